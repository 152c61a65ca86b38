#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
#
# The page of svocl report in a headless browser: all charts and tables are there, texts are escaped, pictures decode,
# and the page loads nothing from outside.
#
# A copy of the page gets a policy under which the browser refuses and reports whatever is not in the page, and a script
# that counts; the page itself has neither.
#
# usage: report_browser.sh PROGRAM RESULTS; exit code 77 (skipped) without chromium.
set -euo pipefail

readonly program=$1 results=$2
if ! command -v chromium >/dev/null; then
    echo "skipped: chromium is not installed (apt install chromium)"
    exit 77
fi
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
"$program" report --quick --from "$results" -o "$work/page"

readonly policy="default-src 'none'; style-src 'unsafe-inline'; img-src data:; script-src 'unsafe-inline'"
cat >"$work/script" <<END
<meta http-equiv="Content-Security-Policy" content="$policy">
<script>
const refused = [];
const errors = [];
const names = ("e1_1 e2_1 e2t_2 e3_1 e3o_2 e4_2 e5v_3 e5r_1 e5vt_1 e5rt_3 e7_1 e7l_2 e7a_1 e7b_1 e8_1 e8u_2 " +
    "builders_4_1 e6_3_1 memory_1 parts_1_1 parts_2_1 workers_1 moving_1 movings_1 paged_1_1 paged_3_1").split(" ");
window.addEventListener("error", event => errors.push(event.message));
document.addEventListener("securitypolicyviolation", event => refused.push(event.blockedURI));
window.addEventListener("load", () => {
    document.querySelectorAll("details").forEach(folded => folded.open = true);
    const charts = [...document.querySelectorAll("svg.chart")];
    const drawn = charts.filter(chart => chart.getBoundingClientRect().height > 70 && chart.getBBox().width > 200 &&
        chart.querySelectorAll("text").length > 4);
    const tables = [...document.querySelectorAll("table")].filter(table =>
        table.tBodies[0].rows.length > 0 && table.getBoundingClientRect().height > 20);
    const pictures = [...document.images].filter(picture => picture.naturalWidth > 100);
    const outside = performance.getEntriesByType("resource").filter(entry => !entry.name.startsWith("data:"));
    const wide = document.documentElement.scrollWidth > window.innerWidth;
    const named = names.filter(name => document.getElementById(name)?.matches("svg.chart"));
    /* Every section without a table says so, and none beside them does. */
    const missing = [...document.querySelectorAll(".missing")].filter(text => text.textContent.startsWith("Missing. "));
    const absent = document.querySelectorAll("a.absent").length;
    const said = absent > 0 && missing.length === absent;
    const own = document.querySelector("#of-its-own");
    const escaped = own.querySelector("h3").textContent === 'A table <b>that</b> no section is for & "quotes"' &&
        own.querySelector("td").textContent === "a < b" && own.querySelector("b") === null;
    const found = [charts.length, drawn.length, named.length === names.length, tables.length, said, escaped,
        pictures.length, outside.length, refused.length, errors.length, wide];
    document.documentElement.dataset.found = found.join(" ");
});
</script>
END
sed "/<meta charset/r $work/script" "$work/page/index.html" >"$work/counted.html"

failed=0
for size in 1280,900 500,900; do
    found=$(HOME=$work timeout 100 chromium --headless=new --no-sandbox --disable-gpu --disable-background-networking \
        --no-first-run --user-data-dir="$work/profile" --window-size="$size" --virtual-time-budget=5000 --dump-dom \
        "file://$work/counted.html" 2>"$work/err" | sed -n 's/.*data-found="\([^"]*\)".*/\1/p' | head -n 1)
    echo "$size: charts, drawn, all named, tables, missing ones said, escaped, pictures, loaded from outside," \
        "refused, errors, wider than the window: $found"
    [[ $found == "53 53 true 16 true true 4 0 0 0 false" ]] || failed=1
done
exit "$failed"
