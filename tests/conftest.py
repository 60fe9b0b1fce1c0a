"""The option --slow, and what several files share: seas, grids, spectra, a browser."""

from __future__ import annotations

import argparse
import contextlib
import os
import subprocess
import sys
import threading
import time
from collections import Counter
from collections.abc import Callable
from pathlib import Path

import numpy as np
import psutil
import pytest
from threadpoolctl import threadpool_limits
from tools import requires

from leakref import Components, Grid, SeaState, UniformCurrent, leakage

collect_ignore = ["example_project"]  # somebody else's, run by itself

# nx, ny, nt and dx, dy, dt all different; even and odd sizes in every position
RECTANGULAR = (
    Grid((12, 17, 22), (0.9, 0.6, 0.35)),
    Grid((15, 10, 9), (0.5, 1.1, 0.8)),
    Grid((9, 14, 16), (1.3, 0.7, 0.45)),
    Grid((16, 13, 11), (0.8, 0.95, 0.6)),
)


# files that take longest come first: none is begun when the others are through
LONGEST = ("test_checks", "test_protocol", "test_golden", "test_certify_command", "test_caches", "test_ensemble",
           "test_exits", "test_ending", "test_plugin", "test_strength", "test_variants", "test_diagnosis",
           "test_properties", "test_real_codes", "test_fast", "test_claims", "test_tracking", "test_guide")  # fmt: skip


def _slow(line: str) -> tuple[str, int]:
    name, _, share = line.partition(" one of ")
    return name, int(share or 0)


SLOW = dict(map(_slow, Path(__file__).with_name("slow.txt").read_text().splitlines()))
"""Tests that take long and have quicker siblings, by name, with their parameters or without: marked slow. Where the
line ends in `one of 4` one in four of the parameters is not.
"""
COMPILING = "LEAKREF_TESTS_COMPILING"
"""Number and start of the process that compiles for all: it takes half a minute, and each would do it by itself."""
BEGUN = time.monotonic()
NAMED: Counter[str] = Counter()
"""Those of them that were found, and how many of each."""


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.addoption("--within", type=float, help="minutes, after which no other test is begun: the rest is skipped")
    parser.addoption("--slow", action="store_true", help="also run the tests marked slow or night")
    parser.addoption("--part", type=_part, help="2/3: of the slow tests every third function from the second on")


@pytest.hookimpl(tryfirst=True)
def pytest_cmdline_main(config: pytest.Config) -> None:
    """All tests take some processes, file by file; tests that are named, benchmarks and debuggers stay in this one.

    One process more than there are cores: a quarter of the time is spent waiting for programs to end. The linear
    algebra has one thread in each, and in the programs that they start: more of them wait for each other most of the
    time, and bits would depend on how many there are.
    """
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    threadpool_limits(int(os.environ["OPENBLAS_NUM_THREADS"]))
    given = config.option
    named = given.file_or_dir or given.keyword or given.markexpr or given.benchmark_only or given.usepdb
    inside = "PYTEST_XDIST_WORKER" in os.environ  # one of them already, which is asked the same
    if not (named or inside) and getattr(given, "numprocesses", 0) is None:
        given.numprocesses, given.dist, given.loadscopereorder = min((os.cpu_count() or 1) + 1, 5), "loadfile", False
    if getattr(given, "numprocesses", 0) and not inside and not given.collectonly:
        compiling = psutil.Popen([sys.executable, Path(__file__).with_name("compiling.py")])
        threading.Thread(target=compiling.wait, daemon=True).start()
        os.environ[COMPILING] = f"{compiling.pid} {compiling.create_time()}"


@pytest.hookimpl(tryfirst=True)
def pytest_runtest_setup(item: pytest.Item) -> None:
    within = item.config.getoption("--within")
    if within is not None and time.monotonic() - BEGUN > 60 * within:
        pytest.skip("left for another time: --within")


def pytest_itemcollected(item: pytest.Item) -> None:
    """Those named one by one first; of the others of a name one in so many is not slow."""
    name = next((name for name in (item.nodeid, _function(item)) if name in SLOW), None)
    if name is not None:
        if not SLOW[name] or NAMED[name] % SLOW[name]:
            item.add_marker(pytest.mark.slow)
        NAMED[name] += 1


def pytest_collection_finish(session: pytest.Session) -> None:
    if "PYTEST_XDIST_WORKER" in os.environ and COMPILING in os.environ:
        number, since = os.environ[COMPILING].split()
        with contextlib.suppress(psutil.NoSuchProcess):  # it is through: what was waited for
            if (compiling := psutil.Process(int(number))).create_time() == float(since):  # and no later one
                compiling.wait()
    gone = sorted(SLOW.keys() - NAMED.keys())
    if gone and session.config.args_source == pytest.Config.ArgsSource.TESTPATHS:
        raise pytest.UsageError(f"tests/slow.txt names tests that are not there: {', '.join(gone)}")


def _function(item: pytest.Item) -> str:
    return item.nodeid.partition("[")[0]


def _part(text: str) -> tuple[int, int]:
    which, _, of = text.partition("/")
    if not (which.isdigit() and of.isdigit() and 1 <= int(which) <= int(of)):
        raise argparse.ArgumentTypeError(f"{text!r} should be a part and of how many, such as 2/3")
    return int(which), int(of)


def _keep_part(items: list[pytest.Item], which: int, of: int, deselected: Callable[..., object]) -> None:
    """Whole functions, so that what their parameters share is made once."""
    slow = [item for item in items if "slow" in item.keywords]
    kept = set(list(dict.fromkeys(map(_function, slow)))[which - 1 :: of])
    gone = {item for item in slow if _function(item) not in kept}
    deselected(items=list(gone))
    items[:] = [item for item in items if item not in gone]


@pytest.hookimpl(trylast=True)
def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    rank = {name: n for n, name in enumerate(LONGEST)}
    items.sort(key=lambda item: rank.get(item.path.stem, len(rank)))
    if config.getoption("--part"):
        _keep_part(items, *config.getoption("--part"), config.hook.pytest_deselected)
    if config.getoption("--slow"):  # where time runs out, it is not those whose siblings run every day
        items.sort(key=lambda item: SLOW.keys().isdisjoint({item.nodeid, _function(item)}))
    else:
        for item in items:
            if not {"slow", "night"}.isdisjoint(item.keywords):
                item.add_marker(pytest.mark.skip(reason="slow: run with --slow"))


def waves_off_bins(grid: Grid, off: float) -> Components:
    """Seven waves on bins of `grid`, moved by about `off` bins: another amount for each wave and axis."""
    rng = np.random.default_rng(7)
    bins = np.stack([rng.integers(-(n // 2) + 1, n // 2, 7) for n in grid.shape]).astype(float)
    bins += off * np.where(rng.random(bins.shape) < 0.5, -1, 1) * (1 if off == 0.5 else rng.uniform(0.5, 1, bins.shape))
    kx, ky, omega = bins * np.array(grid.bin_widths)[:, None]
    return Components(kx, ky, omega, rng.uniform(0.2, 1, 7), rng.uniform(0, 2 * np.pi, 7))


@pytest.fixture(scope="session")
def small_grid() -> Grid:
    """Some five wavelengths and ten periods, no two sizes or spacings alike, dkx and dky different."""
    return Grid((40, 44, 64), (0.8, 0.75, 0.9))


@pytest.fixture(scope="session")
def small_sea() -> Components:
    return SeaState(direction=70, spread=60, length=5, current=UniformCurrent((0.07, -0.04))).components(3)


@pytest.fixture(scope="session")
def tapered(small_grid, small_sea):
    return leakage.spectrum(small_sea, small_grid, "hann")


@pytest.fixture(scope="session")
def untapered(small_grid, small_sea):
    return leakage.spectrum(small_sea, small_grid, "box")


@pytest.fixture(scope="session")
def chromium(tmp_path_factory):
    """A function that runs Chromium on a file, as a new user: what it printed and what it logged."""
    program = requires("chromium")

    def run(path, *arguments):
        done = subprocess.run(
            [
                program,
                "--headless",
                "--no-sandbox",
                "--disable-gpu",
                "--no-first-run",
                "--disable-background-networking",
                "--disable-dev-shm-usage",
                "--hide-scrollbars",
                f"--user-data-dir={tmp_path_factory.mktemp('user')}",
                "--enable-logging=stderr",
                *arguments,
                path.as_uri(),
            ],
            capture_output=True,
            text=True,
            timeout=120,
        )
        assert done.returncode == 0, done.stderr
        return done.stdout, [line for line in done.stderr.splitlines() if "CONSOLE" in line]

    return run
