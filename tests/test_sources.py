"""What a digest covers: every module that computes, none that does not, found by reading imports."""

from __future__ import annotations

import ast
import shutil
import sys
import tomllib
from pathlib import Path

import pytest
from test_architecture import EVERY, mentioned

import leakref
from leakref import altered, runs, sources
from leakref.certify.strength import study
from leakref.claims import evidence, shifts
from leakref.golden import entries
from leakref.methods import METHODS

HOUSE = Path(leakref.__file__).parent
PROJECT = HOUSE.parent
ENTRIES = (
    "leakref.runs",
    "leakref.claims.evidence",
    "leakref.claims.shifts",
    "leakref.certify.strength.study",
    "leakref.golden.entries",
)
CHAIN = {
    "leakref",
    *(
        f"leakref.{name}"
        for name in (
            "_base",
            "grid",
            "dispersion",
            "currents",
            "sea",
            "synthesis",
            "window",
            "spectrum",
            "leakage",
            "shell",
            "nsp",
            "leastsquares",
            *sorted({m.extract.__module__.rpartition(".")[2] for m in METHODS.values()} - {"nsp", "leastsquares"}),
            "methods",
            "chain",
            "cases",
            "ensemble",
            "fast",
            "fast.basins",
            "fast.kernels",
            "fast.leastsquares",
            "fast.score",
            "fast.spectra",
        )
    ),
}
"""Between a case of the paper and its velocities: known apart from what any code derives."""
NEVER = {
    "leakref.cli",
    "leakref.figures",
    "leakref.paper.figures",
    "leakref.explain",
    "leakref.demo",
    "leakref.plugin",
    "leakref.track.page",
    "leakref.certify.commands",
    "leakref.claims.pictures",
    "leakref.golden.commands",
}


@pytest.fixture(scope="module")
def scratch(tmp_path_factory):
    """A copy of the package."""
    root = tmp_path_factory.mktemp("scratch") / "leakref"
    shutil.copytree(HOUSE, root, ignore=shutil.ignore_patterns("__pycache__", "templates"))
    return root


def walked(entry: str) -> set[str]:
    """The closure by the reader of imports of the tests of architecture, which follows every mention."""
    found, waiting = set(), [entry]
    while waiting:
        module = waiting.pop()
        if module not in found:
            found.add(module)
            waiting += sorted(mentioned(module) - {"leakref"})
    return found


def test_a_change_of_a_module_changes_the_digests_of_what_it_computes_and_no_other(scratch):
    before = {entry: sources.digest(entry, root=scratch) for entry in ENTRIES}
    changed = {entry: set() for entry in ENTRIES}
    for module in EVERY:
        path = scratch.joinpath(*module.split(".")[1:])
        path = path / "__init__.py" if path.is_dir() else path.with_suffix(".py")
        whole = path.read_bytes()
        path.write_bytes(whole + b"\n_ANOTHER = 1\n")
        for entry in ENTRIES:
            if sources.digest(entry, root=scratch) != before[entry]:
                changed[entry].add(module)
        path.write_bytes(whole)
    assert {entry: sources.digest(entry, root=scratch) for entry in ENTRIES} == before
    for entry in ENTRIES:
        assert changed[entry] >= CHAIN, CHAIN - changed[entry]
        assert not changed[entry] & NEVER
        assert changed[entry] - {"leakref"} == walked(entry) | changed[entry] & CHECKS
    assert changed["leakref.certify.strength.study"] >= CHECKS  # which are imported by name at run time
    assert not any(changed[entry] & CHECKS for entry in ENTRIES if entry != "leakref.certify.strength.study")


CHECKS = {name for name in EVERY if name.startswith("leakref.certify.checks.")} - {"leakref.certify.checks.conformance"}


def test_stored_results_are_named_by_those_digests(monkeypatch):
    monkeypatch.setattr(sources, "version", lambda name: {"numba": "0"}.get(name, "1"))
    digests = (runs.source_digest, evidence.source_digest, shifts._source_digest, entries._source_digest)
    for entry, digest in zip(ENTRIES[:3] + ENTRIES[4:], digests, strict=True):
        assert digest.__wrapped__() == sources.digest(entry)
    manifest = study.locate().joinpath("manifest.json").read_bytes()
    assert study.source_digest.__wrapped__() == sources.digest(ENTRIES[3], more=manifest)
    assert sources.digest(ENTRIES[3], more=manifest + b" ") != sources.digest(ENTRIES[3], more=manifest)


@pytest.mark.parametrize("library", ["numpy", "scipy", "numba"])
def test_another_version_of_a_library_is_another_digest(library, monkeypatch):
    before = sources.digest("leakref.grid")
    plain = sources.version
    monkeypatch.setattr(sources, "version", lambda name: "0" if name == library else plain(name))
    assert sources.digest("leakref.grid") != before


SMALL = {
    "__init__": "from typing import TYPE_CHECKING\nif TYPE_CHECKING:\n    from small.lazy import Lazy\n"
    "def __getattr__(name):\n    from small import never\n",
    "lazy": "Lazy = 1",
    "never": "",
    "typed": "",
    "late": "from small import deep",
    "deep": "",
    "plain": "",
    "many/__init__": "import importlib\ndef load(n):\n    importlib.import_module(f'small.many.{n}')",
    "many/one": "",
    "many/two": "import small.plain as p",
    "entry": "from typing import TYPE_CHECKING\n"
    "if TYPE_CHECKING:\n    from small import typed\nelse:\n    from small import Lazy\n"
    "def f():\n    import small.late\n    from small.many import load\n",
}


@pytest.fixture
def small(tmp_path):
    for name, text in SMALL.items():
        path = tmp_path / "small" / f"{name}.py"
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text)
    return tmp_path / "small"


def test_every_form_of_import_is_read(small):
    assert set(sources.closure("small.entry", root=small)) == {
        "small",
        "small.entry",
        "small.lazy",
        "small.late",
        "small.deep",
        "small.many",
        "small.many.one",
        "small.many.two",
        "small.plain",
    }
    assert set(sources.closure("small.many.two", root=small)) == {"small.many.two", "small.plain"}
    with pytest.raises(ModuleNotFoundError, match=r"no source of small\.nothing"):
        sources.closure("small.nothing", root=small)


def test_reach_follows_definitions_and_not_annotations(small):
    (small / "lazy.py").write_text("from small import deep, late\nSTART = 1\ndef other():\n    return deep.x, late.y\n")
    (small / "late.py").write_text("y = 2")
    (small / "entry.py").write_text(
        "from small import lazy, plain\nfrom small.plain import P\ndef f(a: P) -> plain.Q:\n    return lazy.START\n"
    )
    assert sources.reach("small.entry", small) == {"small.entry", "small.lazy"}
    (small / "entry.py").write_text("from small.lazy import other\nx = other()\n")
    assert sources.reach("small.entry", small) == {"small.entry", "small.lazy", "small.deep", "small.late"}


def test_compiled_modules_are_shared_unless_a_change_reaches_them():
    compiled = altered._compiled()
    names = ("basins", "kernels", "leastsquares", "score")
    assert compiled == {f"fast.{name}": {f"fast.{name}"} for name in names}
    assert {f"leakref.{name}" for name in altered._alterable("fast", "cases")} == CHAIN - {
        "leakref",
        "leakref._base",
        "leakref.ensemble",
    }


def test_compiled_code_takes_nothing_from_another_module():
    """Numba keeps it by the file that it is in: what it took from another would stay as it was when that changes."""
    functions = 0
    for room in altered._compiled():
        text = altered._file(room).read_text(encoding="utf-8")
        named = sources.imports(text)[0]
        for node in ast.parse(text).body:
            if isinstance(node, ast.FunctionDef) and node.decorator_list:
                functions += 1
                taken = {name for name, _ in sources._definitions(text)[node.name] if name in named}
                assert not {name for name in taken if named[name][0].startswith("leakref")}, node.name
    assert functions > 10


def test_the_wheel_has_every_package_of_the_tree():
    """The list is written out, since setuptools cannot find packages and take others from elsewhere at once."""
    said = tomllib.loads((PROJECT / "pyproject.toml").read_text(encoding="utf-8"))["tool"]["setuptools"]
    tree = {".".join(path.parent.relative_to(PROJECT).parts) for path in HOUSE.rglob("__init__.py")}
    elsewhere = {name for name, folder in said["package-dir"].items() if name != folder}
    assert sorted(said["packages"]) == sorted(tree | elsewhere)
    assert all((PROJECT / said["package-dir"][name] / "__init__.py").is_file() for name in elsewhere)


def test_reading_the_sources_runs_none_of_them(scratch):
    known = set(sys.modules)
    sources.closure("leakref.certify.strength.study", root=scratch)
    assert set(sys.modules) == known
