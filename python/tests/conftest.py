"""What the tests share: the traces of the repository, one captured anew, and the program."""

from __future__ import annotations

import os
import shutil
import subprocess
from pathlib import Path

import pytest

import rayreel

ROOT = Path(__file__).resolve().parents[2]


@pytest.fixture(scope="session")
def program() -> Path:
    """The program `rayreel`: `RAYREEL` says where, else the release build of this tree."""
    target = Path(os.environ.get("CARGO_TARGET_DIR", ROOT / "target"))
    found = os.environ.get("RAYREEL") or shutil.which(str(target / "release" / "rayreel"))
    if not found:
        pytest.skip("there is no program rayreel: build it (cargo build --release), or name it in RAYREEL")
    return Path(found)


@pytest.fixture(scope="session")
def captured(program: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A third trace, of three frames."""
    path = tmp_path_factory.mktemp("captured") / "chess.rtrace"
    command = [program, "capture", "chess", "--size", "48x32", "--samples", "1x1", "--frames", "0..3", "-o", path, "-q"]
    subprocess.run(command, check=True, capture_output=True)
    return path


@pytest.fixture(params=["cornell", "teapot", "chess"])
def path(request: pytest.FixtureRequest) -> Path:
    if request.param == "chess":
        return request.getfixturevalue("captured")
    return ROOT / "traces" / f"v1_0_{request.param}.rtrace"


@pytest.fixture
def cornell() -> rayreel.Trace:
    return rayreel.open(ROOT / "traces" / "v1_0_cornell.rtrace")


@pytest.fixture
def teapot() -> rayreel.Trace:
    return rayreel.open(ROOT / "traces" / "v1_0_teapot.rtrace")
