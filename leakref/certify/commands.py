"""The commands that judge a code: certify, explain; what they print and write.

`run` is the whole of `leakref certify`: it refuses what cannot be right before anything is started, runs the checks
with a progress bar, has failures explained and, in the full profile, bias and stress measured, then prints and writes.
What has been found is printed even if it is interrupted on the way. Help texts and options are in `leakref.cli`.
"""

from __future__ import annotations

import secrets
import shlex
from base64 import b64encode
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from time import perf_counter
from typing import Any

from rich.console import Console
from rich.markup import escape

from leakref._base import LeakrefError
from leakref._output import console, dump, envelope, folder, progress_bar, write_whole
from leakref._tables import Table
from leakref.certify.certificate import REJECTED, SOUND, Certificate, junit, schema
from leakref.certify.checks.draw import PUBLISHED, Draw
from leakref.certify.runner import CutShort, certify, select
from leakref.certify.strength.diagnosis import explain
from leakref.certify.subject.protocol import ProcessSubject
from leakref.certify.targets import HarnessBroken, Limits, connect
from leakref.certify.verdict import Verdict, read_known
from leakref.golden.sets import NEWEST, locate
from leakref.planning.quantities import quantity

__all__ = ["Request", "give", "named", "run", "seed_of", "show_list", "show_schema"]

_COLOUR = {
    Verdict.PASS: "green",
    Verdict.FAIL: "red",
    Verdict.ERROR: "red",
    Verdict.TIMEOUT: "red",
    Verdict.MISSING: "yellow",
    Verdict.UNSUPPORTED: "dim",
}
_SHOWN = 20
"""Failures printed in full; the rest are in the JSON and the report."""


@dataclass(frozen=True)
class Request:
    """What was asked on the command line.

    - `target` or `command`: one of the two, as typed.
    - `profile`: `quick` or `full`; `only`: patterns as for `select`; `golden`: the number of the set.
    - `report`: folder for the page, the badge, JSON and JUnit XML; None writes none.
    - `known`: TOML file of known failures; `keep`: folder in which exchanged files stay.
    - `timeout`, `start`: seconds for one run and for the start; None leaves the defaults of `Limits`.
    - `memory`: GiB, of the program with all it has started; `workers`: sessions side by side.
    - `deep`: whether pairs of faults are tried in the diagnosis; `diagnosis`: whether there is to be one at all.
    - `waves`: the shortest and the longest that the code is made for, as typed, in place of what it declares.
    - `seed`: of the questions that are drawn, as typed: a number, or `fresh` for one of the machine's choice.
    """

    target: str | None
    command: str | None
    profile: str = "quick"
    only: Sequence[str] = ()
    report: Path | None = None
    known: Path | None = None
    golden: int = NEWEST
    timeout: float | None = None
    memory: float = 8.0
    workers: int = 2
    keep: Path | None = None
    deep: bool = False
    start: float | None = None
    seed: str = str(PUBLISHED)
    diagnosis: bool = True
    waves: str | None = None

    @property
    def given_waves(self) -> dict[str, Any]:
        """What `waves`, such as 0.5m:4m, is in a declaration; nothing if it was not given. Raises LeakrefError."""
        if self.waves is None:
            return {}
        ends = self.waves.split(":")
        if len(ends) != 2:
            raise LeakrefError("certify", f"--waves {self.waves} are not two wavelengths", "write --waves 0.5m:4m")
        short, long = (quantity("certify", "--waves", end, "m", "0.5m:4m") for end in ends)
        if not 0 < short < long:
            raise LeakrefError("certify", f"--waves {self.waves} do not go from short to long", "write --waves 0.5m:4m")
        return {"peak_wavelength": [short, long]}


def seed_of(given: str) -> int:
    """The seed that is meant: the number, or for `fresh` one that nobody knows before. Raises LeakrefError."""
    if given == "fresh":
        return 2 + secrets.randbelow(2**31)
    try:
        return Draw(int(given)).seed
    except ValueError:
        raise LeakrefError("certify", f"the seed is {given!r}", "give a whole number from 0 on, or fresh") from None


def show_list(profile: str, only: Sequence[str], *, json: bool) -> int:
    """Print the ids of all findings there can be.

    With `json` they are the `ids` of an envelope, else lines. The exit status is 0, or 3 if there are none.
    """
    ids = [f"{check.id}[{case.id}]" for check, case in select(only, profile=profile)]
    print(dump(envelope("certify", bool(ids), ids=ids)) if json else "\n".join(ids))
    return 0 if ids else 3


def show_schema() -> None:
    """Print the JSON schema of the certificate."""
    print(dump(schema()))


def run(request: Request, *, json: bool = False) -> int:
    """Certify, print, write; the exit status (guide protocol, section 13). With `json` the certificate goes to standard
    output, else a table and what fell short.

    LeakrefError is raised before anything runs: for no target or two, a command that cannot be split, a golden set that
    is not there, a list of known failures that cannot be read, a report folder that cannot be made. A program that does
    not answer is status 3, with its last words. KeyboardInterrupt is passed on after what there is has been printed.
    """
    if (request.target is None) == (request.command is None):
        given = "no target" if request.target is None else "a target and a --command"
        raise LeakrefError(
            "certify",
            f"{given} was given",
            'name package.module:object, reference, fault:ID or variant:ID, or pass --command "program arguments"',
        )
    if request.target is not None and not request.target.strip():
        raise LeakrefError("certify", "the target is empty", "an empty variable? Name what is to be certified")
    command = _split(request.command) if request.command is not None else None
    locate(request.golden)
    known = read_known(request.known) if request.known else {}
    if request.report:
        folder(request.report)
    seed = seed_of(request.seed)
    if seed != PUBLISHED:
        console().print(f"Seed {seed}: the same questions again with --seed {seed}")
    checks = select(request.only, profile=request.profile, golden=request.golden, seed=seed)
    if not checks:
        console().print(
            f"[red]Nothing to run:[/] no check of the {request.profile} profile matches "
            f"{', '.join(map(escape, request.only))}."
        )
        return 3
    limits = Limits.given(
        request.timeout, request.start, request.memory, run=600.0 if request.profile == "full" else 120.0
    )
    sessions = [
        connect(request.target, command, limits=limits, keep=request.keep, waves=request.given_waves)
        for _ in range(min(max(1, request.workers), len(checks)))
    ]
    name = request.target or str(request.command)
    start = perf_counter()
    try:
        with progress_bar(f"checks of {name}", len(checks)) as step:
            found = certify(
                name,
                sessions,
                checks,
                profile=request.profile,
                golden=request.golden,
                seed=seed,
                only=request.only,
                known=known,
                after_each=lambda finding: step(),
            )
    except CutShort as cut:
        give(named(cut.certificate, request), request.report, json=json)
        raise
    except HarnessBroken as broken:
        console().print(f"[red]Could not judge:[/] {escape(str(broken))}", soft_wrap=True)
        return 3
    found = named(found, request)
    pictures: list[dict[str, Any]] = []
    try:
        if found.wrong and request.diagnosis:
            with progress_bar("faults and repairs tried on what fell short", None) as step:
                again = connect(
                    request.target, command, limits=limits, waves=request.given_waves
                )  # the first has ended
                found = explain(found, again, deep=request.deep, after_each=step)
        if request.profile == "full" and found.grade is not None and not request.only:
            session = connect(request.target, command, limits=limits, waves=request.given_waves)
            found, pictures = _measured(found, session)
    except KeyboardInterrupt:  # what has been found is not lost
        found = replace(found, cut_short="interrupted when all had been asked, before it was looked into further")
    found = replace(found, seconds=perf_counter() - start)
    give(found, request.report, pictures, json=json)
    if found.cut_short:
        raise KeyboardInterrupt
    return found.status


def give(
    found: Certificate, report: Path | None, pictures: Sequence[Mapping[str, Any]] = (), *, json: bool = False
) -> None:
    """Print and write what there is, all of it or what was found before somebody lost patience. `report` is the folder
    for page, badge, JSON and JUnit XML; with `json` the certificate is printed as JSON.
    """
    written = _write(found, report, pictures)
    if found.cut_short:
        console().print(f"[yellow]Cut short:[/] {found.cut_short}")
    if json:
        print(dump(found.record()))
    else:
        _print(found, written, found.only)


def named(found: Certificate, request: Request) -> Certificate:
    """With what was asked for in the lines that show a finding, or all of it, again, quoted as a shell needs it."""
    said = shlex.quote(request.target) if request.target else f"--command {shlex.quote(str(request.command))}"
    said += f" --waves {shlex.quote(request.waves)}" if request.waves else ""
    only = "".join(f" --only {shlex.quote(one)}" for one in request.only)
    return replace(
        found,
        findings=[replace(f, repro=f.repro.replace("TARGET", said)) for f in found.findings],
        again=f"leakref certify {said}{only} --profile {found.profile} --golden {found.set_number} --seed {found.seed}",
    )


def _split(command: str) -> list[str]:
    """The argument list of `--command`, split as a shell does. Raises LeakrefError for open quotes, and for nothing at
    all.
    """
    try:
        words = shlex.split(command)
    except ValueError as error:
        raise LeakrefError("certify", f"--command cannot be split ({error})", "quote it as for a shell") from None
    if not words:
        raise LeakrefError("certify", "--command is empty", "an empty variable? Name a program")
    return words


def _measured(found: Certificate, session: ProcessSubject) -> tuple[Certificate, list[dict[str, Any]]]:
    """With how biased it is, sea by sea, what poor sensors make of it, and pictures of both for the page. In a session
    of its own, since the one of the checks has ended. Nothing is measured where it offers no velocities.
    """
    from leakref.certify.measures import stress, stressfigure
    from leakref.certify.measures.bias import REALIZATIONS, SCALES, SEAS, bias, figure

    if "extract" not in found.declaration["can"]:
        return found, []
    pictures: list[dict[str, Any]] = []
    cubes = len(SEAS) * len(SCALES) * REALIZATIONS
    with session as subject:
        with progress_bar("seas, for the bias", cubes) as step:
            rows = bias(subject, after_each=step)
        with progress_bar("seas as poor sensors see them", stress.CUBES) as step:
            stresses = stress.stress(subject, after_each=step)
    if rows:
        words = "; ".join(f"{row.sea.name}, scale {row.scale:g}: {row.words}" for row in rows)
        pictures.append({"title": "How biased it is", "words": f"{words}.", "data": b64encode(figure(rows)).decode()})
    if stresses:
        pictures.append(stressfigure.picture(stresses))
    found = replace(found, bias=[row.record() for row in rows], stress=[one.record() for one in stresses])
    return found, pictures


def _write(found: Certificate, report: Path | None, pictures: Sequence[Mapping[str, Any]]) -> list[Path]:
    """The certificate as a page, a badge, JSON and JUnit XML; the paths written."""
    if report is None:
        return []
    from leakref.certify.report import badge, page

    files = {
        "certificate.html": page(found, pictures),
        "certificate.json": dump(found.record()) + "\n",
        "junit.xml": junit(found),
        "badge.svg": badge(found),
    }
    return [write_whole(report / name, partial(_write_text, text)) for name, text in files.items()]


def _write_text(text: str, path: Path) -> None:
    path.write_text(text, encoding="utf-8", newline="\n")


def _print(found: Certificate, written: Sequence[Path], only: Sequence[str]) -> None:
    """The table, what is wrong with its reason and how to see it again, bias and stress, known and stale failures, the
    diagnosis, and at the end the grade in words. A reason is printed once for each check, however many of its cases
    fell short.
    """
    show = Console()
    show.print(_summary(found))
    reasons = {c.id: c.reason for c, _ in select(golden=found.set_number)}
    colour = "yellow" if found.grade == SOUND else "red"  # it only differs
    told = set()
    for finding in found.unexpected[:_SHOWN]:
        over = "" if finding.over is None else f" ({finding.over:.3g} times the tolerance)"
        show.print(
            f"[{colour}]{finding.verdict}[/] [bold]{escape(finding.id)}[/]{over}\n  {escape(finding.message)}",
            soft_wrap=True,
        )
        check = finding.id.partition("[")[0]
        if check not in told:  # the same for all cases of a check
            told.add(check)
            if check in reasons:
                show.print(f"  [dim]why: {escape(reasons[check])}[/]", soft_wrap=True)
            show.print(f"  [dim]again: {escape(finding.repro)}[/]", soft_wrap=True)
    if len(found.unexpected) > _SHOWN:
        show.print(f"... and {len(found.unexpected) - _SHOWN} more; --json or --report has all of them.")
    for row in found.bias:
        show.print(f"bias, {escape(row['sea'])} sea, scale {row['scale']:g}: {escape(row['words'])}", soft_wrap=True)
    for row in found.stress:
        show.print(f"stress, {escape(row['words'])}", soft_wrap=True)
    for finding in found.findings:
        if finding.id in found.known and finding.verdict is not Verdict.PASS:
            known = found.known[finding.id]
            show.print(f"[yellow]known[/] {escape(finding.id)}: {escape(known.reason)} ({escape(known.issue)})")
    for one in found.stale:
        show.print(f"[red]out of date[/] {escape(one.id)} is listed as a known failure and passes; take it off.")
    if found.explanation:
        show.print(f"[bold]Diagnosis:[/] {escape(found.explanation)}", soft_wrap=True)
    if found.departs_at:
        show.print(f"It departs from the reference at its {found.departs_at}.")
    show.print(_sentence(found), soft_wrap=True)
    if only and found.grade == REJECTED and all(f.family == "conformance" for f in found.wrong):
        show.print(
            "Of the checks named by --only: beside all others, conformance by itself rejects no code.", soft_wrap=True
        )
    for path in written[:1]:
        show.print(f"Page: {path}; beside it {', '.join(other.name for other in written[1:])}", soft_wrap=True)


def _summary(found: Certificate) -> Table:
    """Counts of verdicts by family, and the fewest digits to which a number agreed there."""
    said = found.declaration
    frame = f"{said['units']}, axes {said['axes']}, y {said['y']}, direction {said['direction']}"
    if said["fixed"]:
        frame += f", fixed: {', '.join(said['fixed'])}"
    table = Table(title=escape(f"{said['name']} {said['version']}".strip()), caption=escape(frame))
    table.add_column("family")
    for verdict in Verdict:
        table.add_column(str(verdict), justify="right", style=_COLOUR[verdict])
    table.add_column("fewest digits", justify="right")
    for family, counts in found.families():
        digits = [f.digits for f in found.findings if f.family == family and f.digits is not None]
        table.add_row(
            family, *(str(counts.get(str(verdict), "")) for verdict in Verdict), f"{min(digits):.1f}" if digits else ""
        )
    return table


def _sentence(found: Certificate) -> str:
    """The grade in words."""
    from leakref.certify.report import sentence

    colour = "green" if found.ok and found.grade != REJECTED else "red"
    return (
        f"[{colour} bold]{escape(found.grade_line)}[/]: {sentence(found)}\n{escape(found.scope()['words'])} "
        f"Golden set {found.golden}, {found.profile} profile, seed {found.seed}, {found.seconds:.0f} s."
        + _examined(found.examination)
    )


def _examined(about: Mapping[str, Any]) -> str:
    """That nobody saw the code at work, and which questions and answers it was; empty where it ran."""
    if not about:
        return ""
    answered = f"{about['answered']} of {about['questions']} questions answered"
    return (
        f"\nBy examination: {answered}; digest of the questions {about['digest']}, of the answers {about['answers']}."
    )
