"""Marks: the questions are made once more from their seed, held against those in the folder, and the answers judged.

Only then is it certain what was asked. Numbers of another machine may differ in their last digits; where they do, the
inputs themselves must be in the folder, and are compared.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from contextlib import nullcontext
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from leakref import __version__
from leakref._base import LeakrefError, refusal
from leakref._output import plain
from leakref.certify.certificate import Certificate
from leakref.certify.runner import certify, select
from leakref.certify.strength.diagnosis import explain
from leakref.certify.subject.exchange import opened
from leakref.certify.verdict import Finding, Unanswered
from leakref.exam import storing
from leakref.exam.answers import Answers
from leakref.exam.folder import Sheet
from leakref.exam.recording import Key, Question, questions
from leakref.exam.replaying import Marked, Replay

__all__ = ["mark", "recognise"]

_ROUNDING = 1e-9
"""Relative: between numbers of one seed made on two machines. Who alters a question to any avail alters it by more."""
_REMEDY = "take the folder as it was written, or write the examination again, with the leakref that marks it"
Step = Callable[[], object]


def recognise(place: Path, sheet: Sheet, after_each: Step = lambda: None) -> list[Question]:
    """The questions as they are made here, in the order of the folder. Raises LeakrefError unless those in the folder
    are the same: in number, ids, parameters and inputs, as far as rounding lets them.
    """
    rows: Sequence[Mapping[str, Any]] = sheet.record["inputs"]
    seen: dict[str, str] = {}

    def keep(contents: str, arrays: Mapping[str, Any]) -> None:
        if len(seen) >= len(rows):
            raise _other(sheet, f"it has {len(rows)} inputs, and there are more")
        row = rows[len(seen)]
        seen[contents] = row["path"]
        held = _unharmed(place, row)
        if row["contents"] == contents:
            return
        shapes = {name: np.shape(value) for name, value in arrays.items()}
        if not held or {name: tuple(shape) for name, shape in row["shapes"].items()} != shapes:
            raise _other(sheet, f"{row['path']} is another cube" + " or not in the folder" * (not held))
        try:
            found = storing.read(place.resolve(), place.resolve() / row["path"], sheet.format, shapes)
        except Unanswered as nothing:
            raise _other(sheet, f"{row['path']} cannot be read: {nothing}") from None
        if not all(_same(found[name], value) for name, value in arrays.items()):
            raise _other(sheet, f"{row['path']} is another cube")

    made = questions(sheet.declaration, keep, **sheet.asked, after_each=after_each)
    theirs: Sequence[Mapping[str, Any]] = sheet.record["questions"]
    for mine, row in zip(made, theirs, strict=False):
        given = {name: value for name, value in row["parameters"].items() if name != "shapes"}
        if (mine.id, mine.stage) != (row["id"], row["stage"]) or seen.get(mine.input) != row["input"]:
            raise _other(sheet, f"it asks {row['id']} where {mine.id} is asked")
        if not _alike(given, plain(mine.parameters)):
            raise _other(sheet, f"the parameters of {row['id']} are others")
    if len(made) != len(theirs) or len(seen) != len(rows):
        raise _other(
            sheet, f"it has {len(theirs)} questions on {len(rows)} inputs, should be {len(made)} on {len(seen)}"
        )
    return made


def _other(sheet: Sheet, why: str) -> LeakrefError:
    made_by = sheet.record.get("version")
    words = f"; it was written by leakref {made_by}, this is {__version__}" if made_by != __version__ else ""
    return LeakrefError(
        "exam grade", f"these are not the questions of seed {sheet.record['seed']}: {why}{words}", _REMEDY
    )


def _unharmed(place: Path, row: Mapping[str, Any]) -> bool:
    """Whether an input is in the folder. Raises LeakrefError where it is, and is not as the questions say."""
    path = place / row["path"]
    if not path.exists() and not path.is_symlink():
        return False
    try:
        content, size = b"", 0
        for file in storing.files(path):
            with opened(place.resolve(), place.resolve() / file.relative_to(place)) as stream:
                content += stream.read(max(0, row["bytes"] - size) + 1)
                size = len(content)
    except (OSError, TypeError) as error:
        said = getattr(error, "strerror", None) or error
        raise refusal("exam grade", f"{path} cannot be read ({said})", _REMEDY, error) from None
    if storing.sha256(content) != row["sha256"]:
        raise LeakrefError("exam grade", f"{path} was altered: its SHA-256 is not that of the questions", _REMEDY)
    return True


def _same(found: Any, should: Any) -> bool:
    """Whether arrays are one but for rounding; where one is not finite, nor is the other."""
    theirs, mine = (np.asarray(one, dtype=np.float64) for one in (found, should))
    known = np.isfinite(mine)
    scale = float(np.abs(mine[known]).max(initial=0.0))
    return bool(
        np.array_equal(known, np.isfinite(theirs)) and np.allclose(theirs[known], mine[known], 0, _ROUNDING * scale)
    )


def _alike(given: Any, should: Any) -> bool:
    """Whether parameters are the same but for rounding."""
    if isinstance(should, dict):
        return (
            isinstance(given, dict) and set(given) == set(should) and all(_alike(given[n], should[n]) for n in should)
        )
    if isinstance(should, list):
        return isinstance(given, list) and len(given) == len(should) and all(map(_alike, given, should))
    if isinstance(should, float) and isinstance(given, int | float) and not isinstance(given, bool):
        return abs(given - should) <= _ROUNDING * abs(should)
    return bool(given == should)


def mark(
    place: Path,
    sheet: Sheet,
    answers: Answers,
    made: Sequence[Question],
    *,
    workers: int = 1,
    after_each: Callable[[Finding], object] = lambda finding: None,
    after_fault: Step = lambda: None,
) -> Certificate:
    """The certificate of what was answered, with a diagnosis as far as that needs no further question.

    `made` are the questions from `recognise`; `workers` sessions look up answers side by side.
    """
    rows = sheet.record["questions"]
    known: dict[Key, Marked] = {
        question.key: Marked(row["id"], row["output"] or "", answers.by_id.get(row["id"]))
        for question, row in zip(made, rows, strict=True)
    }
    sessions = [nullcontext(Replay(answers.declaration, known, place, sheet.format)) for _ in range(max(1, workers))]
    found = certify(answers.declaration.name, sessions, select(**sheet.asked), **sheet.asked, after_each=after_each)
    about = {"digest": sheet.digest, "answers": answers.digest, "answered": len(answers.by_id), "questions": len(rows)}
    found = replace(found, examination=about, findings=[_again(f, made, place) for f in found.findings])
    return explain(found, after_each=after_fault) if found.wrong else found


def _again(finding: Finding, made: Sequence[Question], place: Path) -> Finding:
    """With the questions that it rests on in the place of a command, which needs the code here."""
    ids = [question.id for question in made if finding.id in question.checks]
    more = f" and {len(ids) - 3} more" if len(ids) > 3 else ""
    said = f"{', '.join(ids[:3])}{more} in {place / 'questions.tsv'}" if ids else finding.repro
    return replace(finding, repro=said)
