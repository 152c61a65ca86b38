#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
#
# svocl view plays what moves: its frames are those of svocl render --animate, and the same script gives the same
# pictures. What moves has no light by cones and no probes, which is said in words. Edited scenes keep their motions.
#
# usage: view_motion.sh PROGRAM
set -euo pipefail

readonly program=$1
# shellcheck source=tests/support/complain.sh
source "${BASH_SOURCE[0]%/*}/../support/complain.sh"
cd "$work"
export SDL_VIDEODRIVER=offscreen XDG_CONFIG_HOME=$work/config
readonly film=(-d 5 --frames 8)

# view FILE <SCRIPT
view()
{
    cat >script.txt
    "$program" view "$1" "${film[@]}" --width 240 --height 160 --script script.txt
}
# animate FILE PREFIX: its frames.
animate()
{
    "$program" render "$1" --animate "${film[@]}" --size 240x160 -q -o "$2.png"
}
same()
{
    cmp -s "$1.png" "$2.png" || complain "$1 is not $2"
}
differ()
{
    ! cmp -s "$1.png" "$2.png" || complain "$1 and $2 are the same"
}

# Seven intervals in 7/15 s: a frame of the film is four of the script's.
cat >scene.json <<'JSON'
{
  "trees": {"floor": {"path": "scene:cube", "depth": 4}, "knot": {"path": "scene:knot:500", "depth": 4}},
  "instances": [
    {"tree": "floor", "scale": [2, 0.1, 2], "translate": [0, -1, 0]},
    {"tree": "knot", "motion": [
      {"time": 0.1, "translate": [-1, 0, 0], "scale": 0.4},
      {"time": 0.3, "translate": [0, 0.5, 0.3], "rotate": [0, 70, 20], "scale": [0.6, 0.5, 0.4]},
      {"time": 0.5666667, "translate": [1, 0, 0], "rotate": [0, 180, 0], "scale": 0.4}]}
  ]
}
JSON
animate scene.json frame

# By steps, over the ends and back; played, slower and through the end; and once more.
play()
{
    view scene.json <<SCRIPT
key tab
coarse 1
refine
shot $1-0.png
key right
key right
key right
shot $1-3.png
key left
key left
key left
key left
shot $1-7.png
key right
key space
wait 3
shot $1-playing.png
key down
wait 9
shot $1-slower.png
wait 40
key space
shot $1-looped.png
key tab
key F2
key F4
key k
wait 2
shot $1-panel.png
SCRIPT
}
play first
play second
for picture in first-*.png; do
    cmp -s "$picture" "second-${picture#first-}" || complain "$picture differs when it is played again"
done
same first-0 frame_000
same first-3 frame_003
same first-7 frame_007
same first-playing frame_001
same first-slower frame_002
cmp -s first-looped.png first-slower.png && complain "nothing played"
[[ -n $(for k in 0 1 2 3 4 5 6 7; do cmp -s first-looped.png "frame_00$k.png" && echo "$k"; done) ]] ||
    complain "first-looped is no frame"

# Light by cones, probes and levels are refused; instances show, and what moves again.
view scene.json <<'SCRIPT'
key tab
coarse 1
refine
key 0
key 9
key 6
key t
key o
key m
key b
key l
refine
shot refused.png
key F10
key tab
key F2
key F4
wait 2
shot log.png
key F12
click 120 80
wait 2
shot picked.png
key tab
key 2
refine
shot normal.png
key i
refine
shot instances.png
key right
refine
shot again.png
SCRIPT
same refused frame_000
differ log refused
differ log picked
differ normal refused
differ instances refused
same again frame_001

# Saved as it is, the film is the same; an instance that is dragged takes its motion along.
cp scene.json saved.json
printf 'key i\nkey ctrl+s\n' | view saved.json
(($(grep -c '"time"' saved.json) == 3)) || complain "the saved scene has $(grep -c '"time"' saved.json) keys"
animate saved.json saved
for k in 0 4 7; do
    same "saved_00$k" "frame_00$k"
done
cp scene.json dragged.json
view dragged.json <<'SCRIPT'
key tab
coarse 1
key i
refine
drag shift+left 60 80 64 60 4
key n
key delete
key ctrl+s
key right
key right
refine
shot dragged.png
SCRIPT
animate dragged.json dragged
same dragged dragged_002
differ dragged frame_002

# What cannot move: the frame before stays; without a static mesh the instances show.
sed 's/0.1, "t/0, "t/; s/"time": 0.3/"time": 1/; s/0.5666667/7/; s/"scale": 0.4}\]}/"scale": [-0.6, -0.5, -0.4]}]}/' \
    scene.json >flat.json
sed -n '1,3p; 5,$p' scene.json >all.json
printf 'key tab\ncoarse 1\nkey right\nkey right\nkey right\nkey right\nrefine\nshot flat.png\nkey space\nwait 30\n' |
    view flat.json || complain "a flat frame ends the session"
"$program" render flat.json --animate "${film[@]}" --size 240x160 -q -o flat.png >err 2>&1 &&
    complain "the flat frame is not flat"
same flat flat_003
printf 'key tab\ncoarse 1\nkey space\nrefine\nshot all.png\n' | view all.json 2>err ||
    complain "a scene that moves as a whole ends the session"
grep -q "all instances have a 'motion'" err || complain "no words about a scene that moves as a whole: $(cat err)"
exit "$failed"
