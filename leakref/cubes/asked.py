"""What was asked for of a file, and what is then taken for granted about it.

`Asked` holds the options that say what a file does not. `Assumed` is what is in force once the file has been read: it
is printed in a line, stands in the JSON, and says of each thing where it comes from.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from typing import Any

import numpy as np

from leakref._base import LeakrefError
from leakref.planning.quantities import DEEP_WATER, depth_words, tension_words

__all__ = ["Asked", "Assumed", "in_words", "parse_crop", "parse_range", "parse_spacing"]


@dataclass(frozen=True)
class Asked:
    """The options that go before what a file says, or say what it leaves open. None: not asked.

    - `variable`: the name of the samples in the file, such as eta or IMG_SEQ.IMG.
    - `axes`: a permutation of "xyt", the order in which the samples are stored, first index first.
    - `y`: "up" if a larger row is a larger y, "down" if rows are counted downwards, as in images.
    - `spacing`: (dx, dy, dt), or (dx, dy) where the file knows its frame rate.
    - `gravity`: in the units of length and time that the cube is read in. So are `depth` and `surface_tension`, unless
      they are words with a unit, such as "4m", or "deep" and "water" (see `waters`).
    - `crop`: slices along x and along y, of samples as they are stored; `frames`: one along t.
    - `holes`: up to this share of samples may be missing (NaN): they are filled with the mean, lost frames by
      interpolation.
    - `drop_doubled`: leave out frames that are the same as the one before.

    LeakrefError is raised for axes that are no permutation, another y, and a share of holes outside [0, 1).
    """

    variable: str | None = None
    axes: str | None = None
    y: str | None = None
    spacing: Sequence[float] | None = None
    gravity: float | None = None
    depth: float | str | None = None
    surface_tension: float | str | None = None
    crop: tuple[slice, slice] = field(default=(slice(None), slice(None)))
    frames: slice = field(default_factory=lambda: slice(None))
    holes: float = 0.0
    drop_doubled: bool = False

    def __post_init__(self) -> None:
        if self.axes is not None and sorted(self.axes) != ["t", "x", "y"]:
            raise LeakrefError(
                "extract", f"--axes {self.axes} is not a permutation of xyt", "pass for instance --axes txy"
            )
        if self.y not in (None, "up", "down"):
            raise LeakrefError("extract", f"--y {self.y} is no direction", "say up, or down for rows of images")
        if not 0 <= self.holes < 1:
            raise LeakrefError(
                "extract", f"--fill-holes {self.holes:g} is no share of the samples", "pass one such as 0.05"
            )

    @property
    def cut(self) -> dict[str, slice]:
        """What is wanted along each of x, y and t, in samples as they are stored."""
        return {"x": self.crop[0], "y": self.crop[1], "t": self.frames}


@dataclass(frozen=True)
class Assumed:
    """What is taken for granted about a cube, and where each of it comes from.

    `axes` is the order in which the file stores the samples, `y` where its rows run ("up" or "down"); velocities are
    always along x to the right and y upwards. `step` is (dx, dy, dt) in the units of the cube. `sources` are words such
    as "--axes" or "the file", by the names of the fields.
    """

    variable: str
    axes: str
    y: str
    units: str
    gravity: float
    step: tuple[float, float, float]
    depth: float = np.inf
    surface_tension: float = 0.0
    sources: dict[str, str] = field(default_factory=dict)

    def record(self) -> dict[str, Any]:
        """The fields of `assumed` in the JSON."""
        names = ("variable", "axes", "y", "units", "gravity", "depth", "surface_tension", "step")
        deep = {"depth": DEEP_WATER} if self.depth == np.inf else {}
        return {name: getattr(self, name) for name in names} | deep | {"from": dict(self.sources)}

    def line(self) -> str:
        """All of it in one line, with the source of each in brackets."""
        metric = self.units == "si"
        length, time, g = ("m", "s", "m/s2") if metric else ("", "", "")
        units = {"si": "metres and seconds", "scaled": "scaled (k0 = omega0 = g = 1)", "given": "those of the file"}
        dx, dy, dt = (f"{d:.6g}" for d in self.step)
        said = {
            "variable": f"{self.variable}[{', '.join(self.axes)}]",
            "y": f"y {self.y}wards along the rows",
            "units": f"units {units[self.units]}",
            "gravity": f"gravity {self.gravity:.6g} {g}".rstrip(),
            "depth": depth_words(self.depth, "m" * metric),
            "surface_tension": tension_words(self.surface_tension, "m3/s2" * metric),
            "step": f"dx, dy {dx}, {dy} {length}".rstrip() + f", dt {dt} {time}".rstrip(),
        }
        source = {**self.sources, "variable": self.sources.get("axes", "")}
        words = (text + (f" ({source[name]})" if source.get(name) else "") for name, text in said.items() if text)
        return f"Taken: {'; '.join(words)}."


def in_words(depth: float, surface_tension: float, units: str) -> str:
    """Depth and surface tension of a cube in `units`, for lines and titles."""
    metric = units == "si"
    words = depth_words(depth, "m" * metric), tension_words(surface_tension, "m3/s2" * metric)
    return ", ".join(word for word in words if word)


def parse_spacing(text: str) -> list[float]:
    """(dx, dy, dt) or (dx, dy) from "0.3,0.3,1/29.97": numbers or fractions, separated by commas. Raises LeakrefError.

    What is positive is seen to by the grid. A dt may be written as one over the frame rate, since that is what cameras
    state.
    """
    try:
        parts = [word.split("/") for word in text.split(",")]
        values = [float(Fraction(part[0]) / Fraction(part[1]) if len(part) == 2 else Fraction(*part)) for part in parts]
    except (ValueError, TypeError, ZeroDivisionError, OverflowError):
        values = []
    if len(values) not in (2, 3):
        raise LeakrefError(
            "extract",
            f"--spacing {text} is not 3 finite numbers",
            "separate them by commas, as in --spacing 0.5,0.5,0.2 or 0.5,0.5,1/29.97",
        )
    return values


def parse_range(option: str, text: str) -> slice:
    """A slice from "first:end" or "first:end:step", counted from 0, end not included; either may be left out.

    Raises LeakrefError for what is none: words, negative numbers, a step below 1, an end that is not behind the first.
    """
    parts = text.split(":")
    try:
        numbers = [int(part) if part.strip() else None for part in parts]
    except ValueError:
        numbers = []
    first, end, step = (*numbers, None, None, None)[:3]
    wrong = len(numbers) not in (2, 3) or any(n is not None and n < 0 for n in numbers) or step == 0
    if wrong or (end is not None and end <= (first or 0)):
        raise LeakrefError(
            "extract", f"{option} {text} is no range", "write first:end, counted from 0, the end not included: 0:600"
        )
    return slice(first, end, step)


def parse_crop(text: str) -> tuple[slice, slice]:
    """The region of interest from "x0:x1,y0:y1", in samples as they are stored. Raises LeakrefError."""
    parts = text.split(",")
    if len(parts) != 2:
        raise LeakrefError(
            "extract", f"--crop {text} is not two ranges", "write x0:x1,y0:y1 in samples, as in --crop 100:500,50:450"
        )
    along_x, along_y = (parse_range("--crop", part) for part in parts)
    if np.any([(s.step or 1) != 1 for s in (along_x, along_y)]):
        raise LeakrefError("extract", f"--crop {text} leaves samples out", "give only the first and the end of each")
    return along_x, along_y
