"""The chain from samples to velocities in one call, and the built-in implementation for whoever judges codes."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import numpy.typing as npt

from leakref import leakage, methods
from leakref._base import ComplexArray, FloatArray, LeakrefError, finite, levelled, positive
from leakref.dispersion import Water, law
from leakref.grid import Grid
from leakref.sea import Components
from leakref.shell import Extraction
from leakref.spectrum import Spectrum, fourier
from leakref.synthesis import synthesize
from leakref.window import WINDOWS, window

__all__ = ["Reference", "analyse", "extract", "reference", "shell_wavenumbers", "transform"]


def shell_wavenumbers(grid: Grid, smallest: float, largest: float) -> FloatArray:
    """k_i = i dk (n,), rad per length, from `smallest` to `largest` (0.4 and 3.5 k0 in the paper: D9), one a bin."""
    positive("shell_wavenumbers", smallest=smallest, largest=largest)
    dk = grid.wavenumber_resolution
    return np.arange(np.ceil(smallest / dk - 1e-9), np.floor(largest / dk + 1e-9) + 1) * dk


def analyse(
    spectrum: Spectrum,
    wavenumbers: npt.ArrayLike,
    *,
    gravity: float | None = None,
    water: Water | None = None,
    method: str = "nsp",
    **settings: Any,
) -> Extraction:
    """Velocities from a spectrum by a `method` of `methods.METHODS`, in `water`, or in deep water of some `gravity`.

    `settings` are `half_width` and those of the method; of `peak_wavenumber` and `search`, which say how a search is
    judged, a method takes what it knows. Raises LeakrefError.
    """
    record = methods.method(method, "analyse")
    taken = {n: v for n, v in settings.items() if n not in {"peak_wavenumber", "search"} - record.settings.keys()}
    return record.extract(spectrum, wavenumbers, water=law("analyse", gravity, water), **taken)


def extract(
    surface: npt.ArrayLike,
    spacing: tuple[float, float, float],
    wavenumbers: npt.ArrayLike,
    *,
    gravity: float | None = None,
    window: str = "hann",
    method: str = "nsp",
    **settings: Any,
) -> Extraction:
    """From a surface eta[x, y, t] sampled at `spacing` (dx, dy, dt) to velocities at `wavenumbers` (n,).

    Wavenumbers in rad per length, velocities and `gravity` in the surface's own units (9.81 for metres and seconds, 1
    for scaled ones: no default). `settings` as in `analyse`, `water` for gravity among them. Raises LeakrefError.
    """
    water = law("extract", gravity, settings.pop("water", None))
    eta = finite("extract", "surface", surface, 3)
    spectrum = fourier(levelled(eta)[0], Grid(eta.shape, spacing), window)
    return analyse(spectrum, wavenumbers, water=water, method=method, **settings)


def transform(
    components: Components,
    grid: Grid,
    windows: tuple[str, ...],
    *,
    route: str = "A",
    largest_wavenumber: float | None = None,
) -> list[Spectrum]:
    """The spectra of a sea under several windows: by its surface and the FFT (route A), or in closed form (B)."""
    if route not in ("A", "B"):
        raise LeakrefError("transform", f"no route named {route!r}", "choose A (surface and FFT) or B (closed form)")
    if route == "B":
        return [leakage.spectrum(components, grid, name, largest_wavenumber=largest_wavenumber) for name in windows]
    eta = synthesize(components, *(grid.samples(axis) for axis in range(3)))
    return [fourier(eta, grid, name) for name in windows]


class Reference:
    """The reference chain as something that can be judged (`certify.subject.inprocess.Implementation`)."""

    def describe(self) -> Mapping[str, object]:
        """What the reference declares of itself (guide protocol, section 3)."""
        from leakref import __version__

        windows = list(WINDOWS)
        can = {"extract": {"methods": list(methods.DEFAULT), "windows": windows, "resolves": "wavenumber"},
               "spectrum": {"windows": windows}, "window": {"names": windows}, "synthesize": {}}  # fmt: skip
        return {"name": "leakref", "version": __version__, "units": "scaled", "axes": "xyt", "y": "up",
                "direction": "to", "fixed": [], "can": can}  # fmt: skip

    def window(self, name: str, size: int) -> FloatArray:
        """Samples of a window, (size,)."""
        return window(name).samples(size)

    def synthesize(self, components: Components, x: FloatArray, y: FloatArray, t: FloatArray) -> FloatArray:
        """The surface, (nx, ny, nt)."""
        return synthesize(components, x, y, t)

    def spectrum(
        self, surface: FloatArray, spacing: tuple[float, float, float], *, window: str = "hann"
    ) -> ComplexArray:
        """The whole spectrum, (nx, ny, nt), in fftfreq order."""
        eta = finite("spectrum", "surface", surface, 3)
        return fourier(eta, Grid(eta.shape, spacing), window).whole()

    def extract(self, surface: FloatArray, spacing: tuple[float, float, float], wavenumbers: FloatArray, *,
                gravity: float = 1.0, depth: float = np.inf, surface_tension: float = 0.0,
                window: str = "hann", method: str = "nsp") -> FloatArray:  # fmt: skip
        """Velocities, (n, 2), NaN where there is none."""
        water = Water(gravity, depth, surface_tension)
        return extract(surface, spacing, wavenumbers, water=water, window=window, method=method).velocities


reference = Reference()
"""The built-in implementation, `leakref.chain.reference`."""
