"""How a command ends: its exit status, and one line for whatever broke in leakref or around it."""

from __future__ import annotations

import errno
import os
import signal
import sys
import threading
import traceback
from collections.abc import Callable
from contextlib import suppress

__all__ = ["TRACEBACK", "ended", "listen", "plugged", "quiet", "say"]

TRACEBACK = "LEAKREF_TRACEBACK"
"""In the environment: whatever broke is also shown in full (`leakref --traceback ...` sets it)."""
_WRONG_USE, _UNJUDGED = 2, 3
_SIGNALLED = 128  # and the number of the signal, as in a shell
_SIGNALS = [getattr(signal, name) for name in ("SIGINT", "SIGTERM", "SIGHUP") if hasattr(signal, name)]
_told: list[int] = []


def listen() -> None:
    """Take a request to end as Ctrl-C is taken: programs under judgement and temporary folders go as well."""
    sys.unraisablehook = _unraisable
    for number in _SIGNALS:
        if signal.getsignal(number) in (signal.SIG_DFL, signal.default_int_handler):  # under nohup it stays ignored
            signal.signal(number, _tell)


def quiet() -> None:
    """From here on nothing is left to do: a signal ends the process, without words."""
    for number in _SIGNALS:
        if signal.getsignal(number) is _tell:
            signal.signal(number, signal.SIG_DFL)


def _tell(number: int, frame: object) -> None:
    if _told and number != signal.SIGINT:
        return  # it is ending; only who presses Ctrl-C once more has lost patience
    _told.append(number)
    raise KeyboardInterrupt


def _unraisable(lost: sys.UnraisableHookArgs) -> None:
    """Nothing can be raised out of a destructor or a callback from C: there the request is made again soon after."""
    if issubclass(lost.exc_type, KeyboardInterrupt) and _told:
        threading.Timer(0.02, os.kill, [os.getpid(), _told.pop()]).start()
    elif os.environ.get(TRACEBACK):  # what else a destructor complains of has been said in a line, as what caused it
        sys.__unraisablehook__(lost)


def plugged() -> None:
    """Something to write to where a standard stream is closed: else the next file opened would take its number."""
    for name, mode in (("stdin", "r"), ("stdout", "w"), ("stderr", "w")):
        if getattr(sys, name) is None:
            setattr(sys, name, open(os.devnull, mode, encoding="utf-8"))  # noqa: SIM115


def say(text: str) -> None:
    """One line on standard error, whatever is in it, and whether or not there is any."""
    with suppress(OSError, ValueError):
        print("leakref:", " ".join(text.split()), file=sys.stderr, flush=True)


def ended(name: str, body: Callable[[], bool | int]) -> int:
    """The exit status of a command: what `body` returns (True: 0, False: 1), or of what it raised, said in one line.

    A refusal is wrong use, 2, unless it has another `status`. A signal is 128 and its number, as is a reader who has
    gone, without words. Whatever else is raised is 3.
    """
    try:
        holds = body()
        sys.stdout.flush()
        return (0 if holds else 1) if isinstance(holds, bool) else holds
    except BaseException as error:
        if os.environ.get(TRACEBACK):
            with suppress(OSError):
                traceback.print_exc()
        return _status(name, error)
    finally:
        _emptied()


def _status(name: str, error: BaseException) -> int:
    if _told or isinstance(error, KeyboardInterrupt):
        number = _told[0] if _told else signal.SIGINT
        say("interrupted" if number == signal.SIGINT else f"ended by {signal.Signals(number).name}")
        return _SIGNALLED + number
    if isinstance(error, BrokenPipeError) or isinstance(error.__context__, BrokenPipeError):  # rich: SystemExit(1)
        return _SIGNALLED + getattr(signal, "SIGPIPE", 13)
    if hasattr(error, "remedy"):  # a LeakrefError; nothing is imported here, where anything may be broken
        say(str(error))
        return int(getattr(error, "status", _WRONG_USE))
    say(f"{name}: " * bool(name) + f"{_fault(error)}. `leakref --traceback ...` shows where.")
    return _UNJUDGED


def _fault(error: BaseException) -> str:
    """What broke, and what to do about it."""
    said = str(error)[:500] or type(error).__name__
    if isinstance(error, MemoryError):
        return f"not enough memory ({said}); use fewer --workers, or a machine with more"
    if isinstance(error, OSError):
        remedy = {errno.ENOSPC: "make room, or let TMPDIR name a folder that has some",
                  errno.EMFILE: "allow more open files (ulimit -n)"}
        return f"{said}; {remedy.get(error.errno or 0, 'see to that and try again')}"
    return f"a fault of its own, {type(error).__name__}: {said}; please report it"


def _emptied() -> None:
    """What cannot be written to standard output is dropped now, or Python would complain of it at its very end."""
    for stream in (sys.stdout, sys.stderr):
        try:
            stream.flush()
        except (OSError, ValueError):
            with suppress(OSError, ValueError):
                sink = os.open(os.devnull, os.O_WRONLY)
                os.dup2(sink, stream.fileno())
                os.close(sink)
