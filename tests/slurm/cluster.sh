#!/usr/bin/env bash
# A real Slurm on one machine, to be thrown away: munged, slurmctld and a slurmd for each "node", as daemons of whoever calls it.
# No systemd, no cgroups, nothing in /etc, no root needed. Debian: apt-get install --no-install-recommends slurm-wlm munge
#
#   cluster.sh start                  start it; then: export SLURM_CONF=$SLURM_DIR/slurm.conf
#   cluster.sh stop                   stop it, daemon by daemon
#   cluster.sh kill-node K            node K loses its power
#   cluster.sh restore-node K         and comes back
#   cluster.sh kill-task JOB TASK     one task dies as by the kernel's OOM killer: no TERM, and its node goes on
#   cluster.sh hold-task JOB TASK     one task stands still, unnoticed by its node
#   cluster.sh go-on-task JOB TASK    and goes on
#
# SLURM_DIR (/tmp/rayreel-slurm) holds everything; ports are SLURM_PORT (16820) and the next ones; SLURM_NODES (2) have a CPU each.
set -euo pipefail

dir=${SLURM_DIR:-/tmp/rayreel-slurm}
nodes=${SLURM_NODES:-2}
port=${SLURM_PORT:-16820}
host=$(hostname -s)
user=$(id -un)
# Every job has it in its environment: so processes of this cluster's jobs are told from all others.
name=rayreel$port
export SLURM_CONF=$dir/slurm.conf
PATH=$PATH:/usr/sbin:/sbin

fail() {
    echo "cluster.sh: $*" >&2
    exit 1
}

within() { # SECONDS COMMAND...: until it succeeds
    local end=$((SECONDS + $1))
    shift
    until "$@" > /dev/null 2>&1; do
        [ "$SECONDS" -lt "$end" ] || return 1
        sleep 0.1
    done
}

gone() { # PID: a zombie is gone too, for the first process of a container may reap nobody
    local state
    state=$(ps -o stat= -p "$1" 2> /dev/null) || return 0
    case $state in Z*) return 0 ;; *) return 1 ;; esac
}

job_processes() { # VARIABLE=VALUE...: processes of this cluster's jobs that have all of them in their environment
    local found=(/proc/[0-9]*/environ) variable
    for variable in "SLURM_CLUSTER_NAME=$name" "$@"; do
        # Processes come and go meanwhile, and those of others cannot be read.
        mapfile -t found < <(grep -lzxF -e "$variable" "${found[@]}" /dev/null 2> /dev/null || true)
    done
    sed 's:/proc/\([0-9]*\)/.*:\1:' <<< "$(printf '%s\n' "${found[@]}")"
}

configure() {
    mkdir -p "$dir"/{munge,state,log,run,spool}
    chmod 755 "$dir" "$dir/munge" "$dir/run"
    head -c 128 /dev/urandom > "$dir/munge/key"
    chmod 600 "$dir/munge/key"
    cat > "$SLURM_CONF" << CONF
ClusterName=$name
SlurmctldHost=$host(127.0.0.1)
SlurmctldPort=$port
SlurmUser=$user
SlurmdUser=$user
AuthType=auth/munge
CredType=cred/munge
StateSaveLocation=$dir/state
SlurmdSpoolDir=$dir/spool/%n
SlurmctldPidFile=$dir/run/slurmctld.pid
SlurmdPidFile=$dir/run/slurmd-%n.pid
SlurmctldLogFile=$dir/log/slurmctld.log
SlurmdLogFile=$dir/log/slurmd-%n.log
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
JobAcctGatherType=jobacct_gather/none
AccountingStorageType=accounting_storage/none
MpiDefault=none
SelectType=select/cons_tres
SelectTypeParameters=CR_CPU
SlurmdParameters=config_overrides
ReturnToService=2
JobRequeue=1
MinJobAge=300
# A job of the partition "urgent" throws one of "normal" back into the queue.
PreemptType=preempt/partition_prio
PreemptMode=REQUEUE
# Small, so that splitting is tested too.
MaxArraySize=6
MaxJobCount=1000
# Sites leave these alone; here a test waits. With cred_expire=3 or less Slurm takes its default of 120 s, before which a requeued task
# does not start again.
AuthInfo=socket=$dir/munge/socket,cred_expire=5
SchedulerType=sched/backfill
SchedulerParameters=bf_interval=1,sched_interval=1,batch_sched_delay=0,sched_min_interval=0,defer_batch=0
SlurmdTimeout=5
MessageTimeout=3
InactiveLimit=0
KillWait=4
CONF
    local k
    for k in $(seq "$nodes"); do
        # Debian builds slurmd so that several may run on a machine: by name, each with its port.
        echo "NodeName=n$k NodeHostname=$host NodeAddr=127.0.0.1 Port=$((port + k)) CPUs=1 State=UNKNOWN" >> "$SLURM_CONF"
    done
    cat >> "$SLURM_CONF" << CONF
PartitionName=normal Nodes=ALL Default=YES MaxTime=INFINITE State=UP PriorityTier=1
PartitionName=urgent Nodes=ALL MaxTime=INFINITE State=UP PriorityTier=10
CONF
}

start_node() {
    slurmd -N "n$1" -f "$SLURM_CONF"
}

all_idle() {
    [ "$(timeout 3 sinfo -h -N -p normal -o %T | grep -cx idle)" = "$nodes" ]
}

start() {
    local file k
    for file in "$dir"/run/*.pid "$dir"/munge/munged.pid; do
        [ ! -s "$file" ] || gone "$(cat "$file")" || fail "runs in $dir already (process $(cat "$file")): stop it first"
    done
    for k in $(seq 0 "$nodes"); do
        # Two clusters on one port fail in ways that take long to understand.
        ! (exec 3<> "/dev/tcp/127.0.0.1/$((port + k))") 2> /dev/null || fail "port $((port + k)) is taken: set SLURM_PORT"
    done
    [ ! -e "$dir" ] || [ -d "$dir/munge" ] || fail "$dir is none of ours: set SLURM_DIR"
    rm -rf "$dir"
    configure
    munged --key-file="$dir/munge/key" --socket="$dir/munge/socket" --pid-file="$dir/munge/munged.pid" \
        --log-file="$dir/munge/munged.log" --seed-file="$dir/munge/seed"
    slurmctld -f "$SLURM_CONF"
    for k in $(seq "$nodes"); do start_node "$k"; done
    if ! within 40 all_idle; then
        sinfo -N -l >&2 || true
        tail -n 20 "$dir"/log/*.log >&2
        fail "the nodes do not come up"
    fi
}

stop_daemon() { # PIDFILE: by its process, never by name
    local pid
    [ -s "$1" ] || return 0
    pid=$(cat "$1")
    kill "$pid" 2> /dev/null || true
    within 10 gone "$pid" || kill -9 "$pid" 2> /dev/null || true
    rm -f "$1"
}

stop() {
    local file pid
    # Without this the jobs would outlive their daemons.
    timeout 5 scancel --full --quiet --user="$user" 2> /dev/null || true
    for file in "$dir"/run/slurmd-*.pid; do stop_daemon "$file"; done
    stop_daemon "$dir/run/slurmctld.pid"
    stop_daemon "$dir/munge/munged.pid"
    for pid in $(job_processes "SLURM_CLUSTER_NAME=$name"); do kill -9 "$pid" 2> /dev/null || true; done
}

kill_node() { # the daemon, the stepds that would report the end of the jobs, and the jobs
    local pid parent
    kill -9 "$(cat "$dir/run/slurmd-n$1.pid")"
    rm -f "$dir/run/slurmd-n$1.pid"
    for pid in $(job_processes "SLURMD_NODENAME=n$1"); do
        parent=$(ps -o ppid= -p "$pid" | tr -d ' ' || true)
        case $(ps -o args= -p "${parent:-1}" || true) in slurmstepd*) kill -9 "$parent" 2> /dev/null || true ;; esac
        kill -9 "$pid" 2> /dev/null || true
    done
}

signal_task() { # SIGNAL JOB TASK
    local pid
    for pid in $(job_processes "SLURM_ARRAY_JOB_ID=$2" "SLURM_ARRAY_TASK_ID=$3"); do kill -s "$1" "$pid" 2> /dev/null || true; done
}

case ${1:-} in
    start) start ;;
    stop) stop ;;
    kill-node) kill_node "$2" ;;
    restore-node) start_node "$2" ;;
    kill-task) signal_task KILL "$2" "$3" ;;
    hold-task) signal_task STOP "$2" "$3" ;;
    go-on-task) signal_task CONT "$2" "$3" ;;
    *)
        sed -n '2,14s/^# \{0,1\}//p' "$0"
        exit 2
        ;;
esac
