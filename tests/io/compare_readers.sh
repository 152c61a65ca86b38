#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
#
# Compares the library's own readers with assimp on every OBJ, PLY, STL and OFF file of stand_ins.py, and of a folder
# outside the repository where it exists. Gzipped files are unpacked first. Files that differ on purpose are listed
# below with the reason.
#
# usage: compare_readers.sh PROGRAM FOLDER; exit code 77 (skipped) without python3 and the folder.
set -euo pipefail

readonly program=$1 folder=$2
# shellcheck source=tests/support/stand_ins.sh
source "${BASH_SOURCE[0]%/*}/../support/stand_ins.sh"

# NAME VERDICT, one a line; the reason is in the comment above it.
readonly expected='
# assimp takes the strips for one polygon
scan_in_strips.ply different
# assimp leaves out the last face
cut_faces.ply only assimp
# assimp clips ears of a polygon that meets itself
long_line.obj different
'

work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
model_folders "$work" . "$folder"
if [[ -d $folder ]]; then
    mkdir "$work/given"
    cp -r "$folder/." "$work/given"
fi
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
