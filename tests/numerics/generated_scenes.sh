#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
#
# Every generated scene against the exact reference, at depths 6 to 9.
#
# usage: generated_scenes.sh PROGRAM
set -euo pipefail

readonly program=$1
scenes=$("$program" scene --json | sed -n 's/.*"name":[[:space:]]*"\([a-z]*\)".*/\1/p')
failed=0 verified=0
for scene in $scenes; do
    for depth in 6 7 8 9; do
        verdict=$("$program" verify "scene:$scene" -d "$depth" 2>&1 | tail -n 1) || failed=1
        echo "$scene at depth $depth: $verdict"
        [[ $verdict == *'exact: 0 missed, 0 surplus'* ]] || failed=1
        verified=$((verified + 1))
    done
done
echo "$verified trees verified"
((verified > 0 && failed == 0))
