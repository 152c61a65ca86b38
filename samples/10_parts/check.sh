#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
#
# Test of the scripts: GNU parallel and make give the file of one process. check.sh SVOCL FOLDER; exit code 77: skipped.
set -euo pipefail
export SVOCL=$1
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
mkdir -p "$2"
cd "$2"
rm -rf ./*.svo ./*.parts

"$SVOCL" build scene:statue:20000 -d 7 -q -o whole.svo
MAKEFLAGS='' make -s -j 2 -f "$here/Makefile" MESH=scene:statue:20000 DEPTH=7 BYTES=2M OUT=made.svo >/dev/null
cmp whole.svo made.svo
if ! command -v parallel >/dev/null || ! parallel --version | grep -q GNU; then
    echo 'GNU parallel is not installed'
    exit 77
fi
bash "$here/parallel.sh" scene:statue:20000 7 2M parallel.svo -j 2
cmp whole.svo parallel.svo
echo 'the same file by one process, make and GNU parallel'
