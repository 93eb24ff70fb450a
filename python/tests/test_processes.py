"""What ends, and how: policies that do not return or wait for themselves, forks, programs that end while a replay runs. Each in a
process of its own, for what fails here may never end."""

import os
import subprocess
import sys
import textwrap
from pathlib import Path

import pytest

TRACE = Path(__file__).resolve().parents[2] / "traces" / "v1_0_cornell.rtrace"

BEGINNING = f"""
import os, signal, sys, threading, time
import numpy as np
import rayreel

trace = rayreel.open({str(TRACE)!r})

class Full:
    def begin_tile(self, view):
        view.trace_mask(np.ones((view.height, view.width), np.bool_))
"""


needs_fork = pytest.mark.skipif(not hasattr(os, "fork"), reason="there are no forks here")


def run(program: str) -> subprocess.CompletedProcess:
    """Runs it to its end. It says so if that does not come: nothing here takes seconds."""
    whole = BEGINNING + textwrap.dedent(program)
    return subprocess.run([sys.executable, "-c", whole], capture_output=True, text=True, timeout=120)


@pytest.mark.parametrize("name", ["replay", "simulate"])
@pytest.mark.parametrize(
    "ask",
    [
        'trace.table("samples")',
        'trace.batches("samples")',
        "next(made_before)",
        'trace.replay("full")',
        "trace.simulate(Full())",
    ],
)
def test_a_policy_cannot_ask_for_more_in_begin_tile(name: str, ask: str):
    ran = run(f"""
        made_before = trace.batches("steps")

        class Asks(Full):
            def begin_frame(self, frame):
                print(len(trace.table("samples")) > 0)

            def begin_tile(self, view):
                {ask}
                super().begin_tile(view)

        try:
            trace.{name}(Asks())
        except rayreel.Error as error:
            print(error)
    """)
    refused = "a policy cannot ask rayreel for tables or replays in begin_tile; do so in begin_frame, or before"
    assert (ran.returncode, ran.stdout) == (0, f"True\n{refused}\n"), ran.stderr


@pytest.mark.parametrize("caught", [0, 1])
def test_ctrl_c_ends_a_policy_that_does_not_return(caught: int):
    """Also one that takes the first for its own."""
    ran = run(f"""
        class Stays(Full):
            caught = 0

            def begin_tile(self, view):
                os.kill(os.getpid(), signal.SIGINT)
                while True:
                    try:
                        while True:
                            pass
                    except KeyboardInterrupt:
                        if self.caught == {caught}:
                            raise
                        self.caught += 1
                        os.kill(os.getpid(), signal.SIGINT)

        policy = Stays()
        try:
            trace.replay(policy)
        except KeyboardInterrupt:
            print("interrupted", policy.caught)
        # Nothing of it is left.
        print(len(trace.replay(Full()).frames))
    """)
    assert (ran.returncode, ran.stdout) == (0, f"interrupted {caught}\n1\n"), ran.stderr


def test_ctrl_c_ends_what_a_policy_asked_for():
    ran = run("""
        class Stays(Full):
            def begin_tile(self, view):
                while True:
                    pass

        class Asks(Full):
            def begin_frame(self, frame):
                threading.Timer(0.2, os.kill, (os.getpid(), signal.SIGINT)).start()
                trace.replay(Stays())

        try:
            trace.replay(Asks())
        except KeyboardInterrupt:
            print("interrupted")
    """)
    assert (ran.returncode, ran.stdout) == (0, "interrupted\n"), ran.stderr


# `zip` calls one after the other without Python between: the signal waits when the other begins.
SIGNALLED = """
import ctypes
def signalled(iterator):
    return next(zip(map(getattr(ctypes.CDLL(None), "raise"), (signal.SIGINT,)), iterator))[1]
"""


@pytest.mark.skipif(sys.platform != "linux", reason="the C library is elsewhere")
def test_ctrl_c_loses_no_batch():
    ran = run(SIGNALLED + textwrap.dedent("""
        batches = trace.batches("steps")
        try:
            signalled(batches)
        except KeyboardInterrupt:
            print("interrupted")
        print(sum(map(len, batches)) == len(trace.table("steps")), list(batches))
    """))
    assert (ran.returncode, ran.stdout) == (0, "interrupted\nTrue []\n"), ran.stderr


@pytest.mark.skipif(sys.platform != "linux", reason="the C library is elsewhere")
def test_ctrl_c_in_the_first_table_is_no_panic():
    """NumPy's own code, which runs when the first array is made, was interrupted."""
    ran = run(SIGNALLED + textwrap.dedent("""
        from rayreel import _arguments
        asked = _arguments.asked(None, None, None, None, None, None, None)
        try:
            signalled(map(trace._recorded.table, ("steps",), (asked,)))
        except KeyboardInterrupt:
            print("interrupted")
    """))
    assert (ran.returncode, ran.stdout) == (0, "interrupted\n"), ran.stderr


@needs_fork
def test_a_fork_is_refused():
    ran = run("""
        batches = trace.batches("steps")
        asks = [
            lambda: trace.table("rays"),
            lambda: trace.batches("rays"),
            lambda: next(batches),
            lambda: trace.replay("full"),
            lambda: trace.simulate(Full()),
        ]
        child = os.fork()
        if child == 0:
            for ask in asks:
                try:
                    ask()
                except rayreel.Error as error:
                    print(error, flush=True)
            sys.exit()
        os.waitpid(child, 0)
        print(len(trace.replay("full").frames))
    """)
    lines = ran.stdout.splitlines()
    assert ran.returncode == 0 and lines[-1] == "1" and len(lines) == 6, ran.stdout + ran.stderr
    assert all("was forked after rayreel was used" in line and "spawn" in line for line in lines[:-1])


@needs_fork
def test_a_fork_before_its_use_is_none():
    ran = run("""
        child = os.fork()
        if child != 0:
            os.waitpid(child, 0)
        print(len(trace.replay(Full()).frames), flush=True)
    """)
    assert (ran.returncode, ran.stdout) == (0, "1\n1\n"), ran.stderr


@pytest.mark.parametrize("decides", ["time.sleep(0.02)", "while True: pass"])
def test_a_program_may_end_while_a_thread_replays(decides: str):
    """A daemon thread: Python does not wait for it."""
    ran = run(f"""
        began = threading.Event()

        class Works(Full):
            def begin_tile(self, view):
                began.set()
                {decides}
                super().begin_tile(view)

        def work():
            while True:
                trace.simulate(Works())

        threading.Thread(target=work, daemon=True).start()
        began.wait()
        time.sleep(0.05)
        print("the end")
    """)
    assert (ran.returncode, ran.stdout, ran.stderr) == (0, "the end\n", "")


def test_once_python_ends_no_policy_begins():
    """The program is told why; a thread beside it ends quietly."""
    ran = run("""
        import atexit

        # What Python does first when it ends.
        atexit._run_exitfuncs()
        try:
            trace.replay(Full())
        except rayreel.Error as error:
            print(error)
        thread = threading.Thread(target=trace.replay, args=(Full(),))
        thread.start()
        thread.join()
    """)
    said = "Python is ending: no policy in Python can be called any more\n"
    assert (ran.returncode, ran.stdout, ran.stderr) == (0, said, "")


def test_the_end_says_which_policy_it_waits_for():
    ran = run("""
        began = threading.Event()

        class Sleeps(Full):
            def begin_tile(self, view):
                began.set()
                time.sleep(2.5)

        threading.Thread(target=trace.replay, args=(Sleeps(),), daemon=True).start()
        began.wait()
    """)
    said = "rayreel: the program ends when policy Sleeps returns from its call, or with Ctrl-C\n"
    assert (ran.returncode, ran.stdout, ran.stderr) == (0, "", said)
