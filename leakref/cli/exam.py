"""Commands for an examination by files."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Annotated

import typer

from leakref.cli.base import NEWEST_GOLDEN, GoldenNumber, Json, Workers, command, exam_app

__all__ = ["exam_grade", "exam_write"]

Place = Annotated[Path, typer.Argument(metavar="DIR", help="The folder of the examination.")]


@command(None, "write", exam_app)
def exam_write(
    place: Place,
    form: Annotated[
        str, typer.Option("--format", help="Of the arrays: raw (for all runners), mat, npz or netcdf.")
    ] = "raw",
    profile: Annotated[str, typer.Option(help="quick (some 150 questions, 140 MB) or full.")] = "quick",
    seed: Annotated[
        str, typer.Option(metavar="N|fresh", help="Draw seas, phases, currents; 1: the published questions.")
    ] = "1",
    declare: Annotated[
        Path | None, typer.Option(help='What the code expects: JSON, the fields of "ready" (guide protocol).')
    ] = None,
    golden: GoldenNumber = NEWEST_GOLDEN,
    json: Json = False,
) -> bool:
    """The questions of certify as a folder, with runners in MATLAB, C++ and R; no answers in it."""
    from leakref.exam.commands import write

    return write(place, form, profile, seed, declare, golden, json=json)


@command(None, "grade", exam_app)
def exam_grade(
    place: Place,
    report: Annotated[Path | None, typer.Option(help="Folder for the certificate: JSON and JUnit XML.")] = None,
    workers: Workers = 0,
    json: Json = False,
) -> int:
    """Marks for what was answered so far, as a certificate; unanswered questions are missing."""
    from leakref.exam.commands import grade

    return grade(place, report, workers or os.cpu_count() or 1, json=json)
