"""The answers of an examination in the place of a program: each question is looked up, and nothing is run."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from leakref.certify.subject.answers import accepted
from leakref.certify.subject.declaration import Declaration
from leakref.certify.subject.frames import OUTPUTS, Subject
from leakref.certify.verdict import Absent, Unanswered, Verdict
from leakref.exam import storing
from leakref.exam.recording import Key, key_of

__all__ = ["Marked", "Replay"]


@dataclass(frozen=True)
class Marked:
    """A question of the folder beside what came back for it, None if nothing did.

    - `id`: of the question; `output`: where its array should be, below the folder, empty for velocities.
    """

    id: str
    output: str
    answer: Mapping[str, Any] | None


class Replay(Subject):
    """A code as its answers show it. `known` is every question by what it is known by here, `place` the folder.

    What is not answered raises Absent, and becomes missing. A question that is not known hangs on an earlier answer, as
    no question of certify was seen to do, and is unsupported.
    """

    watched = False

    def __init__(self, declaration: Declaration, known: Mapping[Key, Marked], place: Path, form: str) -> None:
        super().__init__(declaration)
        self._known, self._place, self._format = known, place.resolve(), form

    def _work(self, stage: str, arrays: dict[str, Any], parameters: dict[str, Any]) -> Mapping[str, Any]:
        """The answer that came back to this very question. What was not foreseen is unsupported, what was left out
        missing.
        """
        one = self._known.get(key_of(stage, arrays, parameters))
        if one is None:
            raise Unanswered(
                Verdict.UNSUPPORTED, "what is asked next hangs on an answer, and was not in the examination"
            )
        if one.answer is None:
            raise Absent(f"the question {one.id} has not been answered")
        found = accepted(one.answer)
        if shape := self.shape_of(stage, arrays, parameters):
            name = OUTPUTS[stage]
            return storing.read(self._place, self._place / one.output, self._format, {name: shape})
        return found
