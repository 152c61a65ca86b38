#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
#
# svocl view draws on trees: what its strokes make is, byte for byte, what svocl edit makes by the same shapes, and
# looks as svocl render draws it. Undo, redo, questions about what is unsaved, and what goes on without the brush.
#
# usage: view_brush.sh PROGRAM
set -euo pipefail

readonly program=$1
# shellcheck source=tests/support/complain.sh
source "${BASH_SOURCE[0]%/*}/../support/complain.sh"
cd "$work"
export SDL_VIDEODRIVER=offscreen XDG_CONFIG_HOME=$work/config

# The camera looks along -z at the middle of a block, whose face, at z = 24, has four pixels a voxel: the pixel (x, y)
# sees (16.5 + (x - 159.5) / 4, 16.5 - (y - 119.5) / 4).
readonly camera=(--eye '16.5,16.5,68' --at '16.5,16.5,0' --fov 68.5708)
# view INPUT <SCRIPT
view()
{
    cat >script.txt
    "$program" view "$1" "${camera[@]}" --width 320 --height 240 --script script.txt
}
# same_tree FILE <SCRIPT: of svocl edit
same_tree()
{
    cat >edit.txt
    "$program" edit block.svo edit.txt -o expected.svo -q
    cmp -s "$1" expected.svo || complain "$1 is not what svocl edit makes: $("$program" diff "$1" expected.svo 2>&1)"
}
# same_picture PICTURE FILE OPTION...
same_picture()
{
    local picture=$1
    shift
    "$program" render "$@" "${camera[@]}" --size 320x240 -q -o rendered.png
    cmp -s "$picture" rendered.png || complain "$picture is not what svocl render $* draws"
}

"$program" build scene:cube -d 5 -o shell.svo -q
printf 'set box 8 8 8 24 24 24 color 150 150 140\nkeep box 8 8 8 24 24 24\n' >block.txt
"$program" edit shell.svo block.txt -o block.vox -q
"$program" build block.vox -o block.svo -q

# Each tool and shape by a click, a capsule and boxes along drags, whose second places see the block as it was before
# them. A click beside the block draws nothing. Then what was undone is not in the file, and what was redone is.
readonly strokes='key tab
coarse 1
brush set sphere 3 200 30 30 2
click 160 120
brush clear box 1
click 160 120
brush set sphere 2 30 200 60
drag 160 140 180 140 1
brush set box 1 90 90 20 7
drag 140 104 148 104 1
brush paint sphere 2 30 60 200 1
click 160 120
click 20 20
move 4 4
refine'
view block.svo <<SCRIPT
$strokes
shot drawn.png
key ctrl+z
refine
shot undone.png
key ctrl+z
key ctrl+z
key ctrl+y
key ctrl+shift+z
key ctrl+y
refine
shot redone.png
key ctrl+z
key ctrl+s
wait 2
key enter
wait 2
key ctrl+y
refine
shot again.png
key 2
refine
shot normal.png
key 5
refine
shot level.png
key u
refine
shot shaded.png
key ctrl+q
wait 2
shot asked.png
key s
wait 10
shot never.png
SCRIPT
[[ -e asked.png && ! -e never.png ]] || complain "Ctrl+Q with strokes does not ask, or what was saved does not end it"
cmp -s drawn.png redone.png || complain "what was undone and redone is another picture"
cmp -s drawn.png again.png || complain "the picture is another after a file was written"
cmp -s drawn.png shaded.png || complain "the brush shows another picture when it begins again"
cmp -s drawn.png undone.png && complain "Ctrl+Z leaves a stroke"
readonly steps='set sphere 16.5 16.5 24.5 3 color 200 30 30 material 2
clear box 15 15 26 18 18 29
set capsule 16.5 11.5 24.5 21.5 11.5 24.5 2 color 30 200 60
set box 10 19 23 13 22 26 color 90 90 20 material 7
set box 11 19 23 14 22 26 color 90 90 20 material 7
set box 12 19 23 15 22 26 color 90 90 20 material 7
paint sphere 16.5 16.5 25.5 2 color 30 60 200 material 1'
same_tree block-edited.svo <<<"$steps"
same_picture drawn.png block-edited.svo
same_picture normal.png block-edited.svo --view normal
same_picture level.png block-edited.svo --view level

# What was undone is not in the file. Shift and a click take what a voxel has.
rm block-edited.svo
view block.svo <<SCRIPT
$strokes
key ctrl+z
key q
click shift+left 180 140
click 130 150
key ctrl+s
wait 2
key enter
wait 2
SCRIPT
same_tree block-edited.svo <<<"${steps%paint*}set sphere 9.5 8.5 24.5 2 color 30 200 60"

# Instances show what was drawn. Their file needs the voxels', which is asked for first; other names are refused.
rm block-edited.svo
view block.svo <<SCRIPT
$strokes
key i
refine
shot instance.png
key u
key n
key ctrl+s
wait 2
text x
wait 2
key enter
wait 2
key backspace
wait 2
text block-edited.svo
wait 2
key enter
wait 2
key ctrl+s
wait 2
key enter
wait 2
key ctrl+z
key ctrl+z
refine
shot back.png
key ctrl+q
wait 2
key d
SCRIPT
same_tree block-edited.svo <<<"$steps"
cmp -s undone.png back.png || complain "Ctrl+Z does not go from instances back to strokes"
grep -q '"block-edited.svo"' block-scene.json || complain "the scene is not of what was drawn: $(cat block-scene.json)"

# A drag from beside the block turns the camera, and so does one with Shift.
for drag in 'drag 20 20 60 40 3' 'drag shift+left 160 120 200 140 3'; do
    printf '%s\n' 'key tab' 'coarse 1' 'key u' refine 'shot before.png' "$drag" refine 'shot turned.png' \
        'key ctrl+q' 'wait 2' 'shot open.png' | view block.svo
    cmp -s before.png turned.png && complain "$drag does not turn the camera"
    [[ ! -e open.png ]] || complain "$drag draws"
done
exit "$failed"
