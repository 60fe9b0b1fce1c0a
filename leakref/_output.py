"""What leaves the program: JSON without NaN, files that are whole or not there, one console for messages.

Every command prints through `dump` and `envelope` and writes through `write_whole`, so that what one reads is never
half of something. Nothing heavy is imported before it is needed.
"""

from __future__ import annotations

import json
import os
import tempfile
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from enum import Enum
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

from leakref import __version__
from leakref._base import refusal

if TYPE_CHECKING:
    from jinja2 import Template
    from rich.console import Console
    from rich.progress import Progress

__all__ = ["console", "dump", "envelope", "folder", "plain", "progress_bar", "template", "write_whole"]


def plain(value: Any) -> Any:
    """`value` in the types of JSON: arrays as lists, NaN and infinity as null."""
    if hasattr(value, "tolist"):
        value = value.tolist()
    if isinstance(value, dict):
        return {str(key): plain(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [plain(item) for item in value]
    if isinstance(value, Path | Enum):
        return str(value)
    if isinstance(value, float) and (value != value or value in (float("inf"), float("-inf"))):
        return None
    return value


def dump(value: Any) -> str:
    """One line of strict JSON; floats as short as they can be and come back the same."""
    text = json.dumps(plain(value), allow_nan=False, ensure_ascii=False)
    return text.encode("utf-8", "replace").decode()  # the name of a file need not be text


def envelope(command: str, ok: bool, **fields: Any) -> dict[str, Any]:
    """The object that `--json` prints (guide protocol, section 14).

    `ok` is whether it holds. `schema` names the command and the version of its format.
    """
    return {"schema": f"leakref/{command}/1", "version": __version__, "ok": bool(ok), **fields}


def folder(path: Path) -> Path:
    """Make the folder `path` if need be, before the work whose results go there.

    The path is returned. LeakrefError is raised where nothing can be written, Trouble where the disk is full.
    """
    try:
        path.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=path):
            return path
    except OSError as error:
        raise refusal(
            "write",
            f"nothing can be written to {path} ({error.strerror or error})",
            "choose a folder you may write to with --out",
            error,
        ) from None


def write_whole(path: Path, write: Callable[[Path], object]) -> Path:
    """Have `write` make a file beside `path`, and put it there in one step: nothing is ever half written.

    Folders above are made. `write` is handed a path of the same suffix in the same folder. The path is returned, and
    LeakrefError or Trouble raised as by `folder`; what `write` itself raises is passed on, and nothing is left behind.
    """
    path = Path(path)
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        handle, name = tempfile.mkstemp(dir=path.parent, prefix=f".{path.stem}-", suffix=path.suffix)
        os.close(handle)
        beside = Path(name)
        try:
            write(beside)
            mask = os.umask(0)
            os.umask(mask)
            beside.chmod(0o666 & ~mask)  # as any new file: mkstemp makes it private
            beside.replace(path)
        finally:
            with suppress(FileNotFoundError):
                beside.unlink()
    except OSError as error:
        raise refusal(
            "write",
            f"{path} cannot be written ({error.strerror or error})",
            "choose a folder you may write to that has room",
            error,
        ) from None
    return path


def console() -> Console:
    """Where progress and messages go: standard error, so that standard output holds results only."""
    from rich.console import Console

    return Console(stderr=True)


@contextmanager
def progress_bar(what: str, total: int | None) -> Iterator[Callable[[], None]]:
    """A bar with rate and time left (where the total is known), on a terminal; yields what to call after each step."""
    show = console()
    if not show.is_terminal:  # a bar would still end its line where none is shown
        yield lambda: None
        return
    from rich.progress import BarColumn, MofNCompleteColumn, TextColumn, TimeElapsedColumn, TimeRemainingColumn
    from rich.progress import Progress as Bar

    columns = (
        TextColumn("{task.description}"),
        BarColumn(),
        MofNCompleteColumn(),
        TextColumn("{task.fields[rate]}"),
        TimeElapsedColumn(),
        TimeRemainingColumn(),
    )
    bar: Progress
    with Bar(*columns, console=show, transient=True) as bar:
        task = bar.add_task(what, total=total, rate="")

        def step() -> None:
            bar.advance(task)
            speed = bar.tasks[0].speed
            bar.update(task, rate=f"{speed:.2f}/s" if speed else "")

        yield step


@cache
def template(name: str) -> Template:
    """A page or a picture by the name of its file in `certify/pages`.

    Whatever is put into it is escaped, and what is lacking is an error.
    """
    from jinja2 import Environment, PackageLoader, StrictUndefined

    pages = PackageLoader("leakref.certify", "pages")
    return Environment(loader=pages, autoescape=True, undefined=StrictUndefined, trim_blocks=True).get_template(name)
