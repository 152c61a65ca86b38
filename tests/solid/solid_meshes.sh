#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
#
# Broken, open and torn mesh files, as stand_ins.py writes them, and from a folder outside the repository where it
# exists: `svocl verify --solid` must find each inside as the reference does, or refuse the file with one line and exit
# code 1.
#
# usage: solid_meshes.sh PROGRAM FOLDER; exit code 77 (skipped) without python3 and the folder.
set -euo pipefail

readonly program=$1
readonly depth=6
readonly seconds=120
# shellcheck source=tests/support/stand_ins.sh
source "${BASH_SOURCE[0]%/*}/../support/stand_ins.sh"

work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
model_folders "$work" . "$2"

exact=0 open=0 refused=0 failed=0
while IFS= read -r -d '' file; do
    code=0
    timeout "$seconds" "$program" verify "$file" -d "$depth" --solid winding --frontend cl \
        >"$work/out" 2>"$work/err" || code=$?
    if ((code == 0)) && grep -q '^ *0 voxels are not as the reference says' "$work/out"; then
        exact=$((exact + 1))
        if grep -q 'the surface is not closed' "$work/out"; then
            open=$((open + 1))
        fi
    elif ((code == 1)) && [[ $(wc -l <"$work/err") == 1 ]] && ! grep -qE 'not exact|ran out of memory' "$work/err"; then
        refused=$((refused + 1))
    else
        failed=$((failed + 1))
        echo "FAILED with exit code $code: $file"
        cat "$work/out" "$work/err"
    fi
done < <(find "${folders[@]}" -type f \( -name '*.obj' -o -name '*.ply' -o -name '*.stl' -o -name '*.STL' \
    -o -name '*.off' \) -print0 | sort -z)

echo "$exact exact, $open of them open, $refused refused, $failed failed"
((failed == 0 && exact > 0))
