#!/usr/bin/env bash
# Packages as users have them: those that they write beside the tree, and the Python package as `pip install ./python` sets it up.
# Dependencies are built once more with other features, which takes minutes, so this is a check of its own; the Python package's
# tests also run with all others, on what cargo built. What docs/library.md says that they print is compared: `RAYREEL_BLESS=1
# tests/packages.sh` writes what they print now, there, in docs/python.md and docs/export.md, and in the notebook.
set -euo pipefail
cd "$(dirname "$0")/.."

target="$(realpath -m "${CARGO_TARGET_DIR:-target}")"
out_of_tree() { (cd examples/out_of_tree && CARGO_TARGET_DIR="$target" cargo run --locked --release --quiet --bin "$1"); }
python3 tests/library_page.py dependencies
for binary in policy probe; do
    out_of_tree "$binary" >"$target/$binary.txt"
    python3 tests/library_page.py "$binary" "$target/$binary.txt"
done
CARGO_TARGET_DIR="$target" cargo build --locked --release --quiet --bin rayreel # what the tests compare the package with
python3 -m venv "$target/python"
CARGO_TARGET_DIR="$target" "$target/python/bin/pip" install --quiet './python[test,notebook]'
CARGO_TARGET_DIR="$target" "$target/python/bin/python" -m pytest --quiet python/tests
