#!/bin/bash
# One shard of a sweep, as a task of a Slurm array. Argument: what is added to the index of the task.
#
# Two signals, two meanings:
#   USR1  the time limit is near: Slurm would end the job there, so write what is finished and go back into the queue
#   TERM  preemption (Slurm requeues by itself) or scancel (must stay cancelled): write what is finished, nothing else
offset=${1:-0}
again=no pid='' signalled=no
stop() {
    again=$1 signalled=yes
    [ -z "$pid" ] || kill -TERM "$pid" 2>/dev/null
}
trap 'stop yes' USR1
trap 'stop no' TERM
@SETUP@
@PROGRAM@ --quiet --threads "${SLURM_CPUS_PER_TASK:-1}" sweep run @SWEEP@ --shard auto/@SHARDS@ --index-offset "$offset"@RUN@ &
pid=$!
# A signal that came before there was anybody to pass it on to.
[ "$signalled" = no ] || kill -TERM "$pid" 2>/dev/null

# A trapped signal ends `wait` early, with a code that is not the program's. To ask whether the process is still there would not tell
# this from an end at the same moment; the flag does, and the shell remembers the code.
while :; do
    signalled=no
    wait "$pid"
    code=$?
    [ "$signalled" = yes ] || break
done
pid=''

if [ "$code" -eq 75 ] && [ "$again" = yes ]; then
    if [ "${SLURM_RESTART_COUNT:-0}" -ge @MAX@ ]; then
        echo "time limit: not requeued a further time after ${SLURM_RESTART_COUNT}" >&2
    else
        # Said first: the requeue ends this job, and may do so before another line of it runs.
        echo "time limit: back into the queue" >&2
        if scontrol requeue "${SLURM_ARRAY_JOB_ID}_${SLURM_ARRAY_TASK_ID}"; then
            # It ends it with a TERM. Not to be gone before, or the task would be one that failed; not in the foreground, or the TERM
            # would wait for the sleep.
            sleep 60 &
            wait $!
        else
            echo "time limit: Slurm did not requeue it; resubmit with \`rayreel sweep resume\`" >&2
        fi
    fi
fi
exit "$code"
