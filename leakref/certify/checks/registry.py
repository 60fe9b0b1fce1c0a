"""The register of checks: what one is, and what it finds.

A check is a function of a subject and a case, registered by a decorator with its family, the label of what it rests on,
its tolerance in words and its cases. Called, it returns a finding: whatever the function returned or raised as a
verdict, with the error over the tolerance, so that all checks can be compared.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from typing import Any

from leakref.certify.checks import inputs
from leakref.certify.checks.draw import PUBLISHED
from leakref.certify.checks.identity import identify
from leakref.certify.subject.frames import Subject
from leakref.certify.verdict import Absent, Finding, Unanswered, Verdict

__all__ = ["CHECKS", "FAMILIES", "Case", "Check", "Outcome", "check"]

FAMILIES = {
    "signs": "Signs and axes: a current comes back in its own direction.",
    "recovery": "Exact recovery: what is known exactly is returned exactly.",
    "metamorphic": "Metamorphic relations: a changed input changes the answer in a known way.",
    "leakage": "Leakage at zero current: what is measured in still water.",
    "currents": "Strong and opposing currents, up to where omega0 + k.U is negative.",
    "shear": "Sheared currents: each wavenumber sees a depth-weighted current of its own.",
    "depth": "Finite depth and surface tension, for codes that are told of them.",
    "scale": "Scale invariance: the same sea, larger or smaller, has the same current in units of c0.",
    "synthesis": "Energy and statistics of a synthesised surface.",
    "sea": "Random seas from parameters: energy, spectrum, directions, motion and chance.",
    "conformance": "Conformance to the golden values, stage by stage.",
    "behaviour": "Behaviour: input untouched, deterministic, refuses what is not finite.",
}
"""Families of checks, in the order in which they are run."""


@dataclass(frozen=True)
class Case:
    """One input of a check. `id` is short and without spaces; `given` are the arguments that make the input."""

    id: str
    given: Mapping[str, Any] = field(default_factory=dict)
    quick: bool = True
    """Whether it is part of the quick profile."""
    seed: int = PUBLISHED
    """What its input is drawn from, in families that are (`draw.DRAWN`)."""
    water: tuple[str, ...] = ()
    """What of the water a code must be told for this to be asked of it."""
    method: str = ""
    """The method that a code must declare for this to be asked of it; empty where it is of the paper's, or of all."""


@dataclass(frozen=True)
class Outcome:
    """What a check function found: the error over the tolerance (`over` <= 1 passes), in words and in digits."""

    over: float
    message: str
    digits: float | None = None
    figures: Mapping[str, Any] = field(default_factory=dict)


CheckFunction = Callable[[Subject, Case], Outcome]


@dataclass(frozen=True)
class Check:
    """A check: `reason` is the mistake it is there for, `label` the paper's equation, `tolerance` its derivation."""

    id: str
    family: str
    reason: str
    label: str
    tolerance: str
    function: CheckFunction
    cases: tuple[Case, ...]
    stage: str = "extract"
    watched: bool = False
    """Whether only who watches the code at work can tell (`Subject.watched`)."""

    def ids(self) -> Iterator[tuple[str, Case]]:
        """Ids of its findings, `family.name[case]`, and their cases."""
        for case in self.cases:
            yield f"{self.id}[{case.id}]", case

    def __call__(self, subject: Subject, case: Case) -> Finding:
        """Run on one case: always a Finding, whatever the implementation does."""
        identifier = f"{self.id}[{case.id}]"
        drawn = f" --seed {case.seed}" * (case.seed != PUBLISHED)
        blank = Finding(
            identifier,
            self.family,
            Verdict.ERROR,
            "",
            label=self.label,
            repro=f"leakref certify TARGET --only '{identifier}'{drawn} --keep FOLDER",
        )
        if lacking := [name.replace("_", " ") for name in case.water if name not in subject.told]:
            return replace(blank, verdict=Verdict.UNSUPPORTED, message=f"is not told the {' and '.join(lacking)}")
        if self.watched and not subject.watched:
            return replace(blank, verdict=Verdict.UNSUPPORTED, message="only watching can tell, and nobody watched")
        if case.method not in ("", *subject.declaration.methods):
            return replace(blank, verdict=Verdict.UNSUPPORTED, message=f"does not offer the method {case.method}")
        identify(subject)
        subject.calls.clear()
        subject.gaps = ""
        try:
            with inputs.asked(subject, case.seed):
                outcome = self.function(subject, case)
        except Unanswered as nothing:
            said = Verdict.MISSING if isinstance(nothing, Absent) else nothing.verdict
            return replace(blank, verdict=said, message=nothing.message, calls=tuple(subject.calls))
        over = outcome.over
        passed = over <= 1.0  # NaN does not pass
        if passed and subject.gaps:
            return replace(blank, verdict=Verdict.MISSING, message=subject.gaps)
        return replace(
            blank,
            verdict=Verdict.PASS if passed else Verdict.FAIL,
            message=outcome.message + ("" if passed else _unit(subject, self.family)),
            digits=outcome.digits,
            over=float(over),
            figures=dict(outcome.figures),
            calls=() if passed else tuple(subject.calls),
        )


def _unit(subject: Subject, family: str) -> str:
    """For a code in SI, what the unit of velocities in the words of a finding is; empty where they are in no one."""
    asked = [call.asked for call in subject.calls if call.stage == "extract"]
    scales = {call["scale"] for call in asked}
    if subject.declaration.units != "si" or len(scales) != 1 or family in ("conformance", "behaviour"):
        return ""
    return f" (c0 is {subject.declaration.scales(scales.pop()).velocity:.3g} m/s here)"


CHECKS: dict[str, Check] = {}
"""Every check by id, `family.name`."""


def check(
    family: str, label: str, tolerance: str, cases: Iterable[Case], *, stage: str = "extract", watched: bool = False
) -> Callable[[CheckFunction], Check]:
    """Register `check_name(subject, case) -> Outcome` as the check `family.name`; its docstring is the reason.

    The function raises Unanswered where there is nothing to judge. `tolerance` says in whole sentences how much
    is allowed, in which unit, and where that comes from.
    """

    def register(function: CheckFunction) -> Check:
        identifier = f"{family}.{function.__name__.removeprefix('check_').replace('_', '-')}"
        reason = " ".join((function.__doc__ or "").split())
        if family not in FAMILIES or not reason or identifier in CHECKS:
            raise ValueError(f"{identifier} has no family, no reason, or a twin")
        CHECKS[identifier] = Check(identifier, family, reason, label, tolerance, function, tuple(cases), stage, watched)
        return CHECKS[identifier]

    return register
