#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
#
# Runs svocl-lab stress with a planted mistake: it must exit with 1 and report the failed cases.
#
# usage: stress_fails.sh PROGRAM only|also CASE...
#   only: exactly these cases fail. also: at least these cases fail.
set -euo pipefail

readonly program=$1 others=$2
shift 2
status=0
# Uses gl-expand even if the hardware offers conservative rasterization: only expansion has the margin.
report=$("$program" stress --count 1 --frontend gl-expand) || status=$?
failed=$(sed -n 's/^ *\(T.*[^ ]\) *svocl .* FAILED$/\1/p' <<<"$report" | sort)
expected=$(printf '%s\n' "$@" | sort)
missing=$(comm -13 <(echo "$failed") <(echo "$expected"))
surplus=$(comm -23 <(echo "$failed") <(echo "$expected"))

printf 'exit code %d, failed:\n%s\n' "$status" "$failed"
[[ -z $missing ]] || printf 'did not fail:\n%s\n' "$missing"
[[ $others == also || -z $surplus ]] || printf 'should not have failed:\n%s\n' "$surplus"
[[ $status == 1 && -z $missing && ($others == also || -z $surplus) ]]
