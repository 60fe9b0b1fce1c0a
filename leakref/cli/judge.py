"""Commands that judge a code."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Annotated

import typer

from leakref.cli.base import (
    JUDGE,
    NEWEST_GOLDEN,
    GoldenNumber,
    Json,
    Program,
    StartTimeout,
    Target,
    Timeout,
    Workers,
    command,
)

__all__ = ["certify", "compare", "explain", "guide", "scaffold", "strength"]


@command(JUDGE)
def certify(
    target: Target = None,
    program: Program = None,
    profile: Annotated[str, typer.Option(help="quick (about a minute) or full (about ten).")] = "quick",
    only: Annotated[
        list[str] | None, typer.Option(help="A finding, check or family, or a pattern; may be repeated.")
    ] = None,
    report: Annotated[Path | None, typer.Option(help="Folder for the certificate: JSON and JUnit XML.")] = None,
    known: Annotated[Path | None, typer.Option(help="Known failures: TOML, id = {reason, issue}.")] = None,
    golden: GoldenNumber = NEWEST_GOLDEN,
    timeout: Timeout = None,
    start_timeout: StartTimeout = None,
    memory: Annotated[float, typer.Option(min=0.01, help="GiB that the program may hold.")] = 8.0,
    workers: Annotated[int, typer.Option(min=0, help="Sessions side by side; 0: one for each core.")] = 0,
    waves: Annotated[
        str | None, typer.Option(metavar="SHORT:LONG", help="Waves that it is made for, 0.5m:4m: asked in these.")
    ] = None,
    keep: Annotated[Path | None, typer.Option(help="Keep what is exchanged with the program in this folder.")] = None,
    deep: Annotated[bool, typer.Option("--deep", help="Diagnosis: try pairs of faults as well (minutes).")] = False,
    diagnosis: Annotated[bool, typer.Option(help="Have failures explained.")] = True,
    seed: Annotated[
        str, typer.Option(metavar="N|fresh", help="Draw seas, phases, currents; 1: the published questions.")
    ] = "1",
    listing: Annotated[bool, typer.Option("--list", help="Print the ids of all findings and stop.")] = False,
    schema: Annotated[bool, typer.Option("--schema", help="Print the certificate's JSON schema and stop.")] = False,
    json: Json = False,
) -> int:
    """Is this code right? Its signs, axes, scales, leakage and digits; a grade, and what fell short."""
    from leakref import LeakrefError
    from leakref.certify import commands

    if profile not in ("quick", "full"):
        raise LeakrefError("certify", f"no profile {profile!r}", "choose quick or full")
    if schema:
        commands.show_schema()
        return 0
    if listing:
        return commands.show_list(profile, only or [], json=json)
    return commands.run(
        commands.Request(
            target,
            program,
            profile,
            only or [],
            report,
            known,
            golden,
            timeout,
            memory,
            workers or os.cpu_count() or 1,
            keep,
            deep,
            start_timeout,
            seed,
            diagnosis,
            waves,
        ),
        json=json,
    )


@command(JUDGE)
def compare(
    certificates: Annotated[
        list[Path], typer.Argument(metavar="CERTIFICATE", help="Two or more files certificate.json.")
    ],
    out: Annotated[Path, typer.Option(help="Folder for the page, comparison.html.")],
    json: Json = False,
) -> bool:
    """Certificates side by side: a page of which code holds where, and in what they differ."""
    from leakref.certify.comparison import run

    return run(certificates, out, json=json)


@command(JUDGE)
def strength(
    full: Annotated[
        bool,
        typer.Option(
            "--full",
            help="The whole matrix, 1,000 other seeds, the rate of false alarms: up "
            "to an hour and a half; it goes on where it stopped.",
        ),
    ] = False,
    out: Annotated[Path, typer.Option(help="Folder for the result and what it is resumed from.")] = Path(
        "leakref-results/strength"
    ),
    workers: Workers = 0,
    json: Json = False,
) -> int:
    """What the checks catch: every fault planted, every correct variant passed, and what is rejected wrongly."""
    from leakref.certify.strength.study import run

    return run(full=full, out=out, workers=workers or os.cpu_count() or 1, json=json)


@command(JUDGE)
def scaffold(
    kind: Annotated[str, typer.Argument(help="python, octave, shell or cpp: an adapter; ci: files for CI.")],
    place: Annotated[Path, typer.Argument(metavar="DIR", help="Folder to write it to.")],
    json: Json = False,
) -> bool:
    """A working adapter for a code in some language, or CI files, to start from."""
    from leakref._output import dump, envelope
    from leakref.certify.scaffold import NEXT, write

    paths = write(kind, place)
    if json:
        typer.echo(dump(envelope("scaffold", True, paths=paths, next=NEXT[kind])))
    else:
        typer.echo("\n".join(map(str, paths)) + f"\nNext, in {place}: {NEXT[kind]}")
    return True


@command(JUDGE)
def explain(
    identifier: Annotated[
        str | None,
        typer.Argument(
            metavar="[ID]",
            help="Of a check, fault, variant, claim, decision, golden value. None prints which there are.",
        ),
    ] = None,
    json: Json = False,
) -> bool:
    """What an id stands for, in words: why a check is there, what a fault is, how a claim is tested."""
    from leakref.explain import run

    return run(identifier, json=json)


@command(JUDGE)
def guide(
    topic: Annotated[str | None, typer.Argument(metavar="[TOPIC]", help="None prints which there are.")] = None,
    json: Json = False,
) -> bool:
    """Short guides: a certificate read, a code of yours plugged in, pytest and CI, bias over versions."""
    from leakref.guides import run

    return run(topic, json=json)
