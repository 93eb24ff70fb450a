"""Policies written in Python."""

import time

import numpy as np
import pytest

import rayreel
from rayreel import TileView


class Full:
    """Traces every sample."""

    def begin_tile(self, view: TileView) -> None:
        view.trace_mask(np.ones((view.height, view.width), np.bool_))


class Pairs:
    """Every other sample of a row; the one behind it gets the same. As examples/custom_policy.rs."""

    name = "pairs"

    def begin_tile(self, view: TileView) -> None:
        for x, y in view.samples().tolist():
            if x % 2 == 0:
                view.trace(x, y)
            else:
                view.copy(x, y, (x - 1, y))


def test_what_traces_all_gives_the_reference(teapot: rayreel.Trace):
    mine, full = teapot.simulate(Full()), teapot.simulate("full")
    for a, b in zip(mine.frames, full.frames):
        np.testing.assert_array_equal(a.image, a.reference)
        assert a.counts["rays_traced"] == b.counts["rays_traced"] == b.counts["rays_full"]
    assert mine["rays_machine"] == full["rays_machine"] and mine.stats["policy"] == "Full"
    assert mine.stats["policy_config"] is None


def test_a_policy_gives_what_it_traces(teapot: rayreel.Trace):
    """Half of the samples, and their rays."""
    mine = teapot.replay(Pairs())
    assert mine.stats["policy"] == "pairs"
    for frame in mine.frames:
        assert frame.counts["samples_traced"] * 2 == frame.states.size
        np.testing.assert_array_equal(frame.states[:, ::2], rayreel.State.REFERENCE)
        np.testing.assert_array_equal(frame.states[:, 1::2], rayreel.State.INTERPOLATED)
    samples = teapot.table("samples", frames=30)
    assert mine.frames[0].counts["rays_traced"] == int(samples["rays"][samples["x"] % 2 == 0].sum())
    assert mine.stats == teapot.replay(Pairs()).stats, "whatever thread comes first"


def test_a_view_shows_what_is_known(cornell: rayreel.Trace):
    hits = cornell.table("hits")
    primary = hits["ray"] == 0
    depth = np.full((48, 80), np.nan, np.float32)
    depth[hits["y"][primary], hits["x"][primary]] = hits["t"][primary]

    class Look:
        def begin_tile(self, view: TileView) -> None:
            assert not view.known.any() and np.isnan(view.colours).all()
            half = np.zeros((view.height, view.width), np.bool_)
            half[::2] = True
            view.trace_mask(half)
            np.testing.assert_array_equal(view.known, half)
            assert np.isnan(view.colours[1::2]).all() and np.isfinite(view.colours[::2]).all()
            at = np.s_[view.y : view.y + view.height : 2, view.x : view.x + view.width]
            np.testing.assert_array_equal(np.isnan(view.surfaces["depth"][::2]), np.isnan(depth[at]))
            colours = view.colours
            for x, y in view.samples().tolist():
                if (y - view.y) % 2 == 1:
                    view.interpolate(x, y, (x, y - 1), (x, y - 1) if y + 1 >= view.y + view.height else (x, y + 1))
            last = view.colours
            np.testing.assert_array_equal(last[::2], colours[::2])
            if view.height > 2:
                np.testing.assert_allclose(last[1], (colours[0] + colours[2]) / 2, atol=1e-6)

    assert cornell.replay(Look())["samples_interpolated"] > 0


def test_frames_are_told(teapot: rayreel.Trace):
    class Learns(Full):
        def __init__(self) -> None:
            self.told: list = []

        def begin_frame(self, frame: int) -> None:
            self.told.append(frame)

        def end_frame(self, tiles: list) -> None:
            self.told.append(sum(tile["samples_traced"] for tile in tiles))

    policy = Learns()
    teapot.replay(policy)
    size = teapot.meta["width"] * teapot.meta["height"] * teapot.meta["samples"] ** 2
    assert policy.told == [30, size, 31, size]


def test_paint(cornell: rayreel.Trace):
    class Grey:
        def begin_tile(self, view: TileView) -> None:
            for x, y in view.samples().tolist():
                view.paint(x, y, (0.5, 0.25, 0.125))

    frame = cornell.replay(Grey()).frames[0]
    np.testing.assert_array_equal(frame.image, np.broadcast_to(np.float32([0.5, 0.25, 0.125]), frame.image.shape))
    assert frame.counts["rays_traced"] == 0


@pytest.mark.parametrize(
    ("decide", "says"),
    [
        (lambda view: view.trace(view.x, view.y), "undecided"),
        (lambda view: [view.trace(view.x, view.y) for _ in "ab"], "decided already"),
        (lambda view: view.trace(view.x + view.width, view.y), "is not in the tile"),
        (lambda view: view.copy(view.x, view.y, (view.x + 1, view.y)), "is not known yet"),
        (lambda view: view.trace_mask(np.ones((3, 3), np.bool_)), "the mask has shape"),
        (lambda view: view.interpolate(view.x, view.y, (0, 0), (0, 0), share=2.0), "from 0 to 1"),
        (lambda view: view.trace(-1, 0), r"sample \(-1, 0\) is not in the tile"),
        (lambda view: view.copy(view.x, view.y, (-1, view.y)), r"sample \(-1, \d+\) is not in the tile"),
        (lambda view: view.trace(view.x, view.y, round=256), "round is a whole number from 0 to 255, not 256"),
        (lambda view: view.paint(view.x, view.y, (0, 0, 0), round=-1), "round is a whole number from 0 to 255, not -1"),
        (lambda view: view.trace_mask(np.ones((view.height, view.width), np.uint8)), "the mask is an array of bool"),
        (lambda view: view.trace_mask([[True]]), "the mask is an array of bool"),
        (lambda view: view.paint(view.x, view.y, (0, np.nan, 0)), "a colour is three numbers from 0 to 1e30, not"),
        (lambda view: view.paint(view.x, view.y, (0, 0, np.inf)), "a colour is three numbers from 0 to 1e30, not"),
        (lambda view: view.paint(view.x, view.y, (0, 0, 1e300)), "a colour is three numbers from 0 to 1e30, not"),
        (lambda view: view.paint(view.x, view.y, (-0.1, 0, 0)), r"a colour is.*not \(-0.1, 0, 0\)"),
        (lambda view: view.paint(view.x, view.y, (0, 0)), r"a colour is.*not \(0, 0\)"),
        (lambda view: view.paint(view.x, view.y, "red"), "a colour is.*not red"),
        (lambda view: view.copy(view.x, view.y, 3), "a sample is its column and its row, such as .*, not 3"),
        (lambda view: view.copy(view.x, view.y, (1, 2, 3)), "a sample is its column and its row"),
        (lambda view: view.copy(view.x, view.y, (True, False)), "a sample is its column and its row"),
        (lambda view: view.paint(view.x, view.y, (3e38, 3e38, 3e38)), "a colour is three numbers from 0 to 1e30, not"),
        (lambda view: view.trace(2**70, 0), f"x is a whole number in the tile, not {2**70}"),
        (lambda view: view.trace(view.x, "a"), "y is a whole number in the tile, not 'a'"),
        (lambda view: view.trace(view.x, 1 << 20000), "y is a whole number in the tile, not"),
        (lambda view: view.trace(view.x, view.y, round=2**70), "round is a whole number from 0 to 255, not"),
        (lambda view: view.trace(view.x, view.y, round=True), "round is a whole number from 0 to 255, not True"),
        (lambda view: view.trace(view.x, view.y, reference=1), "reference is True or False, not 1"),
        (lambda view: view.interpolate(view.x, view.y, (0, 0), (0, 0), share=2**2000), "share is a number from 0 to 1"),
    ],
)
def test_wrong_policies_are_told(cornell: rayreel.Trace, decide, says: str):
    class Wrong:
        def begin_tile(self, view: TileView) -> None:
            decide(view)

    with pytest.raises(rayreel.Error, match=says):
        cornell.replay(Wrong())


def interrupted():
    yield 0
    raise KeyError("mine")


class Unset:
    def __index__(self) -> int:
        raise KeyError("mine")

    __float__ = __index__


@pytest.mark.parametrize(
    "decide",
    [
        lambda view: view.paint(view.x, view.y, interrupted()),
        lambda view: view.paint(view.x, view.y, (0, 0, Unset())),
        lambda view: view.copy(view.x, view.y, interrupted()),
        lambda view: view.copy(view.x, view.y, (view.x, Unset())),
        lambda view: view.trace(Unset(), view.y),
    ],
)
def test_what_is_raised_inside_a_sample_or_a_colour_comes_out(cornell: rayreel.Trace, decide):
    class Raises:
        def begin_tile(self, view: TileView) -> None:
            decide(view)

    with pytest.raises(KeyError, match="mine"):
        cornell.replay(Raises())


@pytest.mark.parametrize(
    ("attribute", "value", "says"),
    [
        ("name", None, "the name of a policy is text, not NoneType"),
        ("name", "\udcff", r"the name of a policy is no UTF-8: '\\udcff'"),
        ("begin_frame", None, "begin_frame of a policy is a method, not NoneType; leave it out if it does nothing"),
        ("end_frame", 3, "end_frame of a policy is a method, not int"),
    ],
)
def test_attributes_of_policies_are_checked_beforehand(cornell: rayreel.Trace, attribute: str, value, says: str):
    class Never(Full):
        def begin_tile(self, view: TileView) -> None:
            raise AssertionError("the replay began")

    policy = Never()
    setattr(policy, attribute, value)
    with pytest.raises(rayreel.Error, match=says):
        cornell.replay(policy)


def test_the_brightest_colour_is_finite(cornell: rayreel.Trace):
    class Bright:
        def begin_tile(self, view: TileView) -> None:
            for x, y in view.samples().tolist():
                view.paint(x, y, (1e30, 1e30, 1e30))

    frame = cornell.replay(Bright()).frames[0]
    assert np.isfinite(frame.image).all() and all(np.isfinite(value) for value in frame.quality.values())


def test_a_policy_is_called_once_at_a_time(cornell: rayreel.Trace):
    class Counts(Full):
        now = most = 0

        def begin_tile(self, view: TileView) -> None:
            self.now += 1
            self.most = max(self.most, self.now)
            # Other threads have Python meanwhile.
            time.sleep(0.002)
            super().begin_tile(view)
            self.now -= 1

    policy = Counts()
    cornell.replay(policy, compare=False)
    assert (policy.now, policy.most) == (0, 1)


class Fails(Full):
    """Fails at some moments: frame, and method or tile."""

    def __init__(self, *moments: tuple[int, str | int]) -> None:
        self.moments, self.calls, self.frame = moments, [], -1

    def _reach(self, moment: str | int) -> None:
        self.calls.append((self.frame, moment))
        if (self.frame, moment) in self.moments:
            raise KeyError(f"frame {self.frame}, {moment}")

    def begin_frame(self, frame: int) -> None:
        self.frame = frame
        self._reach("begin")

    def begin_tile(self, view: TileView) -> None:
        super().begin_tile(view)
        self._reach(view.index)

    def end_frame(self, tiles: list) -> None:
        self._reach("end")


@pytest.mark.parametrize("name", ["replay", "simulate"])
@pytest.mark.parametrize(
    ("moments", "first"),
    [
        ([(30, 1), (31, 0)], "frame 30, 1"),
        ([(30, 1), (30, 0)], "frame 30, 0"),
        ([(30, "end"), (31, 0)], "frame 30, end"),
        ([(30, "begin"), (30, 0)], "frame 30, begin"),
        ([(31, 0), (31, "end")], "frame 31, 0"),
    ],
)
def test_the_first_failure_counts_and_ends_the_replay(teapot: rayreel.Trace, name: str, moments, first: str):
    policy = Fails(*moments)
    with pytest.raises(KeyError, match=first):
        getattr(teapot, name)(policy)
    frame, moment = min(moments, key=lambda moment: first != f"frame {moment[0]}, {moment[1]}")
    assert max(frame for frame, _ in policy.calls) == frame, "no frame begins after it"
    if moment == "begin":
        assert policy.calls == [(frame, "begin")]
    elif moment != "end":
        assert (frame, "end") not in policy.calls


def test_what_a_policy_raises_comes_out(cornell: rayreel.Trace):
    class Raises:
        def begin_tile(self, view: TileView) -> None:
            if view.index >= 3:
                raise KeyError(f"tile {view.index}")
            view.trace_mask(np.ones((view.height, view.width), np.bool_))

    with pytest.raises(KeyError, match="tile 3"):
        cornell.replay(Raises())


def test_samples_and_colours_may_be_lists_and_arrays(teapot: rayreel.Trace):
    class Lists:
        def begin_tile(self, view: TileView) -> None:
            samples = view.samples()
            view.paint(*samples[0], np.float32([1, 2, 3]))
            view.copy(*samples[1], samples[0])
            view.interpolate(*samples[2], samples[0].tolist(), list(samples[1]))
            for x, y in samples[3:]:
                view.paint(x, y, [1, 2, 3])

    for frame in teapot.replay(Lists()).frames:
        np.testing.assert_array_equal(frame.image, np.broadcast_to(np.float32([1, 2, 3]), frame.image.shape))


def test_a_view_of_a_frame_before_is_of_no_use(teapot: rayreel.Trace):
    """The same tile of the next frame has its number and its place."""

    class Keeps(Full):
        def __init__(self) -> None:
            self.kept: dict[int, TileView] = {}
            self.refused = 0

        def begin_tile(self, view: TileView) -> None:
            if view.index in self.kept:
                with pytest.raises(RuntimeError, match="only during the call"):
                    self.kept[view.index].known
                self.refused += 1
            self.kept[view.index] = view
            super().begin_tile(view)

    policy = Keeps()
    teapot.replay(policy)
    assert policy.refused == teapot.meta["tiles"] == 2


def test_a_view_is_of_use_during_its_call_only(cornell: rayreel.Trace):
    class Keeps(Full):
        def __init__(self) -> None:
            self.kept: list[TileView] = []

        def begin_tile(self, view: TileView) -> None:
            super().begin_tile(view)
            self.kept.append(view)

    policy = Keeps()
    cornell.replay(policy)
    with pytest.raises(RuntimeError, match="only during the call"):
        policy.kept[0].trace(0, 0)
