"""Tables as arrays: the same values as in the program's files."""

import copy
import multiprocessing
import operator
import os
import pickle
import subprocess
from pathlib import Path

import numpy as np
import polars as pl
import pyarrow as pa
import pytest

import rayreel

SIMULATED = ["lookups", "requests", "counters", "tiles"]


def test_tables_are_declared():
    tables = rayreel.tables()
    assert list(tables)[:3] == ["rays", "hits", "steps"] and len(tables) == 11
    t = next(column for column in tables["rays"].columns if column.name == "t")
    assert (t.type, t.unit) == ("f32", "lengths of the direction") and "miss" in t.meaning


@pytest.mark.parametrize("what", rayreel.tables())
def test_files_equal_arrays(path: Path, what: str, program: Path, tmp_path: Path):
    """What polars reads of the program's Parquet file is what Python has, value by value; so are the batches."""
    policy = ["--policy", "adaptive"] if what in SIMULATED + ["samples"] else []
    file = tmp_path / "table.parquet"
    subprocess.run([program, "export", path, "--what", what, "-o", file, "-q", *policy], check=True, capture_output=True)
    there = pl.read_parquet(file)
    trace = rayreel.open(path)
    here = trace.table(what, policy="adaptive" if policy else None)
    assert len(here) == there.height > 0 and list(here) == there.columns
    for name in here:
        np.testing.assert_array_equal(here[name], there[name].to_numpy(), err_msg=name)
    batches = list(trace.batches(what, policy="adaptive" if policy else None))
    for name in here:
        np.testing.assert_array_equal(np.concatenate([batch[name] for batch in batches]), here[name], err_msg=name)
    frame = here.to_polars()
    assert frame.shape == there.shape
    assert frame.cast({pl.Categorical: pl.String}).equals(there.cast({pl.Categorical: pl.String}), null_equal=True)


def test_numbers_are_not_copied(cornell: rayreel.Trace):
    rays = cornell.table("rays")
    assert rays["t"] is rays["t"] and not rays["t"].flags.owndata, "the array is over the memory of the rows"
    arrow = rays.to_arrow()
    assert arrow["t"].chunk(0).buffers()[1].address == rays["t"].ctypes.data
    assert arrow.schema.field("t").metadata[b"unit"] == b"lengths of the direction"
    assert pa.types.is_dictionary(arrow.schema.field("kind").type)


def test_columns_frames_and_tiles(teapot: rayreel.Trace):
    some = teapot.table("rays", columns=["t", "frame", "tile"], frames=31, tiles="0..2")
    assert list(some) == ["t", "frame", "tile"]
    assert set(some["frame"]) == {31} and set(some["tile"]) == {0, 1}
    whole = teapot.table("rays")
    assert len(some) == int(((whole["frame"] == 31) & (whole["tile"] < 2)).sum())
    assert whole.vectors("origin").shape == (len(whole), 3)


def test_frames_and_tiles_may_be_said_in_many_ways(teapot: rayreel.Trace):
    one = teapot.table("rays", frames=31, tiles="1")
    ways = [(np.int64(31), 1), ("31", np.int64(1)), (range(31, 32), range(1, 2)), ((31, 32), "1..2"), ("31", (1, 2))]
    for frames, tiles in ways:
        assert teapot.table("rays", frames=frames, tiles=tiles) == one
    assert teapot.table("rays", frames="30..32") == teapot.table("rays")
    assert list(teapot.table("rays", columns="t")) == ["t"]


def test_tables_are_compared_by_value(cornell: rayreel.Trace):
    rays = cornell.table("rays", columns=["kind", "t"])
    assert rays == cornell.table("rays", columns=["kind", "t"])
    assert not rays != cornell.table("rays", columns=["kind", "t"])
    assert rays != cornell.table("rays", columns=["kind"]) and rays != cornell.table("rays", columns=["kind", "t"], tiles=0)
    changed = cornell.table("rays", columns=["kind", "t"])
    changed["t"][0] += 1
    assert rays != changed and rays != 3 and rays != dict(rays)
    changed["t"][0] = rays["t"][0] = np.nan
    assert rays == changed, "no value is no value"


def test_keys_values_and_items_are_those_of_the_columns(cornell: rayreel.Trace):
    rays = cornell.table("rays", columns=["kind", "t"])
    assert len(rays) == 10051 and len(rays.keys()) == len(rays.values()) == len(rays.items()) == 2
    assert rays.keys() == {"kind", "t"} and list(rays.keys()) == list(rays) == ["kind", "t"]
    assert [name for name, _ in rays.items()] == ["kind", "t"] and dict(rays.items())["t"] is rays["t"]
    assert list(rays.values())[0][0] == "primary" and dict(rays).keys() == rays.keys()


def test_no_part_is_empty_and_none_is_large(teapot: rayreel.Trace):
    sizes = [len(batch) for batch in teapot.batches("steps")]
    assert sum(sizes) == len(teapot.table("steps", columns="number")) and len(sizes) > 4
    assert 0 < min(sizes) and max(sizes) <= 131072


def test_words(cornell: rayreel.Trace):
    rays = cornell.table("rays")
    assert rays["kind"][0] == "primary" and rays.words("kind")[rays.codes("kind")[0]] == "primary"
    with pytest.raises(TypeError, match="holds no words"):
        rays.codes("t")


@pytest.mark.parametrize(
    ("asked", "says"),
    [
        ({"what": "rayz"}, "there is no table"),
        ({"what": None}, "what is text, not None"),
        ({"what": "samples", "policy": b"/p\xff.toml"}, "policy is no UTF-8"),
        ({"what": "lookups", "machine": "\udcff"}, "machine is no UTF-8"),
        ({"what": "rays", "columns": ["\udcff"]}, "columns is no UTF-8"),
        ({"what": "rays", "tiles": "\udcff"}, "tiles is no UTF-8"),
        ({"what": "samples", "policy": "adaptive", "set": {"block": "\udcff"}}, "set is no UTF-8"),
        ({"what": "rays", "columns": ["q"]}, "no column"),
        ({"what": "rays", "columns": []}, "no column is asked for"),
        ({"what": "rays", "policy": "full"}, "whatever a policy makes of it"),
        ({"what": "rays", "machine": "sgrt-ti2"}, "the same for every machine"),
        ({"what": "rays", "set": {"block": 4}}, "is for a policy, and table rays takes no policy; leave it out"),
        ({"what": "rays", "set": {"ti.trv": 4}}, "is for a machine, and table rays is the same for every machine; leave it out"),
        ({"what": "samples", "set": {"block": 4}}, "is for a policy, and there is none; name one, or leave it out"),
        ({"what": "lookups", "tiles": 0}, "table lookups takes no tiles: a machine works on whole frames; leave it out"),
        ({"what": "nodes", "tiles": 0}, "table nodes takes no tiles: it is not of tiles; leave it out"),
        ({"what": "triangles", "frames": 0}, "table triangles is the same for all frames; leave frames out"),
        ({"what": "rays", "interval": 7}, "interval is for table counters, not for rays; leave it out"),
        ({"what": "tiles", "interval": 1000}, "interval is for table counters, not for tiles; leave it out"),
        ({"what": "rays", "frames": 7}, "frame 7 is not in the trace"),
        ({"what": "rays", "frames": range(0, 4, 2)}, "a run of numbers"),
        ({"what": "rays", "frames": -1}, "frames is a whole number.*not -1"),
        ({"what": "rays", "frames": (0, -1)}, "frames is a whole number.*not -1"),
        ({"what": "rays", "frames": (0, 1, 2)}, "frames as a pair"),
        ({"what": "rays", "frames": "9" * 5000}, "frames is a whole number from 0 to 4294967295, not 999"),
        ({"what": "rays", "frames": 1 << 20000}, "frames is a whole number from 0 to"),
        ({"what": "rays", "frames": True}, "frames is a whole number.*not True"),
        ({"what": "rays", "tiles": (0, True)}, "tiles is a whole number.*not True"),
        ({"what": "counters", "interval": True}, "interval is a whole number.*not True"),
        ({"what": "rays", "columns": b"t"}, "columns is made of text, not of b't'"),
        ({"what": "rays", "frames": 0.5}, "frames are a whole number, a range, a pair.*such as 0..60, not 0.5"),
        ({"what": "rays", "frames": [0]}, r"frames are a whole number, a range, a pair.*such as 0..60, not \[0\]"),
        ({"what": "rays", "tiles": [0]}, r"tiles are a whole number, a range, a pair.*such as 0..8,17, not \[0\]"),
        ({"what": "rays", "tiles": (3, 0)}, "tiles are a run of numbers"),
        ({"what": "rays", "tiles": (0, 1, 2)}, "tiles as a pair"),
        ({"what": "rays", "frames": "2..1"}, "frames are a run of numbers"),
        ({"what": "rays", "frames": "first"}, "frames as text are A..B"),
        ({"what": "rays", "tiles": -1}, "tiles is a whole number.*not -1"),
        ({"what": "rays", "columns": [3]}, "columns is made of text"),
        ({"what": "rays", "policy": 3}, "policy is the name of a preset"),
        ({"what": "rays", "machine": 3}, "machine is the name of a preset"),
        ({"what": "counters", "set": 3}, "set is made of text"),
        ({"what": "counters", "interval": -1}, "interval is a whole number.*not -1"),
        ({"what": "rays", "tiles": "900"}, "tile 900 is not in the trace"),
        ({"what": "counters", "interval": 0}, "never ends"),
    ],
)
def test_wrong_questions_are_answered(cornell: rayreel.Trace, asked: dict, says: str):
    for get in (cornell.table, cornell.batches):
        with pytest.raises(rayreel.Error, match=says):
            get(**asked)


def test_batches_may_be_left(cornell: rayreel.Trace):
    batches = cornell.batches("steps")
    next(batches)
    del batches


def test_files_that_are_no_traces(tmp_path: Path):
    with pytest.raises(rayreel.Error, match="cannot open"):
        rayreel.open(tmp_path / "none.rtrace")
    (tmp_path / "bad.rtrace").write_bytes(b"not a trace")
    with pytest.raises(rayreel.Error):
        rayreel.open(tmp_path / "bad.rtrace")


def test_paths_may_be_bytes_and_are_of_files(cornell: rayreel.Trace):
    assert rayreel.open(os.fsencode(cornell.path)).path == cornell.path
    assert len(rayreel.open(Path(cornell.path)).table("nodes")) > 0
    with pytest.raises(rayreel.Error, match="https://host/t.rtrace is a URL, and only local files are read"):
        rayreel.open("https://host/t.rtrace")
    with pytest.raises(rayreel.Error, match="the path is empty"):
        rayreel.open("")
    with pytest.raises(rayreel.Error, match="a path is text, bytes or a path, not 3"):
        rayreel.open(3)


def test_a_trace_that_is_closed_is_of_no_use(cornell: rayreel.Trace):
    with rayreel.open(cornell.path) as trace:
        batches = trace.batches("rays")
        fingerprint = trace.fingerprint
    assert fingerprint == cornell.fingerprint and sum(map(len, batches)) == 10051, "what was begun goes on"
    asks = [
        lambda: trace.table("rays"),
        lambda: trace.batches("rays"),
        lambda: trace.replay("full"),
        lambda: trace.fingerprint,
        lambda: trace.frame_numbers,
        lambda: pickle.dumps(trace),
        lambda: trace.__enter__(),
    ]
    for ask in asks:
        with pytest.raises(rayreel.Error, match="is closed; open it again"):
            ask()
    trace.close()


def test_a_trace_may_be_copied_and_given_away(cornell: rayreel.Trace, monkeypatch: pytest.MonkeyPatch, tmp_path: Path):
    monkeypatch.chdir(Path(cornell.path).parent)
    trace = rayreel.open("v1_0_cornell.rtrace", memory=64)
    monkeypatch.chdir(tmp_path)
    for other in (copy.copy(trace), copy.deepcopy(trace), pickle.loads(pickle.dumps(trace))):
        trace.close()
        assert other.fingerprint == cornell.fingerprint and other._memory == 64
        trace = other
    # Another process opens the file anew.
    with multiprocessing.get_context("spawn").Pool(1) as pool:
        assert pool.apply(operator.attrgetter("fingerprint"), (trace,)) == cornell.fingerprint
        there = pool.apply(operator.methodcaller("table", "rays"), (trace,))
    assert there == cornell.table("rays")


def test_memory_is_bounded(cornell: rayreel.Trace):
    with pytest.raises(rayreel.Error, match="memory for decoding"):
        rayreel.open(cornell.path, memory=0)
    with pytest.raises(rayreel.Error, match="memory is a whole number"):
        rayreel.open(cornell.path, memory=-1)
    with pytest.raises(rayreel.Error, match="memory is a whole number.*not True"):
        rayreel.open(cornell.path, memory=True)
    assert len(rayreel.open(cornell.path, memory=64).table("rays")) > 0
