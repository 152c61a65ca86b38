#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
#
# Real and broken mesh files, as stand_ins.py writes them, and from a folder outside the repository where it exists:
# `svocl verify` must find each tree exact, or refuse the file with one line and exit code 1. Gzipped files are unpacked
# first. The well-formed stand-ins must not be refused.
#
# usage: real_meshes.sh PROGRAM FOLDER; exit code 77 (skipped) without python3 and the folder.
set -euo pipefail

readonly program=$1 folder=$2
readonly depth=8
readonly seconds=120
# shellcheck source=tests/support/stand_ins.sh
source "${BASH_SOURCE[0]%/*}/../support/stand_ins.sh"

work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
model_folders "$work" . "$folder"
if [[ -d $folder ]]; then
    mkdir "$work/given"
    cp -r "$folder/." "$work/given"
fi
find "$work" -name '*.gz' -exec gunzip {} +

exact=0 refused=0 failed=0
while IFS= read -r -d '' file; do
    name=${file#"$work"/}
    code=0
    timeout "$seconds" "$program" verify "$file" -d "$depth" >"$work/out" 2>"$work/err" || code=$?
    if ((code == 0)) && grep -q 'exact: 0 missed, 0 surplus' "$work/out"; then
        exact=$((exact + 1))
        sed -n 's/^ *\([0-9,]* of [0-9,]* triangles refused.*\)/refused in '"${name//\//\\/}"': \1/p' "$work/out"
    elif ((code == 1)) && [[ $name != stand-ins/meshes/* ]] && [[ $(wc -l <"$work/err") == 1 ]] &&
        grep -q "${name##*/}: " "$work/err"; then
        refused=$((refused + 1))
        sed 's/^/refused: /' "$work/err" | sed "s|$work/||g"
    else
        failed=$((failed + 1))
        echo "FAILED with exit code $code: $name"
        cat "$work/out" "$work/err"
    fi
done < <(find "$work" -type f \( -name '*.obj' -o -name '*.ply' -o -name '*.stl' -o -name '*.STL' -o -name '*.off' \
    -o -name '*.glb' -o -name '*.gltf' \) -print0 | sort -z)

echo "$exact exact, $refused refused, $failed failed"
((failed == 0 && exact > 0))
