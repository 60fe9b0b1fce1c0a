"""At which wavenumbers a user's cube is looked at.

They are in rad per unit of length of the cube. The lists and ranges of the command line are read here, and the default
is made: as many shells as the cube has, none of them cut off by the Nyquist wavenumber.
"""

from __future__ import annotations

import numpy as np

from leakref._base import FloatArray, LeakrefError
from leakref.grid import Grid
from leakref.shell import EDGE_MARGIN, HALF_WIDTH

__all__ = ["default_wavenumbers", "parse_numbers", "parse_wavenumbers"]

SMALLEST = 4
"""The first wavenumber by default, in dk: its shell keeps clear of the bins into which a Hann window spreads a mean."""


def parse_numbers(option: str, text: str, count: int | None = None) -> list[float]:
    """Numbers separated by commas. Raises LeakrefError.

    `option` and `text` are as typed, for the message; `count` is how many there must be. Refused are words, NaN and
    infinite ones.
    """
    try:
        values = [float(word) for word in text.split(",")]
    except ValueError:
        values = []
    if not values or (count is not None and len(values) != count) or not np.isfinite(values).all():
        example = "0.4,0.5,0.6" if count is None else ",".join(["0.5", "0.5", "0.2"][:count])
        raise LeakrefError(
            "extract",
            f"{option} {text} is not {count or 'a list of'} finite numbers",
            f"separate them by commas, as in {option} {example}",
        )
    return values


def parse_wavenumbers(text: str) -> FloatArray:
    """A list, "0.4,0.5", or a range with both its ends, "0.4:3.5:0.1". Raises LeakrefError.

    Returned is an array (n,), ascending where it is a range. A range of more than 100 000, or one that runs backwards,
    is refused.
    """
    if ":" not in text:
        return np.array(parse_numbers("--wavenumbers", text))
    values = parse_numbers("--wavenumbers", text.replace(":", ","))
    if text.count(":") != 2 or len(values) != 3 or values[2] <= 0 or values[1] < values[0]:
        raise LeakrefError("extract", f"--wavenumbers {text} is no range", "write first:last:step, as in 0.4:3.5:0.1")
    first, last, step = values
    count = int((last - first) / step + 1e-9) + 1
    if count > 100_000:
        raise LeakrefError("extract", f"--wavenumbers {text} is {count} wavenumbers", "take a larger step")
    return first + np.arange(count) * step


def default_wavenumbers(grid: Grid, largest: float = np.inf) -> FloatArray:
    """i dk, one a bin, from SMALLEST dk to the largest whole shell below the Nyquist wavenumber and `largest`.

    `dk` is the larger of the bin widths along x and y. Returned is an array (n,). Raises LeakrefError for a cube too
    small to have any.
    """
    dk = grid.wavenumber_resolution
    top = min(min(grid.nyquist[:2]) * (1 - EDGE_MARGIN) - HALF_WIDTH * dk, largest)
    last = int(np.ceil(top / dk - 1e-9)) - 1  # strictly inside
    if last < SMALLEST:
        raise LeakrefError(
            "extract",
            f"a cube of {grid.shape[0]} x {grid.shape[1]} samples has no whole shell from {SMALLEST} dk up",
            "pass --wavenumbers, or use a larger or finer cube",
        )
    return np.arange(SMALLEST, last + 1) * dk
