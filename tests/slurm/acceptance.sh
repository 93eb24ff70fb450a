#!/usr/bin/env bash
# A sweep on a real Slurm that goes wrong in every way we promise to survive, against the same sweep on this machine: no row may be
# lost, none doubled, and the merged files must be equal byte for byte. Each fault must have left its own trace, or the test fails:
# one that injected nothing proves nothing.
#
#   acceptance.sh [--required] RAYREEL        without Slurm it says "skipped" and succeeds, unless it is required
set -euo pipefail

required=no
if [ "${1:-}" = --required ]; then
    required=yes
    shift
fi
rayreel=$(realpath "${1:?acceptance.sh [--required] RAYREEL}")
here=$(cd "$(dirname "$0")" && pwd)
PATH=$PATH:/usr/sbin:/sbin
for program in munged slurmctld slurmd sbatch; do
    command -v $program > /dev/null && continue
    [ $required = no ] || { echo "FAILED: no $program; apt-get install --no-install-recommends slurm-wlm munge" >&2; exit 1; }
    echo "skipped: no $program (Debian: apt-get install --no-install-recommends slurm-wlm munge)"
    exit 0
done
# A test that hangs is ended, and still stops its daemons.
if [ -z "${RAYREEL_GUARDED:-}" ]; then
    again=("$rayreel")
    [ $required = no ] || again=(--required "${again[@]}")
    RAYREEL_GUARDED=1 exec timeout -k 30 "${LIMIT:-300}" "$0" "${again[@]}"
fi

work=$(mktemp -d)
export SLURM_DIR=${SLURM_DIR:-/tmp/rayreel-slurm} SLURM_NODES=3
export SLURM_CONF=$SLURM_DIR/slurm.conf
cluster=$here/cluster.sh
# A blank and a quote: every script must have quoted them.
sweep="$work/the main's sweep"
limit=$work/limit.sweep
shards=8

said() { echo "[$(($(date +%s) - begun))s] $*"; }
fail() {
    echo "FAILED: $*" >&2
    echo "--- queue" >&2
    squeue -r -t all -o '%F_%K %T %r %N restarts=%B' >&2 || true
    tail -n 30 "$work"/*sweep/logs/*.log >&2 || true
    exit 1
}
begun=$(date +%s)
trap '"$cluster" stop; rm -rf "$work"' EXIT
trap 'exit 1' TERM INT

until_true() { # WHAT COMMAND...: within a minute or two
    local what=$1 end=$((SECONDS + 90))
    shift
    until "$@"; do
        [ $SECONDS -lt $end ] || fail "waited in vain until $what"
        sleep 0.1
    done
}

jobs() { sed -n 's/^ *"job": "\([0-9]*\)".*/\1/p' "$1/submissions/$2.json"; }     # SWEEP NUMBER: ids of its arrays
offsets() { sed -n 's/^ *"offset": \([0-9]*\).*/\1/p' "$1/submissions/$2.json"; } # SWEEP NUMBER: and where each begins
merge_of() { sed -n 's/^ *"merge": "\([0-9]*\)".*/\1/p' "$1/submissions/$2.json"; }

running() { # NODE: "SHARD JOB TASK" of the shard of the main sweep that runs there
    local job offset task
    while read -r job offset; do
        task=$(squeue -r -h -t R -w "$1" -j "$job" -o %K)
        [ -z "$task" ] || echo "$((offset + task)) $job $task"
    done <<< "$(paste <(jobs "$sweep" 001) <(offsets "$sweep" 001))"
}

log_of() { # SHARD of the main sweep
    case $1 in [0-5]) echo "$sweep/logs/shard-$1.log" ;; *) echo "$sweep/logs/shard-from-6-$(($1 - 6)).log" ;; esac
}

attempt() { sed -n 's/.*, attempt \([0-9a-f]*\), .*/\1/p' "$1" 2> /dev/null | tail -n 1; } # LOG: who is at it

rows() { # SWEEP ATTEMPT: its rows on disk; none of its buckets may be sealed yet
    cat "$1"/segments/*/"$2"-*.seg 2> /dev/null | sed -n 's/^{"rayreel_segment.*"rows":\([0-9]*\),.*/\1/p' | awk '{n += $1} END {print n + 0}'
}

computed() { # SWEEP SHARD/COUNT: points computed by attempts that lived to tell
    grep -l "\"shard\": \"$2\"" "$1"/attempts/*.json | xargs sed -n 's/^ *"computed": \([0-9]*\).*/\1/p' | awk '{n += $1} END {print n + 0}'
}

other_than() { # NODE SHARD...: a shard runs there that is none of these, and has rows on disk; sets `found`
    local node=$1 shard own
    shift
    found=$(running "$node" | head -n 1)
    [ -n "$found" ] || return 1
    shard=${found%% *}
    for own in "$@"; do [ "$shard" != "$own" ] || return 1; done
    own=$(attempt "$(log_of "$shard")")
    [ -n "$own" ] && [ "$(rows "$sweep" "$own")" -gt 0 ]
}

node_is() { sinfo -h -n "$1" -p normal -o %T | grep -qE "$2"; }
ended() { ! squeue -h -j "$1" 2> /dev/null | grep -q .; }

# --- a trace of such a size that a point takes about a quarter of a second here, so that faults hit shards in their middle
plan() { # NAME VALUES: four times so many points
    cat > "$work/$1.toml" << PLAN
name = "$1"
traces = ["cornell.rtrace"]
machines = ["sgrt-ti2"]
policies = ["full"]
[[axis]]
name = "trv"
key = "ti.trv_l1.size"
log = { from = "4KiB", to = "32KiB" }
[[axis]]
name = "fifo"
key = "ti.ray_fifo_entries"
range = { from = 16, to = $((15 + $2)) }
PLAN
}
plan main 24
plan limit 40
for size in 64x32 96x48 128x64 192x96 256x128 384x192 512x256; do
    "$rayreel" capture cornell --quiet --size $size --samples 2x2 -o "$work/cornell.rtrace" --force > /dev/null
    seconds=$("$rayreel" sweep plan "$work/main.toml" --dry-run --json | sed -n 's/^ *"core_seconds": \([0-9.]*\).*/\1/p')
    ! awk "BEGIN {exit !(${seconds:-0} >= 96 * 0.2)}" || break
done
said "96 points at $size take about ${seconds}s of one core"

# --- the same on this machine
"$rayreel" sweep "$work/main.toml" -o "$work/reference" --quiet > /dev/null 2>&1
cp "$work"/reference/results.* "$work"
said "reference: $(wc -c < "$work/results.parquet") bytes of Parquet"

"$cluster" start
said "Slurm $(sbatch --version | cut -d' ' -f2): 3 nodes"

# --- a time limit, on the third node, while the others go through the rest
"$rayreel" sweep plan "$work/limit.toml" -o "$limit" --no-estimate > /dev/null
"$rayreel" sweep submit "$limit" --shards 1 --flush 0.3s --time 1m --patience 1s --wait -- --nodelist=n3 --signal=B:USR1@30 \
    > "$work/limit.out" 2>&1 &
limited=$!

# --- 1: arrays (two of them: this Slurm takes 6 tasks each) and the merge
"$rayreel" sweep plan "$work/main.toml" -o "$sweep" --no-estimate > /dev/null
"$rayreel" sweep submit "$sweep" --dry-run --shards $shards --engine slurm > "$work/dry.out"
[ ! -e "$sweep/submissions" ] || fail "a dry run wrote something"
"$rayreel" sweep submit "$sweep" --shards $shards --flush 0.3s --patience 2s --time 30m --setup 'echo set up' -- --exclude=n3 |
    tee "$work/submit.out" | sed 's/^/    /'
[ "$(jobs "$sweep" 001 | wc -l)" = 2 ] || fail "8 shards are two arrays where an array has 6 tasks at most"
[ "$(grep -c '^sbatch ' "$work/submit.out")" = 3 ] || fail "submit does not print its three sbatch lines"
merge=$(merge_of "$sweep" 001)
if "$rayreel" sweep submit "$sweep" --shards $shards > /dev/null 2>&1; then fail "a second submission beside the first"; fi

# --- 2: node n1 loses its power in the middle of a shard. Slurm notices later; the other faults come meanwhile.
until_true "n1 has rows of a shard" other_than n1
read -r dead _ <<< "$found"
killed=$(attempt "$(log_of "$dead")")
"$cluster" kill-node 1
dead_rows=$(rows "$sweep" "$killed")
said "n1 is dead, in shard $dead with $dead_rows rows on disk"

# --- 3: a zombie: another attempt at the shard that n2 is doing, as behind a network that came back
until_true "n2 has rows of a shard" other_than n2 "$dead"
read -r twice _ <<< "$found"
"$rayreel" --threads 1 --quiet sweep run "$sweep" --shard "$twice/$shards" > /dev/null 2> "$work/zombie.log" &
zombie=$!
said "a second attempt at shard $twice"
"$rayreel" sweep status "$sweep" --json > "$work/status.json" && fail "status says that all is done"
grep -q '"running": [1-9]' "$work/status.json" || fail "status does not see the running tasks"

# --- 4: the OOM killer: the task fails, and Slurm does not try again
until_true "n2 has rows of another shard" other_than n2 "$dead" "$twice"
read -r oom job task <<< "$found"
killed=$(attempt "$(log_of "$oom")")
"$cluster" kill-task "$job" "$task"
oom_rows=$(rows "$sweep" "$killed")
said "shard $oom is killed, with $oom_rows rows on disk"

# --- 5: preemption by a job of a better partition
until_true "n2 has rows of a third shard" other_than n2 "$dead" "$twice" "$oom"
read -r preempted job task <<< "$found"
sbatch --parsable -p urgent -w n2 -o /dev/null --wrap 'sleep 1' > /dev/null
said "shard $preempted is in the way of an urgent job"

# --- 6: the node comes back, once its death was noticed
until_true "Slurm has noticed the death of n1" node_is n1 down
"$cluster" restore-node 1
until_true "n1 is back" node_is n1 'idle|alloc|mixed'
said "n1 is back"

until_true "the merge has ended" ended "$merge"
wait $zombie || fail "the second attempt failed: $(cat "$work/zombie.log")"
grep -q "^shards that miss points: $oom (of 8, submission 1)" "$sweep/logs/merge-001.log" ||
    fail "merge does not name the killed shard $oom, and it alone: $(cat "$sweep/logs/merge-001.log")"
[ ! -e "$sweep/results.parquet" ] || fail "merge wrote a table with points missing"
scontrol show job "$merge" | grep -q 'ExitCode=3:0' || fail "the merge did not end with code 3"
code=0
"$rayreel" sweep merge "$sweep" > /dev/null 2>&1 || code=$?
[ $code = 3 ] || fail "merge ended with $code, not 3"
said "merge: $(grep '^missing' "$sweep/logs/merge-001.log")"

# --- 7: resume submits that shard alone, and one round is enough
"$rayreel" sweep resume "$sweep" --wait > "$work/resume.out" || fail "resume ended with $?: $(cat "$work/resume.out")"
[ "$(jobs "$sweep" 002 | wc -l)" = 1 ] && grep -q "\"tasks\": \"$((oom % 6))\"" "$sweep/submissions/002.json" ||
    fail "resume submitted something else than shard $oom: $(cat "$sweep/submissions/002.json")"
grep -q -- '--exclude=n3' "$sweep/submissions/002.json" || fail "resume forgot the options"
said "resumed"

# --- 8: the verdict
for file in results.parquet results.csv; do
    cmp "$sweep/$file" "$work/$file" || fail "$file is not that of the local run"
done
"$rayreel" sweep status "$sweep" > /dev/null || fail "status does not say that all is done"
grep -q 'restart [1-9]' "$(log_of "$dead")" || fail "the shard of the dead node was not requeued"
grep -q 'restart [1-9]' "$(log_of "$preempted")" || fail "the preempted shard was not requeued"
grep -q 'interrupted, flushed' "$(log_of "$preempted")" || fail "the preempted shard did not write what it had"
grep -q 'set up' "$(log_of 0)" || fail "--setup was not run"
[ "$dead_rows" -gt 0 ] && [ "$oom_rows" -gt 0 ] || fail "shards were killed before they had rows"
for i in $(seq 0 $((shards - 1))); do
    lost=0
    [ "$i" != "$dead" ] || lost=$dead_rows
    [ "$i" != "$oom" ] || lost=$oom_rows
    count=$(($(computed "$sweep" "$i/$shards") + lost))
    if [ "$i" = "$twice" ]; then
        [ $count -gt 12 ] || fail "shard $i was not computed twice in any point: no second attempt"
    else
        [ $count = 12 ] || fail "shard $i has 12 points and computed $count: finished work was done again, or lost"
    fi
done
said "main sweep: 96 rows, the bytes of the local run"

# --- 9: scancel: what is finished is written, and the job stays cancelled
"$rayreel" sweep plan "$work/main.toml" -o "$work/cancel.sweep" --no-estimate > /dev/null
"$rayreel" sweep submit "$work/cancel.sweep" --shards 1 --flush 10m > /dev/null
array=$(jobs "$work/cancel.sweep" 001)
log=$work/cancel.sweep/logs/shard-0.log
until_true "the shard runs" grep -qs 'to do' "$log"
sleep 2
"$rayreel" sweep cancel "$work/cancel.sweep" > /dev/null
until_true "nothing of it is in the queue" ended "$array"
grep -q 'interrupted, flushed' "$log" || fail "scancel lost what was finished"
[ "$(computed "$work/cancel.sweep" 0/1)" -gt 0 ] || fail "the cancelled shard had computed nothing"
said "cancelled"

# --- 10: the time limit
wait $limited || fail "the sweep with a time limit: $(cat "$work/limit.out")"
log=$limit/logs/shard-0.log
grep -q 'time limit: requeued' "$log" && grep -q 'restart [1-9]' "$log" || fail "no requeue at the time limit"
count=$(computed "$limit" 0/1)
[ "$count" = 160 ] || fail "the sweep with a time limit has 160 points and computed $count"
said "time limit: requeued $(grep -c 'time limit: requeued' "$log") times, 160 rows"

# The cancelled one had time to come back by now, and must not have.
scontrol show job "$array" | grep -q 'JobState=CANCELLED' || fail "a cancelled job came back"
[ "$(grep -c 'to do' "$work/cancel.sweep/logs/shard-0.log")" = 1 ] || fail "a cancelled shard ran again"
said "PASSED"
