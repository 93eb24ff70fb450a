#!/usr/bin/env python3
"""Does docs/library.md say what is so?

    tests/library_page.py BINARY OUTPUT    the block of `cargo run --release --bin BINARY` against what it printed
    tests/library_page.py dependencies     the crates, features, edition and Rust version of its Cargo.toml against ours

A last line `...` of a block stands for any more lines. With RAYREEL_BLESS=1 a block gets what was printed, as many lines as it had.
"""

import difflib
import os
import re
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
PAGE = ROOT / "docs" / "library.md"


def block(binary: str, output: str) -> None:
    page = PAGE.read_text()
    command = f"$ cargo run --release --bin {binary}\n"
    found = re.search(rf"```console\n{re.escape(command)}(.*?)```", page, re.S)
    if not found:
        sys.exit(f"docs/library.md has no block of {command.strip()}")
    said, printed = found[1].splitlines(), output.splitlines()
    if said and said[-1] == "...":
        printed = [*printed[: len(said) - 1], "..."]
    if said == printed:
        return
    if os.environ.get("RAYREEL_BLESS") == "1":
        PAGE.write_text(page[: found.start(1)] + "".join(f"{line}\n" for line in printed) + page[found.end(1) :])
        print(f"docs/library.md: the block of {binary} is written anew")
        return
    names = ("docs/library.md", f"what {binary} prints")
    print(*difflib.unified_diff(said, printed, *names, lineterm=""), sep="\n", file=sys.stderr)
    sys.exit("docs/library.md says something else; if the change is meant: RAYREEL_BLESS=1 tests/packages.sh, and review the diff")


def value(text: str, key: str) -> str:
    return re.search(rf'^{key} = "(.*?)"', text, re.M)[1]


def dependencies() -> None:
    page = PAGE.read_text()
    manifest = re.search(r"```toml\n(.*?)```", page, re.S)[1]
    workspace = (ROOT / "Cargo.toml").read_text()
    wrong = [
        f"{key} is {value(workspace, key)}"
        for key in ("edition", "rust-version")
        if value(manifest, key) != value(workspace, key)
    ]
    named = re.findall(r'^(\S+) = \{ path = "\.\./rayreel/(\S+)"(?:, features = \[(.*?)\])? \}$', manifest, re.M)
    if len(named) != manifest.count("path = "):
        wrong.append("a dependency is written in another way than this test reads")
    for crate, folder, features in named:
        ours = (ROOT / folder / "Cargo.toml").read_text()
        declared = re.search(r"^\[features\]\n(.*?)(?=^\[|\Z)", ours, re.S | re.M)
        there = set(re.findall(r"^(\S+) = ", declared[1], re.M)) - {"default"} if declared else set()
        taken = set(re.findall(r'"(.*?)"', features))
        if value(ours, "name") != crate:
            wrong.append(f"{folder} is {value(ours, 'name')}, not {crate}")
        if taken != there:
            wrong.append(f"the features of {crate} are {sorted(there)}, not {sorted(taken)}")
        wrong += [f"the table lacks feature {feature} of {crate}" for feature in there if f"`{feature}`" not in page]
    if wrong:
        sys.exit("docs/library.md, Cargo.toml: " + "; ".join(wrong))


if __name__ == "__main__":
    if sys.argv[1:] == ["dependencies"]:
        dependencies()
    elif len(sys.argv) == 3:
        block(sys.argv[1], Path(sys.argv[2]).read_text())
    else:
        sys.exit(__doc__)
