"""Commands about the paper."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Annotated

import typer

from leakref.cli.base import PAPER, PAPERS, Json, Methods, command, methods_named

__all__ = ["claims", "demo", "reproduce"]


@command(PAPER)
def demo(
    out: Annotated[Path, typer.Option(help="Folder for the picture and the table.")] = Path("leakref-demo"),
    json: Json = False,
) -> bool:
    """The first run: a spurious current in still water, by two routes, and what a window does about it."""
    from leakref.demo import run

    return run(out, json=json)


@command(PAPER)
def reproduce(
    case: Annotated[
        list[str] | None,
        typer.Argument(
            help="Cases or single configurations, as in --list; beside the paper's: depth, water that is not deep, and "
            "shear, currents that vary with depth."
        ),
    ] = None,
    everything: Annotated[bool, typer.Option("--all", help="Every case of the paper.")] = False,
    realizations: Annotated[int, typer.Option(min=1, help="How many of each configuration.")] = 100,
    figures: Annotated[
        bool,
        typer.Option(
            "--figures",
            help="Draw them as well; without a case every figure of the paper, results from golden/ (seconds).",
        ),
    ] = False,
    out: Annotated[Path, typer.Option(help="Folder for tables, data and figures.")] = Path("leakref-results"),
    methods: Methods = PAPERS,
    route: Annotated[str, typer.Option(help="A: surface and FFT, B: closed form.")] = "B",
    workers: Annotated[int, typer.Option(min=0, help="Processes; 0: one for each core.")] = 0,
    scheduler: Annotated[str, typer.Option(help="Address of a dask.distributed scheduler to use instead.")] = "",
    listing: Annotated[bool, typer.Option("--list", help="Print the ids of all cases and stop.")] = False,
    json: Json = False,
) -> bool:
    """The paper's cases: bias and random part of the measured velocity at each wavenumber."""
    from leakref import LeakrefError, _output
    from leakref.cases import ASSUMED_DEEP, CASES, PAPER_CASES

    if listing:
        ids = [c.id for members in (*CASES.values(), ASSUMED_DEEP) for c in members]
        typer.echo(_output.dump(_output.envelope("reproduce", True, ids=ids)) if json else "\n".join(ids))
        return True
    if figures and not everything and not case:
        from leakref.paper.figures import run as run_figures

        return run_figures(out, json=json)
    if everything == bool(case):
        raise LeakrefError(
            "reproduce",
            "both --all and cases were given" if case else "no case was named",
            f"name some of {', '.join(CASES)}, or pass --all",
        )
    from leakref.paper.reproduce import run

    return run(
        list(PAPER_CASES) if everything else case or [],
        realizations=realizations,
        figures=figures,
        out=out,
        route=route.upper(),
        json=json,
        workers=workers or os.cpu_count() or 1,
        scheduler=scheduler,
        everything=everything,
        methods=methods_named(methods, "reproduce"),
    )


@command(PAPER)
def claims(
    ids: Annotated[
        list[str] | None,
        typer.Argument(help="Claims (A4), groups of them (A), or with --decisions decisions (D4); default: all."),
    ] = None,
    decisions: Annotated[
        bool,
        typer.Option(
            "--decisions",
            help="How far each decision moves the velocities, as kept in golden/; with --out or --full computed.",
        ),
    ] = False,
    full: Annotated[
        bool,
        typer.Option(
            "--full",
            help="With --decisions: all claims judged under each variant that "
            "matters (an hour or more; goes on where it stopped).",
        ),
    ] = False,
    realizations: Annotated[
        int | None, typer.Option(min=2, help="How many of each configuration; default 100, with --decisions 20.")
    ] = None,
    judged: Annotated[
        int | None,
        typer.Option(
            "--judged-with", min=2, help="With --decisions: how many for the claims judged again; default as many."
        ),
    ] = None,
    place: Annotated[Path, typer.Option("--folder", help="Where realisations are kept, as by reproduce --out.")] = Path(
        "leakref-results"
    ),
    figures: Annotated[bool, typer.Option("--figures", help="A picture of each claim, in the folder.")] = False,
    out: Annotated[
        Path | None,
        typer.Option(help="Folder for the page and its JSON; with --decisions the file for the JSON."),
    ] = None,
    readings: Annotated[
        bool, typer.Option("--readings", help="Every reading of the claims, not the nearest alone.")
    ] = False,
    workers: Annotated[int, typer.Option(min=0, help="Processes; 0: one for each core.")] = 0,
    json: Json = False,
) -> bool:
    """The paper's statements: which are reproduced, which are not, how firmly, and where."""
    from leakref import LeakrefError

    if full and not decisions:
        raise LeakrefError("claims", "--full without --decisions", "add --decisions; without it all claims are judged")
    if decisions:
        from leakref.claims.decisionscommand import run as run_decisions

        return run_decisions(
            ids or [],
            realizations=realizations or 20,
            judged=judged or realizations or 20,
            place=place,
            figures=figures,
            out=out,
            workers=workers or os.cpu_count() or 1,
            full=full,
            json=json,
        )
    from leakref.claims.command import run

    return run(
        ids or [],
        realizations=realizations or 100,
        place=place,
        figures=figures,
        out=out,
        workers=workers or os.cpu_count() or 1,
        json=json,
        readings=readings,
    )
