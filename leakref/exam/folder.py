"""The folder of an examination: questions, inputs, runners; laid down whole or not at all, read with suspicion.

    questions.json     what is asked, for whoever reads JSON; its digest covers itself and every input
    questions.tsv      the same as a plain table: a line a question, for languages that have no JSON
    declaration.json   what the questions take for granted of the code, as it goes into the answers
    inputs/            the arrays, a file or a folder each; two questions of one cube share it
    README.md, runners

Nothing in it says what is right: no current, and no waves but those that a code is asked to add up.
"""

from __future__ import annotations

import json
import os
import shutil
import tempfile
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from importlib import resources
from pathlib import Path
from typing import Any

import numpy as np

from leakref import __version__
from leakref._base import LeakrefError, refusal
from leakref._output import dump
from leakref.certify.subject.declaration import Declaration
from leakref.certify.subject.exchange import opened, too_deep
from leakref.certify.subject.frames import OUTPUTS
from leakref.certify.verdict import Unanswered
from leakref.exam import storing
from leakref.exam.recording import Question, questions, watched
from leakref.golden.digests import digest

__all__ = ["ANSWERS", "QUESTIONS", "SCHEMA", "Sheet", "filled", "lay_down", "load", "strict_json", "text_of"]

SCHEMA = "leakref/exam/1"
QUESTIONS, ANSWERS = "questions.json", ("answers.json", "answers.mat")
_LARGEST = 1 << 26
"""Bytes of questions.json: those of the full profile take a hundredth."""
_WAVES = ("kx", "ky", "omega", "amplitude", "phase")
RUNNERS = {
    "raw": (
        "leakref_exam.m",
        "leakref_exam.hpp",
        "leakref_exam.R",
        "leakref_example.m",
        "leakref_example.cpp",
        "leakref_example.R",
        "Makefile",
    ),
    "mat": ("leakref_exam.m", "leakref_example.m"),
}
"""By format, those that read it; each was run."""


@dataclass(frozen=True)
class Sheet:
    """The questions of a folder as they stand in it, once `load` has found nothing wrong with their form.

    - `record`: the object in questions.json; `declaration`: of whom it is asked.
    """

    record: Mapping[str, Any]
    declaration: Declaration

    @property
    def digest(self) -> str:
        """Of questions and inputs."""
        return str(self.record["digest"])

    @property
    def format(self) -> str:
        """Of the inputs, and of the arrays that come back."""
        return str(self.record["format"])

    @property
    def asked(self) -> dict[str, Any]:
        """What makes the questions: profile, golden set and seed."""
        return {name: self.record[name] for name in ("profile", "golden", "seed")}


def lay_down(
    place: Path,
    declaration: Declaration,
    form: str,
    *,
    profile: str,
    golden: int,
    seed: int,
    after_each: Callable[[], object] = lambda: None,
) -> dict[str, Any]:
    """Write an examination to `place`, which is not there yet, or an empty folder: the object in questions.json.

    Raises LeakrefError where something is there or nothing can be written. It is made beside, and put there when it is
    whole.
    """
    place = Path(place)
    if place.exists() and (not place.is_dir() or any(place.iterdir())):
        raise LeakrefError("exam write", f"{place} is there already", "name a folder that is new, or empty this one")
    try:
        place.parent.mkdir(parents=True, exist_ok=True)
        beside = Path(tempfile.mkdtemp(prefix=f".{place.name}-", dir=place.parent))
        try:
            record = _written(beside, place.name, declaration, form, profile, golden, seed, after_each)
            if place.exists():
                place.rmdir()
            mask = os.umask(0)
            os.umask(mask)
            beside.chmod(0o777 & ~mask)
            beside.rename(place)
        finally:
            shutil.rmtree(beside, ignore_errors=True)
    except OSError as error:
        raise refusal(
            "exam write", f"{place} cannot be written ({error.strerror or error})", "see to that", error
        ) from None
    return record


def _written(
    place: Path,
    name: str,
    declaration: Declaration,
    form: str,
    profile: str,
    golden: int,
    seed: int,
    after_each: Callable[[], object],
) -> dict[str, Any]:
    """Everything in a folder that is still to be moved to its place: the inputs as they are asked for, each once, then
    the questions in both forms, the declaration, the runners and the page that tells how to answer. The object in
    questions.json is returned.
    """
    inputs: dict[str, dict[str, Any]] = {}

    def keep(contents: str, arrays: Mapping[str, Any]) -> None:
        path = Path("inputs") / f"{len(inputs) + 1:03}{storing.SUFFIX[form]}"
        storing.write(place / path, form, arrays, _dims(declaration.axes))
        bytes_ = b"".join(file.read_bytes() for file in storing.files(place / path))
        shapes = {name: list(np.shape(value)) for name, value in arrays.items()}
        about = {"sha256": storing.sha256(bytes_), "sum": storing.checksum(bytes_), "bytes": len(bytes_)}
        inputs[contents] = {"path": path.as_posix(), "contents": contents, **about, "shapes": shapes}

    asked = questions(declaration, keep, profile=profile, golden=golden, seed=seed, after_each=after_each)
    rows = [_row(n, question, inputs, form) for n, question in enumerate(asked, 1)]
    record: dict[str, Any] = {
        "schema": SCHEMA,
        "version": __version__,
        "seed": seed,
        "profile": profile,
        "golden": golden,
        "format": form,
        "declaration": {**declaration.record(), "format": declaration.format},
        "unsupported": watched(profile),
        "inputs": list(inputs.values()),
        "questions": rows,
    }
    record = json.loads(dump(record))
    record["digest"] = digest(record)
    texts = {QUESTIONS: _lines(record), "questions.tsv": "".join(_table(record))}
    texts["declaration.json"] = dump(record["declaration"]) + "\n"
    words = {"@FOLDER@": name, "@FORMAT@": form, "@COUNT@": str(len(rows))}
    texts["README.md"] = filled(text_of("README.md"), form, words)
    texts |= {name: text_of(name) for name in RUNNERS.get(form, ())}
    for file, text in texts.items():
        (place / file).write_text(text, encoding="utf-8", newline="\n")
    return record


_FITS = {
    "leakref_example.m": ("octave/adapter.m", "function w = taper", "function said = answer"),
    "leakref_example.cpp": ("cpp/adapter.cpp", "Values taper(", "std::string extract("),
}
"""Of the examples that answer with the fit of a scaffold: its file, and where the fit begins and ends in it."""


def text_of(name: str) -> str:
    """A runner, an example, or what is said to the owner."""
    text = resources.files("leakref.exam").joinpath("templates", name).read_text("utf-8")
    if name not in _FITS:
        return text
    place, begins, ends = _FITS[name]
    adapter = resources.files("leakref.certify").joinpath("templates", *place.split("/")).read_text("utf-8")
    return text.replace("@FIT@\n", adapter[adapter.index(begins) : adapter.index(ends)])


def filled(text: str, form: str, words: Mapping[str, str]) -> str:
    """A page with what is for this format only, between lines `@only FORMAT...` and `@end`, and its words put in."""
    kept, holds = [], True
    for line in text.splitlines(keepends=True):
        if line.startswith("@"):
            holds = line.split()[0] == "@end" or form in line.split()
        elif holds:
            kept.append(line)
    filled = "".join(kept)
    for mark, word in words.items():
        filled = filled.replace(mark, word)
    return filled


def _dims(axes: str) -> dict[str, tuple[str, ...]]:
    return {"eta": tuple(axes), **{axis: (axis,) for axis in "xyt"}, **dict.fromkeys(_WAVES, ("wave",))}


def _row(number: int, question: Question, inputs: Mapping[str, Mapping[str, Any]], form: str) -> dict[str, Any]:
    """A question as it stands in questions.json. For raw the shapes are among the parameters, as in protocol 1."""
    held = inputs.get(question.input)
    output = f"outputs/{number:03}{storing.SUFFIX[form]}" if question.shape else None
    parameters = dict(question.parameters)
    if form == "raw":
        expected = {OUTPUTS[question.stage]: list(question.shape)} if question.shape else {}
        parameters["shapes"] = {**(held["shapes"] if held else {}), **expected}
    return {
        "id": question.id,
        "stage": question.stage,
        "input": held["path"] if held else None,
        "output": output,
        "parameters": parameters,
        "checks": list(question.checks),
    }


def _lines(record: Mapping[str, Any]) -> str:
    """JSON with an input or a question on each line, so that a person finds one."""
    lists = ("inputs", "questions")
    head = dump({name: value for name, value in record.items() if name not in lists})[:-1]
    parts = [f'"{name}": [\n' + ",\n".join(map(dump, record[name])) + "\n]" for name in lists]
    return ",\n".join([head, *parts]) + "}\n"


def _table(record: Mapping[str, Any]) -> Iterator[str]:
    """The table for languages without JSON: a first line on all of it, names, and a line a question.

    After its first five cells a line has NAME=VALUE for each parameter; numbers of a list have commas between them.
    """
    yield "\t".join([SCHEMA, record["digest"], record["format"]]) + "\n"
    yield "\t".join(["id", "stage", "input", "sum", "output", "parameters"]) + "\n"
    sums = {one["path"]: one for one in record["inputs"]}
    for row in record["questions"]:
        held = sums.get(row["input"], {"sum": 0, "shapes": {}})
        shapes = row["parameters"].get("shapes", held["shapes"])
        given = {name: value for name, value in row["parameters"].items() if name != "shapes"}
        given |= {f"shape_{name}": shape for name, shape in shapes.items()}
        cells = [row["id"], row["stage"], row["input"] or "-", str(held["sum"]), row["output"] or "-"]
        yield "\t".join([*cells, *(f"{name}={_cell(value)}" for name, value in given.items())]) + "\n"


def _cell(value: Any) -> str:
    return ",".join(map(_cell, value)) if isinstance(value, list) else value if isinstance(value, str) else dump(value)


# ------------------------------------------------------------ reading it back


def strict_json(top: Path, name: str, largest: int, remedy: str) -> tuple[Any, str]:
    """What a file in the folder `top` says, and its SHA-256. Its size is looked at before anything is read; no link is
    followed. Raises LeakrefError for what is no strict JSON: NaN, a name twice in one object, nested beyond reason.
    """
    path = top / name
    try:
        with opened(top.resolve(), top.resolve() / name) as stream:
            size = os.fstat(stream.fileno()).st_size
            if size > largest:
                fault = f"{path} takes {size} bytes, should be at most {largest}"
                raise LeakrefError("exam grade", fault, remedy)
            content = stream.read(largest + 1)
    except OSError as error:
        fault = f"{path} cannot be read ({error.strerror or error})"
        raise refusal(
            "exam grade", fault, "name a folder that `leakref exam write` wrote, with its answers", error
        ) from None
    try:
        said = json.loads(
            content.decode("utf-8"), parse_constant=partial(_refused, "not a number of JSON"), object_pairs_hook=_object
        )
        if too_deep(said):
            _refused("nested too deep", "it")
    except (ValueError, RecursionError) as error:
        raise LeakrefError("exam grade", f"{path} is not strict JSON, or cut short ({error})", remedy) from None
    return said, storing.sha256(content)


def _refused(why: str, what: str) -> Any:
    raise ValueError(f"{what} is {why}")


def _object(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    found = dict(pairs)
    if len(found) < len(pairs):
        names = [name for name, _ in pairs]
        _refused("there twice in one object", repr(next(name for name in names if names.count(name) > 1))[:80])
    return found


def load(place: Path) -> Sheet:
    """The questions of a folder, if they are as they were written. Raises LeakrefError.

    That is by their own digest; that they are those of the seed, and that the inputs are, is for `marking`.
    """
    again = "take questions.json as it was written, or write the examination again"
    record, _ = strict_json(place, QUESTIONS, _LARGEST, again)
    if not isinstance(record, dict) or record.get("schema") != SCHEMA:
        raise LeakrefError("exam grade", f"{place / QUESTIONS} is not of the schema {SCHEMA}", again)
    if record.get("digest") != digest({name: value for name, value in record.items() if name != "digest"}):
        fault = f"{place / QUESTIONS} was altered: its digest is not that of what it says"
        raise LeakrefError("exam grade", fault, again)
    wanted = {"seed": int, "profile": str, "golden": int, "declaration": dict, "inputs": list, "questions": list}
    for name, kind in wanted.items():
        if not isinstance(record.get(name), kind) or isinstance(record[name], bool):
            raise LeakrefError("exam grade", f"{place / QUESTIONS} has no {name} as it should be", again)
    storing.format_named("exam grade", str(record.get("format")))
    if record["profile"] not in ("quick", "full") or not _formed(record):
        raise LeakrefError("exam grade", f"{place / QUESTIONS} is no examination", again)
    try:
        return Sheet(record, Declaration.read(record["declaration"]))
    except (Unanswered, AttributeError, TypeError) as wrong:
        raise LeakrefError("exam grade", f"the code in {place / QUESTIONS} {wrong}", again) from None


def _formed(record: Mapping[str, Any]) -> bool:
    """Whether inputs and questions are objects with what is looked at later, and no path leads out of the folder."""

    def named(path: Any, top: str) -> bool:
        parts = path.split("/") if isinstance(path, str) else []
        return len(parts) == 2 and parts[0] == top and parts[1].replace(".", "").isalnum()

    def rows(name: str, needed: Sequence[str]) -> bool:
        return all(isinstance(row, dict) and all(key in row for key in needed) for row in record[name])

    return (
        rows("inputs", ("path", "contents", "sha256", "bytes", "shapes"))
        and rows("questions", ("id", "stage", "input", "output", "parameters"))
        and all(named(row["path"], "inputs") and isinstance(row["shapes"], dict) for row in record["inputs"])
        and all(row["input"] is None or named(row["input"], "inputs") for row in record["questions"])
        and all(row["output"] is None or named(row["output"], "outputs") for row in record["questions"])
        and all(isinstance(row["id"], str) and isinstance(row["parameters"], dict) for row in record["questions"])
    )
