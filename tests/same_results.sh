#!/usr/bin/env bash
# Do two builds of rayreel give the same results, byte for byte?
#
#   tests/same_results.sh OLD/rayreel NEW/rayreel [FOLDER]
#
# Runs both programs on the same inputs, each in a folder of its own, and compares every file and every output: help pages,
# digests, captures, replays under every policy and on every machine, two example sweeps and the paper's experiment at 64x32.
# Prints what differs; exit code 0 if nothing does, 1 otherwise. Takes a few minutes. What is meant to differ is for the reader
# to judge: the changelog must name it. With a FOLDER that holds the runs of one of them already, only the other is run.
set -euo pipefail

[[ $# -ge 2 ]] || { sed -n '2,10p' "$0" >&2; exit 2; }
root=$(cd "$(dirname "$0")/.." && pwd)
old=$(realpath "$1") new=$(realpath "$2")
out=${3:-$(mktemp -d)}
mkdir -p "$out"
traces="$root/traces"

# keep NAME COMMAND...: its output and exit code become a file.
keep() {
    local name=$1 code=0
    shift
    "$@" >"$name.out" 2>"$name.err" || code=$?
    echo "$code" >"$name.code"
}

run() {
    local rayreel=$1
    for page in '' scenes 'scenes list' 'scenes show' render capture info verify digest diff repair replay paper report compare \
        presets 'presets list' 'presets show' sweep 'sweep plan' 'sweep run' 'sweep resume' 'sweep status' 'sweep merge' \
        'sweep submit' 'sweep cancel' 'sweep export'; do
        # shellcheck disable=SC2086 # a page is words
        keep "help-${page// /-}" "$rayreel" $page --help
    done
    keep scenes "$rayreel" scenes list --json
    keep presets "$rayreel" presets list --json
    keep capture "$rayreel" capture cornell --size 64x32 --samples 2x2 -o cornell.rtrace --quiet
    sed -i 's/, [0-9.]* [kM]rays\/s//' capture.out # by the clock
    keep render "$rayreel" render cornell --size 64x32 -o cornell.exr --quiet
    for trace in "$traces"/*.rtrace cornell.rtrace; do
        local stem
        stem=$(basename "$trace" .rtrace)
        keep "digest-$stem" "$rayreel" digest "$trace" --json
        keep "info-$stem" "$rayreel" info "$trace" --json
        keep "verify-$stem" "$rayreel" verify "$trace" --json
    done
    for machine in $("$rayreel" presets list --json | python3 -c 'import json,sys; print(*(m["name"] for m in json.load(sys.stdin)["machines"]))'); do
        keep "presets-$machine" "$rayreel" presets show "$machine" --json
        keep "machine-$machine" "$rayreel" replay "$traces/v1_0_teapot.rtrace" --machine "$machine" --policy full --json --quiet
        keep "page-$machine" "$rayreel" replay "$traces/v1_0_cornell.rtrace" --machine "$machine" --policy full --quiet
    done
    for policy in $("$rayreel" presets list --json | python3 -c 'import json,sys; print(*(p["name"] for p in json.load(sys.stdin)["policies"]))'); do
        keep "presets-policy-$policy" "$rayreel" presets show "$policy" --json
        keep "policy-$policy" "$rayreel" replay "$traces/v1_0_teapot.rtrace" --policy "$policy" --out "policy-$policy" --json --quiet
    done
    keep timeline "$rayreel" replay "$traces/v1_0_cornell.rtrace" --timeline timeline.json --json --quiet
    for plan in caches policies; do
        keep "sweep-$plan" "$rayreel" sweep "$root/examples/sweeps/$plan.toml" --traces "$traces" -o "$plan.sweep" --quiet
        keep "report-$plan" "$rayreel" report "$plan.sweep" --quiet
        rm -rf "$plan.sweep/attempts" "$plan.sweep/sealed" "$plan.sweep/segments" "$plan.sweep/logs"
        rm -f "sweep-$plan.err" "sweep-$plan.out" # they tell seconds
    done
    keep paper "$rayreel" paper --size 64x32 --quiet
    rm -rf rayreel-cache/results # how results are kept is no result
}

for build in old new; do
    [[ -e "$out/$build/whole" ]] && continue
    mkdir -p "$out/$build"
    (cd "$out/$build" && run "${!build}" && touch whole)
done
if diff -rq "$out/old" "$out/new"; then
    echo "the same: $(find "$out/old" -type f | wc -l) files ($out)"
else
    echo "different; the files are in $out" >&2
    exit 1
fi
