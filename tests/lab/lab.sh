#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
#
# svocl runs svocl-lab for the commands that check and measure: it finds it beside itself, then along PATH, and says
# where neither has it. Nothing of the laboratory is in svocl.
#
# usage: lab.sh PROGRAM LAB
set -euo pipefail

readonly program=$1 lab=$2
# shellcheck source=tests/support/complain.sh
source "${BASH_SOURCE[0]%/*}/../support/complain.sh"
cd "$work"
mkdir alone both path
cp "$program" alone/svocl
cp "$program" both/svocl
cp "$lab" both/svocl-lab
cp "$lab" path/svocl-lab

# --- found and missed ---

for command in verify reference stress bench report tune; do
    expect_failure 1 "svocl: $command: svocl-lab is not installed (apt install svocl-lab)" \
        env PATH=/nonexistent alone/svocl "$command" --help
    expect_failure 1 "svocl: $command: svocl-lab is not installed" env PATH=/nonexistent alone/svocl help "$command"
    both/svocl "$command" --help >"$work/help"
    cmp -s "$work/help" <(both/svocl help "$command") || complain "help $command prints something else"
    cmp -s "$work/help" <(both/svocl-lab "$command" --help) || complain "svocl-lab $command --help does"
    grep -q "^usage: svocl $command" "$work/help" || complain "no usage of $command: $(cat "$work/help")"
done
grep -q 'probes' <(env PATH=/nonexistent alone/svocl man bench) || complain 'a page needs svocl-lab'
chmod a-x both/svocl-lab
if [[ ! -x both/svocl-lab ]]; then
    expect_failure 1 'svocl: verify: svocl-lab: ' both/svocl verify scene:cube
fi
chmod a+x both/svocl-lab

# Exit codes, lines and pipes pass through.
PATH=$work/path:$PATH alone/svocl verify scene:cube -d 4 >"$work/verdict"
grep -q 'exact: 0 missed' "$work/verdict" || complain "along PATH: $(cat "$work/verdict")"
expect_failure 2 'svocl: verify: INPUT is missing' both/svocl verify
expect_failure 1 'svocl: verify: lacking.obj' both/svocl verify lacking.obj
both/svocl scene cube --quiet -o - | both/svocl verify - -d 4 >"$work/verdict"
grep -q 'exact: 0 missed' "$work/verdict" || complain "through a pipe: $(cat "$work/verdict")"

# --- svocl-lab by itself ---

[[ $(both/svocl-lab --version) == "svocl-lab $(both/svocl --version | cut -d ' ' -f 2)" ]] || complain 'another version'
both/svocl-lab --help >"$work/help"
for command in verify reference stress bench report tune; do
    grep -q "^  $command " "$work/help" || complain "svocl-lab --help lacks $command"
done
expect_failure 2 "unknown command 'build', see svocl-lab --help" both/svocl-lab build scene:cube
expect_failure 2 "unknown command 'stres', did you mean 'stress'" both/svocl-lab stres
expect_failure 2 'no command given, see svocl-lab --help' both/svocl-lab

# --- what svocl has not ---

# symbols FILE: the functions and variables in it.
symbols()
{
    nm --defined-only "$1" | cut -d ' ' -f 3
}
readonly of_lab='^(oracle_|bench_|errors_|suite_|stress_|result_|page_write|openvdb_|rtc)'
if command -v nm >/dev/null && [[ -n $(symbols "$lab" 2>/dev/null) ]]; then
    grep -q -E "$of_lab" <(symbols "$lab") || complain 'svocl-lab has no function of the laboratory'
    found=$(symbols "$program" | grep -E "$of_lab" | paste -s -d ' ') || true
    [[ -z $found ]] || complain "svocl has $found"
else
    echo "not run: nm is not installed, or the programs have no symbols"
fi
exit "$failed"
