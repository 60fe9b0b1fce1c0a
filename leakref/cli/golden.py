"""Commands about the golden values."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Annotated

import typer

from leakref.cli.base import NEWEST_GOLDEN, GoldenFolder, GoldenNumber, GoldenWork, Json, Workers, command, golden_app

__all__ = ["golden_lint", "golden_pack", "golden_regenerate", "golden_verify"]


@command(None, "lint", golden_app)
def golden_lint(golden: GoldenNumber = NEWEST_GOLDEN, place: GoldenFolder = None, json: Json = False) -> bool:
    """Whole and unchanged? Schemas, counts, ids, digests of every entry."""
    from leakref.golden.commands import run_lint

    return run_lint(golden, place, json=json)


@command(None, "verify", golden_app)
def golden_verify(
    ids: Annotated[
        list[str] | None,
        typer.Argument(
            help="Entries to look at, or patterns such as 'ensemble-U*'; none: the quick ones, or all with --full."
        ),
    ] = None,
    full: Annotated[bool, typer.Option("--full", help="By every route, all realisations and ensembles.")] = False,
    route: Annotated[
        str,
        typer.Option(
            help="For ensembles: B, or A to confirm some by the surface and the FFT (16 s "
            "a realisation; resumed where it stopped)."
        ),
    ] = "B",
    golden: GoldenNumber = NEWEST_GOLDEN,
    place: GoldenFolder = None,
    work: GoldenWork = Path("leakref-golden"),
    workers: Workers = 0,
    json: Json = False,
) -> int:
    """Still reproduced? Compute again and compare: vectors and a few realisations, or everything."""
    from leakref.golden.commands import run_verify

    return run_verify(
        ids or [],
        golden,
        place,
        full=full,
        route=route.upper(),
        work=work,
        workers=workers or os.cpu_count() or 1,
        json=json,
    )


@command(None, "regenerate", golden_app)
def golden_regenerate(
    ids: Annotated[
        list[str] | None,
        typer.Argument(help="Entries to write; 'realization-*' adds what is missing. None: compare all, write beside."),
    ] = None,
    golden: GoldenNumber = NEWEST_GOLDEN,
    place: GoldenFolder = None,
    work: GoldenWork = Path("leakref-golden"),
    workers: Workers = 0,
    json: Json = False,
) -> bool:
    """Compute entries again, show what differs; replaces only the ids that are named."""
    from leakref.golden.commands import run_regenerate

    return run_regenerate(ids or [], golden, place, work=work, workers=workers or os.cpu_count() or 1, json=json)


@command(None, "pack", golden_app)
def golden_pack(
    out: Annotated[Path, typer.Option(help="The archive to write, a zip.")],
    form: Annotated[
        str, typer.Option("--format", help="Of the arrays: raw (for all runners), mat, npz or netcdf.")
    ] = "raw",
    golden: GoldenNumber = NEWEST_GOLDEN,
    json: Json = False,
) -> bool:
    """For unit tests in other languages: vectors of all stages, tolerances, runners that compare, in one archive."""
    from leakref.exam.pack import run

    return run(out, form, golden, json=json)
