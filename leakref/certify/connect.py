"""From what is named on the command line to the program that is judged."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from pathlib import Path

from leakref._base import LeakrefError
from leakref.certify.subject.protocol import HarnessBroken, Limits, ProcessSubject

__all__ = ["HarnessBroken", "Limits", "connect"]


def connect(target: str | None = None, command: Sequence[str] | None = None, *, limits: Limits | None = None,
            keep: Path | None = None) -> ProcessSubject:
    """The context in which a Python `target` (`targets.load`) or a `command`, an argument list, is judged, run here.

    It is started on entry, where LeakrefError is raised if that cannot be, and HarnessBroken if it does not answer.
    """
    if bool(target) == bool(command):
        raise LeakrefError("certify", "there are a target and a command" if target else "there is no target",
                           "give package.module:object, reference, fault:ID or variant:ID, or a command")
    if command:
        return ProcessSubject(command, limits=limits, keep=keep)
    worker = [sys.executable, "-m", "leakref.certify.worker", str(target), "tell-when-loading"]
    return ProcessSubject(worker, limits=limits, keep=keep, loading=Limits.start)
