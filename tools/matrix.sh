# shellcheck shell=bash
# SPDX-License-Identifier: MIT
#
# `tools/dev matrix`: the same scenes and rays by several OpenCL implementations; hashes and hits must be equal. On this
# machine (Debian 12): PoCL 3.1, Intel's driver for CPUs (tools/drivers.sh) and, for small scenes, oclgrind. In a Debian
# 13 root created by debootstrap: PoCL 6 and Mesa's rusticl, with svocl compiled there by the compiler of that release.
# tools/dev sources this file, which uses its functions and settings.
# shellcheck disable=SC2154

readonly matrix_release=trixie
readonly matrix_mirror=http://deb.debian.org/debian

# Debian 13 packages that svocl needs to build and run, without the tools that only check it.
readonly matrix_packages=(
    build-essential cmake ninja-build pkg-config ocl-icd-opencl-dev opencl-headers libegl-dev libgl-dev libosmesa6-dev
    libegl1 libegl-mesa0 libgl1-mesa-dri libosmesa6 libassimp-dev zlib1g-dev libstb-dev libxxhash-dev libzstd-dev
    libcjson-dev libcmocka-dev libfast-float-dev libgmp-dev
    pocl-opencl-icd # PoCL 6
    mesa-opencl-icd # rusticl
)

# A case is the arguments of `svocl hash`. Small cases also run on oclgrind, an interpreter.
readonly matrix_all=color,normal,rays,material,fill,projected-area
readonly matrix_small_cases=(
    "scene:cornell:60 -d 4 --need $matrix_all"
    "scene:knot:200 -d 5 --need $matrix_all"
    "scene:knot:200 -d 5 --need color,normal,rays,projected-area --light faces"
    "scene:knot:200 -d 5 --need color,rays,fill,projected-area --light bricks"
    "scene:knot:200 -d 5 --need color,rays,fill --light voxels"
    "scene:cornell:60 -d 4 --need rays --probes 1,1,1 --probe-resolution 64 --probe-field 16"
)
readonly matrix_cases=(
    "scene:atrium -d 8 --need $matrix_all"
    "scene:statue:20000 -d 9 --need rays"
    "scene:terrain:20000 -d 8 --need color,normal --weights center"
    "scene:needles -d 8 --need none --coverage closed"
    "scene:dust -d 6 --need rays,normal --weights uniform"
    "scene:knot:5000 -d 11 --need none --coverage thin"
    "scene:atrium -d 8 --need color,normal,rays,projected-area --light faces"
    "scene:atrium -d 8 --need color,rays,fill,projected-area --light bricks"
    "scene:atrium -d 7 --need rays --probes 3,3,3 --probe-resolution 128"
    "scene:knot:140000 -d 7 --need $matrix_all" # enough triangles for a plan by kernels
)
# Front end, builder and whose kernels run: the device's, or another's.
readonly matrix_methods=("cl cl cpu" "cl cl gpu" "cl sorted cpu" "cl sorted gpu" "gl-expand cl cpu" "gl-expand cl gpu"
    "gl-expand gl-compute cpu")
readonly matrix_hits=("cl hits cpu" "cl hits gpu")
# Arguments of `svocl trace`; matrix_rays is on its standard input.
readonly matrix_small_traces=("scene:cornell:60 -d 4 --camera auto --size 24x16")
readonly matrix_traces=(
    "scene:atrium -d 6 --camera auto --size 320x240"
    "scene:knot:5000 -d 6 --rays /dev/stdin"
)
# Arguments of `svocl build`; matrix_session edits the tree, without kernels but for its mesh, and by a build of the
# edited voxels.
readonly matrix_edits=("scene:cornell:60 -d 4 --need color,material")
readonly matrix_session=tests/fuzz/seeds/edit/session.txt
readonly matrix_sessions=("cl edits cpu" "cl edits gpu")
readonly matrix_columns=("PoCL 3.1" "oclgrind" "Intel" "PoCL 6" "rusticl")

# --- the root --------------------------------------------------------------------------------------------------------

# Runs a command as root in a chroot of the folder; its mounts end with the command.
matrix_enter()
{
    local folder=$1
    shift
    # shellcheck disable=SC2016 # expanded by the inner shell
    as_root unshare --mount --propagation private bash -c '
        folder=$1
        shift
        mount -t proc proc "$folder/proc" && mount --rbind /dev "$folder/dev" && mount --rbind /sys "$folder/sys" &&
            mount -t tmpfs tmpfs "$folder/tmp" && mkdir -m 700 "$folder/tmp/runtime" &&
            exec env -i PATH=/usr/sbin:/usr/bin:/sbin:/bin HOME=/root XDG_RUNTIME_DIR=/tmp/runtime \
                DEBIAN_FRONTEND=noninteractive chroot "$folder" "$@"' matrix "$folder" "$@"
}

# An unfinished root has no mark and is created again. It inherits name servers and apt configuration from
# this machine.
matrix_make_root()
{
    local folder=$1 mirror=$2
    if [[ ! -e $folder/made ]]; then
        say "tools/dev: making a root of Debian $matrix_release in $folder"
        as_root rm -rf --one-file-system "$folder"
        mkdir -p "$folder"
        quietly "$folder.log" as_root debootstrap --variant=minbase "$matrix_release" "$folder" "$mirror"
        as_root touch "$folder/made"
    fi
    as_root cp /etc/resolv.conf /etc/hosts "$folder/etc/"
    apt-config dump Acquire | as_root tee "$folder/etc/apt/apt.conf.d/90acquire" >/dev/null
    if [[ $(cat "$folder/packages" 2>/dev/null) != "${matrix_packages[*]}" ]]; then
        quietly "$folder.log" matrix_enter "$folder" apt-get -q update
        quietly "$folder.log" matrix_enter "$folder" \
            apt-get -y -q install --no-install-recommends "${matrix_packages[@]}"
        printf '%s\n' "${matrix_packages[*]}" | as_root tee "$folder/packages" >/dev/null
    fi
}

# The working tree as it is, built with warnings as errors.
matrix_build()
{
    local folder=$1
    matrix_enter "$folder" rm -rf /svocl
    matrix_enter "$folder" mkdir /svocl
    tar --exclude=./.git --exclude='./build*' --exclude=./demo -cf - . |
        matrix_enter "$folder" tar -C /svocl --no-same-owner -xf -
    quietly "$folder.log" matrix_enter "$folder" \
        cmake -S /svocl -B /build -G Ninja -DCMAKE_BUILD_TYPE=Release -DSVOCL_WERROR=ON
    quietly "$folder.log" matrix_enter "$folder" cmake --build /build -j "$jobs"
}

# --- the hashes ------------------------------------------------------------------------------------------------------

# The words before `svocl` that select one implementation, one per line.
matrix_runner()
{
    local column=$1 folder=$2 vendors=/etc/OpenCL/vendors
    case $column in
    "PoCL 3.1") printf '%s\n' env OCL_ICD_VENDORS=$vendors/pocl.icd "$program" ;;
    # Without optimization: oclgrind 21.10 does not support everything that the optimizer emits.
    oclgrind)
        printf '%s\n' oclgrind --build-options -cl-opt-disable "$program"
        ;;
    Intel)
        intel_runner
        printf '%s\n' "$program"
        ;;
    "PoCL 6") printf '%s\n' matrix_enter "$folder" env OCL_ICD_VENDORS=$vendors/pocl.icd /build/bin/svocl ;;
    rusticl)
        # Ray intersections are decided in doubles, which rusticl offers only on request.
        printf '%s\n' matrix_enter "$folder" env OCL_ICD_VENDORS=$vendors/rusticl.icd RUSTICL_ENABLE=llvmpipe \
            RUSTICL_FEATURES=fp64 /build/bin/svocl
        ;;
    esac
}

# One hash by one implementation, or the error. Arguments: the name of the column, the root and those of `svocl hash`.
matrix_hash()
{
    local runner output
    mapfile -t runner < <(matrix_runner "$1" "$2")
    shift 2
    output=$("${runner[@]}" hash "$@" 2>&1) || output="exit code $?: ${output//$'\n'/ | }"
    printf '%s\n' "${output##*$'\n'}"
}

# A CSV file of rays in all directions, past the center of a scene of width 1. Random numbers by Park and Miller,
# "Random Number Generators: Good Ones Are Hard to Find", 1988.
matrix_rays()
{
    awk 'function within(reach) { state = state * 16807 % 2147483647; return (state / 1073741823.5 - 1) * reach }
        BEGIN {
            state = 1
            for (ray = 0; ray < 20000; ++ray) {
                x = within(2); y = within(2); z = within(2)
                printf "%.6f,%.6f,%.6f,%.6f,%.6f,%.6f\n", x, y, z, within(0.5) - x, within(0.5) - y, within(0.5) - z
            }
        }'
}

# A hash of the hits by one implementation, or the error. Arguments as for matrix_hash, but of `svocl trace`.
matrix_hits()
{
    local runner output
    mapfile -t runner < <(matrix_runner "$1" "$2")
    shift 2
    # shellcheck disable=SC2016 # expanded by the inner shell
    output=$("${runner[@]::${#runner[@]}-1}" sh -c '
        hits=$(mktemp --suffix=.csv) && "$0" trace "$@" -o "$hits" >&2 && md5sum <"$hits" && rm "$hits"' \
        "${runner[-1]}" "$@" 2>&1 < <(matrix_rays)) || output="exit code $?: ${output//$'\n'/ | }"
    output=${output##*$'\n'}
    printf '%s\n' "${output%  -}"
}

# A hash of the edited tree by one implementation, or the error. Arguments as for matrix_hash, but of `svocl build`.
matrix_edit()
{
    local runner output
    mapfile -t runner < <(matrix_runner "$1" "$2")
    shift 2
    # shellcheck disable=SC2016 # expanded by the inner shell
    output=$("${runner[@]::${#runner[@]}-1}" sh -c '
        program=$(realpath "$0") && path=${*##*--path } &&
            folder=$(mktemp -d) && trap "rm -rf $folder" EXIT && cd "$folder" && cat >session.txt &&
            "$program" scene knot:200 -q -o knot.obj >&2 && "$program" build "$@" -q -o tree.svo >&2 &&
            "$program" edit tree.svo session.txt --path "$path" -q -o edited.svo >&2 &&
            "$program" edit tree.svo session.txt --path "$path" --builder cl -q -o built.svo >&2 &&
            cmp edited.svo built.svo >&2 && md5sum <edited.svo' "${runner[-1]}" "$@" 2>&1 <"$matrix_session") ||
        output="exit code $?: ${output//$'\n'/ | }"
    output=${output##*$'\n'}
    printf '%s\n' "${output%  -}"
}

# Whether the column takes part: oclgrind is slow, has little memory, and cannot share a process with Mesa's llvmpipe.
matrix_takes_part()
{
    local column=$1 frontend=$2 is_small=$3
    [[ $column != oclgrind ]] || [[ $is_small == yes && $frontend == cl ]]
}

# One line of the table: a method to build, to trace with the builder "hits" or to edit with "edits", by the kernels
# of a path, and by each implementation of the caller's columns. All hashes of a case must equal the first; differences
# go to matrix_wrong.
matrix_wrong=()
matrix_expected=
matrix_row()
{
    local folder=$1 is_small=$2 case=$3 frontend=$4 builder=$5 path=$6 column hash cell
    printf '  %-26s' "$frontend, $builder, $path"
    for column in "${columns[@]}"; do
        cell=-
        if matrix_takes_part "$column" "$frontend" "$is_small"; then
            # shellcheck disable=SC2086 # one word per argument
            if [[ $builder == hits ]]; then
                hash=$(matrix_hits "$column" "$folder" $case --frontend "$frontend" --path "$path")
            elif [[ $builder == edits ]]; then
                hash=$(matrix_edit "$column" "$folder" $case --frontend "$frontend" --path "$path")
            else
                hash=$(matrix_hash "$column" "$folder" $case --frontend "$frontend" --builder "$builder" \
                    --path "$path")
            fi
            matrix_expected=${matrix_expected:-$hash}
            cell=same
            if [[ $hash != "$matrix_expected" || ! $hash =~ ^[0-9a-f]{32}$ ]]; then
                cell=DIFFERS
                matrix_wrong+=("$case, $frontend, $builder, $path, $column: $hash")
            fi
        fi
        printf ' %9s' "$cell"
    done
    printf '\n'
}

# A case by every method: the remaining arguments.
matrix_case()
{
    local folder=$1 is_small=$2 case=$3 method
    shift 3
    matrix_expected=
    printf '%s\n' "$case"
    for method in "$@"; do
        # shellcheck disable=SC2086 # three words
        matrix_row "$folder" "$is_small" "$case" $method
    done
    printf '  %s\n' "$matrix_expected"
}

matrix_versions()
{
    # shellcheck disable=SC2016 # expanded by dpkg-query
    local folder=$1 show='${Package} ${Version}\n'
    printf 'here: %s\n' "$(dpkg-query -W -f="$show" pocl-opencl-icd oclgrind libgl1-mesa-dri gcc |
        paste -s -d , | sed 's/,/, /g')"
    printf 'PyPI: %s\n' "${intel_packages[0]}"
    printf 'Debian 13: %s\n' "$(matrix_enter "$folder" dpkg-query -W -f="$show" pocl-opencl-icd mesa-opencl-icd \
        libgl1-mesa-dri gcc cmake | paste -s -d , | sed 's/,/, /g')"
}

matrix()
{
    local folder mirror=${2:-$matrix_mirror} columns=("${matrix_columns[@]}") case
    mkdir -p "${1:-$build_matrix}"
    folder=$(cd "${1:-$build_matrix}" && pwd)/$matrix_release
    ((EUID == 0)) || command -v sudo >/dev/null || fail "matrix needs root or sudo"
    build
    prepare_run_time
    command -v debootstrap >/dev/null || apt install --no-install-recommends debootstrap >&2
    matrix_make_root "$folder" "$mirror"
    setup_intel
    matrix_build "$folder"
    matrix_versions "$folder"
    printf '%-28s' ''
    printf ' %9s' "${columns[@]}"
    printf '\n'
    for case in "${matrix_small_cases[@]}"; do
        matrix_case "$folder" yes "$case" "${matrix_methods[@]}"
    done
    for case in "${matrix_cases[@]}"; do
        matrix_case "$folder" no "$case" "${matrix_methods[@]}"
    done
    for case in "${matrix_small_traces[@]}"; do
        matrix_case "$folder" yes "$case" "${matrix_hits[@]}"
    done
    for case in "${matrix_traces[@]}"; do
        matrix_case "$folder" no "$case" "${matrix_hits[@]}"
    done
    for case in "${matrix_edits[@]}"; do
        matrix_case "$folder" no "$case" "${matrix_sessions[@]}"
    done
    if ((${#matrix_wrong[@]} > 0)); then
        printf 'matrix: these differ:\n'
        printf '  %s\n' "${matrix_wrong[@]}"
        return 1
    fi
    printf 'matrix: all hashes and hits are equal\n'
}
