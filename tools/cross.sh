# shellcheck shell=bash
# SPDX-License-Identifier: MIT
#
# `tools/dev cross windows|arm64`: svocl for systems that this machine is not, by Debian's cross compilers, and what of
# it runs here under an emulator. A system without its compiler is skipped (77). tools/dev sources this file, which uses
# its functions and settings.
# shellcheck disable=SC2154

readonly build_cross=build-cross

# What both parts leave out.
readonly cross_options=(-DSVOCL_GL=OFF -DSVOCL_VIEW=OFF -DSVOCL_EXR=OFF -DSVOCL_EMBREE=OFF -DSVOCL_OPENVDB=OFF)

# cross_needs COMMAND PACKAGE: ends with 77 where the command is missing.
cross_needs()
{
    if ! command -v "$1" >/dev/null; then
        printf 'cross: skipped, without %s (apt install %s)\n' "$1" "$2"
        exit 77
    fi
}

# --- Windows ---------------------------------------------------------------------------------------------------------

readonly cross_mingw=x86_64-w64-mingw32

# An import library of the OpenCL loader, whose functions are those of the loader here, and a folder of the headers that
# depend on no system.
cross_windows_opencl()
{
    local folder=$1 loader
    loader=$(pkg-config --variable=libdir OpenCL)/libOpenCL.so
    mkdir -p "$folder/include"
    ln -sfn "$(pkg-config --variable=includedir OpenCL)/CL" "$folder/include/CL"
    ln -sfn "$(pkg-config --variable=includedir libxxhash)/xxhash.h" "$folder/include/xxhash.h"
    {
        printf 'LIBRARY OpenCL.dll\nEXPORTS\n'
        nm -D --defined-only "$loader" | sed -n 's/.* T \(cl[A-Z][A-Za-z0-9]*\).*/  \1/p'
    } >"$folder/OpenCL.def"
    "$cross_mingw-dlltool" -d "$folder/OpenCL.def" -l "$folder/libOpenCL.dll.a"
}

# cross_windows_cmake SOURCE FOLDER [OPTION...]: configures for Windows with that loader.
cross_windows_cmake()
{
    local source=$1 folder=$2 opencl=$root/$build_cross/windows/opencl
    shift 2
    [[ -e $folder/build.ninja ]] ||
        cmake -S "$source" -B "$folder" -G Ninja -DCMAKE_BUILD_TYPE=Release -DCMAKE_SYSTEM_NAME=Windows \
            -DCMAKE_SYSTEM_PROCESSOR=x86_64 -DCMAKE_C_COMPILER="$cross_mingw-gcc" \
            -DCMAKE_RC_COMPILER="$cross_mingw-windres" -DOpenCL_INCLUDE_DIR="$opencl/include" \
            -DOpenCL_LIBRARY="$opencl/libOpenCL.dll.a" -DSVOCL_XXHASH_INCLUDE_DIR="$opencl/include" "$@"
}

# The names that a library exports, one a line.
cross_windows_exports()
{
    "$cross_mingw-objdump" -p "$1" | sed -n 's/^.*\[ *[0-9]*\] \(svo_[a-z0-9_]*\)$/\1/p' |
        LC_ALL=C sort -u
}

# Compiles a program of one file against the installation, or without a third argument against this machine's build.
cross_windows_program()
{
    local source=$1 to=$2 prefix=${3:-} opencl=$build_cross/windows/opencl
    if [[ -n $prefix ]]; then
        "$cross_mingw-gcc" -std=c11 -I"$prefix/include" -isystem "$opencl/include" "$source" -o "$to" \
            "$prefix/lib/libsvocl.dll.a" "$opencl/libOpenCL.dll.a"
    else
        cc -std=c11 -DSVO_STATIC -Iinclude "$source" -o "$to" "$build/lib/libsvocl.a" -lOpenCL -lm
    fi
}

# The smallest sample, and one that keeps kernels in files, print under Wine what they print here. Wine's OpenCL loader
# has this machine's drivers.
cross_windows_run()
{
    local folder=$1 prefix=$2 expected got
    configure "$build" -DSVOCL_TESTS=OFF -DSVOCL_SAMPLES=OFF
    quietly "$build/build.log" cmake --build "$build" -j "$jobs" --target svocl
    prepare_run_time
    quietly "$folder/programs.log" cross_windows_program samples/01_minimal/main.c "$folder/voxels"
    quietly "$folder/programs.log" cross_windows_program tests/install/saved_kernels.c "$folder/saved_kernels"
    quietly "$folder/programs.log" cross_windows_program tests/install/saved_kernels.c \
        "$prefix/bin/saved_kernels.exe" "$prefix"
    export WINEPREFIX=$root/$folder/wine WINEDEBUG=-all
    rm -rf "$folder/kernels" "$folder/kernels_wine"
    expected=$("$folder/voxels" && "$folder/saved_kernels" "$folder/kernels") || fail "the programs failed here"
    got=$(wine "$prefix/bin/voxels.exe" && wine "$prefix/bin/saved_kernels.exe" "$folder/kernels_wine") ||
        fail "a program failed under Wine"
    got=${got//$'\r'/}
    [[ $got == "$expected" ]] || fail "under Wine the programs printed '$got', and here '$expected'"
    printf 'cross: windows: libsvocl.dll links; under Wine as here: %s\n' "${got//$'\n'/; }"
}

# libsvocl.dll with the headers, installed, and the smallest sample, which finds it there and links it. The library
# exports what lib/exports.txt lists.
cross_windows()
{
    local folder=$build_cross/windows prefix=$root/$build_cross/windows/prefix
    cross_needs "$cross_mingw-gcc" gcc-mingw-w64-x86-64
    setup "${program_packages[@]}"
    mkdir -p "$folder/consumer"
    quietly "$folder/opencl.log" cross_windows_opencl "$folder/opencl"
    quietly "$folder/configure.log" cross_windows_cmake . "$folder/library" "${cross_options[@]}" \
        -DBUILD_SHARED_LIBS=ON -DSVOCL_IO=OFF -DSVOCL_TOOLS=OFF -DSVOCL_TESTS=OFF -DSVOCL_SAMPLES=OFF \
        -DSVOCL_WERROR=ON -DCMAKE_INSTALL_PREFIX="$prefix"
    quietly "$folder/build.log" cmake --build "$folder/library" -j "$jobs" --target install
    diff <(grep '^svo_' lib/exports.txt | LC_ALL=C sort) <(cross_windows_exports "$prefix/bin/libsvocl.dll") ||
        fail "libsvocl.dll exports other names than lib/exports.txt has"
    cp samples/01_minimal/main.c tests/install/consumer/CMakeLists.txt "$folder/consumer/"
    quietly "$folder/consumer.log" cross_windows_cmake "$folder/consumer" "$folder/consumer/build" \
        -DCMAKE_PREFIX_PATH="$prefix" -DCMAKE_RUNTIME_OUTPUT_DIRECTORY="$prefix/bin"
    quietly "$folder/consumer.log" cmake --build "$folder/consumer/build"
    if command -v wine >/dev/null; then
        cross_windows_run "$folder" "$prefix"
    else
        printf 'cross: windows: libsvocl.dll and a program link; nothing ran, without wine (apt install wine wine64)\n'
    fi
}

# --- arm64 -----------------------------------------------------------------------------------------------------------

readonly cross_arm=aarch64-linux-gnu
# Packages of arm64 that are unpacked beside, not installed.
readonly cross_arm64_packages=(libc6-dev libstdc++6 ocl-icd-opencl-dev opencl-headers libassimp-dev libfast-float-dev
    libstb-dev libzip-dev libexpat1-dev libxxhash-dev libzstd-dev libcjson-dev zlib1g-dev libgmp-dev libcmocka-dev)
# Tests that need no OpenCL device, take seconds there, and start no program, which the kernel would not hand to QEMU.
readonly cross_arm64_tests=(test_core_host test_file test_points)

# apt-get on package lists, a cache and a list of installed packages of its own, so that it needs no root and changes
# nothing of this machine.
cross_arm64_apt()
{
    local folder=$root/$build_cross/arm64/apt
    mkdir -p "$folder/lists/partial" "$folder/archives/partial"
    : >"$folder/status"
    apt-get -q -y -o APT::Architecture=arm64 -o APT::Architectures::=arm64 -o Dir::State="$folder" \
        -o Dir::State::status="$folder/status" -o Dir::Cache="$folder" -o Dir::Cache::archives="$folder/archives" \
        -o Debug::NoLocking=1 "$@"
}

cross_arm64_root()
{
    local sysroot=$1 package
    [[ $(cat "$sysroot/packages" 2>/dev/null) != "${cross_arm64_packages[*]}" ]] || return 0
    rm -rf "$sysroot"
    mkdir -p "$sysroot"
    cross_arm64_apt update
    cross_arm64_apt install --no-install-recommends --download-only "${cross_arm64_packages[@]}"
    for package in "$root/$build_cross"/arm64/apt/archives/*.deb; do
        dpkg-deb -x "$package" "$sysroot"
    done
    printf '%s\n' "${cross_arm64_packages[*]}" >"$sysroot/packages"
}

# The libraries and the program, and the tests that need no OpenCL device, which run under QEMU.
cross_arm64()
{
    local folder=$build_cross/arm64 sysroot=$root/$build_cross/arm64/root pattern
    cross_needs "$cross_arm-gcc" "g++-$cross_arm"
    cross_needs "$cross_arm-g++" "g++-$cross_arm"
    cross_needs qemu-aarch64 qemu-user
    cross_needs apt-get apt
    setup "${program_packages[@]}"
    mkdir -p "$folder"
    quietly "$folder/root.log" cross_arm64_root "$sysroot"
    export PKG_CONFIG_SYSROOT_DIR=$sysroot
    export PKG_CONFIG_LIBDIR=$sysroot/usr/lib/$cross_arm/pkgconfig:$sysroot/usr/share/pkgconfig
    [[ -e $folder/svocl/build.ninja ]] ||
        quietly "$folder/configure.log" cmake -S . -B "$folder/svocl" -G Ninja -DCMAKE_BUILD_TYPE=Release \
            -DCMAKE_SYSTEM_NAME=Linux -DCMAKE_SYSTEM_PROCESSOR=aarch64 -DCMAKE_SYSROOT="$sysroot" \
            -DCMAKE_FIND_ROOT_PATH="$sysroot" -DCMAKE_FIND_ROOT_PATH_MODE_PROGRAM=NEVER \
            -DCMAKE_FIND_ROOT_PATH_MODE_LIBRARY=ONLY -DCMAKE_FIND_ROOT_PATH_MODE_INCLUDE=ONLY \
            -DCMAKE_LIBRARY_ARCHITECTURE="$cross_arm" -DCMAKE_C_COMPILER="$cross_arm-gcc" \
            -DCMAKE_CXX_COMPILER="$cross_arm-g++" \
            "-DCMAKE_CROSSCOMPILING_EMULATOR=$(command -v qemu-aarch64);-L;$sysroot" "${cross_options[@]}" \
            -DSVOCL_SAMPLES=OFF -DSVOCL_WERROR=ON
    quietly "$folder/build.log" cmake --build "$folder/svocl" -j "$jobs" --target svocl_program \
        "${cross_arm64_tests[@]}"
    pattern=$(
        IFS='|'
        printf '^(%s)$' "${cross_arm64_tests[*]}"
    )
    ctest --test-dir "$folder/svocl" -R "$pattern" --no-tests=error --output-on-failure --timeout "$test_seconds"
    "$(command -v qemu-aarch64)" -L "$sysroot" "$folder/svocl/bin/svocl" --version
    printf 'cross: arm64: the program links, and %d tests pass under QEMU\n' "${#cross_arm64_tests[@]}"
}

cross()
{
    case ${1:-} in
    windows | arm64) "cross_$1" ;;
    *)
        usage >&2
        exit 2
        ;;
    esac
}
