#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
#
# Test of the scripts: GNU parallel, make and Slurm give the file of one process; Slurm is a shell script here, which
# runs jobs at once. check.sh SVOCL FOLDER; exit code 77: skipped.
set -euo pipefail
export SVOCL=$1
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
mkdir -p "$2"
cd "$2"
rm -rf ./*.svo ./*.parts slurm

"$SVOCL" build scene:statue:20000 -d 7 -q -o whole.svo
MAKEFLAGS='' make -s -j 2 -f "$here/Makefile" MESH=scene:statue:20000 DEPTH=7 BYTES=2M OUT=made.svo >/dev/null
cmp whole.svo made.svo

# Somebody plans the folder when make builds: it ends, and goes on when it is started again.
rm -r made.svo
mkdir -p made.svo.parts/planner.lease/7
echo m p elsewhere 7 >made.svo.parts/planner.lease/7/owner
rm made.svo.parts/"$(cd made.svo.parts && set -- *.part && echo "$1")"
make_again()
{
    MAKEFLAGS='' make -s -j 1 -f "$here/Makefile" MESH=scene:statue:20000 DEPTH=7 BYTES=2M OUT=made.svo 2>&1
}
! make_again >words
grep -q 'process 7 on elsewhere plans its parts' words
rm -r made.svo.parts/planner.lease
make_again >/dev/null
cmp whole.svo made.svo

# The first try of the second part, and of the last job, finds the folder planned by somebody.
mkdir slurm
cat >slurm/sbatch <<'END'
#!/usr/bin/env bash
# sbatch [--parsable] [--requeue] [--array=0-LAST] [--dependency=...] --wrap COMMAND
first=0 last=0
while [[ $1 != --wrap ]]; do
    [[ $1 != --array=* ]] || last=${1##*-}
    shift
done
lease=slurm.svo.parts/planner.lease
for ((i = first; i <= last; ++i)); do
    export SLURM_JOB_ID=4 SLURM_ARRAY_JOB_ID=3 SLURM_ARRAY_TASK_ID=$i
    if ((i == 1 || last == 0)); then
        mkdir -p $lease/7 && echo m p elsewhere 7 >$lease/7/owner
    fi
    rm -f slurm/queued
    sh -c "$2" >&2 || [[ -e slurm/queued ]] || exit 1
    if [[ -e slurm/queued ]]; then
        rm -r $lease
        sh -c "$2" >&2 || exit 1
    fi
done
echo 3
END
printf '#!/bin/sh\necho "$2" >slurm/queued; echo "$2" >>slurm/all\n' >slurm/scontrol
chmod +x slurm/sbatch slurm/scontrol
PATH=$PWD/slurm:$PATH bash "$here/slurm.sh" scene:statue:20000 7 2M slurm.svo >/dev/null 2>words
cmp whole.svo slurm.svo
[[ $(xargs <slurm/all) = '3_1 4' && ! -e slurm.svo.parts ]]
if ! command -v parallel >/dev/null || ! parallel --version | grep -q GNU; then
    echo 'GNU parallel is not installed'
    exit 77
fi
bash "$here/parallel.sh" scene:statue:20000 7 2M parallel.svo -j 2
cmp whole.svo parallel.svo
echo 'the same file by one process, make, Slurm and GNU parallel'
