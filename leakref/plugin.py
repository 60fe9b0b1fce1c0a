"""The pytest plugin: judges the implementation that an option names, and shows nothing otherwise.

It imports nothing but pytest. What was asked for must be run: a session in which none of it was fails.

The properties are tests of their own, in `leakref.properties`, written for Hypothesis; the checks are those of `leakref
certify`, by `parametrize_with_checks`. Without an option, and without that decorator in a test file, nothing is judged.
"""

from __future__ import annotations

import os
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import pytest

__all__ = ["ASKED", "MARK", "Asked", "Judged", "pytest_addoption", "pytest_collection_finish", "pytest_configure"]

MARK = "leakref_judges"
"""The marker of what judges an implementation: properties and checks."""
ASKED = "leakref-asked"
"""The name under which `Asked` is registered."""


def pytest_addoption(parser: pytest.Parser) -> None:
    """The options: either of the first two is enough for something to be run."""
    group = parser.getgroup("leakref", "judge a code that measures currents from waves")
    group.addoption(
        "--leakref-implementation",
        metavar="TARGET",
        help="run the properties and the checks of leakref on package.module:object, reference, fault:ID or variant:ID",
    )
    group.addoption("--leakref-command", metavar="COMMAND", help="or on a program that speaks its protocol")
    group.addoption(
        "--leakref-profile",
        choices=("quick", "full"),
        help="quick (the default), or full: all cases of "
        "the checks, and twenty times as many examples of the properties",
    )
    group.addoption(
        "--leakref-seed",
        metavar="N",
        type=int,
        default=1,
        help="draw the seas, phases and currents of the checks from it; 1, the default: the published questions",
    )


def pytest_configure(config: pytest.Config) -> None:
    """Where something is asked for, add the properties to what is collected."""
    config.addinivalue_line("markers", f"{MARK}: judges an implementation (leakref)")
    if config.getoption("leakref_profile") == "full" or config.getoption("hypothesis_profile", None) == "thorough":
        os.environ["LEAKREF_PROPERTIES"] = "thorough"
    target, command = config.getoption("leakref_implementation"), config.getoption("leakref_command")
    if target is None and command is None:
        return
    if (target is None) == (command is None) or not (target or command or "").strip():
        raise pytest.UsageError(
            "leakref: give --leakref-implementation or --leakref-command, not both, and not an empty one"
        )
    spec = find_spec("leakref.properties")
    if spec is None or not spec.submodule_search_locations:
        raise pytest.UsageError("leakref: this installation has no leakref.properties")
    folder = Path(next(iter(spec.submodule_search_locations))).resolve()
    config.pluginmanager.register(Asked(config, folder, target, command), ASKED)
    if not any(_inside(argument, folder, config.invocation_params.dir) for argument in config.args):
        config.args.append(str(folder))


def _inside(argument: str, folder: Path, here: Path) -> bool:
    """Whether an argument names the properties, or some of them."""
    name = argument.partition("::")[0]
    path = (here / name).resolve()
    return f"{name}.".startswith("leakref.properties.") or folder in (path, *path.parents)


def pytest_collection_finish(session: pytest.Session) -> None:
    """Where a test file itself asks, with `parametrize_with_checks`, see to it that something is run."""
    plugins = session.config.pluginmanager
    if not plugins.has_plugin(ASKED) and any(item.get_closest_marker(MARK) for item in session.items):
        plugins.register(Judged(), ASKED)


class Judged:
    """Sees whether anything was judged: if not, the session fails."""

    def __init__(self, words: str = "the implementation") -> None:
        self.words, self.count, self.opened = words, 0, True

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        """Count what says something of the implementation: an expected failure does, a skipped test does not."""
        said = report.outcome != "skipped" or hasattr(report, "wasxfail")  # pytest calls an expected failure skipped
        if report.when == "call" and MARK in report.keywords and said:
            self.count += 1

    @pytest.hookimpl(trylast=True)
    def pytest_sessionfinish(self, session: pytest.Session) -> None:
        """A session that judged nothing has failed, unless tests were only to be listed."""
        if not self.count and not session.config.option.collectonly and session.exitstatus in (0, 5):
            session.exitstatus = pytest.ExitCode.TESTS_FAILED

    def pytest_terminal_summary(self, terminalreporter: Any) -> None:
        """Say that nothing was judged."""
        if self.opened and not self.count and not terminalreporter.config.option.collectonly:
            terminalreporter.write_line(
                f"leakref: nothing was judged of {self.words}: no property and no check of it was run to its end",
                red=True,
            )


class Asked(Judged):
    """What an option asked for."""

    def __init__(self, config: pytest.Config, folder: Path, target: str | None, command: str | None) -> None:
        super().__init__(str(target or command))
        self.folder, self.target, self.command, self.opened = folder, target, command, False
        self.profile: str = config.getoption("leakref_profile") or "quick"
        self.seed: int = config.getoption("leakref_seed")
        self.examined: Any = None
        """The implementation as the properties see it, once it was opened."""

    @pytest.hookimpl(tryfirst=True)
    def pytest_collection(self, session: pytest.Session) -> None:
        """Import or start it before anything else: one clear line if that cannot be."""
        try:
            opened = import_module("leakref.properties.opening").opened
            self.examined, close = opened(self.target, self.command, self.profile)
        except Exception as error:
            said = f"{type(error).__name__}: {error}"
            raise pytest.UsageError(f"leakref: {self.words} cannot be judged: {said}") from error
        self.opened = True
        session.config.add_cleanup(close)

    def pytest_collection_modifyitems(self, items: list[pytest.Item]) -> None:
        """Mark what is in the folder of the properties."""
        for item in items:
            if self.folder in item.path.resolve().parents:
                item.add_marker(MARK)
