#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
#
# The files that svocl export-web writes: their length and its limit, their data, their names, and what is refused.
#
# usage: web.sh PROGRAM
set -euo pipefail

readonly program=$1
# shellcheck source=tests/support/complain.sh
source "${BASH_SOURCE[0]%/*}/../support/complain.sh"
cd "$work"

# A number of the JSON report.
number()
{
    sed -n "s/.*\"$1\":[[:space:]]*\([0-9]*\).*/\1/p" report.json
}
# The data of a page: its blocks one after the other, each of which is padded.
read_data()
{
    local block
    sed -n 's|^.*<script type="application/octet-stream">\([^<]*\)</script><script>take()</script>$|\1|p' "$1" |
        while read -r block; do base64 -d <<<"$block"; done
}
# Writes a page and checks its length and its data against the report.
export_page()
{
    local page=$1 data
    shift
    "$program" export-web "$@" -o "$page" --json >report.json
    (($(stat -c %s "$page") == $(number bytes))) || complain "$page: $(stat -c %s "$page") bytes, not $(number bytes)"
    (($(number bytes) <= $(number max_bytes))) || complain "$page: $(number bytes) bytes, above the limit"
    data=$(read_data "$page" | gunzip | wc -c)
    ((data == $(number unpacked_bytes))) || complain "$page: $data bytes of data, not $(number unpacked_bytes)"
}

mkdir folder
"$program" build scene:statue -d 8 -q -o 'folder/a<b.svo'
cp 'folder/a<b.svo' tree.svo

# A page depends on its input alone, and names it without its folder.
export_page page.html 'folder/a<b.svo'
"$program" export-web 'folder/a<b.svo' -q -o - >again.html
cmp page.html again.html || complain "another page on standard output"
grep -q 'folder' page.html && complain "the page says where its input was"
grep -q '"name":"a\\u003cb.svo"' page.html || complain "the page does not have the name of its input"
"$program" export-web - -q -o piped.html <tree.svo
diff <(sed 's/"name":"[^"]*"//' page.html) <(sed 's/"name":"[^"]*"//' piped.html) >/dev/null ||
    complain "another page from standard input"
"$program" export-web scene:statue -d 8 -q -o scene.html
diff <(sed 's/"name":"[^"]*"//' page.html) <(sed 's/"name":"[^"]*"//' scene.html) >/dev/null ||
    complain "another page of the same scene"

# The limit: a page of just that length is written whole, and with one byte less it lacks a level.
export_page whole.html tree.svo
bytes=$(number bytes)
for level in 8 7 6 5 4 3 2 1; do
    export_page limited.html tree.svo --max-bytes "$bytes"
    (($(number level) == level && $(number depth) == 8)) || complain "level $(number level) in $bytes bytes, not $level"
    bytes=$(($(number bytes) - 1))
done
expect_failure 1 'too small for a page of the first level' \
    "$program" export-web tree.svo --max-bytes "$bytes" -o no.html
[[ ! -e no.html ]] || complain "a page was left after a failure"

# Files of compact trees: a solid in the descriptor form.
"$program" build scene:cube -d 5 --solid winding -q -o solid.svc
export_page solid.html solid.svc
(($(number leaves) < 32 * 32 * 32)) || complain "the inside of the cube is not merged"

# Payload: colors and normals, normals alone, none.
for need in color,normal normal none; do
    export_page knot.html scene:knot -d 6 --need "$need"
    for part in color normal; do
        wanted=$([[ $need == *"$part"* ]] && echo true || echo false)
        grep -q "\"${part}s\":[[:space:]]*$wanted" report.json || complain "--need $need: ${part}s are not $wanted"
    done
done

# Blocks end with levels: more than one in a page of some size, and the first alone unpacks.
export_page blocks.html tree.svo
(($(grep -c '<script>take()</script>$' blocks.html) >= 3)) || complain "a tree of depth 8 is not in blocks"
sed -n 's|^<script type="application/octet-stream">\([^<]*\)</script>.*|\1|p' blocks.html | sed -n 1p | base64 -d |
    { gunzip 2>/dev/null || true; } | wc -c >first
(($(<first) > 1000)) || complain "the first block does not unpack alone"

# Light: baked where lights are given or shown, for files of compact trees as well; more bytes than without.
printf '%s' '{"lights": [{"kind": "point", "position": [0.5, 0.8, 0.5], "value": [1, 1, 1]}], "sky": [0.1, 0.2, 0.3],
    "camera": {"eye": [0.5, 0.5, 0.9], "at": [0.5, 0.5, 0], "fov": 70}}' >lamp.json
export_page room.html scene:cornell -d 6
grep -q '"light":[[:space:]]*false' report.json || complain "light without --lights"
unlit=$(number unpacked_bytes)
export_page lit.html scene:cornell -d 6 --lights lamp.json
grep -q '"light":[[:space:]]*true' report.json || complain "no light with --lights"
(($(number unpacked_bytes) > unlit)) || complain "light takes no bytes"
grep -q '"sources":\[{"kind":1,' lit.html || complain "the page does not have the lamp"
grep -q '"view":6,' lit.html || complain "a page with lights does not begin with them"
grep -q '"eye":\[0.5,0.5,0.8' lit.html || complain "the page does not begin where the file's camera is"
export_page shaded.html scene:cornell -d 6 --lights lamp.json --view shaded --eye 0.5,0.5,2
grep -q '"view":0,' shaded.html || complain "--view shaded is not the first view"
grep -q '"eye":\[0.5,0.5,2\]' shaded.html || complain "--eye does not move the camera"
export_page solid-lit.html solid.svc --view full
grep -q '"light":[[:space:]]*true' report.json || complain "no light with --view full"
export_page ao.html tree.svo --view ao --up 0,0,1 --fov 50
grep -q '"view":5,' ao.html || complain "--view ao is not the first view"
grep -q '"up":\[0,0,1\]' ao.html || complain "--up is not what is up"

# Skies by direction: texels that are bounded, of a small page to fewer.
echo '{"sky": {"zenith": [0.1, 0.3, 1], "horizon": [1, 0.8, 0.6], "ground": [0.2, 0.1, 0]}}' >gradient.json
export_page sky.html scene:cube -d 3 --lights gradient.json --cones 5
grep -q '"skyMap":{"width":1,"height":256,"texels":"' sky.html || complain "the page does not have the sky's map"
least=$(($(number bytes) - 500))
export_page sky.html scene:cube -d 3 --lights gradient.json --cones 5 --max-bytes "$least"
grep -q '"skyMap"' sky.html || complain "a small page has no sky"
grep -q '"skyMap"' lit.html && complain "a sky of one radiance is a map"

expect_failure 2 'a page has the views' "$program" export-web tree.svo --view specular -o no.html
expect_failure 2 'without --lights or --view full' "$program" export-web tree.svo --cones 6 -o no.html
expect_failure 2 'without --lights or --view full' "$program" export-web tree.svo --exposure 2 -o no.html
expect_failure 2 'is where the camera' "$program" export-web tree.svo --eye 1,2,3 --at 1,2,3 -o no.html
{ echo '{"lights": ['; for i in {1..17}; do
    echo '{"kind": "point", "position": [0, 0, 0], "value": [1, 1, 1]}'; ((i == 17)) || echo ,
done; echo ']}'; } >many.json
expect_failure 1 '17 lights, above the 16' "$program" export-web tree.svo --lights many.json -o no.html
expect_failure 2 '-o FILE is missing' "$program" export-web tree.svo
expect_failure 2 'max-bytes 0 is below 1' "$program" export-web tree.svo --max-bytes 0 -o no.html
expect_failure 2 'max-bytes 268435457 is above' "$program" export-web tree.svo --max-bytes 268435457 -o no.html
expect_failure 2 'build options do not apply' "$program" export-web tree.svo -d 7 -o no.html
expect_failure 2 'build options do not apply' "$program" export-web solid.svc -d 7 -o no.html
expect_failure 1 'No space left' "$program" export-web tree.svo -o /dev/full
expect_failure 1 'no.svc' "$program" export-web no.svc -o no.html
exit "$failed"
