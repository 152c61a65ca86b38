#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
#
# The arrows' check, a part of `tools/dev check`: which file includes which. Prints what is wrong and exits with 1.
#
#   - Rooms have an order: a file includes files of its own room and of the rooms before it, no others. Of another tree,
#     glinterop includes the rooms of lib but io, and tools include lib's room output.
#   - Files have no circles, where a header counts for the files that define what it declares.
#   - A header declares what the .c file of its name defines; one without such a file, what the files of its folder do.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

# The rooms of each tree in their order. A room in parentheses stands beside the one before it: neither includes the
# other.
lib_rooms='output core plan commands stages pipeline (io (rays voxels '
lib_rooms+='compact (moving (parts edit (paged (solid (scene (light sdf surface (light_file (probes'
readonly lib_rooms
readonly glinterop_rooms='context share raster compute frontend'
tools_rooms='lab/scenes (lab/reference lab/path support lab/measure lab/stress (lab/bench (lab/errors (lab/report '
tools_rooms+='(lab/tune (web (view lab/program (svocl'
readonly tools_rooms

files()
{
    find lib glinterop tools -name '*.[ch]' | sort
}

# "FILE INCLUDED" for each #include of another file in these trees.
includes()
{
    files | xargs grep -H -o '^#include "[^"]*"' | sed 's/:#include "\(.*\)"$/ \1/' | while read -r file name; do
        local folder=${file%/*} tree=${file%%/*} found
        for found in "$folder/$name" "$tree/$name" "$tree/lab/$name" "lib/$name" "tests/$name"; do
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
        function room_of(path,    parts) {
            split(path, parts, "/")
            return parts[1] "/" parts[2] (parts[2] == "lab" ? "/" parts[3] : "")
        }
        function tree_of(path,    parts) { split(path, parts, "/"); return parts[1] }
        BEGIN { read_rooms("lib", lib); read_rooms("glinterop", glinterop); read_rooms("tools", tools) }
        {
            from = room_of($1); to = room_of($2)
            if (!(from in ranks)) { print $1 ": its folder is not in the order of rooms"; next }
            if (tree_of($1) != tree_of($2)) {
                if ((tree_of($1) != "glinterop" || tree_of($2) != "lib" || to == "lib/io") &&
                    (tree_of($1) != "tools" || to != "lib/output"))
                    print $1 " includes " $2 " of another tree"
            } else if (from != to && ranks[to] >= ranks[from]) {
                print $1 " includes " $2 ", against the order of rooms"
            }
        }'
}

# The functions that a header declares: "HEADER NAME".
declarations()
{
    files | grep '\.h$' | while read -r header; do
        # Comments, macros and bodies are left out; what then ends in a semicolon and has a name before a parenthesis
        # is a declaration.
        awk -v header="$header" '
            {
                line = $0
                gsub(/\/\*([^*]|\*[^\/])*\*\//, "", line)
                if (in_comment) { if (sub(/.*\*\//, "", line)) in_comment = 0; else next }
                if (sub(/\/\*.*/, "", line)) in_comment = 1
                if (line ~ /^#/ || in_macro) { in_macro = line ~ /\\$/; next }
                text = text " " line
            }
            END {
                count = split(text, letters, "")
                for (i = 1; i <= count; ++i) {
                    if (letters[i] == "{") { ++depth; statement = "" }
                    else if (letters[i] == "}") { --depth; statement = "" }
                    else if (depth == 0 && letters[i] == ";") { declared(statement); statement = "" }
                    else if (depth == 0) statement = statement letters[i]
                }
            }
            function declared(statement) {
                sub(/__attribute__.*/, "", statement)
                if (statement ~ /typedef|SVO_RECORD|[sS]tatic_assert|SVO_ASSERT/) return
                if (match(statement, /[a-z_][a-z0-9_]*\(/)) print header, substr(statement, RSTART, RLENGTH - 1)
            }' "$header"
    done
}

# Reads what declarations() writes; "HEADER FILE" for each file that defines one of its functions, or "HEADER -NAME"
# where none does that may: the .c file of the header's name, and that of POSIX beside it, or, where there is none, the
# files of its folder.
implementers()
{
    while read -r header name; do
        local candidates=("${header%.h}.c") found
        [[ -e ${candidates[0]} ]] || candidates=("${header%/*}"/*.c)
        [[ ! -e ${header%.h}_posix.c ]] || candidates+=("${header%.h}_posix.c")
        found=$(grep -l -E "^[A-Za-z].*[ *]\\(?$name\\)?\\(" "${candidates[@]}" | head -1) || true
        printf '%s %s\n' "$header" "${found:--$name}"
    done | sort -u
}

# Headers that declare what is defined elsewhere.
foreign_declarations()
{
    sed -n 's/^\(.*\) -\(.*\)$/\1 declares \2, which its .c file or, without one, its folder does not define/p'
}

# Reads what includes() and implementers() write. A header is one with its files: it leads to each of them, and their
# own include of it does not count.
circles()
{
    grep -v ' -' | awk '
        { from[NR] = $1; to[NR] = $2; if ($1 ~ /\.h$/ && $2 ~ /\.c$/) implements[$2 " " $1] = 1 }
        END { for (i = 1; i <= NR; ++i) if (!((from[i] " " to[i]) in implements)) print from[i], to[i] }' |
        sort -u | tsort 2>&1 >/dev/null | sed -n 's/^tsort: \(.*\/.*\)$/in a circle: \1/p'
}

all=$(includes)
made=$(declarations | implementers)
wrong=$(
    against_the_order <<<"$all"
    foreign_declarations <<<"$made"
    circles <<<"$all"$'\n'"$made" || true # where tsort finds circles
)
if [[ -n $wrong ]]; then
    printf '%s\n' "$wrong"
    exit 1
fi
