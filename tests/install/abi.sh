#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
#
# abi.sh FOLDER COMMIT: whether programs that were linked with the shared libraries of COMMIT work with those of this
# folder. Builds both into FOLDER and compares them by abidiff (abigail-tools), as far as the public headers show them.
# Functions, enumerators and, at the end of structs that begin with struct_size, fields may be added. All else is a
# change, and fails. Libraries of other names (SONAME), which another minor version gives them, are not compared.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/../.."
mkdir -p "$1"
folder=$(cd "$1" && pwd)
commit=$(git rev-parse --verify --quiet "$2^{commit}") || {
    printf 'abi: %s is no commit\n' "$2"
    exit 2
}
readonly folder commit libraries='lib/libsvocl lib/io/libsvocl_io glinterop/libsvocl_gl'

# build SOURCE NAME: the libraries, not optimized, with what debuggers know of their types.
build()
{
    if ! {
        cmake -S "$1" -B "$folder/$2" -G Ninja -DCMAKE_BUILD_TYPE=Debug -DBUILD_SHARED_LIBS=ON -DSVOCL_TOOLS=OFF \
            -DSVOCL_TESTS=OFF -DSVOCL_SAMPLES=OFF && cmake --build "$folder/$2" --target svocl svocl_io svocl_gl
    } >"$folder/$2.log" 2>&1; then
        tail -n 40 "$folder/$2.log"
        exit 1
    fi
}

rm -rf "$folder/source"
mkdir "$folder/source"
git archive "$commit" | tar -x -C "$folder/source"
build "$folder/source" before
build "$PWD" after

# bodies FOLDER: the structs that may grow, one a line: the name, a tab, and the fields.
bodies()
{
    cat "$1"/svocl/*.h | gcc -fpreprocessed -E -P -x c - | awk '
        /^typedef struct svo_[a-z_]* *\{/ { name = $3; body = ""; next }
        /^\}/ { if (name && body ~ /^ *size_t struct_size;/) print name "\t" body; name = "" }
        name { body = body $0 }' | sort
}

# Those that grew at their end, and did nothing else, are no change.
join -t $'\t' <(bodies "$folder/source/include") <(bodies include) |
    awk -F '\t' '$2 != $3 && index($3, $2) == 1 { print $1 }' | paste -s -d '|' >"$folder/names"
printf '[suppress_type]\n  type_kind = struct\n  name_regexp = ^(%s)$\n  has_data_member_inserted_at = end\n' \
    "$(cat "$folder/names")" >"$folder/suppressions"

soname()
{
    readelf -d "$1" | sed -n 's/.*SONAME.*\[\(.*\)\]/\1/p'
}

changed=0 renamed=0
for library in $libraries; do
    before=$folder/before/$library.so after=$folder/after/$library.so status=0
    printf '== %s and %s\n' "$(soname "$before")" "$(soname "$after")"
    if [[ $(soname "$before") != "$(soname "$after")" ]]; then
        renamed=1
        continue
    fi
    abidiff --headers-dir1 "$folder/source/include" --headers-dir2 include --drop-private-types --no-added-syms \
        --suppressions "$folder/suppressions" "$before" "$after" || status=$?
    if (((status & 3) != 0)); then
        printf 'abi: abidiff failed (%d)\n' "$status"
        exit 1
    fi
    ((status == 0)) || changed=1
done
if ((changed != 0)); then
    printf 'abi: the ABI of %s is changed; that takes another minor version (include/svocl/version.h)\n' "$2"
    exit 1
fi
if ((renamed != 0)); then
    printf 'abi: the libraries have other names than those of %s, whose programs must be linked again\n' "$2"
else
    printf 'abi: programs of %s work with these libraries\n' "$2"
fi
