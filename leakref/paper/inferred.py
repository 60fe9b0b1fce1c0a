"""What leakage does to a depth that is inferred along with the current: the question that the paper leaves open.

Seas over a bottom at k0 h = 0.7, 1, 1.5, 2, in still water, on the domains of case-L-T, untapered and tapered. From
each realisation a depth is inferred (`depth`) from single shells and from the whole band, with the current searched for
along with it or known to be zero. What is reported is relative to the true depth: `bias` the mean of h / h_true - 1 and
`random` its standard deviation, over the realisations that have a number, and how many these are.

One realisation is a part by itself, kept and resumed as those of `runs` are: it is the same bits wherever it is
computed, and everything that it depends on is in its name.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from concurrent.futures import Executor
from dataclasses import asdict, dataclass, replace
from functools import cache
from itertools import product, repeat
from pathlib import Path
from typing import Any

import numpy as np

from leakref import depth, kept, runs, sources
from leakref._base import FloatArray, IntArray, LeakrefError, deviation_of_known, mean_of_known
from leakref.cases import SHELLS, Configuration
from leakref.depthscore import depth_resolutions
from leakref.dispersion import velocity_unit
from leakref.fast.spectra import Disc, magnitudes
from leakref.nsp import WIDTH
from leakref.sea import LARGEST_WAVENUMBER
from leakref.shell import EDGE_MARGIN, HALF_WIDTH, Note, Shell
from leakref.window import window as named_window

__all__ = [
    "ALIKE", "BAND", "CURRENTS", "DEPTHS", "DOMAINS", "WAVENUMBERS", "Depths", "domain", "ensembles",
]  # fmt: skip

DEPTHS = (0.7, 1.0, 1.5, 2.0)
"""k0 h: from where most waves feel the bottom to where those of the peak hardly do."""
DOMAINS = tuple(product((5.0, 10.0, 20.0), (10.0, 20.0, 80.0)))
"""(L, T) of case-L-T."""
WAVENUMBERS: FloatArray = np.arange(2, 11) / 5
"""Of the single shells, 0.4 ... 2 k0: those that all these domains have, up to where no bottom is felt."""
CURRENTS = ("along", "known")
"""Whether the current is inferred along with the depth, or known to be zero."""
BAND, ALIKE = -2, -1
"""Places of the band, after the shells: each bin by its magnitude, and each wavenumber alike (`depth.levelled`)."""
_PLACES = WAVENUMBERS.size + 2
_EMPTY = 1e-12  # of the largest bin: below is rounding, as in `shell`


def domain(kh: float, length: float = 10.0, duration: float = 20.0) -> Configuration:
    """A sea of case-L-T (theta0 = 90, spread 60 degrees) over a bottom at k0 h = `kh`, L = 10 and T = 20 by default."""
    varied = ("depth",) if (length, duration) == (10.0, 20.0) else ("depth", "length", "duration")
    return Configuration("depth", depth=float(kh), length=float(length), duration=float(duration), varied=varied)


@dataclass(frozen=True, eq=False)
class Depths:
    """Depths inferred from R realisations under one window, with the current `along` or `known`.

    Places are the shells at WAVENUMBERS, then the band (BAND, ALIKE): p of them. `depths` (R, p) in 1 / k0 and
    `velocities` (R, p, 2) in c0, NaN where there is no number; `curvature` (R, p) of N over ln h; `notes` (R, p).
    """

    configuration: Configuration
    window: str
    current: str
    depths: FloatArray
    velocities: FloatArray
    curvature: FloatArray
    notes: IntArray

    @property
    def off(self) -> FloatArray:
        """h / h_true - 1, (R, p)."""
        return self.depths / self.configuration.depth - 1

    @property
    def count(self) -> IntArray:
        """Realisations with a number, (p,)."""
        return np.isfinite(self.depths).sum(axis=0)

    @property
    def bias(self) -> FloatArray:
        """Mean of h / h_true - 1, (p,); NaN where there is none."""
        return mean_of_known(self.off)

    @property
    def random(self) -> FloatArray:
        """Standard deviation of h / h_true with n - 1, (p,); NaN of fewer than two."""
        return deviation_of_known(self.off)

    @property
    def resolution(self) -> FloatArray:
        """The smaller depth resolution of each shell, as a part of the depth (`depthscore`), (p - 2,)."""
        grid = self.configuration.grid
        both = depth_resolutions(
            WAVENUMBERS, grid.wavenumber_resolution, grid.frequency_resolution, self.configuration.water
        )
        return np.minimum(*both)

    def noted(self, note: Note) -> IntArray:
        """In how many realisations a note was made, (p,)."""
        return ((self.notes & note.value) != 0).sum(axis=0)


# ---- one realisation


@cache
def source_digest() -> str:
    """SHA-256 of all sources that a part depends on, and of the libraries' versions (`sources.digest`)."""
    return sources.digest(__name__)


def _shells(configuration: Configuration, realization: int) -> Iterator[tuple[Shell, Shell, list[Shell]]]:
    """The band, the band with each wavenumber alike, and the shells, under each window of the configuration.

    As `depth.band` and `shell.shell_at` make them, from the magnitudes of the fast path.
    """
    grid, water, dk = configuration.grid, configuration.water, configuration.grid.wavenumber_resolution
    waves, step = configuration.components(realization), grid.frequency_resolution
    disc = Disc(grid, max(SHELLS[1], LARGEST_WAVENUMBER, float(WAVENUMBERS[-1]) + HALF_WIDTH * dk) + EDGE_MARGIN)
    kx, ky = (bins * width for bins, width in zip(disc.bins, grid.bin_widths, strict=False))
    k, m = np.hypot(kx, ky), grid.bins(2)
    weight = np.where((m == 0) | (2 * m == grid.shape[2]), 0.5, 1.0)
    seen = magnitudes(waves, grid, [named_window(name) for name in configuration.windows], disc)

    def within(magnitude: FloatArray, middle: float, half: float) -> Shell:
        on = np.abs(k - middle) / dk <= half + EDGE_MARGIN
        f, still = magnitude[on], float(water.frequency(middle))
        empty = not f.max() > _EMPTY * magnitude.max()
        return Shell(middle, still, kx[on], ky[on], water.frequency(k[on]), m * step, weight, f, None, empty)

    for name in configuration.windows:
        band = within(seen[name], sum(SHELLS) / 2, (SHELLS[1] - SHELLS[0]) / 2 / dk)
        yield band, depth.levelled(band, dk), [within(seen[name], k_i, HALF_WIDTH) for k_i in WAVENUMBERS.tolist()]


def _computed(configuration: Configuration, realization: int) -> dict[str, FloatArray | IntArray]:
    """Of one realisation under w windows: arrays (w, current, p) by name, `velocities` (w, current, p, 2)."""
    water, found = configuration.water, []
    a, unit = WIDTH * configuration.grid.frequency_resolution, velocity_unit(1.0, replace(water, depth=np.inf), 1.0)
    for band, alike, shells in _shells(configuration, realization):
        for current in (None, configuration.current):
            each = [depth.infer(shell, water, width=a, unit=unit, current=current) for shell in (*shells, band, alike)]
            found.append(depth.gathered(each))
    shape = (-1, len(CURRENTS), _PLACES)
    notes = np.array([[note.value for note in one.notes] for one in found], dtype=np.int64)
    return {
        "depths": np.array([one.depths for one in found]).reshape(shape),
        "velocities": np.array([one.velocities for one in found]).reshape(*shape, 2),
        "curvature": np.array([one.curvature for one in found]).reshape(shape),
        "notes": notes.reshape(shape),
    }


def _part(configuration: Configuration, realization: int, folder: Path | None) -> dict[str, Any]:
    """`_computed`, from the folder if it is there, else left there. This is what a worker runs."""
    about: dict[str, Any] = {"configuration": asdict(replace(configuration, varied=())), "source": source_digest()}
    path = folder and folder / f"depth-{kept.key(about)}" / f"{realization:05d}.npz"
    about = {**about, "realization": realization}
    shape: tuple[int, ...] = (len(configuration.windows), len(CURRENTS), _PLACES)
    found = path and kept.arrays(path, about, depths=shape, velocities=(*shape, 2), curvature=shape, notes=shape)
    if not found:
        with runs.one_thread():
            found = _computed(configuration, realization)
        if path is not None:
            kept.keep_arrays(path, about, **found)
    return found


def ensembles(
    configuration: Configuration,
    realizations: int,
    *,
    folder: Path | None = None,
    executor: Executor | None = None,
    after_each: Callable[[], object] = lambda: None,
) -> list[Depths]:
    """Realisations 0 ... `realizations` - 1 of a configuration over a bottom: a Depths for each window and CURRENTS.

    Windows first. As `runs.run`: kept in `folder` one by one and resumed, the same bits whatever the `executor`.
    Raises LeakrefError for deep water, and for fewer than one realisation.
    """
    if not np.isfinite(configuration.depth):
        raise LeakrefError("ensembles", f"{configuration.id} is in deep water", "give one that has a depth")
    if realizations < 1:
        raise LeakrefError("ensembles", f"{realizations} realisations", "ask for at least one")
    given = (repeat(configuration, realizations), range(realizations), repeat(folder))
    parts = []
    for part in map(_part, *given) if executor is None else executor.map(_part, *given):
        parts.append(part)
        after_each()
    stacked = {name: np.array([part[name] for part in parts]) for name in parts[0]}
    return [
        Depths(configuration, window, current, **{name: values[:, w, c] for name, values in stacked.items()})
        for w, window in enumerate(configuration.windows)
        for c, current in enumerate(CURRENTS)
    ]
