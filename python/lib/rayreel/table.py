"""Tables: columns of equal length, as NumPy arrays."""

from __future__ import annotations

import json
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ItemsView, Iterator, KeysView, Mapping, ValuesView

import numpy as np
import numpy.typing as npt

from . import _native

if TYPE_CHECKING:
    import polars
    import pyarrow


Array = npt.NDArray[Any]


@dataclass(frozen=True)
class Column:
    """What a column of a table is."""

    name: str
    #: u8 to u64, i8, i32, i64, f32, bool or word.
    type: str
    #: Empty where its values have none.
    unit: str
    meaning: str


@dataclass(frozen=True)
class TableInfo:
    """What a table is: the meaning of a row, and its columns."""

    name: str
    row: str
    columns: tuple[Column, ...]


def tables() -> dict[str, TableInfo]:
    """The tables that a trace has, by name."""
    return {
        name: TableInfo(name, row, tuple(Column(*column) for column in columns))
        for name, row, columns in _native.tables()
    }


def _equal(ours: Array, theirs: Array) -> bool:
    return np.array_equal(ours, theirs, equal_nan=ours.dtype.kind == "f")


class Table(Mapping[str, "Array"]):
    """Rows of a table, column by column: `table["t"]` is an array.

    Numbers are the memory in which the rows were made, without a copy. A column of words is an array of text, made when it is first
    asked for; `codes` and `words` give what it is made of.

    It is a mapping of names to arrays, but that its length is the number of rows; `len(table.keys())` is that of columns.
    """

    def __init__(self, info: TableInfo, columns: Mapping[str, Any]) -> None:
        self.info = info
        self._columns = dict(columns)
        self._text: dict[str, Array] = {}

    def __getitem__(self, name: str) -> Array:
        column: Array | tuple[Array, list[str]] = self._columns[name]
        if not isinstance(column, tuple):
            return column
        if name not in self._text:
            codes, words = column
            self._text[name] = np.array(words, dtype=np.str_)[codes] if words else np.array([], dtype=np.str_)
        return self._text[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self._columns)

    # The views of a mapping take its length for the number of names.
    def keys(self) -> KeysView[str]:
        """The names of the columns, in order."""
        return self._columns.keys()

    def values(self) -> ValuesView[Array]:
        """The columns, in order."""
        return self._arrays().values()

    def items(self) -> ItemsView[str, Array]:
        """Names and columns, in order."""
        return self._arrays().items()

    def _arrays(self) -> dict[str, Array]:
        return {name: self[name] for name in self}

    def __len__(self) -> int:
        """Number of rows."""
        for column in self._columns.values():
            return len(column[0] if isinstance(column, tuple) else column)
        return 0

    def __contains__(self, name: object) -> bool:
        return name in self._columns

    def __eq__(self, other: object) -> bool:
        """The same rows of the same columns of the same table. What is no number equals itself: it stands for no value."""
        if not isinstance(other, Table):
            return NotImplemented
        if self.info != other.info or list(self) != list(other):
            return False
        return all(_equal(self[name], other[name]) for name in self)

    def __repr__(self) -> str:
        return f"<rayreel.Table {self.info.name}: {len(self)} rows of {', '.join(self._columns)}>"

    def codes(self, name: str) -> Array:
        """A column of words as codes: `table.words(name)[code]` is the word."""
        return self._word(name)[0]

    def words(self, name: str) -> list[str]:
        """The words of a column, by code."""
        return list(self._word(name)[1])

    def _word(self, name: str) -> tuple[Array, list[str]]:
        column = self._columns[name]
        if not isinstance(column, tuple):
            raise TypeError(f"column {name!r} holds no words; take table[{name!r}]")
        return column

    def vectors(self, name: str) -> Array:
        """Columns `name_x`, `name_y` and `name_z` (or `_r`, `_g` and `_b`) side by side: an array of three columns, copied."""
        for ends in ("xyz", "rgb"):
            parts = [f"{name}_{end}" for end in ends]
            if all(part in self._columns for part in parts):
                return np.stack([self[part] for part in parts], axis=1)
        raise KeyError(f"the table has no columns {name}_x, {name}_y, {name}_z, nor {name}_r, {name}_g, {name}_b")

    def to_arrow(self) -> pyarrow.Table:
        """The same as a table of Arrow; needs pyarrow. Words are dictionaries. Units and meanings stand in the fields' metadata."""
        import pyarrow as pa

        about = {column.name: column for column in self.info.columns}
        arrays, fields = [], []
        for name, column in self._columns.items():
            if isinstance(column, tuple):
                codes, words = column
                array = pa.DictionaryArray.from_arrays(pa.array(codes.astype(np.int32)), pa.array(words, pa.string()))
            else:
                array = pa.array(column)
            metadata = {"unit": about[name].unit, "meaning": about[name].meaning}
            arrays.append(array)
            fields.append(pa.field(name, array.type, nullable=False, metadata=metadata))
        schema = pa.schema(fields, metadata={"rayreel": json.dumps({"table": self.info.name, "row": self.info.row})})
        return pa.Table.from_arrays(arrays, schema=schema)

    def to_polars(self) -> polars.DataFrame:
        """The same as a data frame of polars; needs polars and pyarrow. Words are categories."""
        import polars as pl

        frame = pl.from_arrow(self.to_arrow())
        assert isinstance(frame, pl.DataFrame)
        return frame
