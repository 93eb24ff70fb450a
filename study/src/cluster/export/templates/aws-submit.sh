#!/bin/sh
# @LABEL@
# ./submit.sh QUEUE. Edit IMAGE and FILE_SYSTEM in definition.json first; the file system holds the folder of the sweep and its
# traces, at the paths of the plan. An array has 2 to 10000 shards.
set -eu
cd "$(dirname "$0")"
aws batch register-job-definition --cli-input-json file://definition.json
aws batch submit-job --job-name @NAME@ --job-queue "$1" --job-definition @NAME@ --array-properties size=@SHARDS@
# No job that depends on the array: it would fail with any shard. When the array has ended, wherever the folder is mounted:
echo "then: rayreel sweep merge /sweep --patience 90s"
