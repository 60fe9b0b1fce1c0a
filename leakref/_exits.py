"""How a command ends: its exit status, and one line for whatever broke in leakref or around it."""

from __future__ import annotations

import errno
import os
import signal
import sys
import traceback
from collections.abc import Callable
from contextlib import suppress

from leakref import ending
from leakref.ending import TRACEBACK

__all__ = ["plugged", "say", "status_of"]

_WRONG_USE, _UNJUDGED = 2, 3
_SIGNALLED = 128  # and the number of the signal, as in a shell


def plugged() -> None:
    """Something to write to where a standard stream is closed: else the next file opened would take its number."""
    for name, mode in (("stdin", "r"), ("stdout", "w"), ("stderr", "w")):
        if getattr(sys, name) is None:
            setattr(sys, name, open(os.devnull, mode, encoding="utf-8"))  # noqa: SIM115  # it is the stream from now on


def say(text: str) -> None:
    """One line on standard error, whatever is in it, and whether or not there is any."""
    with suppress(OSError, ValueError):
        print("leakref:", " ".join(text.split()), file=sys.stderr, flush=True)


def status_of(name: str, body: Callable[[], bool | int]) -> int:
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
    """The exit status for whatever ended a command, after one line has said so."""
    if isinstance(error, KeyboardInterrupt) or ending.told():
        say(ending.words())
        return ending.status()
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
        remedy = {
            errno.ENOSPC: "make room, or let TMPDIR name a folder that has some",
            errno.EMFILE: "allow more open files (ulimit -n)",
        }
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
