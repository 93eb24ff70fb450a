"""A sampling policy written in Python, for trying an idea out."""

from __future__ import annotations

from typing import Protocol, runtime_checkable

from ._native import TileView


@runtime_checkable
class Policy(Protocol):
    """What `Trace.replay` and `Trace.simulate` take as a policy of your own: any object with this method.

    These are used if they are there: an attribute `name` that results show, a method `begin_frame(frame)`, and a method
    `end_frame(tiles)`, which is told what the policy did in each tile.

    In a replay tiles are decided one at a time, but in several threads and in any order, so what `begin_tile` does must depend on the tile alone,
    and on what earlier frames left behind. A policy sees one tile at a time and decides all its samples. It cannot ask for tables or
    replays there: `begin_frame` can.
    """

    def begin_tile(self, view: TileView) -> None:
        """Traces or interpolates every sample of a tile."""
