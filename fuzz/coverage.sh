#!/usr/bin/env bash
# Builds rayreel-fuzz with LLVM's counters in the crates of this workspace, with the toolchain that is there:
#
#   fuzz/coverage.sh && target/release/rayreel-fuzz --seconds 600
#
# Cargo calls this file as the compiler of the workspace's own crates; dependencies are not built again.
set -euo pipefail

if [[ $# -eq 0 ]]; then
    cd "$(dirname "$0")/.."
    exec env CARGO_INCREMENTAL=0 RUSTC_WORKSPACE_WRAPPER="$PWD/fuzz/coverage.sh" \
        cargo build --locked --release --workspace --features s3 --bin rayreel-fuzz
fi
for word in "$@"; do
    # Neither build scripts nor questions to the compiler have anything to count.
    case $word in build_script_build | ___ | -vV | --print*) exec "$@" ;; esac
done
exec "$@" -C passes=sancov-module -C llvm-args=-sanitizer-coverage-level=3 -C llvm-args=-sanitizer-coverage-inline-8bit-counters
