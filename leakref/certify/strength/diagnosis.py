"""What is wrong, in two ways side by side: which fault the reference needs, and which repair the code does.

Every fault of the list is a hypothesis: the checks that an implementation failed are run again on the reference with
the fault (`replays`). The fault that reproduces its answers best explains them, if it does so to `ENOUGH` digits and
clearly better than the reference without any fault. A code of another algorithm has digits in common with them only in
checks whose answer is the same for every algorithm: if all that failed leads nowhere, those are compared alone. Then
`maps` looks for a sign, an exchange of axes, a lost component, a turn or a factor between its velocities and those of
the reference. For a code of any make `cure` looks for the smallest repair under which what failed comes right, with the
code itself, and `symptoms` says what stands in the findings. What none of these finds is unexplained, and told to be.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import AbstractContextManager, nullcontext
from dataclasses import dataclass, replace
from itertools import combinations
from typing import Any

from leakref._base import LeakrefError
from leakref.certify.certificate import REJECTED, SOUND, Certificate
from leakref.certify.checks.draw import PUBLISHED
from leakref.certify.runner import select
from leakref.certify.strength import cure, faults, regime, replays
from leakref.certify.strength.clues import EXACT_FOR_ALL, FULL, TWICE, Hypothesis, gather
from leakref.certify.strength.maps import MAPS, common_map
from leakref.certify.strength.maxima import other_maxima
from leakref.certify.strength.replays import ENOUGH, Names, Scored
from leakref.certify.strength.symptoms import symptoms
from leakref.certify.subject.declaration import GIVEN
from leakref.certify.subject.frames import OWN, Subject
from leakref.certify.verdict import WRONG, Finding, Verdict
from leakref.golden.sets import NEWEST
from leakref.methods import DEFAULT

__all__ = ["ENOUGH", "Diagnosis", "Hypothesis", "departure", "diagnose", "explain"]

_CLEARLY = 1.0  # digits that it must be better than the reference without a fault
_ALIKE = 0.5  # digits within which several faults explain as well as the best
_EVIDENCE = 8  # failed checks that are run again
_SAID = 5  # explanations that are the same here, named before the rest is counted
_STAGES = ("window", "synthesize", "spectrum", "extract")
_SESSIONS = 2.0  # judging takes as many at once, the search for a cure one
_LEAST = 2e7
_FEW = 2  # checks that failed: so few are told with what they are there for
_COINCIDENCE = 6.0  # digits below which a fault that gives one answer again and again explains nothing by it
_LOOK = {
    "signs": "D2", "recovery": "D3, D9", "metamorphic": "D1, D5", "leakage": "D1, D16", "currents": "D2, D6",
    "shear": "D9", "depth": "D26", "scale": "D4", "synthesis": "D15", "conformance": "D1",
}  # fmt: skip
"""Decisions that codes take otherwise where a family of checks fails."""
_STORIES = ("currents", "scale", "recovery", "signs")
"""Families whose failures are told of in the guide real-codes."""

Step = Callable[[], object]


@dataclass(frozen=True)
class Diagnosis:
    """The hypotheses that explain the failures, best first (several if they cannot be told apart); `words` for it."""

    hypotheses: tuple[Hypothesis, ...]
    words: str


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


def explain(
    certificate: Certificate,
    session: Subject | AbstractContextManager[Subject] | None = None,
    *,
    deep: bool = False,
    after_each: Step = lambda: None,
) -> Certificate:
    """The certificate with a diagnosis of what fell short and was not known, if anything did; see `diagnose`.

    With a `session`, another one with the same code or a context that opens one, a rejected code is run again with
    repairs around it as well (`cure`), for as many samples as its judging took. A session that breaks ends that, and
    nothing else. Calls `after_each` for every fault and every repair tried.
    """
    given = {"seed": certificate.seed, "golden": certificate.set_number}
    wrong, declared = certificate.wrong, certificate.declaration
    of_chain = [f for f in wrong if f.family != "sea"]  # of random seas the reference makes others, which tell nothing
    said = diagnose(of_chain, declared, **given, alike=certificate.alike, deep=deep, after_each=after_each)
    repairs, remark = _cured(certificate, session, after_each) if session is not None else ([], "")
    seen = symptoms(certificate.findings, declared) + other_maxima(of_chain, declared, certificate.methods, **given)
    exact = [one for one in said.hypotheses if one.digits is None or one.digits >= ENOUGH]
    rough = [one for one in said.hypotheses if one not in exact and not repairs]
    if exact or repairs:  # which say why it is where it is
        seen = [one for one in seen if one.fault != "stops-early"]
    found = [*exact, *(hypothesis for hypothesis, _ in repairs), *rough, *seen]
    parts = [said.words + _frame(said, declared)] if exact or rough else []
    parts += [_repair_in_words(repairs)] if repairs else []
    parts += [one.words for one in seen]
    covered = {one.fault for one in seen}
    if not (exact or repairs or rough) and any(f.id.partition("[")[0] not in covered for f in wrong):
        parts.append(_unexplained(certificate, bool(seen)))
    parts += [remark] if remark and wrong else []
    return replace(
        certificate,
        diagnosis=[one.record() for one in found],
        explanation="; ".join(parts),
        departs_at=departure(certificate.findings) if wrong else "",
    )


def _cured(
    certificate: Certificate, session: Subject | AbstractContextManager[Subject], after_each: Step
) -> tuple[list[tuple[Hypothesis, cure.Cure]], str]:
    """Repairs that hold, and what is to be said of the search.

    Only a rejected code is looked at, since another algorithm needs no cure, and only where it measures velocities. A
    session that cannot be opened, or breaks, is said, and the certificate stands as it is.
    """
    if certificate.grade != REJECTED or "extract" not in certificate.declaration["can"]:
        return [], ""
    try:
        with session if isinstance(session, AbstractContextManager) else nullcontext(session) as subject:
            subject.reproduces = next(iter(certificate.methods), OWN)
            subject.alike = frozenset(certificate.alike)
            found, remark = cure.cure(
                certificate.findings,
                subject,
                seed=certificate.seed,
                golden=certificate.set_number,
                allowance=_allowance(certificate),
                after_each=after_each,
            )
            remark = "; ".join(filter(None, (_regime(certificate, subject), remark)))
    except (LeakrefError, OSError) as broken:
        return [], f"no repair was looked for, since no second session could be held: {broken}"
    return [(Hypothesis(one.repair.id, one.repair.words, one.digits, "repair"), one) for one in found], remark


def _regime(certificate: Certificate, subject: Subject) -> str:
    """The waves in which a code is right that is wrong in others, in words; empty if there are none, or no question
    about other waves was wrong.
    """
    if not any(f.id.startswith("scale.peak") and "untapered" not in f.id for f in certificate.wrong):
        return ""
    found = regime.right_between(subject)
    if found is None:
        return ""
    short, long = found
    return (
        f"in waves of {short:.2g} to {long:.2g} m its answers are within the resolution, and not in all others that it "
        f"was shown: if it is made for these, declare them, or ask with --waves {short:.2g}m:{long:.2g}m "
        "(`leakref guide regimes`)"
    )


def _allowance(certificate: Certificate) -> float:
    """Samples that one session handled in the judging; where nobody counted, as many for each as what failed took. Of a
    few questions it is a fifth of what a quick run takes.
    """
    failed = [clue.cost for clue in gather(certificate.wrong, certificate.seed, certificate.set_number)]
    handled = certificate.handled or sum(failed) / max(1, len(failed)) * len(certificate.judged)
    return max(handled / _SESSIONS, _LEAST)


def _repair_in_words(repairs: Sequence[tuple[Hypothesis, cure.Cure]]) -> str:
    first = repairs[0][1]
    others = [one.repair.words for _, one in repairs[1:]]
    to = "" if first.digits is None else f", to {first.digits:.0f} digits"
    same = f" (or if {_listed(others, ', or if ')}: the same here)" if others else ""
    return f"comes right if {first.repair.words}{same}{to}: {first.counted}"


def _listed(said: Sequence[str], between: str = ", ") -> str:
    """Some of many."""
    more = len(said) - _SAID
    return between.join(said[:_SAID]) + (f" and {more} more" if more > 0 else "")


def _unexplained(certificate: Certificate, besides: bool) -> str:
    """What is said where nothing explains it, and where to look.

    Of a sound code that it is another algorithm; of one or two failures that they are too little to go on, and what to
    run; of all others the first check that failed, the decisions of its family, and the guide where it tells of such.
    """
    wrong = certificate.wrong
    farthest = max(wrong, key=lambda f: f.over or 0.0)
    if certificate.grade == SOUND:
        return (
            f"another algorithm: it differs from the golden values as no fault of the list does, most in {farthest.id}"
        )
    words = "the rest is unexplained" if besides else "unexplained: no fault of the list reproduces these answers"
    if len(wrong) <= 2:
        more = "without --only" if certificate.only else "--profile full" if certificate.profile != "full" else ""
        words += f"; {len(wrong)} failed question{'s' * (len(wrong) > 1)} is too little to go on"
        words += f": run it {more}" if more else f": run it with another seed, and see `leakref explain {farthest.id}`"
    apart = dict.fromkeys(f.id.partition("[")[0] for f in wrong if f.family != "conformance")
    if 1 <= len(apart) <= _FEW and len(wrong) > 2:
        reasons = {check.id: check.reason for check, _ in select(list(apart))}
        words += "; beside golden values it fails no more than " + ", and ".join(
            f"{name} ({reasons[name].rstrip('.')})" for name in apart
        )
    families = dict.fromkeys(f.family for f in wrong)
    first = next(iter(families), "")
    look = [f"`leakref explain {next(f.id for f in wrong).partition('[')[0]}`"]
    look += [f"decisions {_LOOK[first]} (`leakref explain {_LOOK[first].partition(',')[0]}`)"] if first in _LOOK else []
    look += ["`leakref guide real-codes`"] if any(family in _STORIES for family in families) else []
    return f"{words}; where to look first: {', '.join(look)}"


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
    golden: int = NEWEST,
    alike: Sequence[str] | None = None,
    deep: bool = False,
    after_each: Step = lambda: None,
) -> Diagnosis:
    """Explain the failures among `findings`; with `deep`, pairs of faults are tried as well. Nothing failed: no words.

    `declared` is what the implementation says of itself (`Declaration.record`): the reference with a fault is asked for
    no more than that, of the questions of the same `seed` and `golden` set, so that it is asked the same. Each of its
    methods is tried for a code that names none; `alike` are those as which it answers a broad sea, if that is known.
    Calls `after_each` for every fault tried.
    """
    ways = [replays.question(declared, methods, seed, golden, alike) for methods in replays.methods(declared)]
    clues = gather(findings, seed, golden, _EVIDENCE)
    if not clues:
        return Diagnosis((), "")
    for where, evidence, given in _attempts(findings, declared, deep):
        hypotheses = [(), *given]
        for way in ways:
            best, plain = replays.tried(gather(evidence, seed, golden, _EVIDENCE), hypotheses, way, after_each)
            best = [row for row in best if row[1] >= _COINCIDENCE or not _one_answer(evidence)]
            if _explains(best, plain):
                equal = [_hypothesis(names, digits) for names, digits in best if digits >= best[0][1] - _ALIKE]
                return Diagnosis(tuple(equal), where + _sentence(equal))
    map_ = common_map(*replays.pairs(clues, ways[0]))
    if map_ is not None:
        rough = Hypothesis(*map_)
        digits = map_[2]
        same = f"equals the reference, but {rough.words}, to {digits:.0f} digits"
        like = f"like the reference, but {rough.words} (another algorithm: to {digits:.1f} digits)"
        return Diagnosis((rough,), same if digits >= ENOUGH else like)
    return Diagnosis((), "unexplained: no fault of the list reproduces these answers")


def _attempts(
    findings: Sequence[Finding], declared: Mapping[str, Any], deep: bool
) -> Iterator[tuple[str, Sequence[Finding], Iterable[Names]]]:
    """What to compare with which hypotheses, one after the other, and how to say where it was compared."""
    told = GIVEN in (declared.get("water") or {}).values()  # else no depth is handed over that could be mistaken
    named = set(declared["can"].get("extract", {}).get("methods", ()))
    tried = [
        name
        for name, fault in faults.FAULTS.items()
        if fault.family != "sea" and (fault.methods == DEFAULT or named & {*fault.methods})
    ]
    singles: list[Names] = [(name,) for name in tried if told or faults.FAULTS[name].stage != "water"]
    yield "", findings, singles
    if deep:
        yield (
            "",
            findings,
            (pair for pair in combinations(tried, 2) if replays.implementation(pair) is not None),
        )
    if any(f.id.startswith(TWICE) for f in findings):  # its numbers are no evidence
        yield "", [f for f in findings if f.family == "behaviour"], singles
    for_all = [f for f in findings if f.id.partition("[")[0] in EXACT_FOR_ALL]
    yield "where every algorithm must agree it ", for_all, singles


def _hypothesis(names: Names, digits: float) -> Hypothesis:
    return Hypothesis("+".join(names), " and ".join(faults.FAULTS[name].words for name in names), _shown(digits))


def _one_answer(findings: Sequence[Finding]) -> bool:
    """Whether most velocities are one and the same, as those of any code are that gives up where it began."""
    rows = [tuple(row) for f in findings for call in f.calls if call.stage == "extract" for row in call.answer.tolist()]
    return len(rows) >= _EVIDENCE and max(Counter(rows).values()) > len(rows) / 2


def _explains(best: Scored, plain: float) -> bool:
    return bool(best) and best[0][1] >= max(ENOUGH, plain + _CLEARLY)


def _shown(digits: float) -> float | None:
    return None if digits > FULL else round(digits, 1)


def _sentence(alike: Sequence[Hypothesis]) -> str:
    first = alike[0]
    to = "in what it does wrong" if first.digits is None else f"to {first.digits:.0f} digits"
    same = f" (or {_listed([one.fault for one in alike[1:]])}: the same here)" if len(alike) > 1 else ""
    return f"equals the reference with this fault, {to}: {first.words}{same}"
