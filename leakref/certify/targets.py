"""What a TARGET on the command line means."""

from __future__ import annotations

import importlib
import os
import sys
from typing import Any

from leakref._base import LeakrefError

__all__ = ["load"]


def load(target: str) -> Any:
    """The Python object that `target` names: reference, fault:ID, variant:ID or package.module:object.

    Raises LeakrefError if there is none of that name. What the module raises on import is passed on.
    """
    if target == "reference":
        from leakref.certify.strength.faults import Named
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
        raise LeakrefError("certify", f"{target!r} names nothing", "give package.module:object, reference, fault:ID or "
                           "variant:ID, or --command for a program")
    if os.getcwd() not in sys.path:
        sys.path.insert(0, os.getcwd())  # the caller's own modules, as python -m would find them
    try:
        found: Any = importlib.import_module(kind)
    except ModuleNotFoundError as error:
        raise LeakrefError("certify", f"there is no module {error.name!r}", "run it where the module can be "
                           "imported, or set PYTHONPATH") from None
    for part in name.split("."):
        if not hasattr(found, part):
            raise LeakrefError("certify", f"{kind} has no {name!r}", "name an object or a function of that module")
        found = getattr(found, part)
    return found() if isinstance(found, type) else found
