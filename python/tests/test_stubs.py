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


def test_types_take_what_is_taken(tmp_path: Path):
    """Numbers of NumPy, and pairs; wrong types are told."""
    pytest.importorskip("mypy", reason="mypy is not installed")
    program = tmp_path / "program.py"
    program.write_text("""
from fractions import Fraction
import numpy as np
import rayreel

trace = rayreel.open(b"t.rtrace", memory=np.int64(64))
one, two = np.int64(1), np.int64(2)
trace.table("rays", frames=one, tiles=one)
trace.table("rays", frames=(one, two), tiles=(0, 3))
trace.table("counters", interval=np.int64(500))
trace.table("rays", tiles=0.5)  # type: ignore[arg-type]
trace.table("samples", policy=b"adaptive")
trace.simulate(b"adaptive", detail=Fraction(1, 2), pictures=np.False_, compare=np.True_)
trace.replay(pictures="no")  # type: ignore[arg-type]

class Mine(rayreel.Trace):
    more = 1

with Mine("t.rtrace") as mine:
    mine.more
names: set[str] = set(trace.table("rays").keys())

def decide(view: rayreel.TileView) -> None:
    for x, y in view.samples():
        view.trace(x, y, reference=np.bool_(x > y))
    view.interpolate(0, 0, (0, 1), (0, 2), share=Fraction(1, 2))
    view.copy(0, 0, [one, 2])
    view.paint(0, 0, np.zeros(3, np.float32))
""")
    settings = Path(__file__).resolve().parents[1] / "pyproject.toml"
    command = [sys.executable, "-m", "mypy", "--config-file", settings, program]
    checked = subprocess.run(command, capture_output=True, text=True, cwd=tmp_path)
    assert checked.returncode == 0, checked.stdout + checked.stderr


def test_types_fit(tmp_path: Path):
    pytest.importorskip("mypy", reason="mypy is not installed")
    settings = Path(__file__).resolve().parents[1] / "pyproject.toml"
    command = [sys.executable, "-m", "mypy", "--config-file", settings, "-p", "rayreel"]
    checked = subprocess.run(command, capture_output=True, text=True, cwd=tmp_path)
    assert checked.returncode == 0, checked.stdout + checked.stderr
