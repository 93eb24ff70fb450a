"""Results of sweeps, as tables of Arrow and polars."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from . import _arguments
from ._arguments import Location
from ._native import Error

if TYPE_CHECKING:
    import polars
    import pyarrow


def _file(folder: Location) -> Path:
    path = Path(_arguments.path(folder))
    if path.is_dir():
        path = path / "results.parquet"
    if not path.is_file():
        raise Error(f"{path} is not there; give the folder of a sweep that `rayreel sweep merge` was run on, or a Parquet file")
    return path


def _unreadable(path: Path, error: Exception) -> Error:
    return Error(f"{path} cannot be read as a Parquet file: {error}")


def read_results(folder: Location) -> pyarrow.Table:
    """The table of a sweep: of its folder, or of a Parquet file. Needs pyarrow. Units and meanings stand in the metadata."""
    import pyarrow as pa
    import pyarrow.parquet as pq

    path = _file(folder)
    try:
        return pq.read_table(path)
    except (pa.ArrowException, OSError) as error:
        raise _unreadable(path, error) from error


def open_results(folder: Location) -> polars.DataFrame:
    """The same as a data frame of polars; needs polars."""
    import polars as pl

    path = _file(folder)
    try:
        return pl.read_parquet(path)
    except (pl.exceptions.PolarsError, OSError) as error:
        raise _unreadable(path, error) from error
