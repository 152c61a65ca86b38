#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
#
# oldest_cmake.sh FOLDER: whether the CMake that CMakeLists.txt asks for suffices to configure everything, to build
# svocl as a part of another project, and to build, install and use its shared libraries. pip brings that CMake into
# FOLDER; without pip or its index the test is skipped (77).
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/../.."
mkdir -p "$1"
folder=$(cd "$1" && pwd)
version=$(sed -n 's/^cmake_minimum_required(VERSION \(.*\))$/\1/p' CMakeLists.txt)
readonly folder version cmake=$folder/venv/bin/cmake

if [[ ! -x $cmake ]] && ! {
    python3 -m venv "$folder/venv" && "$folder/venv/bin/pip" install --quiet "cmake==$version.*"
} >"$folder/pip.log" 2>&1; then
    rm -rf "$folder/venv"
    printf 'skipped: pip cannot install CMake %s\n' "$version"
    exit 77
fi
"$cmake" --version | head -n 1

rm -rf "$folder/build"
"$cmake" -S . -B "$folder/build" -G Ninja -DCMAKE_BUILD_TYPE=Release >"$folder/configure.log" 2>&1 || {
    cat "$folder/configure.log"
    exit 1
}
"$cmake" --list-presets >/dev/null
project=$(sed -n 's/^#define SVO_VERSION_STRING "\(.*\)".*/\1/p' include/svocl/version.h)
for test in subproject shared; do
    "$cmake" -DSOURCE_DIR="$PWD" -DWORK_DIR="$folder/$test" -DC_COMPILER=cc -DGENERATOR=Ninja -DVERSION="$project" \
        -P "tests/install/test_$test.cmake"
    printf '%s: passed\n' "$test"
done
