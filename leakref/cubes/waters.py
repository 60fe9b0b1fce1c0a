"""The depth and the surface tension of the water in a cube: what was asked for, and what the file says.

Both are in the units of the cube. `--depth` and `--surface-tension` take a plain number in those units or one with a
unit, which says something only where the cube is known to be in metres and seconds: "4m", "13 ft", "7.3e-5 m3/s2".
"deep" is a depth that no wave feels, "water" the surface tension of clean water. What is asked for goes before the
file, and that the two differ is said.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from leakref._base import LARGEST, LeakrefError
from leakref.cubes.asked import Asked
from leakref.cubes.coordinates import LENGTHS
from leakref.cubes.suspicion import refuse
from leakref.planning.quantities import CLEAN_WATER, depth_fault, quantity, tension_fault

__all__ = ["EARTH", "Said", "is_metric", "water_of"]

EARTH = (9.7, 9.9)
"""Gravity in m/s2: a cube whose gravity lies here is in metres and seconds."""
_DEPTH, _TENSION = "depth", "surface_tension"
_OPTIONS = {_DEPTH: "--depth", _TENSION: "--surface-tension"}
_UNITS = {_DEPTH: "m", _TENSION: "m^3/s^2"}
_WORDS = {_DEPTH: ("deep", math.inf), _TENSION: ("water", CLEAN_WATER)}
_WRITTEN = {
    _DEPTH: "write it as in --depth 4m, or --depth deep",
    _TENSION: "write it as in --surface-tension 7.3e-5m3/s2, or --surface-tension water",
}


@dataclass(frozen=True)
class Said:
    """The water of a cube in its units, and where each of the two numbers is known from."""

    depth: float = math.inf
    surface_tension: float = 0.0
    sources: dict[str, str] = field(default_factory=dict)


def is_metric(units: str, gravity: float) -> bool:
    """Whether a cube is in metres and seconds: because its file says so, or by its gravity."""
    return units == "si" or (units != "scaled" and EARTH[0] < gravity < EARTH[1])


def water_of(
    path: Path,
    raw: Mapping[str, Any],
    units: str,
    factors: Mapping[str, float],
    gravity: float,
    asked: Asked,
    notes: list[str],
) -> Said:
    """The depth and the surface tension of the cube in a file; deep and none where neither file nor options say it.

    `factors` is what x, y and t of the file were multiplied by to be metric. A difference between what was asked for
    and what the file says is added to `notes`, and so is what was not taken. LeakrefError is raised for what is no such
    quantity, for a unit where the cube has none, and for what no water has.
    """
    metric = is_metric(units, gravity)
    values, sources = {_DEPTH: math.inf, _TENSION: 0.0}, {_DEPTH: "by default; --depth if not"}
    for name in values:
        said = getattr(asked, name)
        if said is not None:
            values[name], sources[name] = _asked_for(name, said, metric), _OPTIONS[name]
            _contradicted(path, name, values[name], raw, factors, metric, notes)
        elif name in raw and not _is_coordinate(name, raw, notes):
            values[name], sources[name] = _in_file(path, name, raw, factors, metric), "the file"
    return Said(values[_DEPTH], values[_TENSION], sources)


def _asked_for(name: str, said: float | str, metric: bool) -> float:
    """An option as a number in the units of the cube."""
    option, (word, meaning) = _OPTIONS[name], _WORDS[name]
    text = str(said).strip()
    with_unit = not _is_number(text)
    if text.lower() == word and name == _DEPTH:
        return meaning
    if with_unit and not metric and (text.lower() == word or any(c.isdigit() for c in text)):
        raise LeakrefError(
            "extract",
            f"{option} {text} is in metres, and the cube is not known to be in metres and seconds",
            f"give {option} as a plain number, in the cube's own units of length and time",
        )
    if text.lower() == word:
        return meaning
    if not with_unit:
        value = float(text)
    else:
        try:
            value = quantity("extract", option, text, _UNITS[name])
        except LeakrefError as error:
            per_density = ", and over the density: 0.073 N/m is 7.3e-5 m3/s2" if name == _TENSION else ""
            raise LeakrefError("extract", error.fault, _WRITTEN[name] + per_density) from None
    fault = _fault(name, value, metric)
    if fault:
        raise LeakrefError("extract", f"{option} {text} {fault}", _WRITTEN[name])
    return value


def _is_number(text: str) -> bool:
    try:
        float(text)
    except ValueError:
        return False
    return True


def _fault(name: str, value: float, metric: bool) -> str:
    """What is wrong with a number, empty if nothing is."""
    if not math.isfinite(value):
        return "is not a finite number"
    fault = (depth_fault if name == _DEPTH else tension_fault)(value)
    if fault and (metric or value <= 0):  # what is too much is known in metres only
        return fault
    return "is beyond all reckoning" if value and not 1 / LARGEST <= value <= LARGEST else ""


def _is_coordinate(name: str, raw: Mapping[str, Any], notes: list[str]) -> bool:
    """Whether what is called depth is a coordinate of its own, levels at which something was measured."""
    if not raw.get(f"coordinate {name}"):
        return False
    notes.append(f"the file's {name} is a coordinate of its own and was not taken for that of the water")
    return True


def _in_file(path: Path, name: str, raw: Mapping[str, Any], factors: Mapping[str, float], metric: bool) -> float:
    """The number in the file, in the units of the cube. Refused, with the option that helps, is all else."""
    remedy = f"pass {_OPTIONS[name]}" + (", or --depth deep" if name == _DEPTH else ", 0 for none")
    array = np.asarray(raw[name])
    if array.size != 1 or array.dtype.kind not in "iuf":
        refuse(path, f"has a {name} of shape {array.shape} that is not one number", remedy)
    value, unit = float(array.ravel()[0]), str(raw.get(f"units of {name}", "")).strip().lower()
    if value == math.inf and name == _DEPTH:
        return value
    if metric and unit in LENGTHS and name == _DEPTH:
        value *= LENGTHS[unit]
    elif any(factor != 1 for factor in factors.values()) and unit not in ("m3 s-2", "m3/s2"):
        refuse(path, f"was converted to metres and seconds, but says {name} = {value:g} in {unit or 'no unit'}", remedy)
    fault = _fault(name, value, metric)
    if fault:
        refuse(path, f"has {name} = {value:g}, which {fault}", remedy)
    return value


def _contradicted(
    path: Path,
    name: str,
    value: float,
    raw: Mapping[str, Any],
    factors: Mapping[str, float],
    metric: bool,
    notes: list[str],
) -> None:
    """Say so if the file holds another number than was asked for."""
    if name not in raw or _is_coordinate(name, raw, []):
        return
    try:
        own = _in_file(path, name, raw, factors, metric)
    except LeakrefError:
        notes.append(f"{_OPTIONS[name]} was taken; what the file says of its {name} is not a number to go by")
        return
    if own != value and not math.isclose(own, value, rel_tol=1e-6):
        notes.append(f"WARNING: {_OPTIONS[name]} {value:g} was taken, and the file says {name} = {own:g}")
