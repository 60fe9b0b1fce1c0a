"""A code with a repair around it: what is handed over is changed, or what came back, and nothing within.

So it holds for a code in any language and of any algorithm. `Repair` is what a repair is (the list is in `repairs`),
`Repaired` the code with one around it, as any check sees it, and `Memory` what keeps the search from asking twice. All
is in the frame and the units that the code itself declares, since that is where its mistake is.

A check is run on a `Repaired` as on any code, and knows nothing of it: it passes or not. So no rule for what is right
stands here a second time, and a repair that is right for one kind of question and wrong for another shows at once.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from hashlib import sha256
from typing import Any

import numpy as np

from leakref._base import FloatArray
from leakref.certify.subject.declaration import WATER
from leakref.certify.subject.frames import Subject
from leakref.certify.verdict import Unanswered, Verdict

__all__ = ["NONE", "Memory", "Question", "Repair", "Repaired", "Spent", "joined"]


class Spent(Exception):
    """No more is to be asked: the allowance is used up, or the session broke; the words say which."""


@dataclass(frozen=True, eq=False)
class Question:
    """What `extract` is handed: `eta` [x, y, t] with y as the code counts it, `steps` dx, dy, dt, the length of each
    axis in samples, gravity, wavenumbers (n,), the window that is asked for, and what it is told of the `water`."""

    eta: FloatArray
    steps: tuple[float, float, float]
    sizes: tuple[int, ...]
    gravity: float
    wavenumbers: FloatArray
    window: str
    water: Mapping[str, float] = field(default_factory=dict)

    @property
    def bin(self) -> float:
        """The wider of the two bins along kx and ky."""
        return 2 * np.pi / min(n * d for n, d in zip(self.sizes[:2], self.steps[:2], strict=True))


Change = Callable[[Question], Question]
Back = Callable[[FloatArray, Question], FloatArray]
"""Velocities (m, 2), NaN where there is none, as they should be, from what the code answered to a question."""


def _unchanged(question: Question) -> Question:
    """Handed over as it is."""
    return question


def _as_they_are(velocities: FloatArray, question: Question) -> FloatArray:
    """Taken as they came."""
    return velocities


def _the_same(question: Question) -> float:
    """Wavenumbers are those asked for."""
    return 1.0


@dataclass(frozen=True)
class Repair:
    """Comes right if `words`: `change` what is handed over, `back` what comes back, by the question as it was asked.

    `matrix` is there if `back` is a linear map, the same for all questions. `at` is the factor between wavenumbers of
    the answer, if it has its own, and those asked for; `square` asks on square pixels; `alone` one wavenumber at a
    time. `rival` is one that must not hold beside it, if it is for the reason that it says.
    """

    id: str
    words: str
    change: Change = _unchanged
    back: Back = _as_they_are
    matrix: tuple[tuple[float, float], tuple[float, float]] | None = None
    at: Callable[[Question], float] = _the_same
    square: bool = False
    alone: bool = False
    parts: int = 1
    rival: Repair | None = None


def joined(first: Repair, second: Repair) -> Repair:
    """Both: the first is nearer to the code. Ids are joined by `+`."""
    if not first.id or not second.id:
        return first if first.id else second
    return Repair(
        f"{first.id}+{second.id}",
        f"{first.words} and {second.words}",
        lambda q: first.change(second.change(q)),
        lambda v, q: second.back(first.back(v, second.change(q)), q),
        at=lambda q: first.at(second.change(q)) * second.at(q),
        square=first.square or second.square,
        alone=first.alone or second.alone,
        parts=first.parts + second.parts,
    )


NONE = Repair("", "nothing is done")


class Memory:
    """Answers of a code by what it was handed, so that no question is put to it twice, and what may still be asked.

    `allowance` counts samples handled (those of the cube times the wavenumbers asked for). Raises Spent when it is
    used up, and when the session breaks: after a time-out, or `_ERRORS` errors in a row.
    """

    _ERRORS = 8

    def __init__(self, inner: Subject, allowance: float) -> None:
        self.inner, self.allowance, self.used = inner, allowance, 0.0
        self._answers: dict[bytes, Mapping[str, Any] | Unanswered] = {}
        self._errors = 0

    def asked(self, arrays: dict[str, Any], parameters: dict[str, Any]) -> Mapping[str, Any]:
        """The answer of `extract`, from memory if it was there."""
        eta = np.ascontiguousarray(arrays["eta"])
        said = repr((eta.shape, sorted(parameters.items()), [np.size(arrays[axis]) for axis in "xyt"]))
        key = sha256(said.encode() + eta.tobytes()).digest()
        if key not in self._answers:
            cost = eta.size * max(1, len(parameters["wavenumbers"]))
            if self.used + cost > self.allowance:
                raise Spent("it was ended after as many samples as the judging took")
            self.used += cost
            self._answers[key] = self._answer({**arrays, "eta": eta}, parameters)
        answer = self._answers[key]
        if isinstance(answer, Unanswered):
            raise answer
        return answer

    def _answer(self, arrays: dict[str, Any], parameters: dict[str, Any]) -> Mapping[str, Any] | Unanswered:
        try:
            answer = self.inner._work("extract", arrays, parameters)
        except Unanswered as nothing:
            self._errors += nothing.verdict is Verdict.ERROR
            if nothing.verdict is Verdict.TIMEOUT or self._errors >= self._ERRORS:
                raise Spent(f"it ended when the program broke: {nothing.message}") from None
            return nothing
        self._errors = 0
        return answer


class Repaired(Subject):
    """A code with a repair of what it is handed and one of what it answers around it, of the same declaration."""

    def __init__(self, memory: Memory, handed: Repair, answered: Repair = NONE) -> None:
        own = memory.inner.declaration
        super().__init__(replace(own, fixed=(*own.fixed, "dy")) if handed.square and "dy" not in own.untold else own)
        self.memory, self.repair = memory, joined(handed, answered)
        self.reproduces, self.alike = memory.inner.reproduces, memory.inner.alike or frozenset()

    def _work(self, stage: str, arrays: dict[str, Any], parameters: dict[str, Any]) -> Mapping[str, Any]:
        """The question as the repair changes it, put to the code itself, and its answer as the repair changes that."""
        if stage != "extract":
            return self.memory.inner._work(stage, arrays, parameters)
        order, repair = self.declaration.axes, self.repair
        eta = self.unframed(arrays["eta"])
        asked = np.asarray(parameters["wavenumbers"], dtype=np.float64)
        steps = (parameters["dx"], parameters["dy"], parameters["dt"])
        water = {name: parameters[name] for name in WATER if name in parameters}
        question = Question(eta, steps, eta.shape, parameters["gravity"], asked, parameters["window"], water)
        handed = repair.change(question)
        cube = handed.eta.transpose(["xyt".index(axis) for axis in order])
        given = {name: np.arange(n) * d for name, n, d in zip("xyt", handed.sizes, handed.steps, strict=True)}
        dx, dy, dt = map(float, handed.steps)
        said = {**parameters, "dx": dx, "dy": dy, "dt": dt, "gravity": float(handed.gravity), "window": handed.window}
        said |= handed.water
        each = [handed.wavenumbers] if not repair.alone else np.split(handed.wavenumbers, asked.size)
        answers = [
            _parsed(self.memory.asked({"eta": cube, **given}, {**said, "wavenumbers": k.tolist()})) for k in each
        ]
        if any(isinstance(one, Mapping) for one in answers):
            return next(one for one in answers if isinstance(one, Mapping))
        velocities = np.concatenate([one[0] for one in answers])
        at = answers[0][1] if len(answers) == 1 else None
        back = repair.back(velocities, question)
        rows = [None if np.isnan(row).any() else row.tolist() for row in back]
        return {"velocities": rows} | ({} if at is None else {"wavenumbers": np.asarray(at) * repair.at(question)})


def _parsed(answer: Mapping[str, Any]) -> Any:
    """Velocities (m, 2), NaN where it declined, and its wavenumbers or None; the answer as it is if it is of another
    form or holds what is no number, which no repair mends.
    """
    given = answer.get("velocities")
    try:
        if np.ma.isMaskedArray(given):
            found = np.ma.filled(given.astype(np.float64), np.nan)
            bad = ~np.isfinite(np.asarray(given)[~np.ma.getmaskarray(given)]).all()
        else:
            rows = [row if row is None else [float(one) for one in row] for row in given]  # type: ignore[union-attr]  # or it raises
            found = np.array([(np.nan, np.nan) if row is None else row for row in rows], dtype=np.float64)
            bad = not all(np.isfinite(row).all() for row in rows if row is not None)
        return answer if bad or found.shape[1:] != (2,) else (found, answer.get("wavenumbers"))
    except (TypeError, ValueError, OverflowError):
        return answer
