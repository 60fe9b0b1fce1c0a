"""What all commands share: the application, how a command ends, and options that several have.

Commands are registered by `command`, a decorator that turns what the body returns, or raises, into an exit status
(`_exits.status_of`). The modules beside this one have a function for each command, which imports what does the work
only when it is called, so that `leakref --help` stays quick.
"""

from __future__ import annotations

import os
from collections.abc import Callable
from functools import wraps
from pathlib import Path
from typing import Annotated, Any

import typer

from leakref import __version__, _caches, _exits, ending

__all__ = ["app"]

JUDGE, DATA, PAPER, UPKEEP = "Judge a code", "Your data", "The paper", "Upkeep"
app = typer.Typer(
    name="leakref",
    no_args_is_help=True,
    add_completion=False,
    rich_markup_mode="rich",
    pretty_exceptions_enable=False,
    context_settings={"help_option_names": ["-h", "--help"]},
    help="A reference and test oracle for measuring near-surface currents from images of waves.",
)
Json = Annotated[bool, typer.Option("--json", help="Print one JSON object on standard output.")]


@app.callback(invoke_without_command=True)
def _options(
    context: typer.Context,
    version: Annotated[bool, typer.Option("--version", help="Print the version and exit.")] = False,
    traceback: Annotated[
        bool,
        typer.Option("--traceback", help="Where something breaks, show where in the code; also LEAKREF_TRACEBACK=1."),
    ] = False,
) -> None:
    """What may stand before a command; without a command only --version is an answer."""
    if traceback:
        os.environ[ending.TRACEBACK] = "1"
    if context.invoked_subcommand is None and version is True:
        typer.echo(f"leakref {__version__}")
    elif context.invoked_subcommand is None:
        context.fail("Missing command.")
    elif version is True:  # status 0 is the verdict of a command that ran, and of nothing else
        context.fail("--version goes without a command.")


def command(
    panel: str | None, name: str | None = None, group: typer.Typer = app
) -> Callable[[Callable[..., bool | int]], Callable[..., None]]:
    """A command of `group` whose body returns whether it holds, exit status 0 or 1, or the status itself.

    `panel` is the heading in the help under which it stands, `name` what it is called if not as its function; the
    function's docstring is its help. The body may return True, False or a status, or raise anything.
    """

    def register(body: Callable[..., bool | int]) -> Callable[..., None]:
        @group.command(name, rich_help_panel=panel)
        @wraps(body)
        def run(*args: Any, **kwargs: Any) -> None:
            _caches.prepare()
            raise typer.Exit(_exits.status_of(body.__name__.replace("_", " "), lambda: body(*args, **kwargs)))

        return run

    return register


PAPERS = "nsp,ls"
METHODS = "Which, with commas between: nsp, ls, and those of `leakref guide methods`."
Methods = Annotated[str, typer.Option("--methods", help=METHODS)]


def methods_named(text: str, call: str) -> tuple[str, ...]:
    """The methods of a list with commas, each once. Raises LeakrefError for one that there is not, or none."""
    from leakref.methods import method

    return tuple(dict.fromkeys(method(name.strip(), call).id for name in text.split(",")))


golden_app = typer.Typer(no_args_is_help=True, context_settings={"help_option_names": ["-h", "--help"]})
app.add_typer(golden_app, name="golden", rich_help_panel=UPKEEP, help="The golden values: unchanged? still reproduced?")
exam_app = typer.Typer(no_args_is_help=True, context_settings={"help_option_names": ["-h", "--help"]})
app.add_typer(exam_app, name="exam", rich_help_panel=JUDGE, help="Certified without Python: questions as files, marks.")
NEWEST_GOLDEN = 2
GoldenNumber = Annotated[int, typer.Option("--golden", help="Which set: 1 for golden/v1; 2 is that and what is new.")]
GoldenFolder = Annotated[Path | None, typer.Option("--set", help="Folder of a set, instead of the installed one.")]
GoldenWork = Annotated[Path, typer.Option(help="Folder where long runs are kept, and resumed from.")]
Timeout = Annotated[
    float | None,
    typer.Option(min=0.1, help="Seconds for a run, default 120 (in full 600), and for the start, default 30."),
]
StartTimeout = Annotated[float | None, typer.Option(min=0.1, help="Seconds for the start, if other than --timeout.")]
Workers = Annotated[int, typer.Option(min=0, help="Processes; 0: one for each core.")]
track_app = typer.Typer(no_args_is_help=True, context_settings={"help_option_names": ["-h", "--help"]})
app.add_typer(track_app, name="track", rich_help_panel=UPKEEP, help="Bias over versions: recorded, compared, drawn.")
Target = Annotated[
    str | None, typer.Argument(help="What is judged: package.module:object, reference, fault:ID or variant:ID.")
]
Program = Annotated[str | None, typer.Option("--command", help="A program in any language, with its arguments.")]
HistoryFile = Annotated[Path, typer.Option("--history", help="JSON lines, one an entry; made if it is not there.")]
HISTORY = Path("leakref-history.jsonl")
