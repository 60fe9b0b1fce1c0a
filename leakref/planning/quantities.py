"""Quantities with their units, as people write them: "128m", "30s", "45deg", "0.3m/s".

A number without a unit is refused, since metres and peak wavelengths are easily taken for each other; any unit of the
right kind is taken (`0.2km`, `2/s`, `30deg`). Used by `planning.command`.
"""

from __future__ import annotations

import math
import re
from functools import cache
from typing import Any

from leakref._base import LeakrefError

__all__ = ["EXAMPLES", "number", "quantity"]

EXAMPLES = {"m": "128m", "s": "30s", "deg": "45deg", "m/s": "0.3m/s", "Hz": "2Hz"}
"""The units that are asked for, and how one writes such a quantity."""
_WRITTEN = re.compile(r"\s*([+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?)\s*([^\s\d.+-][\w\s/*^°.-]{0,40})?\s*")


@cache
def _registry() -> Any:
    from pint import UnitRegistry

    return UnitRegistry()


def quantity(call: str, option: str, text: str, unit: str) -> float:
    """`text` in `unit`, whatever unit of that kind it is written in. Raises LeakrefError, and if there is no unit.
    `call` and `option` are for the message. Refused are also units of another kind, plain numbers for an angle, and
    what is not finite.
    """
    from pint.errors import PintError

    example = f"write it as in {option} {EXAMPLES[unit]}"
    written = _WRITTEN.fullmatch(text)
    if written is None:
        raise LeakrefError(call, f"{option} {text} is not a number with a unit", example)
    if written[2] is None:
        raise LeakrefError(call, f"{option} {text} has no unit", example)
    try:
        units = _registry().parse_units(f"1{written[2]}" if written[2].startswith("/") else written[2])
    except (PintError, ValueError, AssertionError, TypeError, KeyError, AttributeError):
        raise LeakrefError(call, f"{option} {text}: there is no unit {written[2].strip()!r}", example) from None
    angle = unit == "deg"  # which pint counts as a plain number, so that any other would pass for radians
    if not units.is_compatible_with(unit) or (angle and not _is_angle(units)):
        raise LeakrefError(call, f"{option} {text}: {units} cannot be had in {unit}", example)
    return _finite(call, option, text, float(_registry().Quantity(float(written[1]), units).to(unit).magnitude))


def _is_angle(units: Any) -> bool:
    """Whether `units` is one unit of angle and nothing else."""
    return str(units) in ("degree", "radian", "turn", "arcminute", "arcsecond", "grade", "milliradian")


def number(call: str, option: str, text: str) -> float:
    """`text` as a plain number. Raises LeakrefError. Refused is also what is not finite."""
    try:
        return _finite(call, option, text, float(text))
    except ValueError as error:
        if isinstance(error, LeakrefError):
            raise
        raise LeakrefError(call, f"{option} {text} is not a number", f"write it as in {option} 3.3") from None


def _finite(call: str, option: str, text: str, value: float) -> float:
    if not math.isfinite(value):
        raise LeakrefError(call, f"{option} {text} is not finite", "give a number that is")
    return value
