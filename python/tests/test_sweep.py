"""Results of sweeps as tables."""

import os
import subprocess
import sys
from pathlib import Path

import polars as pl
import pyarrow as pa
import pyarrow.parquet as pq
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


@pytest.mark.parametrize("name", [b"a[1]", b"a*", b"{a,b}", b"policy=zzz", b"\xff"])
def test_the_name_of_a_folder_is_no_pattern(tmp_path: Path, name: bytes):
    """Beside it lies one that the pattern would find."""
    if name == b"\xff" and sys.platform != "linux":
        pytest.skip("names of files are text here")
    folders = [os.path.join(os.fsencode(tmp_path), each) for each in (name, b"a1")]
    for number, folder in enumerate(folders):
        os.mkdir(folder)
        with open(os.path.join(folder, b"results.parquet"), "wb") as file:
            pq.write_table(pa.table({"x": [number]}), file)
    assert rayreel.open_results(folders[0]).to_dict(as_series=False) == {"x": [0]}
    assert rayreel.read_results(folders[0]).to_pydict() == {"x": [0]}


def test_a_panic_and_an_old_polars_are_told(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    def panics(file: object) -> None:
        raise pl.exceptions.PanicException("unwrap")

    (tmp_path / "results.parquet").touch()
    monkeypatch.setattr(pl, "read_parquet", panics)
    for version, old in [("1.42.1", True), ("1.43.0", False), ("2.0.0", False)]:
        monkeypatch.setattr(pl, "__version__", version)
        with pytest.raises(rayreel.Error, match="cannot be read as a Parquet file: unwrap") as told:
            rayreel.open_results(tmp_path)
        assert (f"polars {version} may be too old for this file: take 1.43 or later" in str(told.value)) == old


def test_a_folder_without_results_is_named(tmp_path: Path):
    with pytest.raises(rayreel.Error, match="results.parquet is not there"):
        rayreel.read_results(tmp_path)
    with pytest.raises(rayreel.Error, match="results.parquet is not there"):
        rayreel.open_results(bytes(tmp_path))
    with pytest.raises(rayreel.Error, match="a path is text, bytes or a path, not None"):
        rayreel.open_results(None)  # type: ignore[arg-type]
