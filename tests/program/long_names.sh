#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
#
# What a driver says has any length: with names of 200 and of 5000 characters, which the shim gives a driver, the
# program works, and where it prints a name it prints all of it.
#
# usage: long_names.sh PROGRAM SHIM
set -euo pipefail

readonly program=$1 shim=$2
# shellcheck source=tests/support/complain.sh
source "${BASH_SOURCE[0]%/*}/../support/complain.sh"
cd "$work"

# run NAME ARGUMENT...: the program's output, in NAME.
run()
{
    local name=$1
    shift
    env LD_PRELOAD="$shim" SHIM_NAME_BYTES="$length" "$program" "$@" >"$name" 2>"$name.errors" ||
        complain "$length: svocl $* failed: $(tail -c 600 "$name.errors")"
}

# expect_name FILE EXPRESSION: what follows the expression in the file, to the next quote, is a whole name.
expect_name()
{
    local name
    name=$(tr -d '\n' <"$1" | grep -o -m 1 -E -e "$2[^\"]*\\(end\\)" | head -n 1) || true
    ((${#name} >= length)) || complain "$length: $1 has no whole name after $2: '${name:0:80}'"
}

for length in 200 5000; do
    run devices.json devices --json
    for name in name vendor version driver device; do
        expect_name devices.json "\"$name\":[[:space:]]*\""
    done
    run devices devices
    run build build scene:cube -d 3
    run build.json build scene:cube -d 3 --json
    run bench.json bench voxelize --scenes cube:12 --depths 3 --repeat 1 --json
    expect_name build 'opencl   '
    expect_name devices 'OpenCL platform 0: '
    expect_name build.json '"device":[[:space:]]*"'
    for name in device driver platform; do
        expect_name bench.json "\"$name\":[[:space:]]*\""
    done
    # Kernels are found again by names that are whole.
    run save kernels scene:cube -d 3 --kernels "kernels-$length"
    run load build scene:cube -d 3 --kernels "kernels-$length" --json
    expect_name load '"device":[[:space:]]*"'
done
exit "$failed"
