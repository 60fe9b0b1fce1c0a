"""What is wrong: which fault, applied to the reference, does what the implementation does.

Every fault of the list is a hypothesis. The checks that an implementation failed are run again on the reference with
the fault, and its answers are compared with those of the implementation, one by one. The fault that reproduces them
best is the diagnosis, if it does so to `ENOUGH` digits and clearly better than the reference without any fault. A code
of another algorithm has digits in common with them only in checks whose answer is the same for every algorithm: if all
that failed leads nowhere, those are compared alone. Then `_in_common` looks for a sign, an exchange of axes, a lost
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
from leakref.certify.checks.registry import Case, Check
from leakref.certify.runner import select
from leakref.certify.strength import faults
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
    declared: str
    """What the implementation offers and what it cannot be told, as JSON."""

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
    said = diagnose(certificate.wrong, certificate.declaration, deep=deep, after_each=after_each)
    words = said.words + _frame(said, certificate.declaration)
    if not said.hypotheses and certificate.grade == SOUND:
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
    of_frame = any(one.fault in _MAPS or one.fault == "turned" for one in said.hypotheses)
    return (
        f" (as leakref has it: axes xyt, y up, direction to; declared are {', '.join(other)})"
        if (other and of_frame)
        else ""
    )


def diagnose(
    findings: Sequence[Finding], declared: Mapping[str, Any], *, deep: bool = False, after_each: Step = lambda: None
) -> Diagnosis:
    """Explain the failures among `findings`; with `deep`, pairs of faults are tried as well. Nothing failed: no words.

    `declared` is what the implementation says of itself (`Declaration.record`): the reference with a fault is asked for
    no more than that, so that it is asked the same. Calls `after_each` for every fault tried.
    """
    declared_as = dumps({name: declared[name] for name in ("can", "fixed")}, sort_keys=True, default=list)
    clues = _clues(findings, declared_as)
    if not clues:
        return Diagnosis((), "")
    for where, evidence, hypotheses in _attempts(findings, deep):
        best, plain = _tried(_clues(evidence, declared_as), [(), *hypotheses], after_each)
        if _explains(best, plain):
            alike = [_hypothesis(names, digits) for names, digits in best if digits >= best[0][1] - _ALIKE]
            return Diagnosis(tuple(alike), where + _sentence(alike))
    rough = _in_common(clues)
    if rough is not None:
        digits = rough.digits or 0.0
        same = f"equals the reference, but {rough.words}, to {digits:.0f} digits"
        like = f"like the reference, but {rough.words} (another algorithm: to {digits:.1f} digits)"
        return Diagnosis((rough,), same if digits >= ENOUGH else like)
    return Diagnosis((), "unexplained: no fault of the list reproduces these answers")


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


def _clues(findings: Sequence[Finding], declared: str) -> list[_Clue]:
    """What failed, from cheap to dear, each family once before any twice."""
    by_id = {f"{c.id}[{case.id}]": (c, case) for c, case in select()}
    found = sorted(
        (_Clue(*by_id[f.id], f, declared) for f in findings if f.verdict in WRONG and f.id in by_id),
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
def _replayed(identifier: str, names: _Names, declared: str) -> tuple[Finding, tuple[Call, ...]]:
    """What a check finds of the reference with faults, offering no more than is declared, and the answers it had."""
    ((check, case),) = select([identifier])
    subject = InProcess(_implementation(names))
    own, theirs = subject.declaration, Declaration(**loads(declared))
    asked = {
        "methods": [m for m in theirs.methods if m in METHODS] or list(METHODS)[:1],
        "windows": list(theirs.windows) if theirs.tapers else [],
    }
    subject.declaration = replace(
        own,
        fixed=("dy",) if "dy" in theirs.fixed else (),  # the same pixels
        can={**own.can, "extract": {**own.can["extract"], **asked}},
    )
    finding = check(subject, case)
    return replace(finding, calls=()), tuple(subject.calls)


def _agreement(clue: _Clue, names: _Names) -> list[float]:
    """Digits to which a hypothesis gives the answers of a clue; beyond those of float64 for what is no number."""
    theirs = clue.finding
    finding, calls = _replayed(theirs.id, names, clue.declared)
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


# ---------------------------------------------------------------- what another algorithm has in common

_MAPS: dict[str, tuple[str, list[list[float]]]] = {
    "": ("", [[1, 0], [0, 1]]),
    "negated-current": ("negated", [[-1, 0], [0, -1]]),
    "flipped-x": ("with the x component of the wrong sign", [[-1, 0], [0, 1]]),
    "flipped-y": ("with the y component of the wrong sign", [[1, 0], [0, -1]]),
    "exchanged-axes": ("with x and y exchanged", [[0, 1], [1, 0]]),
    "quarter-turn": ("turned by a quarter turn", [[0, -1], [1, 0]]),
    "quarter-turn-back": ("turned back by a quarter turn", [[0, 1], [-1, 0]]),
    "exchanged-and-negated": ("with x and y exchanged, and negated", [[0, -1], [-1, 0]]),
    "lost-x": ("without an x component", [[0, 0], [0, 1]]),
    "lost-y": ("without a y component", [[1, 0], [0, 0]]),
}
_NEAR = 0.35  # part of the velocities that may be left over
_BETTER = 0.7  # how much less a turn by any angle must leave over than the best of the maps above
_FACTOR = 0.15  # that a factor may differ from one


def _in_common(clues: Sequence[_Clue]) -> Hypothesis | None:
    """A linear map between the velocities of the implementation and of the reference, if one is common to them."""
    mine, true, scales = _velocities(clues)
    if len(mine) < 2 or np.linalg.matrix_rank(true, tol=0.1 * np.abs(true).max()) < 2:
        return None
    maps = {name: (words, true @ np.array(matrix).T) for name, (words, matrix) in _MAPS.items()}
    rest, name = min((_left_over(mine, mapped), name) for name, (_, mapped) in maps.items())
    angle = float(np.angle(np.sum((mine @ [1, 1j]) * (true @ [1, -1j]))))
    c, s = np.cos(angle), np.sin(angle)
    turned = true @ np.array([[c, s], [-s, c]])
    if _left_over(mine, turned) < _BETTER * rest:
        rest, name = _left_over(mine, turned), "turned"
        maps[name] = f"turned by {np.degrees(angle):.0f} degrees", turned
    words, mapped = maps[name]
    factor = _factor(mine, mapped)
    each = {scale: _factor(mine[scales == scale], mapped[scales == scale]) for scale in np.unique(scales)}
    if max(each.values()) - min(each.values()) > _FACTOR * factor:
        rest = _left_over(mine, mapped * np.array([each[scale] for scale in scales])[:, None])
        said = ", ".join(f"{value:.2f} at {scale:g}" for scale, value in each.items())
        name, words = (
            "scale-dependent",
            (
                f"{words} and times a factor that depends on the scale of the sea: {said} "
                "times the usual peak wavenumber"
            ).removeprefix(" and "),
        )
    elif abs(factor - 1) >= min(_FACTOR, 1e-3 + 3 * rest):
        name, words = name or "factor", f"{words} and times {factor:.3g}".removeprefix(" and ")
    if rest > _NEAR or not name:
        return None
    return Hypothesis(name, words, round(float(-np.log10(max(rest, 10**-_FULL))), 1))


def _factor(mine: FloatArray, mapped: FloatArray) -> float:
    """By which `mapped` (m, 2) comes nearest to `mine` (m, 2), not below zero."""
    return max(float(np.sum(mapped * mine) / (np.sum(mapped**2) or 1.0)), 0.0)


def _left_over(mine: FloatArray, mapped: FloatArray) -> float:
    """Part of `mine` (m, 2) that no multiple of `mapped` (m, 2) explains."""
    rest = mine - _factor(mine, mapped) * mapped
    return float(np.sqrt(np.sum(rest**2) / (np.sum(mine**2) or 1.0)))


def _velocities(clues: Sequence[_Clue]) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Velocities of the implementation and of the reference for the same questions, (m, 2) each, and scales (m,)."""
    mine, true, scales = [np.empty((0, 2))], [np.empty((0, 2))], [np.empty(0)]
    for clue in clues:
        _, calls = _replayed(clue.finding.id, (), clue.declared)
        for a, b in zip(clue.finding.calls, calls, strict=False):
            if a.stage == b.stage == "extract" and a.answer.shape == b.answer.shape:
                use = np.isfinite(a.answer).all(axis=1) & (np.hypot(*b.answer.T) > _FLOOR)
                mine.append(a.answer[use])
                true.append(b.answer[use])
                scales.append(np.full(int(use.sum()), float(a.asked["scale"])))
    return np.concatenate(mine), np.concatenate(true), np.concatenate(scales)
