"""The commands. Nothing heavy is imported before a command needs it."""

from __future__ import annotations

import sys
from collections.abc import Callable
from functools import wraps
from pathlib import Path
from typing import Annotated, Any

import typer

from leakref import __version__

__all__ = ["app", "main"]

JUDGE, DATA, PAPER, UPKEEP = "Judge a code", "Your data", "The paper", "Upkeep"
app = typer.Typer(name="leakref", no_args_is_help=True, add_completion=False, rich_markup_mode="rich",
                  pretty_exceptions_enable=False, context_settings={"help_option_names": ["-h", "--help"]},
                  help="A reference and test oracle for measuring near-surface currents from images of waves.")
Json = Annotated[bool, typer.Option("--json", help="Print one JSON object on standard output.")]


def _version(wanted: bool) -> None:
    if wanted:
        typer.echo(f"leakref {__version__}")
        raise typer.Exit


@app.callback()
def _options(version: Annotated[bool, typer.Option("--version", callback=_version, is_eager=True,
                                                   help="Print the version and exit.")] = False) -> None:
    pass


def command(panel: str, name: str | None = None) -> Callable[[Callable[..., bool]], Callable[..., None]]:
    """A command whose body returns whether it holds: exit status 0 or 1; 2 and one line for a refused input."""

    def register(body: Callable[..., bool]) -> Callable[..., None]:
        @app.command(name, rich_help_panel=panel)
        @wraps(body)
        def run(*args: Any, **kwargs: Any) -> None:
            from leakref import LeakrefError

            try:
                holds = body(*args, **kwargs)
            except LeakrefError as refusal:
                typer.echo(f"leakref: {refusal}", err=True)
                raise typer.Exit(2) from None
            except KeyboardInterrupt:
                typer.echo("leakref: interrupted", err=True)
                raise typer.Exit(130) from None
            raise typer.Exit(0 if holds else 1)

        return run

    return register


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
    case: Annotated[list[str] | None, typer.Argument(help="Cases or single configurations, as in --list.")] = None,
    everything: Annotated[bool, typer.Option("--all", help="Every case of the paper.")] = False,
    realizations: Annotated[int, typer.Option(min=1, help="How many of each configuration.")] = 100,
    figures: Annotated[bool, typer.Option("--figures", help="Draw them as well.")] = False,
    out: Annotated[Path, typer.Option(help="Folder for tables, data and figures.")] = Path("leakref-results"),
    route: Annotated[str, typer.Option(help="A: surface and FFT, B: closed form.")] = "B",
    listing: Annotated[bool, typer.Option("--list", help="Print the ids of all cases and stop.")] = False,
    json: Json = False,
) -> bool:
    """The paper's cases: bias and random part of the measured velocity at each wavenumber."""
    from leakref import LeakrefError, _output
    from leakref.cases import CASES

    if listing:
        ids = [c.id for members in CASES.values() for c in members]
        typer.echo(_output.dump(_output.envelope("reproduce", True, ids=ids)) if json else "\n".join(ids))
        return True
    if everything == bool(case):
        raise LeakrefError("reproduce", "both --all and cases were given" if case else "no case was named",
                           f"name some of {', '.join(CASES)}, or pass --all")
    from leakref.reproduce import run

    return run(list(CASES) if everything else case or [], realizations=realizations, figures=figures, out=out,
               route=route.upper(), json=json)


def main() -> None:
    """Entry point of the `leakref` command."""
    for stream in (sys.stdout, sys.stderr):  # a pipe may be ASCII, and figures carry degrees and deltas
        if hasattr(stream, "reconfigure"):
            stream.reconfigure(encoding="utf-8", errors="replace")
    app()
