"""From a cube to velocities: trend, spectrum, wavenumbers, screen, and whether there is a dispersion shell.

Each step is a function here, and `measure` is the order in which they are taken. What is done to the samples on the way
is said in notes.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from leakref._base import FloatArray, LeakrefError, levelled
from leakref.chain import analyse
from leakref.cubes import blocks, causes, contrast, deferred, screen
from leakref.cubes.cube import Cube
from leakref.cubes.wavenumbers import default_wavenumbers
from leakref.grid import Grid
from leakref.shell import HALF_WIDTH, Extraction
from leakref.spectrum import Spectrum, fourier

__all__ = ["IN_MEMORY", "KEPT", "Measured", "Request", "measure", "spectrum_of"]

IN_MEMORY = deferred.IN_MEMORY
"""A memory-mapped cube larger than this many bytes, as float64, is transformed in blocks."""
KEPT = 7 * 2**27
"""Bytes that the spectrum of such a cube may take."""
_LOOKED_AT = 5  # wavenumbers at which the contrast is taken where others were asked for


@dataclass(frozen=True)
class Request:
    """What is to be measured: under which window and by which method, at which wavenumbers (None: where there is
    signal), with a screen or not and after which turn of it in degrees, less which trend.
    """

    window: str = "hann"
    method: str = "nsp"
    wavenumbers: FloatArray | None = None
    screening: bool = False
    angle: float | None = None
    detrend: str = "none"


@dataclass(frozen=True, eq=False)
class Measured:
    """What was found: velocities, the screening if there was one, the trend removed (4,), and what to say.

    `contrasts` are those of the shell at each wavenumber, None where there is no number, `shell` what they and the band
    come to; None if the cube is too small to have a band.
    """

    found: Extraction
    screened: screen.Screening | None
    notes: list[str]
    trend: FloatArray
    contrasts: list[float | None]
    shell: causes.Verdict | None


def spectrum_of(cube: Cube, window: str, trend: FloatArray | None, reach: float | None, *, in_blocks: bool) -> Spectrum:
    """The spectrum of a cube less its trend, whole or (`in_blocks`) of what lies within `reach`.

    `trend` is from `blocks.trend`, None for none; `reach` is the largest wavenumber kept, in rad per length, and counts
    only `in_blocks`.
    """
    if in_blocks:
        return blocks.fourier_in_blocks(cube.surface, cube.grid, window, largest_wavenumber=reach, remove=trend)
    eta = cube.surface if trend is None else cube.surface - blocks.plane(trend, cube.grid.shape)
    return fourier(eta, cube.grid, window)


def measure(cube: Cube, request: Request) -> Measured:
    """The velocities of a cube, and whether it shows a dispersion shell.

    In this order: decide whether blocks are needed, remove the trend, transform under the window, choose wavenumbers by
    where the tapered spectrum has signal, extract, look for the shell, and if asked for screen, turned or not. A cube
    whose samples are extreme is scaled by a power of two first, which moves no velocity. Raises LeakrefError.
    """
    notes = list(cube.notes)
    in_blocks = isinstance(cube.surface, np.memmap) and 8 * cube.surface.size > IN_MEMORY
    reach = _reach(cube, request, notes) if in_blocks else None
    surface, exponent = (cube.surface, 0) if in_blocks else levelled(cube.surface)
    level = replace(cube, surface=surface)
    removed = blocks.trend(surface, request.detrend)
    trend = np.ldexp(removed, exponent)  # as it is in the file
    notes.append(_trend_words(request.detrend, trend))

    def spectrum(name: str) -> Spectrum:
        return spectrum_of(level, name, None if request.detrend == "none" else removed, reach, in_blocks=in_blocks)

    main = spectrum(request.window)
    taper = "hann" if request.window == "box" else request.window
    smooth = spectrum(taper) if request.window == "box" else main
    with_signal = _with_signal(smooth, reach)
    k = request.wavenumbers
    if k is None:
        k, said = _by_default(smooth, with_signal, reach)
        notes.append(said)
    found = analyse(main, k, water=cube.water, method=request.method)
    contrasts, shell = _shell(level, smooth, found, with_signal, request, in_blocks)
    notes += _depth_words(cube, shell)
    screened = None
    if request.screening:
        pair = main if request.window == "box" else spectrum("box"), smooth
        rotated = None if request.angle is None else _turned(level, removed, k, taper, request, notes)
        screened = screen.screen(*pair, k, water=cube.water, method=request.method, rotated=rotated)
    return Measured(found, screened, notes, trend, contrasts, shell)


def _reach(cube: Cube, request: Request, notes: list[str]) -> float:
    """The largest wavenumber that is kept of a cube that is transformed in blocks."""
    notes.append("the cube was transformed in blocks: it is larger than what is held in memory")
    if request.angle is not None:
        raise LeakrefError("rotate", "the cube is too large to be turned in memory", "leave out --rotate or cut it")
    if request.wavenumbers is not None:
        reach = float(request.wavenumbers.max()) + (HALF_WIDTH + 1) * cube.grid.wavenumber_resolution
        across = np.minimum(2 * reach / np.array(cube.grid.bin_widths[:2]) + 1, cube.grid.shape[:2])
        size = 8 * float(across.prod()) * cube.grid.shape[2]
        if (share := KEPT / size) < 1:
            most = request.wavenumbers.max() * np.sqrt(share)
            raise LeakrefError(
                "extract",
                f"the spectrum up to the largest wavenumber takes {size / 1e9:.2g} GB",
                f"ask for wavenumbers up to some {most:.2g} at most, or cut the cube with --crop or --frames",
            )
        return reach
    return blocks.largest_kept(cube.surface, cube.grid, KEPT)


def _trend_words(kind: str, trend: FloatArray) -> str:
    """What was removed, or that nothing was."""
    if kind == "mean":
        return f"the mean, {trend[0]:.6g}, was removed"
    if kind == "linear":
        slopes = ", ".join(f"{b:.3g}" for b in trend[1:])
        return f"the mean, {trend[0]:.6g}, and a plane with the slopes {slopes} per sample along x, y, t were removed"
    return "neither mean nor trend was removed (--detrend mean or linear does)"


def _candidates(spectrum: Spectrum, reach: float | None) -> FloatArray:
    """Every dk that the cube has a whole shell for, and that was kept. Raises LeakrefError if there is none."""
    limit = np.inf if reach is None else reach - (HALF_WIDTH + 1) * spectrum.grid.wavenumber_resolution
    return default_wavenumbers(spectrum.grid, limit)


def _with_signal(smooth: Spectrum, reach: float | None) -> FloatArray | None:
    """Those of the candidates where the tapered spectrum holds more than noise; None if there is no candidate."""
    try:
        k = _candidates(smooth, reach)
    except LeakrefError:
        return None
    return k[screen.shells_with_signal(smooth, k, 0.5)]  # at the wavenumber itself, not at the edge of its shell only


def _by_default(smooth: Spectrum, with_signal: FloatArray | None, reach: float | None) -> tuple[FloatArray, str]:
    """The wavenumbers where none were asked for, and what is said of them."""
    if with_signal is not None and with_signal.size:
        k = with_signal
        return k, f"wavenumbers: every dk from {k[0]:.4g} to {k[-1]:.4g}, where there is signal"
    k = _candidates(smooth, reach)
    return k, f"wavenumbers: every dk from {k[0]:.4g} to {k[-1]:.4g}, though no shell holds more than noise"


def _shell(
    cube: Cube,
    smooth: Spectrum,
    found: Extraction,
    with_signal: FloatArray | None,
    request: Request,
    in_blocks: bool,
) -> tuple[list[float | None], causes.Verdict | None]:
    """The contrast at each wavenumber, and whether the cube shows a shell: in its tapered spectrum, whatever the window
    of the velocities is, and in the whole band with signal, whatever wavenumbers were asked for.
    """
    water = cube.water

    def at(k: FloatArray) -> list[float | None]:
        own = found
        if request.window == "box" or k is not found.wavenumbers:
            own = analyse(smooth, k, water=water, method=request.method, search=False)
        return contrast.contrasts(smooth, k, own.velocities, water)

    here = at(found.wavenumbers)
    if with_signal is None:
        return here, None
    some = with_signal[:: max(1, -(-with_signal.size // _LOOKED_AT))]
    there = here if request.wavenumbers is None else at(some) if some.size else []
    band = contrast.band(smooth, with_signal, water)
    return here, causes.judge(band, there, cube, None if in_blocks else _other_order(cube))


def _depth_words(cube: Cube, shell: causes.Verdict | None) -> list[str]:
    """Which depths the cube itself leaves open, where its shell is where it should be."""
    if shell is None or not shell.holds or shell.depths is None:
        return []
    low, high = shell.depths
    unit = " m" * (cube.units == "si")
    taken = "deep water was taken" if cube.depth == np.inf else f"{cube.depth:.4g}{unit} was taken"
    alike = f"from {low:.3g}{unit} up" if high == np.inf else f"from {low:.3g} to {high:.3g}{unit}"
    return [f"depth: {taken}, and by these waves alone any {alike} fits as well"]


def _other_order(cube: Cube) -> Callable[[str], contrast.Band | None]:
    """The band of a cube with its axes in another order, the steps along x, y and t being kept."""

    def transposed(order: str) -> contrast.Band | None:
        eta = np.asarray(cube.surface).transpose(["xyt".index(name) for name in order])
        spectrum = fourier(eta, Grid(eta.shape, cube.grid.spacing), "hann")
        k = _with_signal(spectrum, None)
        return None if k is None or not k.size else contrast.band(spectrum, k, cube.water)

    return transposed


def _turned(
    cube: Cube, removed: FloatArray, k: FloatArray, taper: str, request: Request, notes: list[str]
) -> screen.Turned:
    """What is measured after the images were turned, for the screen."""
    assert request.angle is not None
    surface, angle = cube.surface, request.angle
    flat = np.asarray(surface) if request.detrend == "none" else surface - blocks.plane(removed, cube.grid.shape)
    turned, smaller = screen.rotate(flat, cube.grid, angle)
    notes.append(
        f"turned by {angle:g} degrees by interpolation on the inscribed square of {smaller.shape[0]} x "
        f"{smaller.shape[1]} samples: not lossless, and of coarser resolution"
    )
    spectra = [fourier(turned, smaller, name) for name in ("box", taper)]
    return screen.turn(spectra, k, angle, water=cube.water, method=request.method)
