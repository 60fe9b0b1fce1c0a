"""What is wrong: which fault, applied to the reference, does what the implementation does.

Every fault of the list is a hypothesis. The checks that an implementation failed are run again on the reference with
the fault, and its answers are compared with those of the implementation, one by one. The fault that reproduces them
best is the diagnosis, if it does so to `ENOUGH` digits and clearly better than the reference without any fault. A code
of another algorithm has digits in common with them only in checks whose answer is the same for every algorithm: if all
that failed leads nowhere, those are compared alone. Then `maps` looks for a sign, an exchange of axes, a lost
component, a turn or a factor between its velocities and those of the reference. What none of this finds is
unexplained.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from itertools import combinations
from json import dumps, loads
from typing import Any

import numpy as np
import numpy.typing as npt

from leakref._base import FloatArray, LeakrefError
from leakref.certify.certificate import SOUND, Certificate
from leakref.certify.checks.draw import PUBLISHED
from leakref.certify.checks.registry import Case, Check
from leakref.certify.runner import select
from leakref.certify.strength import faults
from leakref.certify.strength.maps import MAPS, common_map
from leakref.certify.subject.declaration import Declaration
from leakref.certify.subject.frames import Call
from leakref.certify.subject.inprocess import InProcess
from leakref.certify.verdict import WRONG, Finding, Verdict
from leakref.methods import METHODS

__all__ = ["ENOUGH", "Diagnosis", "Hypothesis", "departure", "diagnose", "explain"]

ENOUGH = 3.0
"""Digits of agreement from which a fault explains an answer: far more than two velocities share by chance."""
_CLEARLY = 1.0  # digits that it must be better than the reference without a fault
_ALIKE = 0.5  # digits within which several faults explain as well as the best
_FULL = 15.6  # digits of float64
_EVIDENCE = 8  # failed checks that are run again
_STAGES = ("window", "synthesize", "spectrum", "extract")
_TWICE = "behaviour.deterministic"
_FOR_ALL = ("recovery.pair", "signs.aligned", "currents.aligned", "leakage.aligned")
"""Checks of so few waves that other algorithms with the same mistake give the same answers."""
_FLOOR = 0.02  # in c0: slower velocities of the reference say nothing of a sign
_USUAL = 0.3  # in c0: digits of slower velocities are counted from here, since optimisers stop at so much of c0

Step = Callable[[], object]
_Names = tuple[str, ...]  # of the faults of a hypothesis


@dataclass(frozen=True)
class Hypothesis:
    """A fault, what it is in `words`, and to how many `digits` it gives the answers; None if none are numbers."""

    fault: str
    words: str
    digits: float | None

    def record(self) -> dict[str, Any]:
        """As in the JSON of `leakref certify`."""
        return {"fault": self.fault, "digits": self.digits, "words": self.words}


@dataclass(frozen=True)
class Diagnosis:
    """The hypotheses that explain the failures, best first (several if they cannot be told apart); `words` for it."""

    hypotheses: tuple[Hypothesis, ...]
    words: str


@dataclass(frozen=True, eq=False)
class _Clue:
    """A check that failed, and what came of it."""

    check: Check
    case: Case
    finding: Finding
    asked: str
    """What the implementation offers, what it cannot be told, and of which questions it was asked, as JSON."""

    @property
    def cost(self) -> float:
        """Of running it again: samples times wavenumbers."""
        return float(
            sum(
                np.prod(call.asked.get("shape", (1,))) * np.size(call.asked.get("wavenumbers", 1))
                for call in self.finding.calls
            )
        )


def departure(findings: Iterable[Finding]) -> str:
    """The first stage of the chain whose golden values are not reproduced; empty if there is none, or only one.

    `findings` are those of a certificate, of which only conformance is looked at: its checks go through the stages in
    the order window, synthesize, spectrum, extract.
    """
    compared = [f for f in findings if f.family == "conformance" and f.verdict is not Verdict.UNSUPPORTED]
    stage = {f.id: _stage(f) for f in compared}
    if len(set(stage.values())) < 2:
        return ""
    return next((s for s in _STAGES if any(stage[f.id] == s and f.verdict in WRONG for f in compared)), "")


def _stage(finding: Finding) -> str:
    return next(c.stage for c, case in select([finding.id.partition("[")[0]]))


def explain(certificate: Certificate, *, deep: bool = False, after_each: Step = lambda: None) -> Certificate:
    """The certificate with a diagnosis of what fell short and was not known, if anything did; see `diagnose`."""
    said = diagnose(
        certificate.wrong,
        certificate.declaration,
        seed=certificate.seed,
        golden=certificate.set_number,
        deep=deep,
        after_each=after_each,
    )
    words = said.words + _frame(said, certificate.declaration)
    if not said.hypotheses and certificate.wrong and certificate.grade == SOUND:
        farthest = max(certificate.wrong, key=lambda f: f.over or 0.0)
        words = (
            f"another algorithm: it differs from the golden values as no fault of the list does, most in {farthest.id}"
        )
    return replace(
        certificate,
        diagnosis=[one.record() for one in said.hypotheses],
        explanation=words,
        departs_at=departure(certificate.findings) if certificate.wrong else "",
    )


def _frame(said: Diagnosis, declared: Mapping[str, Any]) -> str:
    """Whose x and y are meant, where that is not the same."""
    other = [
        f"{name} {declared[name]}"
        for name, usual in (("axes", "xyt"), ("y", "up"), ("direction", "to"))
        if declared[name] != usual
    ]
    of_frame = any(one.fault in MAPS or one.fault == "turned" for one in said.hypotheses)
    return (
        f" (as leakref has it: axes xyt, y up, direction to; declared are {', '.join(other)})"
        if (other and of_frame)
        else ""
    )


def diagnose(
    findings: Sequence[Finding],
    declared: Mapping[str, Any],
    *,
    seed: int = PUBLISHED,
    golden: int = 1,
    deep: bool = False,
    after_each: Step = lambda: None,
) -> Diagnosis:
    """Explain the failures among `findings`; with `deep`, pairs of faults are tried as well. Nothing failed: no words.

    `declared` is what the implementation says of itself (`Declaration.record`): the reference with a fault is asked for
    no more than that, of the questions of the same `seed` and `golden` set, so that it is asked the same. Each of its
    methods is tried for a code that names none. Calls `after_each` for every fault tried.
    """
    ways = [_asked(declared, methods, seed, golden) for methods in _methods(declared)]
    clues = _clues(findings, ways[0])
    if not clues:
        return Diagnosis((), "")
    for where, evidence, given in _attempts(findings, deep):
        hypotheses = [(), *given]
        for way in ways:
            best, plain = _tried(_clues(evidence, way), hypotheses, after_each)
            if _explains(best, plain):
                alike = [_hypothesis(names, digits) for names, digits in best if digits >= best[0][1] - _ALIKE]
                return Diagnosis(tuple(alike), where + _sentence(alike))
    map_ = common_map(*_velocities(clues))
    if map_ is not None:
        rough = Hypothesis(*map_)
        digits = map_[2]
        same = f"equals the reference, but {rough.words}, to {digits:.0f} digits"
        like = f"like the reference, but {rough.words} (another algorithm: to {digits:.1f} digits)"
        return Diagnosis((rough,), same if digits >= ENOUGH else like)
    return Diagnosis((), "unexplained: no fault of the list reproduces these answers")


def _methods(declared: Mapping[str, Any]) -> list[list[str]]:
    """Methods of the reference to compare with: those that are declared, else one after the other."""
    named = declared["can"].get("extract", {}).get("methods", ())
    if named:
        return [[name for name in named if name in METHODS] or list(METHODS)[:1]]
    return [[name] for name in METHODS]


def _asked(declared: Mapping[str, Any], methods: Sequence[str], seed: int, golden: int) -> str:
    """How the reference is to be asked, as JSON, since results are kept by it."""
    given = {"can": declared["can"], "fixed": declared["fixed"], "methods": methods, "seed": seed, "golden": golden}
    return dumps(given, sort_keys=True, default=list)


def _attempts(findings: Sequence[Finding], deep: bool) -> Iterator[tuple[str, Sequence[Finding], Iterable[_Names]]]:
    """What to compare with which hypotheses, one after the other, and how to say where it was compared."""
    singles: list[_Names] = [(name,) for name in faults.FAULTS]
    yield "", findings, singles
    if deep:
        yield "", findings, (pair for pair in combinations(faults.FAULTS, 2) if _implementation(pair) is not None)
    if any(f.id.startswith(_TWICE) for f in findings):  # its numbers are no evidence
        yield "", [f for f in findings if f.family == "behaviour"], singles
    for_all = [f for f in findings if f.id.partition("[")[0] in _FOR_ALL]
    yield "where every algorithm must agree it ", for_all, singles


def _hypothesis(names: _Names, digits: float) -> Hypothesis:
    return Hypothesis("+".join(names), " and ".join(faults.FAULTS[name].words for name in names), _shown(digits))


def _clues(findings: Sequence[Finding], asked: str) -> list[_Clue]:
    """What failed, from cheap to dear, each family once before any twice."""
    given = loads(asked)
    by_id = {f"{c.id}[{case.id}]": (c, case) for c, case in select(seed=given["seed"], golden=given["golden"])}
    found = sorted(
        (_Clue(*by_id[f.id], f, asked) for f in findings if f.verdict in WRONG and f.id in by_id),
        key=lambda clue: clue.cost,
    )
    rank: dict[str, int] = {}
    order = []
    for clue in found:
        rank[clue.check.family] = rank.get(clue.check.family, -1) + 1
        order.append((rank[clue.check.family], clue.cost))
    return [found[n] for n in sorted(range(len(found)), key=order.__getitem__)][:_EVIDENCE]


Scored = list[tuple[_Names, float]]


def _tried(clues: Sequence[_Clue], hypotheses: Iterable[_Names], after_each: Step) -> tuple[Scored, float]:
    """Hypotheses by digits, best first, and the digits of the empty one, the reference itself.

    One after the other the clues are compared; hypotheses that are far behind are not followed further.
    """
    digits: dict[_Names, list[float]] = {names: [] for names in hypotheses}
    for clue in clues:
        for names, seen in digits.items():
            seen += _agreement(clue, names)
            after_each()
        top = max(_worst(seen) for names, seen in digits.items() if names)
        digits = {names: seen for names, seen in digits.items() if not names or _worst(seen) >= top - 2}
    plain = _worst(digits.pop(()))
    return sorted(((names, _worst(seen)) for names, seen in digits.items()), key=lambda row: -row[1]), plain


def _worst(digits: Sequence[float]) -> float:
    """What nine answers in ten agree to: one shell in another basin does not refute a hypothesis."""
    return float(np.quantile(digits, 0.1, method="lower")) if digits else 0.0


def _explains(best: Scored, plain: float) -> bool:
    return bool(best) and best[0][1] >= max(ENOUGH, plain + _CLEARLY)


def _shown(digits: float) -> float | None:
    return None if digits > _FULL else round(digits, 1)


def _sentence(alike: Sequence[Hypothesis]) -> str:
    first = alike[0]
    to = "in what it does wrong" if first.digits is None else f"to {first.digits:.0f} digits"
    same = f" (or {', '.join(one.fault for one in alike[1:])}: the same here)" if len(alike) > 1 else ""
    return f"equals the reference with this fault, {to}: {first.words}{same}"


# ---------------------------------------------------------------- answers of a hypothesis, and how near they come


@lru_cache(maxsize=4096)
def _implementation(names: _Names) -> Any:
    """The reference with faults; None where they cannot be had together."""
    from leakref.altered import altered
    from leakref.chain import reference

    if len(names) < 2:
        return faults.implementation(names[0]) if names else reference
    pair = [faults.FAULTS[name] for name in names]
    if any(fault.instead is not None or not fault.changes for fault in pair):
        return None
    try:
        return altered(tuple(change for fault in pair for change in fault.changes)).chain.reference
    except LeakrefError:
        return None  # both change one line


@lru_cache(maxsize=4096)
def _replayed(identifier: str, names: _Names, asked: str) -> tuple[Finding, tuple[Call, ...]]:
    """What a check finds of the reference with faults, offering no more than is declared, and the answers it had."""
    given = loads(asked)
    ((check, case),) = select([identifier], seed=given["seed"], golden=given["golden"])
    subject = InProcess(_implementation(names))
    own, theirs = subject.declaration, Declaration(can=given["can"])
    offered = {"methods": given["methods"], "windows": list(theirs.windows) if theirs.tapers else []}
    subject.declaration = replace(
        own,
        fixed=("dy",) if "dy" in given["fixed"] else (),  # the same pixels
        can={**own.can, "extract": {**own.can["extract"], **offered}},
    )
    finding = check(subject, case)
    return replace(finding, calls=()), tuple(subject.calls)


def _agreement(clue: _Clue, names: _Names) -> list[float]:
    """Digits to which a hypothesis gives the answers of a clue; beyond those of float64 for what is no number."""
    theirs = clue.finding
    finding, calls = _replayed(theirs.id, names, clue.asked)
    in_words = theirs.family == "behaviour" or not theirs.calls
    if (names or in_words) and finding.verdict is not theirs.verdict:  # the reference is compared by its numbers alone
        return [0.0]
    digits = [digit for mine, other in zip(theirs.calls, calls, strict=False) for digit in _digits(mine, other)]
    if in_words:  # and more alike with the same numbers
        same = _told(finding) <= _told(theirs)  # which may tell of the checks before as well
        return [_FULL + 1 + _worst(digits) / _FULL if same else 0.0]
    return digits if len(calls) == len(theirs.calls) else [0.0]


def _told(finding: Finding) -> set[str]:
    """The parts of its message, without numbers."""
    return set(re.sub(r"[-+]?[0-9][0-9.e+-]*", "#", finding.message).split("; "))


def _digits(mine: Call, other: Call) -> list[float]:
    """Of two answers to one question: of velocities one number a wavenumber, else one in all."""
    a, b = mine.answer, other.answer
    if mine.stage != other.stage or a.shape != b.shape:
        return [0.0]
    if mine.stage == "spectrum":
        b = _fitted(a, b)
    with np.errstate(invalid="ignore", divide="ignore"):
        scale = np.nanmax(np.abs(a), initial=_USUAL if mine.stage == "extract" else 0.0) or 1.0
        off = np.abs(a - b).reshape(len(a), -1).max(axis=1) / scale
    gone = np.isnan(a).reshape(len(a), -1).any(axis=1)
    off = np.where(gone & np.isnan(b).reshape(len(b), -1).any(axis=1), 0.0, np.where(np.isnan(off), 1.0, off))
    each = np.clip(-np.log10(np.maximum(off, 10**-_FULL)), 0.0, _FULL)
    return [float(d) for d in each] if mine.stage == "extract" else [float(each.min())]


def _fitted(a: npt.NDArray[Any], b: npt.NDArray[Any]) -> npt.NDArray[Any]:
    """b, made like a: magnitudes if a has no phases, times the best common factor."""
    if not np.iscomplexobj(a):
        b = np.abs(b)
    power = np.vdot(b, b).real
    return b * (np.vdot(b, a) / power) if power else b


def _velocities(clues: Sequence[_Clue]) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Velocities of the implementation and of the reference for the same questions, (m, 2) each, and scales (m,)."""
    mine, true, scales = [np.empty((0, 2))], [np.empty((0, 2))], [np.empty(0)]
    for clue in clues:
        _, calls = _replayed(clue.finding.id, (), clue.asked)
        for a, b in zip(clue.finding.calls, calls, strict=False):
            if a.stage == b.stage == "extract" and a.answer.shape == b.answer.shape:
                use = np.isfinite(a.answer).all(axis=1) & (np.hypot(*b.answer.T) > _FLOOR)
                mine.append(a.answer[use])
                true.append(b.answer[use])
                scales.append(np.full(int(use.sum()), float(a.asked["scale"])))
    return np.concatenate(mine), np.concatenate(true), np.concatenate(scales)
