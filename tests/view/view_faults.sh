#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
#
# svocl view with one call that fails: its allocations and its calls of OpenGL, SDL and OpenCL. Each must end in one
# line and exit code 1, or in the same picture as without.
#
# usage: view_faults.sh PROGRAM SHIM SCRIPT [every]
#
# Without "every" the first call from every second place of the program fails, and every 200th of all.
set -euo pipefail

readonly program=$1 shim=$2 script=$3
[[ ${4:-} == every ]] && step=1 || step=200
# shellcheck source=tests/support/complain.sh
source "${BASH_SOURCE[0]%/*}/../support/complain.sh"
cd "$work"
export SDL_VIDEODRIVER=offscreen XDG_CONFIG_HOME=$work

view()
{
    timeout 120 env "$@" LD_PRELOAD="$shim" "$program" view scene:cube -d 3 --probes 1,1,1 --probe-resolution 64 \
        --width 160 --height 160 --script "$script"
}

if ! view VIEW_FAULT_LIST="$work/calls" 2>err; then
    cat err
    exit 1
fi
mv fault.png whole.png
(($(wc -l <calls) > 200)) || complain "only $(wc -l <calls) calls were seen"
for kind in malloc realloc glTexImage2D glGetShaderiv SDL_CreateWindow SDL_GL_CreateContext clEnqueueNDRangeKernel; do
    grep -q " $kind " calls || complain "no call of $kind was seen"
done

failures=0
while read -r number kind _; do
    code=0
    rm -f fault.png
    view VIEW_FAULT_AT="$number" >out 2>err || code=$?
    if ((code == 0)); then
        cmp -s fault.png whole.png || complain "call $number, $kind: another picture"
        [[ ! -s err ]] || complain "call $number, $kind: exit code 0 with $(cat err)"
    else
        failures=$((failures + 1))
        ((code == 1 && $(wc -l <err) == 1)) || complain "call $number, $kind: exit code $code with: $(cat err)"
        [[ ! -s out ]] || complain "call $number, $kind: standard output has $(cat out)"
    fi
done < <(awk -v step="$step" '
    !($2 " " $3 in seen) { seen[$2 " " $3]; fresh = ++places % 2 }
    fresh || NR % step == 0 { print }
    { fresh = 0 }' calls)
((failures > 20)) || complain "only $failures calls that failed were noticed"
exit "$failed"
