#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
#
# svocl view edits scenes: instances that are added, moved, removed, saved and loaded again; what it shows is what svocl
# render draws of the file that it saved. A tree becomes a scene. A file that cannot be read changes nothing.
#
# usage: view_scene.sh PROGRAM
set -euo pipefail

readonly program=$1
# shellcheck source=tests/complain.sh
source "${BASH_SOURCE[0]%/*}/complain.sh"
cd "$work"
export SDL_VIDEODRIVER=offscreen XDG_CONFIG_HOME=$work/config

# view INPUT... <SCRIPT
view()
{
    cat >script.txt
    "$program" view "$@" --width 640 --height 400 --script script.txt
}
same()
{
    "$program" render "$1" --size 640x400 -q -o rendered.png
    cmp -s "$2" rendered.png || complain "$2 is not what svocl render draws of $1"
}
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
key ctrl+o
refine
shot loaded.png
SCRIPT
same before.json before.png
same scene.json edited.png
same scene.json loaded.png
(($(count_instances scene.json) == 4)) || complain "$(count_instances scene.json) instances in the saved scene"
cmp -s before.png edited.png && complain "another instance shows nothing"
cmp -s removed.png edited.png && complain "a removed instance still shows"

# A tree becomes a scene, which is saved by the panel.
view scene:knot:2000 -d 6 <<'SCRIPT'
key i
key F2
key F4
key F8
wait 2
click 580 253
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

# A scene that cannot be loaded changes nothing.
printf '{"trees": 1}\n' >broken.json
view scene:knot:2000 -d 6 2>err <<'SCRIPT'
key i
key F2
key F4
key F8
wait 2
click 580 253
text broken.json
click 320 390
key tab
key ctrl+o
refine
shot kept.png
SCRIPT
cmp -s kept.png made.png || complain "a broken scene changes the picture"
if (($(wc -l <err) != 1)) || ! grep -q "broken.json:1: 'trees' is missing" err; then
    complain "not one line about the broken scene: $(cat err)"
fi
exit "$failed"
