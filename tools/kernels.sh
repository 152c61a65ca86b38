# shellcheck shell=bash
# SPDX-License-Identifier: MIT
#
# `tools/dev check`: each kernel file alone, under each set of defines, compiles without a warning; and for GPUs of
# NVIDIA and AMD its kernels keep within the private memory (the stack) that tools/kernel_stacks.txt allows them.
# `tools/dev stacks [NAME...]` prints what they take, and their registers. tools/dev sources this file, which uses its
# functions and settings.
# shellcheck disable=SC2154

readonly stack_limits=tools/kernel_stacks.txt
readonly stack_targets="nvptx64 amdgcn" libclc=/usr/lib/clc
# What selects the kernels of CPUs.
readonly cpu_defines='PAIR_LANES COLUMN_LANES ONE_WORKER SORT_SERIAL BVH_SERIAL CAST_TILES RAY_STREAMS LANES_APART'

# Lines of a kernel file, a tab and the names of defines without their SVO_: all that are checked, also those that
# change nothing in the file. No kernel uses all of its helpers. These two always have rays that are no camera's.
all_variants()
{
    listed_variants | sed -E '/^kernels\/light\/(gather_rays|shade)\.cl/s/$/ LIT_LEAVES/'
}

listed_variants()
{
    local lists='RANGES LISTS' names form picture='PICTURE_TRIANGLES COLOR NORMAL FINISHES'
    local by_rays=' PICTURE_SCREEN EMITTERS SKY_MAP SKY_AIMS LIT_MESH NORMAL_MAPS GATHER_ERRORS'
    for names in "$lists COMPARE COLOR NORMAL FILL MATERIAL LONG_LEAVES WEIGHTS_AREA" \
        "$lists ORDER CODE48 COLOR VERTEX_COLOR TEXTURE NORMAL VERTEX_NORMAL WEIGHTS_CENTER AREAS" \
        'COLOR NORMAL WEIGHTS_AREA AREAS' 'SORT SORT_SERIAL BVH_SERIAL NO_TEST CAST_TILES RAY_STREAMS COLOR NORMAL' \
        'COLOR VERTEX_COLOR TEXTURE NORMAL VERTEX_NORMAL WEIGHTS_AREA AREAS PAIR_LANES' \
        'COLOR NORMAL CODE48 WEIGHTS_CENTER PAIR_LANES' 'NARROW COLUMN_LANES ONE_WORKER COUNT_HITS' \
        'NARROW COLUMN_LANES CODE48' 'NARROW THIN' 'WIDE CODE48' 'WIDE CODE48 THIN'; do
        # Kernels that read light need a form.
        find kernels -name '*.cl' -printf "%p\t$names LIGHT_FACES\n"
    done
    # What compact trees are read by.
    for form in READ_{DESCRIPTOR,IMPLIED,SHARED,MIRRORED}{,' HAS_BASES'}; do
        printf "%s\tCOLOR NORMAL $form\n" kernels/rays/{render,trace_voxels,view}.cl \
            kernels/scene/{bounds,render,trace}.cl kernels/compact/expand.cl
        printf '%s\t%s RAY_STREAMS\n' kernels/rays/trace_voxels.cl "$form"
        printf 'kernels/scene/trace.cl\t%s RAY_STREAMS LANES_APART\n' "$form"
    done
    # Rays and hits by field.
    printf 'kernels/rays/trace.cl\tRAY_FIELDS%s\n' '' ' RAY_STREAMS' ' COUNT_HITS'
    # Packed payload.
    printf 'kernels/compact/unpack.cl\tPACKED\n'
    names='COLOR NORMAL PACKED_COLOR PACKED_NORMAL READ_SHARED HAS_BASES'
    printf '%s\n' kernels/rays/{render,view}.cl$'\t'"$names"{,' CAST_TILES'}
    printf '%s\n' kernels/scene/{render,see}.cl$'\tPACKED READ_SHARED HAS_BASES'{,' CLEAR_NODES',' RAY_STREAMS'}
    # Pictures of scenes are of voxels.
    printf 'kernels/scene/trace.cl\t%s\n' SCENE_TRIANGLES 'SCENE_TRIANGLES RAY_STREAMS' 'RAY_STREAMS LANES_APART'
    # What of a scene shows in part.
    printf '%s\n' kernels/scene/{render,see}.cl$'\tCLEAR_NODES'{,' READ_IMPLIED HAS_BASES',' RAY_STREAMS'}
    # What probes and photons see of it.
    printf '%s\tCLEAR_NODES\n' kernels/{probes/clear,light/voxel_photons}.cl
    # Rays through probes under a map.
    printf 'kernels/probes/trace.cl\tSKY_MAP\n'
    # What paged trees are read by.
    printf "%s\tCOLOR NORMAL READ_PAGED\n" kernels/rays/{render,view}.cl
    # What edits are read by.
    printf '%s\n' kernels/rays/render.cl$'\tCOLOR READ_EDIT'{,' CAST_TILES'}
    # What light is stored in.
    for form in LIGHT_{FACES,BRICKS,VOXELS}{,' LIGHT_AREA',' LIGHT_LOBES',{,"$by_rays"}" $picture",' ONE_WORKER'}; do
        find kernels/light -name '*.cl' -printf "%p\t$form\n"
    done
    # Paths that aim.
    printf "%s\tLIGHT_FACES $picture${by_rays/ GATHER_ERRORS/}\n" kernels/light/gather_rays.cl
    # Cones alone, in trees of one color, normal and material.
    form="LIGHT_FACES GATHER_CONES $picture ONE_COLOR ONE_NORMAL ONE_MATERIAL"
    find kernels/light -name '*.cl' -printf "%p\t$form\n"
}

# Lines of a kernel file and the words in it and in what it includes.
kernel_words()
{
    find kernels -name '*.cl' -print0 | xargs -0 clang -x cl -target spir64 -Iinclude -Ikernels -MM -w |
        sed -e ':more; /\\$/ { N; s/\\\n//; b more }' | while read -r _ file files; do
        # shellcheck disable=SC2086 # one word per file
        printf '%s %s\n' "$file" "$(grep -ohE '\<SVO_[A-Z0-9_]+' "$file" $files | sort -u | tr '\n' ' ')"
    done
}

# Lines of all_variants with the defines that the file asks for, each once.
kernel_variants()
{
    awk 'NR == FNR { for (i = 2; i <= NF; ++i) known[$1, $i]; next }
        {
            defines = ""
            for (i = 2; i <= NF; ++i) if (($1, "SVO_" $i) in known) defines = defines " " $i
            print $1 "\t" substr(defines, 2)
        }' <(kernel_words) <(all_variants) | sort -u
}

# A line of kernel_variants as a device without svocl around it would see it, after the precompiled built-in functions.
check_variant()
{
    local file=${1%%$'\t'*} name defines=()
    for name in ${1#*$'\t'}; do
        defines+=("-DSVO_$name")
    done
    # shellcheck disable=SC2086 # one word per option
    clang $builtin_options -include-pch "$builtins" -fsyntax-only -Wall -Wextra -Wno-unused-function -Werror -Iinclude \
        -Ikernels "${defines[@]}" "$file"
}

# Names of defines without a value that the library gives to kernels, and that no variant has.
find_unchecked_defines()
{
    comm -23 <(sources c | grep -z -E '^(lib|glinterop)/' |
        xargs -0 grep -h -o -P -- '-DSVO_\K[A-Z0-9_]{2,}\b(?!=)' | sort -u) \
        <(all_variants | cut -f 2 | tr ' ' '\n' | sort -u)
}

# Places where a condition chooses between max() or min() of a number and another operation on it. Some versions of
# Intel's driver for CPUs compile that wrongly for 64-bit numbers; svo_reduce of kernels/plan/plan.clh is right in all.
find_chosen_maxima()
{
    local number='[\w.>\[\]-]+'
    local first="\\?\\s*(?:max|min)\\(\\s*($number)\\s*,[^;?]*\\)\\s*:\\s*\\1\\s*[-+*/|&^]"
    local second="\\?\\s*($number)\\s*[-+*/|&^][^;?:]*:\\s*(?:max|min)\\(\\s*\\2\\s*,"
    sources cl clh | xargs -0 grep -H -z -o -P "$first|$second" | tr '\0' '\n' || true # xargs fails where there is none
}

# Functions that have barriers, or call such, and are not SVO_INLINED (kernels/shared/calls.clh).
find_called_barriers()
{
    # shellcheck disable=SC2016 # of awk
    sources cl clh | xargs -0 awk '
        /^(static|SVO_CALLED|SVO_INLINED) .*\(/ {
            match($0, /svo_[a-z0-9_]+\(/)
            name = substr($0, RSTART, RLENGTH - 1)
            place[name] = FILENAME ":" FNR ": " name
            is_inlined[name] = /^SVO_INLINED/
        }
        /^__kernel/ || /^}/ { name = "" }
        name != "" && /[^a-z_]barrier\(/ { meets[name] = 1 }
        name != "" {
            for (rest = $0; match(rest, /svo_[a-z0-9_]+\(/); rest = substr(rest, RSTART + RLENGTH)) {
                calls[name, substr(rest, RSTART, RLENGTH - 1)] = 1
            }
        }
        END {
            do {
                found = 0
                for (call in calls) {
                    split(call, pair, SUBSEP)
                    if (pair[2] in meets && !(pair[1] in meets)) {
                        meets[pair[1]] = found = 1
                    }
                }
            } while (found)
            for (name in meets) if (!is_inlined[name]) print place[name]
        }'
}

# tools/scalar_bounds.clh refuses what oclgrind 21 gets wrong. And no local array of a kernel's own: PoCL 3.1 puts some
# of them into static storage that its threads share, with wrong results now and then. Local memory comes as an
# argument.
check_kernels()
{
    if find_unchecked_defines | grep .; then
        printf 'defines of kernels that all_variants does not have\n'
        return 1
    fi
    if find_called_barriers | grep .; then
        printf 'functions with barriers that are not SVO_INLINED\n'
        return 1
    fi
    if find_chosen_maxima | grep .; then
        printf 'a condition chooses between max() or min() and another operation; write a comparison (svo_reduce)\n'
        return 1
    fi
    if sources cl clh | xargs -0 grep -n -E '__local [^()*=]*\[.*\] *[;=]'; then
        printf 'local arrays declared in kernels; make them arguments\n'
        return 1
    fi
    local builtins=$build_clang/builtins.pch
    local builtin_options='-x cl -cl-std=CL1.2 -target spir64 -cl-no-stdinc -Xclang -finclude-default-header'
    mkdir -p "$build_clang"
    # shellcheck disable=SC2086
    clang $builtin_options -fsyntax-only -Xclang -emit-pch -Xclang -o -Xclang "$builtins" tools/scalar_bounds.clh ||
        return 1
    export -f check_variant
    export builtins builtin_options
    # shellcheck disable=SC2016 # expanded by the inner shell
    kernel_variants | tr '\n' '\0' | xargs -0 -n 1 -P "$jobs" bash -c 'check_variant "$1" || exit 255' check
}

# --- private memory --------------------------------------------------------------------------------------------------

# Lines of kernel_variants for GPUs, without what selects the kernels of CPUs.
gpu_variants()
{
    kernel_variants | sed -E "s/ (${cpu_defines// /|})\>//g; s/\t(${cpu_defines// /|}) */\t/" | sort -u
}

# Of each file only the lines whose defines no other line has all of, since defines add to a kernel. All but two of the
# kernels take the most by these lines, and those 2 % less than by the others.
largest_variants()
{
    gpu_variants | awk -F '\t' '
        function is_within(a, b,    words, count, i) {
            count = split(a, words, " ")
            for (i = 1; i <= count && index(" " b " ", " " words[i] " "); ++i) { }
            return i > count
        }
        { file[NR] = $1; defines[NR] = $2 }
        END {
            for (i = 1; i <= NR; ++i) {
                covered = 0
                for (k = 1; k <= NR; ++k) {
                    covered += k != i && file[k] == file[i] && is_within(defines[i], defines[k])
                }
                if (!covered) print file[i] "\t" defines[i]
            }
        }'
}

# Of files that shade pictures, whose lines take clang up to twelve seconds each, the lines with bricks alone: the
# others take at most 3 % more private memory. `tools/dev long` checks all of largest_variants.
quick_variants()
{
    largest_variants | awk -F '\t' '
        { line[NR] = $0; file[NR] = $1; bricks[NR] = $2 ~ /LIGHT_BRICKS (PICTURE_SCREEN )?SKY_MAP.*LIT_MESH/ }
        bricks[NR] { has_bricks[$1] }
        END { for (i = 1; i <= NR; ++i) if (bricks[i] || !(file[i] in has_bricks)) print line[i] }'
}

# Options of clang for a target: NVIDIA's GPUs from Volta on, and AMD's gfx906 by a driver for which scratch is printed.
stack_options()
{
    case $1 in
    nvptx64)
        printf '%s\n' -target nvptx64--nvidiacl -Xclang -target-cpu -Xclang sm_70 -Xclang -target-feature \
            -Xclang +ptx60 -Xclang -mlink-builtin-bitcode -Xclang "$libclc/nvptx64--nvidiacl.bc"
        ;;
    amdgcn)
        printf '%s\n' -target amdgcn-mesa-mesa3d -mcpu=gfx906 -Xclang -mlink-builtin-bitcode \
            -Xclang "$libclc/gfx906-amdgcn-mesa-mesa3d.bc"
        ;;
    esac
}

# Lines of each kernel of an assembly file and the bytes of private memory of a work-item. AMD's files tell what a
# kernel takes with all that it calls; NVIDIA's tell the frame and the calls of each function, and none calls itself.
read_stacks()
{
    case $1 in
    nvptx64)
        awk 'function total(name,    most, i, bytes) {
                most = 0
                for (i = 0; i < calls[name]; ++i) {
                    bytes = total(called[name, i])
                    if (bytes > most) most = bytes
                }
                return frame[name] + most
            }
            /\.(entry|func)/ { is_kernel = /\.entry/; name = ""; sub(/.*\.(entry|func) */, "") }
            name == "" && match($0, /[A-Za-z_$][A-Za-z0-9_$]*\($/) {
                name = substr($0, RSTART, RLENGTH - 1)
                if (is_kernel) kernels[name]
            }
            /__local_depot[0-9]+\[/ { sub(/.*\[/, ""); frame[name] = int($0) }
            /^\tcall/ { in_call = 1 }
            in_call && /^\t[A-Za-z_$][A-Za-z0-9_$]*, *$/ {
                called[name, calls[name]++] = substr($1, 1, length($1) - 1)
                in_call = 0
            }
            END { for (kernel in kernels) print kernel, total(kernel) }'
        ;;
    amdgcn) awk '/-- Begin function/ { name = $NF } /^; ScratchSize: / && name ~ /^svo_k_/ { print name, $NF }' ;;
    esac
}

# read_registers TARGET FILE FIRST: lines of FIRST, a GPU, each kernel of an assembly file and its registers, vector
# registers on AMD's. NVIDIA's files name registers without limit; ptxas gives them those of a GPU.
read_registers()
{
    local gpu
    if [[ $1 == amdgcn ]]; then
        awk -v first="$3" '/-- Begin function/ { name = $NF }
            /^; NumVgprs: / && name ~ /^svo_k_/ { print "gfx906", first, name, $NF }
            /^; Occupancy: / && name ~ /^svo_k_/ { print "waves", first, name, $NF }' "$2"
        return
    fi
    for gpu in $ptxas_gpus; do
        ptxas -v -arch "$gpu" -o /dev/null "$2" 2>&1 | awk -v first="$gpu $3" -F "'" '
            /Compiling entry function/ { name = $2 }
            match($0, /Used [0-9]+ registers/) { print first, name, substr($0, RSTART + 5) + 0 }'
    done
}

# measure_variant FOLDER "FILE<tab>DEFINES" compiles a file for each target, where FOLDER does not have the result yet,
# and prints the names of the results. They are named by hashes of the preprocessed text, the options and what reads the
# assembly, since many defines change nothing in a file.
measure_variant()
{
    local folder=$1 file=${2%%$'\t'*} name target text hash options result
    local compile=(clang -x cl -cl-std=CL1.2 -Werror -Iinclude -Ikernels)
    for name in ${2#*$'\t'}; do
        compile+=("-DSVO_$name")
    done
    text=$("${compile[@]}" -target nvptx64--nvidiacl -E -P -o - "$file") || return 1
    for target in $stack_targets; do
        mapfile -t options < <(stack_options "$target")
        hash=$(printf '%s' "$clang_version ${options[*]} $ptxas_gpus $stack_reader $text" | sha256sum)
        result=$folder/${hash%% *}
        if [[ ! -e $result ]]; then
            "${compile[@]}" "${options[@]}" -O2 -S -o "$result.$$.s" "$file" &&
                read_stacks "$target" <"$result.$$.s" | sed "s,^,$target ${file#kernels/} ," >"$result.$$" &&
                read_registers "$target" "$result.$$.s" "${file#kernels/}" >>"$result.$$" &&
                rm "$result.$$.s" && mv "$result.$$" "$result" || return 1
        fi
        printf '%s\n' "$result"
    done
}

# Lines of a kernel's file, its name and, under any defines, the most bytes of private memory that it takes on each
# target; then the most registers on GPUs of ptxas_gpus, 0 without it, and on gfx906, and the fewest waves there, of 10
# for each SIMD. Arguments: which prints the variants; parts of names of files, none means all.
kernel_stacks()
{
    local variants=$1
    shift
    local folder=$root/$build/stacks clang_version stack_reader
    clang_version=$(clang --version | head -n 1)
    stack_reader=$(declare -f read_stacks read_registers)
    mkdir -p "$folder"
    export -f measure_variant stack_options read_stacks read_registers
    export clang_version stack_reader stack_targets ptxas_gpus libclc
    # shellcheck disable=SC2016 # expanded by the inner shell
    "$variants" | grep -F "$(printf '%s\n' "${@:-.cl}")" | tr '\n' '\0' |
        xargs -0 -n 1 -P "$jobs" bash -o pipefail -c 'measure_variant "$1" "$2" || exit 255' measure "$folder" |
        sort -u | xargs cat | awk '
            { kernel = $2 " " $3; kernels[kernel]; number = $1 == "waves" ? 10 - $4 : $4 }
            number > most[kernel, $1] { most[kernel, $1] = number }
            END {
                for (kernel in kernels) {
                    print kernel, most[kernel, "nvptx64"] + 0, most[kernel, "amdgcn"] + 0, most[kernel, "sm_75"] + 0,
                        most[kernel, "sm_90"] + 0, most[kernel, "gfx906"] + 0, 10 - most[kernel, "waves"]
                }
            }' |
        sort
}

# Occupancy is the share of a GPU's places for groups that registers leave; local memory, which the host gives, is left
# out. NVIDIA's GPUs have 65536 registers for 32 warps on sm_75 and 64 on sm_90; a warp takes them in pieces of 256, and
# a group of SVO_GROUP_ITEMS is two warps.
stacks()
{
    local ptxas_gpus='sm_75 sm_90'
    setup
    if ! command -v ptxas >/dev/null; then
        ptxas_gpus=
        say "stacks: without ptxas, of CUDA's tools, no registers of NVIDIA's GPUs"
    fi
    kernel_stacks gpu_variants "$@" | awk '
        function occupancy(registers, warps,    room) {
            if (registers == 0) return "-"
            room = 2 * int(65536 / (2 * 256 * int((registers + 7) / 8)))
            return int(100 * (room < warps ? room : warps) / warps) "%"
        }
        BEGIN {
            row = "%-22s %-32s %7s %7s %6s %6s %6s %6s %6s %6s\n"
            printf row, "", "", "bytes", "bytes", "regs", "", "regs", "", "VGPRs", ""
            printf row, "file", "kernel", "nvptx64", "amdgcn", "sm_75", "busy", "sm_90", "busy", "gfx906", "busy"
        }
        {
            printf row, $1, $2, $3, $4, $5, occupancy($5, 32), $6, occupancy($6, 64), $7, 10 * $8 "%"
        }'
}

# check_stacks [VARIANTS]: lines of kernel_stacks against the table of limits.
check_stacks()
{
    local ptxas_gpus=
    kernel_stacks "${1:-quick_variants}" | awk -v limits="$stack_limits" '
        function wrong(words) { print limits ": " words; failed = 1 }
        NR == FNR {
            if ($0 ~ /^#|^$/) next
            if ($1 != "*" && NF < 5) wrong($2 " gives no reason")
            kernel = $1 " " $2; nvptx64[kernel] = $3; amdgcn[kernel] = $4
            next
        }
        {
            kernel = $1 " " $2; line = kernel in nvptx64 ? kernel : "* *"; seen[kernel]
            if ($3 > nvptx64[line]) wrong(kernel " takes " $3 " bytes on nvptx64, above " nvptx64[line])
            if ($4 > amdgcn[line]) wrong(kernel " takes " $4 " bytes on amdgcn, above " amdgcn[line])
            if (line == kernel && $3 <= nvptx64["* *"] && $4 <= amdgcn["* *"]) wrong(kernel " needs no line")
        }
        END {
            for (kernel in nvptx64) if (kernel != "* *" && !(kernel in seen)) wrong("there is no kernel " kernel)
            exit failed
        }' "$stack_limits" -
}
