"""The bins around one wavenumber, and what an extraction from them reports.

A shell around k_i holds what the spectrum has near that wavenumber (eq:g, equation 20, for the surface of
eq:maskedSpec, equation 13),

    F_i(k, omega) = sqrt(P(k, omega)) where | |k| - k_i | <= 2 dk, and nothing elsewhere.

P = |S|^2 is the power in a bin, k its wave vector and k_i the shell's wavenumber in rad per length, omega in rad per
time, dk the larger of the widths of a bin along kx and ky.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import Flag

import numpy as np
import numpy.typing as npt

from leakref._base import FloatArray, IntArray, LeakrefError, finite, positive
from leakref.dispersion import Water
from leakref.spectrum import Spectrum
from leakref.window import window

__all__ = [
    "EDGE_MARGIN", "HALF_WIDTH", "Extraction", "Note", "Optimum", "Shell", "checked_wavenumbers", "collect",
    "nothing", "shell_at",
]  # fmt: skip

HALF_WIDTH = 2.0
"""Half width of a shell in dk (app:numdetails)."""
EDGE_MARGIN = 1e-9
"""In dk: a bin on the edge is inside, and no rounding decides about it (decision D3)."""
_ROUNDING = 1e-12  # of the spectrum's largest bin: below, a shell holds nothing but rounding


class Note(Flag):
    """What to know before using a number. Several may hold at once."""

    NONE = 0
    ANOTHER_BASIN = 1
    "nsp: some other current within reach scores higher than the one that Nelder-Mead found"
    EDGE = 2
    """nsp: the optimum is faster than the search that judges it reaches; if most of the surface has left the Nyquist
    range there, or one component is free, or there is no end to it, there is no number"""
    TOO_FEW_BINS = 4
    "nsp: fewer than 8 bins in the plane; ls: fewer than 2 bins above the threshold, and no number"
    FLAT = 8
    "the score hardly depends on one component of the current; ls: if not at all, there is no number"
    NO_SIGNAL = 16
    "the shell holds only rounding, and there is no number"
    LEAKAGE_FLOOR = 32
    "all that lies near the fitted surface could have leaked from the strongest wave, which is elsewhere"
    THRESHOLD = 64
    "ls, pcs: a bin is within rounding of a threshold, or as strong as another, so that the result may jump"
    UNCONVERGED = 128
    "nsp: no stationary maximum was reached within that range, others: none at all; and there is no number"

    @property
    def names(self) -> list[str]:
        """As in JSON: lower case with hyphens, empty if there is nothing to say."""
        return [note.name.lower().replace("_", "-") for note in Note if note in self and note.name]


@dataclass(frozen=True, eq=False)
class Shell:
    """All bins with |k - k_i| <= `half_width` dk (eq:g): n columns in the plane, each with every omega >= 0.

    `magnitude` F = sqrt(P), (n, nw) (eq:maskedSpec); `kx`, `ky`, `intrinsic` omega0 at each bin's own k, (n,);
    `omega`, `weight` (nw,), `weight` making the half space stand for the whole (decision D5). `frequency` is omega0 at
    the shell's own `wavenumber`.
    """

    wavenumber: float
    frequency: float
    kx: FloatArray
    ky: FloatArray
    intrinsic: FloatArray
    omega: FloatArray
    weight: FloatArray
    magnitude: FloatArray
    floor: FloatArray | None
    """What the strongest wave of the spectrum and its mirror image may leak here, (n, nw); None if it is here."""
    is_empty: bool
    """Only rounding is here."""

    def notes(self, near: npt.NDArray[np.bool_]) -> Note:
        """LEAKAGE_FLOOR, if nothing at the bins `near` (n, nw) rises above what may have leaked there."""
        if self.floor is None or not near.any():
            return Note.NONE
        return Note.NONE if ((self.magnitude > self.floor) & near).any() else Note.LEAKAGE_FLOOR


@dataclass(frozen=True, eq=False)
class Extraction:
    """Doppler shift velocities per wavenumber, and how each was found. n wavenumbers, NaN where there is no number.

    `score` (n,): N of eq:normSp at the optimum, or C of eq:LS1; its `gradient` (n, 2) and `hessian` (n, 2, 2)
    there; `evaluations` (n,) of the score; `notes`, one a wavenumber.
    """

    method: str
    wavenumbers: FloatArray
    velocities: FloatArray
    score: FloatArray
    gradient: FloatArray
    hessian: FloatArray
    evaluations: IntArray
    notes: tuple[Note, ...]


@dataclass(frozen=True, eq=False)
class Optimum:
    """What was found in one shell: a row of an Extraction, with `velocity` and `gradient` (2,), `hessian` (2, 2)."""

    velocity: FloatArray
    score: float
    gradient: FloatArray
    hessian: FloatArray
    evaluations: int
    note: Note


def nothing(note: Note, evaluations: int = 0) -> Optimum:
    """No number, and why."""
    return Optimum(np.full(2, np.nan), np.nan, np.full(2, np.nan), np.full((2, 2), np.nan), evaluations, note)


def collect(method: str, wavenumbers: FloatArray, found: list[Optimum]) -> Extraction:
    """One record of the optima of all shells."""
    names = ("velocity", "score", "gradient", "hessian", "evaluations")
    c, n, slope, bend, count = (np.array([getattr(one, name) for one in found]) for name in names)
    return Extraction(method, wavenumbers, c, n, slope, bend, count, tuple(one.note for one in found))


def checked_wavenumbers(wavenumbers: npt.ArrayLike, call: str = "extract") -> FloatArray:
    """(n,) positive wavenumbers, n >= 1, or LeakrefError."""
    k = finite(call, "wavenumbers", np.atleast_1d(np.asarray(wavenumbers)), 1)
    if not k.size:
        raise LeakrefError(call, "the list of wavenumbers is empty", "ask for at least one")
    positive(call, wavenumbers=k)
    return k


def _leaked(spectrum: Spectrum, distances: tuple[IntArray, IntArray, IntArray]) -> FloatArray:
    """How much of a wave may be seen this many bins away from it along each axis, (n,), (n,) and (nw,): (n, nw)."""
    taper, sizes = window(spectrum.window), spectrum.grid.shape
    x, y, t = (taper.sidelobe_envelope(d, n) for d, n in zip(distances, sizes, strict=True))
    return (x * y)[:, None] * t


def shell_at(spectrum: Spectrum, wavenumber: float, *, water: Water, half_width: float = HALF_WIDTH) -> Shell:
    """The shell around `wavenumber` (rad per length), `half_width` in dk.

    Raises LeakrefError for a shell that reaches past the Nyquist wavenumber or past the bins of the
    spectrum, or that holds no bin.
    """
    positive("shell_at", wavenumber=wavenumber, half_width=half_width)
    grid, reaches = spectrum.grid, f"the shell around k = {wavenumber:.6g} reaches"
    dk = grid.wavenumber_resolution
    outer, nyquist = wavenumber + half_width * dk, min(grid.nyquist[:2])
    if outer >= nyquist * (1 - EDGE_MARGIN):
        fault = f"{reaches} to {outer:.6g}, past the Nyquist wavenumber {nyquist:.6g}"
        raise LeakrefError("shell_at", fault, f"ask for k below {nyquist - half_width * dk:.6g}")
    here = min((np.abs(spectrum.i).max() + 1) * grid.bin_widths[0], (np.abs(spectrum.j).max() + 1) * grid.bin_widths[1])
    if outer + EDGE_MARGIN * dk >= here:  # the first bin that is not here would be in the shell
        fault = f"{reaches} to {outer:.6g}, the spectrum only to below {here:.6g}"
        raise LeakrefError("shell_at", fault, "make the spectrum with a larger largest_wavenumber")
    k = np.hypot(*np.meshgrid(spectrum.kx, spectrum.ky, indexing="ij"))
    a, b = np.nonzero(np.abs(k - wavenumber) / dk <= half_width + EDGE_MARGIN)
    if not a.size:
        raise LeakrefError("shell_at", f"no bin lies within {half_width} dk of k = {wavenumber:.6g}", "widen the shell")
    magnitude = np.abs(spectrum.values[a, b])
    largest, (i, j, m) = spectrum.strongest
    floor = None
    if not np.any((spectrum.i[a] == i) & (spectrum.j[b] == j)):
        distances = ((spectrum.i[a] + s * i, spectrum.j[b] + s * j, grid.bins(2) + s * m) for s in (-1, 1))
        wave, mirror = (_leaked(spectrum, distance) for distance in distances)
        floor = largest * (wave + mirror)
    kx, ky, intrinsic, frequency = spectrum.kx[a], spectrum.ky[b], water.frequency(k[a, b]), water.frequency(wavenumber)
    weight, is_empty, k_i = spectrum.half_weight, not magnitude.max() > _ROUNDING * largest, float(wavenumber)
    return Shell(k_i, float(frequency), kx, ky, intrinsic, spectrum.omega, weight, magnitude, floor, is_empty)
