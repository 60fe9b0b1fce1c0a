"""What a TARGET on the command line means.

Four kinds of names are understood: `reference`, `fault:ID`, `variant:ID` and `package.module:object`. `load` turns one
into an object, here; `connect` into a context in which it runs in a process of its own, as `leakref certify` wants it.
A program that is not Python has no name and is given as a command.
"""

from __future__ import annotations

import importlib
import os
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from leakref._base import LeakrefError
from leakref.certify.subject.protocol import HarnessBroken, Limits, ProcessSubject

__all__ = ["HarnessBroken", "Limits", "connect", "load"]


def load(target: str) -> Any:
    """The Python object that `target` names: reference, fault:ID, variant:ID or package.module:object.

    Raises LeakrefError if there is none of that name. What the module raises on import is passed on.

    A class is called without arguments and the instance returned; any other object is returned as it is. The current
    folder is put in front of the search path, as `python -m` does. LeakrefError is raised for a name that is malformed,
    a module that is not there (its own missing imports too, by the name of the missing one), an attribute that the
    module lacks, and an unknown fault or variant.
    """
    if target == "reference":
        from leakref.certify.subject.named import Named
        from leakref.chain import reference

        return Named(reference, "leakref")  # with null where it has no number
    kind, _, name = target.partition(":")
    if kind == "fault":
        from leakref.certify.strength.faults import implementation

        return implementation(name)
    if kind == "variant":
        from leakref.certify.strength.variants import implementation

        return implementation(name)
    if not name or not all(part.isidentifier() for part in kind.split(".")):
        raise LeakrefError(
            "certify",
            f"{target!r} names nothing",
            "give package.module:object, reference, fault:ID or variant:ID, or --command for a program",
        )
    if os.getcwd() not in sys.path:
        sys.path.insert(0, os.getcwd())  # the caller's own modules, as python -m would find them
    try:
        found: Any = importlib.import_module(kind)
    except ModuleNotFoundError as error:
        raise LeakrefError(
            "certify",
            f"there is no module {error.name!r}",
            "run it where the module can be imported, or set PYTHONPATH",
        ) from None
    for part in name.split("."):
        if not hasattr(found, part):
            raise LeakrefError("certify", f"{kind} has no {name!r}", "name an object or a function of that module")
        found = getattr(found, part)
    return found() if isinstance(found, type) else found


def connect(
    target: str | None = None,
    command: Sequence[str] | None = None,
    *,
    limits: Limits | None = None,
    keep: Path | None = None,
    waves: Mapping[str, Any] | None = None,
) -> ProcessSubject:
    """The context in which a Python `target` (`targets.load`) or a `command`, an argument list, is judged, run here.

    It is started on entry, where LeakrefError is raised if that cannot be, and HarnessBroken if it does not answer.

    `limits` are of time and memory, `keep` is a folder in which the exchanged files stay, `waves` go before those that
    the code declares. A Python target gets
    `Limits.start` seconds for the import of leakref itself before its own start begins to count. LeakrefError is raised
    here, too, if both or neither of `target` and `command` are given.
    """
    if bool(target) == bool(command):
        raise LeakrefError(
            "certify",
            "there are a target and a command" if target else "there is no target",
            "give package.module:object, reference, fault:ID or variant:ID, or a command",
        )
    if command:
        return ProcessSubject(command, limits=limits, keep=keep, waves=waves)
    worker = [sys.executable, "-m", "leakref.certify.worker", str(target), "tell-when-loading"]
    return ProcessSubject(worker, limits=limits, keep=keep, loading=Limits.start, waves=waves)
