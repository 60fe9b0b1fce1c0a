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

__all__ = [
    "CLEAN_WATER",
    "DEEP_WATER",
    "EXAMPLES",
    "depth_fault",
    "depth_words",
    "number",
    "quantity",
    "tension_fault",
    "tension_words",
]

EXAMPLES = {"m": "128m", "s": "30s", "deg": "45deg", "m/s": "0.3m/s", "Hz": "2Hz", "m^3/s^2": "7.3e-5m3/s2"}
"""The units that are asked for, and how one writes such a quantity."""
DEEP_WATER = "deep water"
"""A depth without end, in lines, titles and JSON."""
CLEAN_WATER = 7.29e-5
"""Surface tension of clean water at 20 degrees over its density, 0.0728 N/m / 998 kg/m3, in m3/s2."""
_DEEPEST = 1.2e4  # m: no ocean is deeper
_STRONGEST = 1e-3  # m3/s2: no liquid has more, and 0.07 is that of water in N/m
_WRITTEN = re.compile(r"\s*([+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?)\s*([^\s\d.+-][\w\s/*^°.-]{0,40})?\s*")


@cache
def _registry() -> Any:
    from pint import UnitRegistry

    return UnitRegistry()


def quantity(call: str, option: str, text: str, unit: str, example: str | None = None) -> float:
    """`text` in `unit`, whatever unit of that kind it is written in. Raises LeakrefError, and if there is no unit.
    `call`, `option` and an `example` are for the message. Refused are also units of another kind, plain numbers for an
    angle, and what is not finite.
    """
    from pint.errors import PintError

    example = f"write it as in {option} {example or EXAMPLES[unit]}"
    written = _WRITTEN.fullmatch(text)
    if written is None:
        raise LeakrefError(call, f"{option} {text} is not a number with a unit", example)
    if written[2] is None:
        raise LeakrefError(call, f"{option} {text} has no unit", example)
    try:
        plain = re.sub(r"(?<=[A-Za-z])(?=\d)", "^", written[2])  # m3/s2, as it is written
        units = _registry().parse_units(f"1{plain}" if plain.startswith("/") else plain)
    except (PintError, ValueError, AssertionError, TypeError, KeyError, AttributeError):
        raise LeakrefError(call, f"{option} {text}: there is no unit {written[2].strip()!r}", example) from None
    angle = unit == "deg"  # which pint counts as a plain number, so that any other would pass for radians
    if not units.is_compatible_with(unit) or (angle and not _is_angle(units)):
        raise LeakrefError(call, f"{option} {text}: {units} cannot be had in {unit}", example)
    return _finite(call, option, text, float(_registry().Quantity(float(written[1]), units).to(unit).magnitude))


def _is_angle(units: Any) -> bool:
    """Whether `units` is one unit of angle and nothing else."""
    return str(units) in ("degree", "radian", "turn", "arcminute", "arcsecond", "grade", "milliradian")


def depth_fault(depth: float) -> str:
    """What is wrong with a depth in m, in words that follow it; empty if nothing is, or if it is infinite."""
    if depth != depth or depth <= 0:
        return "is not positive: a depth counts downwards from the surface"
    return "is deeper than any ocean" if _DEEPEST < depth < math.inf else ""


def tension_fault(surface_tension: float) -> str:
    """What is wrong with a surface tension over the density in m3/s2, empty if nothing is."""
    if not 0 <= surface_tension < math.inf:
        return "is not a number of at least 0"
    too_much = "is more than any liquid has: divide it by the density, 0.073 N/m is 7.3e-5 m3/s2 for water"
    return too_much if surface_tension > _STRONGEST else ""


def depth_words(depth: float, unit: str = "m") -> str:
    """A depth in words, for lines and titles."""
    return DEEP_WATER if depth == math.inf else f"depth {depth:.6g} {unit}".rstrip()


def tension_words(surface_tension: float, unit: str = "m3/s2") -> str:
    """A surface tension over the density in words, empty if there is none."""
    return f"surface tension {surface_tension:.3g} {unit}".rstrip() if surface_tension else ""


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
