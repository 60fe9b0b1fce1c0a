"""The checks as tests of pytest, for a third party's own test file."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import cache
from pathlib import Path
from typing import Any

import pytest

from leakref._base import LeakrefError
from leakref.certify.certificate import Known, read_known
from leakref.certify.checks.registry import Case, Check
from leakref.certify.runner import select
from leakref.certify.subject.frames import Subject
from leakref.certify.subject.inprocess import InProcess
from leakref.certify.targets import load
from leakref.certify.verdict import Finding, Verdict
from leakref.plugin import MARK

__all__ = ["parametrize_with_checks", "settle"]


def settle(finding: Finding) -> None:
    """A finding as the outcome of a test: nothing, a skip where there was nothing to judge, or a failure."""
    if finding.verdict in (Verdict.UNSUPPORTED, Verdict.MISSING):
        pytest.skip(f"{finding.verdict}: {finding.message}")
    if finding.verdict is not Verdict.PASS:
        over = "" if finding.over is None else f" ({finding.over:.3g} times the tolerance)"
        pytest.fail(f"{finding.verdict} {finding.id}{over}\n{finding.message}\n{finding.repro}", pytrace=False)


def parametrize_with_checks(
    implementation: Any,
    *,
    profile: str = "quick",
    only: Sequence[str] = (),
    known: Mapping[str, Mapping[str, str]] | Path | None = None,
) -> Any:
    """Decorate a test that calls its argument `check`: it becomes one test for each finding of `leakref certify`.

        @parametrize_with_checks(extract)
        def test_with_leakref(check):
            check()

    `implementation` is an object or a function (guide protocol, section 5), or a TARGET in words; `only` are families,
    checks or patterns of ids. `known` are failures that are accepted for now, {id: {"reason": ..., "issue": ...}} or a
    TOML file of that: they must fail, and one that passes fails the test until it is taken off. Raises LeakrefError for
    an unknown check, profile or known failure.
    """
    if profile not in ("quick", "full"):
        raise LeakrefError("parametrize_with_checks", f"no profile is called {profile!r}", "choose quick or full")
    accepted = read_known(known) if isinstance(known, Path) else _known(known or {})
    ids = {identifier for check, _ in select() for identifier, _ in check.ids()}
    if unknown := sorted(set(accepted) - ids):
        raise LeakrefError(
            "parametrize_with_checks",
            f"the known failure {unknown[0]!r} is none of the {len(ids)} there are",
            "correct the id; `leakref certify --list` prints all",
        )

    @cache
    def subject() -> Subject:  # made when the first test runs, so that collecting is quick
        return InProcess(load(implementation) if isinstance(implementation, str) else _made(implementation))

    return pytest.mark.parametrize(
        "check",
        [
            pytest.param(
                _bound(check, case, subject),
                id=f"{check.id}[{case.id}]",
                marks=_marks(accepted.get(f"{check.id}[{case.id}]")),
            )
            for check, case in select(only, profile=profile)
        ],
    )


def _made(implementation: Any) -> Any:
    return implementation() if isinstance(implementation, type) else implementation


def _known(given: Mapping[str, Mapping[str, str]]) -> dict[str, Known]:
    for identifier, row in given.items():
        if set(row) != {"reason", "issue"} or not all(str(words).strip() for words in row.values()):
            raise LeakrefError(
                "parametrize_with_checks",
                f"the known failure {identifier!r} is given as {dict(row)!r}",
                "give it a reason and an issue in words",
            )
    return {identifier: Known(identifier, **row) for identifier, row in given.items()}


def _marks(known: Known | None) -> list[pytest.MarkDecorator]:
    marks = [getattr(pytest.mark, MARK)]
    if known is not None:
        marks.append(pytest.mark.xfail(strict=True, reason=f"{known.reason} ({known.issue})"))
    return marks


def _bound(check: Check, case: Case, subject: Callable[[], Subject]) -> Callable[[], None]:
    def run() -> None:
        settle(check(subject(), case))

    return run
