#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
#
# svocl stress of a program with a mistake in it: exits with 1, and says which cases failed.
#
# usage: stress_fails.sh PROGRAM only|also CASE...
#   only: these cases fail and no others. also: these fail, whatever else does.
set -euo pipefail

readonly program=$1 others=$2
shift 2
status=0
# By expansion, whatever the hardware offers: the margin is part of that way.
report=$("$program" stress --count 1 --frontend gl-expand) || status=$?
failed=$(sed -n 's/^ *\(T.*[^ ]\) *svocl .* FAILED$/\1/p' <<<"$report" | sort)
expected=$(printf '%s\n' "$@" | sort)
missing=$(comm -13 <(echo "$failed") <(echo "$expected"))
surplus=$(comm -23 <(echo "$failed") <(echo "$expected"))

printf 'exit code %d, failed:\n%s\n' "$status" "$failed"
[[ -z $missing ]] || printf 'did not fail:\n%s\n' "$missing"
[[ $others == also || -z $surplus ]] || printf 'should not have failed:\n%s\n' "$surplus"
[[ $status == 1 && -z $missing && ($others == also || -z $surplus) ]]
