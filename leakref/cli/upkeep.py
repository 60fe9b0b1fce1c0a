"""Commands about speed, and about bias over versions."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Annotated

import typer

from leakref.cli.base import (
    HISTORY,
    PAPERS,
    UPKEEP,
    HistoryFile,
    Json,
    Program,
    StartTimeout,
    Target,
    Timeout,
    Workers,
    command,
    methods_named,
    track_app,
)

__all__ = ["bench", "track_check", "track_compare", "track_null", "track_plot", "track_record"]


@command(UPKEEP)
def bench(
    out: Annotated[Path, typer.Option(help="Folder for the table and the picture.")] = Path("leakref-bench"),
    json: Json = False,
) -> bool:
    """Timings of every stage, as ratios within one run (a few minutes)."""
    from leakref.bench import run

    return run(out, json=json)


@command(None, "record", track_app)
def track_record(
    target: Target = None,
    program: Program = None,
    label: Annotated[str | None, typer.Option(help="What this version is called; default: as the target says.")] = None,
    path: HistoryFile = HISTORY,
    case: Annotated[
        list[str] | None,
        typer.Option(
            help="A configuration (`leakref reproduce --list`), or one of the "
            "coarser seas broad, directional, peaked, following, narrow, "
            "crossing, small; may be repeated. Default: nsp-ls and one of "
            "U for the reference, else broad and following."
        ),
    ] = None,
    realizations: Annotated[int, typer.Option(min=2, help="How many of each case.")] = 100,
    first: Annotated[int, typer.Option(min=0, help="The first of them.")] = 0,
    source: Annotated[
        list[Path] | None,
        typer.Option(help="A file or folder that also belongs to the source of what is measured; may be repeated."),
    ] = None,
    timings: Annotated[Path | None, typer.Option(help="JSON of pytest-benchmark, to be recorded with it.")] = None,
    yardstick: Annotated[str | None, typer.Option(help="The benchmark in it that the others are divided by.")] = None,
    timeout: Timeout = None,
    start_timeout: StartTimeout = None,
    memory: Annotated[float, typer.Option(min=0.01, help="GiB that the program may hold.")] = 8.0,
    workers: Annotated[int, typer.Option(min=0, help="Processes, for the reference; 0: one for each core.")] = 0,
    methods: Annotated[str, typer.Option(help="Of the reference; another target has those it declares.")] = PAPERS,
    json: Json = False,
) -> int:
    """Measure a version and append it to the history."""
    from leakref.track.commands import Request, run_record

    return run_record(
        Request(
            target,
            program,
            path,
            label,
            case or [],
            realizations,
            first,
            source or [],
            timings,
            yardstick,
            timeout,
            memory,
            workers or os.cpu_count() or 1,
            start_timeout,
            methods_named(methods, "track"),
        ),
        json=json,
    )


@command(None, "compare", track_app)
def track_compare(
    first: Annotated[
        str,
        typer.Argument(
            metavar="A", help="last, previous, a label (the last of that name) or the beginning of a digest."
        ),
    ],
    second: Annotated[str, typer.Argument(metavar="B", help="Likewise: better or worse than A?")],
    path: HistoryFile = HISTORY,
    margin: Annotated[
        float, typer.Option(min=0.0, help="A change within this share of the smaller velocity resolution is none.")
    ] = 0.01,
    json: Json = False,
) -> int:
    """Has the bias risen? Exit status 1 if it has, beyond the margin; 3 if nothing could be compared."""
    from leakref.track.commands import run_compare

    return run_compare(first, second, path, margin=margin, json=json)


@command(None, "plot", track_app)
def track_plot(
    path: HistoryFile = HISTORY,
    case: Annotated[list[str] | None, typer.Option(help="Only this case; may be repeated.")] = None,
    target: Annotated[str | None, typer.Option(help="Whose versions; default: of the last entry's target.")] = None,
    out: Annotated[Path, typer.Option(help="Folder for the page and the pictures.")] = Path("leakref-track"),
    json: Json = False,
) -> int:
    """Bias against version, with its steps, and against wavenumber: a page and pictures."""
    from leakref.track.commands import run_plot

    return run_plot(path, cases=case or [], target=target, out=out, json=json)


@command(None, "null", track_app)
def track_null(
    out: Annotated[
        Path | None, typer.Option(help="File for the JSON; the committed one is golden/tracking.json.")
    ] = None,
    place: Annotated[Path, typer.Option("--folder", help="Where realisations are kept, as by reproduce --out.")] = Path(
        "leakref-results"
    ),
    workers: Workers = 0,
    json: Json = False,
) -> bool:
    """How often compare raises a false alarm, and what it sees: 2,150 comparisons without a change (half an hour)."""
    from leakref.track.falsealarms import run

    return run(out, place=place, workers=workers or os.cpu_count() or 1, json=json)


@command(None, "check", track_app)
def track_check(path: HistoryFile = HISTORY, json: Json = False) -> bool:
    """Is the history as it was written? Nothing edited, cut off, repeated or missing."""
    from leakref.track.commands import run_check

    return run_check(path, json=json)
