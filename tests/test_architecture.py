"""The house: who may import whom, what is public, and that a bare import is light."""

from __future__ import annotations

import ast
import importlib.util
import inspect
import subprocess
import sys
import tokenize
from graphlib import CycleError, TopologicalSorter
from pathlib import Path

import pytest

import leakref
from leakref.methods import METHODS

HOUSE = Path(leakref.__file__).parent
EVERY = sorted(
    ".".join(path.relative_to(HOUSE.parent).with_suffix("").parts).removesuffix(".__init__")
    for path in HOUSE.rglob("*.py")
    if "templates" not in path.parts
)
MODULES = sorted({name.split(".")[1] for name in EVERY if "." in name})
HEAVY = ("numpy", "scipy", "matplotlib", "numba", "pint")
# the table of the design, row by row; a row may use its own rooms, `_base` and `_caches`
ROOMS = {
    "_base": set(),
    "grid": set(),
    "dispersion": set(),
    "currents": {"dispersion"},
    "sea": {"grid", "dispersion", "currents"},
    "synthesis": {"sea"},
    "window": {"grid"},
    "spectrum": {"grid", "window"},
    "leakage": {"grid", "window", "spectrum", "sea"},
    "shell": {"spectrum", "dispersion", "window"},
    "nsp": {"spectrum", "dispersion", "shell"},
    "leastsquares": {"spectrum", "dispersion", "shell"},
}
# methods beside the paper's, a file each: whatever is registered
MORE = {record.extract.__module__.rpartition(".")[2] for record in METHODS.values()} - {"nsp", "leastsquares"}
ROOMS |= {room: {"grid", "spectrum", "dispersion", "shell", "nsp", "leastsquares"} for room in sorted(MORE)}
ROOMS["methods"] = {"grid", "dispersion", "nsp", "leastsquares", "shell", *MORE}
ROOMS["chain"] = {room for room in ROOMS if room != "_base"}
ABOVE = {"cases", "ensemble", "fast"}  # all of the above, and each other
FAST = [f"fast.{name}" for name in ("basins", "kernels", "leastsquares", "score", "spectra")]
ROOMS |= {room: {*ROOMS, *ABOVE} for room in [*sorted(ABOVE), *FAST]}


def source(module: str) -> ast.Module:
    """The parsed source of a module, by its dotted name."""
    return ast.parse(Path(importlib.util.find_spec(module).origin).read_text(encoding="utf-8"))


def mentioned(module: str) -> set[str]:
    """The modules of leakref that a module's source mentions in an import, wherever it stands."""
    found = set()
    for node in ast.walk(source(module)):
        if isinstance(node, ast.Import):
            names = [alias.name for alias in node.names]
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"{module} imports relatively: {ast.unparse(node)}"
            names = [f"{node.module}.{alias.name}" for alias in node.names]
        else:
            continue
        found |= {name if name in EVERY else name.rpartition(".")[0] for name in names}
    return found & set(EVERY) - {module}


def imported(room: str) -> set[str]:
    """Likewise, but by rooms: files and folders of the house."""
    return {name.split(".")[1] for name in mentioned(f"leakref.{room}") if "." in name}


@pytest.mark.parametrize("module", ROOMS)
def test_rooms_import_only_what_the_design_allows(module):
    assert imported(module) - {"_base", "_caches", module.partition(".")[0]} <= ROOMS[module]


def test_the_reader_of_imports_sees_every_form():
    assert imported("chain") == {
        "_base",
        "dispersion",
        "grid",
        "leakage",
        "methods",
        "sea",
        "shell",
        "spectrum",
        "synthesis",
        "window",
    }
    assert imported("grid") == {"_base"}


def test_no_imports_run_in_a_circle():
    graph = {module: mentioned(module) for module in EVERY if module != "leakref"}  # which has the names, on first use
    assert "leakref.certify.checks.registry" in graph["leakref.certify.runner"]
    TopologicalSorter(graph).prepare()
    graph["leakref.grid"].add("leakref.chain")
    with pytest.raises(CycleError):
        TopologicalSorter(graph).prepare()


def light(code: str) -> set[str]:
    """Which heavy packages are loaded after `code` ran in a fresh interpreter."""
    report = f"\nimport sys; print('loaded:', *(set(sys.modules) & set({HEAVY})), file=sys.stderr)"
    done = subprocess.run([sys.executable, "-c", code + report], capture_output=True, text=True, check=True)
    return set(done.stderr.rpartition("loaded:")[2].split())


def test_importing_leakref_loads_nothing_heavy():
    assert light("import leakref; leakref.__version__; dir(leakref)") == set()
    assert "numpy" in light("import leakref; leakref.Grid")  # the look-out sees what there is to see


@pytest.mark.parametrize("arguments", [["--help"], ["--version"]])
def test_help_and_version_load_nothing_heavy(arguments):
    code = (
        f"import sys; sys.argv = ['leakref', *{arguments}]\nfrom leakref.cli import main\n"
        "try:\n    main()\nexcept SystemExit as end:\n    assert not end.code, end.code"
    )
    assert light(code) == set()


def defined(module: str) -> set[str]:
    """Public names that a module's source itself binds at its top level."""
    names = set()
    for node in source(module).body:
        if isinstance(node, ast.FunctionDef | ast.ClassDef):
            names.add(node.name)
        elif isinstance(node, ast.Assign | ast.AnnAssign):
            targets = node.targets if isinstance(node, ast.Assign) else [node.target]
            names |= {name.id for target in targets for name in ast.walk(target) if isinstance(name, ast.Name)}
    return {name for name in names if not name.startswith("_")}


@pytest.mark.parametrize("module", ROOMS)
def test_all_is_true_and_complete(module):
    exported = importlib.import_module(f"leakref.{module}").__all__
    assert len(set(exported)) == len(exported)
    assert set(exported) == defined(f"leakref.{module}")


def test_all_names_of_the_package_resolve():
    assert len(set(leakref.__all__)) == len(leakref.__all__)
    assert dir(leakref) == sorted(leakref.__all__)
    for name in leakref.__all__:
        value = getattr(leakref, name)
        home = getattr(value, "__module__", None)
        if name != "__version__" and home in {f"leakref.{m}" for m in MODULES} and not name.islower():
            assert name in sys.modules[home].__all__
    with pytest.raises(AttributeError, match="no attribute 'nonsense'"):
        leakref.nonsense  # noqa: B018  # reading it raises


@pytest.mark.parametrize("module", EVERY)
def test_everything_public_has_a_docstring(module):
    loaded = importlib.import_module(module)
    assert loaded.__doc__
    assert hasattr(loaded, "__all__") or not defined(module)
    for name in getattr(loaded, "__all__", ()):
        value = getattr(loaded, name)
        if not (inspect.isfunction(value) or inspect.isclass(value)) or value.__module__ != loaded.__name__:
            continue
        assert value.__doc__, name
        if inspect.isclass(value) and not getattr(value, "_is_protocol", False):
            for member, part in vars(value).items():
                function = part.fget if isinstance(part, property) else getattr(part, "__func__", part)
                if not member.startswith("_") and inspect.isfunction(function):
                    assert function.__doc__, f"{name}.{member}"


def explaining(path: Path) -> int:
    """Lines of a file that are docstrings, of modules, classes, functions and names, or hold a comment."""
    text = path.read_text(encoding="utf-8")
    blocks = [node.body for node in ast.walk(ast.parse(text)) if isinstance(getattr(node, "body", None), list)]
    said = [
        one.value
        for body in blocks
        for one in body
        if isinstance(one, ast.Expr) and isinstance(one.value, ast.Constant) and isinstance(one.value.value, str)
    ]
    lines = {n for one in said for n in range(one.lineno, one.end_lineno + 1)}
    with path.open("rb") as stream:
        tokens = list(tokenize.tokenize(stream.readline))
    return len(lines | {token.start[0] for token in tokens if token.type == tokenize.COMMENT})


def test_enough_of_the_package_says_what_it_does():
    files = [path for path in HOUSE.rglob("*.py") if "templates" not in path.parts]
    lines = sum(len(path.read_text(encoding="utf-8").splitlines()) for path in files)
    assert sum(map(explaining, files)) / lines >= 0.18


def test_no_module_is_longer_than_one_reads_in_a_sitting():
    long = {path.name: n for path in HOUSE.rglob("*.py") if (n := len(path.read_text("utf-8").splitlines())) > 400}
    assert long == {}
