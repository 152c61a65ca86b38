#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
#
# exports.sh [--plugin PLUGIN] SOURCE SVOCL [GL] [IO]: whether the lists of exported symbols (lib/exports.txt,
# glinterop/exports.txt, lib/io/exports.txt) are what the public headers declare; whether the internal part of the first
# is what GL and IO need, no more and no less; whether the libraries, if they are shared, export the symbols of their
# list and no others, each with its version; and whether PLUGIN, which contains the static libraries, exports none.
set -euo pipefail
export LC_ALL=C
plugin=
if [[ $1 == --plugin ]]; then
    plugin=$2
    shift 2
fi
readonly plugin source=$1
shift

failed=0
# Compares two lists of symbols, one a line.
expect_same()
{
    local difference
    difference=$(diff <(sort -u <<<"$2") <(sort -u <<<"$3")) && return 0
    difference=$(grep '^[<>]' <<<"$difference")
    printf '%s:\n%s\n' "$1" "$difference"
    failed=1
}

# Undefined (U) or defined (other) symbols of archives and shared libraries, with their version if there is one.
versioned_symbols()
{
    local option=$1 file
    shift
    for file in "$@"; do
        case $file in
        *.a) nm "$option" "$file" 2>/dev/null ;;
        *) nm -D "$option" "$file" ;;
        esac
    done | awk 'NF > 1 {print $NF}' | grep '^svo_' || true
}

symbols()
{
    versioned_symbols "$@" | sed 's/@.*//'
}

# Each declaration begins with SVO_API; its name is the word before the first parenthesis.
declared()
{
    cat "$@" | tr '\n' ' ' | grep -o 'SVO_API [^(;]*(' | grep -oE 'svo_[a-z0-9_]+ *\($' | tr -d ' ('
}

# The list of a library and the headers with its declarations.
list_of()
{
    case ${1##*/} in
    libsvocl_gl.*) printf '%s\n' "$source/glinterop/exports.txt" ;;
    libsvocl_io.*) printf '%s\n' "$source/lib/io/exports.txt" ;;
    *) printf '%s\n' "$source/lib/exports.txt" ;;
    esac
}

headers_of()
{
    local header
    case ${1##*/} in
    libsvocl_gl.*) printf '%s\n' "$source/include/svocl/gl.h" ;;
    libsvocl_io.*) printf '%s\n' "$source"/include/svocl/{io,paged,parts,parts_tree,points,voxel_files}.h ;;
    *)
        for header in "$source"/include/svocl/*.h; do
            [[ $header == */@(gl|io|paged|parts|parts_tree|points|voxel_files).h ]] || printf '%s\n' "$header"
        done
        ;;
    esac
}

for library in "$@"; do
    list=$(list_of "$library")
    listed=$(grep '^svo_' "$list")
    mapfile -t headers < <(headers_of "$library")
    expect_same "$list (<) and the public headers (>)" "$(grep -v '^svo_i_' <<<"$listed")" "$(declared "${headers[@]}")"
    if [[ $library != *.a ]]; then
        expect_same "$list (<) and what $library exports (>)" "$listed" "$(symbols --defined-only "$library")"
        # lib.so.MAJOR.MINOR.PATCH has the versions SVOCL_MAJOR.MINOR and, for internal symbols, ..._INTERNAL.
        abi=$(readelf -d "$library" | sed -n 's/.*SONAME.*\.so\.\([0-9.]*\)\]$/\1/p')
        versioned=$(sed -E "s/^svo_i_.*/&@@SVOCL_${abi}_INTERNAL/; t; s/\$/@@SVOCL_$abi/" <<<"$listed")
        expect_same "versions expected (<) and those of $library (>)" "$versioned" \
            "$(versioned_symbols --defined-only "$library")"
    fi
done

# Only where all users are built is it known what they need.
if (($# == 3)); then
    listed=$(grep '^svo_i_' "$(list_of "$1")")
    shift
    needed=$(comm -23 <(symbols --undefined-only "$@" | sort -u) <(symbols --defined-only "$@" | sort -u))
    expect_same 'lib/exports.txt (<) and what svocl::gl and svocl::io need (>)' "$listed" \
        "$(grep '^svo_i_' <<<"$needed")"
fi

if [[ -n $plugin ]]; then
    # Proof that the plugin contains the libraries at all.
    if [[ $(nm "$plugin") != *' svo_build'$'\n'* ]]; then
        printf '%s does not contain svo_build\n' "$plugin"
        failed=1
    fi
    expect_same "nothing (<) and what $plugin exports (>)" '' "$(symbols --defined-only "$plugin")"
fi
exit "$failed"
