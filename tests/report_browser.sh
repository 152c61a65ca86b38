#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
#
# The page of svocl report in a browser without a screen: every chart is drawn, every table has rows, pictures are decoded, and
# nothing outside the page is asked for.
#
# A copy of the page gets a policy under which the browser refuses and reports whatever is not in the page, and a script that
# counts; the page itself has neither.
#
# usage: report_browser.sh PROGRAM RESULTS; exit code 77 (skipped) without chromium or gnuplot.
set -euo pipefail

readonly program=$1 results=$2
for tool in chromium gnuplot; do
    if ! command -v "$tool" >/dev/null; then
        echo "skipped: $tool is not installed"
        exit 77
    fi
done
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
"$program" report --quick --from "$results" -o "$work/page"

readonly policy="default-src 'none'; style-src 'unsafe-inline'; img-src data:; script-src 'nonce-count'"
cat >"$work/script" <<END
<meta http-equiv="Content-Security-Policy" content="$policy">
<script nonce="count">
const refused = [];
document.addEventListener("securitypolicyviolation", event => refused.push(event.blockedURI));
window.addEventListener("load", () => {
    document.querySelectorAll("details").forEach(folded => folded.open = true);
    const charts = [...document.querySelectorAll("svg.chart")];
    const drawn = charts.filter(chart => chart.getBoundingClientRect().height > 100 && chart.getBBox().width > 200 &&
        chart.querySelectorAll("text").length > 4);
    const tables = [...document.querySelectorAll("table")].filter(table =>
        table.tBodies[0].rows.length > 0 && table.getBoundingClientRect().height > 20);
    const pictures = [...document.images].filter(picture => picture.naturalWidth > 100);
    const outside = performance.getEntriesByType("resource").filter(entry => !entry.name.startsWith("data:"));
    const wide = document.documentElement.scrollWidth > window.innerWidth;
    const found = [charts.length, drawn.length, tables.length, pictures.length, outside.length, refused.length, wide];
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
    echo "$size: charts, drawn, tables, pictures, asked outside, refused, wider than the window: $found"
    [[ $found == "32 32 9 4 0 0 false" ]] || failed=1
done
exit "$failed"
