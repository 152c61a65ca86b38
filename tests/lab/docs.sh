#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
#
# The tables of README.md and docs/ match docs/results.json: written again into copies, the documents are the same, byte
# for byte. A wrong marker is reported in one line, and then no document changes. Relative links lead to files.
#
# usage: docs.sh PROGRAM SOURCE_DIR
set -euo pipefail

readonly program=$1 source=$2
# shellcheck source=tests/support/complain.sh
source "${BASH_SOURCE[0]%/*}/../support/complain.sh"

copy_documents()
{
    rm -rf "$work/copy"
    mkdir -p "$work/copy/docs"
    cp "$source/README.md" "$work/copy"
    cp "$source"/docs/*.md "$source"/docs/gl_vs_cl*.json "$work/copy/docs"
}
write_tables()
{
    "$program" report --from "$source/docs/results.json" --docs "$work/copy"
}
expect_same()
{
    local path
    for path in README.md docs; do
        diff -r -x '*.json' -x '*.png' -x gallery -x tutorial -x Doxyfile "$source/$path" "$work/copy/$path" ||
            complain "$path: $1"
    done
}

# Every relative link of a document.
expect_links()
{
    local document=$1 target
    while read -r target; do
        [[ -e ${document%/*}/$target ]] || complain "$document: $target does not exist"
    done < <(grep -o '](\([^)#]*\)' "$document" | cut -c 3- | grep -v -e '^https\?:' -e '^$')
}
for document in "$source"/*.md "$source"/docs/*.md "$source"/samples/*/README.md; do
    expect_links "$document"
done

copy_documents
write_tables
expect_same 'not what docs/results.json says; run svocl report --from docs/results.json --docs .'
grep -q '<!-- svocl:table' "$work/copy/docs/performance.md" || complain "no tables in docs/performance.md"

# As JSON: which documents were written.
"$program" report --from "$source/docs/results.json" --docs "$work/copy" --json >"$work/written.json"
grep -q "\"$work/copy/docs/performance.md\"" "$work/written.json" ||
    complain "performance.md is not among what was written"
grep -q '"page":[[:space:]]*null' "$work/written.json" || complain "a page that was not asked for"

# What stands between markers, and nothing else, is replaced.
sed -i '/^<!-- svocl:table /a something else' "$work"/copy/README.md "$work"/copy/docs/*.md
write_tables
expect_same 'text between markers was not replaced'

# Lines to append to a document, and words of the one line that is printed about them.
expect_refused()
{
    local lines=$1 words=$2
    copy_documents
    printf '%b' "$lines" >>"$work/copy/docs/performance.md"
    cp -r "$work/copy" "$work/before"
    sed -i '/^<!-- svocl:table /a something else' "$work/copy/README.md" "$work/before/README.md"
    expect_failure 1 "$words" write_tables
    diff -r "$work/before" "$work/copy" || complain "documents changed in spite of: $lines"
    rm -rf "$work/before"
}
expect_refused '<!-- svocl:table nothing -->\n<!-- svocl:end -->\n' 'performance.md:[0-9]*: .* nothing$'
expect_refused '<!-- svocl:table rays -->\n' 'performance.md:[0-9]*: this table has no svocl:end'
expect_refused '<!-- svocl:table rays -->\n<!-- svocl:table e1 -->\n<!-- svocl:end -->\n' 'this table has no svocl:end'
expect_refused '<!-- svocl:end -->\n' 'svocl:end without a svocl:table'
expect_refused '<!-- svocl:tables rays -->\n' 'neither <!-- svocl:table ID --> nor'

expect_refused '<!-- svocl:results nowhere.json -->\n' 'docs/nowhere.json: No such file'
expect_refused '<!-- svocl:results gl_vs_cl.json -->\n<!-- svocl:table nothing -->\n<!-- svocl:end -->\n' \
    'performance.md:[0-9]*: .* nothing$'

# Results that lack a table.
copy_documents
cat >"$work/empty.json" <<'END'
{"machine": {"device": "d", "driver": "1", "platform": "p", "renderer": "none", "cpu_threads": 1, "svocl": "0"},
 "tables": []}
END
expect_failure 1 'the results lack' "$program" report --from "$work/empty.json" --docs "$work/copy"
expect_same 'changed by results without tables'
exit "$failed"
