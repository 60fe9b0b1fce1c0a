"""The paper's practical test for leakage (sec:conclusions): does a taper, or turning the camera, change the result?

A velocity that is right does not change when the cube is tapered, or when the camera is turned; one that leakage made
does, since leakage runs along the axes of the cube and is cut by a taper (sec:NSP_and_leakage). The verdicts compare
these velocities and say nothing of how large the true current is. Used by `leakref extract --screen`.

Two spectra of one cube are all it needs:

    result = screen(fourier(eta, grid, "box"), fourier(eta, grid, "hann"), wavenumbers, gravity=9.81)
    print(result.verdicts)
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy import ndimage

from leakref._base import FloatArray, LeakrefError, finite
from leakref.chain import analyse
from leakref.dispersion import Water, law, velocity_resolutions
from leakref.grid import Grid
from leakref.shell import EDGE_MARGIN, HALF_WIDTH, Extraction, Note
from leakref.spectrum import Spectrum
from leakref.window import window

__all__ = [
    "LEAKAGE",
    "LEAKED_SHARE",
    "NOISE",
    "NO_CHANGE",
    "NO_SIGNAL",
    "SIGNAL",
    "TELLING",
    "UNRESOLVED",
    "Screening",
    "Turned",
    "leaked_share",
    "rotate",
    "screen",
    "shells_with_signal",
    "turn",
]

NO_CHANGE, UNRESOLVED, LEAKAGE, NO_SIGNAL = "no change", "below resolution", "leakage", "no signal"
"""The verdicts, as they stand in tables and in the JSON. None says that a velocity is right: "no change" is that the
taper does not move it, "below resolution" that it does, by less than can be told from chance.
"""
TELLING = 0.1
"""A change counts from this part of the velocity, or of the resolution if that is larger."""
SIGNAL = 1e-2
"""A shell holds signal if its largest |S| is at least this part of that of the strongest shell ..."""
NOISE = 2.0
"""... and this many times the largest that noise of the shell's own median would reach, sqrt(log2 of the bins)."""
LEAKED_SHARE = 0.1
"""A bin has leaked if tapering brings it, and its neighbours, below this part; leakage needs this share of a shell.

The share was 0.4 to 0.7 in every shell of random seas, 1e-14 in those of waves on bins: any value between will do.
"""


@dataclass(frozen=True)
class Turned:
    """What is measured after the camera was turned by `angle` degrees: velocities (n, 2) in the axes of the cube.

    NaN where the inscribed square, smaller than the cube, has no whole shell. `resolution` (n,) is its larger one.

    - `untapered`, `tapered`: (n, 2), turned back, in the cube's units of velocity.
    - `resolution` (n,): the larger of eq:dcdwk in the smaller cube; `side`: its samples along x and along y.
    """

    angle: float
    untapered: FloatArray
    tapered: FloatArray
    resolution: FloatArray
    side: int


@dataclass(frozen=True)
class Screening:
    """Untapered against tapered at n wavenumbers, and a verdict on each: one of the four words above.

    `disagreement` (n,) is the length of the difference of the two velocities; `resolution` (n,) the larger of eq:dcdwk;
    `leaked` (n,) the share of the untapered shell's magnitude that the taper removes.

    - `untapered`, `tapered`: what was extracted from each, at the same wavenumbers.
    - `verdicts`: n words, see `screen`.
    - `turned`: the same after a turn, None if none was asked for.
    """

    untapered: Extraction
    tapered: Extraction
    disagreement: FloatArray
    resolution: FloatArray
    leaked: FloatArray
    verdicts: tuple[str, ...]
    turned: Turned | None = None

    @property
    def wavenumbers(self) -> FloatArray:
        """(n,), rad per length."""
        return self.tapered.wavenumbers


def _ordered(spectrum: Spectrum) -> tuple[FloatArray, FloatArray]:
    """|k| (a, b) of the bins sorted by number, and |S| (a, b, nw) there in units of a wave's amplitude over two. `gain`
    is the sum of the window over all samples, so that a wave on a bin has the same height under every window.
    """
    order = np.ix_(np.argsort(spectrum.i), np.argsort(spectrum.j))
    gain = np.prod([window(spectrum.window).samples(n).sum() for n in spectrum.grid.shape])
    k = np.hypot(*np.meshgrid(spectrum.kx, spectrum.ky, indexing="ij"))[order]
    return k, np.abs(spectrum.values[order]) / gain


def _shell(k: FloatArray, wavenumber: float, dk: float, half_width: float = HALF_WIDTH) -> Any:
    return np.abs(k - wavenumber) <= (half_width + EDGE_MARGIN) * dk


def shells_with_signal(spectrum: Spectrum, wavenumbers: FloatArray, half_width: float = HALF_WIDTH) -> list[bool]:
    """Whether each shell, of `half_width` in dk, holds more than noise and the skirts of stronger ones.

    A list of n. A shell needs a largest magnitude of `SIGNAL` times that of the strongest one, and `NOISE` times what
    noise of its own median would reach. `wavenumbers` are in rad per length.
    """
    k, magnitude = _ordered(spectrum)
    found = []
    for wavenumber in wavenumbers:
        bins = magnitude[_shell(k, wavenumber, spectrum.grid.wavenumber_resolution, half_width)]
        noise = np.median(bins) * np.sqrt(np.log2(max(bins.size, 2))) if bins.size else np.inf
        found.append((bins.max(initial=0.0), bins.max(initial=0.0) > NOISE * noise))
    strongest = max((largest for largest, _ in found), default=0.0)
    return [bool(clear and largest >= SIGNAL * strongest) for largest, clear in found]


def leaked_share(untapered: Spectrum, tapered: Spectrum, wavenumbers: FloatArray) -> FloatArray:
    """The share of each untapered shell's magnitude in bins that only leakage can explain, (n,).

    A wave stands in its own bins and their neighbours whatever the taper; what is at a bin untapered and is gone there,
    and around, once tapered, came from afar. Waves on bins do not leak at all, so their share is rounding.

    From 0 to 1. Both spectra are of the same cube, and of the same bins in any order.
    """
    k, plain = _ordered(untapered)
    around = ndimage.maximum_filter(_ordered(tapered)[1], 3)
    gone = np.where(around < LEAKED_SHARE * plain, plain, 0.0)
    shells = [_shell(k, wavenumber, untapered.grid.wavenumber_resolution) for wavenumber in wavenumbers]
    return np.array([gone[s].sum() / max(plain[s].sum(), 1e-300) for s in shells])


def screen(
    untapered: Spectrum,
    tapered: Spectrum,
    wavenumbers: FloatArray,
    *,
    gravity: float | None = None,
    water: Water | None = None,
    method: str = "nsp",
    rotated: Turned | None = None,
) -> Screening:
    """Compare the velocities of a cube without and with a taper, at each wavenumber.

    No signal: the tapered shell holds none, or nothing that could not have leaked from the strongest wave, or there is
    no number to compare. Leakage: the two disagree by more than both resolutions of eq:dcdwk, and at least LEAKED_SHARE
    of the untapered shell is gone when tapered (else the taper, which mixes neighbouring bins, made the difference); or
    the untapered velocities with and without a turn of the camera disagree by more than both resolutions of the
    smaller, rotated cube. Of the others: below resolution, if the taper moves the velocity by `TELLING` of it or more,
    so that it may be off by as much without anybody knowing; no change, if by less. Raises LeakrefError.

    Both spectra are of the same cube; `wavenumbers` (n,) in rad per length, `water` (or the `gravity` of deep water) in
    the units of the cube.
    """
    water = law("screen", gravity, water)
    plain, smooth = (analyse(s, wavenumbers, water=water, method=method, search=False) for s in (untapered, tapered))
    grid = tapered.grid
    resolution = np.maximum(
        *velocity_resolutions(wavenumbers, grid.wavenumber_resolution, grid.frequency_resolution, water)
    )
    off = np.hypot(*(plain.velocities - smooth.velocities).T)
    leaked = leaked_share(untapered, tapered, wavenumbers)
    suspect = (off > resolution) & (leaked >= LEAKED_SHARE)
    if rotated is not None:
        suspect |= np.hypot(*(rotated.untapered - plain.velocities).T) > rotated.resolution
    empty = ~np.array(shells_with_signal(tapered, wavenumbers)) | ~np.isfinite(off)
    empty |= [Note.LEAKAGE_FLOOR in note for note in smooth.notes]
    moved = off > TELLING * np.maximum(np.hypot(*smooth.velocities.T), resolution)
    verdicts = tuple(
        NO_SIGNAL if e else LEAKAGE if s else UNRESOLVED if m else NO_CHANGE
        for e, s, m in zip(empty, suspect, moved, strict=True)
    )
    return Screening(plain, smooth, off, resolution, leaked, verdicts, rotated)


def rotate(surface: Any, grid: Grid, angle: float) -> tuple[FloatArray, Grid]:
    """What a camera turned by `angle` degrees (anticlockwise) about the centre sees, on the inscribed square.

    Every frame is interpolated with cubic splines, which is not lossless: the shortest waves are damped. The
    spacing is the larger of dx and dy. Raises LeakrefError if fewer than eight samples fit.
    """
    eta = finite("rotate", "surface", surface, 3)
    finite("rotate", "angle", angle)
    (nx, ny, nt), (dx, dy, dt) = grid.shape, grid.spacing
    c, s, d = np.cos(np.radians(angle)), np.sin(np.radians(angle)), max(dx, dy)
    n = int(min((nx - 1) * dx, (ny - 1) * dy) / (d * (abs(c) + abs(s))) + 1e-9) + 1
    if n < 8:
        raise LeakrefError(
            "rotate",
            f"the square inscribed at {angle} degrees has {n} samples a side",
            "turn by less or use a larger cube",
        )
    matrix = np.array([[c / dx, -s / dx], [s / dy, c / dy]]) * d
    offset = np.array([nx - 1, ny - 1]) / 2 - matrix @ np.full(2, (n - 1) / 2)
    result = np.empty((n, n, nt))
    for m in range(nt):
        result[:, :, m] = ndimage.affine_transform(eta[:, :, m], matrix, offset, (n, n), order=3, mode="nearest")
    return result, Grid((n, n, nt), (d, d, dt))


def turn(
    spectra: Sequence[Spectrum],
    wavenumbers: FloatArray,
    angle: float,
    *,
    gravity: float | None = None,
    water: Water | None = None,
    method: str = "nsp",
) -> Turned:
    """The velocities from the (untapered, tapered) spectra of a cube rotated by `angle`, turned back.

    `wavenumbers` (n,) are those of the cube before; a shell is measured only if it lies whole within the square's own
    wavenumbers, and clear of zero. Velocities come back in the axes of the unrotated cube. `water` or `gravity` are as
    in `screen`.
    """
    water, grid = law("turn", gravity, water), spectra[0].grid
    dk = grid.wavenumber_resolution
    whole = (wavenumbers >= 2 * HALF_WIDTH * dk * (1 - EDGE_MARGIN)) & (
        wavenumbers + HALF_WIDTH * dk < min(grid.nyquist[:2]) * (1 - EDGE_MARGIN)
    )
    c, s = np.cos(np.radians(angle)), np.sin(np.radians(angle))
    found = np.full((2, wavenumbers.size, 2), np.nan)
    if whole.any():
        for n, spectrum in enumerate(spectra):
            measured = analyse(spectrum, wavenumbers[whole], water=water, method=method, search=False).velocities
            found[n, whole] = measured @ np.array([[c, s], [-s, c]])
    resolution = np.maximum(*velocity_resolutions(wavenumbers, dk, grid.frequency_resolution, water))
    return Turned(angle, found[0], found[1], resolution, grid.shape[0])
