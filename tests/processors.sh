#!/usr/bin/env bash
# Do builds for different processors give the same traces and the same results?
#
#   tests/processors.sh [FLAGS...]
#
# Builds the tests of captures and of golden replays once for each of FLAGS (words for rustc; by default three: the baseline of
# x86-64, with AVX2 and FMA, and for this machine's processor) and runs them: all built-in scenes at 64x32 must have the digests and
# the bytes of traces/captures.txt, and the golden traces the counters of traces/machine.txt. Each build takes some minutes and goes
# to a folder of its own below target/processors. CARGO_BUILD_TARGET, with a linker and a runner, takes another architecture:
# docs/tests.md has the words for aarch64 under qemu.
set -euo pipefail
cd "$(dirname "$0")/.."

[[ $# -gt 0 ]] || set -- '-C target-cpu=x86-64' '-C target-feature=+avx2,+fma,+bmi2' '-C target-cpu=native'
bad=0
for flags in "$@"; do
    folder="target/processors/$(tr -c 'A-Za-z0-9\n' '_' <<<"$flags")"
    run() {
        RUSTFLAGS="$flags" CARGO_TARGET_DIR="$folder" cargo test --locked --release --quiet "$@" >"$folder.log" 2>&1 && return
        tail -n 30 "$folder.log" >&2
        return 1
    }
    mkdir -p "$folder"
    if run -p rayreel-tracer --test captures && run -p rayreel-replay --test machine_goldens; then
        echo "the same: $flags"
    else
        echo "DIFFERENT: $flags"
        bad=1
    fi
done
exit $bad
