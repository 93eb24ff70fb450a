"""Pages print what stands in them. `RAYREEL_BLESS=1` writes what they print now."""

import contextlib
import io
import os
import re
import shlex
import subprocess
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]


def check_python(path: Path, least: int):
    """The Python of a page, one block after the other, prints the text below it."""
    names: dict = {}

    def run(block: re.Match) -> str:
        printed = io.StringIO()
        with contextlib.redirect_stdout(printed):
            exec(block[2], names)
        return block[1] + printed.getvalue() + "```"

    page = path.read_text()
    now, blocks = re.subn(r"(```python\n(.*?)```\n\n```text\n).*?```", run, page, flags=re.S)
    assert blocks >= least
    if os.environ.get("RAYREEL_BLESS"):
        path.write_text(now)
    else:
        assert now == page, "RAYREEL_BLESS=1 writes what it prints now"


def test_the_page_of_the_package(monkeypatch: pytest.MonkeyPatch):
    monkeypatch.chdir(ROOT)
    check_python(ROOT / "docs" / "python.md", 3)


def test_the_page_of_export(program: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.chdir(tmp_path)
    page = ROOT / "docs" / "export.md"
    commands = re.search(r"```console\n(.*?)```", page.read_text(), re.S)
    assert commands
    for command in re.findall(r"^\$ rayreel (.*)$", commands[1], re.M):
        subprocess.run([program, *shlex.split(command), "-q"], check=True, capture_output=True)
    check_python(page, 3)
