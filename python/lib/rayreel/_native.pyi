"""The native part: what `rayreel` is made of."""

from typing import Any, Iterable, Iterator, Mapping, SupportsFloat, SupportsIndex, TypeAlias, final

import numpy as np
import numpy.typing as npt

_Array: TypeAlias = npt.NDArray[Any]
_Floats: TypeAlias = npt.NDArray[np.float32]
#: Column and row.
_Sample: TypeAlias = Iterable[SupportsIndex]
_Colour: TypeAlias = Iterable[SupportsFloat]

__all__ = ["Batches", "Error", "Frame", "MODEL_VERSION", "TileView", "Trace", "__version__", "preset", "presets", "tables"]
__version__: str
MODEL_VERSION: int

class Error(ValueError):
    """What was asked for cannot be had, or a file cannot be read."""

@final
class Batches(Iterator[dict[str, Any]]):
    """An iterator of batches, each a dictionary of columns."""

    def __iter__(self) -> Batches: ...
    def __next__(self) -> dict[str, Any]: ...

@final
class Frame:
    """A replayed frame."""

    @property
    def number(self) -> int:
        """Number of the frame."""

    @property
    def image(self) -> _Floats | None:
        """Linear RGB: rows, columns, channels. None without pictures."""

    @property
    def reference(self) -> _Floats | None:
        """The picture of full sampling. None without pictures or comparison."""

    @property
    def flip(self) -> _Floats | None:
        """FLIP of each pixel: rows, columns. None without pictures or comparison."""

    @property
    def states(self) -> npt.NDArray[np.uint8]:
        """What became of each sample, as `State`: rows, columns."""

    @property
    def rounds(self) -> npt.NDArray[np.uint8]:
        """The round of each sample: rows, columns."""

    @property
    def counts(self) -> dict[str, Any]:
        """rays_full, rays_traced, rays_apron, samples_traced, samples_interpolated, similarity_ratio."""

    @property
    def quality(self) -> dict[str, float | None] | None:
        """psnr_db (None for equal pictures), ssim, flip. None without comparison."""

@final
class TileView:
    """A tile of the sample grid while a policy decides it. Columns and rows are those of the frame's grid; arrays have the tile's
    rows and columns. It is of use during the call of `begin_tile` only."""

    @property
    def index(self) -> int:
        """Number of the tile in the frame."""

    @property
    def x(self) -> int:
        """First column."""

    @property
    def y(self) -> int:
        """First row."""

    @property
    def width(self) -> int:
        """Columns."""

    @property
    def height(self) -> int:
        """Rows."""

    @property
    def known(self) -> npt.NDArray[np.bool_]:
        """Which samples are known."""

    @property
    def colours(self) -> _Floats:
        """Colours of the known samples, linear RGB; others are not numbers."""

    @property
    def surfaces(self) -> dict[str, _Array]:
        """Where the primary rays of the known samples met a surface: object (-1 for none), depth, shadows, normal, position.

        `shadows` has two bits a light, the first light in the lowest: `shadows >> 2 * light & 3` is 0 if no ray was cast towards it, 1 if
        it is lit, 2 if something opaque is in the way, 3 if it is seen through something transparent. It is 0 where nothing is known
        too: mask it with `known`."""

    def samples(self) -> npt.NDArray[np.uint32]:
        """Column and row of all samples, row by row."""

    def trace(self, x: SupportsIndex, y: SupportsIndex, round: SupportsIndex = 0, reference: bool | np.bool_ = True) -> None:
        """Traces a sample with all its rays."""

    def trace_mask(self, mask: npt.NDArray[np.bool_], round: SupportsIndex = 0, reference: bool | np.bool_ = True) -> None:
        """Traces the samples where `mask`, of the tile's rows and columns, is true."""

    def interpolate(
        self,
        x: SupportsIndex,
        y: SupportsIndex,
        near: _Sample,
        far: _Sample,
        share: SupportsFloat = 0.5,
        round: SupportsIndex = 1,
    ) -> None:
        """Gives a sample what lies `share` of the way from sample `near` to sample `far`."""

    def copy(self, x: SupportsIndex, y: SupportsIndex, source: _Sample, round: SupportsIndex = 1) -> None:
        """Gives a sample what sample `source` has."""

    def paint(self, x: SupportsIndex, y: SupportsIndex, colour: _Colour, round: SupportsIndex = 1) -> None:
        """Gives a sample a colour, linear RGB of three numbers from 0 to 1e30, and no surface."""

@final
class Trace:
    """A trace that is open."""

    def __new__(cls, path: str, memory: int) -> Trace: ...
    @property
    def frame_numbers(self) -> tuple[int, int]:
        """The first, and the one behind the last."""

    def meta(self) -> dict[str, Any]:
        """What was captured, by name."""

    def camera(self, frame: int | None) -> dict[str, tuple[float, float, float]]:
        """The camera of a frame, the first if none is named."""

    def fingerprint(self) -> str:
        """What the trace holds, in 64 digits."""

    def table(self, what: str, asked: Mapping[str, Any]) -> dict[str, Any]:
        """A table, all of it."""

    def batches(self, what: str, asked: Mapping[str, Any]) -> Batches:
        """A table, batch by batch."""

    def aov(self, frame: int | None, policy: str, overrides: list[str]) -> dict[str, _Array]:
        """What a frame holds beside its colours, and what a policy makes of it: planes by name."""

    def replay(self, request: Mapping[str, Any]) -> tuple[str, list[Frame]]:
        """Replays frames, on a machine if one is named: the report as JSON, and the frames."""

def tables() -> list[tuple[str, str, list[tuple[str, str, str, str]]]]:
    """The tables: name, what a row is, and the columns: name, type, unit, meaning."""

def presets() -> tuple[list[str], list[str]]:
    """Names of the policies and of the machines."""

def preset(name: str, overrides: list[str]) -> str:
    """The values of a policy or a machine, as JSON."""
