#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
#
# svocl report of figures in a file: every table and chart is in the page, the page needs nothing else, the files beside it hold
# the same tables, and what goes wrong is one line.
#
# usage: report.sh PROGRAM RESULTS; exit code 77 (skipped) without gnuplot.
set -euo pipefail

readonly program=$1 results=$2
if ! command -v gnuplot >/dev/null; then
    echo "skipped: gnuplot is not there, install gnuplot-nox"
    exit 77
fi
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
failed=0
complain()
{
    echo "$*"
    failed=1
}
expect()
{
    grep -q -- "$1" "$2" || complain "no '$1' in ${2##*/}"
}
expect_none()
{
    if grep -n -i -E -m 3 -- "$1" "$work/without_pictures.html" | cut -c 1-200 | grep .; then
        complain "'$1' in the page"
    fi
}

"$program" report --quick --from "$results" -o "$work/page"
readonly page=$work/page/index.html

# Charts: a panel per scene, set of rays, attribute or stiffness, for every figure.
charts=$(grep -c '<svg class="chart"' "$page")
((charts == 2 + 2 + 2 + 2 + 2 + 2 + 4 * 3 + 4 + 3 + 1)) || complain "$charts charts"
[[ $(grep -c '^</svg>' "$page") == "$charts" ]] || complain "a chart does not end"
for name in e1_1 e2_1 e2t_2 e3_1 e3o_2 e4_2 e5v_3 e5r_1 e5vt_1 e5rt_3 builders_4_1 e6_3_1 memory_1; do
    expect "<svg class=\"chart\" id=\"$name\"" "$page"
done
# Tables: those of the file, also one that no section is for, its text escaped; others are named as missing.
while read -r id; do
    expect "<table id=\"table-$id\"" "$page"
    [[ -s $work/page/$id.csv ]] || complain "no $id.csv"
done < <(sed -n 's/^ *{"id": "\([^"]*\)".*/\1/p' "$results")
expect 'A table &lt;b&gt;that&lt;/b&gt; no section is for &amp; &quot;quotes&quot;' "$page"
expect 'a device &lt;for tests&gt;' "$page"
(($(grep -c 'class="missing"' "$page") == 10)) || complain "$(grep -c 'class="missing"' "$page") tables named as missing"
(($(grep -o 'src="data:image/png;base64,iVBOR' "$page" | wc -l) == 4)) || complain "not four pictures"
# Nothing from outside.
sed 's/base64,[^"]*//' "$page" >"$work/without_pictures.html"
expect_none 'https?:|//[a-z]|<script|<link|<iframe|@import|url\(|xlink|file:'
expect_none '(src|href)=["'\''][^#"'\''d]'
# Beside it.
expect '"tables"' "$work/page/results.json"
expect '| exact integers, cl |' "$work/page/summary.md"
expect '| cl |' "$work/page/summary.md"
[[ -z $(find "$work/page" -name '*.tmp') ]] || complain "temporary files are left"
# Read again, the same figures.
"$program" report --quick --from "$work/page/results.json" -o "$work/again" >/dev/null
for file in "$work"/page/*.csv "$work/page/summary.md" "$work/page/results.json"; do
    cmp "$file" "$work/again/${file##*/}" || complain "${file##*/} differs when read again"
done

# One line each.
expect_failure()
{
    local code=0 wanted=$1 words=$2
    shift 2
    "$@" >"$work/out" 2>"$work/err" || code=$?
    ((code == wanted)) || complain "exit code $code of: $*"
    if (($(wc -l <"$work/err") != 1)) || ! grep -q -- "$words" "$work/err"; then
        complain "not one line with '$words': $(cat "$work/err")"
    fi
}
expect_failure 2 '-o DIR is missing' "$program" report --quick
expect_failure 1 'nowhere.json' "$program" report --from "$work/nowhere.json" -o "$work/other"
expect_failure 1 'summary.md' "$program" report --from "$work/page/summary.md" -o "$work/other"
expect_failure 1 'not a folder' "$program" report --from "$results" -o "$results"
expect_failure 1 'install gnuplot-nox' env PATH=/nowhere "$program" report --quick --from "$results" -o "$work/bare"
[[ ! -e $work/bare/index.html ]] || complain "a page without its charts"
exit "$failed"
