#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
#
# OctoMap's own program reads .bt files of svocl's and writes the same nodes again; svocl reads what it writes.
#
# usage: octomap.sh PROGRAM CONVERT_OCTREE
set -euo pipefail

readonly program=$1 convert_octree=$2
# shellcheck source=tests/support/complain.sh
source "${BASH_SOURCE[0]%/*}/../support/complain.sh"

nodes_of()
{
    sed '1,/^data$/d' "$1"
}

cd "$work"
cat >cloud.ply <<'END'
ply
format ascii 1.0
element vertex 5
property double x
property double y
property double z
end_header
0.3 -7.25 100
0.3 -7.25 100.5
-40 8 2.5
-40 8 2.75
12 12 12
END
"$program" convert cloud.ply cloud.bt --voxel-size 0.25 --axes z-up -q
"$program" convert scene:cube solid.bt --voxel-size 0.125 --solid winding -q
for name in cloud solid; do
    # The program says that it fails in words alone.
    "$convert_octree" "$name.bt" "$name.ot" >"$name.log" 2>&1
    "$convert_octree" "$name.ot" "$name.again.bt" >>"$name.log" 2>&1
    ! grep -i error "$name.log" || complain "$name.bt: see above"
    cmp <(nodes_of "$name.bt") <(nodes_of "$name.again.bt") || complain "$name.bt: OctoMap writes other nodes"
    for file in "$name" "$name.again"; do
        "$program" convert "$file.bt" "$file.svo" --need none -q
        "$program" hash "$file.svo" >"$file.hash"
    done
    cmp "$name.hash" "$name.again.hash" || complain "$name.again.bt: other voxels"
done
grep -q 'Done (' cloud.log || complain 'convert_octree read nothing'
exit "$failed"
