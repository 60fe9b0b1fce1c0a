"""The chain with lines of its source changed: variants of decisions, and faults.

A change names a module, a text that occurs in it exactly once, and what stands there instead. The altered modules are
imported under another package name, so that the chain itself, and other alterations, are not touched. The compiled
modules can be altered likewise; what no change reaches of them is shared, since compiling takes half a minute.

Faults (`certify.strength.faults`) and variants (`claims.variants`, `certify.strength.variants`) are such changes. They
are made in the text and not by patching objects, because the compiled loops would not see a patch. A text that no
longer occurs, or occurs twice, is refused before anything runs: a fault that changes nothing would pass for a weak
suite.

For instance the chain with a Hann window sampled the other way (D1):

    other = altered((Change("window", "symmetric: bool = False", "symmetric: bool = True"),))
    other.window.window("hann").samples(4)  # 0, 0.75, 0.75, 0
"""

from __future__ import annotations

import importlib
import importlib.abc
import importlib.machinery
import importlib.util
import re
import sys
import warnings
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache, lru_cache
from hashlib import sha256
from pathlib import Path
from types import CodeType, ModuleType
from typing import Any

from leakref import sources
from leakref._base import LeakrefError

__all__ = ["Change", "altered"]

_HOME = Path(__file__).parent
_SHARED = ("_base", "_caches")  # exceptions and types must be the same ones everywhere
_PACKAGE = __name__.rpartition(".")[0]


@dataclass(frozen=True)
class Change:
    """In `module`, `new` instead of `old`, which occurs exactly once.

    `module` is a dotted name below the package, such as `nsp` or `fast.score`. `old` may span lines, and must be text
    of the code as it is formatted.
    """

    module: str
    old: str
    new: str


class _Altered(importlib.abc.MetaPathFinder, importlib.abc.Loader):
    """Imports modules of the package `name` from the sources of leakref, changed."""

    def __init__(self, name: str, changes: Sequence[Change]) -> None:
        self.name, self.changes = name, changes

    def find_spec(self, fullname: str, path: Any = None, target: Any = None) -> importlib.machinery.ModuleSpec | None:
        if fullname == self.name or fullname.startswith(self.name + "."):
            is_package = _file(self._own(fullname)).stem == "__init__"
            return importlib.util.spec_from_loader(fullname, self, is_package=is_package)
        return None

    def _own(self, fullname: str) -> str:
        return fullname.removeprefix(self.name).lstrip(".") or "__init__"

    def exec_module(self, module: ModuleType) -> None:
        part = self._own(module.__name__)
        source = _changed(part, [change for change in self.changes if change.module == part])
        exec(_code(part, source), module.__dict__)


@lru_cache(maxsize=1024)
def _code(part: str, source: str) -> CodeType:
    """Compiled with imports that are relative, so that what is not changed is the same in all alterations."""
    package = part if _file(part).stem == "__init__" else part.rpartition(".")[0]
    root = "." * (1 if package in ("", "__init__") else 2 + package.count("."))
    own = re.sub(
        rf"^(\s*from )leakref(?!\.(?:{'|'.join(_SHARED)})\b)(?:\.|(?= ))", rf"\1{root}", source, flags=re.MULTILINE
    )
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", SyntaxWarning)  # a fault may be planted as `x is 3`: that is its affair
        return compile(own, f"<altered {part}>", "exec")


def _file(part: str) -> Path:
    """Where a module stands, a dotted name below the package."""
    place = _HOME.joinpath(*part.split("."))
    return place / "__init__.py" if place.is_dir() else place.with_suffix(".py")


def _changed(part: str, changes: Sequence[Change]) -> str:
    """The source of a module with its changes made. LeakrefError if a text to be changed is not there exactly once."""
    source = _file(part).read_text(encoding="utf-8")
    for change in changes:
        if (count := source.count(change.old)) != 1 or change.old == change.new:
            raise LeakrefError(
                "altered",
                f"{change.old!r} occurs {count} times in {part}.py",
                "bring the change up to date with the source",
            )
        source = source.replace(change.old, change.new)
    return source


@cache
def _alterable(*entries: str) -> list[str]:
    """What can be altered of the modules that compute something: all but the package itself and what is shared."""
    names = (module.partition(".")[2] for module in sources.closure(*(f"{_PACKAGE}.{entry}" for entry in entries)))
    return [name for name in names if name not in ("", *_SHARED)]


@cache
def _compiled() -> dict[str, set[str]]:
    """The compiled modules, and for each whose changes reach it."""
    return {
        part: {module.partition(".")[2] for module in sources.reach(f"{_PACKAGE}.{part}")} - {*_SHARED}
        for part in _alterable("fast", "cases")
        if any(name == "njit" for _, name in sources.imports(_file(part).read_text("utf-8"))[2])
    }


@cache
def altered(changes: tuple[Change, ...], *, fast: bool = False) -> Any:
    """The chain with all `changes` made: its modules as attributes, `altered(...).nsp` and so on.

    With `fast` also `cases`, `fast` and the compiled modules, these the package's own where no change reaches them.
    Raises LeakrefError if a change no longer fits the source, before anything runs.

    The same changes give the same package, made once in a process. Exceptions and array types are shared with the chain
    itself, so that a LeakrefError from an altered module is one.
    """
    modules = {change.module for change in changes}
    for part in modules:
        _changed(part, [change for change in changes if change.module == part])
    name = f"leakref_altered_{sha256(repr((changes, fast)).encode()).hexdigest()[:12]}"
    sys.meta_path.insert(0, _Altered(name, changes))
    package = importlib.import_module(name)
    for part, needs in _compiled().items() if fast else ():
        if not modules & needs:
            sys.modules[f"{name}.{part}"] = importlib.import_module(f"{_PACKAGE}.{part}")
    for part in _alterable("fast", "cases") if fast else _alterable("chain", "generator"):
        module = importlib.import_module(f"{name}.{part}")
        above, _, own = f"{name}.{part}".rpartition(".")
        setattr(sys.modules[above], own, module)
    return package
