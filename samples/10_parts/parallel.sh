#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
#
# A tree in parts by GNU parallel: parallel.sh MESH DEPTH BYTES OUT.svo [options of parallel]
#
# Options such as --sshloginfile hosts let other machines take part that see the folder under the same name. Exit code
# 75 of `svocl parts build` says that another try may succeed; parallel tries each part three times.
set -euo pipefail
mesh=$1 depth=$2 bytes=$3 out=$4
svocl=${SVOCL:-svocl}

"$svocl" parts plan "$mesh" -d "$depth" --max-memory "$bytes" -o "$out"
"$svocl" parts status "$out.parts" --json | sed -n 's/.*"part":[[:space:]]*"\(.*\)".*/\1/p' |
    parallel --will-cite --halt now,fail=1 --retries 3 "${@:5}" "$svocl" parts build "$out.parts" --part {}
"$svocl" parts stitch "$out.parts"
"$svocl" parts remove "$out.parts"
