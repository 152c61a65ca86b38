#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
#
# The arrows' check, a part of `tools/dev check`: which file includes which. Prints what is wrong and exits with 1.
#
#   - Rooms have an order: a file includes files of its own room and of the rooms before it, no others.
#   - Files have no circles, where a header counts as one with the .c file of its name.
#   - A header declares only what the .c file of its name defines; one without such a file declares no function.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

# The rooms of each tree in their order. A room in parentheses stands beside the one before it: neither includes the
# other.
readonly lib_rooms='core plan commands stages build (rays (io'
readonly glinterop_rooms='context share raster compute frontend'
readonly tools_rooms='scenes (reference support measure stress bench (errors (report svocl (snapshot'

files()
{
    find lib glinterop tools -name '*.[ch]' | sort
}

# "FILE INCLUDED" for each #include of another file in these trees.
includes()
{
    files | xargs grep -H -o '^#include "[^"]*"' | sed 's/:#include "\(.*\)"$/ \1/' | while read -r file name; do
        local folder=${file%/*} tree=${file%%/*} found
        for found in "$folder/$name" "$tree/$name" "lib/$name" "tests/$name"; do
            if [[ -e $found ]]; then
                printf '%s %s\n' "$file" "$found"
                break
            fi
        done
    done
}

# Reads what includes() writes; prints the lines against the order of rooms.
against_the_order()
{
    awk -v lib="$lib_rooms" -v glinterop="$glinterop_rooms" -v tools="$tools_rooms" '
        function read_rooms(tree, text,    names, count, i, rank, name) {
            count = split(text, names, " ")
            for (i = 1; i <= count; ++i) {
                name = names[i]
                rank += sub(/^\(/, "", name) ? 0 : 1
                ranks[tree "/" name] = rank
            }
        }
        function room_of(path,    parts) { split(path, parts, "/"); return parts[1] "/" parts[2] }
        function tree_of(path,    parts) { split(path, parts, "/"); return parts[1] }
        BEGIN { read_rooms("lib", lib); read_rooms("glinterop", glinterop); read_rooms("tools", tools) }
        {
            from = room_of($1); to = room_of($2)
            if (!(from in ranks)) { print $1 ": its folder is not in the order of rooms"; next }
            if (tree_of($1) != tree_of($2)) {
                if (tree_of($1) != "glinterop" || tree_of($2) != "lib" || to == "lib/io")
                    print $1 " includes " $2 " of another tree"
            } else if (from != to && ranks[to] >= ranks[from]) {
                print $1 " includes " $2 ", against the order of rooms"
            }
        }'
}

# Reads what includes() writes; prints the circles between files.
circles()
{
    sed 's/\.[ch]\b//g' | awk '$1 != $2' | sort -u | tsort 2>&1 >/dev/null | sed -n 's/^tsort: \(.*\/.*\)$/in a circle: \1/p'
}

# Functions that a header declares and the .c file of its name does not define.
foreign_declarations()
{
    files | grep '\.h$' | while read -r header; do
        local source=${header%.h}.c
        [[ -e $source ]] || source=/dev/null
        awk -v header="$header" '
            # The header first: text without comments, macros and bodies; then the names that are called like functions.
            FNR == NR {
                line = $0
                gsub(/\/\*([^*]|\*[^\/])*\*\//, "", line)
                if (in_comment) { if (sub(/.*\*\//, "", line)) in_comment = 0; else next }
                if (sub(/\/\*.*/, "", line)) in_comment = 1
                if (line ~ /^#/ || in_macro) { in_macro = line ~ /\\$/; next }
                text = text " " line
                next
            }
            { source = source "\n" $0 }
            END {
                depth = 0
                count = split(text, letters, "")
                for (i = 1; i <= count; ++i) {
                    if (letters[i] == "{") { ++depth; statement = "" }
                    else if (letters[i] == "}") { --depth; statement = "" }
                    else if (depth == 0 && letters[i] == ";") { check(statement); statement = "" }
                    else if (depth == 0) statement = statement letters[i]
                }
            }
            function check(statement,    name) {
                if (statement ~ /typedef|SVO_RECORD|[sS]tatic_assert|SVO_ASSERT|__attribute__\(\(weak/) return
                sub(/__attribute__.*/, "", statement)
                if (!match(statement, /[a-z_][a-z0-9_]*\(/)) return
                name = substr(statement, RSTART, RLENGTH - 1)
                if (source !~ ("\n[A-Za-z][^\n;=]*[ *]" name "\\(")) print header " declares " name ", which its .c file does not define"
            }' "$header" "$source"
    done
}

all=$(includes)
wrong=$(against_the_order <<<"$all"; circles <<<"$all"; foreign_declarations)
if [[ -n $wrong ]]; then
    printf '%s\n' "$wrong"
    exit 1
fi
