"""Whether what was computed here is what was computed elsewhere: never bit for bit, always within a derived tolerance.

Processors differ in the last bits of sums of products, sines and exponentials. So inputs that the set has are read and
not made again, and a value is another one only beyond its tolerance.
"""

from __future__ import annotations

from functools import partial
from typing import Any

import numpy as np

from leakref._base import FloatArray
from leakref.golden.defined import VECTORS
from leakref.golden.sets import EPSILON, Entry, compare, tolerance
from leakref.golden.stages import STAGES
from leakref.golden.vectors import Vector
from leakref.grid import Grid

__all__ = ["agree", "alike", "archived_tolerance", "given"]

_HALF = EPSILON**0.5
"""A conditioning is known to first order, in parts by differences: half of its digits are what it is compared to."""
_COMPUTED = ("output", "accuracy", "input", "resolution_frequency", "resolution_wavenumber")


def alike(a: Any, b: Any, allowed: Any = None) -> bool:
    """Whether two values of JSON are the same but for the rounding of numbers: by `allowed`, or of each its own.

    `allowed` is an absolute difference, a number or an array that goes with the values. Without it each number may be
    off by `tolerance(1)` of its own size. NaN is like NaN here, and lists must be of one length.
    """
    if isinstance(a, dict) and isinstance(b, dict):
        return a.keys() == b.keys() and all(alike(a[key], b[key], allowed) for key in a)
    if isinstance(a, str | bool | None) or isinstance(b, str | bool | None):
        return type(a) is type(b) and a == b
    try:
        one, other = (np.asarray(value, dtype=np.float64) for value in (a, b))
    except (TypeError, ValueError):  # words, or lists of different lengths, among them
        return (
            isinstance(a, list)
            and isinstance(b, list)
            and len(a) == len(b)
            and all(map(partial(alike, allowed=allowed), a, b))
        )
    if one.shape != other.shape:
        return False
    tolerated = tolerance(1.0) * np.maximum(np.abs(one), np.abs(other)) if allowed is None else allowed
    with np.errstate(invalid="ignore"):
        return bool(((np.abs(one - other) <= tolerated) | (np.isnan(one) & np.isnan(other))).all())


def archived_tolerance(vector: Vector) -> float:
    """By how much an archived surface may differ where it is made again: the tolerance of a golden surface.

    It is one number, in units of `1 / k0`, from the conditioning of the stage `surface`.
    """
    grid = Grid(tuple(vector.input["shape"]), tuple(vector.input["spacing"]))
    axes = {name: grid.samples(axis) for axis, name in enumerate("xyt")}
    return tolerance(STAGES["surface"].conditioning({**vector.input, **axes}, {})["eta"])


def given(vector: Vector, before: Entry | None) -> dict[str, Any]:
    """The inputs of a vector: as the set has them, unless the definition is another by more than rounding.

    So that what a processor rounds otherwise when it makes them is no change, and archived surfaces are read.
    """
    there = before.input if before is not None else {}

    def same(name: str) -> bool:
        tolerated = archived_tolerance(vector) if name in vector.archived else None
        return name in there and alike(there[name], vector.input[name], tolerated)

    return {name: there[name] if same(name) else value for name, value in vector.input.items()}


def agree(before: Entry, after: Entry) -> bool:
    """Whether an entry made again is the old one within the tolerance of its values.

    Equal are words, notes, reasons and counts; inputs and resolutions but for rounding; conditioning to half of its
    digits. How many digits the routes agreed on is not compared: beyond the tolerance it is chance.

    Keys must be the same ones in both. Used by `making.regenerate` to decide whether an entry has changed.
    """
    a, b = before.record, after.record
    tolerances = {
        name: archived_tolerance(v)
        for members in VECTORS.values()
        for v in members
        if v.id == before.id
        for name in v.archived
    }
    conditioning = [{name: said["conditioning"] for name, said in one["accuracy"].items()} for one in (a, b)]
    return bool(
        a.keys() == b.keys()
        and all(a[key] == b[key] for key in a if key not in _COMPUTED)
        and before.input.keys() == after.input.keys()
        and all(alike(value, after.input[name], tolerances.get(name)) for name, value in before.input.items())
        and all(alike(a[name], b[name]) for name in _COMPUTED[3:] if name in a)
        and before.output.keys() == after.output.keys()
        and not compare(before, after.output)
        and conditioning[0].keys() == conditioning[1].keys()
        and all(
            alike(value, other, _HALF * np.abs(value))
            for value, other in (_in_one_form(value, conditioning[1][name]) for name, value in conditioning[0].items())
        )
    )


def _in_one_form(a: Any, b: Any) -> tuple[FloatArray, FloatArray]:
    """Two conditionings, of which one number stands for one for each item."""
    one, other = (np.asarray(value, dtype=np.float64) for value in (a, b))
    return one + np.zeros(other.shape * (not one.ndim)), other + np.zeros(one.shape * (not other.ndim))
