# shellcheck shell=bash
# SPDX-License-Identifier: MIT
#
# `tools/dev asan`, `tools/dev tsan` and `tools/dev coverage`: the tests on libraries that watch themselves run. The
# presets of CMakePresets.json say how they are built, tools/suppressions which findings in other libraries are left
# out. tools/dev sources this file, which uses its functions and settings.
# shellcheck disable=SC2154

readonly build_coverage=build-coverage
readonly suppressions=$root/tools/suppressions
readonly coverage_minimum=97 # percent of lines

# What `asan` and `tsan` run without arguments, in minutes: files and arrays from outside, builds that wait and builds
# that do not, rays, OpenGL, failing drivers, threads, paging.
readonly instrumented_tests=(fuzz_seeds_file fuzz_seeds_mesh test_file test_workspace test_bad_driver test_threads
    test_paged_threads)

# configure_preset PRESET [OPTION...]: as `configure`, into the preset's folder.
configure_preset()
{
    local folder=build-$1
    [[ -e $folder/build.ninja ]] && return 0
    mkdir -p "$folder"
    quietly "$folder/configure.log" cmake --preset "$@"
}

# instrumented PRESET PREFIX... -- [CTEST ARGUMENT...]: builds and runs the seven tests, or those that the arguments
# select. PREFIX is a command that runs ctest. oclgrind loads a library of its own first, where a sanitizer must be.
instrumented()
{
    local preset=$1 prefix=() targets=() options=() selected
    shift
    while [[ $1 != -- ]]; do
        prefix+=("$1")
        shift
    done
    shift
    if (($# == 0)); then
        selected=$(printf '|%s' "${instrumented_tests[@]}")
        set -- -R "^(${selected:1})\$"
        targets=(--target "${instrumented_tests[@]}")
        # Optimized code takes longer to compile than it saves these tests. A build that is here already serves as well.
        options=(-DCMAKE_C_FLAGS_RELEASE=-O0 -DCMAKE_CXX_FLAGS_RELEASE=-O0)
    fi
    setup
    configure_preset "$preset" "${options[@]}"
    quietly "build-$preset/build.log" cmake --build "build-$preset" -j "$jobs" "${targets[@]}"
    prepare_run_time
    "${prefix[@]}" ctest --test-dir "build-$preset" --output-on-failure --no-tests=error --timeout 1800 -j 2 \
        -E oclgrind "$@"
}

asan()
{
    export ASAN_OPTIONS=detect_leaks=1:strict_string_checks=1
    export LSAN_OPTIONS=suppressions=$suppressions/leaks:print_suppressions=0
    export UBSAN_OPTIONS=print_stacktrace=1
    instrumented asan-ubsan env -- "$@"
}

# The addresses of a process must not be random: the sanitizer of Debian 12 does not know the layout of newer kernels.
tsan()
{
    export TSAN_OPTIONS=suppressions=$suppressions/threads:second_deadlock_stack=1
    instrumented tsan setarch "$(uname -m)" --addr-no-randomize -- "$@"
}

# Every test, then which lines of the libraries none of them ran.
coverage()
{
    local status=0
    setup
    configure_preset coverage
    quietly "$build_coverage/build.log" cmake --build "$build_coverage" -j "$jobs"
    find "$build_coverage" -name '*.gcda' -delete
    prepare_run_time
    export GCOV_ERROR_FILE=$root/$build_coverage/gcov.log # not standard error, which tests read
    ctest --test-dir "$build_coverage" --output-on-failure --no-tests=error --timeout "$test_seconds" -j 2 "$@" ||
        status=$?
    mkdir -p "$build_coverage/report"
    printf 'lines that no test runs: %s\n' "$root/$build_coverage/report/index.html"
    gcovr --root . --object-directory "$build_coverage" --filter lib/ --filter glinterop/ -j "$jobs" \
        --print-summary --fail-under-line "$coverage_minimum" --html-details "$build_coverage/report/index.html" \
        --txt "$build_coverage/report/lines.txt" "$build_coverage/lib" "$build_coverage/glinterop" \
        >"$build_coverage/report/summary" || status=$?
    grep '^lines' "$build_coverage/report/summary"
    return "$status"
}
