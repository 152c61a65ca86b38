#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
#
# exports.sh SOURCE SHARED USER...: whether lib/exports.txt is what the shared library SHARED exports; whether its
# public part is what the headers of svocl::svocl declare; and whether its internal part is what the libraries USER
# (svocl::gl and svocl::io) need, no more and no less.
set -euo pipefail
export LC_ALL=C
readonly source=$1 shared=$2
shift 2

failed=0
# Compares two lists of symbols, one a line.
expect_same()
{
    local difference
    difference=$(diff <(sort -u <<<"$2") <(sort -u <<<"$3")) && return 0
    difference=$(grep '^[<>]' <<<"$difference")
    printf '%s:\n%s\n' "$1" "$difference"
    failed=1
}

# Undefined (U) or defined (other) symbols of archives and shared libraries.
symbols()
{
    local option=$1 file
    shift
    for file in "$@"; do
        case $file in
        *.a) nm "$option" "$file" 2>/dev/null ;;
        *) nm -D "$option" "$file" ;;
        esac
    done | awk 'NF > 1 {sub(/@.*/, "", $NF); print $NF}' | grep '^svo_' || true
}

listed=$(grep '^svo_' "$source/lib/exports.txt")
expect_same 'lib/exports.txt (<) and what a shared svocl exports (>)' "$listed" "$(symbols --defined-only "$shared")"

headers=()
for header in "$source"/include/svocl/*.h; do
    [[ $header == */gl.h || $header == */io.h ]] || headers+=("$header")
done
# Each declaration begins with SVO_API; its name is the word before the first parenthesis.
declared=$(cat "${headers[@]}" | tr '\n' ' ' | grep -o 'SVO_API [^(;]*(' | grep -oE 'svo_[a-z0-9_]+ *\($' | tr -d ' (')
expect_same 'lib/exports.txt (<) and the public headers (>)' "$(grep -v '^svo_i_' <<<"$listed")" "$declared"

# Only where all users are built is it known what they need.
if (($# == 2)); then
    needed=$(comm -23 <(symbols --undefined-only "$@" | sort -u) <(symbols --defined-only "$@" | sort -u))
    expect_same 'lib/exports.txt (<) and what svocl::gl and svocl::io need (>)' "$(grep '^svo_i_' <<<"$listed")" \
        "$(grep '^svo_i_' <<<"$needed")"
fi
exit "$failed"
