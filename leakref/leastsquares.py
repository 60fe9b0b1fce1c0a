"""Least squares: the current that brings the dispersion surface closest to the strong bins."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from leakref._base import LeakrefError
from leakref.shell import HALF_WIDTH, Extraction, Note, Optimum, Shell, checked_wavenumbers, collect, nothing, shell_at
from leakref.spectrum import Spectrum

__all__ = ["SOFT", "THRESHOLD", "extract", "optimum"]

THRESHOLD = 0.2
"""Bins below this part of the shell's own largest power are discarded (app:numdetails, decision D7)."""

SOFT = 1e-3
"""Softest over stiffest direction of C: below, the bins lie almost on one line and hardly fix the current across it."""


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
    note = shell.notes(strong)
    if np.any(np.abs(power - threshold) < 1e-10):
        note |= Note.THRESHOLD
    if column.size < 2:
        note |= Note.TOO_FEW_BINS
    if soft < SOFT * stiff:
        note |= Note.FLAT
    if soft <= 1e-9 * stiff:
        return nothing(note)
    velocity = np.linalg.solve(normal, k @ shift)
    residual = velocity @ k - shift
    return velocity, float(residual @ residual), 2 * (k @ residual), 2 * normal, 0, note


def extract(spectrum: Spectrum, wavenumbers: npt.ArrayLike, *, gravity: float = 1.0, threshold: float = THRESHOLD,
            half_width: float = HALF_WIDTH) -> Extraction:
    """Doppler shift velocities by least squares (sec:LSvsNSP), one for each wavenumber (n,). Raises LeakrefError."""
    k = checked_wavenumbers(wavenumbers, "leastsquares.extract")
    if not (isinstance(threshold, int | float) and 0 < threshold <= 1):
        raise LeakrefError("leastsquares.extract", f"threshold = {threshold}",
                           "give a part of the largest power, above 0 and at most 1")
    return collect("ls", k, [optimum(shell_at(spectrum, k_i, gravity=gravity, half_width=half_width), threshold)
                             for k_i in k])
