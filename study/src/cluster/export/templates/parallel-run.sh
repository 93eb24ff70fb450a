#!/bin/sh
# @LABEL@
# On this machine; with --sshlogin a,b,c on others that share the file system. Ctrl-C twice sends TERM: what is finished is written.
# Children live on if parallel itself is killed: their rows count, and those of a second attempt do no harm.
seq 0 @LAST@ | parallel --jobs 100% --retries 3 --termseq TERM,30000,KILL --quote \
    @PROGRAM@ --quiet --threads 1 sweep run @SWEEP@ --shard '{}/@SHARDS@' --flush 30s
exec @PROGRAM@ sweep merge @SWEEP@ --patience 90s
