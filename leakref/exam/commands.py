"""`leakref exam write` and `leakref exam grade`: what they refuse, print and write."""

from __future__ import annotations

import json as jsonlib
from collections.abc import Mapping
from pathlib import Path

from rich.console import Console
from rich.markup import escape

from leakref._base import LeakrefError, refusal
from leakref._output import console, dump, envelope, folder, progress_bar
from leakref.certify.commands import give, seed_of
from leakref.certify.runner import select
from leakref.certify.subject.declaration import Declaration
from leakref.certify.verdict import Unanswered
from leakref.exam import answers, storing
from leakref.exam.folder import lay_down, load
from leakref.exam.marking import mark, recognise
from leakref.golden.sets import locate

__all__ = ["declared", "grade", "write"]


def declared(path: Path | None) -> Declaration:
    """The declaration in a file, the fields of "ready" as JSON (guide protocol, section 3); without one the default.
    Raises LeakrefError.
    """
    if path is None:
        return Declaration()
    remedy = 'write an object such as {"units": "si", "can": {"extract": {"methods": ["nsp"], "windows": ["hann"]}}}'
    try:
        given = jsonlib.loads(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise refusal("exam write", f"{path} cannot be read ({error.strerror})", remedy, error) from None
    except (ValueError, RecursionError) as error:
        raise LeakrefError("exam write", f"{path} is not JSON ({error})", remedy) from None
    if not isinstance(given, Mapping):
        raise LeakrefError("exam write", f"{path} holds no object", remedy)
    try:
        return Declaration.read({name: value for name, value in given.items() if name not in ("op", "protocol")})
    except Unanswered as wrong:
        raise LeakrefError("exam write", f"{path} {wrong.message}", remedy) from None


def write(
    place: Path, form: str, profile: str, seed: str, declare: Path | None, golden: int, *, json: bool = False
) -> bool:
    """Lay an examination down in `place`; returns True. Raises LeakrefError before anything is made."""
    storing.format_named("exam write", form)
    if profile not in ("quick", "full"):
        raise LeakrefError("exam write", f"no profile {profile!r}", "choose quick or full")
    declaration, number = declared(declare), seed_of(seed)
    locate(golden)
    with progress_bar("questions", len(select(profile=profile, golden=golden, seed=number))) as step:
        record = lay_down(place, declaration, form, profile=profile, golden=golden, seed=number, after_each=step)
    size = sum(file.stat().st_size for file in place.rglob("*") if file.is_file())
    asked = len(record["questions"])
    if json:
        said = envelope("exam", True, action="write", path=place, questions=asked, bytes=size, digest=record["digest"])
        print(dump({**said, "seed": number, "unsupported": record["unsupported"]}))
        return True
    show = Console()
    words = f"{declaration.units} units, axes {declaration.axes}, y {declaration.y}, direction {declaration.direction}"
    methods = f"methods {', '.join(declaration.methods)}" if declaration.methods else "no method named"
    offered = f"offers {', '.join(declaration.can)}; {methods}; windows {', '.join(declaration.windows)}"
    show.print(f"{asked} questions, {size / 1e6:.0f} MB, in {escape(str(place))}; seed {number}.", soft_wrap=True)
    taken = "as the file declares it" if declare else "by default; --declare FILE says otherwise"
    show.print(f"Of the code is taken, {taken}: {escape(words)}; {escape(offered)}.", soft_wrap=True)
    told = ", ".join(record["unsupported"])
    show.print(f"Only watching could tell, and is not asked: {escape(told)}; time and memory.", soft_wrap=True)
    show.print(
        f"Next: {escape(str(place / 'README.md'))}, then leakref exam grade {escape(str(place))}", soft_wrap=True
    )
    return True


def grade(place: Path, report: Path | None, workers: int, *, json: bool = False) -> int:
    """Mark what was answered so far; the exit status, as of certify. Nothing in `place` is changed: it can be repeated.

    Raises LeakrefError for questions that are not as they were written, and for answers that cannot be theirs.
    """
    if not place.is_dir():
        raise LeakrefError("exam grade", f"there is no folder {place}", "name one that `leakref exam write` wrote")
    sheet = load(place)
    given = answers.read(place, sheet)
    checks = select(**sheet.asked)
    if report:
        folder(report)
    with progress_bar("questions made again", len(checks)) as step:
        made = recognise(place, sheet, step)
    with progress_bar("answers marked", len(checks)) as step:
        found = mark(place, sheet, given, made, workers=workers, after_each=lambda finding: step())
    left = len(made) - len(given.by_id)
    if left and not json:
        console().print(f"{left} of {len(made)} questions are not answered yet, and count as missing.")
    give(found, report, json=json)
    return found.status
