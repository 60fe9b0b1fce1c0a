"""`leakref guide`: short guides, which travel with the package as `guide/*.md`.

Each is Markdown with code that tests run, so that it cannot go out of date. On a terminal it is rendered, else printed
as it is.
"""

from __future__ import annotations

import difflib
from functools import cache
from importlib import resources

from leakref._base import LeakrefError
from leakref._output import dump, envelope

__all__ = ["TOPICS", "run", "text", "titles"]

TOPICS = (
    "certificate",
    "regimes",
    "python",
    "octave",
    "cpp",
    "shell",
    "exam",
    "protocol",
    "real-codes",
    "pytest",
    "tracking",
    "data",
    "methods",
    "paper",
    "decisions",
    "adding",
)
"""In the order in which one would read them."""


@cache
def _all() -> dict[str, str]:
    folder = resources.files("leakref").joinpath("guide")
    return {topic: folder.joinpath(f"{topic}.md").read_text(encoding="utf-8") for topic in TOPICS}


def titles() -> dict[str, str]:
    """The title of each guide by its topic."""
    return {topic: words.splitlines()[0].removeprefix("# ") for topic, words in _all().items()}


def text(topic: str) -> str:
    """A guide in Markdown, without what only its test reads. Raises LeakrefError for a topic that there is not."""
    if topic not in _all():
        near = difflib.get_close_matches(topic, _all(), 1)
        raise LeakrefError(
            "guide",
            f"there is no guide to {topic!r}",
            f"did you mean {near[0]}?" if near else f"choose one of {', '.join(_all())}",
        )
    return "".join(line for line in _all()[topic].splitlines(keepends=True) if not line.startswith("<!--"))


def run(topic: str | None, *, json: bool = False) -> bool:
    """The command: print a guide, or which there are."""
    from rich.console import Console
    from rich.markdown import Markdown

    from leakref._tables import Table

    if json:
        print(
            dump(envelope("guide", True, **({"topic": topic, "text": text(topic)} if topic else {"topics": titles()})))
        )
    elif topic:
        console = Console(width=min(Console().width, 100))
        console.print(Markdown(text(topic))) if console.is_terminal else print(text(topic), end="")
    else:
        table = Table(box=None, show_header=False, padding=(0, 2))
        for name, title in titles().items():
            table.add_row(f"leakref guide {name}", title)
        Console().print(table)
    return True
