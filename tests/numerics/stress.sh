#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
#
# A small run of svocl stress, with OpenGL if available and with OpenCL alone: every case passes, and the JSON has
# all its names, rows and methods.
#
# usage: stress.sh PROGRAM
set -euo pipefail

readonly program=$1
for frontend in auto cl; do
    document=$("$program" stress --count 1 --frontend "$frontend" --json) || failed=1
    for word in device frontend frontend_reason renderer seed count cases name method false_negatives false_positives \
        figure unit ms judged passed; do
        [[ $document == *"\"$word\":"* ]] || { echo "no \"$word\" in the JSON"; failed=1; }
    done
    for row in T1 T2 T3 T4 T5 T6 T7 T8 T9 T10 T14 T15 T16; do
        [[ $document == *"\"$row "* ]] || { echo "no row $row"; failed=1; }
    done
    for method in svocl Schwarz-Seidel box-centered 'pixel centers' '4 samples' expanded; do
        [[ $document == *"\"$method\""* ]] || { echo "no method $method"; failed=1; }
    done
    echo "$document" | grep -E '"(name|reason)"' | grep -B 1 '"reason"' || true
    echo "$frontend: $(grep -c '"judged":[[:space:]]*true' <<<"$document") judged cases"
done
exit "${failed:-0}"
