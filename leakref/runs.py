"""Many realisations: over any executor, written as they come, resumed where they stopped.

A run is a list of configurations and a number of realisations. Each realisation is a task by itself, whose result does
not depend on where or when it is computed: so tasks can be spread over processes or a cluster, kept one by one, and
taken from where an earlier run left them. `reproduce`, `claims`, `plan`, `track` and `golden` all compute through
`run`. What a realisation is is in `ensemble`; files are `kept`'s.

For instance ten realisations of one case, by two processes:

    with pool(2) as executor:
        for ensembles in run(configurations(["nsp-ls"]), realizations=10, executor=executor):
            print([(e.window, e.method, e.bias) for e in ensembles])
"""

from __future__ import annotations

import logging
import multiprocessing
import os
import threading
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import CancelledError, Executor, Future, ProcessPoolExecutor, as_completed
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from dataclasses import asdict, dataclass
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
from threadpoolctl import ThreadpoolController

from leakref import ensemble, kept, sources
from leakref._base import FloatArray, IntArray, LeakrefError, Trouble, installed_with
from leakref.cases import REALIZATIONS, Configuration
from leakref.ending import Workers
from leakref.ensemble import Ensemble
from leakref.methods import DEFAULT, METHODS
from leakref.shell import Extraction

__all__ = ["Task", "compute", "connected", "one_thread", "pool", "run", "source_digest"]

Part = tuple[FloatArray, IntArray]
"""Velocities (w, m, n, 2) and notes (w, m, n) of one realisation under w windows and m methods."""


@cache
def source_digest() -> str:
    """SHA-256 of the source of everything between a sea and its velocities, and of the libraries' versions.

    It is part of what every kept result is of, so that nothing computed by other sources or libraries is ever taken for
    it. Whole files count, comments and docstrings too.
    """
    return sources.digest(__name__)


@dataclass(frozen=True)
class Task:
    """One realisation of a configuration: everything a worker anywhere needs to know.

    - `realization`: counted from 0; `methods`: ids of `leakref.methods`.
    - `route`: `A` through the surface and the FFT, `B` in closed form.
    """

    configuration: Configuration
    realization: int
    methods: tuple[str, ...] = DEFAULT
    route: str = "B"

    @property
    def about(self) -> dict[str, Any]:
        """What its result depends on. It is a dictionary of plain values, the key of `kept`."""
        return {**asdict(self), "source": source_digest()}

    @property
    def shape(self) -> tuple[int, int, int]:
        """Windows, methods and wavenumbers of its result."""
        return len(self.configuration.windows), len(self.methods), self.configuration.wavenumbers.size

    def path(self, folder: Path) -> Path:
        """Where its result is kept: another configuration, setting or source is another file. All realisations of one
        configuration and setting share a folder.
        """
        return folder / kept.key({**self.about, "realization": None}) / f"{self.realization:05d}.npz"


@cache
def _threads() -> ThreadpoolController:
    return ThreadpoolController()


_ENTERING = threading.Lock()
_BEFORE: list[dict[str, int]] = []
"""Of each thread that is within `one_thread`, how many threads the libraries had before the first of them came."""


def _set_threads(counts: Mapping[str, int]) -> None:
    """Of the libraries by file, in the whole process: since threadpoolctl 3.8 who sets one keeps other threads out."""
    for library in _threads().lib_controllers:
        free = getattr(library, "clear_controlling_thread", lambda force: None)
        free(force=True)
        library.set_num_threads(counts[library.filepath])
        free(force=True)


@contextmanager
def one_thread() -> Iterator[None]:
    """Within it BLAS has one thread: how a product is split among several changes its last bits. With it every result
    is the same to the last bit on one machine, however many workers there are. The limit is one of the process: it is
    taken back by the last thread to go.
    """
    with _ENTERING:
        now = {library.filepath: library.num_threads for library in _threads().lib_controllers}
        _BEFORE.append(_BEFORE[0] if _BEFORE else now)
        _set_threads(dict.fromkeys(now, 1))
    try:
        yield
    finally:
        with _ENTERING:
            before = _BEFORE.pop()
            if not _BEFORE:
                _set_threads(before)


def compute(task: Task) -> Part:
    """Velocities and notes of a task, the same bits everywhere.

    Velocities are in `c0`; notes are the integers of `shell.Note`. This is what a worker runs.
    """
    with one_thread():
        found = ensemble.realize(task.configuration, task.realization, methods=task.methods, route=task.route)
    return _stacked(list(found.values()), len(task.methods))


def _stacked(found: Sequence[Extraction], methods: int) -> Part:
    velocities = np.array([e.velocities for e in found])
    notes = np.array([[note.value for note in e.notes] for e in found], dtype=np.int64)
    return velocities.reshape(-1, methods, *velocities.shape[1:]), notes.reshape(-1, methods, notes.shape[1])


def _stored(task: Task, folder: Path | None) -> Part | None:
    """What an earlier run wrote for this task; None if there is nothing, or nothing that can be of it."""
    shape = task.shape
    found = folder and kept.arrays(task.path(folder), task.about, velocities=(*shape, 2), notes=shape)
    return (found["velocities"], found["notes"]) if found and _agree(task, **found) else None


def _agree(task: Task, velocities: FloatArray, notes: IntArray) -> bool:
    """Whether there is a number where the notes allow one, and none only where a note says why."""
    there = np.isfinite(velocities)
    silent = np.array([METHODS[name].silences.value for name in task.methods])
    none = np.isnan(velocities).all(axis=-1)
    return bool((there.all(axis=-1) & (notes & silent[:, None] == 0) | none & (notes != 0)).all())


def _store(task: Task, folder: Path | None, part: Part) -> None:
    if folder is not None:
        kept.keep_arrays(task.path(folder), task.about, velocities=part[0], notes=part[1])


def _end_with_parent() -> None:
    """In a worker: leave when the process that started it is gone, however it went."""
    parent = multiprocessing.parent_process()
    if parent is not None:

        def follow() -> None:
            parent.join()
            os._exit(1)

        threading.Thread(target=follow, daemon=True).start()


@contextmanager
def pool(workers: int) -> Iterator[Executor | None]:
    """An executor of `workers` processes, or None for one: this process. Whatever ends it early ends them at once.

    An interruption kills the workers instead of waiting for what they are at. A worker that dies is a Trouble, with the
    advice to use fewer; LeakrefError is raised for fewer than one.
    """
    if workers < 1:
        raise LeakrefError("pool", f"{workers} workers", "ask for at least one")
    if workers == 1:
        yield None
        return
    context = Workers()
    with ProcessPoolExecutor(workers, mp_context=context, initializer=_end_with_parent) as executor:
        try:
            yield executor
        except BrokenProcessPool:
            context.kill()  # one that is just starting may never hear that the pool is broken
            raise Trouble(
                "run",
                "a worker process died, perhaps for want of memory",
                "use fewer workers; the same command goes on where this one stopped",
            ) from None
        except BaseException:
            executor.shutdown(wait=False, cancel_futures=True)
            context.kill()  # it would be waited for what they are at, for minutes
            raise


@contextmanager
def _hushed(*packages: str) -> Iterator[None]:
    """Without what some packages log: each of their loggers has a level of its own."""
    loggers = [logging.getLogger(name) for name in logging.root.manager.loggerDict if name.split(".")[0] in packages]
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
    """The executor of an existing dask.distributed cluster (extra `distributed`).

    `address` is that of its scheduler, such as `tcp://host:8786`. LeakrefError is raised if the library is missing or
    no scheduler answers within 10 s, Trouble if scheduler or workers go away while it runs.
    """
    try:
        from distributed import Client, KilledWorker
        from distributed.comm import CommClosedError
    except ModuleNotFoundError:
        raise LeakrefError("connected", "dask.distributed is not installed", installed_with("distributed")) from None
    try:
        client = Client(address, timeout=10)
    except (OSError, ValueError, TimeoutError) as error:
        raise LeakrefError(
            "connected",
            f"no scheduler answers at {address} ({error})",
            "start one with `dask scheduler` and give its address, tcp://host:8786",
        ) from None
    with _hushed("distributed", "tornado", "asyncio"), client:  # what they would say is said below, once
        try:
            yield client.get_executor(pure=False)
        except (CancelledError, KilledWorker, CommClosedError) as error:
            raise Trouble(
                "run",
                f"the scheduler at {address} or its workers are gone ({type(error).__name__})",
                "start them again; the same command goes on where this one stopped",
            ) from None


def run(
    configurations: Sequence[Configuration],
    *,
    realizations: int = REALIZATIONS,
    methods: Sequence[str] = DEFAULT,
    route: str = "B",
    folder: Path | None = None,
    executor: Executor | None = None,
    after_each: Callable[[], object] = lambda: None,
) -> Iterator[list[Ensemble]]:
    """Realisations 0 ... `realizations` - 1 of each configuration: its ensembles, a list for each in order.

    Realisations are tasks for `executor` (default: this process). With a `folder`, each result is written there as it
    comes, and one that is already there, whole and of the same source, is not computed again. Results do not depend on
    the executor, the number of its workers or the order of completion. Raises LeakrefError.

    An ensemble for each window and method of a configuration, windows first. `after_each` is called for every
    realisation, kept ones as well. A list is yielded as soon as its configuration is complete, and its parts are then
    let go. A kept part that is damaged is computed again.
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
    return [
        Ensemble(configuration, window, method, configuration.wavenumbers, velocities[:, w, m], notes[:, w, m])
        for w, window in enumerate(configuration.windows)
        for m, method in enumerate(methods)
    ]
