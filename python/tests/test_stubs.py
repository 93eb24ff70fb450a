"""The stubs say what the native part is."""

import subprocess
import sys
from pathlib import Path

import pytest


def test_stubs_fit(tmp_path: Path):
    pytest.importorskip("mypy.stubtest", reason="mypy is not installed")
    settings = Path(__file__).resolve().parents[1] / "pyproject.toml"
    command = [sys.executable, "-m", "mypy.stubtest", "rayreel._native", "--mypy-config-file", settings]
    # From elsewhere: what is installed is checked, not what lies beside the tests.
    checked = subprocess.run(command, capture_output=True, text=True, cwd=tmp_path)
    assert checked.returncode == 0, checked.stdout + checked.stderr


def test_types_fit(tmp_path: Path):
    pytest.importorskip("mypy", reason="mypy is not installed")
    settings = Path(__file__).resolve().parents[1] / "pyproject.toml"
    command = [sys.executable, "-m", "mypy", "--config-file", settings, "-p", "rayreel"]
    checked = subprocess.run(command, capture_output=True, text=True, cwd=tmp_path)
    assert checked.returncode == 0, checked.stdout + checked.stderr
