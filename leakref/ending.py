"""A command that is told to end does so within seconds, with all it has started, whatever it is at.

`install` is called once, by the command line; a library that uses leakref keeps its own handlers. The first signal
becomes a KeyboardInterrupt in the main thread, which unwinds as ever; if that takes longer than three seconds, because
a library does not come back to Python, the watching thread ends workers and programs and the process itself.
"""

from __future__ import annotations

import _thread
import multiprocessing
import os
import signal
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from multiprocessing.context import SpawnContext, SpawnProcess
from typing import Any

__all__ = ["TRACEBACK", "Workers", "install", "last_resorts", "over", "status", "told", "words"]

TRACEBACK = "LEAKREF_TRACEBACK"
"""In the environment: whatever broke is also shown in full (`leakref --traceback ...` sets it)."""
_SIGNALS = [getattr(signal, name) for name in ("SIGINT", "SIGTERM", "SIGHUP") if hasattr(signal, name)]
_PATIENCE = 3.0  # seconds to end in good order, of the five that there are
_HURRY = 1.0  # seconds for the last resorts together

last_resorts: set[Callable[[], object]] = set()
"""What is to be done where there is no end in good order: programs ended, folders removed. Added to, and taken from."""


class _Told:
    """Whether we were told to end, what holds that back for a moment, and whether it got lost."""

    by = 0  # the number of the first signal
    raised = lost = False
    deferred = 0


def told() -> bool:
    """Whether we were told to end.

    False until a signal has come, and true from then on: whoever catches the interruption can ask.
    """
    return _Told.by != 0


def status() -> int:
    """Exit status of a command that was told to end: 128 and the number of the signal, as in a shell."""
    return 128 + (_Told.by or signal.SIGINT)


def words() -> str:
    """What became of the command, for people.

    For instance `interrupted`, or `ended by SIGTERM`.
    """
    return f"ended by {signal.Signals(_Told.by).name}" if _Told.by not in (0, signal.SIGINT) else "interrupted"


def install() -> None:
    """Let the first signal that asks us to end raise KeyboardInterrupt, further ones nothing; the rest is by force.

    The main thread may be within a library for as long as it likes: another one waits for it, and no longer than that.
    """
    reader, writer = os.pipe()
    os.set_blocking(writer, False)
    signal.set_wakeup_fd(writer, warn_on_full_buffer=False)  # written to at once, by whichever thread is interrupted
    for number in _SIGNALS:
        if number in (signal.SIGINT, signal.SIGTERM) or signal.getsignal(number) is not signal.SIG_IGN:  # by nohup
            signal.signal(number, _interrupt)  # a job in the background of a script is started to ignore Ctrl-C
    sys.unraisablehook = _unraisable
    threading.Thread(target=_watch, args=(reader,), daemon=True).start()


def over() -> None:
    """The command is through: a signal ends the process now as it ends any other. SystemExit if one came before.
    Signals that come after one that was heeded are ignored, so that the last lines are written whole.
    """
    for number in _SIGNALS:
        if signal.getsignal(number) is _interrupt:
            signal.signal(number, signal.SIG_IGN if told() else signal.SIG_DFL)
    if told():
        raise SystemExit(status())


def _interrupt(number: int, frame: object) -> None:
    """An interruption that comes while it is held back is counted as lost, and repeated by `_watch`."""
    _Told.by = _Told.by or number
    if not (_Told.raised or _Told.deferred):
        _Told.raised = True
        raise KeyboardInterrupt
    _Told.lost |= not _Told.raised


def _unraisable(said: Any) -> None:
    """An interruption within a finaliser or a callback goes nowhere: it is to be repeated, not printed."""
    if isinstance(said.exc_value, KeyboardInterrupt):
        _Told.raised, _Told.lost = False, True
    elif os.environ.get(TRACEBACK):  # what else a destructor complains of has been said in a line, as what caused it
        sys.__unraisablehook__(said)


def _watch(reader: int) -> None:
    """The thread that `install` starts: it sleeps on the pipe until a signal is written there, repeats an interruption
    that got lost, and after `_PATIENCE` ends everything by force.
    """
    while os.read(reader, 1)[0] not in _SIGNALS:
        pass
    end = time.monotonic() + _PATIENCE
    while (left := end - time.monotonic()) > 0:
        time.sleep(min(left, 0.1))
        if _Told.lost and not _Told.deferred:
            _Told.lost = False
            _thread.interrupt_main(signal.SIGINT)
    _by_force()


def _by_force() -> None:
    """Workers first, then the last resorts, each of which may hang and is not waited for; one line, and the exit
    status.
    """
    for process in multiprocessing.active_children():
        process.kill()
    hurried = threading.Thread(target=_tidy, daemon=True)
    hurried.start()
    hurried.join(_HURRY)
    show_cursor = b"\x1b[?25h" if os.isatty(2) else b""  # a bar that is cut off has hidden it
    with suppress(OSError):
        os.write(2, show_cursor + f"leakref: {words()}\n".encode())
    os._exit(status())


def _tidy() -> None:
    """The last resorts, each of them whatever the others did."""
    for resort in list(last_resorts):
        with suppress(Exception):  # the others are to have their turn, and there is nobody left to tell
            resort()


class Workers(SpawnContext):
    """The context of a pool whose processes can all be ended at once.

    Its processes ignore Ctrl-C, and `kill` does not wait for what they are at. Used by `runs.pool`.
    """

    def __init__(self) -> None:
        super().__init__()
        self._started: list[_Worker] = []

    def Process(self, *args: Any, **keywords: Any) -> _Worker:  # type: ignore[override]  # one of ours
        """A process that is remembered."""
        self._started.append(_Worker(*args, **keywords))
        return self._started[-1]

    def kill(self) -> None:
        """End all of them, whatever they are at."""
        for process in self._started:
            if process.pid is not None:
                process.kill()


class _Worker(SpawnProcess):
    """A process that Ctrl-C does not reach: whoever started it hears of it, and ends it."""

    def start(self) -> None:
        """As ever, in one piece."""
        with _deferred():
            super().start()


@contextmanager
def _deferred() -> Iterator[None]:
    """No interruption within, and none ever of the processes started within, which inherit the mask."""
    _Told.deferred += 1
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT}) if os.name == "posix" else None
    try:
        yield
    finally:
        if before is not None:
            signal.pthread_sigmask(signal.SIG_SETMASK, before)
        _Told.deferred -= 1
