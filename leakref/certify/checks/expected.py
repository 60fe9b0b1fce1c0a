"""What the reference says of a cube, sooner: by the fast path, which tests hold against the literal chain."""

from __future__ import annotations

from functools import lru_cache

import numpy as np
import numpy.typing as npt

from leakref import fast
from leakref._base import FloatArray
from leakref.certify.checks.inputs import Cube
from leakref.nsp import WIDTH, normalized_scalar_product
from leakref.shell import Extraction, shell_at
from leakref.spectrum import Spectrum, fourier
from leakref.window import WINDOWS

__all__ = ["expected", "score", "unflagged"]


@lru_cache(maxsize=256)
def expected(cube: Cube, window: str, method: str) -> Extraction:
    """The reference's answer. A window or method that it does not know stands for Hann and the NSP."""
    window, method = window if window in WINDOWS else "hann", method if method == "ls" else "nsp"
    return fast.realize(cube.components, cube.grid, cube.wavenumbers, windows=(window,),
                        methods=(method,))[window, method]


def unflagged(cube: Cube, window: str, method: str) -> npt.NDArray[np.bool_]:
    """The shells (n,) of which the reference has a number and nothing to note."""
    return np.array([not note for note in expected(cube, window, method).notes])


@lru_cache(maxsize=8)
def _spectrum(cube: Cube, window: str) -> Spectrum:
    return fourier(cube.surface, cube.grid, window, workers=1)


def score(cube: Cube, window: str, wavenumber: float, velocity: FloatArray) -> float:
    """N of eq:normSp at a velocity (2,), as the reference sees the cube."""
    shell = shell_at(_spectrum(cube, window), wavenumber)
    return normalized_scalar_product(shell, velocity, WIDTH * cube.grid.frequency_resolution)
