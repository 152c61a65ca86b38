#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
#
# svocl report from a file of results: the page holds the data and needs nothing else, the files in its folder hold the
# same tables, and every failure is one line. report_browser.sh tests what the page makes of the data.
#
# usage: report.sh PROGRAM RESULTS
set -euo pipefail

readonly program=$1 results=$2
# shellcheck source=tests/support/complain.sh
source "${BASH_SOURCE[0]%/*}/../support/complain.sh"
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

# One block of data and four scripts, none of which a text of the results ends.
(($(grep -c '<script' "$page") == 5)) || complain "$(grep -c '<script' "$page") scripts"
(($(grep -o '</script' "$page" | wc -l) == 5)) || complain "a text ends a script"
expect 'A table \\u003cb>that\\u003c/b> no section is for & \\"quotes\\"' "$page"
expect 'a device \\u003cfor tests>' "$page"
(($(grep -o '"data:image/png;base64,iVBOR' "$page" | wc -l) == 4)) || complain "not four pictures"
# All tables, in the page and as files; a reader without JavaScript is told where.
while read -r id; do
    expect "\"id\":\"$id\"" "$page"
    [[ -s $work/page/$id.csv ]] || complain "no $id.csv"
done < <(sed -n 's/^ *{"id": "\([^"]*\)".*/\1/p' "$results")
expect '<noscript>.*JavaScript' "$page"
expect 'href="summary.md"' "$page"
# Nothing from outside.
sed 's/base64,[^"]*//g' "$page" >"$work/without_pictures.html"
expect_none 'https?:|//[a-z]|<link|<iframe|@import|url\(|xlink|file:/|fetch\(|import'
# shellcheck disable=SC2016 # a dollar sign in the page's scripts
expect_none '(src|href)=["'\''][^#"'\''$s]'
# The other files.
expect '"tables"' "$work/page/results.json"
expect '| exact integers, cl |' "$work/page/summary.md"
expect '| cl |' "$work/page/summary.md"
[[ -z $(find "$work/page" -name '*.tmp') ]] || complain "temporary files are left"
# Read again, the same figures.
"$program" report --quick --from "$work/page/results.json" -o "$work/again" >/dev/null
for file in "$work"/page/*.csv "$work/page/summary.md" "$work/page/results.json"; do
    cmp "$file" "$work/again/${file##*/}" || complain "${file##*/} differs when read again"
done

# What was written, as JSON: every file of the folder with its length.
"$program" report --quick --from - -o "$work/piped" --json <"$results" >"$work/written.json"
expect '"version":' "$work/written.json"
expect "\"page\":[[:space:]]*\"$work/piped/index.html\"" "$work/written.json"
for file in "$work"/piped/*; do
    grep -A 1 -F "\"$file\"" "$work/written.json" |
        grep -q -x "[[:space:]]*\"bytes\":[[:space:]]*$(stat -c %s "$file")" ||
        complain "${file##*/} is not among what was written, or with another length"
done
(($(grep -c '"file":' "$work/written.json") == $(find "$work/piped" -type f | wc -l))) ||
    complain "other files were listed"

# One line each.
expect_failure 2 '-o DIR is missing' "$program" report --quick
expect_failure 1 'nowhere.json' "$program" report --from "$work/nowhere.json" -o "$work/other"
expect_failure 1 'summary.md' "$program" report --from "$work/page/summary.md" -o "$work/other"
expect_failure 1 'not a folder' "$program" report --from "$results" -o "$results"
exit "$failed"
