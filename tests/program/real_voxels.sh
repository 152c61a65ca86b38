#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
#
# Voxel files of stand_ins.py, and of folders outside the repository where they exist, there and back: each becomes a
# .svo file with the same tree, and that a .binvox file with the same voxels. Those of .vox files become .vox files
# again, with the same tree.
#
# usage: real_voxels.sh PROGRAM FOLDER...; exit code 77 (skipped) without python3 and the folders.
set -euo pipefail

readonly program=$1
shift
# shellcheck source=tests/support/stand_ins.sh
source "${BASH_SOURCE[0]%/*}/../support/stand_ins.sh"
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
model_folders "$work" voxels "$@"

# Whether two files have the same tree; further arguments are options of svocl hash.
same_tree()
{
    [[ $("$program" hash "$1" "${@:3}") == "$("$program" hash "$2" "${@:3}")" ]]
}

there_and_back()
{
    rm -f "$work"/[ab].*
    "$program" convert "$1" "$work/a.svo" --quiet || return 1
    same_tree "$1" "$work/a.svo" || return 1
    "$program" convert "$work/a.svo" "$work/b.binvox" --quiet || return 1
    same_tree "$1" "$work/b.binvox" --need none || return 1
    [[ $1 == *.vox ]] || return 0
    "$program" convert "$work/a.svo" "$work/b.vox" --quiet || return 1
    same_tree "$1" "$work/b.vox"
}

same=0 failed=0
while IFS= read -r -d '' file; do
    if there_and_back "$file"; then
        same=$((same + 1))
    else
        failed=$((failed + 1))
        echo "FAILED: $file"
    fi
done < <(find "${folders[@]}" -type f \( -name '*.vox' -o -name '*.svx' -o -name '*.binvox' \) -print0 | sort -z)

echo "$same the same, $failed failed"
((failed == 0 && same > 0))
