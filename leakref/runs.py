"""Many realisations: over any executor, written as they come, resumed where they stopped."""

from __future__ import annotations

import hashlib
import json
import logging
import multiprocessing
import os
import signal
import threading
import zipfile
import zlib
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import CancelledError, Executor, Future, ProcessPoolExecutor, as_completed
from concurrent.futures.process import BrokenProcessPool
from contextlib import AbstractContextManager, contextmanager
from dataclasses import asdict, dataclass
from functools import cache
from pathlib import Path

import numpy as np
import scipy
from threadpoolctl import ThreadpoolController

from leakref import ensemble
from leakref._base import FloatArray, IntArray, LeakrefError, Trouble
from leakref._output import write_whole
from leakref.cases import REALIZATIONS, Configuration
from leakref.chain import METHODS
from leakref.ensemble import Ensemble
from leakref.shell import Extraction

__all__ = ["Task", "compute", "connected", "one_thread", "pool", "run", "source_digest"]

_CHAIN = ("_base", "grid", "dispersion", "sea", "synthesis", "window", "spectrum", "leakage", "shell", "nsp",
          "leastsquares", "chain", "fastspectra", "fastscore", "fast", "ensemble")
Part = tuple[FloatArray, IntArray]
"""Velocities (w, m, n, 2) and notes (w, m, n) of one realisation under w windows and m methods."""


@cache
def source_digest() -> str:
    """SHA-256 of the source of everything between a sea and its velocities, and of the libraries' versions."""
    rooms = [(Path(__file__).parent / f"{room}.py").read_bytes() for room in _CHAIN]
    versions = f"{np.__version__} {scipy.__version__}".encode()
    return hashlib.sha256(b"\0".join([*rooms, versions])).hexdigest()


@dataclass(frozen=True)
class Task:
    """One realisation of a configuration: everything a worker anywhere needs to know."""

    configuration: Configuration
    realization: int
    methods: tuple[str, ...] = tuple(METHODS)
    route: str = "B"

    def path(self, folder: Path) -> Path:
        """Where its result is kept: another configuration, setting or source is another file."""
        fields = {**asdict(self), "realization": None, "source": source_digest()}
        key = hashlib.sha256(json.dumps(fields, sort_keys=True).encode()).hexdigest()[:20]
        return folder / key / f"{self.realization:05d}.npz"


@cache
def _threads() -> ThreadpoolController:
    return ThreadpoolController()


def one_thread() -> AbstractContextManager[object]:
    """Within it BLAS has one thread: how a product is split among several changes its last bits."""
    return _threads().limit(limits=1)


def compute(task: Task) -> Part:
    """Velocities and notes of a task, the same bits everywhere."""
    with one_thread():
        found = ensemble.realize(task.configuration, task.realization, methods=task.methods, route=task.route)
    return _stacked(list(found.values()), len(task.methods))


def _stacked(found: Sequence[Extraction], methods: int) -> Part:
    velocities = np.array([e.velocities for e in found])
    notes = np.array([[note.value for note in e.notes] for e in found], dtype=np.int64)
    return velocities.reshape(-1, methods, *velocities.shape[1:]), notes.reshape(-1, methods, notes.shape[1])


def _stored(task: Task, folder: Path | None) -> Part | None:
    """What an earlier run wrote for this task; None if there is nothing, or nothing whole (each array has its CRC)."""
    if folder is None:
        return None
    try:
        with task.path(folder).open("rb") as stream, np.load(stream, allow_pickle=False) as kept:
            return kept["velocities"], kept["notes"]
    except (OSError, ValueError, KeyError, EOFError, zipfile.BadZipFile, zlib.error):
        return None


def _store(task: Task, folder: Path | None, part: Part) -> None:
    if folder is not None:
        write_whole(task.path(folder), lambda path: np.savez(path, velocities=part[0], notes=part[1]))


def _end_with_parent() -> None:
    """In a worker: leave when the process that started it is gone, however it went; Ctrl-C is its business."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    parent = multiprocessing.parent_process()
    if parent is not None:

        def follow() -> None:
            parent.join()
            os._exit(1)

        threading.Thread(target=follow, daemon=True).start()


@contextmanager
def pool(workers: int) -> Iterator[Executor | None]:
    """An executor of `workers` processes, or None for one: this process."""
    if workers < 1:
        raise LeakrefError("pool", f"{workers} workers", "ask for at least one")
    if workers == 1:
        yield None
        return
    with ProcessPoolExecutor(workers, mp_context=multiprocessing.get_context("spawn"),
                             initializer=_end_with_parent) as executor:
        try:
            yield executor
        except BrokenProcessPool:
            raise Trouble("run", "a worker process died, perhaps for want of memory",
                          "use fewer workers; the same command goes on where this one stopped") from None
        except BaseException:
            executor.shutdown(wait=False, cancel_futures=True)
            raise


@contextmanager
def _hushed(package: str) -> Iterator[None]:
    """Without what a package logs: each of its loggers has a level of its own."""
    loggers = [logging.getLogger(name) for name in logging.root.manager.loggerDict if name.split(".")[0] == package]
    spoke = [logger for logger in loggers if not logger.disabled]
    for logger in spoke:
        logger.disabled = True
    try:
        yield
    finally:
        for logger in spoke:
            logger.disabled = False


@contextmanager
def connected(address: str) -> Iterator[Executor]:
    """The executor of an existing dask.distributed cluster (extra `distributed`)."""
    try:
        from distributed import Client, KilledWorker
        from distributed.comm import CommClosedError
    except ModuleNotFoundError:
        raise LeakrefError("connected", "dask.distributed is not installed",
                           "pip install 'leakref[distributed]'") from None
    try:
        client = Client(address, timeout=10)
    except (OSError, ValueError, TimeoutError) as error:
        raise LeakrefError("connected", f"no scheduler answers at {address} ({error})",
                           "start one with `dask scheduler` and give its address, tcp://host:8786") from None
    with _hushed("distributed"), client:  # what it would say is said below, once
        try:
            yield client.get_executor(pure=False)
        except (CancelledError, KilledWorker, CommClosedError) as error:
            raise Trouble("run", f"the scheduler at {address} or its workers are gone ({type(error).__name__})",
                          "start them again; the same command goes on where this one stopped") from None


def run(configurations: Sequence[Configuration], *, realizations: int = REALIZATIONS,
        methods: Sequence[str] = tuple(METHODS), route: str = "B", folder: Path | None = None,
        executor: Executor | None = None, after_each: Callable[[], object] = lambda: None) -> Iterator[list[Ensemble]]:
    """Realisations 0 ... `realizations` - 1 of each configuration: its ensembles, a list for each in order.

    Realisations are tasks for `executor` (default: this process). With a `folder`, each result is written there
    as it comes, and one that is already there, whole and of the same source, is not computed again. Results do
    not depend on the executor, the number of its workers or the order of completion. Raises LeakrefError.
    """
    if realizations < 1:
        raise LeakrefError("run", f"{realizations} realisations", "ask for at least one")
    plans = [[Task(c, number, tuple(methods), route) for number in range(realizations)] for c in configurations]
    waiting: dict[Task, Future[Part]] = {}
    done: dict[Task, Part] = {}
    for task in (task for plan in plans for task in plan):
        part = _stored(task, folder)
        if part is not None:
            done[task] = part
            after_each()
        elif executor is not None:
            waiting[task] = executor.submit(compute, task)
    tasks = {future: task for task, future in waiting.items()}
    finished = as_completed(tasks) if tasks else iter(())
    for plan in plans:
        for task in plan:
            while task not in done:
                if executor is None:
                    one, part = task, compute(task)
                else:
                    one, part = _next(finished, tasks)
                _store(one, folder, part)
                done[one] = part
                after_each()
        yield _ensembles(plan, [done.pop(task) for task in plan])


def _next(finished: Iterator[Future[Part]], tasks: dict[Future[Part], Task]) -> tuple[Task, Part]:
    future = next(finished)
    part = future.result()
    return tasks[future], part


def _ensembles(plan: Sequence[Task], parts: Sequence[Part]) -> list[Ensemble]:
    configuration, methods = plan[0].configuration, plan[0].methods
    velocities, notes = (np.array(values) for values in zip(*parts, strict=True))
    return [Ensemble(configuration, window, method, configuration.wavenumbers, velocities[:, w, m], notes[:, w, m])
            for w, window in enumerate(configuration.windows) for m, method in enumerate(methods)]
