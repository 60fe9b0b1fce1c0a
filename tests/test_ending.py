"""Commands that are told to end: whatever they are at, they do, with status 130, in silence, and leave nothing."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import psutil
import pytest

import leakref

pytestmark = pytest.mark.skipif(os.name != "posix", reason="signals are sent")
COMMANDS = """
import os, shutil, sys, time
from pathlib import Path
from leakref import cli, ending, runs
from leakref.cli import base

HERE = Path(__file__).parent

def busy(number):
    (HERE / f"begun-{number}").touch()
    time.sleep(600)

class Slow:
    def __del__(self):
        busy(0)

@base.command(None)
def pool() -> bool:
    with runs.pool(2) as executor:
        return bool(list(executor.map(busy, range(4))))

@base.command(None)
def idle() -> bool:
    with runs.pool(2) as executor:
        list(executor.map(time.sleep, [0.2, 0.2]))
        try:
            busy(0)
        finally:
            time.sleep(2)  # they have the time to say what they think of it
    return True

@base.command(None)
def deaf() -> bool:
    (HERE / "left").mkdir()
    ending.last_resorts.add(lambda: shutil.rmtree(HERE / "left"))
    while True:
        try:
            busy(0)
        except KeyboardInterrupt:
            pass

@base.command(None)
def finaliser() -> bool:
    Slow()
    while True:
        time.sleep(0.01)

if __name__ == "__main__":
    cli.main()
"""


def told(tmp_path, command, number, *, group=False, begun=1):
    """Run a command, tell it to end once that many tasks have begun: its status, what it printed, who is left."""
    script = tmp_path / "commands.py"
    script.write_text(COMMANDS)
    with subprocess.Popen(
        [sys.executable, str(script), command],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
    ) as process:
        try:
            while len(list(tmp_path.glob("begun-*"))) < begun:
                assert process.poll() is None
                time.sleep(0.01)
            family = psutil.Process(process.pid).children(recursive=True)
            for _ in range(1 + group):  # as `timeout` does: to the process, and again to its group
                (os.killpg if group else os.kill)(process.pid, number)
            said = "".join(process.communicate(timeout=120))  # a hang; it is to be 5 s
        finally:
            process.kill()
    gone, left = psutil.wait_procs(family, timeout=60)
    assert len(gone) == len(family)
    return process.returncode, said, left


@pytest.mark.parametrize("group", [False, True])
@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_a_pool_does_not_wait_for_what_its_workers_are_at(tmp_path, number, group):
    said = "leakref: interrupted\n" if number == signal.SIGINT else "leakref: ended by SIGTERM\n"
    assert told(tmp_path, "pool", number, group=group, begun=2) == (128 + number, said, [])


def test_ctrl_c_is_not_the_business_of_workers_that_wait(tmp_path):
    assert told(tmp_path, "idle", signal.SIGINT, group=True) == (130, "leakref: interrupted\n", [])


def test_what_does_not_listen_is_ended_by_force(tmp_path):
    assert told(tmp_path, "deaf", signal.SIGTERM) == (143, "leakref: ended by SIGTERM\n", [])
    assert not (tmp_path / "left").exists()


def test_an_interruption_lost_in_a_finaliser_comes_again(tmp_path):
    assert told(tmp_path, "finaliser", signal.SIGINT) == (130, "leakref: interrupted\n", [])


def test_there_is_one_way_to_have_workers():
    house = Path(leakref.__file__).parent
    users = {
        path.name
        for path in house.rglob("*.py")
        for word in ("ProcessPoolExecutor(", "multiprocessing.Pool", "multiprocessing.Process", ".get_context(")
        if word in path.read_text(encoding="utf-8")
    }
    assert users == {"runs.py"}
