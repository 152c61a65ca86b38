#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
#
# conan.sh FOLDER: whether an archive of what is committed is a Conan package: conanfile.py makes it, with static and
# with shared libraries, and the program of its test links and runs. pip brings Conan into FOLDER; without pip or its
# index the test is skipped (77). What the recipe requires is Debian's (platform_requires), so no other index is asked.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/../.."
mkdir -p "$1"
folder=$(cd "$1" && pwd)
readonly folder conan=$folder/venv/bin/conan
export CONAN_HOME=$folder/home

if [[ ! -x $conan ]] && ! {
    python3 -m venv "$folder/venv" && "$folder/venv/bin/pip" install --quiet 'conan>=2.5,<3'
} >"$folder/pip.log" 2>&1; then
    rm -rf "$folder/venv"
    printf 'skipped: pip cannot install Conan\n'
    exit 77
fi
"$conan" --version

# platform REQUIREMENT PACKAGE [PREFIX]: a line of the profile, with the version that upstream gave a Debian package.
platform()
{
    local version
    version=$(dpkg-query -W -f '${Version}' "$2" |
        sed -E 's/^([0-9]+:|3\.0~|0\.0~git)//; s/^([0-9]+(\.[0-9]+){0,2}).*/\1/')
    printf '%s/%s\n' "$1" "${3:-}$version"
}

"$conan" profile detect --force >"$folder/profile.log" 2>&1
{
    printf 'include(default)\n[platform_requires]\n'
    platform assimp libassimp-dev
    platform c-blosc libblosc-dev
    platform cjson libcjson-dev
    platform expat libexpat1-dev
    platform fast_float libfast-float-dev
    platform libzip libzip-dev
    platform opencl-headers opencl-headers
    platform opencl-icd-loader opencl-headers # both have the dates of the headers
    platform stb libstb-dev cci.
    platform xxhash libxxhash-dev
    platform zlib zlib1g-dev
    platform zstd libzstd-dev
} >"$folder/debian"

rm -rf "$folder/source"
mkdir "$folder/source"
git archive HEAD | tar -x -C "$folder/source"
for shared in True False; do
    "$conan" create "$folder/source" --no-remote -pr "$folder/debian" -o "&:shared=$shared" -o '&:gl=True' \
        >"$folder/create.log" 2>&1 || {
        tail -n 60 "$folder/create.log"
        exit 1
    }
    grep -q '^96776 leaves, 128073 nodes, hash ' "$folder/create.log" || {
        printf 'the program of the test did not print its octree, see %s\n' "$folder/create.log"
        exit 1
    }
    printf 'conan create, shared=%s: passed\n' "$shared"
done
"$conan" remove --confirm svocl >/dev/null
