"""Realisations over executors, killed, damaged and resumed: always the same bits."""

import os
import shutil
import signal
import subprocess
import sys
import threading
import time
from concurrent.futures import Executor, Future, ProcessPoolExecutor

import distributed
import numpy as np
import pytest
from threadpoolctl import threadpool_info

from leakref import LeakrefError, kept, runs
from leakref._base import Trouble
from leakref.cases import Configuration
from leakref.shell import Note

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
    content[content.index(np.load(bent)["velocities"].tobytes()) + 3] ^= 1
    bent.write_bytes(content)
    emptied.write_bytes(b"")
    assert bits(runs.run(BOTH, realizations=NUMBER, folder=tmp_path)) == serial
    assert computed == [1, 2, 3]


def rewrite(path, **changes):
    """The part with some of its arrays others, every checksum of the archive right."""
    with np.load(path) as stored:
        arrays = {name: stored[name] for name in stored.files}
    np.savez(path, **{**arrays, **{name: change(arrays[name]) for name, change in changes.items()}})


def planted(where, value):
    def change(values):
        values = values.copy()
        values[where] = value
        return values

    return change


def another_configuration(path, folder):
    """That of the other configuration, of the same realisation and shape."""
    (other,) = (one for one in folder.rglob(path.name) if one.parent != path.parent)
    shutil.copy(other, path)


def resealed(path, task, **changes):
    """As by somebody who knows how parts are sealed."""
    with np.load(path) as stored:
        arrays = {name: stored[name] for name in ("velocities", "notes")}
    kept.keep_arrays(path, task.about, **{name: changes.get(name, lambda same: same)(a) for name, a in arrays.items()})


NUMBER_OF = (0, 0, 0)  # an item that has a number
HARMS = {
    "another realisation": lambda path, folder: shutil.copy(path.with_name("00001.npz"), path),
    "another configuration": another_configuration,
    "an edited velocity": lambda path, folder: rewrite(path, velocities=planted((*NUMBER_OF, 0), 0.1)),
    "a last bit": lambda path, folder: rewrite(path, velocities=lambda v: np.nextafter(v, 9)),
    "an edited note": lambda path, folder: rewrite(path, notes=planted(NUMBER_OF, 1)),
    "NaN": lambda path, folder: rewrite(path, velocities=planted(NUMBER_OF, np.nan)),
    "another shape": lambda path, folder: rewrite(path, velocities=lambda v: v[:, :, 1:], notes=lambda n: n[:, :, 1:]),
    "single precision": lambda path, folder: rewrite(path, velocities=lambda v: v.astype(np.float32)),
    "one array": lambda path, folder: np.savez(path, velocities=np.load(path)["velocities"]),
    "as they were once": lambda path, folder: np.savez(path, **{n: np.load(path)[n] for n in ("velocities", "notes")}),
    "words": lambda path, folder: np.savez(
        path, velocities=np.array("a"), notes=np.array("b"), about=np.array(1), sha256=np.array(2)
    ),
    "no archive": lambda path, folder: path.write_bytes(b"\x93NUMPY\x01\x00\x10\x00{'descr': "),
    "a folder": lambda path, folder: (path.unlink(), path.mkdir(), (path / "x").write_text("")),
    "NaN, sealed": lambda path, folder: resealed(path, TASK, velocities=planted(NUMBER_OF, np.nan)),
    "infinity, sealed": lambda path, folder: resealed(path, TASK, velocities=planted(NUMBER_OF, np.inf)),
    "half a number, sealed": lambda path, folder: resealed(path, TASK, velocities=planted((*NUMBER_OF, 1), np.nan)),
    "no signal, yet a number, sealed": lambda path, folder: resealed(
        path, TASK, notes=planted(NUMBER_OF, Note.NO_SIGNAL.value)
    ),
    "ls of one bin, yet a number, sealed": lambda path, folder: resealed(
        path, TASK, notes=planted((0, 1, 0), Note.TOO_FEW_BINS.value)
    ),
    "another shape, sealed": lambda path, folder: resealed(path, TASK, velocities=lambda v: v[:, :, 1:]),
}
TASK = runs.Task(SMALL, 0)


@pytest.mark.parametrize("harm", HARMS)
def test_a_part_that_is_not_of_this_task_is_never_taken(harm, serial, tmp_path, monkeypatch):
    """Whatever stands in the place of realisation 0: it is computed again, and no other part is."""
    assert bits(runs.run(BOTH, realizations=NUMBER, folder=tmp_path)) == serial
    path = TASK.path(tmp_path)
    HARMS[harm](path, tmp_path)
    if path.is_dir():
        assert runs._stored(TASK, tmp_path) is None  # it cannot be replaced either, which is said then
        return
    computed = []
    compute = runs.compute
    monkeypatch.setattr(runs, "compute", lambda task: computed.append(task) or compute(task))
    assert bits(runs.run(BOTH, realizations=NUMBER, folder=tmp_path)) == serial
    assert computed == [TASK]
    assert runs._stored(TASK, tmp_path) is not None


def test_no_number_with_a_note_is_taken_and_every_part_that_is_written_is(tmp_path):
    for task in (TASK, runs.Task(TURNED, 3), runs.Task(SMALL, 0, ("ls",)), runs.Task(SMALL, 0, ("ls", "nsp"))):
        part = runs.compute(task)
        runs._store(task, tmp_path, part)
        for found, written in zip(runs._stored(task, tmp_path), part, strict=True):
            np.testing.assert_array_equal(found, written)
    velocities, notes = part
    velocities[0, 0, 0], notes[0, 0, 0] = np.nan, Note.NO_SIGNAL.value
    runs._store(task, tmp_path, (velocities, notes))
    assert np.isnan(runs._stored(task, tmp_path)[0][0, 0, 0]).all()


def test_other_settings_or_sources_are_other_files(tmp_path, monkeypatch):
    a = runs.Task(SMALL, 0).path(tmp_path)
    assert runs.Task(SMALL, 1).path(tmp_path).parent == a.parent
    others = [runs.Task(TURNED, 0), runs.Task(SMALL, 0, ("nsp",)), runs.Task(SMALL, 0, route="A")]
    assert len({a.parent, *(task.path(tmp_path).parent for task in others)}) == 4
    monkeypatch.setattr(runs, "source_digest", lambda: "other")
    assert runs.Task(SMALL, 0).path(tmp_path) != a


RUN = """
import sys, time
from pathlib import Path
sys.path.insert(0, sys.argv[2])
from test_runs import BOTH, NUMBER, bits
from leakref import runs

def step():
    if len(list(Path(sys.argv[1]).rglob("0*.npz"))) >= int(sys.argv[4]) >= 0:
        time.sleep(600)

if __name__ == "__main__":
    with runs.pool(int(sys.argv[3])) as executor:
        sys.stdout.buffer.write(bits(runs.run(BOTH, realizations=NUMBER, folder=Path(sys.argv[1]), executor=executor,
                                              after_each=step)))
"""


def start(folder, tmp_path, workers=1, parts=-1):
    """A run in a process of its own, which stands still once it has written so many parts."""
    script = tmp_path / "run.py"
    script.write_text(RUN)
    return subprocess.Popen(
        [sys.executable, script, folder, os.path.dirname(__file__), str(workers), str(parts)],
        stdout=subprocess.PIPE,
        start_new_session=True,
    )


@pytest.mark.parametrize("workers", [1, 2])
def test_a_run_killed_at_any_moment_goes_on_where_it_was(serial, tmp_path, workers):
    folder = tmp_path / "parts"
    counts = []
    for wanted in (1, 4):  # killed with the first part written, and again later
        killed = start(folder, tmp_path, workers, wanted)
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


def _is_empty(group, patience=120):
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


def test_threads_that_overlap_share_one_limit_and_leave_none_behind():
    """One comes first and goes first, while the other is still at work: products have one thread for both."""
    turns = [threading.Event() for _ in range(3)]
    seen = {}

    def threads():
        return {pool["num_threads"] for pool in threadpool_info() if pool["user_api"] == "blas"}

    def first():
        with runs.one_thread():
            turns[0].set()
            assert turns[1].wait(30)
        seen["the other is within"] = threads()
        turns[2].set()

    runs._set_threads({pool["filepath"]: 2 for pool in threadpool_info()})
    other = threading.Thread(target=first)
    other.start()
    assert turns[0].wait(30)
    with runs.one_thread():
        turns[1].set()
        assert turns[2].wait(30)
    other.join()
    seen["after"] = threads()
    runs._set_threads({pool["filepath"]: 1 for pool in threadpool_info()})  # as for all tests
    assert seen == {"the other is within": {1}, "after": {2}}
