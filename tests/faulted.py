"""The properties called directly, with an implementation that need not be right: what comes of it."""

from __future__ import annotations

import importlib
import inspect
import itertools
from collections.abc import Callable, Iterator

import pytest

from leakref.properties.examined import Examined

MODULES = ("windows", "spectrum", "recovery", "symmetry", "scale", "optimum", "ensemble")


def _parameters(function: Callable[..., None]) -> Iterator[dict[str, object]]:
    marks = [mark.args for mark in getattr(function, "pytestmark", ()) if mark.name == "parametrize"]
    for values in itertools.product(*(given for _, given in marks)):
        yield dict(zip((name for name, _ in marks), values, strict=True))


def properties() -> dict[str, tuple[Callable[..., None], list[dict[str, object]]]]:
    """Every property by `module.name`, with what it is parametrised over."""
    found = {}
    for family in MODULES:
        module = importlib.import_module(f"leakref.properties.test_{family}")
        for name, function in vars(module).items():
            if name.startswith("test_") and inspect.isfunction(function):
                found[f"{family}.{name.removeprefix('test_')}"] = function, list(_parameters(function))
    return found


def outcome(name: str, examined: Examined) -> str:
    """pass, fail, or skip: of a property on an implementation. It fails if it does for any of its parameters."""
    function, cases = properties()[name]
    inside = "modules" in inspect.signature(function).parameters
    if inside and examined.modules is None:
        return "skip"
    said = set()
    for case in cases:
        try:
            function(**({"modules": examined.modules} if inside else {"examined": examined}), **case)
            said.add("pass")
        except pytest.skip.Exception:  # not offered: counted below, and all of them skipped is no pass
            said.add("skip")
        except Exception:  # a fault may well raise
            return "fail"
    return "pass" if "pass" in said else "skip"
