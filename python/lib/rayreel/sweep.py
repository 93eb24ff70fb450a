"""Results of sweeps, as tables of Arrow and polars."""

from __future__ import annotations

import re
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


def _unreadable(path: Path, error: BaseException, reason: str = "") -> Error:
    return Error(f"{path} cannot be read as a Parquet file: {error}{reason}")


def _too_old(version: str) -> str:
    """What is said of a polars that does not know the order of floats in these files."""
    known = tuple(int(number) for number in re.findall(r"\d+", version)[:2])
    return f" (polars {version} may be too old for this file: take 1.43 or later)" if known < (1, 43) else ""


def read_results(folder: Location) -> pyarrow.Table:
    """The table of a sweep: of its folder, or of a Parquet file. Needs pyarrow. Units and meanings stand in the metadata."""
    import pyarrow as pa
    import pyarrow.parquet as pq

    path = _file(folder)
    try:
        # An open file: a path would have to be UTF-8.
        with open(path, "rb") as file:
            return pq.read_table(file)
    except (pa.ArrowException, OSError) as error:
        raise _unreadable(path, error) from error


def open_results(folder: Location) -> polars.DataFrame:
    """The same as a data frame of polars; needs polars."""
    import polars as pl

    path = _file(folder)
    try:
        # An open file: a path would be a pattern too.
        with open(path, "rb") as file:
            return pl.read_parquet(file)
    # Of damaged files polars panics now and then, and that is no `Exception`.
    except (pl.exceptions.PolarsError, pl.exceptions.PanicException, OSError) as error:
        raise _unreadable(path, error, _too_old(pl.__version__)) from error
