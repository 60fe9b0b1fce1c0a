"""What a result depends on, read from the sources themselves: the modules that what computes it imports.

Imports are read and not run, those inside functions too; those for type checkers alone are left out. `from package
import name` counts for the module of that name or, if there is none, for the `__init__` that has the name; importing a
submodule does not count for the `__init__` above it, which has no way into what the submodule computes.

Digests of kept results and of histories come from `digest`, so that a change in a module that has nothing to do with a
number does not throw the number away. `reach` goes further, by definitions, and decides which compiled modules an
alteration must compile again.

A digest is of whole files, so that a docstring that changes makes kept results be computed again: that is the price of
never having to ask what a change meant.
"""

from __future__ import annotations

import ast
from collections.abc import Iterator
from functools import cache
from hashlib import sha256
from importlib.metadata import version
from pathlib import Path
from typing import Any

__all__ = ["LIBRARIES", "closure", "digest", "imports", "reach"]

LIBRARIES = ("numpy", "scipy", "numba")
"""Whose versions are part of every digest: another one may round otherwise."""
_ROOT = Path(__file__).parent
Pair = tuple[str, str]
"""A module, and a name asked of it ("" for the module itself, "*" for all that lies in a package)."""


class _Imports(ast.NodeVisitor):
    """Collects what a source imports when it runs (`run`) and what only its type checker sees (`typed`)."""

    def __init__(self) -> None:
        self.run: list[tuple[str, Pair]] = []  # under which name, and what
        self.typed: list[tuple[str, Pair]] = []

    def visit_If(self, node: ast.If) -> None:
        if "TYPE_CHECKING" not in ast.unparse(node.test):
            return self.generic_visit(node)
        within = _Imports()
        for part in node.body:
            within.visit(part)
        self.typed += within.run
        for part in node.orelse:
            self.visit(part)

    def visit_FunctionDef(self, node: ast.FunctionDef) -> None:
        if node.name != "__getattr__":  # of a package: each name is looked up where it is asked for, see `_home`
            self.generic_visit(node)

    def visit_Import(self, node: ast.Import) -> None:
        self.run += [(one.asname or one.name, (one.name, "")) for one in node.names]

    def visit_ImportFrom(self, node: ast.ImportFrom) -> None:
        self.run += [(one.asname or one.name, (node.module or "", one.name)) for one in node.names]

    def visit_Call(self, node: ast.Call) -> None:
        """`import_module(f"package.{name}")` may be any module of the package."""
        given = node.args[0] if node.args else None
        called = node.func.attr if isinstance(node.func, ast.Attribute) else getattr(node.func, "id", "")
        if called == "import_module" and isinstance(given, ast.JoinedStr):
            first = given.values[0]
            if isinstance(first, ast.Constant) and str(first.value).endswith("."):
                self.run.append(("", (str(first.value)[:-1], "*")))
        self.generic_visit(node)


@cache
def imports(text: str) -> tuple[dict[str, Pair], dict[str, Pair], frozenset[Pair]]:
    """Of a source: imported names and what they are, the same of type checkers' imports, and all that is imported.

    The last is a set of pairs of module and name, the others are by the name under which something is known there.
    Parsed once for each text.
    """
    found = _Imports()
    found.visit(ast.parse(text))
    return dict(found.run), dict(found.typed), frozenset(pair for _, pair in found.run)


def _file(module: str, root: Path) -> Path | None:
    head, *rest = module.split(".")
    if head != root.name:
        return None
    place = root.joinpath(*rest)
    return next((p for p in (place / "__init__.py", place.with_suffix(".py")) if p != root and p.is_file()), None)


def _home(pair: Pair, root: Path) -> Iterator[Pair]:
    """The modules of the package that an import counts for, each with the name asked of it. A name that a package loads
    on first use (`__getattr__`) is looked up among the imports of its type checkers.
    """
    module, name = pair
    path = _file(module, root)
    if name == "*":
        folder = root.joinpath(*module.split(".")[1:])
        yield from ((f"{module}.{one.stem}", "") for one in sorted(folder.glob("*.py")) if one.stem != "__init__")
    elif name and _file(f"{module}.{name}", root):
        yield f"{module}.{name}", ""
    elif path:
        yield pair
        if name and path.name == "__init__.py":
            typed = imports(path.read_text(encoding="utf-8"))[1]
            if name in typed:  # a name that the package loads on first use
                yield from _home(typed[name], root)


def closure(*entries: str, root: Path = _ROOT) -> dict[str, Path]:
    """The modules that `entries` import, and those import, with their files; the package lies in folder `root`.

    Sorted by name. Raises ModuleNotFoundError for an entry that has no source there; imports from outside are left out.
    """
    found: dict[str, Path] = {}
    waiting, seen = list(entries), set[Pair]()
    while waiting:
        module = waiting.pop()
        if module not in found:
            path = _file(module, root)
            if path is None:
                raise ModuleNotFoundError(f"no source of {module} in {root}")
            found[module] = path
            pairs = {
                (of, name)
                for of, name in imports(path.read_text(encoding="utf-8"))[2] - seen
                if of.partition(".")[0] == root.name
            }
            seen |= pairs
            waiting += [home for pair in pairs for home, _ in _home(pair, root)]
    return dict(sorted(found.items()))


def digest(*entries: str, root: Path = _ROOT, more: bytes = b"") -> str:
    """SHA-256 of the sources of `closure`, of the versions of `LIBRARIES`, and of `more`.

    `entries` are dotted names. The hexadecimal text is returned. Whole files count, their comments too.
    """
    parts = [
        part for module, path in closure(*entries, root=root).items() for part in (module.encode(), path.read_bytes())
    ]
    versions = " ".join(f"{name} {version(name)}" for name in LIBRARIES)
    return sha256(b"\0".join([*parts, versions.encode(), more])).hexdigest()


# ---------------------------------------------------------------- by definition

_ANNOTATIONS = {"annotation", "returns"}


def _code(node: ast.AST) -> Iterator[ast.AST]:
    """A node and all within but for annotations, which are never evaluated."""
    yield node
    for name, value in ast.iter_fields(node):
        for part in (value if isinstance(value, list) else [value]) if name not in _ANNOTATIONS else ():
            if isinstance(part, ast.AST):
                yield from _code(part)


@cache
def _definitions(text: str) -> dict[str, frozenset[Pair]]:
    """By name bound at the top of a source, "" for everything: the (name, attribute or "") that its code reads."""
    found: dict[str, set[Pair]] = {"": set()}
    for statement in ast.parse(text).body:
        if isinstance(statement, ast.Import | ast.ImportFrom):
            continue
        nodes = list(_code(statement))
        read = {(n.id, "") for n in nodes if isinstance(n, ast.Name) and isinstance(n.ctx, ast.Load)}
        read |= {(n.value.id, n.attr) for n in nodes if isinstance(n, ast.Attribute) and isinstance(n.value, ast.Name)}
        bound: set[Any] = {
            getattr(statement, "name", ""),
            *(n.id for n in nodes if isinstance(n, ast.Name) and isinstance(n.ctx, ast.Store)),
        }
        for name in {"", *bound}:
            found.setdefault(name, set()).update(read)
    return {name: frozenset(read) for name, read in found.items()}


def reach(module: str, root: Path = _ROOT) -> set[str]:
    """The modules whose definitions the code of `module` uses, or those use in turn: a part of its `closure`.

    Finer than imports: a module that is imported for one constant does not bring all that it imports itself.

    Names are followed from definition to definition; annotations do not count, since they are never evaluated.
    """
    seen: set[Pair] = set()
    waiting: list[Pair] = [(module, "")]
    while waiting:
        pair = waiting.pop()
        path = _file(pair[0], root)
        if pair in seen or path is None:
            continue
        seen.add(pair)
        text = path.read_text(encoding="utf-8")
        named = imports(text)[0]
        for name, attribute in _definitions(text).get(pair[1], ()):
            if name not in named:
                waiting.append((pair[0], name))
                continue
            for home, of in _home(named[name], root):
                waiting += [(home, of or attribute)] if of or attribute else []
    return {home for home, _ in seen}
