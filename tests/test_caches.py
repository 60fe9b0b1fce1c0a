"""Another user, no home, a package that belongs to somebody else: everything runs, and nothing is left."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

import leakref._golden
import leakref.properties

CODE = "from leakref.cli import main; main()"
OWN = ("XDG_CACHE_HOME", "XDG_CONFIG_HOME", "NUMBA_CACHE_DIR", "MPLCONFIGDIR", "PYTHONPATH", "PYTHONPYCACHEPREFIX")


@pytest.fixture(scope="module")
def foreign(tmp_path_factory):
    """A copy of the package that may not be written, and how to run Python as somebody who may not.

    Root becomes nobody, who keeps the right to read everything, since the interpreter may lie in a private home.
    """
    place = tmp_path_factory.mktemp("site")
    away = shutil.ignore_patterns("__pycache__")
    for package in (leakref, leakref.properties, leakref._golden):
        shutil.copytree(
            package.__path__[0], place.joinpath(*package.__name__.split(".")), ignore=away, dirs_exist_ok=True
        )
    for folder, _, _ in os.walk(place):
        os.chmod(folder, 0o555)
    _open(place)
    if os.geteuid():
        yield place, [sys.executable]
    else:
        right = ["--inh-caps", "-all,+dac_read_search", "--ambient-caps", "-all,+dac_read_search"]
        somebody = ["setpriv", "--reuid", "65534", "--regid", "65534", "--clear-groups", *right]
        yield place, [*(somebody if shutil.which("setpriv") else []), sys.executable]
    for folder, _, _ in os.walk(place):
        os.chmod(folder, 0o755)


def _open(folder):
    """Let others come as far as this: whether a place can be written is asked without any special rights."""
    for place in (folder, *folder.parents):
        if place == folder or place.name.startswith(("pytest-", "popen-")):
            place.chmod(place.stat().st_mode | 0o055)


def run(foreign, tmp_path, code, *words):
    """With a folder for temporary files as the only place that can be written. Nothing may be left there."""
    place, python = foreign
    temporary, home = tmp_path / "temporary", tmp_path / "home"
    temporary.mkdir()
    temporary.chmod(0o777)
    home.mkdir(mode=0o555)
    _open(tmp_path)
    env = {name: value for name, value in os.environ.items() if name not in OWN}
    env |= {"HOME": str(home), "TMPDIR": str(temporary), "PYTHONPATH": str(place)}
    done = subprocess.run(
        [*python, "-c", code, *map(str, words)],
        env=env,
        cwd="/",
        capture_output=True,
        text=True,
        timeout=1200,
        check=False,
    )
    assert list(temporary.iterdir()) == []
    assert list(home.iterdir()) == []
    return done


def test_another_user_without_a_home_can_certify(foreign, tmp_path):
    done = run(
        foreign,
        tmp_path,
        CODE,
        "certify",
        "fault:hard-coded-width",
        "--only",
        "signs",
        "--workers",
        "2",
        "--no-diagnosis",
    )  # of 125 faults, each to be compiled again
    assert done.returncode in (0, 1), done.stderr
    assert "no grade" not in done.stdout
    assert done.stderr == ""


def test_what_is_compiled_and_drawn_finds_a_place_and_its_children_share_it(foreign, tmp_path):
    code = """
import subprocess, sys
from leakref import _caches
if sys.argv[1:]:
    _caches.prepare()
import leakref.fast.score, leakref.certify.strength.variants, matplotlib, os
print(os.environ["NUMBA_CACHE_DIR"], matplotlib.get_configdir(), matplotlib.get_cachedir(), flush=True)
assert leakref.__file__.startswith(os.environ["PYTHONPATH"])
if sys.argv[1:]:
    subprocess.run([sys.executable, "-c", sys.argv[1]], check=True)
"""
    done = run(foreign, tmp_path, code, code)
    assert (done.returncode, done.stderr) == (0, "")
    mine, of_child = done.stdout.splitlines()
    assert mine == of_child
    assert len({Path(one).parent for one in mine.split()}) == 1


def test_where_there_is_no_place_at_all_it_is_compiled_without_one(foreign, tmp_path):
    code = (
        "import tempfile\ndef full(*a, **k): raise OSError(28, 'full')\ntempfile.mkdtemp = full\n"
        "from leakref._caches import njit\nimport os\n"
        "from leakref.fast import basins\nprint('NUMBA_CACHE_DIR' in os.environ, basins.POOL)"
    )
    done = run(foreign, tmp_path, code)
    assert (done.returncode, done.stdout, done.stderr) == (0, "False 8\n", "")


def test_places_of_their_own_are_left_alone(tmp_path):
    code = f"from leakref import _caches; import os; _caches.prepare(); print(*(os.environ.get(n) for n in {OWN}))"
    env = {name: value for name, value in os.environ.items() if name not in OWN} | {"HOME": str(tmp_path)}
    done = subprocess.run([sys.executable, "-c", code], env=env, capture_output=True, text=True, check=True)
    assert set(done.stdout.split()) == {"None"}
    assert list(tmp_path.iterdir()) == []  # and nothing is made before it is needed
