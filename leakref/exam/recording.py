"""The questions of certify, found by asking: every check is run on a subject that keeps what it is asked.

Some checks ask further only if an answer was wrong, or lacking, or if the code works as one of the reference's methods.
So each is run on every kind of answer there is: numbers that are never right, none at all, and both for each method
that a code may turn out to be. What follows from an answer comes last, as far as there is room for it. What can still
be asked beyond that, or hangs on an answer in a way that nobody foresaw, is `unsupported` where it is marked
(`replaying`).
"""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from leakref._output import dump
from leakref.certify.checks.draw import PUBLISHED
from leakref.certify.checks.identity import identify
from leakref.certify.checks.registry import Case, Check
from leakref.certify.runner import select
from leakref.certify.subject.declaration import Declaration
from leakref.certify.subject.frames import OUTPUTS, OWN, Subject
from leakref.certify.verdict import Unanswered, Verdict
from leakref.golden.sets import NEWEST
from leakref.methods import METHODS

__all__ = ["IDENTITY", "LARGEST", "Key", "Question", "Recorder", "content", "key_of", "questions", "watched"]

IDENTITY = "identity"
"""The id of the question by which a code is held to digits, where no check asks it as well."""
LARGEST = 150e6
"""Bytes of the quick examination, whatever is declared."""
_REST = 2e6  # of these for headers, questions and runners
Keep = Callable[[str, Mapping[str, Any]], object]
Key = tuple[str, str, str]
"""What a question is known by: its stage, the digest of its arrays, its parameters as JSON."""
_WRONG = 1e3  # in units of any code: no current, and too far off for a score to mean anything


@dataclass(frozen=True)
class Question:
    """One request, put once however many checks ask it.

    - `id`: that of the first finding it is for, and `#2`, `#3` where that asks more; `checks`: of all findings.
    - `stage`, `parameters`: as in a run of protocol 1; `input`: the digest of its arrays, empty if there are none.
    - `shape`: of the array that is to come back, empty for velocities.
    """

    id: str
    stage: str
    input: str
    parameters: Mapping[str, Any]
    shape: tuple[int, ...]
    checks: tuple[str, ...]

    @property
    def key(self) -> Key:
        """What it is known by."""
        return self.stage, self.input, dump(self.parameters)


def content(arrays: Mapping[str, Any]) -> str:
    """SHA-256 of arrays by name, of their shapes and float64 values, whatever file they stand in; empty for none."""
    if not arrays:
        return ""
    digest = hashlib.sha256()
    for name in sorted(arrays):
        values = np.ascontiguousarray(arrays[name], dtype="<f8")
        digest.update(f"{name}{values.shape}\0".encode() + values.tobytes())
    return digest.hexdigest()


def key_of(stage: str, arrays: Mapping[str, Any], parameters: Mapping[str, Any]) -> Key:
    """What a request is known by."""
    return stage, content(arrays), dump(parameters)


class Recorder(Subject):
    """A subject that keeps what it is asked in `found`, and answers so that a check goes on.

    `keep` is called with the digest and the arrays of each input that is new, in the order in which they are asked.
    Inputs of what follows from an answer must fit into the bytes of `room`, and are unsupported if they do not.
    """

    watched = False

    def __init__(self, declaration: Declaration, keep: Keep, room: float) -> None:
        super().__init__(declaration)
        self.found: dict[Key, Question] = {}
        self.room, self.followed = room, False
        self._keep, self._inputs, self._asked = keep, set[str](), 0
        self.check = IDENTITY
        """The id of the finding that is asked for."""
        self.silent = False
        """Whether it answers nothing, in place of what is wrong."""

    def _work(self, stage: str, arrays: dict[str, Any], parameters: dict[str, Any]) -> Mapping[str, Any]:
        """Keep what is asked, once for all checks that ask it and with its input once for all questions, and answer so
        that the check goes on.
        """
        key = key_of(stage, arrays, parameters)
        shape = self.shape_of(stage, arrays, parameters)
        known = self.found.get(key)
        if known is None:
            if key[1] and key[1] not in self._inputs:
                size = sum(np.asarray(array).nbytes for array in arrays.values())
                if self.followed and size > self.room:
                    raise Unanswered(Verdict.UNSUPPORTED, "there is no room for what follows from an answer")
                self.room -= size
                self._inputs.add(key[1])
                self._keep(key[1], arrays)
            count = sum(question.checks[0] == self.check for question in self.found.values())
            name = self.check if not count else f"{self.check}#{count + 1}"
            self.found[key] = Question(name, stage, key[1], dict(parameters), shape, (self.check,))
        elif self.check not in (*known.checks, IDENTITY):
            self.found[key] = replace(known, checks=(*known.checks, self.check))
        return self._answer(stage, shape, parameters)

    def _answer(self, stage: str, shape: tuple[int, ...], parameters: Mapping[str, Any]) -> Mapping[str, Any]:
        """Velocities that are another each time, so that nothing agrees with anything; or what is not zero."""
        self._asked += 1
        if stage != "extract":
            return {OUTPUTS[stage]: np.full(shape, 1.0)}
        count = 1 if self.declaration.band else len(parameters["wavenumbers"])
        row = None if self.silent else [_WRONG * self._asked, -_WRONG * (self._asked + 1)]
        return {"velocities": [row] * count, "wavenumbers": parameters["wavenumbers"][:count]}

    def ask_all(self, check: Check, case: Case) -> bool:
        """Have a check put its questions, to each kind of code that this one may turn out to be, and with `followed`
        those that follow where what is answered is wrong, or nothing. Whether it asks for velocities.
        """
        self.check, before = f"{check.id}[{case.id}]", self._asked
        named = self.declaration.methods
        kinds = [("", frozenset[str]()), ("", frozenset(METHODS))]
        if not named:
            kinds = [(OWN, frozenset()), *((name, frozenset({name})) for name in METHODS)]
        for reproduces, alike in kinds if self.offers("extract") else kinds[:1]:
            for silent in (False, True) if self.followed else (False,):
                self.reproduces, self.alike, self.silent = reproduces, alike, silent
                check(self, case)
        return check.stage == "extract" and self._asked > before


def questions(
    declaration: Declaration,
    keep: Keep = lambda digest, arrays: None,
    *,
    profile: str = "quick",
    golden: int = NEWEST,
    seed: int = PUBLISHED,
    room: float | None = None,
    after_each: Callable[[], object] = lambda: None,
) -> list[Question]:
    """All questions that `certify` may put to a code of that declaration, each once: first those that it puts to every
    such code, in the order of the checks, then those that follow from an answer, as far as `room` goes.

    `keep` is called with each new input as it is made, `after_each` after each check. `room` is in bytes of inputs
    (default: in the quick profile what leaves the whole within `LARGEST`, in the full one as much as is asked).
    """
    if room is None:
        room = LARGEST - _REST if profile == "quick" else np.inf
    recorder = Recorder(declaration, keep, room)
    checks = select(profile=profile, golden=golden, seed=seed)
    leading = []
    for check, case in checks:
        if recorder.ask_all(check, case):
            leading.append((check, case))
        after_each()
    recorder.check, recorder.alike = IDENTITY, None
    identify(recorder)
    recorder.followed = True
    for check, case in leading:
        recorder.ask_all(check, case)
    return list(recorder.found.values())


def watched(profile: str = "quick") -> list[str]:
    """The findings that no examination can make: only who watches the code can tell."""
    return [f"{check.id}[{case.id}]" for check, case in select(profile=profile) if check.watched]
