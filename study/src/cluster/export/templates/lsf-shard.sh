#!/bin/sh
# @LABEL@
exec @PROGRAM@ --quiet --threads 1 sweep run @SWEEP@ --shard auto/@SHARDS@ --flush 30s
