"""What was found, as kept in `golden/`: the verdicts of the claims, and how far each decision moves the velocities."""

from __future__ import annotations

import json
from collections.abc import Sequence
from importlib import resources
from pathlib import Path
from typing import Any

from leakref import LeakrefError
from leakref._output import dump, write_whole

__all__ = ["by_line", "stored_claim", "stored_claims", "stored_decision", "stored_decisions", "turned", "write"]


def _read(name: str) -> dict[str, Any]:
    try:
        return json.loads(resources.files("leakref._golden").joinpath(name).read_text(encoding="utf-8"))
    except (OSError, ValueError) as error:
        raise LeakrefError("claims", f"golden/{name} cannot be read ({type(error).__name__})",
                           "compute it with `leakref claims --out`, or install again") from None


def stored_claims() -> dict[str, Any]:
    """The JSON of `leakref claims` with 100 realisations, golden/claims.json. Raises LeakrefError if there is none."""
    return _read("claims.json")


def stored_decisions() -> dict[str, Any]:
    """The JSON of `leakref claims --decisions`, golden/decisions.json. Raises LeakrefError if there is none."""
    return _read("decisions.json")


def stored_claim(id: str) -> dict[str, Any] | None:
    """What came of one claim: verdict, figure, every reading; None if it was not evaluated."""
    return next((record for record in stored_claims()["claims"] if record["id"] == id), None)


def stored_decision(id: str) -> dict[str, Any] | None:
    """What came of one decision: its variants, how far each moves the velocities, and the claims that turn on it."""
    return next((record for record in stored_decisions()["decisions"] if record["id"] == id), None)


def turned(id: str) -> list[dict[str, Any]]:
    """Under which variants of which decisions readings of a claim turn; see `stored_decisions`."""
    return [record for record in stored_decisions()["claims"] if record["id"] == id and record["flipped"]]


def by_line(result: dict[str, Any], lists: Sequence[str]) -> str:
    """JSON with an item of the `lists` on each line, so that a change is seen as a change of that item."""
    head = dump({key: value for key, value in result.items() if key not in lists})[:-1]
    parts = [f'"{name}": [\n' + ",\n".join(dump(item) for item in result[name]) + "\n]" for name in lists]
    return ", ".join([head, *parts]) + "}\n"


def write(path: Path, result: dict[str, Any], lists: Sequence[str]) -> Path:
    """The file `path` of `by_line`, whole or not at all."""
    return write_whole(path, lambda beside: beside.write_text(by_line(result, lists), encoding="utf-8"))
