"""Results of sweeps as tables."""

import subprocess
from pathlib import Path

import pytest

import rayreel


def test_results_of_a_sweep(program: Path, tmp_path: Path):
    root = Path(__file__).resolve().parents[2]
    plan = tmp_path / "plan.toml"
    trace = root / "traces" / "v1_0_cornell.rtrace"
    plan.write_text(f'traces = ["{trace}"]\nmachines = ["none"]\npolicies = ["full", "adaptive"]\n')
    folder = tmp_path / "sweep"
    subprocess.run([program, "sweep", "plan", plan, "--out", folder, "-q"], check=True, capture_output=True)
    subprocess.run([program, "sweep", "run", folder, "-q"], check=True, capture_output=True)
    subprocess.run([program, "sweep", "merge", folder, "-q"], check=True, capture_output=True)
    frame, table = rayreel.open_results(folder), rayreel.read_results(folder)
    assert frame.height == table.num_rows == 2
    rays = dict(zip(frame["policy"], frame["rays_traced"]))
    for policy in ("full", "adaptive"):
        assert rays[policy] == rayreel.open(trace).replay(policy)["rays_traced"]
    assert rayreel.open_results(folder / "results.parquet").equals(frame)


def test_results_that_are_not_parquet_are_named(tmp_path: Path):
    file = tmp_path / "results.parquet"
    for bytes_there in (b"", b"machine,policy\n", b"PAR1" + bytes(100) + b"PAR1"):
        file.write_bytes(bytes_there)
        for read in (rayreel.read_results, rayreel.open_results):
            with pytest.raises(rayreel.Error, match="results.parquet cannot be read as a Parquet file"):
                read(tmp_path)


def test_a_folder_without_results_is_named(tmp_path: Path):
    with pytest.raises(rayreel.Error, match="results.parquet is not there"):
        rayreel.read_results(tmp_path)
    with pytest.raises(rayreel.Error, match="results.parquet is not there"):
        rayreel.open_results(bytes(tmp_path))
    with pytest.raises(rayreel.Error, match="a path is text, bytes or a path, not None"):
        rayreel.open_results(None)  # type: ignore[arg-type]
