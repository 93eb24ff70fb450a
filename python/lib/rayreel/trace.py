"""Traces: their tables, replays under a policy, simulations on a machine."""

from __future__ import annotations

import json
import os
from dataclasses import dataclass
from enum import IntEnum
from functools import partial
from typing import TYPE_CHECKING, Any, Iterator, Sequence, SupportsFloat, SupportsIndex

import numpy.typing as npt

from . import _arguments, _native
from ._arguments import Flag, Frames, Location, Overrides, PresetOrFile, Tiles
from ._native import Error, Frame
from .policy import Policy
from .table import Table, tables

if TYPE_CHECKING:
    from typing_extensions import Self


class State(IntEnum):
    """What became of a sample: the values of `Frame.states`."""

    #: Traced before any test.
    REFERENCE = 0
    #: Tested, and traced.
    TRACED = 1
    #: Tested; some of its rays were traced, and some hits interpolated.
    PARTIAL = 2
    #: Interpolated.
    INTERPOLATED = 3


@dataclass(frozen=True, repr=False)
class Result:
    """What came of a replay or a simulation."""

    #: What `rayreel replay --json` prints, but for the command, and with None for the trace's digest.
    stats: dict[str, Any]
    #: The frames, in order.
    frames: list[Frame]

    def __getitem__(self, name: str) -> Any:
        """A figure of all frames together, such as `cycles`."""
        return self.stats[name]

    @property
    def counters(self) -> dict[str, Any]:
        """What the machine counted, by name; empty without a machine."""
        return self.stats["counters"] or {}

    def __repr__(self) -> str:
        of, cycles = self.stats["policy"], self.stats["cycles"]
        ran = "" if cycles is None else f", {cycles} cycles"
        if self.stats["machine"] is not None:
            of += f" on {self.stats['machine']}"
        return f"<rayreel.Result of {of}: {len(self.frames)} frames, {self.stats['rays_traced']} rays{ran}>"


class Trace:
    """A trace file that is open; decoding it takes at most `memory` MiB at a time.

    `with` closes it. Where it is copied, or given to another process, its file is opened once more.
    """

    def __init__(self, path: Location, *, memory: SupportsIndex = 1024) -> None:
        self.path = _arguments.path(path)
        self._memory = _arguments.whole("memory", memory)
        self._open: _native.Trace | None = _native.Trace(self.path, self._memory)
        # What is run later may run in another folder.
        self._place = os.path.abspath(self.path)
        self.meta: dict[str, Any] = self._open.meta()

    @property
    def _recorded(self) -> _native.Trace:
        if self._open is None:
            raise Error(f"trace {self.path} is closed; open it again")
        return self._open

    def close(self) -> None:
        """Lets go of the file: nothing can be asked of the trace any more. Batches that were begun go on."""
        self._open = None

    def __enter__(self) -> Self:
        self._recorded  # Raises if it is closed.
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def __reduce__(self) -> tuple[Any, ...]:
        self._recorded  # Raises if it is closed.
        return partial(type(self), memory=self._memory), (self._place,)

    def __repr__(self) -> str:
        meta = self.meta
        return f"<rayreel.Trace {meta['scene']}: {meta['frames']} frames of {meta['width']} x {meta['height']} pixels>"

    @property
    def fingerprint(self) -> str:
        """What the trace holds, in 64 digits; the same in reports and in tables of sweeps."""
        return self._recorded.fingerprint()

    @property
    def frame_numbers(self) -> range:
        """The numbers of its frames."""
        return range(*self._recorded.frame_numbers)

    def camera(self, frame: SupportsIndex | None = None) -> dict[str, tuple[float, float, float]]:
        """The camera of a frame, the first if none is named: `eye`, and from it `corner` to the upper left corner of the picture, `right`
        and `down` from sample to sample. The ray through sample x, y goes along corner + right * (x + 0.5) + down * (y + 0.5)."""
        return self._recorded.camera(None if frame is None else _arguments.whole("frame", frame))

    def table(
        self,
        what: str,
        *,
        columns: str | Sequence[str] | None = None,
        frames: Frames | None = None,
        tiles: Tiles | None = None,
        policy: PresetOrFile | None = None,
        machine: PresetOrFile | None = None,
        set: Overrides | None = None,
        interval: SupportsIndex | None = None,
    ) -> Table:
        """A table, all of it in memory: `rays`, `hits`, `steps`, `addresses`, `samples`, `nodes`, `triangles`, `lookups`,
        `requests`, `counters` or `tiles`. The arguments are the options of `rayreel export`; one that means nothing for
        the table is refused. Of columns that are not asked for nothing is kept."""
        asked = _arguments.asked(columns, frames, tiles, policy, machine, set, interval)
        columns_by_name = self._recorded.table(_arguments.text("what", what), asked)
        return Table(tables()[what], columns_by_name)

    def batches(
        self,
        what: str,
        *,
        columns: str | Sequence[str] | None = None,
        frames: Frames | None = None,
        tiles: Tiles | None = None,
        policy: PresetOrFile | None = None,
        machine: PresetOrFile | None = None,
        set: Overrides | None = None,
        interval: SupportsIndex | None = None,
    ) -> Iterator[Table]:
        """The same table in parts of some 100 000 rows, 131 072 at most, made in the background: memory does not depend on its
        length. Each part has rows, but that of a table without any."""
        asked = _arguments.asked(columns, frames, tiles, policy, machine, set, interval)
        batches = self._recorded.batches(_arguments.text("what", what), asked)
        # Unlike a generator, this goes on after an interruption.
        return map(partial(Table, tables()[what]), batches)

    def aov(
        self,
        frame: SupportsIndex | None = None,
        *,
        policy: PresetOrFile = "adaptive",
        set: Overrides | None = None,
    ) -> dict[str, npt.NDArray[Any]]:
        """What a frame holds beside its colours, the first if none is named, and what a policy makes of it: by name planes of rows
        and columns, with the names of the channels that `rayreel aov` writes, such as `depth.Z`, `normal.X` and `work.node_visits`."""
        number = None if frame is None else _arguments.whole("frame", frame)
        name = _arguments.preset_or_file("policy", policy)
        if name is None:
            raise Error("aov takes a policy: the name of a preset, or a file")
        return self._recorded.aov(number, name, _arguments.overrides(set))

    def replay(
        self,
        policy: PresetOrFile | Policy = "adaptive",
        *,
        set: Overrides | None = None,
        frames: Frames | None = None,
        pictures: Flag = True,
        compare: Flag = True,
    ) -> Result:
        """Replays frames under a policy, without a machine. The policy is a preset, a file, or an object of yours (`Policy`).
        Without `compare` there is no reference and no quality; without `pictures` frames keep none."""
        return self._replay(policy, None, set, frames, None, pictures, compare)

    def simulate(
        self,
        policy: PresetOrFile | Policy = "adaptive",
        machine: PresetOrFile = "sgrt-ti2",
        *,
        set: Overrides | None = None,
        frames: Frames | None = None,
        detail: str | SupportsFloat = "full",
        pictures: Flag = True,
        compare: Flag = True,
    ) -> Result:
        """The same on a machine: a preset or a file. `detail` is that of `rayreel replay`: `full`, `all`, `counts`, a share of the
        tiles, or `precision P`. Under a policy of yours every cycle is simulated, whatever share is asked for."""
        return self._replay(policy, _arguments.machine(machine), set, frames, _arguments.detail(detail), pictures, compare)

    def _replay(
        self,
        policy: PresetOrFile | Policy,
        machine: str | None,
        overrides: Overrides | None,
        frames: Frames | None,
        detail: str | None,
        pictures: Flag,
        compare: Flag,
    ) -> Result:
        request = {
            "policy": _arguments.policy(policy),
            "machine": machine,
            "overrides": _arguments.overrides(overrides),
            "frames": _arguments.frames(frames),
            "detail": detail,
            "pictures": _arguments.flag("pictures", pictures),
            "compare": _arguments.flag("compare", compare),
        }
        stats, kept = self._recorded.replay(request)
        return Result(json.loads(stats), kept)


def open(path: Location, *, memory: SupportsIndex = 1024) -> Trace:
    """Opens a trace file on this computer; decoding it takes at most `memory` MiB at a time."""
    return Trace(path, memory=memory)


def presets() -> dict[str, list[str]]:
    """The names of the built-in policies and machines."""
    policies, machines = _native.presets()
    return {"policies": policies, "machines": machines}


def preset(name: PresetOrFile, *, set: Overrides | None = None) -> dict[str, Any]:
    """The values of a policy or a machine, a preset or a file: what `rayreel presets show NAME --json` prints. Those of a machine are
    numbers, or text with a unit, each with its class and source."""
    given = _arguments.preset_or_file("name", name)
    if given is None:
        raise Error("name is the name of a preset, or a file, not None")
    values: dict[str, Any] = json.loads(_native.preset(given, _arguments.overrides(set)))
    return values
