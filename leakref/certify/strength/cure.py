"""Diagnosis by cure: the smallest repair around a code under which what it failed comes right.

The code itself is run again, with each repair of the list around it, on the questions that it failed; a repair holds if
they pass then, and if none that passed fails with it. Nothing is assumed of the code's algorithm. Repairs of the answer
cost no call and are tried with each other repair; a factor, or an angle, is found from the answers, and holds only if
it is common to velocities that are not all along one line. Cheap questions come first, and only what they leave goes
on. The search handles no more samples than it is allowed.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from itertools import combinations

import numpy as np

from leakref._base import FloatArray
from leakref.certify.runner import select
from leakref.certify.strength.clues import EXACT_FOR_ALL, TRUE, Clue, digits, gather, velocities, worst
from leakref.certify.strength.fits import HOLDS, fits, spans
from leakref.certify.strength.repaired import NONE, Memory, Repair, Repaired, Spent, joined
from leakref.certify.strength.repairs import (
    GRAVITIES,
    IMAGES,
    INPUTS,
    KNOWN_GRAVITIES,
    OUTPUTS,
    PAIRS,
    gravity,
)
from leakref.certify.subject.frames import Subject
from leakref.certify.verdict import Finding, Verdict

__all__ = ["FAMILIES", "Cure", "Search", "cure"]

FAMILIES = ("signs", "recovery", "metamorphic", "currents", "shear", "scale", "depth", "leakage")
"""Of the questions that a repair must answer rightly."""
_REMAIN = 4  # one in so many questions may go on failing, and is told
_UNHARMED, _AT_MOST = 5, 12  # questions that passed and must pass, and those that are asked as far as it goes
_FIRST = 2  # questions that every repair is tried on, and from which a factor is found
_FEW = 12  # questions among which these are looked for
_ASKED = 8  # questions that must come right; the others are asked as far as the allowance goes
_EVIDENCE = 3  # questions that must have come right, unless the answer is known exactly
_SURE = 4.0  # digits from which nothing else need be tried
_SAME_AS_OUTPUTS = ("x-reversed", "y-reversed", "time-reversed", "cube-exchanged")
_ALIKE = 0.5  # digits within which repairs are as good as the best
_SLACK, _FLAT = 4.0, 2e-3  # a map is tried in earnest if it comes so near: times the tolerance, and in c0
_GRAVITY = (0.05, 2000.0)  # between which it is looked for

Step = Callable[[], object]


@dataclass(frozen=True)
class Cure:
    """A repair that holds: of the `asked` among so many `failed` questions it answers `cured` rightly, and none of the
    `unharmed` wrongly.

    `digits` are those to which answers come right that are known exactly; None if none are.
    """

    repair: Repair
    cured: int
    asked: int
    failed: int
    unharmed: int
    digits: float | None

    @property
    def counted(self) -> str:
        """On what it rests."""
        most = "" if self.cured == self.asked else "most of what failed: "
        again = "" if self.asked == self.failed else f", of the {self.failed} no more were asked again"
        harmed = f", none of {self.unharmed} others harmed" if self.unharmed else ""
        return f"{most}{self.cured} of {self.asked} failed questions{again}{harmed}"


@dataclass(eq=False)
class _Candidate:
    """A repair of what is handed over with one of the answer, and how it has done so far."""

    handed: Repair
    answered: Repair
    missed: int = 0
    cured: int = 0
    right: list[float] = field(default_factory=list)  # digits where the answer is known exactly
    near: list[float] = field(default_factory=list)  # errors over tolerance
    unharmed: int = 0

    @property
    def repair(self) -> Repair:
        return joined(self.handed, self.answered)

    def made(self, failed: int) -> Cure:
        known = round(_digits(self), 1) if self.right else None
        return Cure(self.repair, self.cured, self.cured + self.missed, failed, self.unharmed, known)


def cure(
    findings: Sequence[Finding],
    subject: Subject,
    *,
    seed: int,
    golden: int,
    allowance: float,
    after_each: Step = lambda: None,
) -> tuple[list[Cure], str]:
    """The repairs that hold, best first (several if they cannot be told apart), and why it ended early, if it did.

    `subject` is a session with the code whose `findings` these are. `allowance` are samples to be handled (`Memory`).
    """
    search = Search(findings, subject, seed, golden, allowance, after_each)
    try:
        return search.best(), search.remark
    except Spent as ended:
        return [], f"no repair was found before {ended}"


class Search:
    """One search over the failed questions of a code."""

    def __init__(
        self, findings: Sequence[Finding], subject: Subject, seed: int, golden: int, allowance: float, after_each: Step
    ) -> None:
        self.memory, self.after_each, self.remark = Memory(subject, allowance), after_each, ""
        known = {f"{c.id}[{case.id}]": (c, case) for c, case in select(seed=seed, golden=golden)}
        self.failed = _telling_first(
            clue
            for clue in gather(findings, seed, golden)
            if clue.check.family in FAMILIES and clue.check.stage == "extract" and clue.finding.verdict is Verdict.FAIL
        )
        passed = [
            Clue(*known[f.id], f)
            for f in findings
            if f.verdict is Verdict.PASS
            and f.family in FAMILIES
            and f.id in known
            and known[f.id][0].stage == "extract"
        ]
        cheap = sorted(passed, key=lambda clue: clue.check.id not in EXACT_FOR_ALL)
        self.passed = _alternating(cheap)[:_AT_MOST]
        self._found: dict[tuple[str, str, str], Finding] = {}
        self._turn = np.diag([1.0, -1.0 if subject.declaration.y == "down" else 1.0])  # to the frame of the checks

    def best(self) -> list[Cure]:
        """The smallest repairs that hold, with what more can be asked of them."""
        self._forget_what_passes()
        held: list[_Candidate] = []
        try:
            for found in self._searched() if self.failed else ():
                held = found
        except Spent:
            if not held:
                raise
        return [one.made(len(self.failed)) for one in held if self._stands(one)]

    def _searched(self) -> Iterator[list[_Candidate]]:
        """What holds, again as more is found: single repairs, those of the answer first; then two at once."""
        alone = self._ranked(self._tried([(NONE, OUTPUTS)], fits=True))
        yield alone
        if alone and alone[0].right and _digits(alone[0]) >= _SURE:
            yield self._ranked(alone + self._tried((one, ()) for one in INPUTS if one.id in _SAME_AS_OUTPUTS))
            return
        inputs = list(self._inputs())
        singles = self._ranked(alone + self._tried((one, ()) for one in inputs))
        yield singles
        if not singles:
            doubles = self._tried(((one, IMAGES) for one in inputs), fits=True)
            yield self._ranked(doubles or self._tried((one, ()) for one in PAIRS))

    def _forget_what_passes(self) -> None:
        """A question that passes when it is asked again says nothing: something else than it decides on the answer."""
        some = self.failed[: 2 * _FIRST]
        again = [clue for clue in some if self._finding(clue, NONE, NONE).verdict is Verdict.PASS]
        if again:
            self.remark = (
                f"{len(again)} of {len(some)} failed questions pass when asked again: answers are not repeated"
            )
            self.failed = [clue for clue in self.failed if clue not in again]

    def _inputs(self) -> Iterator[Repair]:
        """Those that can matter to a code of this declaration; any value of gravity only if it is seen to ignore it.

        The values that people write down are tried on all: a code may ignore gravity where it counts and use it where
        its search begins.
        """
        own = self.memory.inner.declaration
        exact = self.failed[0].check.id in EXACT_FOR_ALL  # else what is wrong shows where a cube is tapered
        some = sorted((*INPUTS, *GRAVITIES), key=lambda one: exact or "taper" not in one.id)
        for one in some:
            of_wavenumbers = one.id.startswith(("wavenumbers", "sorted", "one-by-one"))
            if not (of_wavenumbers and ("wavenumbers" in own.untold or own.band)) and not (
                one.square and "dy" in own.untold
            ):
                yield one
        if self._ignores_gravity() and (fitted := self._fitted_gravity()) is not None:
            yield fitted

    # ------------------------------------------------------------ trying

    def _finding(self, clue: Clue, handed: Repair, answered: Repair) -> Finding:
        key = clue.finding.id, handed.id + handed.words, answered.id + answered.words
        if key not in self._found:
            self.after_each()
            self._found[key] = clue.check(Repaired(self.memory, handed, answered), clue.case)
        return self._found[key]

    def _tried(self, tries: Iterable[tuple[Repair, Sequence[Repair]]], fits: bool = False) -> list[_Candidate]:
        """What answers the failed questions and harms none that passed, one repair of what is handed over after the
        other; with `fits` factors are looked for as well. What was found when the allowance ends is not lost.
        """
        found: list[_Candidate] = []
        try:
            for handed, some in tries:
                first = [_Candidate(handed, answered) for answered in (NONE, *some)]
                for clue in self.failed[:_FIRST]:
                    for one in first if fits or some else [one for one in first if not one.missed]:
                        self._count(one, clue)
                for fitted in self._fits(handed) if fits else ():
                    first.append(_Candidate(handed, fitted))
                    for clue in self.failed[:_FIRST]:
                        self._count(first[-1], clue)
                found += [one for one in first if not one.missed and self._goes_on(one, _FIRST, _ASKED)
                          and self._holds(one) and self._harmless(one) and not self._rivalled(one)]  # fmt: skip
        except Spent:
            if not found:
                raise
        return found

    def _count(self, one: _Candidate, clue: Clue) -> None:
        """How a candidate does on a question; what is not judged with it counts neither way."""
        finding = self._finding(clue, one.handed, NONE)
        if one.answered is not NONE and finding.verdict in (Verdict.PASS, Verdict.FAIL):
            if one.answered.matrix is not None and not _plausible(finding, clue, one.answered, self._turn):
                one.missed += 1
                return
            finding = self._finding(clue, one.handed, one.answered)
        if finding.verdict is Verdict.PASS:
            one.cured += 1
            one.near.append(finding.over or 0.0)
            found, should = velocities(finding.figures)
            if clue.check.id in EXACT_FOR_ALL and len(found):
                one.right.append(float(digits(found, should).min()))
        elif finding.verdict is not Verdict.UNSUPPORTED:
            one.missed += 1

    def _holds(self, one: _Candidate) -> bool:
        """Right as a right code is, and not just within what is allowed."""
        if one.right and (one.cured >= _EVIDENCE or one.repair.parts == 1):
            return _digits(one) >= (HOLDS if one.cured >= _EVIDENCE else _SURE)
        return one.cured >= _EVIDENCE and float(np.median(one.near)) <= 0.5

    def _rivalled(self, one: _Candidate) -> bool:
        """Whether another repair does as well that cannot if this one is the reason."""
        rival, some = one.handed.rival, self.failed[:_FIRST]
        return rival is not None and all(
            self._finding(clue, rival, one.answered).verdict is Verdict.PASS for clue in some
        )

    def _harmless(self, one: _Candidate) -> bool:
        """Whether all that passed, as far as it is asked again, passes with it."""
        one.unharmed = 0
        return all(self._unharmed(one, clue) for clue in self.passed[:_UNHARMED]) and one.cured + one.unharmed >= 3

    def _unharmed(self, one: _Candidate, clue: Clue) -> bool:
        verdict = self._finding(clue, one.handed, one.answered).verdict
        one.unharmed += verdict is Verdict.PASS
        return verdict in (Verdict.PASS, Verdict.UNSUPPORTED)

    # ------------------------------------------------------------ what is found from the answers

    def _fits(self, handed: Repair) -> list[Repair]:
        """A factor, one for each component or, if the code is handed what it was, an angle, that the answers have in
        common to `HOLDS` digits; in the frame of the code."""
        clues = [clue for clue in self.failed[: (1 + (handed is NONE)) * _FIRST] if clue.check.family in TRUE]
        pairs = [velocities(self._finding(clue, handed, NONE).figures) for clue in clues]
        found = np.concatenate([np.empty((0, 2)), *(p[0] for p in pairs)]) @ self._turn
        should = np.concatenate([np.empty((0, 2)), *(p[1] for p in pairs)]) @ self._turn
        return fits(found, should, angles=handed is NONE)

    def _ignores_gravity(self) -> bool:
        """Whether another gravity changes nothing."""
        if "gravity" in self.memory.inner.declaration.untold:
            return True
        other = Repair("gravity", "", lambda q: replace(q, gravity=1.37 * q.gravity))
        mine, changed = (velocities(self._finding(self.failed[0], one, NONE).figures)[0] for one in (NONE, other))
        return mine.shape == changed.shape != (0, 2) and bool(np.abs(mine - changed).max() < 1e-3)

    def _fitted_gravity(self) -> Repair | None:
        """What gravity it takes for granted, to three digits at least, from a question whose answer is known.

        Looked for within `_GRAVITY`, closer and closer, by how far answers are off; then along a straight line.
        """
        clue = next((clue for clue in self.failed if clue.check.id in EXACT_FOR_ALL), None)
        if clue is None:
            return None

        def off(log: float) -> FloatArray:
            found, should = velocities(self._finding(clue, gravity(float(np.exp(log)), 12), NONE).figures)
            return found - should if len(found) else np.full((1, 2), np.inf)

        low, high = np.log(_GRAVITY)
        for points in (25, 9, 9):
            grid = np.linspace(low, high, points)
            n = int(np.argmin([np.hypot(*off(g).T).mean() for g in grid]))
            low, high = grid[max(n - 1, 0)], grid[min(n + 1, points - 1)]
        for _ in range(2):  # the velocity is nearly linear in it
            one, two = off(low), off(high)
            if one.shape != two.shape or not np.isfinite([one, two]).all() or not (slope := two - one).any():
                return None
            best = low - (high - low) * float((one * slope).sum() / (slope**2).sum())
            if not np.log(_GRAVITY[0]) <= best <= np.log(_GRAVITY[1]):  # a line that is nearly level ends anywhere
                return None
            low, high = best - (high - low) / 20, best + (high - low) / 20
        value = float(np.exp(best))
        if any(abs(value / known - 1) < 2e-4 for known in KNOWN_GRAVITIES):
            return None
        return gravity(value)

    # ------------------------------------------------------------ which is best

    def _goes_on(self, one: _Candidate, start: int, end: int | None = None) -> bool:
        """Whether other failed questions come right as well, but for one in `_REMAIN`."""
        for clue in self.failed[start:end]:
            self._count(one, clue)
            near = one.missed and one.handed.id.startswith("wavenumbers")  # a neighbour's answer is often as good
            if near or one.missed * _REMAIN > len(self.failed[:end]):
                return False
        return one.missed * _REMAIN <= one.cured + one.missed

    def _stands(self, one: _Candidate) -> bool:
        """Whether it still holds with all that can be asked."""
        try:
            return self._goes_on(one, _ASKED) and all(self._unharmed(one, clue) for clue in self.passed[_UNHARMED:])
        except Spent:
            return one.missed * _REMAIN <= one.cured + one.missed

    def _ranked(self, found: list[_Candidate]) -> list[_Candidate]:
        """The smallest, of these those that cure most, of these those that come right to as many digits as the best.

        Beyond `_SURE` digits what is left is the code's own rounding, and tells nothing apart.
        """
        if not found:
            return []
        best = min(found, key=lambda one: (one.repair.parts, -one.cured, -_digits(one)))
        alike = [one for one in found if (one.repair.parts, one.cured) == (best.repair.parts, best.cured)]
        return [one for one in alike if _digits(one) >= min(_digits(best), _SURE) - _ALIKE]


def _telling_first(clues: Iterable[Clue]) -> list[Clue]:
    """From cheap to dear, but first two of which it is known what the answers should be, along different lines."""
    found = sorted(clues, key=lambda clue: clue.cost)
    truths = [velocities(clue.finding.figures)[1] if clue.check.family in TRUE else np.empty((0, 2)) for clue in found]
    for n, m in combinations([n for n, truth in enumerate(truths) if truth.any()][:_FEW], 2):
        if spans(np.concatenate([truths[n], truths[m]])):
            return [found[n], found[m], *(_alternating(clue for clue in found if clue not in (found[n], found[m])))]
    return _alternating(found)


def _alternating(clues: Iterable[Clue]) -> list[Clue]:
    """Each check once before any twice, in their order."""
    seen: dict[str, int] = {}
    keyed = []
    for n, clue in enumerate(clues):
        seen[clue.check.id] = seen.get(clue.check.id, -1) + 1
        keyed.append((seen[clue.check.id], n, clue))
    return [clue for _, _, clue in sorted(keyed, key=lambda row: row[:2])]


def _digits(one: _Candidate) -> float:
    """What nine answers in ten come right to; by their tolerances where none is known exactly."""
    if one.right:
        return worst(one.right)
    return -float(np.log10(max(np.median(one.near), 1e-3)))


def _plausible(finding: Finding, clue: Clue, answered: Repair, turn: FloatArray) -> bool:
    """Whether a linear map of these answers comes near what they should be: else it need not be tried in earnest."""
    found, should = velocities(finding.figures)
    if clue.check.family not in TRUE or not len(found) or not finding.over or answered.matrix is None:
        return True
    matrix = turn @ np.array(answered.matrix) @ turn
    allowed = float(np.hypot(*(found - should).T).max()) / finding.over
    return bool(np.hypot(*(found @ matrix.T - should).T).max() <= _SLACK * allowed + _FLAT)
