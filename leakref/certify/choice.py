"""Which checks are run, and their findings."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from fnmatch import fnmatchcase

from leakref._base import LeakrefError
from leakref.certify import checks
from leakref.certify.checks import conformance
from leakref.certify.checks.registry import FAMILIES, Case, Check
from leakref.certify.subject.frames import Subject
from leakref.certify.verdict import Finding

__all__ = ["chosen", "judged", "run_check"]


def chosen(patterns: Sequence[str] = (), *, profile: str = "full", golden: int = 1) -> list[tuple[Check, Case]]:
    """Checks and cases whose id, check or family matches one of the patterns (default: all) in a profile.

    Conformance is to golden set number `golden`. Raises LeakrefError for a pattern that matches nothing in any profile.
    """
    order, every = {family: n for n, family in enumerate(FAMILIES)}, checks.load()
    if golden != 1:
        every = {**every, **conformance.of_set(golden)}
    found = [(identifier, c, case) for c in sorted(every.values(), key=lambda c: order[c.family])
             for identifier, case in c.ids()]

    def matches(pattern: str, identifier: str, c: Check) -> bool:
        return pattern in (identifier, c.id, c.family) or any(
            fnmatchcase(name, pattern.replace("[", "[[]")) for name in (identifier, c.id))

    for pattern in patterns:
        if not any(matches(pattern, identifier, c) for identifier, c, _ in found):
            raise LeakrefError("checks", f"no check is called {pattern!r}",
                               f"families are {', '.join(FAMILIES)}; `leakref certify --list` prints all ids")
    return [(c, case) for identifier, c, case in found if (profile == "full" or case.quick)
            and (not patterns or any(matches(pattern, identifier, c) for pattern in patterns))]


def run_check(identifier: str, subject: Subject) -> Finding:
    """One check on one case by the id of its finding."""
    (c, case), = chosen([identifier])
    return c(subject, case)


def judged(pairs: Sequence[tuple[Check, Case]], subject: Subject,
           after_each: Callable[[Finding], object] = lambda finding: None) -> list[Finding]:
    """All findings. A fault of a check itself is not the implementation's: it is raised, with the id."""
    findings = []
    for c, case in pairs:
        try:
            finding = c(subject, case)
        except (LeakrefError, OSError, MemoryError):  # of the harness, such as a disk that is full
            raise
        except Exception as error:
            raise RuntimeError(f"check {c.id}[{case.id}] is broken: {type(error).__name__}: {error}") from error
        findings.append(finding)
        after_each(finding)
    return findings
