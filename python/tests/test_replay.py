"""Replays and simulations: the same figures as the program's, pictures as arrays."""

import json
import os
import signal
import subprocess
import threading
import time
from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest

import rayreel
from rayreel import State


class Full:
    """Traces every sample."""

    def begin_tile(self, view: rayreel.TileView) -> None:
        view.trace_mask(np.ones((view.height, view.width), np.bool_))


#: What only the program knows.
PROGRAM = ["command", "trace_digest"]


def figures(stats: dict) -> dict:
    return {key: value for key, value in stats.items() if key not in PROGRAM}


@pytest.mark.parametrize("policy", ["adaptive", "multirate", "full"])
def test_figures_equal_the_programs(path: Path, program: Path, policy: str):
    command = [program, "replay", path, "--policy", policy, "--machine", "none", "--json", "-q"]
    there = json.loads(subprocess.run(command, check=True, capture_output=True).stdout)
    assert figures(rayreel.open(path).replay(policy).stats) == figures(there)


@pytest.mark.parametrize("detail", ["full", "counts", 0.5])
def test_simulations_equal_the_programs(path: Path, program: Path, detail):
    options = ["--policy", "paper-ss", "--set", "ti.trv_l1.size=8KiB", "--set", "block=4", "--detail", str(detail)]
    command = [program, "replay", path, *options, "--json", "-q"]
    there = json.loads(subprocess.run(command, check=True, capture_output=True).stdout)
    here = rayreel.open(path).simulate("paper-ss", set=["ti.trv_l1.size=8KiB", "block=4"], detail=detail)
    assert figures(here.stats) == figures(there) and here.counters
    by_name = rayreel.open(path).simulate("paper-ss", set={"ti.trv_l1.size": "8KiB", "block": 4}, detail=detail)
    assert by_name.stats == here.stats


def test_the_program_finds_the_same_run_equal(captured: Path, program: Path, tmp_path: Path):
    here, there = tmp_path / "here.json", tmp_path / "there.json"
    here.write_text(json.dumps(rayreel.open(captured).simulate("adaptive").stats))
    command = [program, "replay", captured, "--json", "-q"]
    there.write_bytes(subprocess.run(command, check=True, capture_output=True).stdout)
    compared = subprocess.run([program, "compare", here, there], capture_output=True, text=True)
    assert compared.returncode == 0, compared.stdout + compared.stderr


def test_what_was_replayed_is_named(cornell: rayreel.Trace):
    for policy in ("full", Full()):
        stats = cornell.replay(policy).stats
        assert stats["trace"] == "v1_0_cornell.rtrace" and stats["trace_fingerprint"] == cornell.fingerprint
        assert stats["program"] == f"rayreel {rayreel.__version__}" and stats["model_version"] == rayreel.MODEL_VERSION
        assert "command" not in stats and stats["trace_digest"] is None


def test_values_may_be_numpys(cornell: rayreel.Trace):
    config = cornell.simulate("adaptive", set={"gpu.warm_caches": np.True_, "block": np.int64(4)}).stats
    assert config["machine_config"]["gpu.warm_caches"]["value"] is True


def test_pictures(teapot: rayreel.Trace):
    result = teapot.replay("adaptive")
    assert [frame.number for frame in result.frames] == list(teapot.frame_numbers)
    frame, meta = result.frames[0], teapot.meta
    assert frame.image.shape == frame.reference.shape == (meta["height"], meta["width"], 3)
    assert frame.image.dtype == np.float32 and frame.flip.shape == (meta["height"], meta["width"])
    assert frame.quality["flip"] == pytest.approx(float(frame.flip.mean(dtype=np.float64)), abs=1e-6)
    samples = meta["samples"]
    assert frame.states.shape == frame.rounds.shape == (meta["height"] * samples, meta["width"] * samples)
    assert (frame.states == State.INTERPOLATED).sum() == frame.counts["samples_interpolated"]
    assert set(np.unique(teapot.replay("full").frames[0].states)) == {State.REFERENCE}


def test_the_reference_is_the_mean_of_the_recorded_samples(teapot: rayreel.Trace):
    meta = teapot.meta
    samples = teapot.table("samples", frames=30)
    n, height, width = meta["samples"], meta["height"], meta["width"]
    grid = np.zeros((height * n, width * n, 3), np.float64)
    grid[samples["y"], samples["x"]] = np.stack([samples[c] for c in "rgb"], axis=1)
    pixels = grid.reshape(height, n, width, n, 3).mean(axis=(1, 3))
    np.testing.assert_allclose(teapot.replay("adaptive", frames=30).frames[0].reference, pixels, rtol=1e-5, atol=1e-6)


def test_what_is_not_wanted_is_not_there(cornell: rayreel.Trace):
    frame = cornell.replay("adaptive", pictures=False).frames[0]
    assert frame.image is None and frame.reference is None and frame.flip is None and frame.quality is not None
    frame = cornell.replay("adaptive", compare=np.False_).frames[0]
    assert frame.image is not None and frame.reference is None and frame.quality is None


@pytest.mark.parametrize(
    ("asked", "says"),
    [
        ({"policy": "adaptiv"}, "did you mean adaptive"),
        ({"policy": "full", "frames": 8}, "frame 8 is not in the trace"),
        ({"policy": "full", "frames": (0, 9)}, "frame 8 is not in the trace"),
        ({"policy": "full", "frames": -1}, "frames is a whole number"),
        ({"policy": "full", "set": ["ti.trv_l1.size=8KiB"]}, "is for a machine, and there is none in a replay; call simulate"),
        ({"policy": 3}, "an object with a method begin_tile"),
        ({"policy": Full}, r"Full is a class; pass an instance: Full\(\)"),
        ({"pictures": np.array([1, 2])}, r"pictures is True or False, not array\(\[1, 2\]\)"),
        ({"pictures": "no"}, "pictures is True or False, not 'no'"),
        ({"compare": 1}, "compare is True or False, not 1"),
        ({"set": b"block=4"}, "set is made of text, not of b'block=4'"),
        ({"policy": Full(), "set": {"block": 4}}, "block=4 is for a policy, and this one is an object; set its values in Python"),
    ],
)
def test_wrong_replays_are_refused(cornell: rayreel.Trace, asked: dict, says: str):
    with pytest.raises(rayreel.Error, match=says):
        cornell.replay(**asked)


def test_wrong_machines_are_refused(cornell: rayreel.Trace):
    with pytest.raises(rayreel.Error, match="sgrt-ti2"):
        cornell.simulate(machine="sgrt-ti22")
    with pytest.raises(rayreel.Error, match="simulate takes a machine.*without one, call replay"):
        cornell.simulate("full", None)


@pytest.mark.parametrize("detail", ["some", 2, True, np.True_, "precision 9"])
def test_wrong_details_are_refused(cornell: rayreel.Trace, detail):
    with pytest.raises(rayreel.Error, match="detail: .*; `precision P`, such as precision 0.01, is one too"):
        cornell.simulate(detail=detail)


@pytest.mark.parametrize("detail", [None, b"full", pytest.param(1 << 20000, id="long"), np.array([1, 2])])
def test_a_detail_is_text_or_a_number(cornell: rayreel.Trace, detail):
    with pytest.raises(rayreel.Error, match="detail is full, all, counts, a share.* or precision P, not "):
        cornell.simulate(detail=detail)


def test_a_detail_may_be_any_number(cornell: rayreel.Trace):
    half = cornell.simulate(detail="0.5").stats
    for detail in (Fraction(1, 2), np.float32(0.5)):
        assert cornell.simulate(detail=detail).stats == half


def test_a_result_is_shown_in_a_line(teapot: rayreel.Trace):
    assert repr(teapot.replay("full")) == "<rayreel.Result of full: 2 frames, 27115 rays>"
    run = teapot.simulate(Full(), frames=30)
    said = f"<rayreel.Result of Full on sgrt-ti2: 1 frames, {run['rays_traced']} rays, {run['cycles']} cycles>"
    assert repr(run) == said


def test_ctrl_c_ends_a_simulation(cornell: rayreel.Trace):
    class Slow:
        def begin_tile(self, view: rayreel.TileView) -> None:
            time.sleep(0.2)
            view.trace_mask(np.ones((view.height, view.width), np.bool_))

    threading.Timer(0.3, lambda: os.kill(os.getpid(), signal.SIGINT)).start()
    began = time.monotonic()
    with pytest.raises(KeyboardInterrupt):
        cornell.replay(Slow())
    assert time.monotonic() - began < 2.5, "15 tiles of 0.2 s take longer"


def test_layers_are_those_of_the_program(path: Path, program: Path, tmp_path: Path):
    """Depth and place of a pixel fit its camera: the place lies so far along the ray of the pixel's first sample."""
    trace = rayreel.open(path)
    frame = trace.frame_numbers[-1]
    layers, camera = trace.aov(frame, policy="full"), trace.camera(frame)
    shape = (trace.meta["height"], trace.meta["width"])
    assert {layer.shape for layer in layers.values()} == {shape}
    y, x = np.argwhere(np.isfinite(layers["depth.Z"]))[0]
    n = trace.meta["samples"]
    eye, corner, right, down = (np.array(camera[name]) for name in ("eye", "corner", "right", "down"))
    along = corner + right * (n * x + 0.5) + down * (n * y + 0.5)
    place = eye + layers["depth.Z"][y, x] * along / np.linalg.norm(along)
    np.testing.assert_allclose([layers[f"position.{axis}"][y, x] for axis in "XYZ"], place, rtol=1e-4, atol=1e-4)
    samples = trace.table("samples", columns=["rays"], frames=frame)
    assert layers["rays.all"].sum() == samples["rays"].sum()
    file = tmp_path / "x.exr"
    command = [program, "aov", path, "--frame", str(frame), "--policy", "full", "-o", file, "-q"]
    told = subprocess.run(command, check=True, capture_output=True, text=True).stdout
    assert f" {len(layers)} channels " in told
    with pytest.raises(rayreel.Error, match="frame 9999"):
        trace.aov(9999)
    with pytest.raises(rayreel.Error, match="frame 9999"):
        trace.camera(9999)


@pytest.mark.parametrize("name", ["sgrt-ti2", "multirate"])
def test_presets_are_those_of_the_program(name: str, program: Path):
    there = subprocess.run([program, "presets", "show", name, "--json"], check=True, capture_output=True).stdout
    assert rayreel.preset(name) == json.loads(there)
    with pytest.raises(rayreel.Error, match="policies are"):
        rayreel.preset("nothing")
