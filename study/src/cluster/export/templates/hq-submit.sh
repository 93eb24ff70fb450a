#!/bin/sh
# @LABEL@
# With a running `hq server` and workers (`hq alloc add slurm` starts them on a cluster). A task whose worker is lost runs again.
set -eu
hq submit --wait --name @NAME@ --array 0-@LAST@ --cpus 1 --crash-limit 20 -- \
    @PROGRAM@ --quiet --threads 1 sweep run @SWEEP@ --shard auto/@SHARDS@ --flush 30s || true
exec @PROGRAM@ sweep merge @SWEEP@ --patience 90s
