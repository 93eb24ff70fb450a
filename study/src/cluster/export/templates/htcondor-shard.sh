#!/bin/sh
# @LABEL@
exec @PROGRAM@ --quiet --threads 1 sweep run @SWEEP@ --shard "$1/@SHARDS@" --flush 30s
