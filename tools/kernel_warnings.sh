#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
#
# The kernels compile without a warning for processors with narrow and with wide vectors. PoCL prints "10 warnings
# generated." where the vectors of a kernel are wider than the processor's; code must be generated to see them.
#
# usage: kernel_warnings.sh, in the repository's root
set -euo pipefail

compile()
{
    # shellcheck disable=SC2086 # words
    clang -x cl -cl-std=CL1.2 -target x86_64-pc-linux-gnu -Xclang -finclude-default-header -Dcl_khr_fp64 -O0 -S \
        -emit-llvm -o /dev/null -Iinclude -Ikernels -Werror $1
}

# Lines of options and a file.
list_variants()
{
    local processor kernel form
    for processor in x86-64 haswell; do
        for kernel in stages/scan stages/subdivide stages/voxelize stages/filter rays/nearest rays/render rays/trace \
            rays/trace_voxels rays/view compact/expand compact/gather compact/implied compact/minimize \
            compact/payload compact/places compact/sizes compact/words plan/attributes plan/classify plan/closed \
            plan/keep plan/snap plan/tiles plan/views bvh/collapse bvh/corners bvh/items bvh/leaves bvh/morton \
            bvh/refit bvh/split bvh/subtree; do
            printf '%s' "-march=$processor -DSVO_RANGES -DSVO_LISTS -DSVO_SORT -DSVO_COMPARE -DSVO_COLOR -DSVO_NORMAL" \
                ' -DSVO_FILL -DSVO_WEIGHTS_AREA -DSVO_PAIR_LANES -DSVO_RAY_STREAMS -DSVO_CAST_TILES -DSVO_NARROW' \
                " -DSVO_COLUMN_LANES -DSVO_ONE_WORKER kernels/$kernel.cl"
            printf '\n'
        done
        for form in DESCRIPTOR IMPLIED SHARED MIRRORED; do
            for kernel in rays/render rays/trace_voxels rays/view compact/expand; do
                printf '%s' "-march=$processor -DSVO_COLOR -DSVO_NORMAL -DSVO_READ_$form" \
                    " -DSVO_HAS_BASES kernels/$kernel.cl"
                printf '\n'
            done
        done
    done
}

export -f compile
# shellcheck disable=SC2016 # expanded by the inner shell
list_variants | tr '\n' '\0' | xargs -0 -n 1 -P "$(nproc)" bash -c 'compile "$1"' compile
