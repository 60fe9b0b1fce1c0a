"""The commands. Nothing heavy is imported before a command needs it."""

from __future__ import annotations

import sys
from importlib import import_module

from leakref import _exits, ending
from leakref.cli.base import app

__all__ = ["app", "main"]

for _part in ("judge", "exam", "data", "paper", "golden", "upkeep"):  # in this order they are listed
    import_module(f"leakref.cli.{_part}")


def main() -> None:
    """Entry point of the `leakref` command."""
    _exits.plugged()
    for stream in (sys.stdout, sys.stderr):  # a pipe may be ASCII, and figures carry degrees and deltas
        if hasattr(stream, "reconfigure"):
            stream.reconfigure(encoding="utf-8", errors="replace")
    ending.install()
    status = _exits.status_of("", _typed)
    ending.over()
    sys.exit(status)


def _typed() -> int:
    """What is on the command line, done: typer ends everything by a SystemExit."""
    try:
        app()
    except SystemExit as end:
        if isinstance(end.code, int) and not isinstance(end.__context__, BrokenPipeError):
            return end.code
        raise
    return 0
