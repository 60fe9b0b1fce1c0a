"""Where the claims get their numbers: ensembles of the paper's chain, computed when asked for and kept.

A claim asks for a configuration, a window, a method and a setting; what was computed for one claim serves the others,
and what `leakref reproduce` has left in the folder serves as well. Settings other than the paper's (`Setting`) have
files of their own. What is made of the ensembles is in `words` and in the claims.
"""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import Executor
from dataclasses import asdict, dataclass, replace
from functools import cache
from itertools import repeat
from pathlib import Path
from time import perf_counter
from typing import Any

import numpy as np
from scipy.ndimage import affine_transform
from scipy.optimize import minimize

from leakref import fast, kept, leakage, leastsquares, nsp, runs, sources
from leakref._base import FloatArray, LeakrefError
from leakref.cases import Configuration
from leakref.chain import analyse
from leakref.dispersion import DEEP
from leakref.ensemble import Ensemble
from leakref.methods import DEFAULT
from leakref.paper.inferred import Depths
from leakref.paper.inferred import ensembles as ensembles_of_depths
from leakref.sea import Components
from leakref.shell import Shell, shell_at
from leakref.spectrum import fourier
from leakref.synthesis import synthesize
from leakref.window import Window
from leakref.window import window as named_window

__all__ = ["PLAIN", "RESAMPLED", "Evidence", "Setting", "kept_velocities", "peak_waves", "resampled", "source_digest"]

RESAMPLED = 5
"""Realisations whose images are resampled: they go through the surface and its FFT, which takes half a minute each."""
_SOFTNESS = 12
_PEAK = 0.1  # "about" k = 1: within 10 %


@dataclass(frozen=True)
class Setting:
    """What is done otherwise than in the paper's table: the `width` a in domega, the LS `threshold`, the sea
    `without_peak`, and whether the images, not the sea, are turned by the configuration's rotation (`resampled`).

    `width` is a of eq:DSVkernel in frequency bins, `threshold` the part of the largest power from which LS takes a bin.
    The paper's are `PLAIN`.
    """

    width: float = nsp.WIDTH
    threshold: float = leastsquares.THRESHOLD
    without_peak: bool = False
    resampled: bool = False


PLAIN = Setting()
"""The paper's own."""


def peak_waves(waves: Components) -> np.ndarray:
    """Which waves are those of the peak, (n,): within 10 % of k = 1."""
    return np.abs(np.hypot(waves.kx, waves.ky) - 1) <= _PEAK


class Evidence:
    """`evidence(configuration, window)` is an Ensemble of `realizations`, computed once and kept in `folder`.

    A call takes a configuration, a window, and optionally method and setting. `executor` is as in `runs.run`.
    LeakrefError is raised for fewer than two realisations, since one has no spread.
    """

    def __init__(self, realizations: int, folder: Path | None = None, executor: Executor | None = None) -> None:
        if realizations < 2:
            raise LeakrefError("claims", f"{realizations} realisations", "ask for two or more: one has no spread")
        self.realizations, self.folder, self.executor = realizations, folder, executor
        self._kept: dict[tuple[object, ...], Ensemble] = {}
        self._seconds: dict[Configuration, dict[str, float]] = {}
        self._softness: dict[Configuration, FloatArray] = {}
        self._depths: dict[Configuration, list[Depths]] = {}

    def __call__(
        self, configuration: Configuration, window: str, method: str = "nsp", setting: Setting = PLAIN
    ) -> Ensemble:
        key = (configuration, setting)
        if (*key, window, method) not in self._kept:
            found = self._plain(configuration, method) if setting == PLAIN else self._special(configuration, setting)
            self._kept |= {(*key, e.window, e.method): e for e in found}
        return self._kept[*key, window, method]

    def window(self, name: str) -> Window:
        """A window by name."""
        return named_window(name)

    def seconds(self, configuration: Configuration) -> dict[str, float]:
        """Seconds of NSP and of LS for one spectrum on this machine, see `_timed`.

        Measured once for each configuration, whatever the executor does meanwhile: they are of this process.
        """
        if configuration not in self._seconds:
            self._seconds[configuration] = _timed(configuration)
        return self._seconds[configuration]

    def softness(self, configuration: Configuration) -> FloatArray:
        """The curvature of log N across the waves over that along them, (R, n), under Hann, where N is largest; of the
        first twelve realisations, by the literal chain.
        """
        if configuration not in self._softness:
            numbers = range(min(self.realizations, _SOFTNESS))
            given = (repeat(configuration), numbers, repeat(self.folder))
            found = list(map(_softness, *given) if self.executor is None else self.executor.map(_softness, *given))
            self._softness[configuration] = np.stack(found)[:, 0, 0, :, 0]
        return self._softness[configuration]

    def depths(self, configuration: Configuration) -> list[Depths]:
        """The depths inferred in a configuration over a bottom, for each window and `paper.inferred.CURRENTS`.

        Kept as all ensembles are, so that what `leakref reproduce depth` has left there serves.
        """
        if configuration not in self._depths:
            self._depths[configuration] = ensembles_of_depths(
                configuration, self.realizations, folder=self.folder, executor=self.executor
            )
        return self._depths[configuration]

    def _plain(self, configuration: Configuration, method: str) -> list[Ensemble]:
        """By the paper's two methods at once, which share the spectra; another method is asked for by itself."""
        methods = DEFAULT if method in DEFAULT else (method,)
        how: dict[str, Any] = {"folder": self.folder, "executor": self.executor}
        return next(runs.run([configuration], realizations=self.realizations, methods=methods, **how))

    def _special(self, configuration: Configuration, setting: Setting) -> list[Ensemble]:
        numbers = range(min(self.realizations, RESAMPLED) if setting.resampled else self.realizations)
        given = (repeat(configuration), numbers, repeat(setting), repeat(self.folder))
        found = list(map(_special, *given) if self.executor is None else self.executor.map(_special, *given))
        velocities = np.array(found)  # (R, w, m, n, 2)
        notes = np.zeros(velocities.shape[0::3], dtype=np.int64)
        return [
            Ensemble(configuration, window, method, configuration.wavenumbers, velocities[:, w, m], notes)
            for w, window in enumerate(configuration.windows)
            for m, method in enumerate(DEFAULT)
        ]


def _special(configuration: Configuration, realization: int, setting: Setting, folder: Path | None) -> FloatArray:
    """Velocities (w, m, n, 2) under a setting, from the folder if they are there."""
    about = {"configuration": asdict(configuration), "setting": asdict(setting), "source": source_digest()}
    shape = (len(configuration.windows), len(DEFAULT), configuration.wavenumbers.size, 2)
    return kept_velocities(
        folder and folder / f"claims-{kept.key(about)}" / f"{realization:05d}.npz",
        {**about, "realization": realization},
        shape,
        _computed,
        configuration,
        realization,
        setting,
    )


@cache
def source_digest() -> str:
    """SHA-256 of the sources of what is computed here, and of the libraries' versions."""
    return sources.digest(__name__)


def kept_velocities(
    path: Path | None, about: kept.About, shape: tuple[int, ...], compute: Callable[..., FloatArray], *given: Any
) -> FloatArray:
    """Velocities from the file `path` if they are there, else `compute(*given)` in one thread, and left there. `path`
    None keeps nothing. `shape` is what `compute` returns; a file of another shape, or of another `about`, is not taken.
    """
    found = path and kept.arrays(path, about, velocities=shape)
    if found:
        return found["velocities"]
    with runs.one_thread():
        velocities = compute(*given)
    if path is not None:
        kept.keep_arrays(path, about, velocities=velocities)
    return velocities


def _computed(configuration: Configuration, realization: int, setting: Setting) -> FloatArray:
    """Velocities (w, m, n, 2) of one realisation with what the setting does otherwise, by the compiled chain."""
    k, windows = configuration.wavenumbers, configuration.windows
    if setting.resampled:
        return resampled(configuration, realization)
    waves = configuration.components(realization)
    if setting.without_peak:
        rest = ~peak_waves(waves)
        waves = Components(*(getattr(waves, name)[rest] for name in waves.__dataclass_fields__))
    how: dict[str, Any] = {"width": setting.width, "threshold": setting.threshold, "search": False}
    found = fast.realize(waves, configuration.grid, k, windows=windows, water=configuration.water, **how)
    return np.array([[found[window, method].velocities for method in DEFAULT] for window in windows])


def resampled(configuration: Configuration, realization: int) -> FloatArray:
    """Every image turned by cubic splines about the centre of the domain.

    The camera first sees a larger square, so that what is cut out after the turn has all its corners.

    Returned are velocities (w, m, n, 2) in the frame of the turned images, by the plain chain. Images are interpolated,
    so that the shortest waves are damped; that is what is to be seen.
    """
    waves = replace(configuration, rotation=0.0).components(realization)
    grid, angle = configuration.grid, np.radians(configuration.rotation)
    n, (dx, _, _) = grid.shape[0], grid.spacing
    margin = int(np.ceil(n * (abs(np.cos(angle)) + abs(np.sin(angle)) - 1) / 2)) + 8  # splines need a few more
    x = (np.arange(n + 2 * margin) - margin) * dx
    back = np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]])
    offset = n / 2 + margin - back @ np.full(2, n / 2)
    turned = np.empty(grid.shape)
    for start in range(0, grid.shape[2], 40):
        times = grid.samples(2)[start : start + 40]
        for m, image in enumerate(np.moveaxis(synthesize(waves, x, x, times), 2, 0), start):
            turned[:, :, m] = affine_transform(image, back, offset, output_shape=(n, n), order=3)
    spectra = [fourier(turned, grid, window) for window in configuration.windows]
    return np.array(
        [
            [
                analyse(spectrum, configuration.wavenumbers, method=method, search=False, gravity=1.0).velocities
                for method in DEFAULT
            ]
            for spectrum in spectra
        ]
    )


def _softness(configuration: Configuration, realization: int, folder: Path | None) -> FloatArray:
    """Of one realisation, (1, 1, n, 2) as velocities are, the second column unused; kept in the folder."""
    about = {"configuration": asdict(configuration), "softness": "log N", "source": source_digest()}
    shape = (1, 1, configuration.wavenumbers.size, 2)
    path = folder and folder / f"claims-{kept.key(about)}" / f"{realization:05d}.npz"
    return kept_velocities(path, {**about, "realization": realization}, shape, _curvatures, configuration, realization)


def _curvatures(configuration: Configuration, realization: int) -> FloatArray:
    """The Hessian of N at its maximum, in the axes across and along the waves: the ratio of the two curvatures."""
    k, grid, water = configuration.wavenumbers, configuration.grid, configuration.water
    waves = configuration.components(realization)
    largest = float(k.max()) + 3 * grid.wavenumber_resolution
    spectrum = leakage.spectrum(waves, grid, "hann", largest_wavenumber=largest)
    angle = np.radians(configuration.direction + configuration.rotation)
    along, across = np.array([np.cos(angle), np.sin(angle)]), np.array([-np.sin(angle), np.cos(angle)])
    found = np.full((1, 1, k.size, 2), np.nan)
    width = nsp.WIDTH * grid.frequency_resolution
    for n, k_n in enumerate(k):
        shell = shell_at(spectrum, float(k_n), water=water)
        best = nsp.optimum(shell, width, 1.0, search=False).velocity
        _, _, hessian = nsp.score_derivatives(shell, best, width)
        found[0, 0, n, 0] = (across @ hessian @ across) / (along @ hessian @ along)
    return found


def _timed(configuration: Configuration, repeats: int = 3) -> dict[str, float]:
    """Seconds for one spectrum and all its shells, the best of `repeats`: taper and `transform`, the `shells` picked,
    and the currents found in them by NSP and by LS, both by Nelder-Mead to MATLAB's tolerances as the paper has it, and
    by LS in closed form. How long a transform takes does not depend on what is transformed.
    """
    k, dk, grid = configuration.wavenumbers, configuration.grid.wavenumber_resolution, configuration.grid
    waves = configuration.components(0)
    spectrum = leakage.spectrum(waves, grid, "hann", largest_wavenumber=float(k.max()) + 3 * dk)
    surface = np.random.default_rng(0).standard_normal(grid.shape, dtype=np.float32).astype(np.float64)
    width = nsp.WIDTH * grid.frequency_resolution
    with runs.one_thread():
        shells = [shell_at(spectrum, k_i, water=DEEP) for k_i in k]
        timed: dict[str, Callable[[], object]] = {
            "transform": lambda: fourier(surface, grid, "hann"),
            "shells": lambda: [shell_at(spectrum, k_i, water=DEEP) for k_i in k],
            "nsp": lambda: [_nsp_by_simplex(shell, width) for shell in shells],
            "ls by Nelder-Mead": lambda: [_least_squares_by_simplex(shell) for shell in shells],
            "ls": lambda: [leastsquares.optimum(shell) for shell in shells],
        }
        return {name: min(_clocked(work) for _ in range(repeats)) for name, work in timed.items()}


def _clocked(work: Callable[[], object]) -> float:
    start = perf_counter()
    work()
    return perf_counter() - start


_MATLAB = {"xatol": 1e-4, "fatol": 1e-4}
"""Tolerances at which its fminsearch stops by default."""


def _simplex(score: Callable[[FloatArray], float]) -> FloatArray:
    simplex = np.array([[0.0, 0.0], [nsp.START, 0.0], [0.0, nsp.START]])
    options = {"initial_simplex": simplex, **_MATLAB}
    return np.asarray(minimize(score, simplex[0], method="Nelder-Mead", options=options).x)


def _nsp_by_simplex(shell: Shell, width: float) -> FloatArray:
    """eq:normSp maximised as the paper does it."""
    return _simplex(lambda c: -nsp.normalized_scalar_product(shell, c, width))


def _least_squares_by_simplex(shell: Shell) -> FloatArray:
    """eq:LS1 minimised as the paper does it."""
    power = (shell.magnitude / shell.magnitude.max()) ** 2
    column, m = np.nonzero(power >= leastsquares.THRESHOLD)
    kx, ky, shift = shell.kx[column], shell.ky[column], shell.omega[m] - shell.intrinsic[column]
    return _simplex(lambda c: float(np.sum((kx * c[0] + ky * c[1] - shift) ** 2)))
