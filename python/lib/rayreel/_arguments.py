"""Arguments as the native part takes them. What is wrong with one is said by its name."""

from __future__ import annotations

import operator
import os
import re
from typing import Any, Mapping, Sequence, SupportsFloat, SupportsIndex, TypeAlias

import numpy as np

from ._native import Error

#: A frame, a run of them (`range(0, 60)`, or its first and the one behind its last), or the same as text: `0..60`.
Frames: TypeAlias = SupportsIndex | range | tuple[SupportsIndex, SupportsIndex] | str
#: The same of tiles; as text also several runs, such as `0..8,17`.
Tiles: TypeAlias = SupportsIndex | range | tuple[SupportsIndex, SupportsIndex] | str
#: `key=value` once or several times, or values by key.
Overrides: TypeAlias = str | Sequence[str] | Mapping[str, Any]
#: The name of a preset, or a file.
PresetOrFile: TypeAlias = str | bytes | os.PathLike[str] | os.PathLike[bytes]
#: Yes or no, of Python or NumPy.
Flag: TypeAlias = bool | np.bool_
#: Where a file is.
Location: TypeAlias = str | bytes | os.PathLike[str] | os.PathLike[bytes]

_LARGEST = 2**32 - 1


def _shown(value: object) -> str:
    try:
        return repr(value)
    except ValueError:
        # Python writes no number of thousands of digits.
        return f"<unprintable {type(value).__name__} object>"


def whole(argument: str, value: object, largest: int = _LARGEST) -> int:
    """A whole number, of Python or NumPy. Yes and no are none."""
    try:
        number = -1 if isinstance(value, bool) else operator.index(value)  # type: ignore[arg-type]
    except TypeError:
        number = -1
    if not 0 <= number <= largest:
        raise Error(f"{argument} is a whole number from 0 to {largest}, not {_shown(value)}")
    return number


def flag(argument: str, value: object) -> bool:
    """Yes or no. Words and numbers are neither: `"no"` would be yes."""
    if not isinstance(value, (bool, np.bool_)):
        raise Error(f"{argument} is True or False, not {_shown(value)}")
    return bool(value)


def path(wanted: Location) -> str:
    """The path of a file. Only local files are read."""
    try:
        found = os.fsdecode(wanted)
    except TypeError:
        raise Error(f"a path is text, bytes or a path, not {wanted!r}") from None
    if not found:
        raise Error("the path is empty; give that of a file")
    if re.match(r"[A-Za-z][A-Za-z0-9+.-]*://", found):
        raise Error(f"{found} is a URL, and only local files are read; download it, and give the path of the file")
    return found


def _run(argument: str, wanted: range) -> tuple[int, int]:
    if wanted.step != 1 or not wanted:
        raise Error(f"{argument} are a run of numbers, such as range(0, 60), not {_shown(wanted)}")
    return whole(argument, wanted.start), whole(argument, wanted.stop)


def _written(argument: str, digits: str) -> int:
    """The number that digits stand for. Python reads no more than some thousands of them."""
    significant = digits.lstrip("0") or "0"
    if len(significant) > len(str(_LARGEST)):
        raise Error(f"{argument} is a whole number from 0 to {_LARGEST}, not {digits}")
    return int(significant)


def _numbers(argument: str, wanted: object, text: str) -> tuple[int, int]:
    """The first of a run of numbers, and the one behind the last; `text` is how such a run may be written."""
    if isinstance(wanted, range):
        return _run(argument, wanted)
    if isinstance(wanted, tuple):
        if len(wanted) != 2:
            raise Error(f"{argument} as a pair are the first and the one behind the last, not {_shown(wanted)}")
        return _run(argument, range(*(whole(argument, number) for number in wanted)))
    try:
        operator.index(wanted)  # type: ignore[arg-type]
    except TypeError:
        kinds = f"a whole number, a range, a pair of the first and the one behind the last, or text such as {text}"
        raise Error(f"{argument} are {kinds}, not {wanted!r}") from None
    first = whole(argument, wanted, _LARGEST - 1)
    return first, first + 1


def frames(wanted: Frames | None) -> tuple[int, int] | None:
    """The first frame, and the one behind the last."""
    if wanted is None:
        return None
    if isinstance(wanted, str):
        found = re.fullmatch(r"\s*(\d+)\s*(?:\.\.\s*(\d+)\s*)?", wanted, re.ASCII)
        if not found:
            raise Error(f"frames as text are A..B with A below B, such as 0..60, or one number, not {wanted!r}")
        first = _written("frames", found[1])
        return _run("frames", range(first, _written("frames", found[2]) if found[2] else first + 1))
    return _numbers("frames", wanted, "0..60")


def tiles(wanted: Tiles | None) -> str | None:
    """The tiles as text."""
    if wanted is None:
        return None
    if isinstance(wanted, str):
        return text("tiles", wanted)
    first, end = _numbers("tiles", wanted, "0..8,17")
    return f"{first}..{end}"


def overrides(wanted: Overrides | None) -> list[str]:
    """Each as `key=value`."""
    if wanted is None:
        return []
    if isinstance(wanted, Mapping):
        return [text("set", f"{key}={_setting(value)}") for key, value in wanted.items()]
    return texts("set", wanted)


def detail(wanted: str | SupportsFloat) -> str:
    """How much is simulated, as text."""
    if isinstance(wanted, str):
        return text("detail", wanted)
    try:
        # Numbers of Python and NumPy as they write themselves: as a float, one of few digits has more.
        if isinstance(wanted, (int, float, np.generic)):
            return str(wanted)
        if isinstance(wanted, SupportsFloat):
            return str(float(wanted))
    except (TypeError, ValueError, OverflowError):
        pass
    raise Error(f"detail is full, all, counts, a share of the tiles such as 0.05, or precision P, not {_shown(wanted)}")


def _setting(value: object) -> object:
    if isinstance(value, (bool, np.bool_)):
        return "true" if value else "false"
    return value


def text(argument: str, wanted: str) -> str:
    """Text that is UTF-8: what stands for other bytes in the name of a file is none."""
    if not isinstance(wanted, str):
        raise Error(f"{argument} is text, not {wanted!r}")
    try:
        wanted.encode()
    except UnicodeEncodeError:
        raise Error(f"{argument} is no UTF-8: {wanted!r}; files of policies and machines have names in UTF-8") from None
    return wanted


def texts(argument: str, wanted: str | Sequence[str]) -> list[str]:
    """Words, of which one may stand alone."""
    try:
        words = [wanted] if isinstance(wanted, (str, bytes, bytearray)) else list(wanted)
    except TypeError:
        words = [wanted]  # type: ignore[list-item]
    for word in words:
        if not isinstance(word, str):
            raise Error(f"{argument} is made of text, not of {word!r}")
        text(argument, word)
    return words


def preset_or_file(argument: str, wanted: PresetOrFile | None) -> str | None:
    """The name of a preset, or of a file."""
    if wanted is None:
        return None
    try:
        found = os.fsdecode(wanted)
    except TypeError:
        raise Error(f"{argument} is the name of a preset, or a file, not {wanted!r}") from None
    return text(argument, found)


def policy(wanted: object) -> object:
    """The name of a preset or of a file, or an object."""
    return text("policy", os.fsdecode(wanted)) if isinstance(wanted, (str, bytes, os.PathLike)) else wanted


def machine(wanted: PresetOrFile | None) -> str:
    """The name of a preset, or of a file; there is one."""
    name = preset_or_file("machine", wanted)
    if name is None:
        raise Error("simulate takes a machine: the name of a preset, or a file; without one, call replay")
    return name


def asked(
    columns: str | Sequence[str] | None,
    wanted_frames: Frames | None,
    wanted_tiles: Tiles | None,
    wanted_policy: PresetOrFile | None,
    wanted_machine: PresetOrFile | None,
    wanted_overrides: Overrides | None,
    interval: SupportsIndex | None,
) -> dict[str, Any]:
    """How a table is asked for."""
    return {
        "columns": None if columns is None else texts("columns", columns),
        "frames": frames(wanted_frames),
        "tiles": tiles(wanted_tiles),
        "policy": preset_or_file("policy", wanted_policy),
        "machine": preset_or_file("machine", wanted_machine),
        "overrides": overrides(wanted_overrides),
        "interval": None if interval is None else whole("interval", interval, 2**64 - 1),
    }
