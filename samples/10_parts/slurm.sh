#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
#
# A tree in parts by Slurm: slurm.sh MESH DEPTH BYTES OUT.svo, on a file system that all nodes see
#
# The parts are an array job; the last job stitches them when all have succeeded. What another try may help, by its exit
# code 75, puts itself back into the queue.
set -euo pipefail
mesh=$1 depth=$2 bytes=$3 out=$4
svocl=${SVOCL:-svocl}

"$svocl" parts plan "$mesh" -d "$depth" --max-memory "$bytes" -o "$out"
last=$(($("$svocl" parts status "$out.parts" --json | grep -c '"part"') - 1))
job=$(sbatch --parsable --requeue --array="0-$last" --wrap \
    "$svocl parts build '$out.parts' --part \$SLURM_ARRAY_TASK_ID || { code=\$?; [ \$code != 75 ] ||
        scontrol requeue \${SLURM_ARRAY_JOB_ID}_\$SLURM_ARRAY_TASK_ID; exit \$code; }")
sbatch --requeue --dependency="afterok:$job" --wrap \
    "{ $svocl parts stitch '$out.parts' && $svocl parts remove '$out.parts'; } || { code=\$?; [ \$code != 75 ] ||
        scontrol requeue \$SLURM_JOB_ID; exit \$code; }"
