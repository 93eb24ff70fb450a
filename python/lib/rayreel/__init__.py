"""Record what a ray tracer does once; replay it through models of a mobile ray-tracing GPU.

    >>> import rayreel
    >>> trace = rayreel.open("traces/v1_0_cornell.rtrace")
    >>> rays = trace.table("rays", columns=["kind", "t"])
    >>> rays["t"].dtype, len(rays)
    (dtype('float32'), 10051)
    >>> trace.simulate(policy="adaptive", machine="sgrt-ti2").stats["cycles"]  # doctest: +SKIP

Everything here is a pure function of its arguments: neither the clock nor the number of threads enters a result.
"""

from ._native import MODEL_VERSION, Error, Frame, TileView, __version__
from .policy import Policy
from .sweep import open_results, read_results
from .table import Column, Table, TableInfo, tables
from .trace import Result, State, Trace, open, preset, presets

__all__ = [
    "Column",
    "Error",
    "Frame",
    "MODEL_VERSION",
    "Policy",
    "Result",
    "State",
    "Table",
    "TableInfo",
    "TileView",
    "Trace",
    "__version__",
    "open",
    "open_results",
    "preset",
    "presets",
    "read_results",
    "tables",
]
