"""What was found, as kept in `golden/`: the verdicts of the claims, and how far each decision moves the velocities.

Evaluating all claims takes long; what came of it is kept with the package, so that `leakref explain`, the guides and
the documentation can quote it. `write` makes these files. They are results of a version, and say with how many
realisations.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from leakref._output import dump, write_whole
from leakref.golden import beside

__all__ = ["by_line", "stored_claim", "stored_claims", "stored_decision", "stored_decisions", "turned", "write"]


def stored_claims() -> dict[str, Any]:
    """The JSON of `leakref claims`, golden/claims.json. Raises Damaged if it is not whole."""
    return dict(beside.read("claims.json"))


def stored_decisions() -> dict[str, Any]:
    """The JSON of `leakref claims --decisions`, golden/decisions.json. Raises Damaged if it is not whole."""
    return dict(beside.read("decisions.json"))


def stored_claim(id: str) -> dict[str, Any] | None:
    """What came of one claim: verdict, figure, every reading; None if it was not evaluated."""
    return next((record for record in stored_claims()["claims"] if record["id"] == id), None)


def stored_decision(id: str) -> dict[str, Any] | None:
    """What came of one decision: its variants, how far each moves the velocities, and the claims that turn on it."""
    return next((record for record in stored_decisions()["decisions"] if record["id"] == id), None)


def turned(id: str) -> list[dict[str, Any]]:
    """Under which variants of which decisions readings of a claim turn; see `stored_decisions`. An empty list if it
    turns under none, or was not judged.
    """
    return [record for record in stored_decisions()["claims"] if record["id"] == id and record["flipped"]]


def by_line(result: dict[str, Any], lists: Sequence[str]) -> str:
    """JSON with an item of the `lists` on each line, so that a change is seen as a change of that item. What is not a
    list comes first.
    """
    head = dump({key: value for key, value in result.items() if key not in lists})[:-1]
    parts = [f'"{name}": [\n' + ",\n".join(dump(item) for item in result[name]) + "\n]" for name in lists]
    return ", ".join([head, *parts]) + "}\n"


def write(path: Path, result: dict[str, Any], lists: Sequence[str]) -> Path:
    """The file `path` of `by_line`, whole or not at all.

    If the file is one of those in `golden/`, its digest in the manifest is brought up to date in the same step.
    """
    written = write_whole(path, lambda place: place.write_text(by_line(result, lists), encoding="utf-8"))
    beside.noted(written)
    return written
