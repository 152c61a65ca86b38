# shellcheck shell=bash
# SPDX-License-Identifier: MIT
#
# OpenCL drivers besides PoCL on this machine: Intel's for CPUs, which pip brings. `tools/dev setup --drivers` installs
# it, `tools/dev foreign` runs a part of the tests by it, `tools/dev matrix` compares it with others. tools/dev sources
# this file, which uses its functions and settings.
# shellcheck disable=SC2154

# Intel's driver, and the libraries of numbers that its kernels call: packages of PyPI. With what they need, 276 MB to
# download and 830 MB on disk.
readonly intel_packages=(intel-opencl-rt==2026.2.0 intel-cmplr-lib-rt==2026.2.0)
readonly intel_folder=$build_drivers/intel

# A virtual environment, which is used again until the list of packages changes.
setup_intel()
{
    [[ $(cat "$intel_folder/packages" 2>/dev/null) != "${intel_packages[*]}" ]] || return 0
    setup python3-venv
    say "tools/dev: installing ${intel_packages[*]} into $root/$intel_folder"
    rm -rf "$intel_folder"
    mkdir -p "$intel_folder/vendors"
    quietly "$build_drivers/intel.log" python3 -m venv "$intel_folder"
    quietly "$build_drivers/intel.log" "$intel_folder/bin/pip" install --no-cache-dir --only-binary :all: \
        "${intel_packages[@]}"
    printf '%s\n' "${intel_packages[*]}" >"$intel_folder/packages"
}

# The words before a command that runs by Intel's driver alone, one per line: the folder of vendors is empty. Freed
# memory is overwritten, so that a compiler that reads it fails each time (tests/drivers/barriers.c).
intel_runner()
{
    printf '%s\n' env MALLOC_PERTURB_=165 OCL_ICD_VENDORS="$root/$intel_folder/vendors" \
        OCL_ICD_FILENAMES="$root/$intel_folder/lib/libintelocl.so" LD_LIBRARY_PATH="$root/$intel_folder/lib"
}

# --- a part of the tests ---------------------------------------------------------------------------------------------

# As in tools/matrix.sh. Each run compiles for five to ten seconds, so there are few: every stage by every builder and
# the kernels of each path; a plan by kernels; light; hits; a session of edits.
readonly foreign_case="scene:cornell:60 -d 4 --need $matrix_all"
readonly foreign_plan="scene:knot:140000 -d 5 --need normal"
readonly foreign_light="scene:cornell:60 -d 4 --need color,rays,fill --light bricks"
readonly foreign_trace="scene:cornell:60 -d 4 --camera auto --size 24x16"
# A path, "cpu" or "gpu", a test program, and a group and a case of it if it has such.
readonly foreign_tests=(
    "cpu test_bvh bvh *"
    "gpu test_bvh bvh *"
    "cpu test_plan_device plan_buffers *"
    "cpu test_rays trace one_voxel_covers_its_pixels" # uploaded on an out-of-order queue
    "cpu test_edit edit commits_are_builds"
    "gpu test_edit edit mirrors_show_what_is_committed"
    "cpu driver_barriers"
)

# Prints what a test says where it fails.
foreign_test()
{
    local path=$1 test=$2 log=$build_drivers/test.log runner
    shift 2
    mapfile -t runner < <(intel_runner)
    if "${runner[@]}" SVOCL_TEST_PATH="$path" "$build/tests/$test" "$@" >"$log" 2>&1; then
        printf '  %-70s %9s\n' "$test${*:+ $*}, $path" passed
        return 0
    fi
    printf '  %-70s %9s\n' "$test${*:+ $*}, $path" FAILED
    cat "$log"
    return 1
}

foreign()
{
    # shellcheck disable=SC2034 # of matrix_row
    local columns=("PoCL 3.1" Intel)
    local case failed=0
    build
    prepare_run_time
    if ! (setup_intel); then
        say "foreign: skipped: pip could not install ${intel_packages[*]}"
        return 77
    fi
    matrix_case - no "$foreign_case" "${matrix_methods[@]}"
    matrix_case - no "$foreign_plan" "cl cl cpu"
    matrix_case - no "$foreign_light" "cl cl cpu"
    matrix_case - no "$foreign_trace" "${matrix_hits[@]}"
    matrix_case - no "${matrix_edits[0]}" "${matrix_sessions[0]}"
    set -f # no word of a case names files
    for case in "${foreign_tests[@]}"; do
        # shellcheck disable=SC2086 # words
        foreign_test $case || failed=1
    done
    set +f
    if ((${#matrix_wrong[@]} > 0)); then
        printf 'foreign: these differ:\n'
        printf '  %s\n' "${matrix_wrong[@]}"
        failed=1
    fi
    ((failed == 0)) || return 1
    printf 'foreign: hashes and hits are equal, tests pass\n'
}
