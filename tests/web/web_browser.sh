#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
#
# The page of svocl export-web in a headless browser: it asks nothing from outside, the console stays empty, rays end at
# the nodes that the library finds, pictures are those of svocl render, mouse and keys work, and what is missing is said
# in words.
#
# A copy of the page gets a script that uses it and leaves what it found in the document (web/inspect.js).
#
# usage: web_browser.sh PROGRAM COMPARE_PAGE; exit code 77 (skipped) without chromium.
set -euo pipefail

readonly program=$1 compare=$2
if ! command -v chromium >/dev/null; then
    echo "skipped: chromium is not installed (apt install chromium)"
    exit 77
fi
readonly inspect=${BASH_SOURCE[0]%/*}/inspect.js
# shellcheck source=tests/support/complain.sh
source "${BASH_SOURCE[0]%/*}/../support/complain.sh"

# Opens a copy of the page after the script and leaves the document in $work/dom. What else: options of the browser.
open_page()
{
    local page=$1 script=$2
    shift 2
    sed "/<meta charset/r $script" "$page" >"$work/copy.html"
    HOME=$work timeout 200 chromium --headless=new --no-sandbox --use-angle=swiftshader --enable-unsafe-swiftshader \
        --disable-background-networking --no-first-run --user-data-dir="$work/profile" --enable-logging=stderr \
        --timeout=150000 "$@" --dump-dom "file://$work/copy.html" >"$work/dom" 2>"$work/log" ||
        complain "the browser failed: $(tail -n 3 "$work/log")"
}

# What the script left under a name.
found()
{
    tr '\n' '\f' <"$work/dom" | sed -n "s/.*<pre id=\"found-$1\"[^>]*>\([^<]*\)<.*/\1/p" | tr '\f' '\n'
}
expect()
{
    local name=$1 pattern=$2 value
    value=$(found "$name")
    [[ $value =~ ^($pattern)$ ]] || complain "$label: $name is '$value', not '$pattern'"
}

# A script for the copy: the given lines, then inspect.js.
make_script()
{
    { echo '<script>'; cat; cat "$inspect"; echo '</script>'; } >"$work/script"
}

# The pictures that svocl render draws of a tree; the first may be of another.
list_pictures()
{
    local view tree=$2
    echo 'const pictures = ['
    for view in shaded normal depth steps level; do
        "$program" render "$tree" --view "$view" --size 128x96 -q -o "$work/view.png"
        printf '"data:image/png;base64,%s",\n' "$(base64 -w 0 "$work/view.png")"
        tree=$1
    done
    echo '];'
}

# Everything of one page: the tree, its page, whether its pictures are those of the tree, and for a tree without normals
# the same with them: voxels that are about as small as pixels are shaded as if they had normals, not by their faces.
inspect_page()
{
    local tree=$1 page=$2 pictures=$3 smooth=${4:-$1} view kind
    list_pictures "$tree" "$smooth" | make_script
    open_page "$page" "$work/script"
    expect words ''
    expect complaints ''
    expect outside 0
    expect wide false
    expect picked true
    expect turned true
    expect coarser true
    expect moved ''
    for view in 0 1 4; do # at most 1 % of the pixels; the program shows depths and steps in the range of the picture
        if [[ $view == 0 && $smooth != "$tree" ]]; then
            expect distance-0 '[01]\.[0-9]+' # 3.7 by faces
        elif [[ $pictures != other ]]; then
            expect "differs-$view" '0\.[0-9]+|1\.00'
        fi
    done
    for kind in pixel leaf; do
        found "probes-$kind" >"$work/probes"
        "$compare" "$tree" "$work/probes" || complain "$label: rays end at other nodes"
    done
    grep CONSOLE "$work/log" >"$work/console" && complain "$label: the console has $(cat "$work/console")"
    grep -q 'https\?://' "$page" && complain "$label: the page has an address"
    return 0
}

# --- colors and normals; the upper levels of a tree; normals alone; neither; leaves above the deepest level ---

label='statue'
"$program" build scene:statue -d 8 -q -o "$work/statue.svo"
"$program" export-web "$work/statue.svo" -q -o "$work/statue.html"
inspect_page "$work/statue.svo" "$work/statue.html" same

label='upper levels'
"$program" build scene:statue -d 6 -q -o "$work/upper.svo"
"$program" export-web "$work/statue.svo" --max-bytes 140000 -o "$work/cut.html" | tee "$work/said"
grep -q 'Levels 7 to 8 are left out' "$work/said" || complain "$label: not cut at level 6"
inspect_page "$work/upper.svo" "$work/cut.html" other

for need in normal none; do
    label="need $need"
    "$program" build scene:knot -d 7 --need "$need" -q -o "$work/knot-$need.svo"
    "$program" export-web "$work/knot-$need.svo" -q -o "$work/knot.html"
    inspect_page "$work/knot-$need.svo" "$work/knot.html" same "$work/knot-normal.svo"
done

label='merged leaves'
"$program" build scene:cornell -d 7 --need none -q -o "$work/cornell.svo"
"$compare" "$work/cornell.svo" "$work/cornell.svc"
"$program" export-web "$work/cornell.svc" -q -o "$work/cornell.html"
inspect_page "$work/cornell.svc" "$work/cornell.html" other

# --- 500 pixels wide, light and dark ---

make_script <<<''
for scheme in 0 1; do
    label="500 pixels, scheme $scheme"
    open_page "$work/statue.html" "$work/script" --window-size=500,900 --blink-settings=preferredColorScheme=$scheme
    expect words ''
    expect wide false
    expect complaints ''
done

# --- what is missing is said ---

# The words that the page says after a script, with options of the browser.
expect_words()
{
    local words=$1 lines=$2
    shift 2
    label="no picture"
    make_script <<<"$lines"
    open_page "$work/damaged.html" "$work/script" "$@"
    expect words ".*$words.*"
    expect complaints ''
    grep -q CONSOLE "$work/log" && complain "$words: the console has $(grep CONSOLE "$work/log")"
    return 0
}
cp "$work/cut.html" "$work/damaged.html"
expect_words 'no WebGL2' '' --disable-3d-apis
expect_words 'no DecompressionStream' 'delete window.DecompressionStream;'
expect_words 'graphics device has no room for .* of the tree' \
    'WebGL2RenderingContext.prototype.getError = function () { return this.OUT_OF_MEMORY; };'
expect_words 'not compile the shaders' 'WebGL2RenderingContext.prototype.getProgramParameter = () => false;'
expect_words 'graphics device was lost' 'const lose = () => document.querySelector("canvas").getContext("webgl2")
    .getExtension("WEBGL_lose_context").loseContext();
addEventListener("DOMContentLoaded", () => viewer.then(lose));'
expect_words 'browser has no room' 'const Bytes = Uint8Array;
Uint8Array = function (...given) {
    if (given[0] > 40000) { throw new RangeError(); } return new Bytes(...given);
};'
sed '/id="tree"/s/9029/&0/g' "$work/cut.html" >"$work/damaged.html"
expect_words 'damaged: they are too short' ''
sed 's/\("level":\)6\(.*"nodes":\[[0-9,]*\),[0-9]*\]/\15\2]/' "$work/cut.html" >"$work/damaged.html"
expect_words 'damaged: they are too long' ''
sed 's|^\(<script type="application/octet-stream">.\{4000\}\)....|\1AAAA|' "$work/cut.html" >"$work/damaged.html"
expect_words 'data of this page are damaged' ''
sed 's|^\(<script type="application/octet-stream">.\{4000\}\)....|\1****|' "$work/cut.html" >"$work/damaged.html"
expect_words 'data of this page are damaged' ''
exit "$failed"
