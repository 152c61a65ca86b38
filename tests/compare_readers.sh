#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
#
# Compares the library's own readers with assimp on every OBJ, PLY, STL and OFF file of a folder outside the repository.
# Gzipped files are unpacked first. Files that differ on purpose are listed below with the reason.
#
# usage: compare_readers.sh PROGRAM FOLDER; exit code 77 (skipped) if the folder does not exist.
set -euo pipefail

readonly program=$1 folder=$2

# NAME VERDICT, one a line; the reason is in the comment above it.
readonly expected=''

if [[ ! -d $folder ]]; then
    echo "skipped: no folder $folder"
    exit 77
fi
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cp -r "$folder/." "$work"
find "$work" -name '*.gz' -exec gunzip {} +

find "$work" -type f \( -iname '*.obj' -o -iname '*.ply' -o -iname '*.stl' -o -iname '*.off' \) -print0 | sort -z |
    xargs -0 "$program" | sed "s|$work/||g" >"$work/lines"
cat "$work/lines"
awk -F '\t' -v expected="$expected" '
    BEGIN {
        count = split(expected, lines, "\n")
        for (i = 1; i <= count; ++i)
            if (lines[i] !~ /^ *(#|$)/) {
                name = lines[i]; sub(/^ */, "", name); sub(/ .*/, "", name)
                verdict = lines[i]; sub(/^ *[^ ]* */, "", verdict)
                wanted[name] = verdict
            }
    }
    {
        name = $2; sub(/.*\//, "", name)
        ++total[$1]
        if (name in wanted ? $1 != wanted[name] : $1 == "different" || $1 == "only assimp") {
            print "FAILED: " $2 ": " $1
            failed = 1
        }
    }
    END {
        for (verdict in total) print total[verdict] " " verdict
        exit failed || total["equal"] == 0
    }' "$work/lines"
