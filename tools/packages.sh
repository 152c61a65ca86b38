# shellcheck shell=bash
# SPDX-License-Identifier: MIT
#
# `tools/dev deb`: the Debian packages and the Python wheel, and whether they install and run in a clean Debian 12.
# `tools/dev bare`: demo and test of a clone in a clean Debian 12. `tools/dev recipe`: the recipe of docs/ci.md in one.
# `tools/dev oldest_cmake`: whether the oldest CMake suffices. `tools/dev conan`: the recipe for Conan. `tools/dev abi`:
# whether the ABI is that of the last release. tools/dev sources this file, which uses its functions and settings.
# shellcheck disable=SC2154

readonly build_deb=build-deb
readonly build_ci=build-ci # as in docs/ci.md
readonly build_cmake=build-cmake
readonly build_conan=build-conan
readonly build_abi=build-abi

# wheel FOLDER: the Python package as a wheel there. pip brings what builds it.
wheel()
{
    local venv=$build_deb/venv
    [[ -x $venv/bin/pip ]] || quietly "$build_deb/venv.log" python3 -m venv "$venv"
    quietly "$build_deb/wheel.log" "$venv/bin/pip" wheel --no-deps --wheel-dir "$1" \
        --config-settings=build-dir="$root/$build_deb/python" "$root/python"
}

# What makes clean roots; without root or sudo the tests in them are skipped.
setup_debootstrap()
{
    if ((EUID == 0)) || command -v sudo >/dev/null; then
        setup debootstrap
    fi
}

deb()
{
    local folder=${1:-$build_deb/debian} mirror=${2:-}
    setup
    configure_preset deb
    quietly "$build_deb/build.log" cmake --build "$build_deb" -j "$jobs"
    rm -rf "$build_deb/packages"
    quietly "$build_deb/cpack.log" cpack --config "$build_deb/CPackConfig.cmake" -B "$root/$build_deb/packages"
    rm -rf "$build_deb/packages/_CPack_Packages"
    lintian --allow-root --fail-on error "$build_deb"/packages/*.deb
    wheel "$build_deb/packages"
    ls -s --block-size=K "$build_deb"/packages/*.{deb,whl}
    prepare_run_time
    setup_debootstrap
    tests/install/debian_root.sh "$build_deb/packages" "$build_deb/bin/svocl" "$folder" ${mirror:+"$mirror"}
}

bare()
{
    setup_debootstrap
    tests/install/bare_root.sh "${1:-$build_deb/debian}" "${@:2}"
}

# Makes the package by the lines of docs/ci.md.
recipe()
{
    local lines
    setup "${program_packages[@]}" python3-yaml
    setup_debootstrap
    lines=$(sed -n '/^cmake -B build-ci/,/^cpack/p' docs/ci.md)
    mkdir -p "$build_ci"
    quietly "$build_ci/package.log" bash -e -c "${lines/%packages/$build_ci/packages}"
    tests/install/recipe_root.sh "$build_ci/packages" "${1:-$build_deb/debian}" "${@:2}"
}

oldest_cmake()
{
    setup
    prepare_run_time
    tests/install/oldest_cmake.sh "$build_cmake"
}

conan()
{
    setup "${program_packages[@]}"
    prepare_run_time
    tests/install/conan.sh "$build_conan"
}

# abi [COMMIT]: beside the last tag.
abi()
{
    local commit=${1:-}
    if [[ -z $commit ]] && ! commit=$(git describe --tags --abbrev=0 2>/dev/null); then
        printf 'abi: there is no tag, thus no release to compare with; tools/dev abi COMMIT compares with a commit\n'
        return 77
    fi
    setup "${program_packages[@]}" abigail-tools
    tests/install/abi.sh "$build_abi" "$commit"
}
