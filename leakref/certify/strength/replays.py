"""The questions that a code failed, put to the reference with a fault, and how near its answers come to the code's.

What a fault answers is kept in files, since it is the same for every code that is asked the same: under the digest of
all sources that have a part in it, so that nothing in them is ever of another version. A file holds the answers of all
faults to one question. Where nothing can be written they are worked out anew each time.

What is compared are numbers: velocities wavenumber by wavenumber, spectra after the best common factor, surfaces and
windows sample by sample. A failure that is no number (a cube with NaN that was not refused, an input that was altered)
is compared by what it did, and counts as the same only where the words are the same as well.

A hypothesis holds if nine answers in ten agree to `ENOUGH` digits: one shell in another basin of the score does not
refute it. More other answers than that are its end, and nothing further is asked of it, which is most of what makes a
diagnosis quick.

The reference is asked as the code was: of the methods and windows that it declares, with its pixels square if they must
be, its rows counted the same way, and held to digits where the code was.
"""

from __future__ import annotations

import re
from base64 import b64decode, b64encode
from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field, replace
from functools import cache, lru_cache
from json import dumps, loads
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from leakref import _caches, kept, sources
from leakref._base import FloatArray, LeakrefError
from leakref.certify.checks.criteria import NEVER
from leakref.certify.checks.draw import PUBLISHED
from leakref.certify.runner import select
from leakref.certify.strength import faults
from leakref.certify.strength.clues import FULL, OTHERWISE, TWICE, USUAL, Clue, worst
from leakref.certify.subject.declaration import Declaration
from leakref.certify.subject.frames import Call
from leakref.certify.subject.inprocess import InProcess
from leakref.certify.verdict import Finding, Verdict
from leakref.golden.sets import locate
from leakref.methods import DEFAULT, METHODS

__all__ = ["ENOUGH", "Names", "Scored", "implementation", "methods", "pairs", "question", "tried"]

ENOUGH = 3.0
"""Digits of agreement from which a fault explains an answer: far more than two velocities share by chance."""
_FLOOR = 0.02  # in c0: slower velocities of the reference say nothing of a sign
_SMALL = 4000  # numbers: more are not kept
_FILES = 300  # of questions; the oldest are removed
_ENTRIES = tuple(f"leakref.certify.{part}" for part in ("strength.replays", "strength.faults", "checks", "runner"))

Step = Callable[[], object]
Names = tuple[str, ...]  # of the faults of a hypothesis
Scored = list[tuple[Names, float]]


def methods(declared: Mapping[str, Any]) -> list[list[str]]:
    """Methods of the reference to compare with: those that are declared, else one after the other."""
    named = declared["can"].get("extract", {}).get("methods", ())
    if named:
        return [[name for name in named if name in METHODS] or list(DEFAULT)[:1]]
    return [[name] for name in DEFAULT]


def question(
    declared: Mapping[str, Any], methods: Sequence[str], seed: int, golden: int, alike: Sequence[str] | None = None
) -> str:
    """How the reference is to be asked, as JSON, since results are kept by it.

    `alike` are methods of the reference as which the code answers a broad sea; None finds out for each fault.
    """
    said = {name: declared.get(name) for name in ("can", "fixed", "y", "cube", "units", "water", "waves")}
    return dumps({**said, "methods": methods, "seed": seed, "golden": golden, "alike": alike}, default=list)


def tried(
    clues: Sequence[Clue], hypotheses: Iterable[Names], asked: str, after_each: Step = lambda: None
) -> tuple[Scored, float]:
    """Hypotheses by digits, best first, and the digits of the empty one, the reference itself.

    `clues` are from cheap to dear, `hypotheses` ids of faults, one or several together, and `asked` is a `question`.
    One after the other the clues are compared. Not followed further are hypotheses that are far behind the best, and
    those that gave more other answers than may be, whatever the rest is.
    """
    spare = int(OTHERWISE * (sum(_answers(clue.finding) for clue in clues) - 1))
    digits: dict[Names, list[float]] = {names: [] for names in hypotheses}
    for clue in clues:
        for names, seen in digits.items():
            seen += _agreement(clue, names, asked)
            after_each()
        top = max((worst(seen) for names, seen in digits.items() if names), default=0.0)
        digits = {
            names: seen
            for names, seen in digits.items()
            if not names or (worst(seen) >= top - 2 and sum(one < ENOUGH for one in seen) <= spare)
        }
    _store().flush()
    plain = worst(digits.pop((), []))
    return sorted(((names, worst(seen)) for names, seen in digits.items()), key=lambda row: -row[1]), plain


@lru_cache(maxsize=4096)
def implementation(names: Names) -> Any:
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
def _replayed(identifier: str, names: Names, asked: str) -> tuple[Finding, tuple[Call, ...]]:
    """What a check finds of the reference with faults, offering no more than is declared, and the answers it had."""
    if (found := _store().get(identifier, names, asked)) is not None:
        return found
    given = loads(asked)
    ((check, case),) = select([identifier], seed=given["seed"], golden=given["golden"])
    subject = InProcess(implementation(names))
    own = subject.declaration
    shown = {name: given[name] for name in ("units", "cube", "water", "waves") if given[name]}
    theirs = Declaration(can=given["can"], **{"units": own.units, **shown})
    subject.asked_as = theirs
    offered = {"methods": given["methods"], "windows": list(theirs.windows) if theirs.tapers else []}
    subject.declaration = replace(
        own,
        fixed=tuple(name for name in given["fixed"] if name.split()[0] in ("dy", "gravity")),  # the same questions
        y=given["y"] or "up",  # an array is shown as it is
        cube=given["cube"] or {},
        can={**own.can, "extract": {**own.can["extract"], **offered}},
    )
    if given["alike"] is not None:
        subject.alike = frozenset(given["alike"])
    finding, calls = replace(check(subject, case), calls=(), figures={}), tuple(subject.calls)
    _store().put(identifier, names, asked, finding, calls)
    return finding, calls


# ---------------------------------------------------------------- how near answers come


def _in_words(finding: Finding) -> bool:
    """Whether it failed by what it did, and not by a number."""
    like_a_verdict = finding.family == "behaviour" and (finding.over is None or not finding.over < NEVER)
    return like_a_verdict or not finding.calls


def _answers(finding: Finding) -> int:
    """How many there are to compare."""
    if _in_words(finding):
        return 1
    return sum(len(call.answer) if call.stage == "extract" else 1 for call in finding.calls)


def _agreement(clue: Clue, names: Names, asked: str) -> list[float]:
    """Digits to which a hypothesis gives the answers of a clue; beyond those of float64 for what is no number.

    What failed by what it did must fail in the same way and words, and with the same numbers if it has any.
    """
    theirs = clue.finding
    finding, calls = _replayed(theirs.id, names, asked)
    in_words = _in_words(theirs)
    if (names or in_words) and finding.verdict is not theirs.verdict:  # the reference is compared by its numbers alone
        return [0.0]
    digits = [digit for mine, other in zip(theirs.calls, calls, strict=False) for digit in _digits(mine, other)]
    if in_words:
        told = _told(finding) <= _told(theirs)  # which may tell of the checks before as well
        same = told and (theirs.id.startswith(TWICE) or not digits or worst(digits) >= ENOUGH)
        return [FULL + 1 + worst(digits) / FULL if same else 0.0]
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
        scale = np.nanmax(np.abs(a), initial=USUAL if mine.stage == "extract" else 0.0) or 1.0
        off = np.abs(a - b).reshape(len(a), -1).max(axis=1) / scale
    gone = np.isnan(a).reshape(len(a), -1).any(axis=1)
    off = np.where(gone & np.isnan(b).reshape(len(b), -1).any(axis=1), 0.0, np.where(np.isnan(off), 1.0, off))
    each = np.clip(-np.log10(np.maximum(off, 10**-FULL)), 0.0, FULL)
    return [float(d) for d in each] if mine.stage == "extract" else [float(each.min())]


def _fitted(a: npt.NDArray[Any], b: npt.NDArray[Any]) -> npt.NDArray[Any]:
    """b, made like a: magnitudes if a has no phases, times the best common factor."""
    if not np.iscomplexobj(a):
        b = np.abs(b)
    power = np.vdot(b, b).real
    return b * (np.vdot(b, a) / power) if power else b


def pairs(clues: Sequence[Clue], asked: str) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Velocities of the implementation and of the reference for the same questions, (m, 2) each, and scales (m,)."""
    mine, true, scales = [np.empty((0, 2))], [np.empty((0, 2))], [np.empty(0)]
    for clue in clues:
        _, calls = _replayed(clue.finding.id, (), asked)
        for a, b in zip(clue.finding.calls, calls, strict=False):
            if a.stage == b.stage == "extract" and a.answer.shape == b.answer.shape:
                use = np.isfinite(a.answer).all(axis=1) & (np.hypot(*b.answer.T) > _FLOOR)
                mine.append(a.answer[use])
                true.append(b.answer[use])
                scales.append(np.full(int(use.sum()), float(a.asked["scale"])))
    return np.concatenate(mine), np.concatenate(true), np.concatenate(scales)


# ---------------------------------------------------------------- kept in files


@cache
def _store() -> _Store:
    return _Store(_caches.folder())


@dataclass(eq=False)
class _Store:
    """Findings and answers of faults, a file for each question, read once and written when a search is through.

    Several processes may write: a file is whole or not there, and what one has lost to another is worked out again.
    """

    folder: Path | None
    read: dict[Path, dict[str, Any]] = field(default_factory=dict)
    new: dict[Path, tuple[dict[str, Any], dict[str, Any]]] = field(default_factory=dict)

    def _place(self, identifier: str, asked: str) -> tuple[Path, dict[str, Any]] | None:
        """Where the answers to a question are; None for one that will not come again."""
        if self.folder is None or loads(asked)["seed"] != PUBLISHED:
            return None
        about = {"question": identifier, "asked": asked, "sources": _sources(loads(asked)["golden"])}
        return self.folder / "replays" / f"{kept.key(about)}.json", about

    def get(self, identifier: str, names: Names, asked: str) -> tuple[Finding, tuple[Call, ...]] | None:
        """What was kept; None if nothing was."""
        if (place := self._place(identifier, asked)) is None:
            return None
        path, about = place
        if path not in self.read:
            self.read[path] = kept.record(path, about) or {}
        try:
            row = self.read[path][_key(names)]
            calls = tuple(Call(stage, {}, _unpacked(packed)) for stage, packed in row["calls"])
            return Finding(identifier, row["family"], Verdict(row["verdict"]), row["message"]), calls
        except (KeyError, TypeError, ValueError):
            return None

    def put(self, identifier: str, names: Names, asked: str, finding: Finding, calls: tuple[Call, ...]) -> None:
        """Note it, to be written by `flush`; what is large is not."""
        place = self._place(identifier, asked)
        if place is None or sum(call.answer.size for call in calls) > _SMALL:
            return
        row = {"family": finding.family, "verdict": str(finding.verdict), "message": finding.message}
        packed = [(call.stage, _packed(call.answer)) for call in calls]
        self.new.setdefault(place[0], (place[1], {}))[1][_key(names)] = {**row, "calls": packed}

    def flush(self) -> None:
        """Write what is new beside what is there by now. A disk that takes nothing is no error."""
        for path, (about, rows) in self.new.items():
            self.read[path] = {**(kept.record(path, about) or {}), **rows}
            with suppress(OSError, LeakrefError):
                kept.keep_record(path, about, self.read[path])
        if self.new and self.folder is not None:
            with suppress(OSError):
                files = sorted((self.folder / "replays").glob("*.json"), key=lambda path: path.stat().st_mtime)
                for path in files[:-_FILES]:
                    path.unlink(missing_ok=True)
        self.new.clear()


@cache
def _sources(golden: int) -> str:
    """Of all that has a part in an answer or a verdict: code, and the golden set."""
    return sources.digest(*_ENTRIES, more=(locate(golden) / "manifest.json").read_bytes())


def _key(names: Names) -> str:
    return "+".join(names)


def _packed(answer: npt.NDArray[Any]) -> dict[str, Any]:
    """An array in JSON, to the last bit."""
    return {"type": answer.dtype.str, "shape": answer.shape, "data": b64encode(answer.tobytes()).decode()}


def _unpacked(packed: Mapping[str, Any]) -> npt.NDArray[Any]:
    return np.frombuffer(b64decode(packed["data"]), dtype=packed["type"]).reshape(packed["shape"])
