"""The polar current shell: the sine curve over direction on which the crest of a shell lies.

Seen along a circle of wave vectors k (cos theta, sin theta), a current c moves the frequencies of waves off omega0(k)
by k.c, a sine curve over theta. Of each column n of a shell, of wave vector k_n in rad per length, the crest is the
frequency (rad per time; P = F^2 is the power, m* the bin where it is largest)

    omega_n = sum of omega P over the bins m* - 1, m*, m* + 1, over the sum of P there,

if that largest power is at least a fifth of the shell's own. Through these points the curve is fitted robustly, by
Tukey's biweight: with r_n(c) = omega_n - omega0(k_n) - k_n.c, omega0 the frequency in still water and a = 4 domega,

    C(c) = (a^2 / 3) sum over n of 1 - (1 - (r_n / a)^2)^3 if |r_n| < a, and of 1 if not,

which is sum r_n^2 where all r_n are small, and to which points further off than a do not matter. The velocity that is
measured is the minimum of C, in lengths per time, that is reached from that of sum r_n^2 by weighted least squares,

    sum w_n k_n k_n^T c = sum w_n k_n (omega_n - omega0(k_n)),    w_n = (1 - (r_n / a)^2)^2 if |r_n| < a, else 0.

Shen, Huang, Gill, Carrasco and Horstmann 2015, doi 10.3390/rs70607753; as an alternative to the scalar product named by
Smeltzer, Aesoy, Adnoy and Ellingsen 2019, doi 10.1029/2019JC015202. What is open in them is in decisions D33 and D34.
"""

from __future__ import annotations

from functools import partial
from typing import Any

import numpy as np
import numpy.typing as npt

from leakref._base import fraction, positive
from leakref.dispersion import Water, law
from leakref.leastsquares import FREE, THRESHOLD, remarks
from leakref.shell import HALF_WIDTH, Extraction, Note, Optimum, Shell, checked_wavenumbers, collect, nothing, shell_at
from leakref.spectrum import Spectrum

__all__ = ["METHOD", "OUTLIER", "extract", "optimum"]

OUTLIER = 4.0
"""a in domega: points of the crest further from the curve are outliers (decision D34)."""
_NEAR = 0.01  # of a: from steps as small on, Newton's method
_TIE = 1e-10  # of the largest power: two bins as near may change places by rounding


def optimum(shell: Shell, threshold: float = THRESHOLD, outlier: float = OUTLIER) -> Optimum:
    """The minimum of C over the crest of a shell; `threshold` of the largest power, `outlier` a in domega."""
    if shell.is_empty:
        return nothing(Note.NO_SIGNAL)
    power = (shell.magnitude / shell.magnitude.max()) ** 2
    tops, a = power.max(axis=1), outlier * shell.omega[1]
    column = np.flatnonzero(tops >= threshold)
    near = np.abs(power - tops[:, None]) < _TIE * tops[:, None]
    close = bool(np.any(np.abs(tops - threshold) < _TIE) or np.any(near[column].sum(axis=1) > 1))
    m = power[column].argmax(axis=1)[:, None] + np.array([-1, 0, 1])
    part = np.pad(power, ((0, 0), (1, 1)))[column[:, None], m + 1]
    m = np.clip(m, 0, shell.omega.size - 1)
    crest = np.sum(shell.omega[m] * part, axis=1) / part.sum(axis=1)
    k, shift = np.stack([shell.kx[column], shell.ky[column]]), crest - shell.intrinsic[column]
    velocity, weight = np.zeros(2), np.ones(column.size)
    hessian = 2 * k @ k.T
    for count in range(1, 200):
        normal = (k * weight) @ k.T
        soft, stiff = np.linalg.eigvalsh(normal)
        if soft <= FREE * stiff:
            return nothing(remarks(column.size, close, soft, stiff) | Note.FLAT, count)
        pull = (k * weight) @ (shift - velocity @ k)
        step = np.linalg.solve(normal, pull)
        if np.hypot(*step) * shell.wavenumber < _NEAR * a and np.linalg.eigvalsh(hessian)[0] > 0:
            step = np.linalg.solve(hessian, 2 * pull)  # Newton's, which ends sooner
        velocity = velocity + step
        z = (shift - velocity @ k) / a
        inside = np.abs(z) < 1
        weight = np.where(inside, (1 - z**2) ** 2, 0.0)
        hessian = 2 * (k * np.where(inside, (1 - z**2) * (1 - 5 * z**2), 0.0)) @ k.T
        length = np.hypot(*step) * shell.wavenumber / shell.frequency
        if count > 1 and (length < 1e-14 or (count > 50 and length < 1e-12)):
            break
    else:
        return nothing(Note.UNCONVERGED, count)
    used = np.zeros(power.shape, dtype=np.bool_)
    used[column, m[:, 1]] = weight > 0
    soft, stiff = np.linalg.eigvalsh(hessian)
    note = remarks(int(np.sum(weight > 0)), close, soft, stiff) | shell.notes(used)
    cost = float(a**2 / 3 * np.sum(1 - np.where(inside, (1 - z**2) ** 3, 0.0)))
    return Optimum(velocity, cost, -2 * a * (k @ (weight * z)), hessian, count, note)


def extract(
    spectrum: Spectrum,
    wavenumbers: npt.ArrayLike,
    *,
    gravity: float | None = None,
    water: Water | None = None,
    threshold: float = THRESHOLD,
    outlier: float = OUTLIER,
    half_width: float = HALF_WIDTH,
) -> Extraction:
    """Doppler shift velocities by the polar current shell, one for each wavenumber (n,).

    `water` is the law of dispersion, or `gravity` that of deep water: one of them is given. Raises LeakrefError.
    """
    k = checked_wavenumbers(wavenumbers, "pcs.extract")
    fraction("pcs.extract", threshold=threshold)
    positive("pcs.extract", outlier=outlier)
    shell = partial(shell_at, spectrum, water=law("pcs.extract", gravity, water), half_width=half_width)
    return collect("pcs", k, [optimum(shell(k_i), threshold, outlier) for k_i in k])


METHOD: dict[str, Any] = {
    "id": "pcs", "title": "PCS", "words": "polar current shell", "extract": extract, "optimum": optimum,
    "settings": {"threshold": THRESHOLD, "outlier": OUTLIER}, "exact_on_bins": True,
    "silences": Note.NO_SIGNAL | Note.UNCONVERGED | Note.TOO_FEW_BINS,
}  # fmt: skip
"""The record of the register (`methods`)."""
