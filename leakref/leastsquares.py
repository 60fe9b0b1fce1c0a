"""Least squares: the current that brings the dispersion surface closest to the strong bins.

Of a Doppler shift velocity c the sum of squares is (eq:LS1, equation 21)

    C(c) = sum over j of (omega0(k_j) + k_j.c - omega_j)^2

over the bins j of a shell with omega >= 0 whose power is at least a fifth of the largest there. k_j is the wave vector
of a bin in rad per length, omega_j its frequency and omega0 that of a wave of |k_j| in still water, in rad per time.
The velocity that is measured is the c in lengths per time where C is smallest.
"""

from __future__ import annotations

from functools import partial

import numpy as np
import numpy.typing as npt

from leakref._base import fraction
from leakref.dispersion import Water, law
from leakref.shell import HALF_WIDTH, Extraction, Note, Optimum, Shell, checked_wavenumbers, collect, nothing, shell_at
from leakref.spectrum import Spectrum

__all__ = ["FREE", "THRESHOLD", "extract", "optimum", "remarks"]

THRESHOLD = 0.2
"""Bins below this part of the shell's own largest power are discarded (app:numdetails, decision D7)."""

_SOFT = 1e-3  # softest over stiffest direction of C: below, the bins lie almost on one line, and hardly fix the current
FREE = 1e-9
"""The same, where there is no number: the bins lie on one line."""


def remarks(bins: int, close: bool, soft: float, stiff: float) -> Note:
    """What is to be said of the fit to so many bins, one of them `close` to the threshold, with these curvatures."""
    note = Note.THRESHOLD if close else Note.NONE
    note |= Note.TOO_FEW_BINS if bins < 2 else Note.NONE
    return note | (Note.FLAT if soft < _SOFT * stiff or not stiff else Note.NONE)


def optimum(shell: Shell, threshold: float = THRESHOLD) -> Optimum:
    """The minimum of C of eq:LS1 over the bins with omega >= 0 (decision D19), in closed form (D8).

    C is quadratic in the current: sum of k k^T c = sum of k (omega - omega0(k)).
    """
    if shell.is_empty:
        return nothing(Note.NO_SIGNAL)
    power = (shell.magnitude / shell.magnitude.max()) ** 2
    strong = power >= threshold
    column, m = np.nonzero(strong)
    k = np.stack([shell.kx[column], shell.ky[column]])
    shift = shell.omega[m] - shell.intrinsic[column]
    normal = k @ k.T
    soft, stiff = np.linalg.eigvalsh(normal)
    note = remarks(column.size, bool(np.any(np.abs(power - threshold) < 1e-10)), soft, stiff) | shell.notes(strong)
    if soft <= FREE * stiff:
        return nothing(note)
    velocity = np.linalg.solve(normal, k @ shift)
    residual = velocity @ k - shift
    return Optimum(velocity, float(residual @ residual), 2 * (k @ residual), 2 * normal, 0, note)


def extract(
    spectrum: Spectrum,
    wavenumbers: npt.ArrayLike,
    *,
    gravity: float | None = None,
    water: Water | None = None,
    threshold: float = THRESHOLD,
    half_width: float = HALF_WIDTH,
) -> Extraction:
    """Doppler shift velocities by least squares (sec:LSvsNSP), one for each wavenumber (n,).

    `water` is the law of dispersion, or `gravity` that of deep water: one of them is given. Raises LeakrefError.
    """
    k = checked_wavenumbers(wavenumbers, "leastsquares.extract")
    fraction("leastsquares.extract", threshold=threshold)
    shell = partial(shell_at, spectrum, water=law("leastsquares.extract", gravity, water), half_width=half_width)
    return collect("ls", k, [optimum(shell(k_i), threshold) for k_i in k])
