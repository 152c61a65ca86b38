#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
#
# The files that svocl export-web writes: their length and its limit, their data, their names, and what is refused.
#
# usage: web.sh PROGRAM
set -euo pipefail

readonly program=$1
# shellcheck source=tests/complain.sh
source "${BASH_SOURCE[0]%/*}/complain.sh"
cd "$work"

# A number of the JSON report.
number()
{
    sed -n "s/.*\"$1\":[[:space:]]*\([0-9]*\).*/\1/p" report.json
}
# Writes a page and checks its length and its data against the report.
export_page()
{
    local page=$1 data
    shift
    "$program" export-web "$@" -o "$page" --json >report.json
    (($(stat -c %s "$page") == $(number bytes))) || complain "$page: $(stat -c %s "$page") bytes, not $(number bytes)"
    (($(number bytes) <= $(number max_bytes))) || complain "$page: $(number bytes) bytes, above the limit"
    data=$(sed -n 's/.*<script id="data"[^>]*>\([^<]*\).*/\1/p' "$page" | base64 -d | gunzip | wc -c)
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

expect_failure 2 '-o FILE is missing' "$program" export-web tree.svo
expect_failure 2 'max-bytes 0 is below 1' "$program" export-web tree.svo --max-bytes 0 -o no.html
expect_failure 2 'max-bytes 268435457 is above' "$program" export-web tree.svo --max-bytes 268435457 -o no.html
expect_failure 2 'build options do not apply' "$program" export-web tree.svo -d 7 -o no.html
expect_failure 2 'build options do not apply' "$program" export-web solid.svc -d 7 -o no.html
expect_failure 1 'No space left' "$program" export-web tree.svo -o /dev/full
expect_failure 1 'no.svc' "$program" export-web no.svc -o no.html
exit "$failed"
