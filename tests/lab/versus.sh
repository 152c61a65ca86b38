#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
#
# svocl bench gl-vs-cl on a cube: every cell has a tree of the right hash or a reason, the tables are complete, files
# hold the same, and a tree of another hash is a failure that names its cell.
#
# usage: versus.sh PROGRAM
set -euo pipefail

readonly svocl=$1
# shellcheck source=tests/support/complain.sh
source "${BASH_SOURCE[0]%/*}/../support/complain.sh"
folder=$(cd "${BASH_SOURCE[0]%/*}" && pwd)
cd "$work"
"$svocl" devices >devices.txt 2>&1 || { echo "skipped: no device"; exit 77; }

# check FILE EXPRESSION: it must be true of the document's tables t[ID], lists of objects.
check()
{
    [[ $(python3 -c '
import json, sys
d = json.load(open(sys.argv[1]))
t = {one["id"]: [dict(zip((c["name"] for c in one["columns"]), row)) for row in one["rows"]] for one in d["tables"]}
t = {name.removeprefix("gl-vs-cl-"): rows for name, rows in t.items()}
setting = lambda c: (c["scene"], c["depth"], c["need"], c["weights"], c["coverage"])
method = lambda c: (c["path"], c["list"], c["share"], c["builder"])
print(eval(sys.argv[2]))' "$1" "$2") == True ]] || complain "$1: not true: $2"
}

"$svocl" bench gl-vs-cl cube --quick -d 3 --depths 2,3 --repeat 2 --processes 2 -o all.json --page all.html \
    --csv all.csv >all.txt

# --- cells ---

# All lists with all shares and all builders.
check all.json 'len({method(c)[1:] for c in t["cells"]}) == 4 * 4 * 3'
check all.json 'all((c["hash"] == "") == (c["reason"] != "") for c in t["cells"])'
check all.json 'all(len({o["hash"] for o in t["cells"] if setting(o) == setting(c) and o["hash"]}) <= 1
                    for c in t["cells"])'
hash=$("$svocl" hash scene:cube -d 3 --need color,normal,rays -q | tail -n 1)
check all.json "t['cells'][0]['hash'] == '$hash' and t['cells'][0]['list'] == 'cl'"
# Of what a build reports and of the library's failures.
check all.json 'any("the build reports share" in c["reason"] for c in t["cells"])'
check all.json 'all(c["hash"] or "gl-hw" in c["reason"] or c["share"] == "interop"
                    for c in t["cells"] if c["list"] == "gl-hw")'
# 2 needs, 2 weights, 2 coverages, and the other depth.
check all.json 'all(sum(method(o) == method(c) for o in t["cells"]) in (1, 8, 9) for c in t["cells"])'

# --- rounds ---

check all.json '{r["process"] for r in t["rounds"]} == {1, 2} and {r["round"] for r in t["rounds"]} == {0, 1, 2}'
check all.json 'all(0 < r["plan"] < r["wall"] for r in t["rounds"])'
check all.json 'all(t["cells"][r["cell"]]["hash"] for r in t["rounds"])'
check all.json 'all(s["wall low"] <= s["wall"] <= s["wall high"] for s in t["stages"])'
check all.json 't["stages"][0]["ratio"] == 1'

# --- what is computed ---

check all.json 'all(text for name in ("methods", "payload", "depth", "scene") for row in t[name]
                    for text in row.values())'
check all.json '[row["depth"] for row in t["depth"]] == [2, 3] and len(t["payload"]) == 8'
check all.json 'abs(sum(e["share"] for e in t["effects"] if e["design"] == "methods and payload" and e["factor"] not in
                    ("path", "list", "share", "builder") and e["factor"].split(" ")[0] not in
                    ("path", "list", "share", "builder")) - 100) < 1.5'
check all.json '{s["caches"] for s in t["start"]} == {"cold", "warm"} and all(s["process"] > 0 for s in t["start"])'
check all.json 'd["machine"]["device"] != "" and d["machine"]["renderer"] != ""'
[[ $(grep -c 'gl-vs-cl-' all.txt) -ge 8 ]] || complain "tables are missing: $(cat all.txt)"

# --- files ---

grep -q '"id":"gl-vs-cl-methods"' all.html || complain 'the page has no table'
python3 -c '
import csv, json
rows = list(csv.DictReader(open("all.csv")))
tables = {one["id"]: one for one in json.load(open("all.json"))["tables"]}
rounds = tables["gl-vs-cl-rounds"]["rows"]
assert len(rows) == len(rounds) and all(float(r["wall [ms]"]) > 0 and r["hash"] for r in rows)' ||
    complain 'the CSV file'
"$svocl" bench gl-vs-cl --from all.json -o again.json -q
cmp all.json again.json || complain 'other tables from the same rounds'

# --- a wrong tree ---

python3 -c '
import json
d = json.load(open("all.json"))
cells = next(one for one in d["tables"] if one["id"] == "gl-vs-cl-cells")
hash, builder = ([c["name"] for c in cells["columns"]].index(name) for name in ("hash", "builder"))
row = [row for row in cells["rows"] if row[hash] and row[builder] == "sorted"][-1]
row[hash] = "0" * 32
json.dump(d, open("wrong.json", "w"))'
expect_failure 1 "bench: cube at depth 3, cl, none, sorted.*: the tree's hash is 0000" \
    "$svocl" bench gl-vs-cl --from wrong.json

# --- mistakes ---

expect_failure 1 'no results of bench gl-vs-cl' "$svocl" bench gl-vs-cl --from "$folder/results.json"
expect_failure 2 'option --scenes does not apply to bench gl-vs-cl' "$svocl" bench gl-vs-cl --scenes cube
expect_failure 2 'option --builder does not apply to bench gl-vs-cl' "$svocl" bench gl-vs-cl --builder cl
expect_failure 2 'option --processes does not apply to bench voxelize' "$svocl" bench voxelize --processes 2
expect_failure 2 "unexpected argument 'cube'" "$svocl" bench rays knot cube
exit "$failed"
