"""The answers to an examination, read as a file of somebody unknown.

answers.json, or answers.mat with variables of the same names: the digest of the questions, what the code declares of
itself, and an answer for each question that was answered. Sizes are looked at before contents, nothing is followed,
loaded as an object or run, and what cannot be an answer to these questions is refused as a whole, in words.
"""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from leakref._base import LeakrefError
from leakref.certify.subject.declaration import Declaration
from leakref.certify.subject.exchange import opened
from leakref.certify.verdict import Unanswered, printable
from leakref.cubes import matlab
from leakref.exam.folder import ANSWERS, Sheet, strict_json
from leakref.exam.storing import sha256

__all__ = ["Answers", "read"]

_EACH = 4096
"""Bytes of an answer beside its rows."""
_ROW = 256
"""Bytes of a row of two numbers and its wavenumber."""
_ITS_OWN = ("name", "version", "format")
"""What the declaration in the answers may say otherwise than the one that was asked."""
_AGAIN = "let the runner write it again, or start anew: remove the answers, and answer again"


@dataclass(frozen=True)
class Answers:
    """What came back: `by_id` of the questions, the `declaration` of the code, the file's `digest` and its `name`."""

    by_id: Mapping[str, Mapping[str, Any]]
    declaration: Declaration
    digest: str
    name: str


def read(place: Path, sheet: Sheet) -> Answers:
    """The answers in a folder. Raises LeakrefError for what is not there, damaged, or of other questions."""
    there = [name for name in ANSWERS if os.path.lexists(place / name)]
    if len(there) != 1:
        fault = f"{place} holds {' and '.join(there) or f'neither {ANSWERS[0]} nor {ANSWERS[1]}'}"
        raise LeakrefError("exam grade", fault, "answer with a runner of the folder, into one of the two")
    name = there[0]
    rows = sum(_EACH + _ROW * len(question["parameters"].get("wavenumbers", ())) for question in _questions(sheet))
    largest = (1 << 20) + rows
    said, digest = (strict_json if name.endswith(".json") else _mat)(place, name, largest, _AGAIN)
    path = place / name
    if not isinstance(said, dict) or not isinstance(said.get("answers"), list):
        raise LeakrefError("exam grade", f"{path} holds no answers", _AGAIN)
    if said.get("digest") != sheet.digest:
        fault = f"{path} answers another examination: its digest is {printable(said.get('digest'), 80)}, should be "
        raise LeakrefError("exam grade", fault + sheet.digest, "answer the questions that are in this folder")
    return Answers(_by_id(path, said["answers"], sheet), _declared(path, said.get("code"), sheet), digest, name)


def _questions(sheet: Sheet) -> Sequence[Mapping[str, Any]]:
    found: Sequence[Mapping[str, Any]] = sheet.record["questions"]
    return found


def _by_id(path: Path, given: Sequence[Any], sheet: Sheet) -> dict[str, Mapping[str, Any]]:
    """Each answer under the id of its question, which is asked and answered once, with no file but its own."""
    asked = {question["id"]: question for question in _questions(sheet)}
    found: dict[str, Mapping[str, Any]] = {}
    for answer in given:
        name = answer.get("id") if isinstance(answer, dict) else None
        if not isinstance(name, str) or name not in asked:
            fault = f"{path} answers {printable(name or answer, 80)!r}, which was not asked"
            raise LeakrefError("exam grade", fault, _AGAIN)
        if name in found:
            raise LeakrefError("exam grade", f"{path} answers {name} twice", "leave one of the two")
        if answer.get("output") not in (None, "", asked[name]["output"]):
            fault = f"{path} names the output {printable(answer['output'], 80)!r} for {name}, should be "
            remedy = "write arrays where the question says, into the folder of the examination"
            raise LeakrefError("exam grade", fault + f"{asked[name]['output'] or 'none'}", remedy)
        found[name] = answer
    return found


def _declared(path: Path, code: Any, sheet: Sheet) -> Declaration:
    """What the code declares, where it leaves nothing out that of the questions; it may differ in its name only."""
    remedy = "declare the same in the answers as the questions were written for, or have them written with --declare"
    if not isinstance(code, dict | None):
        raise LeakrefError("exam grade", f"{path} declares no code, but {printable(code, 80)}", remedy)
    try:
        said = Declaration.read({**sheet.record["declaration"], **(code or {})})
    except (Unanswered, AttributeError, TypeError) as wrong:
        raise LeakrefError("exam grade", f"the code in {path} {printable(wrong)}", remedy) from None
    own, asked = said.record(), sheet.declaration.record()
    for name in asked:
        if name not in _ITS_OWN and own[name] != asked[name]:
            fault = f"{path} declares {name} = {printable(own[name], 120)}; the questions are for {name} = "
            raise LeakrefError("exam grade", fault + printable(asked[name], 120), remedy)
    return said


def _mat(place: Path, name: str, largest: int, remedy: str) -> tuple[Any, str]:
    """The variables of answers.mat, version 5 to 7, as JSON would have them."""
    try:
        with opened(place.resolve(), place.resolve() / name) as stream:
            size = os.fstat(stream.fileno()).st_size
            if size > largest:
                raise LeakrefError("exam grade", f"{place / name} takes {size} bytes, at most {largest}", remedy)
            content = stream.read(largest + 1)
        held = matlab.tree(place / name, content, largest)
    except LeakrefError as refused:
        raise LeakrefError("exam grade", refused.fault, remedy) from None
    except Exception as error:  # a damaged file may make a parser raise anything
        words = " ".join(str(error).split()) or type(error).__name__
        raise LeakrefError("exam grade", f"{place / name} is damaged or cut short ({words})", remedy) from None
    said = {key: _plain(held[key]) for key in ("digest", "code", "answers") if key in held}
    if isinstance(said.get("code"), dict):
        said["code"] = _listed(said["code"])
    answers = said.get("answers")
    rows = answers if isinstance(answers, list) else [answers]
    said["answers"] = [_answer(row) for row in rows if isinstance(row, dict)]
    return said, sha256(content)


def _answer(row: dict[str, Any]) -> dict[str, Any]:
    """An answer without the fields that are empty; rows of NaN are null, and one row alone is a row."""
    found = {name: value for name, value in row.items() if value not in ("", [], None)}
    if "velocities" in found:
        rows = np.atleast_2d(np.asarray(found["velocities"], dtype=np.float64)).tolist()
        found["velocities"] = [None if all(value != value for value in one) else one for one in rows]
    if "wavenumbers" in found:
        found["wavenumbers"] = np.ravel(found["wavenumbers"]).tolist()
    return found


def _listed(code: dict[str, Any]) -> dict[str, Any]:
    """A declaration in which one word alone is a list of it: a mat file does not tell the two apart."""
    names = {name: value for name, value in code.items() if name in ("fixed", "methods", "windows", "names")}
    listed = {name: [value] if isinstance(value, str) and value else value or [] for name, value in names.items()}
    return {name: _listed(value) if isinstance(value, dict) else value for name, value in code.items()} | listed


def _plain(value: Any) -> Any:
    """Numbers, words, lists and objects: a 1 x 1 is a number, a row a list, whole numbers are whole."""
    if isinstance(value, dict):
        return {name: _plain(item) for name, item in value.items()}
    if isinstance(value, list):
        found = [_plain(item) for item in value]
        return found
    if isinstance(value, str):
        return value
    array = np.squeeze(np.asarray(value))
    listed = array.tolist()
    if array.ndim == 0 and isinstance(listed, float) and listed.is_integer():
        return int(listed)
    return listed
