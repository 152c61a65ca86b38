#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
#
# svocl view edits scenes: instances that are added, moved, removed, saved and loaded again; what it shows is what svocl
# render draws of the file that it saved. A tree becomes a scene. A file that cannot be read changes nothing.
#
# usage: view_scene.sh PROGRAM
set -euo pipefail

readonly program=$1
# shellcheck source=tests/support/complain.sh
source "${BASH_SOURCE[0]%/*}/../support/complain.sh"
cd "$work"
export SDL_VIDEODRIVER=offscreen XDG_CONFIG_HOME=$work/config

# view INPUT... <SCRIPT
view()
{
    cat >script.txt
    "$program" view "$@" --width 640 --height 400 --script script.txt
}
# same FILE PICTURE OPTION...
same()
{
    local file=$1 picture=$2
    shift 2
    "$program" render "$file" --size 640x400 "$@" -q -o rendered.png
    cmp -s "$picture" rendered.png || complain "$picture is not what svocl render $* draws of $file"
}
# Keys until the panel Instances is alone: of a tree that has become a scene.
readonly edit_keys='key i
key F2
key F4
key F8
wait 2'
count_instances()
{
    grep -c '{"tree": ' "$1"
}

cat >scene.json <<'JSON'
{
  "trees": {"knot": {"path": "scene:knot:2000", "depth": 6}, "cube": {"path": "scene:cube", "depth": 4}},
  "instances": [
    {"tree": "knot", "rotate": [0, 30, 0], "scale": 1.5},
    {"tree": "cube", "translate": [3, 0, 0], "scale": 0.7},
    {"tree": "knot", "matrix": [1, 0.2, 0, -3, 0, 1, 0, 0, 0, 0, 1, 0]}
  ],
  "lights": [{"direction": [0.5, 0.7, 0.4], "color": [1, 0.95, 0.85]}],
  "camera": {"eye": [4, 4, 10], "target": [0, 0, 0]}
}
JSON

# As it is; one more, dragged, saved; removed again; and the saved one back.
cp scene.json before.json
view scene.json <<'SCRIPT'
key tab
refine
shot before.png
click 320 230
key n
drag shift+left 320 230 380 160 6
refine
shot edited.png
key ctrl+s
key delete
refine
shot removed.png
key ctrl+z
refine
shot undone.png
key ctrl+y
refine
shot redone.png
key ctrl+r
wait 2
key d
refine
shot loaded.png
SCRIPT
same before.json before.png
same scene.json edited.png
same scene.json loaded.png
same scene.json undone.png
cmp -s removed.png redone.png || complain "what was undone and redone is another picture"
(($(count_instances scene.json) == 4)) || complain "$(count_instances scene.json) instances in the saved scene"
cmp -s before.png edited.png && complain "another instance shows nothing"
cmp -s removed.png edited.png && complain "a removed instance still shows"

# In a form the picture is the same, and the saved scene names it.
cp before.json form.json
view form.json --tree-form shared <<'SCRIPT'
key tab
refine
shot form.png
key ctrl+s
wait 2
SCRIPT
cmp -s before.png form.png || complain "the scene in a form is another picture"
grep -q '"form": "shared"' form.json || complain "the saved scene does not name its form: $(cat form.json)"

# Through probes: as it is, and after an instance was moved; without light.
readonly probes=(--probes '3,3,3' --probe-resolution 64)
cp before.json probes.json
view probes.json "${probes[@]}" <<'SCRIPT'
key tab
key t
refine
shot probes.png
key 3
refine
shot probes-depth.png
key t
click 320 230
drag shift+left 320 230 380 160 6
key o
refine
shot probes-moved-places.png
key o
key t
refine
shot probes-moved.png
key ctrl+s
key tab
key F2
key F4
key F12
key m
wait 2
shot probes-panel.png
SCRIPT
same before.json probes.png --through probes "${probes[@]}" --view normal
same before.json probes-depth.png --through probes "${probes[@]}" --view depth
same probes.json probes-moved.png --through probes "${probes[@]}" --view normal
cmp -s probes.png probes-moved.png && complain "an instance that was moved shows nothing through probes"

# A grid beyond the budget is refused in words, and the session goes on.
printf 'key F9\nkey t\nkey F10\nwait 2\nshot refused.png\n' >refused.txt
"$program" view scene:cube -d 3 --probes 8,8,8 --probe-resolution 1024 --width 320 --height 240 --script refused.txt ||
    complain "a grid beyond the budget ends the session"
[[ -e refused.png ]] || complain "no picture after a grid was refused"

# A tree becomes a scene, which is saved by the panel.
view scene:knot:2000 -d 6 <<SCRIPT
$edit_keys
click 580 274
text made.json
key enter
wait 2
shot panel.png
key tab
refine
shot made.png
SCRIPT
[[ -e made.json ]] || complain "Enter in the field of the file saves nothing"
same made.json made.png

# Ctrl+S asks for a name beside INPUT, and before it replaces a file of somebody else; Ctrl+Q asks before edits are
# lost.
printf 'mine\n' >knot-scene.json
view scene:knot:2000 -d 6 <<SCRIPT
key i
key n
key ctrl+q
wait 2
shot asked.png
key escape
key ctrl+s
wait 3
key enter
wait 3
key escape
SCRIPT
[[ -e asked.png ]] || complain "Ctrl+Q loses what no file has"
[[ $(<knot-scene.json) == mine ]] || complain "a file was replaced unasked"
rm knot-scene.json
view scene:knot:2000 -d 6 <<SCRIPT
key i
key n
key ctrl+q
wait 2
key s
wait 3
key enter
wait 20
shot never.png
SCRIPT
(($(count_instances knot-scene.json) == 2)) || complain "the scene was not saved under the name that was asked for"
[[ ! -e never.png ]] || complain "the window stays open after its edits were saved"

# The lights of a tree alone go where --lights reads them.
view scene:atrium -d 5 <<SCRIPT
key tab
drag ctrl+left 320 200 400 230 4
key 8
refine
shot lit.png
key ctrl+s
wait 3
key enter
wait 3
SCRIPT
"$program" render scene:atrium -d 5 --view direct --lights atrium-lights.json --size 640x400 -q -o relit.png
cmp -s lit.png relit.png || complain "saved lights give another picture"

# Skies by direction show as svocl render draws them, before and after lights are saved.
mkdir skies
printf '#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 1 +X 2\n\200\100\040\200\040\100\200\201' >two.hdr
echo '{"sky": {"file": "../two.hdr", "scale": 0.75, "turn": 30}}' >skies/picture.json
echo '{"sky": {"zenith": [0.1, 0.3, 1], "horizon": [1, 0.8, 0.6], "ground": [0.2, 0.1, 0]}}' >skies/gradient.json
for sky in skies/picture skies/gradient; do
    cp "$sky.json" "$sky-before.json"
    view scene:knot:2000 -d 4 --cones 5 --lights "$sky.json" <<SCRIPT
key 0
refine
key tab
refine
shot $sky.png
key ctrl+s
wait 2
SCRIPT
    cmp -s "$sky.json" "$sky-before.json" && complain "$sky.json was not saved"
    same scene:knot:2000 "$sky.png" -d 4 --cones 5 --view full --lights "$sky-before.json"
    same scene:knot:2000 "$sky.png" -d 4 --cones 5 --view full --lights "$sky.json"
done

# A scene that cannot be loaded changes nothing.
printf '{"trees": 1}\n' >broken.json
view scene:knot:2000 -d 6 2>err <<SCRIPT
$edit_keys
click 580 274
text broken.json
click 320 390
key tab
key ctrl+r
wait 2
shot notice.png
key escape
refine
shot kept.png
SCRIPT
cmp -s kept.png made.png || complain "a broken scene changes the picture"
cmp -s notice.png made.png && complain "no box says that a scene is broken"
if (($(wc -l <err) != 1)) || ! grep -q "broken.json:1: 'trees' is missing" err; then
    complain "not one line about the broken scene: $(cat err)"
fi
exit "$failed"
