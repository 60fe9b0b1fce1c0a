"""Certificates of several codes side by side, on one page: where they hold, where they fall short, where they differ.

What is read are files that `leakref certify --report` or `--json` has written, today or with an earlier leakref: what
later ones say of themselves (scope, seed, date) may be absent, and is then counted from the findings or not said. The
words in them are other people's: they are cleaned when read and escaped on the page. No check is run and no code is
asked. Nothing is ranked, since a code that offers less is asked less; and what was asked differently of two codes is
said before anything is compared.
"""

from __future__ import annotations

import json
import re
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import Any

from jsonschema import Draft202012Validator
from rich.console import Console
from rich.markup import escape

from leakref import __version__
from leakref._base import LeakrefError, refusal
from leakref._output import dump, envelope, folder, template, write_whole
from leakref._tables import Table
from leakref.certify.certificate import CONFORMANT, NO_GRADE, REJECTED, SOUND, schema
from leakref.certify.checks.registry import FAMILIES
from leakref.certify.verdict import WRONG, Verdict, printable

__all__ = ["Cell", "Code", "differing", "page", "read", "read_all", "run", "unlike"]

_SCHEMA = "leakref/certify/1"
_REMEDY = "name a certificate.json that `leakref certify --report` wrote"
_COVERAGE = ("asked", "judged", "missing", "unsupported")
_LATER = {"grade_line", "coverage", "scope", "seed", "date", "complete", "cut_short", "stress"}
"""What certificates of an earlier leakref lack."""
_WORDS = {  # what is shown of them besides, and is not in their schema
    "declaration": {"properties": {name: {"type": "string"} for name in ("name", "version")}},
    "known": {"items": {"properties": {name: {"type": "string"} for name in ("id", "reason", "issue")}}},
}
_NOT_SAID = "not said"
_SETTINGS = {
    "version": "Made by different versions of leakref: {}. Checks and tolerances may have changed between them.",
    "profile": "Asked in different profiles: {}. The full profile asks more: compare where both were asked.",
    "golden": "Held against different golden sets: {}. Of conformance, compare what both were asked.",
    "seed": "Shown seas of different seeds: {}. Digits differ for that alone, and a verdict near its tolerance may.",
}
"""What should be the same of certificates that are compared; what to say, and what to mind, where it is not."""


@dataclass(frozen=True)
class Cell:
    """What happened to one code in one family of checks, or in all: how many findings of which kind.

    `others` is how many questions other codes were asked there and this one was not.
    """

    asked: int
    held: int
    wrong: int
    missing: int
    unsupported: int
    others: int = 0

    @property
    def judged(self) -> int:
        """Findings that say something of the code."""
        return self.held + self.wrong

    @property
    def kind(self) -> str:
        """In one word, for the colour and the mark: `asked-not`, `offered-not`, `wrong`, `missing` or `held`."""
        if not self.asked:
            return "asked-not"
        if self.unsupported == self.asked:
            return "offered-not"
        return "wrong" if self.wrong else "missing" if self.missing else "held"

    @property
    def words(self) -> str:
        """In short."""
        return {
            "asked-not": "not asked",
            "offered-not": "not offered",
            "wrong": f"{self.wrong} of {self.judged} wrong",
            "missing": f"{self.missing} of {self.asked - self.unsupported} missing",
            "held": f"all {self.held} held" if self.held > 1 else "held",
        }[self.kind]

    @property
    def besides(self) -> list[str]:
        """What else there is to say of a family of which it was asked something, each in short."""
        counts = {
            "missing": self.missing * (self.kind == "wrong"),
            "not offered": self.unsupported * (self.kind != "offered-not"),
            "not asked": self.others * (self.kind != "asked-not"),
        }
        return [f"{count} {words}" for words, count in counts.items() if count]


@dataclass(frozen=True, eq=False)
class Code:
    """A code as its certificate has it. `number` is 0 unless others have its name and version: then 1, 2, ...

    - `file`: its name as given; `record`: what is in it, held to the schema. All characters can be shown.
    """

    file: str
    record: Mapping[str, Any]
    number: int = 0

    @property
    def name(self) -> str:
        """As it calls itself, or else what was typed to certify it."""
        return str(self.record["declaration"]["name"]).strip() or str(self.record["target"]) or "unnamed"

    @property
    def version(self) -> str:
        """Its own, which may be empty."""
        return str(self.record["declaration"].get("version", "")).strip()

    @property
    def label(self) -> str:
        """Name and version, and its number where others have the same."""
        return f"{self.name} {self.version}".strip() + f" ({self.number})" * bool(self.number)

    @property
    def grade(self) -> str:
        """In a word, `no grade` where there is none."""
        return str(self.record["grade"] or NO_GRADE)

    @property
    def grade_line(self) -> str:
        """The grade, and on how many of all questions it was judged."""
        judged = f", {self.coverage['judged']} of {self.coverage['asked']} questions" if self.record["grade"] else ""
        return str(self.record.get("grade_line") or self.grade + judged)

    @property
    def coverage(self) -> dict[str, int]:
        """How many questions were `asked`, `judged`, `missing` and `unsupported`, counted here where it is not said."""
        all_ = self.cell()
        counted = (all_.asked, all_.judged, all_.missing, all_.unsupported)
        said = self.record.get("coverage") or dict(zip(_COVERAGE, counted, strict=True))
        return {name: said[name] for name in _COVERAGE}

    @cached_property
    def verdicts(self) -> dict[str, str]:
        """Of each finding, by its id."""
        return {f["id"]: f["verdict"] for f in self.record["findings"]}

    def cell(self, family: str | None = None, ids: Sequence[str] = ()) -> Cell:
        """What happened in `family`, or in all. `ids` are those of all findings that any code has there."""
        found = [f["verdict"] for f in self.record["findings"] if family in (None, f["family"])]
        wrong = sum(verdict in WRONG for verdict in found)
        others = sum(identifier not in self.verdicts for identifier in ids)
        return Cell(len(found), found.count("pass"), wrong, found.count("missing"), found.count("unsupported"), others)

    @property
    def scope(self) -> str:
        """For what waves and water it is meant, in words."""
        return str(self.record.get("scope", {}).get("words") or _NOT_SAID)

    @property
    def date(self) -> str:
        """When it was certified, to the minute."""
        return re.sub(r"^(\S{10})T(\d\d:\d\d)[:\d.]*\+00:00$", r"\1, \2 UTC", self.setting("date"))

    def setting(self, name: str) -> str:
        """How it was asked, by a key of the certificate; `not said` by older ones."""
        value = self.record.get(name)
        return _NOT_SAID if value in (None, "") else str(value)


def read(path: Path) -> Code:
    """A certificate from a file.

    Raises LeakrefError, with the name of the file, for one that is not there, not JSON, no certificate of `leakref
    certify`, one of another format, and one that is damaged: whose form is not that of the schema, which has a finding
    twice or in a family that is not its own, or whose counts are not those of its findings.
    """
    try:
        record = _clean(json.loads(path.read_bytes()))
    except OSError as error:
        raise refusal("compare", f"{path} cannot be read ({error.strerror or error})", _REMEDY, error) from None
    except (ValueError, RecursionError) as error:
        raise LeakrefError("compare", f"{path} is not JSON ({printable(error, 120)})", _REMEDY) from None
    form = record.get("schema") if isinstance(record, dict) else None
    if not isinstance(form, str) or not form.startswith("leakref/certify/"):
        what = f": its schema is {form[:60]!r}" if isinstance(form, str) else ""
        raise LeakrefError("compare", f"{path} is no certificate of leakref certify{what}", _REMEDY)
    maker = str(record.get("version") or __version__)[:40]
    remedy = "certify the code again" + f", or compare with leakref {maker}, which made it" * (maker != __version__)
    if form != _SCHEMA:
        raise LeakrefError(
            "compare", f"{path} is a certificate of the format {form[:60]}, and {_SCHEMA} is what is read here", remedy
        )
    if fault := next(_faults(record), ""):
        raise LeakrefError("compare", f"{path} is damaged: {printable(fault, 240)}", remedy)
    return Code(printable(path), record)


def _clean(value: Any) -> Any:
    """With a mark in the place of every character that is not shown, such as one that turns the direction of words."""
    if isinstance(value, str):
        return "".join(c if c.isprintable() else " " if c.isspace() else "\ufffd" for c in value)
    if isinstance(value, dict):
        return {_clean(key): _clean(item) for key, item in value.items()}
    return [_clean(item) for item in value] if isinstance(value, list) else value


def _faults(record: Mapping[str, Any]) -> Iterator[str]:
    """What is amiss with a certificate, in words: its form first, on which all else relies."""
    form = schema()
    form["required"] = [name for name in form["required"] if name not in _LATER]
    for error in Draft202012Validator({"allOf": [form, {"properties": _WORDS}]}).iter_errors(record):
        yield f"{error.json_path.removeprefix('$').removeprefix('.') or 'it'}: {error.message}"
    for f in record["findings"]:
        if f["id"].partition(".")[0] != f["family"]:
            yield f"the finding {f['id']} is said to be of the family {f['family']}"
    ids = [f["id"] for f in record["findings"]]
    if twice := next((one for one in ids if ids.count(one) > 1), ""):
        yield f"the finding {twice} is there twice"
    if Counter(f["verdict"] for f in record["findings"]) != record["counts"]:
        yield f"its counts are not those of its {len(ids)} findings"


def read_all(paths: Sequence[Path]) -> list[Code]:
    """Several certificates, in an order that does not depend on that of `paths`: by name, version and target.

    Codes of the same name and version are numbered, from 1. Raises LeakrefError as `read` does, and for fewer than two.
    """
    if len(paths) < 2:
        raise LeakrefError(
            "compare",
            f"{len(paths) or 'no'} certificate was given, and one has nothing beside it",
            "name two or more; `leakref certify --report` writes a page of one",
        )
    codes = sorted((read(path) for path in paths), key=_place)
    labels = [code.label for code in codes]
    several = {label for label in labels if labels.count(label) > 1}
    return [replace(c, number=labels[: n + 1].count(c.label) * (c.label in several)) for n, c in enumerate(codes)]


def _place(code: Code) -> tuple[str, ...]:
    return code.name.casefold(), code.version, *map(code.setting, ("target", "date")), dump(code.record), code.file


def _asked(codes: Sequence[Code], family: str) -> list[str]:
    """Ids of all findings that any code has in a family, in the order of the certificate that has most of them."""
    longest = sorted(codes, key=lambda code: -len(code.verdicts))
    return list(dict.fromkeys(f["id"] for code in longest for f in code.record["findings"] if f["family"] == family))


def differing(codes: Sequence[Code]) -> list[str]:
    """Ids of the findings whose verdicts differ between codes, in the order of the families.

    Only codes that have a finding count for it: one that was not asked does not differ.
    """
    ids = [identifier for family in FAMILIES for identifier in _asked(codes, family)]
    return [one for one in ids if len({code.verdicts[one] for code in codes if one in code.verdicts}) > 1]


def unlike(codes: Sequence[Code]) -> list[str]:
    """What was not the same for all codes, and what that means for comparing them: sentences, none if all was alike."""
    told = {name: _told({code: code.setting(name) for code in codes}) for name in _SETTINGS}
    found = [sentence.format(told[name]) for name, sentence in _SETTINGS.items() if told[name]]
    everything = {identifier for code in codes for identifier in code.verdicts}
    common = {identifier for identifier in everything if all(identifier in code.verdicts for code in codes)}
    if common != everything:
        counts = _told({code: str(len(code.verdicts)) for code in codes}) or f"{len(codes[0].verdicts)} each"
        found.append(
            f"Not asked the same questions: {counts}; {len(common) or 'none'} of {len(everything)} were asked of all. "
            "What a code was not asked speaks neither for nor against it."
        )
    for code in codes:
        if code.record.get("complete") is False or code.record.get("cut_short"):
            found.append(f"The run of {code.label} was cut short: {code.setting('cut_short')}.")
    return found


def _told(values: Mapping[Code, str]) -> str:
    """Which codes have which value, the one that most have last; empty where it is the same for all."""
    groups: dict[str, list[str]] = {}
    for code, value in values.items():
        groups.setdefault(value, []).append(code.label)
    *few, (most, rest) = sorted(groups.items(), key=lambda group: (len(group[1]), group))
    last = f"{most} for {'the others' if len(rest) > 1 else rest[0]}"
    return "; ".join([*(f"{value} for {', '.join(labels)}" for value, labels in few), last]) if few else ""


def page(codes: Sequence[Code]) -> str:
    """One self-contained page of HTML, which holds everything without its script; that sorts and filters.

    A table of codes by families on top, then what each certificate says of its code, then the findings family by
    family: where codes differ, and of each code what fell short, with the rest folded away.
    """
    differ = set(differing(codes))
    families = [_family(codes, family, differ) for family in FAMILIES if any(c.cell(family).asked for c in codes)]
    return template("comparison.html").render(
        codes=list(enumerate(codes, start=1)),
        families=families,
        unlike=unlike(codes),
        differ=differ,
        settings=_settings(codes[0]),
        count=sum(len(family["ids"]) for family in families),
        offered=sum(len(family["offered"]) for family in families),
        grades=[CONFORMANT, SOUND, REJECTED, NO_GRADE],  # in this order they are sorted
        version=__version__,
    )


def _settings(code: Code) -> str:
    """How a code was asked: by which leakref, with what. A seed that is not said is left out."""
    said = f"leakref {code.setting('version')}, golden set {code.setting('golden')}, {code.setting('profile')} profile"
    return said + f", seed {code.setting('seed')}" * (code.setting("seed") != _NOT_SAID)


def _family(codes: Sequence[Code], family: str, differ: set[str]) -> dict[str, Any]:
    """What the template needs of a family. Those in `offered` differ only in that some codes offer no answer."""
    ids = _asked(codes, family)
    rows: dict[bool, list[Any]] = {True: [], False: []}
    for one in ids:
        if one in differ:
            row = [_verdict(code, one) for code in codes]
            rows[len({verdict for _, verdict in row} - {"not offered", "not asked"}) > 1].append((one, row))
    return {
        "name": family,
        "title": FAMILIES[family],
        "ids": ids,
        "anchors": {one: number for number, one in enumerate(ids, start=1)},
        "cells": [code.cell(family, ids) for code in codes],
        "findings": [_findings(code, family) for code in codes],
        "differ": rows[True],
        "offered": rows[False],
    }


def _verdict(code: Code, identifier: str) -> tuple[str, str]:
    """The kind, as of a cell, and the words of one verdict in a table."""
    verdict = code.verdicts.get(identifier)
    if verdict in (None, Verdict.UNSUPPORTED):
        return ("offered-not", "not offered") if verdict else ("asked-not", "not asked")
    return ("wrong" if verdict in WRONG else "held" if verdict == Verdict.PASS else "missing"), str(verdict)


def _findings(code: Code, family: str) -> list[dict[str, Any]]:
    """The findings of a code in a family; those that are not `short` are folded away."""
    known = {one["id"]: f"{one['reason']} ({one['issue']})" for one in code.record["known"]}
    return [
        {**f, "known": known.get(f["id"], ""), "short": f["verdict"] in (*WRONG, Verdict.MISSING)}
        for f in code.record["findings"]
        if f["family"] == family
    ]


def run(paths: Sequence[Path], out: Path, *, json: bool = False) -> bool:
    """The whole of `leakref compare`: read, write `comparison.html` in the folder `out`, print.

    With `json` an envelope goes to standard output, else a table of families by codes. LeakrefError is raised before
    anything is written. It always holds: a code that is rejected is no fault of a comparison.
    """
    codes = read_all(paths)
    text, place = page(codes), folder(out) / "comparison.html"
    write_whole(place, lambda path: path.write_text(text, encoding="utf-8", newline="\n"))
    if json:
        rows = [
            {"name": code.name, "version": code.version, "wrong": code.cell().wrong, "coverage": code.coverage}
            | {name: code.record[name] for name in ("target", "grade")}
            for code in codes
        ]
        print(dump(envelope("compare", True, path=place, codes=rows, differs=differing(codes), unlike=unlike(codes))))
    else:
        _print(codes, place)
    return True


def _print(codes: Sequence[Code], place: Path) -> None:
    """Families by codes: on a terminal there is more room downwards."""
    show, table = Console(), Table("family")
    colour = {"held": "green", "wrong": "red", "missing": "yellow", "offered-not": "dim", "asked-not": "dim"}
    for code in codes:
        table.add_column(escape(code.label), overflow="fold")
    table.add_row("grade", *(code.grade_line for code in codes), end_section=True)
    for family in FAMILIES:
        cells = [code.cell(family) for code in codes]
        if any(cell.asked for cell in cells):
            table.add_row(family, *(f"[{colour[cell.kind]}]{cell.words}[/]" for cell in cells))
    show.print(table)
    for sentence in unlike(codes):
        show.print(f"[yellow]Mind:[/] {escape(sentence)}", soft_wrap=True)
    show.print(
        f"Findings that differ between codes: {len(differing(codes))}. Page: {escape(str(place))}", soft_wrap=True
    )
