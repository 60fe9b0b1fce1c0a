"""The coordinates of a cube: their steps, their direction, and their units.

Of a coordinate that is not uniform it is told whether its values are rounded, as the stamps of cameras are, or a sample
is lost or stands there twice: rounding is taken, the others are named with their number. Lengths and times in units
that are known become metres and seconds.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from leakref._base import LARGEST, FloatArray, IntArray
from leakref.cubes.formats import refuse

__all__ = ["JITTER", "LENGTHS", "Steps", "flat", "metric_factors", "stated_units", "steps"]

JITTER = 1e-3
"""How far, in spacings, a coordinate may be from its place without a word (float32 coordinates are off by 1e-4)."""
_UNSTEADY = 0.3
"""How far, in spacings, a stamp may be from its place where no frame is lost or doubled: cameras stamp unsteadily."""
LENGTHS = {
    **dict.fromkeys(("m", "metre", "metres", "meter", "meters"), 1.0),
    **dict.fromkeys(("km", "kilometre", "kilometres", "kilometer", "kilometers"), 1e3),
    **dict.fromkeys(("cm", "centimetre", "centimetres", "centimeter", "centimeters"), 1e-2),
    **dict.fromkeys(("mm", "millimetre", "millimetres", "millimeter", "millimeters"), 1e-3),
}
"""The units of length that files state, in metres."""
_TIMES = {
    **dict.fromkeys(("s", "sec", "secs", "second", "seconds"), 1.0),
    **dict.fromkeys(("ms", "msec", "millisecond", "milliseconds"), 1e-3),
    **dict.fromkeys(("us", "microsecond", "microseconds"), 1e-6),
    **dict.fromkeys(("ns", "nanosecond", "nanoseconds"), 1e-9),
    **dict.fromkeys(("min", "minute", "minutes"), 60.0),
    **dict.fromkeys(("h", "hr", "hour", "hours"), 3600.0),
    **dict.fromkeys(("d", "day", "days"), 86400.0),
}


@dataclass(frozen=True)
class Steps:
    """What the values of one coordinate come to.

    `step` is positive; `descends` says whether the values fall with the index. `lost` are pairs (index, how many) of
    samples that are missing behind that index, `doubled` the indices of samples with the value of the one before.
    `note` is what is worth saying, empty if the values are uniform.
    """

    step: float
    descends: bool = False
    lost: tuple[tuple[int, int], ...] = ()
    doubled: tuple[int, ...] = ()
    note: str = ""


def stated_units(raw: Mapping[str, Any]) -> dict[str, str]:
    """The units that a file states of x, y and t, in lower case and without "since ...", empty where it says none."""
    of = {name: str(raw.get(f"units of {name}", "")).strip().lower().split(" since ")[0] for name in "xyt"}
    return {name: "" if unit in ("1", "none", "dimensionless") else unit for name, unit in of.items()}


def metric_factors(units: Mapping[str, str]) -> dict[str, float] | None:
    """What x, y and t are to be multiplied by to be in metres and seconds, None if not all of their units are known."""
    known = {"x": LENGTHS, "y": LENGTHS, "t": _TIMES}
    if not all(units[name] in known[name] for name in "xyt"):
        return None
    return {name: known[name][units[name]] for name in "xyt"}


def flat(path: Path, name: str, values: npt.ArrayLike) -> npt.NDArray[Any]:
    """A coordinate as one row, (n,): also one that is stored for every pixel, as a meshgrid is.

    Refused is one of two axes that changes along both, since such a grid is turned or bent.
    """
    v = np.asarray(values)
    if v.ndim != 2 or 1 in v.shape:
        return np.ravel(v)
    if (v == v[:1]).all():
        return np.asarray(v[0])
    if (v == v[:, :1]).all():
        return np.asarray(v[:, 0])
    refuse(path, f"has a coordinate {name} of shape {v.shape} that changes along both", "interpolate onto a plain grid")


def _quantum(v: FloatArray, step: float) -> float:
    """The power of ten to which the values are rounded, 0 if none that is near the step."""
    for digits in range(-3, 10):
        unit = 10.0**-digits
        if unit < 1e-4 * step:
            return 0.0
        if unit < 4 * step and np.allclose(v / unit, np.rint(v / unit), rtol=0, atol=1e-6 + 1e-15 * np.abs(v / unit)):
            return unit
    return 0.0


def _numbers(path: Path, name: str, values: npt.ArrayLike, size: int, shape: tuple[int, ...]) -> FloatArray:
    """The values as float64, finite and as many as there are samples."""
    v = flat(path, name, values)
    if v.size != size:
        refuse(
            path,
            f"has {v.size} values of {name} for {size} samples: eta has shape {shape} as [x, y, t]",
            "pass --axes with the order in which eta is stored, or correct the coordinate",
        )
    if v.dtype.kind not in "iuf" or not np.isfinite(v).all():
        refuse(path, f"has a coordinate {name} that is not all finite real numbers", "correct it or pass --spacing")
    with np.errstate(over="ignore"):
        v = v.astype(np.float64)
        mean = float(v[-1] - v[0]) / (v.size - 1)
    if not 1 / LARGEST <= abs(mean) <= LARGEST and np.unique(v).size > 1:
        refuse(
            path,
            f"has a coordinate {name} from {v[0]:g} to {v[-1]:g}, beyond all reckoning",
            "give it in units that bring its steps nearer to 1",
        )
    return v


def steps(path: Path, name: str, values: npt.ArrayLike, shape: tuple[int, ...], axis: int) -> Steps:
    """The spacing of a coordinate of an axis of a cube of `shape`, and what is irregular in it. It may begin anywhere.

    Where it was made as i d the step is the very float d. Steps may differ by `JITTER` of a spacing, as float32
    coordinates do; stamps that are rounded or unsteady, by less than `_UNSTEADY` of one, are fitted by a straight line,
    and that is noted. x and y may fall with the index, a time may not. Refused is what neither rounding nor lost and
    doubled frames explain.
    """
    v = _numbers(path, name, values, shape[axis], shape)
    descends = bool(name != "t" and v[-1] < v[0])
    v = -v if descends else v
    index = np.arange(v.size)
    mean = float(v[-1] - v[0]) / (v.size - 1)
    first = float(v[1] - v[0])
    if np.array_equal(v[0] + index * first, v) and first > 0:
        return Steps(first, descends)
    if mean > 0 and np.abs(v - (v[0] + index * mean)).max() <= JITTER * mean:
        return Steps(mean, descends)
    rises = np.diff(v) >= 0 if name == "t" else np.diff(v) > 0
    if not rises.all() or not mean > 0:
        at = int(np.argmin(rises))
        sign, what = (-1, "decrease") if descends else (1, "increase")
        refuse(
            path,
            f"has a coordinate {name} that does not {what}: {sign * v[at]:g} is followed by {sign * v[at + 1]:g} "
            f"(index {at})",
            f"sort it, and reverse eta along {name} with it",
        )
    return _irregular(path, name, v, descends)


def _irregular(path: Path, name: str, v: FloatArray, descends: bool) -> Steps:
    """Of a coordinate that rises, but not evenly: rounded, or with lost and doubled samples, or refused."""
    typical = float(np.median(np.diff(v)))
    if typical <= 0:
        refuse(path, f"has a coordinate {name} most of whose values stand there twice", "pass --spacing dx,dy,dt")
    places = _places(v, typical)
    slope, origin = np.polyfit(places, v, 1)
    step, off = float(slope), np.abs(v - (origin + slope * places)) / slope
    quantum = _quantum(v, step)
    if off.max() > max(_UNSTEADY if name == "t" else JITTER, 0.51 * quantum / step):
        at = int(np.argmax(off))
        refuse(
            path,
            f"has a coordinate {name} that is not uniform: {v[at]:g} (index {at}) is {off.max():.2g} spacings from its "
            "place",
            f"interpolate eta onto equal steps, or take them as equal with --spacing (d{name} {step:.7g})",
        )
    gaps = np.diff(places)
    lost = tuple((int(at), int(gaps[at] - 1)) for at in np.flatnonzero(gaps > 1))
    doubled = tuple(int(at + 1) for at in np.flatnonzero(gaps == 0))
    if quantum and off.max() * step <= 0.51 * quantum:
        how = f"{name} is rounded to {quantum:g}"
    else:
        how = f"{name} is unsteady by up to {off.max():.2g} steps"
    return Steps(step, descends, lost, doubled, f"{how}: a step of {step:.7g} was fitted to it")


def _places(v: FloatArray, typical: float) -> IntArray:
    """The whole number of steps from the first value to each, by their differences: rounding does not add up in it.

    It is done twice, the second time with the step of the first, which is not rounded: stamps in milliseconds of 60
    frames a second are 16 or 17 apart.
    """
    places = np.concatenate([[0], np.cumsum(np.rint(np.diff(v) / typical))]).astype(np.int64)
    for _ in range(2):
        if places[-1] <= 0:
            break
        step = float(np.polyfit(places, v, 1)[0])
        places = np.concatenate([[0], np.cumsum(np.rint(np.diff(v) / step))]).astype(np.int64)
    return places
