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

jobs() { sed -n 's/^ *"job": "\([0-9]*\)".*/\1/p' "$1/submissions/$2.json"; }       # SWEEP NUMBER: ids of its arrays
merge_of() { sed -n 's/^ *"merge": "\([0-9]*\)".*/\1/p' "$1/submissions/$2.json"; } # SWEEP NUMBER: and of its merge

running() { # NODE: "SHARD JOB TASK" of the shard of the main sweep that runs there
    squeue -r -h -t R -w "$1" -j "$first,$second" -o '%F %K' | while read -r job task; do
        echo "$((job == second ? task + 6 : task)) $job $task"
    done
}

log_of() { # SHARD of the main sweep
    case $1 in [0-5]) echo "$sweep/logs/shard-$1.log" ;; *) echo "$sweep/logs/shard-from-6-$(($1 - 6)).log" ;; esac
}

attempt() { sed -n 's/.*, attempt \([0-9a-f]*\), .*/\1/p' "$1" 2> /dev/null | tail -n 1; } # LOG: who is at it

rows() { # SWEEP ATTEMPT: its rows on disk; none of its buckets may be sealed yet
    cat "$1"/segments/*/"$2"-*.seg 2> /dev/null | sed -n 's/^{"rayreel_segment.*"rows":\([0-9]*\),.*/\1/p' | awk '{n += $1} END {print n + 0}'
}

computed() { # SWEEP SHARD/COUNT: points computed by attempts that lived to tell
    local file
    for file in "$1"/attempts/*.json; do
        ! grep -q "\"shard\": \"$2\"" "$file" || sed -n 's/^ *"computed": \([0-9]*\).*/\1/p' "$file"
    done | awk '{n += $1} END {print n + 0}'
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

# --- a trace of such a size that a point takes about 0.4 s here, so that faults hit shards in their middle
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
for size in 64x32 80x40 96x48 112x56 128x64 160x80 192x96 224x112 256x128 320x160; do
    "$rayreel" capture cornell --quiet --size $size --samples 2x2 -o "$work/cornell.rtrace" --force > /dev/null
    seconds=$("$rayreel" sweep plan "$work/main.toml" --dry-run --json | sed -n 's/^ *"core_seconds": \([0-9.]*\).*/\1/p')
    ! awk "BEGIN {exit !(${seconds:-0} >= 96 * 0.35)}" || break
done
said "96 points at $size take about ${seconds%.*} s of one core"

# --- the same on this machine
"$rayreel" sweep "$work/main.toml" -o "$work/reference" --quiet > /dev/null 2>&1
cp "$work"/reference/results.* "$work"
said "reference: $(wc -c < "$work/results.parquet") bytes of Parquet"

"$cluster" start
said "Slurm $(sbatch --version | cut -d' ' -f2): 3 nodes"

# --- a time limit, on the third node, while the others go through the rest: a shard that is far too long for it
plan limit 250
"$rayreel" sweep plan "$work/limit.toml" -o "$limit" --no-estimate > /dev/null
"$rayreel" sweep submit "$limit" --shards 1 --flush 0.3s --time 1m -- --nodelist=n3 --signal=B:USR1@30 > /dev/null

# --- 1: arrays (two of them: this Slurm takes 6 tasks each) and the merge
"$rayreel" sweep plan "$work/main.toml" -o "$sweep" --no-estimate > /dev/null
"$rayreel" sweep submit "$sweep" --dry-run --shards $shards --engine slurm > "$work/dry.out"
[ ! -e "$sweep/submissions" ] || fail "a dry run wrote something"
"$rayreel" sweep submit "$sweep" --shards $shards --flush 0.3s --patience 2s --time 30m --setup 'echo set up' -- --exclude=n3 |
    tee "$work/submit.out" | sed 's/^/    /'
[ "$(jobs "$sweep" 001 | wc -l)" = 2 ] || fail "8 shards are two arrays where an array has 6 tasks at most"
[ "$(grep -c '^sbatch ' "$work/submit.out")" = 3 ] || fail "submit does not print its three sbatch lines"
{ read -r first; read -r second; } <<< "$(jobs "$sweep" 001)"
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
read -r twice job task <<< "$found"
# The first stands still meanwhile. On a machine that is very busy it may have done all before the second has begun.
"$cluster" hold-task "$job" "$task"
"$rayreel" --threads 1 sweep run "$sweep" --shard "$twice/$shards" --flush 0.3s > /dev/null 2> "$work/zombie.log" &
zombie=$!
begun_twice() { again=$(attempt "$work/zombie.log") && [ -n "$again" ] && [ "$(rows "$sweep" "$again")" -gt 0 ]; }
until_true "the second attempt has rows" begun_twice
"$cluster" go-on-task "$job" "$task"
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

# --- 9: the time limit. Slurm looks every 30 seconds for tasks that come near theirs. On a machine that is very busy it may take n3 for
# dead before: it puts the shard back too, and that is not what is tested here
log=$limit/logs/shard-0.log
back() { # an attempt began after the script had put its task back; sets `early` to the one that was put back
    early=$(sed -n '/time limit: back into the queue/q; s/.* to do, attempt \([0-9a-f]*\), .*/\1/p' "$log" | tail -n 1)
    later=$(awk '/time limit: back into the queue/ {put = 1} put && / to do, / {print; exit}' "$log")
    [ -n "$later" ]
}
until_true "the script of the shard with a time limit has put it back" back
[ -s "$limit/attempts/$early.json" ] || fail "attempt $early at the shard with a time limit left no report"
own=$(sed -n 's/^ *"computed": \([0-9]*\).*/\1/p' "$limit/attempts/$early.json")
[ "$own" -gt 0 ] || fail "the shard with a time limit wrote nothing"
# An attempt before it may have been lost with n3; what it wrote counts.
done=$(sed -n 's/.*: \([0-9]*\) skipped, .*/\1/p' <<< "$later")
[ "$done" -ge "$own" ] && grep -q ": $done skipped, $((1000 - done)) to do, .* restart [1-9]" <<< "$later" ||
    fail "$own points were done, and the next attempt does not skip them: $later"
said "time limit: requeued behind $done points"

# --- 10: cancel: what is finished is written, and the task stays cancelled
array=$(jobs "$limit" 001)
attempts() { ls "$limit/attempts" | wc -l; }
at_work() { [ "$(grep -c 'to do' "$log")" -gt "$(attempts)" ]; }
until_true "the shard runs" at_work
before=$(attempts)
done=$(computed "$limit" 0/1)
sleep 2
"$rayreel" sweep cancel "$limit" > /dev/null
another() { [ "$(attempts)" -gt "$before" ]; }
until_true "the cancelled shard has written what it had" another
[ "$(computed "$limit" 0/1)" -gt "$done" ] || fail "cancelling lost what was finished"
until_true "nothing of it is in the queue" ended "$array"
sleep 2
squeue -h -t all -j "$array" -o %T | grep -qx CANCELLED || fail "a cancelled job came back"
[ "$(grep -c 'to do' "$log")" = "$(attempts)" ] || fail "a cancelled shard ran again"
"$rayreel" sweep status "$limit" --json > "$work/status.json" && fail "status says that the cancelled sweep is done"
grep -q '"running": 0' "$work/status.json" && grep -q '"merge": "CANCELLED"' "$work/status.json" || fail "cancel left something in the queue"
said "cancelled"

# --- 11: a task that cannot do its points says so to Slurm too: its script passes the code on
mkdir "$work/empty"
"$rayreel" sweep plan "$work/main.toml" -o "$work/lost.sweep" --no-estimate > /dev/null
"$rayreel" sweep submit "$work/lost.sweep" --shards 1 --traces "$work/empty" --patience 0s > /dev/null
until_true "the merge has ended" ended "$(merge_of "$work/lost.sweep" 001)"
scontrol show job "$(jobs "$work/lost.sweep" 001)" | grep -q 'ExitCode=3:0' || fail "a shard without its trace does not end with code 3"
"$rayreel" sweep status "$work/lost.sweep" > "$work/status.txt" && fail "status says that the sweep without a trace is done"
grep -q ': 1 failed, merge failed' "$work/status.txt" || fail "status does not tell that the task failed: $(cat "$work/status.txt")"
said "a lost trace is told"
said "PASSED"
