"""What stands in the findings themselves, whatever the algorithm: said as it was seen, and no further.

A behaviour that failed is its own explanation. Velocities that stick at one value, lie on a lattice of rounding or are
always the same, energies in a constant ratio, and answers that are right at one scale only are told with their numbers.
`other_maxima` looks whether velocities are maxima of the score, if not those that a search from zero finds.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np

from leakref._base import FloatArray
from leakref.certify.strength.clues import TRUE, Hypothesis, digits, parts, velocities
from leakref.certify.subject.declaration import Declaration
from leakref.certify.subject.frames import Subject
from leakref.certify.verdict import WRONG, Finding, Verdict

__all__ = ["AWAY", "said", "symptoms"]

_IN_STEPS = ("signs.aligned", "recovery.ring", "recovery.shells", "recovery.half-width")
"""Checks whose currents are whole multiples of a step themselves."""
_SAME = 1e-6  # relative: velocities that are one
_OFTEN, _MOSTLY = 0.2, 0.6  # parts of the answers
_AT_LEAST = 4
_ENERGIES = {2 / 3: "2/3", 0.5: "1/2", 1 / 3: "1/3", 0.25: "1/4", 2.0: "2", 4.0: "4", 1.5: "3/2"}
AWAY = 0.05
"""In c0: a velocity so far from the reference's is at another maximum, if at any."""


def symptoms(findings: Sequence[Finding], declared: Mapping[str, Any]) -> list[Hypothesis]:
    """What can be said of failures by looking at them, each once.

    `findings` are all of a certificate, since some of it is seen only beside what passed; `declared` is what the code
    says of itself, whose units the numbers are told in. No code is run again. The order is that in which they are told:
    what has no answer, what it did, what its surfaces hold, what its velocities look like, at which scales.
    """
    failed = [f for f in findings if f.verdict in WRONG]
    found = [
        *_unanswered(failed),
        *_behaviours(failed),
        *_depth(failed),
        *_energy(failed),
        *_crests(failed),
        *_seas(failed),
        *_signs_lost(failed),
        *(list(_stale(failed)) or _repeated(failed, declared)),  # which repeats values because it repeats cubes
        *_scales(findings, Declaration.read(declared)),
    ]
    return list({(one.fault, one.words): one for one in found}.values())


def said(identifier: str, words: str) -> Hypothesis:
    """What stands in the findings, in words: a hypothesis without digits."""
    return Hypothesis(identifier, words, None, "symptom")


def _behaviours(failed: Sequence[Finding]) -> Iterator[Hypothesis]:
    """Those that are no number: what it did is what is wrong."""
    for f in failed:
        check, case = f.id.partition("[")[0], f.id.partition("[")[2].rstrip("]")
        if f.verdict is not Verdict.FAIL or f.over is None:  # else it gave no answer, which says nothing of this
            continue
        if check == "behaviour.refuses":
            what = "infinity" if case == "infinity" else "NaN"
            gave = "gives NaN for velocities of" if "answered NaN" in f.message else "answers"
            yield said(check, f"it {gave} a cube that holds {what} as if it were whole")
        elif check == "behaviour.input":
            yield said(check, f"it does what it must not: {f.message}")
        elif check == "behaviour.deterministic":
            yield said(check, "it does not answer the same question twice alike")
        elif check == "behaviour.order":
            yield said(check, "its velocity at a wavenumber depends on which others are asked for, or in which order")
        elif check == "behaviour.past-nyquist":
            yield said(check, "it gives NaN for a velocity past the Nyquist wavenumber")
        elif check == "metamorphic.amplitude":
            yield said(check, "its answers change with the unit of the surface: a threshold or a floor in absolute "
                               "numbers, a logarithm, or integers that round or wrap")  # fmt: skip


def _depth(failed: Sequence[Finding]) -> Iterator[Hypothesis]:
    """A depth that is handed over and not used: the answer to one cube is the same whatever it is. Or another one than
    the code declares, in which several of its answers would be right.
    """
    for check, identifier, words, enough in (
        ("depth.change", "depth-unused", "the depth that it is handed is not used", 1),
        ("recovery.pair", "another-depth", "it is not in the depth that it declares", _AT_LEAST),
    ):
        found = [part for f in failed if f.id.startswith(check) for part in parts(f.figures)]
        found = [part for part in found if part.get("unused", "right_in" in part)]
        if len(found) >= enough:
            depths = Counter(part["right_in"] for part in found if "right_in" in part).most_common(1)
            yield said(identifier, words + "".join(f": it answers as in {depth}" for depth, _ in depths))


def _seas(failed: Sequence[Finding]) -> Iterator[Hypothesis]:
    """What is wrong with random seas, the worst of each kind: the findings are in the words of the mistake."""
    found = {}
    for f in sorted((f for f in failed if f.family == "sea" and f.over is not None), key=lambda f: f.over or 0.0):
        found[f.id.partition("[")[0]] = f.message
    for check, message in found.items():
        yield said(check, message)


def _crests(failed: Sequence[Finding]) -> Iterator[Hypothesis]:
    """Velocities of the waves in place of that of the water."""
    seas = [part for f in failed for part in parts(f.figures) if "crests" in part or "errors" in part]
    along = sum(bool(part.get("crests")) for part in seas)
    if along:
        yield said(
            "crests",
            f"in {along} of {len(seas)} seas that fell short its velocity is that of the crests, not of the water: it "
            "takes waves for something that drifts, as image velocimetry does, or a branch for floating particles "
            "beside that of the waves",
        )


def _unanswered(failed: Sequence[Finding]) -> Iterator[Hypothesis]:
    """The same fault instead of an answer, again and again.

    An exception that a fifth of the failed questions end in is one mistake, and is told in the words of the code.
    """
    told = [re.sub(r"[-+]?[0-9][0-9.e+-]*", "#", f.message) for f in failed if f.over is None]
    for words, count in Counter(told).most_common(1):
        if count >= max(_AT_LEAST, _OFTEN * len(failed)):
            message = next(f.message for f in failed if re.sub(r"[-+]?[0-9][0-9.e+-]*", "#", f.message) == words)
            yield said("no-answer", f"{count} of {len(failed)} failed questions have no answer: {message}")


def _signs_lost(failed: Sequence[Finding]) -> Iterator[Hypothesis]:
    """Components that are right but for their signs, or always zero.

    Looked at are answers of which it is known what they should be, where true components are not small and some of them
    negative: where none of the code's is, and their size is right, they have lost their signs.
    """
    pairs = [velocities(f.figures) for f in failed if f.family in TRUE]
    mine, true = (np.concatenate([np.empty((0, 2)), *(pair[n] for pair in pairs)]) for n in (0, 1))
    if len(mine) < _AT_LEAST or not (np.abs(true).max(axis=0) > AWAY).all():
        return
    if (true < -AWAY).any() and (mine >= 0).all() and np.median(digits(mine, np.abs(true))) >= 1.5:
        yield said("absolute-value", f"no component of {len(mine)} velocities is negative: they have lost their signs")
    for axis, name in enumerate("xy"):
        if not mine[:, axis].any():
            yield said(f"lost-{name}", f"the {name} component of all {len(mine)} velocities that fell short is zero")


def _energy(failed: Sequence[Finding]) -> Iterator[Hypothesis]:
    """A ratio of energy that is the same for other waves.

    To a thousandth it is a factor in the code. That amplitudes were drawn anew is said where the ratios scatter about
    2/3: twice the square of a number between 0 and 1 is that in the mean.
    """
    single = [f.figures["ratio"] for f in failed if f.id.startswith("synthesis.energy") and "ratio" in f.figures]
    ratios = [r for f in failed if f.id.startswith("synthesis.mean-energy") for r in f.figures.get("ratios", ())]
    both = np.array([*single, *ratios], dtype=np.float64)
    if both.size < 2 or not np.isfinite(both).all():
        return
    mean = float(both.mean())
    if np.ptp(both) <= 1e-3 * mean:
        name = next((f" ({said})" for value, said in _ENERGIES.items() if abs(mean / value - 1) < 1e-3), "")
        yield said("energy-ratio", f"each surface holds {mean:.4g}{name} of the energy asked for")
    elif abs(mean - 2 / 3) < 3 * float(both.std()) / np.sqrt(both.size) and np.ptp(both) > 0.05:
        yield said(
            "energy-ratio",
            f"surfaces hold {mean:.2g} of the energy asked for in the mean, and each another part: as if amplitudes "
            "were drawn anew, which leaves 2/3",
        )


# ---------------------------------------------------------------- velocities that repeat


def _repeated(failed: Sequence[Finding], declared: Mapping[str, Any]) -> Iterator[Hypothesis]:
    """One answer for everything, answers at the edge of a box, answers on a lattice: in the units of the code.

    A search within a box that was chosen for other waves ends on its edge, and then one component has the same value to
    the last digit in cube after cube. A right code does so only where the currents themselves do (`_IN_STEPS`).
    """
    subject, unit = (
        Subject(Declaration.read(declared)),
        "m/s" if declared["units"] == "si" else "in its units",
    )
    rows, asked = [np.empty((0, 2))], [np.empty(0)]
    free = [f for f in failed if f.id.partition("[")[0] not in (*_IN_STEPS, "scale.gravity")]  # of another unit
    for n, call in enumerate(call for f in free for call in f.calls if call.stage == "extract"):
        length, time, _ = subject.units(call.asked["scale"])
        there = np.isfinite(call.answer).all(axis=1)
        rows.append(call.answer[there] * (length / time))
        asked.append(np.full(int(there.sum()), n))
    v, of = np.concatenate(rows), np.concatenate(asked)
    if len(v) < 2 * _AT_LEAST:
        return
    alike = (np.abs(v - np.median(v, axis=0)) <= _SAME * np.abs(v).max()).all(axis=1)
    if alike.mean() >= _MOSTLY and np.unique(of[alike]).size >= _AT_LEAST:
        one = ", ".join(f"{part:.4g}" for part in v[alike][0])
        yield said("one-answer", f"{int(alike.sum())} of {len(v)} answers are ({one}) {unit}, whatever is asked")
        return
    size = np.abs(v)
    if (step := _step(size)) is not None:
        yield said("on-a-lattice", f"its velocities are whole multiples of {step:.4g} {unit}")
        return
    value, at = _commonest(size)
    if value > 0 and at.sum() >= max(_AT_LEAST, _OFTEN * len(v)) and np.unique(of[at]).size >= 3:
        edge = value >= size.max() * (1 - _SAME)
        what = "the edge of what it searches" if edge else "a value at which it sticks, as at the edge of a range"
        yield said(
            "edge-of-range",
            f"{int(at.sum())} of {len(v)} answers that fell short have a component of {value:.4g} {unit} to the last "
            f"digit: {what}",
        )


def _stale(failed: Sequence[Finding]) -> Iterator[Hypothesis]:
    """The same velocity for different cubes wherever the wavenumber is the same, and others at other wavenumbers.

    The checks ask at the same wavenumbers of cubes with other currents and other waves: a code that looks at the cube
    cannot answer them alike to the last digit.
    """
    at: dict[tuple[float, ...], dict[str, tuple[float, ...]]] = {}
    for f in failed:
        for call in f.calls:
            if call.stage == "extract" and f.family in TRUE and np.isfinite(call.answer).all():
                for k, velocity in zip(np.atleast_1d(call.asked["wavenumbers"]), call.answer, strict=False):
                    at.setdefault((round(float(k), 9), call.asked["scale"]), {})[f.id] = tuple(velocity.tolist())
    several = [np.array(list(of.values())) for of in at.values() if len(of) > 2]
    same = [one for one in several if np.ptp(one, axis=0).max() <= _SAME * np.abs(one).max() > 0]
    if len(same) >= _AT_LEAST and len(same) >= _MOSTLY * len(several) and len({tuple(one[0]) for one in same}) > 2:
        cubes = max(map(len, same))
        yield said(
            "state-kept",
            f"asked at one wavenumber about {cubes} different cubes it gives one velocity, to the last digit: it "
            "keeps an earlier cube, or its spectrum",
        )


def _commonest(size: FloatArray) -> tuple[float, FloatArray]:
    """The commonest |component| other than zero of velocities (m, 2), and which of them have it, (m,)."""
    flat = np.sort(size[size > 0])
    if not flat.size:
        return 0.0, np.zeros(len(size), bool)
    groups = np.split(flat, np.flatnonzero(np.diff(flat) > _SAME * flat[1:]) + 1)
    value = float(np.median(max(groups, key=len)))
    return value, (np.abs(size - value) <= _SAME * value).any(axis=1)


def _step(size: FloatArray) -> float | None:
    """Of which all components are whole multiples, if they are."""
    flat = np.unique(np.round(size / max(float(size.max()), 1e-300), 9)) * float(size.max())
    flat = flat[flat > 0]
    if flat.size < 3:
        return None
    step = float(min(flat[0], np.diff(flat).min()))
    off = np.abs(flat / step - np.rint(flat / step))
    return step if step > 1e-3 * flat[-1] and off.max() < 1e-4 else None


# ---------------------------------------------------------------- scales


def _scales(findings: Sequence[Finding], declared: Declaration) -> Iterator[Hypothesis]:
    """Right at the usual scale and wrong at others: those of everybody, or the ends of what it is made for.

    A width, a range or a limit in rad/s, rad/m or m/s suits the waves that it was chosen in. Which of them it is cannot
    be told from longer waves or shorter ones alone: the words say what it may be.
    """
    judged = [f for f in findings if f.family in ("signs", "recovery", "currents", "scale")]
    wrong = [f for f in judged if f.verdict in WRONG]
    nominal = {"sixteenth": 1 / 16, "quarter": 1 / 4, "4": 4.0, "16": 16.0}
    other = {
        name: f"{2 * np.pi * declared.scales(declared.scale(scale)).length:.3g} m long"
        if declared.waves
        else f"{max(scale, 1 / scale):g} times {'longer' if scale < 1 else 'shorter'}"
        for name, scale in nominal.items()
    }
    at = {f.id.partition("[")[2].rstrip("]").removesuffix("-untapered") for f in wrong if f.id.startswith("scale.peak")}
    if not at or any(f.family != "scale" for f in wrong) or not any(f.family == "signs" for f in judged):
        return
    longer, shorter = at & {"sixteenth", "quarter"}, at & {"4", "16"}
    what = (
        "a width, a range, a limit or a second branch"
        if longer and shorter
        else "a width too wide there, a range of velocities too narrow, or a depth,"
        if longer
        else "a width too narrow there, a limit of frequency or wavenumber, a spurious branch, or surface tension,"
    )
    told = " and ".join(words for name, words in other.items() if name in at)
    yield said(
        "fixed-constants",
        f"it is right at the usual scale and wrong where the same waves are {told}: {what} is written down in rad/s, "
        "rad/m or m/s instead of being taken from the cube",
    )
