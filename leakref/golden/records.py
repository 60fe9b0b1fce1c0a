"""The record of an entry as it is written: outputs, their accuracy, reasons where there is no number.

Used by `entries` alone. It decides what an entry states of its accuracy: digits on which all routes agree, the
conditioning, and the tolerance that follows from it (`sets.tolerance`). Where routes are farther apart than that
tolerance there is no record, but a LeakrefError.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import numpy as np

from leakref._base import FloatArray, LeakrefError
from leakref._output import plain as to_json
from leakref.golden import oracle
from leakref.golden.same import given
from leakref.golden.sets import Entry, agreed_digits, tolerance
from leakref.golden.stages import STAGES
from leakref.golden.stages.stage import plain
from leakref.golden.vectors import Vector

__all__ = ["entry_record", "head_of", "vector_record"]


def _values(value: FloatArray) -> Any:
    """Nested lists for JSON: whole numbers as such, NaN as null."""
    listed = to_json(np.asarray(value, dtype=np.float64))

    def whole(item: Any) -> Any:
        if isinstance(item, list):
            return [whole(part) for part in item]
        return int(item) if item is not None and item == int(item) and abs(item) < 2**31 else item

    exact = bool(np.all(np.equal(np.round(value), value)))
    return whole(listed) if exact else listed


def _accuracy(
    name: str, identifier: str, golden: FloatArray, others: Mapping[str, FloatArray], conditioning: Any
) -> dict[str, Any]:
    """Digits, conditioning and tolerance of one output; LeakrefError if a route is farther off than that. The digits
    are those of the route that is farthest off. Where an output is all zero but for rounding its conditioning stands in
    for its size.
    """
    kappa = np.asarray(conditioning, dtype=np.float64)
    if kappa.size > 1 and np.all(kappa == kappa.flat[0]):
        kappa = kappa.ravel()[:1].reshape(())  # one number for all of them
    allowed = np.asarray([tolerance(float(c)) for c in kappa.ravel()]).reshape(kappa.shape)
    per_item = allowed.reshape(allowed.shape + (1,) * (golden.ndim - allowed.ndim if allowed.ndim else 0))
    worst = 0.0
    for route, values in others.items():
        same_nan = np.isnan(values) == np.isnan(golden)
        off = np.where(np.isnan(golden), 0.0, np.abs(values - golden))
        too_far = off > np.where(np.isnan(per_item), 0, per_item)
        if values.shape != golden.shape or not same_nan.all() or too_far.any():
            raise LeakrefError(
                "golden.regenerate",
                f"{identifier}: route {route} differs in {name} by "
                f"{float(np.nanmax(off)):.2g}, more than its conditioning allows "
                f"({float(np.nanmax(allowed)):.2g})",
                "find out why; nothing was written",
            )
        worst = max(worst, float(np.nanmax(off, initial=0.0)))
    scale, most = (float(np.nanmax(np.abs(v), initial=0.0)) for v in (golden, kappa))
    scale = scale if scale > tolerance(most) else most  # all zero but for rounding: digits after the first that counts
    return {"digits": agreed_digits(worst, scale), "conditioning": to_json(kappa), "tolerance": to_json(allowed)}


def _reasons(golden: FloatArray, notes: Sequence[Sequence[str]] | None) -> list[str]:
    """For each item of the first axis why there is no number there: its notes, or just that there is none; empty where
    there is.
    """
    rows = golden.reshape(golden.shape[0], -1) if golden.ndim else golden.reshape(1, 1)
    missing = [bool(np.isnan(row).any()) for row in rows]
    return [
        ", ".join(notes[n]) if gone and notes is not None else "no number" if gone else ""
        for n, gone in enumerate(missing)
    ]


def entry_record(
    head: Mapping[str, Any],
    given: Mapping[str, Any],
    found: Mapping[str, Mapping[str, Any]],
    kept: str,
    conditioning: Mapping[str, Any],
    extra: Mapping[str, Any] | None = None,
) -> dict[str, Any]:
    """The record of an entry from what each route `found`, keeping the values of route `kept`."""
    notes = next((outputs["notes"] for outputs in found.values() if "notes" in outputs), None)
    for route, outputs in found.items():
        if outputs.get("notes", notes) != notes:
            raise LeakrefError(
                "golden.regenerate",
                f"{head['id']}: route {route} notes {outputs['notes']}, another {notes}",
                "find out why; nothing was written",
            )
    golden = {name: value for name, value in found[kept].items() if name != "notes"}
    accuracy = {
        name: _accuracy(
            name, str(head["id"]), value, {r: o[name] for r, o in found.items() if r != kept}, conditioning[name]
        )
        for name, value in golden.items()
    }
    reasons = {name: _reasons(value, notes) for name, value in golden.items() if np.isnan(value).any()}
    record: dict[str, Any] = {**head, "input": given, "output": {name: _values(v) for name, v in golden.items()}}
    if notes is not None:
        record["notes"] = notes
    if reasons:
        record["reasons"] = reasons
    origin = {"values": kept, "confirmed_by": sorted(route for route in found if route != kept)}
    return {**record, **(extra or {}), "origin": origin, "accuracy": accuracy}


def head_of(
    identifier: str,
    stage: str,
    difficulty: str,
    purpose: str,
    equation: str,
    faults: Iterable[str] = (),
    decisions: Iterable[str] = (),
    supersedes: str | None = None,
) -> dict[str, Any]:
    """The first fields of a record: what the entry is, how hard it is, and what it is for.

    `difficulty` is a word for readers, `purpose` the mistake that the entry would show, `equation` the paper's label;
    `faults` and `decisions` are ids; `supersedes` is the id of an entry that this one replaces.
    """
    return {
        "id": identifier,
        "stage": stage,
        "difficulty": difficulty,
        "purpose": purpose,
        "faults": list(faults),
        "equation": equation,
        "decisions": list(decisions),
        "supersedes": supersedes,
    }


def vector_record(vector: Vector, before: Entry | None = None) -> dict[str, Any]:
    """The record of a vector, by every route and the high-precision oracle; `before` is what the set has of it.

    Values of the oracle are kept where the stage has one, else those of its first route. Inputs come from `before`
    where they are the same but for rounding (`same.given`). Raises LeakrefError where a route is too far off.
    """
    stage, put_in = STAGES[vector.stage], given(vector, before)
    found = {route: compute(put_in) for route, compute in stage.routes.items()}
    first = next(iter(found))
    if stage.oracle is not None:
        found["mpmath"] = oracle.at_digits(stage.oracle)(put_in, found[first])
    rounded = {route: plain(outputs) for route, outputs in found.items()}
    conditioning = stage.conditioning(put_in, {n: v for n, v in rounded[first].items() if n != "notes"})
    head = head_of(
        vector.id,
        vector.stage,
        vector.difficulty,
        vector.purpose,
        stage.equation,
        vector.faults,
        vector.decisions,
        vector.supersedes,
    )
    return entry_record(head, put_in, rounded, "mpmath" if stage.oracle is not None else first, conditioning)
