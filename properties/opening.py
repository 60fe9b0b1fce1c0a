"""From what is named on the command line to what is examined."""

from __future__ import annotations

import shlex
from collections.abc import Callable
from contextlib import ExitStack
from typing import Any

from leakref._base import LeakrefError

from .examined import Examined, reference

__all__ = ["examined", "opened"]


def examined(target: str) -> Examined:
    """A Python object by its name (`targets.load`). A fault of the reference has its inside too."""
    from leakref.altered import altered
    from leakref.certify.strength.faults import FAULTS
    from leakref.certify.subject.inprocess import InProcess
    from leakref.certify.targets import load

    if target == "reference":
        return reference()
    implementation = load(target)
    kind, _, name = target.partition(":")
    modules = altered(FAULTS[name].changes) if kind == "fault" else None
    return Examined(InProcess(implementation), modules)


def opened(target: str | None, command: str | None, profile: str = "quick") -> tuple[Examined, Callable[[], Any]]:
    """What is to be examined, and what closes it. Raises LeakrefError, HarnessBroken, or what an import raises."""
    if target is not None:
        return examined(target), lambda: None
    from leakref.certify.targets import Limits, connect

    try:
        words = shlex.split(str(command))
    except ValueError as error:
        raise LeakrefError(
            "pytest", f"--leakref-command cannot be split ({error})", "quote it as for a shell"
        ) from None
    stack = ExitStack()
    limits = Limits(run=600.0 if profile == "full" else 120.0)
    return Examined(stack.enter_context(connect(command=words, limits=limits))), stack.close
