#!/bin/sh
# @LABEL@
# Arrays above MAX_JOB_ARRAY_SIZE (often 1000) are refused: submit several, with --index-offset in shard.sh. Indices begin at 1;
# `--shard auto` takes that off.
set -eu
cd "$(dirname "$0")"
# -r: run again if the host dies. -Q 75: put back what was interrupted and has written its rows. -wa, -wt: TERM before the time limit.
bsub -J "@NAME@[1-@SHARDS@]" -n 1 -W 60 -r -Q "75" -wa TERM -wt 2 -o "shard-%I.log" ./shard.sh
# ended and not done: merge is to run behind shards that failed too.
bsub -J "@NAME@-merge" -n 1 -w "ended(@NAME@)" -o merge.log ./merge.sh
