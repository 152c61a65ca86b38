#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
#
# svocl tune: errors against closed forms on a cube, bounds that are kept, the same answer from a file of state, files,
# and what is wrong with its options.
#
# usage: tune.sh PROGRAM
set -euo pipefail

readonly svocl=$1
# shellcheck source=tests/support/complain.sh
source "${BASH_SOURCE[0]%/*}/../support/complain.sh"
cd "$work"
"$svocl" devices >devices.txt 2>&1 || { echo "skipped: no device"; exit 77; }

# value FILE EXPRESSION: of a document d and its function error(setting, measure).
value()
{
    python3 -c '
import json, sys
d = json.load(open(sys.argv[1]))
rows = next(t for t in d["tables"] if t["id"] == "tune-errors")["rows"]
error = lambda setting, measure: next(r[2] for r in rows if r[0] == setting and r[1] == measure)
print(eval(sys.argv[2]))' "$1" "$2"
}
# check FILE EXPRESSION: it must be true.
check()
{
    [[ $(value "$1" "$2") == True ]] || complain "$1: not true: $2"
}
# same FILE FILE EXPRESSION: of two documents.
same()
{
    [[ $(value "$1" "$3") == "$(value "$2" "$3")" ]] || complain "$1 and $2 differ: $3"
}
readonly cube=(tune scene:cube --free "depth:4-5,builder:cl+sorted" --error voxel-rms-units:.02 --json)

# --- closed forms ---

# The cube's faces lie on faces of voxels: centers are half a voxel away from the surface.
"$svocl" "${cube[@]}" --resume state.json --page page.html --csv rounds.csv >first.json
check first.json 'abs(error(0, "voxel-rms") - 0.5) < 1e-3'
check first.json 'abs(error(2, "voxel-rms") - 0.5) < 1e-3'
check first.json 'abs(error(0, "voxel-rms-units") / error(2, "voxel-rms-units") - 2) < 1e-3'
check first.json 'error(0, "normal") < 0.01'
check first.json 'error(0, "silhouette") == 0 and error(0, "surface-max") < 0.9'

# --- the answer ---

check first.json 'd["fresh"]["voxel-rms-units"] <= .02 and "-d 5" in d["answer"]["command"]'
"$svocl" "${cube[@]}" --resume state.json >again.json
same first.json again.json '(d["answer"], d["second"], d["sure"], d["settings"])'
# Interrupted: all but the first rounds are missing.
python3 -c '
import json
d = json.load(open("state.json"))
for one in d["settings"]:
    one["rounds_ms"] = one["rounds_ms"][:1]
    one["left"] = ""
json.dump(d, open("state.json", "w"))'
"$svocl" "${cube[@]}" --resume state.json >later.json
same first.json later.json '(error(0, "voxel-rms"), "-d 5" in d["answer"]["command"])'
"$svocl" "${cube[@]}" --exhaustive >exhaustive.json
same first.json exhaustive.json '"-d 5" in d["answer"]["command"]'
check exhaustive.json 'all(len(one["rounds_ms"]) == 11 for one in d["settings"])'
"$svocl" tune scene:cube --free depth:4-5 --error voxel-rms-units:1e-6 >none.txt
grep -q 'no setting keeps these bounds' none.txt || complain "an impossible bound: $(cat none.txt)"

# The command runs in a shell, with what is fixed on tune's own line.
"$svocl" scene cube -o "it's a cube.obj"
"$svocl" tune "it's a cube.obj" --weld .001 --free depth:4 --error normal --json >quoted.json
command=$(value quoted.json 'd["answer"]["command"]')
[[ $command == *' --weld .001 '* ]] || complain "--weld is not in: $command"
(eval "\"$svocl\" ${command#svocl }") >build.txt || complain "does not run: $command"
[[ -s model.svo ]] || complain "no tree by: $command"

# --- files ---

grep -q '^setting,round,"\?time' rounds.csv || complain "CSV: $(head -n 1 rounds.csv)"
[[ $(grep -c 'svocl build scene:cube' rounds.csv) -ge 8 ]] || complain 'the CSV file lacks rounds'
grep -q '"id":"tune"' page.html || complain 'the page has no table'

# --- mistakes ---

expect_failure 2 "tune: --error: 'voxel-rm' is no measure, see tune --help, did you mean 'voxel-rms'" \
    "$svocl" tune scene:cube --error voxel-rm:1
expect_failure 2 "tune: --error: 'ao:x' is not NAME:NUMBER" "$svocl" tune scene:cube --error ao:x
expect_failure 2 "both lack a number" "$svocl" tune scene:cube --error ao,normal
expect_failure 2 "tune: --free: 'depht' is none of depth, coverage" "$svocl" tune scene:cube --free depht
expect_failure 2 "tune: --free: 'thick' is no value of coverage" "$svocl" tune scene:cube --free coverage:thick
expect_failure 2 "tune: --free: '9-7' is no depth or range of depths in 1 .. 16" \
    "$svocl" tune scene:cube --free depth:9-7
expect_failure 2 "tune: --time '20m' is not a time above 0" "$svocl" tune scene:cube --time 20m
expect_failure 1 "tune: --resume state.json: it is of another mesh, other settings or other bounds" \
    "$svocl" tune scene:cube --free depth:4 --resume state.json
expect_failure 1 "it is of another mesh, other settings or other bounds" \
    "$svocl" "${cube[@]}" --time 9s --resume state.json
expect_failure 1 "it is of another mesh, other settings or other bounds" \
    "$svocl" "${cube[@]}" --edge 3 --origin=-1,-1,-1 --resume state.json
echo '{"settings": [' >damaged.json
expect_failure 1 "damaged.json:" "$svocl" "${cube[@]}" --resume damaged.json
check first.json 'len(d["settings"]) == 4'
"$svocl" tune scene:cube --free depth:4+4-5+5,builder:cl+sorted+cl --json --error voxel-rms-units:.02 >twice.json
check twice.json 'len(d["settings"]) == 4'
exit "$failed"
