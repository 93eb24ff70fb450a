"""Pages print what stands in them."""

import contextlib
import io
import re
import shlex
import subprocess
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]


def check_python(page: str, least: int):
    """The Python of a page, one block after the other, prints the text below it."""
    blocks = re.findall(r"```python\n(.*?)```\n\n```text\n(.*?)```", page, re.S)
    assert len(blocks) >= least
    names: dict = {}
    for code, expected in blocks:
        printed = io.StringIO()
        with contextlib.redirect_stdout(printed):
            exec(code, names)
        assert printed.getvalue() == expected


def test_the_page_of_the_package(monkeypatch: pytest.MonkeyPatch):
    monkeypatch.chdir(ROOT)
    check_python((ROOT / "docs" / "python.md").read_text(), 3)


def test_the_page_of_export(program: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.chdir(tmp_path)
    page = (ROOT / "docs" / "export.md").read_text()
    commands = re.search(r"```console\n(.*?)```", page, re.S)
    assert commands
    for command in re.findall(r"^\$ rayreel (.*)$", commands[1], re.M):
        subprocess.run([program, *shlex.split(command), "-q"], check=True, capture_output=True)
    check_python(page, 3)
