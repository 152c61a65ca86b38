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

# value FILE EXPRESSION: of a document d, its measures error(setting, measure), and its table: names of columns and
# cell(setting, name).
value()
{
    python3 -c '
import json, sys
d = json.load(open(sys.argv[1]))
rows = next(t for t in d["tables"] if t["id"] == "tune-errors")["rows"]
error = lambda setting, measure: next(r[2] for r in rows if r[0] == setting and r[1] == measure)
table = next(t for t in d["tables"] if t["id"] == "tune")
names = [column["name"] for column in table["columns"]]
cell = lambda setting, name: table["rows"][setting][names.index(name)]
print(eval(sys.argv[2]))' "$1" "$2"
}
# check FILE EXPRESSION: it must be true.
check()
{
    [[ $(value "$1" "$2") == True ]] || complain "$1: not true: $2"
}
# run FILE SETTING [OPTION...]: the command that a document has for a setting.
run()
{
    local command
    command=$(value "$1" "d['settings'][$2]['command']")
    eval "\"$svocl\" ${command#svocl } ${*:3}" || complain "does not run: $command"
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
check quoted.json '" --weld .001 " in d["answer"]["command"]'
run quoted.json 0 -q
[[ -s model.svo ]] || complain 'no tree by the answer'

# --- rays ---

# Against every triangle in long double; cells of what has no triangles say so.
"$svocl" tune scene:statue:2000 --free depth:5,coverage:half-open+thin,form:tree+shared --error triangle:0 \
    --json >rays.json
"$svocl" tune scene:statue:2000 --free depth:5,form:tree+shared --exhaustive --json >forms.json
check rays.json 'error(0, "triangle") == 0 and error(0, "t-max-units") < 1e-5'
check forms.json 'error(1, "depth") == error(0, "depth") and error(1, "silhouette") == error(0, "silhouette")'
check rays.json 'cell(1, "triangle") == cell(1, "t-rms-units") == "a compact form has no triangles"'
check rays.json 'cell(2, "triangle") == cell(3, "triangle") == "thin voxels lack triangles"'
check rays.json 'd["answer"]["setting"] == 0 and [cell(i, "standing") for i in (1, 2, 3)] == 3 * ["no value"]'
# The bound adds rays, and a line says so; what is built has them.
check rays.json '"trees hold rays, too, which --error asks for" in d["asked"]'
check rays.json '".need = SVO_NEED_COLOR | SVO_NEED_NORMAL | SVO_NEED_RAYS" in d["answer"]["c"]'
run rays.json 0 -q
"$svocl" info model.svo | grep -q rays || complain 'no rays in the tree of the answer'

# --- needs ---

"$svocl" tune scene:cube --need normal,fill --free depth:5 --error normal --json >fill.json
"$svocl" tune scene:cube --need normal --free depth:5 --error normal --json >normal.json
check fill.json '" --need normal,fill " in d["answer"]["command"] and d["asked"] == "least normal"'
check fill.json '".need = SVO_NEED_NORMAL | SVO_NEED_FILL" in d["answer"]["c"]'
[[ $(value fill.json 'd["answer"]["memory_bytes"]') -gt $(value normal.json 'd["answer"]["memory_bytes"]') ]] ||
    complain 'fill takes no memory'
check fill.json '"normal" in names and "color" not in names'
expect_failure 2 "tune: --error delta-e asks for color, which --need leaves out" \
    "$svocl" tune scene:cube --need rays,normal --free depth:4 --error delta-e:3
printf 'OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n' >bare.off
expect_failure 1 "tune: --error delta-e: bare.off has no colors" "$svocl" tune bare.off --error delta-e:3
expect_failure 1 "tune: --error volume: bare.off is not closed" "$svocl" tune bare.off --error volume
# What is gathered adds to the needs.
"$svocl" tune scene:cube --need fill --free depth:4,rays:16 --json >gathered.json
check gathered.json '"trees hold color,normal,rays, too, by which light is gathered" in d["asked"]'
check gathered.json '" --need color,normal,rays,fill " in d["settings"][0]["command"]'

# A compact form is made by the command.
"$svocl" tune scene:cube --free depth:4,form:shared --error voxel-rms:1 --json >form.json
check form.json 'd["answer"]["command"].endswith(" --tree-form shared -o model.svc") and d["answer"]["note"] == ""'
run form.json 0 -q
[[ -s model.svc ]] || complain "no file of the compact form: $(value form.json 'd["answer"]["command"]')"

# --- light ---

cat >room.json <<'end'
{"lights": [{"kind": "point", "position": [0.3, 1.2, 0.2], "value": [1, 0.8, 0.6]}], "sky": [0.3, 0.4, 0.5]}
end
cat >sun.json <<'end'
{"lights": [{"kind": "directional", "direction": [-0.5, -1, -0.35], "value": [3, 3, 3]}], "sky": [0.4, 0.4, 0.4]}
end
echo '{"lights": [], "sky": [0, 0, 0]}' >dark.json
# agree FILE SETTING LIGHT.csv TRUTH.csv: bias and RMSE of a setting are those of its command's light against a truth of
# its own: of ambient occlusion within .001, of light within .01 of its mean.
agree()
{
    python3 -c '
import csv, json, math, sys
read = lambda path: [{k: float(v) for k, v in row.items()} for row in csv.DictReader(open(path))]
table = next(t for t in json.load(open(sys.argv[1]))["tables"] if t["id"] == "tune-errors")
own = {row[1]: row[2] for row in table["rows"] if row[0] == int(sys.argv[2])}
found, truth = read(sys.argv[3]), read(sys.argv[4])
parts = {"ao": ["ao"], "light": ["r", "g", "b"], "direct": ["direct_r", "direct_g", "direct_b"]}
for name, channels in parts.items():
    scale = 1 if name == "ao" else sum(t[c] for t in truth for c in channels) / (len(truth) * len(channels))
    off = [(a[c] - b[c]) / scale for a, b in zip(found, truth) for c in channels]
    here = {name: math.sqrt(sum(x * x for x in off) / len(off)), name + "-bias": sum(off) / len(off)}
    for measure, value in here.items():
        if not abs(own[measure] - value) <= (.001 if name == "ao" else .01):
            print(f"{measure}: {own[measure]}, and {value} by {sys.argv[4]}")
' "$@" >differences.txt
    [[ ! -s $work/differences.txt ]] || complain "$1, setting $2: $(cat differences.txt)"
}
# truth SCENE LIGHTS: at the points of light.csv, by other paths than tune's and four times as many, and by the
# library's own rays of another tree.
truth()
{
    local range
    range=$(python3 -c 'import json; print(json.load(open("gathered.json"))["range"])')
    cut -d, -f1-6 light.csv >points.csv
    "$svocl" reference "$1" --points points.csv --lights "$2" --range "$range" --samples 16384 --seed 9 -q -o paths.csv
    "$svocl" gather "$1" -d 7 --points points.csv --lights "$2" --paths 4096 --method rays -q -o rays.csv
}

# A closed room with a lamp in it.
"$svocl" tune scene:cornell --lights room.json --free depth:5,cones:16,rays:64,probes:2x64 --json --resume lit.json \
    >room-tuned.json
run room-tuned.json 0 --json >gathered.json
truth scene:cornell room.json
agree room-tuned.json 0 light.csv paths.csv
agree room-tuned.json 0 light.csv rays.csv
run room-tuned.json 1 --json >gathered.json
agree room-tuned.json 1 light.csv paths.csv
check room-tuned.json 'error(1, "ao") < .02 and error(0, "ao") > 3 * error(1, "ao") and error(0, "direct") < .001'
# Probes: two reflections; what they do not hold; the picture and the options that have them.
check room-tuned.json 'abs(error(2, "light-bias")) < .1 and .1 < error(2, "light") < 1'
check room-tuned.json 'cell(2, "ao") == cell(2, "ao-bias") == "probes hold no openness"'
check room-tuned.json 'cell(2, "direct") == "probes hold no direct light"'
check room-tuned.json 'cell(2, "query") > 0 and cell(2, "result") > cell(0, "result")'
# Around a cube under the sky there is the sky alone.
"$svocl" tune scene:cube --edge 4 --origin=-1.5,-1.5,-1.5 --free depth:4,probes:2x64 --error light --json >sky.json
check sky.json 'error(0, "light") < .02 and ".counts = {2, 2, 2}, .resolution = 64, .diffuse = 1" in d["answer"]["c"]'
check sky.json '"irradiance at points is svo_probes_irradiance" in d["answer"]["note"]'
run sky.json 0 --size 16x16 -q
[[ -s probes.png ]] || complain 'no picture through probes'
# Other lights of the same name.
cp room.json other.json
sed -i 's/1.2/1.3/' room.json
expect_failure 1 "it is of another mesh, other settings or other bounds" \
    "$svocl" tune scene:cornell --lights room.json --free depth:5,cones:16,rays:64,probes:2x64 --resume lit.json

# A court under the sun and the sky that tune has without --lights, of voxels too, which have no triangles.
"$svocl" tune scene:atrium:5000 --free depth:5,coverage:half-open+thin,rays:64 --json >court.json
"$svocl" tune scene:atrium:5000 --lights sun.json --free depth:5,coverage:half-open+thin,rays:64 --json >lit-court.json
same court.json lit-court.json '[error(i, name) for i in (0, 1) for name in ("ao", "light", "light-bias", "direct")]'
run lit-court.json 0 --json >gathered.json
truth scene:atrium:5000 sun.json
agree lit-court.json 0 light.csv paths.csv
agree lit-court.json 0 light.csv rays.csv
run lit-court.json 1 --json >gathered.json
agree lit-court.json 1 light.csv paths.csv
check court.json 'error(1, "direct") > 100 * error(0, "direct")'

expect_failure 1 "tune: --error light: no light reaches scene:cube from dark.json" \
    "$svocl" tune scene:cube --free depth:4,rays:16 --lights dark.json --error light
expect_failure 2 "output sun.json would replace sun.json" \
    "$svocl" tune scene:cube --free depth:4,rays:16 --lights sun.json --csv sun.json
grep -q directional sun.json || complain 'the lights are gone'
expect_failure 1 "none.json" "$svocl" tune scene:cube --lights none.json
for value in 0 41 4x65 4x 4x48 4x1040 x64 -2; do
    expect_failure 2 "--free: '$value' is not N or NxR: probes along an axis, 1 .. 40, and texels of a map's side, 64" \
        "$svocl" tune scene:cube --free "probes:$value"
done

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
