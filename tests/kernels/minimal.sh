#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
#
# minimal.sh PROGRAM: whether a program that only builds trees, linked with the static library, contains what it asks
# for alone: no kernel that it cannot launch, nothing of rooms beside the build, and at most 0.9 MB.
set -euo pipefail
export LC_ALL=C
readonly program=$1 bytes_max=900000
# Of rooms beside the build; svo_i_moving_tiles_make is of plans that are updated.
readonly rooms='compact|light|probes|rays|scene|solid'
readonly others="^svo_(i_)?($rooms)_|^svo_(i_text_|i_program_)?(bvh|moving|$rooms)(_|\$)"

failed=0
fail()
{
    printf '%s: %s\n' "$program" "$1"
    failed=1
}

symbols=$(nm "$program" | awk '{print $NF}' | grep '^svo_')
grep -q '^svo_i_text_stages_' <<<"$symbols" || fail 'has no kernel of a build'
found=$(grep -E "$others" <<<"$symbols" || true)
[[ -z $found ]] || fail "contains $found"

# Kernels that the program has the text of, and those that it can ask the driver for, whose name ends a string.
defined=$(strings -n 7 "$program" | grep -oE 'svo_k_[a-z0-9_]+\(' | tr -d '(' | sort -u || true)
named=$(strings -n 7 "$program" | grep -oE 'svo_k_[a-z0-9_]+$' | sort -u || true)
[[ -n $defined ]] || fail 'has no text of a kernel'
unused=$(comm -23 <(printf '%s\n' "$defined") <(printf '%s\n' "$named"))
[[ -z $unused ]] || fail "contains kernels that it cannot launch: $unused"

stripped=$(mktemp)
trap 'rm -f "$stripped"' EXIT
strip -o "$stripped" "$program"
bytes=$(stat -c %s "$stripped")
((bytes <= bytes_max)) || fail "has $bytes bytes, above $bytes_max"
printf '%s: %s bytes, %s kernels\n' "$program" "$bytes" "$(wc -l <<<"$defined")"
exit $failed
