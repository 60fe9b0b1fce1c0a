"""Iterative least squares: weak bins count as well, if they lie near the dispersion surface of the current so far.

The velocity c_0 of least squares over the strongest bins (`leastsquares`) is a first guess. Then, again and again, with
the bins j of a shell whose power is at least a fiftieth of the largest there and that lie near the surface of c_i,

    r_j(c, s) = omega_j - s omega0(k_j) - k_j.c,    |r_j(c_i, s_j)| <= a = 4 domega,    s_j = 1 or -1,

c_(i+1) is the minimum of the sum over these j of r_j(c, s_j)^2. k_j is the wave vector of a bin in rad per length,
omega_j its frequency and omega0 that of a wave of |k_j| in still water, in rad per time; s_j is that of the nearer
branch, -1 for waves that the current sweeps backwards; domega is the width of a bin. The velocity that is measured, in
lengths per time, is the one with which the bins no longer change.

Senet, Seemann and Ziemer 2001, doi 10.1109/36.911108. What is open in it is in decisions D37 and D38.
"""

from __future__ import annotations

from functools import partial
from typing import Any

import numpy as np
import numpy.typing as npt

from leakref import leastsquares
from leakref._base import fraction, positive
from leakref.dispersion import Water, law
from leakref.leastsquares import FREE, THRESHOLD, remarks
from leakref.shell import HALF_WIDTH, Extraction, Note, Optimum, Shell, checked_wavenumbers, collect, nothing, shell_at
from leakref.spectrum import Spectrum

__all__ = ["LOWER", "METHOD", "REACH", "extract", "optimum"]

LOWER = 0.02
"""Part of the shell's largest power below which bins are discarded after the first guess (decision D37)."""
REACH = 4.0
"""a in domega: how far from the dispersion surface bins may be (decision D38)."""
_TIE = (
    1e-10  # of a or of the largest power: what rounding might decide is noted, and as near to both is the first branch
)


def optimum(shell: Shell, threshold: float = THRESHOLD, lower: float = LOWER, reach: float = REACH) -> Optimum:
    """Where the bins no longer change; `threshold` and `lower` of the largest power, `reach` a in domega.

    There is no number where the first guess has none, or where the bins change for ever.
    """
    guess = leastsquares.optimum(shell, threshold)
    if not np.isfinite(guess.velocity).all():
        return guess
    power, a = (shell.magnitude / shell.magnitude.max()) ** 2, reach * shell.omega[1]
    column, m = np.nonzero(power >= lower)
    k, omega, intrinsic = np.stack([shell.kx[column], shell.ky[column]]), shell.omega[m], shell.intrinsic[column]
    close = Note.THRESHOLD in guess.note or bool(np.any(np.abs(power - lower) < _TIE))
    velocity, before = guess.velocity, np.full(column.size, np.nan)
    for count in range(100):
        moved = omega - velocity @ k
        sign = np.where(np.abs(moved + intrinsic) < np.abs(moved - intrinsic) - _TIE * a, -1.0, 1.0)
        off = np.abs(moved - sign * intrinsic) / a
        close |= bool(np.any(np.abs(off - 1) < _TIE))
        taken = np.where(off <= 1, sign, 0.0)
        if np.array_equal(taken, before):
            break
        before, here = taken, taken != 0
        near, shift = k[:, here], (omega - sign * intrinsic)[here]
        normal = near @ near.T
        soft, stiff = np.linalg.eigvalsh(normal)
        if soft <= FREE * stiff:
            return nothing(remarks(int(here.sum()), close, soft, stiff) | Note.FLAT, count)
        velocity = np.linalg.solve(normal, near @ shift)
    else:
        return nothing(Note.UNCONVERGED, count)
    used = np.zeros(power.shape, dtype=np.bool_)
    used[column[here], m[here]] = True
    residual = velocity @ near - shift
    note = remarks(int(here.sum()), close, soft, stiff) | shell.notes(used)
    return Optimum(velocity, float(residual @ residual), 2 * (near @ residual), 2 * normal, count, note)


def extract(
    spectrum: Spectrum,
    wavenumbers: npt.ArrayLike,
    *,
    gravity: float | None = None,
    water: Water | None = None,
    threshold: float = THRESHOLD,
    lower: float = LOWER,
    reach: float = REACH,
    half_width: float = HALF_WIDTH,
) -> Extraction:
    """Doppler shift velocities by iterative least squares, one for each wavenumber (n,).

    `water` is the law of dispersion, or `gravity` that of deep water: one of them is given. Raises LeakrefError.
    """
    call = "lsiterative.extract"
    k = checked_wavenumbers(wavenumbers, call)
    fraction(call, threshold=threshold, lower=lower)
    positive(call, reach=reach)
    shell = partial(shell_at, spectrum, water=law(call, gravity, water), half_width=half_width)
    return collect("ls-iterative", k, [optimum(shell(k_i), threshold, lower, reach) for k_i in k])


METHOD: dict[str, Any] = {
    "id": "ls-iterative", "title": "iterative LS", "words": "iterative least squares", "extract": extract,
    "optimum": optimum, "settings": {"threshold": THRESHOLD, "lower": LOWER, "reach": REACH}, "exact_on_bins": True,
    "silences": Note.NO_SIGNAL | Note.UNCONVERGED | Note.TOO_FEW_BINS,
}  # fmt: skip
"""The record of the register (`methods`)."""
