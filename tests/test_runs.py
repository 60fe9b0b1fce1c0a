"""Realisations over executors, killed, damaged and resumed: always the same bits."""

import os
import signal
import subprocess
import sys
import time
from concurrent.futures import Executor, Future, ProcessPoolExecutor

import distributed
import numpy as np
import pytest

from leakref import LeakrefError, runs
from leakref._base import Trouble
from leakref.cases import Configuration

SMALL = Configuration("small", direction=60, spread=45, length=2, duration=4)
TURNED = Configuration("turned", direction=60, spread=45, length=2, duration=4, rotation=30, speed=0.1)
BOTH, NUMBER = [SMALL, TURNED], 5


def bits(results):
    return b"".join(e.velocities.tobytes() + e.notes.tobytes() for found in results for e in found)


@pytest.fixture(scope="module")
def serial():
    return bits(runs.run(BOTH, realizations=NUMBER))


class Backwards(Executor):
    """Does nothing until asked for a result, and then the last task first."""

    def __init__(self):
        self.tasks = []

    def submit(self, function, /, *args, **kwargs):
        future = Future()
        self.tasks.append((future, function, args))
        if len(self.tasks) == len(BOTH) * NUMBER:
            for waiting, work, given in reversed(self.tasks):
                waiting.set_result(work(*given))
        return future


def test_neither_executor_nor_workers_nor_order_matter(serial):
    assert bits(runs.run(BOTH, realizations=NUMBER, executor=Backwards())) == serial
    with runs.pool(2) as executor:
        assert isinstance(executor, ProcessPoolExecutor)
        assert bits(runs.run(BOTH, realizations=NUMBER, executor=executor)) == serial


def test_ensembles_hold_the_realisations_of_their_configuration_in_order():
    (first, *_), (second, *_) = runs.run(BOTH, realizations=2, methods=["ls"])
    assert first.configuration == SMALL
    assert second.configuration == TURNED
    velocities, notes = runs.compute(runs.Task(TURNED, 1, ("ls",)))
    np.testing.assert_array_equal(second.velocities[1], velocities[0, 0])
    np.testing.assert_array_equal(second.notes[1], notes[0, 0])


def test_what_is_there_is_not_computed_again_and_what_is_damaged_is(serial, tmp_path, monkeypatch):
    assert bits(runs.run(BOTH, realizations=NUMBER, folder=tmp_path)) == serial
    parts = sorted(tmp_path.rglob("*.npz"))
    assert len(parts) == len(BOTH) * NUMBER
    computed = []
    compute = runs.compute
    monkeypatch.setattr(runs, "compute", lambda task: computed.append(task.realization) or compute(task))
    assert bits(runs.run(BOTH, realizations=NUMBER, folder=tmp_path)) == serial
    assert computed == []
    cut, bent, emptied = (p for p in parts if p.stem in ("00001", "00002", "00003") and p.parent == parts[0].parent)
    cut.write_bytes(cut.read_bytes()[:200])
    content = bytearray(bent.read_bytes())
    content[len(content) // 3] ^= 1
    bent.write_bytes(content)
    emptied.write_bytes(b"")
    assert bits(runs.run(BOTH, realizations=NUMBER, folder=tmp_path)) == serial
    assert computed == [1, 2, 3]


def test_other_settings_or_sources_are_other_files(tmp_path, monkeypatch):
    a = runs.Task(SMALL, 0).path(tmp_path)
    assert runs.Task(SMALL, 1).path(tmp_path).parent == a.parent
    others = [runs.Task(TURNED, 0), runs.Task(SMALL, 0, ("nsp",)), runs.Task(SMALL, 0, route="A")]
    assert len({a.parent, *(task.path(tmp_path).parent for task in others)}) == 4
    monkeypatch.setattr(runs, "source_digest", lambda: "other")
    assert runs.Task(SMALL, 0).path(tmp_path) != a


RUN = """
import sys
from pathlib import Path
sys.path.insert(0, sys.argv[2])
from test_runs import BOTH, NUMBER, bits
from leakref import runs
if __name__ == "__main__":
    with runs.pool(int(sys.argv[3])) as executor:
        sys.stdout.buffer.write(bits(runs.run(BOTH, realizations=NUMBER, folder=Path(sys.argv[1]), executor=executor)))
"""


def start(folder, tmp_path, workers=1):
    script = tmp_path / "run.py"
    script.write_text(RUN)
    return subprocess.Popen([sys.executable, script, folder, os.path.dirname(__file__), str(workers)],
                            stdout=subprocess.PIPE, start_new_session=True)


@pytest.mark.parametrize("workers", [1, 2])
def test_a_run_killed_at_any_moment_goes_on_where_it_was(serial, tmp_path, workers):
    folder = tmp_path / "parts"
    counts = []
    for wanted in (1, 4):  # killed with the first part written, and again later
        killed = start(folder, tmp_path, workers)
        while len(list(folder.rglob("0*.npz"))) < wanted and killed.poll() is None:
            time.sleep(0.01)
        killed.send_signal(signal.SIGKILL)
        killed.communicate()
        assert _is_empty(killed.pid)  # the workers have left as well
        counts.append(len(list(folder.rglob("0*.npz"))))
    assert counts[0] < len(BOTH) * NUMBER  # it really was cut short
    output, _ = start(folder, tmp_path, workers).communicate()
    assert output == serial


def test_two_runs_on_one_folder_do_not_disturb_each_other(serial, tmp_path):
    both = [start(tmp_path / "parts", tmp_path) for _ in range(2)]
    assert [process.communicate()[0] for process in both] == [serial, serial]


def test_a_refusal_in_a_worker_comes_back_as_it_was():
    with runs.pool(2) as executor, pytest.raises(LeakrefError, match="no route named 'C'"):
        list(runs.run([SMALL], realizations=2, route="C", executor=executor))


def test_a_worker_that_dies_is_reported():
    with pytest.raises(Trouble, match=r"worker process died.*goes on where"), runs.pool(2) as executor:
        runs._next(iter([executor.submit(os._exit, 1)]), {})


def test_a_scheduler_that_is_not_there_is_refused():
    with pytest.raises(LeakrefError, match="no scheduler answers"), runs.connected("tcp://127.0.0.1:1"):
        pass


def test_a_dask_cluster_gives_the_same_bits_even_when_a_worker_is_killed(serial, tmp_path):
    with distributed.LocalCluster(n_workers=2, threads_per_worker=1, processes=True, dashboard_address=None) as cluster:
        with runs.connected(cluster.scheduler_address) as executor:
            assert bits(runs.run(BOTH, realizations=NUMBER, executor=executor)) == serial
        victim = next(iter(cluster.workers.values())).pid
        seen = []

        def kill():
            seen.append(1)
            if len(seen) == 2:
                os.kill(victim, signal.SIGKILL)

        with runs.connected(cluster.scheduler_address) as executor:
            killed = list(runs.run(BOTH, realizations=NUMBER, executor=executor, after_each=kill))
        assert len(seen) == len(BOTH) * NUMBER
        assert bits(killed) == serial
        assert not _is_running(victim)


def _is_empty(group, patience=20):
    for _ in range(10 * patience):
        try:
            os.killpg(group, 0)
        except ProcessLookupError:
            return True
        time.sleep(0.1)
    return False


def _is_running(pid):
    try:
        os.kill(pid, 0)
    except ProcessLookupError:
        return False
    return True
