"""The checks as tests of pytest, for a third party's own test file.

Each finding of `leakref certify` becomes a test of its own, with the id of the finding, so that `-k`, `--lf` and
reports work as for any other test. The implementation is called in the process of the tests, without limits: for a code
that may hang, crash or leak, `leakref certify` is the safer way. Importing this module imports pytest.
"""

from __future__ import annotations

import os
import shlex
import sys
from collections.abc import Callable, Mapping, Sequence
from functools import cache
from pathlib import Path
from typing import Any

import pytest

from leakref._base import LeakrefError
from leakref.certify.checks.draw import PUBLISHED
from leakref.certify.checks.registry import Case, Check
from leakref.certify.runner import select
from leakref.certify.subject.frames import Subject
from leakref.certify.subject.inprocess import InProcess
from leakref.certify.targets import load
from leakref.certify.verdict import Finding, Known, Verdict, read_known
from leakref.plugin import MARK

__all__ = ["parametrize_with_checks", "settle"]


def settle(finding: Finding, target: str | None = None) -> None:
    """A finding as the outcome of a test: nothing, a skip where there was nothing to judge, or a failure.

    A failure ends with a line that can be pasted: of `leakref certify` where it is known what is to stand there for
    TARGET, else of pytest.

    `target` is how the implementation is named on the command line, already quoted for a shell; None if it has no such
    name. The outcome is raised as pytest wants it: `pytest.skip` for `unsupported` and `missing`, `pytest.fail` for the
    others. A pass returns None.
    """
    if finding.verdict in (Verdict.UNSUPPORTED, Verdict.MISSING):
        # nothing was judged, and a session in which nothing at all was judged fails (leakref.plugin.Judged)
        pytest.skip(f"{finding.verdict}: {finding.message}")  # not offered, or not answered: neither right nor wrong
    if finding.verdict is not Verdict.PASS:
        over = "" if finding.over is None else f" ({finding.over:.3g} times the tolerance)"
        again = finding.repro.replace("TARGET", target) if target else _this_test()
        pytest.fail(f"{finding.verdict} {finding.id}{over}\n{finding.message}\n{again}", pytrace=False)


def _this_test() -> str:
    """pytest names the running test in the environment."""
    return f"pytest {shlex.quote(os.environ.get('PYTEST_CURRENT_TEST', '').rpartition(' ')[0])}"


def parametrize_with_checks(
    implementation: Any,
    *,
    profile: str = "quick",
    only: Sequence[str] = (),
    known: Mapping[str, str | Mapping[str, str]] | Path | str | None = None,
    seed: int = PUBLISHED,
) -> Any:
    """Decorate a test that calls its argument `check`: it becomes one test for each finding of `leakref certify`.

        @parametrize_with_checks(extract)
        def test_with_leakref(check):
            check()

    `implementation` is an object or a function (guide protocol, section 5), or a TARGET in words; `only` are families,
    checks or patterns of ids. `known` are failures that are accepted for now, {id: reason}, {id: {"reason": ...,
    "issue": ...}} or the path of a TOML file of the latter: they must fail, and one that passes fails the test until it
    is taken off. `seed` draws seas, phases and currents; that of the published questions unless it is given. Raises
    LeakrefError for an unknown check, profile or known failure, and for what is no seed.

    An instance, or what a class gives when it is called, is made once, when the first test runs, and shared by all.
    Golden values are those of set 1.
    """
    if profile not in ("quick", "full"):
        raise LeakrefError("parametrize_with_checks", f"no profile is called {profile!r}", "choose quick or full")
    accepted = read_known(Path(known)) if isinstance(known, Path | str) else _known(known or {})
    ids = {identifier for check, _ in select() for identifier, _ in check.ids()}
    if unknown := sorted(set(accepted) - ids):
        raise LeakrefError(
            "parametrize_with_checks",
            f"the known failure {unknown[0]!r} is none of the {len(ids)} there are",
            "correct the id; `leakref certify --list` prints all",
        )

    name = implementation if isinstance(implementation, str) else _address(implementation)
    target = name and shlex.quote(name)

    @cache
    def subject() -> Subject:  # made when the first test runs, so that collecting is quick
        return InProcess(load(implementation) if isinstance(implementation, str) else _made(implementation))

    return pytest.mark.parametrize(
        "check",
        [
            pytest.param(
                _bound(check, case, subject, target),
                id=f"{check.id}[{case.id}]",
                marks=_marks(accepted.get(f"{check.id}[{case.id}]")),
            )
            for check, case in select(only, profile=profile, seed=seed)
        ],
    )


def _made(implementation: Any) -> Any:
    """An instance: of a class, made without arguments, else what was given."""
    return implementation() if isinstance(implementation, type) else implementation


def _address(implementation: Any) -> str | None:
    """What names an object on the command line; None for what no module holds under its own name."""
    module, name = getattr(implementation, "__module__", None), getattr(implementation, "__qualname__", "<none>")
    found: Any = sys.modules.get(str(module))
    for part in name.split("."):
        found = getattr(found, part, None)
    return f"{module}:{name}" if found is implementation and module != "__main__" else None


def _known(given: Any) -> dict[str, Known]:
    """Known failures from a mapping; the issue may be left out here, unlike in a file. Raises LeakrefError for other
    forms.
    """
    if not isinstance(given, Mapping):
        raise LeakrefError(
            "parametrize_with_checks",
            f"known = {given!r} is of the type {type(given).__name__}",
            'give {"id": "reason", ...}, or the path of a TOML file',
        )
    found = {}
    for identifier, said in given.items():
        row = {"reason": said, "issue": ""} if isinstance(said, str) else said
        words = list(row.values()) if isinstance(row, Mapping) and row.keys() == {"reason", "issue"} else [None]
        if not all(isinstance(w, str) for w in words) or not str(words[0]).strip():
            raise LeakrefError(
                "parametrize_with_checks",
                f"the known failure {identifier!r} is given as {said!r}",
                'give it a reason in words, or {"reason": ..., "issue": ...}',
            )
        found[str(identifier)] = Known(str(identifier), row["reason"], row["issue"])
    return found


def _marks(known: Known | None) -> list[pytest.MarkDecorator]:
    """The marker by which a session knows that something was judged, and a strict expected failure if it is known."""
    marks = [getattr(pytest.mark, MARK)]
    if known is not None:
        issue = f" ({known.issue})" if known.issue else ""  # strict: one that passes fails the test
        marks.append(pytest.mark.xfail(strict=True, reason=known.reason + issue))  # the reason is asked for in `known`
    return marks


def _bound(check: Check, case: Case, subject: Callable[[], Subject], target: str | None) -> Callable[[], None]:
    """What a test calls: the check on its case, as the outcome of the test."""

    def run() -> None:
        settle(check(subject(), case), target)

    return run
