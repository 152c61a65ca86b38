#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
#
# svocl view by scripts: a tour of everything that is the same, byte for byte, when it is taken again; pictures that
# are those of svocl render; what is missing, in one line.
#
# usage: view.sh PROGRAM SCRIPT
set -euo pipefail

readonly program=$1 tour=$2
# shellcheck source=tests/support/complain.sh
source "${BASH_SOURCE[0]%/*}/../support/complain.sh"
cd "$work"
export SDL_VIDEODRIVER=offscreen XDG_CONFIG_HOME=$work/config
readonly scene=(scene:atrium -d 6) probes=(--probes '3,3,3' --probe-resolution 64)

# Pictures of the tour that svocl render makes too, each with its options.
mapfile -t rendered <<LINES
view-1-shaded
view-2-normal --view normal
view-5-level --view level
view-6-triangles --view triangles
view-8-direct --view direct
view-0-full --view full --cones 5
toggle-no-gi --view full --cones 5 --gi off
toggle-no-photons --view full --cones 5 --photons off
probes-shaded --through probes ${probes[*]} --cones 5
probes-normal --through probes ${probes[*]} --view normal
probes-depth --through probes ${probes[*]} --view depth
probes-steps --through probes ${probes[*]} --view steps
LINES

# take_tour FOLDER SCRIPT
take_tour()
{
    mkdir "$1"
    (cd "$1" && "$program" view "${scene[@]}" "${probes[@]}" --cones 5 --width 640 --height 400 --script "$2")
}

# Taken again without those: render is another program that makes the same of them.
printf '%s\n' "${rendered[@]}" | awk '
    NR == FNR { is_rendered["shot " $1 ".png"]; next }
    $0 in is_rendered { held = 0; next }
    held { print "refine" }
    { held = $0 == "refine" }
    !held { print }' - "$tour" >again.txt
take_tour first "$tour"
take_tour second "$work/again.txt"
pictures=(first/*)
((${#pictures[@]} == $(grep -c '^shot' "$tour"))) || complain "${#pictures[@]} pictures, not the script's"
again=(second/*)
((${#again[@]} == ${#pictures[@]} - ${#rendered[@]})) || complain "${#again[@]} pictures were taken again"
for picture in "${again[@]}"; do
    cmp -s "$picture" "first/${picture#second/}" || complain "$picture differs from the first tour's"
done
[[ ! -e config ]] || complain "a script wrote settings"

# Pictures are those of svocl render.
size=640x400
same()
{
    local picture=$1
    shift
    "$program" render "${scene[@]}" --size "$size" "$@" -q -o rendered.png
    cmp -s "first/$picture.png" rendered.png || complain "$picture is not what svocl render $* writes"
}
for line in "${rendered[@]}"; do
    # shellcheck disable=SC2086 # words
    same $line
done

# So are those by rays, which take long: a tenth of the pixels.
size=160x160
printf 'key tab\nrefine\nshot first/rays.png\n' >rays.txt
"$program" view "${scene[@]}" --view full --width 160 --height 160 --script rays.txt
same rays --view full

# A stored tree has the textures, normals and finishes of its mesh.
"$program" scene atrium -q -o atrium.obj
"$program" build atrium.obj -d 6 --need color,normal,rays,material -q -o atrium.svo
printf 'key tab\nrefine\nshot stored.png\n' >stored.txt
"$program" view atrium.svo --mesh atrium.obj --view full --width 160 --height 160 --script stored.txt
"$program" render atrium.obj -d 6 --view full --size 160x160 -q -o built.png
cmp -s stored.png built.png || complain "a stored tree with its mesh is not shown as the mesh is"

# What changes a picture shows; what goes back does.
differ()
{
    ! cmp -s "first/$1.png" "first/$2.png" || complain "$1 and $2 are the same"
}
differ view-0-full toggle-no-gi
differ view-0-full toggle-no-photons
differ view-0-full toggle-exposure
differ view-9-gi toggle-bricks
differ view-9-gi toggle-voxels
differ view-8-direct light-moved
differ view-1-shaded level-up
differ level-up level-down
differ camera-coarse camera-orbit
differ camera-orbit camera-near
differ camera-near camera-fly
differ pick pick-none
differ brush-set brush-cleared
differ brush-cleared brush-painted
differ brush-painted brush-undone
differ view-1-shaded clip-shaded
differ view-3-depth clip-depth
differ view-0-full clip-full
differ view-1-shaded grid-behind
differ grid-behind grid-z
cmp -s first/grid-gone.png first/view-1-shaded.png || complain "without clip plane and grid the picture is another"
differ view-1-shaded probes-spheres
differ probes-spheres probes-chosen
differ probes-map-radiance probes-map-normal
differ probes-map-normal probes-map-distance
differ probes-planned probes-made
cmp -s first/camera-home.png first/view-2-normal.png || complain "the first view does not come back"
mapfile -t panels < <(ls first/panel-*)
(($(md5sum "${panels[@]}" | cut -d' ' -f1 | sort -u | wc -l) == ${#panels[@]})) || complain "panels that look alike"

# A finished tree has one level.
"$program" build scene:knot:2000 -d 5 --need color,normal -o knot.svo -q
printf 'key tab\nrefine\nshot finest.png\nkey l\nrefine\nshot lower.png\n' >levels.txt
"$program" view knot.svo --width 320 --height 240 --script levels.txt || complain "a finished tree ends with key L"
cmp -s finest.png lower.png || complain "key L changes a finished tree"

# What is loaded says how far it is. Escape ends a program that has nothing else to show; later loads change nothing.
small=(--width 320 --height 240)
printf 'loading shot load-1.png\nloading shot load-2.png\nloading key escape\nrefine\nshot never.png\n' >cancel.txt
"$program" view scene:knot:2000 -d 5 "${small[@]}" --script cancel.txt 2>err || complain "Escape ends with code $?"
[[ -e load-2.png && ! -e never.png && ! -s err ]] || complain "Escape does not end a load: $(cat err)"
cmp -s load-1.png load-2.png && complain "two steps of a load look alike"
printf 'taken' >knot-001.png
cat >open.txt <<'SCRIPT'
key tab
refine
shot one.png
drop knot.svo
loading key escape
refine
shot canceled.png
key l
loading wait 1
loading key escape
refine
shot level.png
drop nothing.obj
wait 2
shot notice.png
key escape
key c
drop knot.svo
refine
shot two.png
key ctrl+p
wait 2
key ctrl+o
wait 2
text scene:cu
wait 1
text be:12
wait 1
key enter
refine
shot three.png
SCRIPT
"$program" view scene:atrium -d 4 "${small[@]}" --script open.txt 2>err || complain "opening files ends the session"
[[ $(cat err) == *"nothing.obj: cannot be read: No such file or directory" && $(wc -l <err) == 1 ]] ||
    complain "not one line about a file that is missing: $(cat err)"
cmp -s one.png canceled.png || complain "a load that was canceled changes the picture"
cmp -s one.png level.png || complain "a level that was canceled changes the picture"
cmp -s one.png notice.png && complain "no box about a file that is missing"
cmp -s two.png finest.png || complain "a file that was dropped does not look as on the command line"
[[ $(cat knot-001.png) == taken ]] || complain "a picture has overwritten a file"
cmp -s knot-002.png two.png || complain "Ctrl+P does not save the picture"
printf 'key tab\nrefine\nshot cube.png\n' >cube.txt
"$program" view scene:cube:12 -d 4 "${small[@]}" --script cube.txt || complain "a cube is not shown"
cmp -s three.png cube.png || complain "the box that asks for a file does not open it"
printf 'loading wait 1\nrefine\nloading wait 1\n' >late.txt
expect_failure 1 'late.txt:3: nothing is being loaded' "$program" view scene:cube -d 2 --script late.txt

# Panels of twice the size, and the same picture behind them.
printf 'refine\nshot panels.png\nkey tab\nwait 1\nshot plain.png\n' >scale.txt
for scale in 1 2; do
    "$program" view scene:cube -d 2 "${small[@]}" --script scale.txt --scale "$scale" || complain "--scale $scale fails"
    mv panels.png "panels-$scale.png"
    mv plain.png "plain-$scale.png"
done
cmp -s plain-1.png plain-2.png || complain "--scale changes the picture"
cmp -s panels-1.png panels-2.png && complain "--scale changes no panel"

# What is missing, and mistakes in scripts.
printf 'shot a.png\n' >short.txt
view=("$program" view scene:cube -d 2 --script short.txt)
expect_failure 1 'no display' env -u SDL_VIDEODRIVER -u DISPLAY -u WAYLAND_DISPLAY "${view[@]}"
expect_failure 1 'OpenGL 4.3' env MESA_GL_VERSION_OVERRIDE=4.2 "${view[@]}"
expect_failure 1 'OpenCL' env OCL_ICD_VENDORS=/nonexistent "${view[@]}"
expect_failure 1 'nothing.txt' "$program" view scene:cube -d 2 --script nothing.txt
expect_failure 2 'frames' "${view[@]}" --frames 8
expect_failure 2 'tree-form takes a scene' "${view[@]}" --tree-form shared
expect_failure 2 "scale '9' is not a number within 1 .. 4" "${view[@]}" --scale 9
echo '{"trees": {"a": {"path": "scene:cube", "depth": 2}}, "instances": [{"tree": "a"}]}' >still.json
expect_failure 2 'lights and cones' "$program" view still.json --script short.txt --view full
expect_failure 2 'lights and cones' "$program" view still.json --script short.txt --cones 5
expect_failure 2 'still.json: nothing moves' "$program" view still.json --script short.txt --frames 8
[[ ! -e a.png ]] || complain "a picture in spite of failures"
while IFS='|' read -r line words; do
    printf '\n%s\n' "$line" >wrong.txt
    expect_failure 1 "wrong.txt:2: .*$words" "$program" view scene:cube -d 2 --script wrong.txt
done <<'LINES'
jump 1 2|'jump' is not a command
key|lacks a key
key hyper|'hyper' is not a key
move 10|lacks a number
move 10 -4|'-4' is not a number within
wait 1.5|not a whole number
coarse 3|none of 0, 1, 2, 4, 8
shot|takes one file name
shot a b|takes one file name
drop|takes one file name
brush set sphere|lacks a tool, a shape or a radius
brush smooth sphere 3|'smooth' is not a tool
brush set cone 3|'cone' is not a shape
brush set box 65|'65' is not a number within 0 .. 64
brush set box 3 1 2|lacks a number
brush set box 3 1 2 256|'256' is not a number within 0 .. 255
loading hop|'hop' is not a command
a b c d e f g h i|more than 8 words
LINES
exit "$failed"
