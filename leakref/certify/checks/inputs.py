"""The inputs of the checks: small seas and aligned waves with a known current, the same bits every time.

No two sizes and no two spacings of a grid are alike, and dkx differs from dky, unless a case is about that. What a
check writes down are the published questions; what a seed makes of them is in `draw`, and applied here.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass, field
from functools import cached_property, lru_cache
from typing import Any

import numpy as np

from leakref._base import FloatArray
from leakref.certify.checks.draw import PUBLISHED, asked_fastest, asked_seed, drawing
from leakref.certify.subject.declaration import Declaration
from leakref.certify.subject.frames import Subject
from leakref.currents import Current, UniformCurrent, shift_in
from leakref.dispersion import DEEP, Water, velocity_resolutions
from leakref.grid import Grid
from leakref.sea import Components, SeaState, aligned_waves
from leakref.synthesis import synthesize

__all__ = [
    "BRIEF",
    "EVEN",
    "GRIDS",
    "ODD",
    "PRIME",
    "SEA",
    "SHELLS",
    "TWELVE",
    "ByShell",
    "Cube",
    "asked",
    "drawn",
    "fitting",
    "in_water",
    "many",
    "on_bins",
    "pair",
    "polar",
    "ring",
    "sampling",
    "sea",
    "still",
    "together",
    "waves",
]

SEA = Grid((50, 44, 80), (0.63, 0.68, 0.78))
"""Five peak wavelengths by ten periods, a tenth of a wavelength and an eighth of a period apart."""
BRIEF = Grid((46, 42, 52), (0.62, 0.71, 0.43))
"""Three and a half periods: the frequency bins are wide, and so is the range in which a search from zero current finds
one."""
EVEN = Grid((28, 34, 96), (0.9, 0.7, 0.6))
ODD = Grid((27, 35, 99), (0.93, 0.68, 0.58))
PRIME = Grid((31, 29, 97), (0.77, 0.87, 0.61))
GRIDS = {"even": EVEN, "odd": ODD, "prime": PRIME}
"""For aligned waves: long, so that the frequency bins are narrow."""
SHELLS = (1.25, 1.5, 1.8, 2.15)
"""Wavenumbers at which seas are judged: above the peak, their shells well below Nyquist."""
_PHASES = (0.3, 1.9)  # of a pair


_SQUARE: ContextVar[bool] = ContextVar("square", default=False)
_STILL: ContextVar[Water] = ContextVar("still", default=DEEP)
_SHOWN: ContextVar[Declaration | None] = ContextVar("shown", default=None)


@contextmanager
def asked(subject: Subject, seed: int) -> Iterator[None]:
    """Within it the questions are those of a seed, as a subject is shown them: with square pixels if it knows no
    others, of the sizes that it takes, in its water, on currents that it is made for. Other threads go on with theirs.
    """
    declared = subject.shown_as
    tokens = _SQUARE.set("dy" in subject.declaration.untold), asked_seed.set(seed), _SHOWN.set(declared)
    try:
        with in_water(subject.still(), declared.fastest()):
            yield
    finally:
        _SQUARE.reset(tokens[0])
        asked_seed.reset(tokens[1])
        _SHOWN.reset(tokens[2])


@contextmanager
def in_water(water: Water, fastest: float | None = None) -> Iterator[None]:
    """Within it cubes are made of waves of that water, on currents up to `fastest` (as before), in scaled units."""
    token, other = _STILL.set(water), asked_fastest.set(asked_fastest.get() if fastest is None else fastest)
    try:
        yield
    finally:
        _STILL.reset(token)
        asked_fastest.reset(other)


def fitting(grid: Grid, square: bool = False) -> Grid:
    """The grid, or for a code that takes certain numbers of samples one as long with such.

    With `square` pixels the step along y is that along x, and the grid as long along y as whole samples have it.
    """
    declared, (nx, ny, nt), (dx, dy, dt) = _SHOWN.get(), grid.shape, grid.spacing
    multiple, shape = (1, None) if declared is None else (declared.multiple, declared.shape)
    if multiple == 1 and shape is None:  # rows stay odd or even
        return grid if not square else Grid((nx, ny + 2 * round((ny * dy / dx - ny) / 2), nt), (dx, dx, dt))
    n, _, k = shape or tuple(-(-samples // multiple) * multiple for samples in grid.shape)
    dx = dx * nx / n
    if square:
        rows = shape[1] if shape else max(1, round(ny * dy / dx / multiple)) * multiple
        return Grid((n, rows, k), (dx, dx, dt * nt / k))
    rows = shape[1] if shape else -(-ny // multiple) * multiple
    return Grid((n, rows, k), (dx, dy * ny / rows, dt * nt / k))


def still() -> Water:
    """The water of the cubes that are made now, in scaled units."""
    return _STILL.get()


def sampling(grid: Grid) -> Grid:
    """The grid, or where pixels must be square one like it with dy = dx, of samples that the code takes."""
    return fitting(grid, _SQUARE.get())


def drawn(grid: Grid) -> Grid:
    """The grid of a sea, as the seed has it. Grids on whose bins waves lie are kept."""
    return sampling(drawing().grid(grid))


@dataclass(frozen=True, eq=False)
class Cube:
    """A surface and what is known of it, in scaled units: its waves and current, and `wavenumbers` (n,) to ask for.

    `water` is the one it is made in, that of the question where it is not given; it is shown at `scale` times the usual
    peak wavenumber.
    `noise` is white, a part of the waves' standard deviation, the same samples every time.
    Two that show the same waves on the same grid, asked for the same wavenumbers, are equal: a search for a cure puts
    the same questions again and again, and what is right of them is worked out once.
    """

    components: Components
    grid: Grid
    wavenumbers: FloatArray
    current: Current
    water: Water = field(default_factory=still)
    scale: float = 1.0
    noise: float = 0.0

    @cached_property
    def _shown(self) -> tuple[object, ...]:
        waves = self.components
        arrays = (waves.kx, waves.ky, waves.omega, waves.amplitude, waves.phase, self.wavenumbers)
        return (self.grid, self.water, self.noise, *(np.asarray(array, dtype=np.float64).tobytes() for array in arrays))

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Cube) and self._shown == other._shown

    def __hash__(self) -> int:
        return hash(self._shown)

    @cached_property
    def surface(self) -> FloatArray:
        """eta[x, y, t], read-only."""
        eta = synthesize(self.components, *(self.grid.samples(axis) for axis in range(3)))
        if self.noise:
            deviation = self.noise * np.sqrt(self.components.variance)
            eta += deviation * np.random.default_rng(PUBLISHED).standard_normal(eta.shape)
        eta.flags.writeable = False
        return eta

    @property
    def spacing(self) -> tuple[float, float, float]:
        """dx, dy, dt."""
        return self.grid.spacing

    @property
    def truth(self) -> FloatArray:
        """The Doppler shift velocity of the current at each wavenumber, (n, 2) (eq:SJ)."""
        return shift_in("truth", self.current, self.wavenumbers, self.water)

    @property
    def resolutions(self) -> FloatArray:
        """The smaller and the larger of the two of eq:dcdwk at each wavenumber, (2, n)."""
        bins = self.grid.wavenumber_resolution, self.grid.frequency_resolution
        return np.sort(velocity_resolutions(self.wavenumbers, *bins, self.water), axis=0)


@dataclass(frozen=True, eq=False)
class ByShell:
    """Another current at each of some wavenumbers (n,): `velocities` (n, 2), as no profile over depth would have it."""

    wavenumbers: FloatArray
    velocities: FloatArray

    def doppler_shift_velocity(self, wavenumber: FloatArray, water: Water = DEEP) -> FloatArray:
        """(m, 2): the velocity of the nearest of the wavenumbers, whatever the water."""
        return self.velocities[np.abs(np.asarray(wavenumber)[:, None] - self.wavenumbers).argmin(axis=1)]


def polar(speed: float, direction: float) -> tuple[float, float]:
    """A velocity of that speed going to `direction` in degrees."""
    return float(speed * np.cos(np.radians(direction))), float(speed * np.sin(np.radians(direction)))


def sea(
    direction: float,
    spread: float,
    current: Current | None = None,
    *,
    realization: int = 0,
    peakedness: float = 3.3,
    grid: Grid = SEA,
    wavenumbers: tuple[float, ...] = SHELLS,
) -> Cube:
    """A JONSWAP sea on a current."""
    draw = drawing()
    return _sea(
        draw.direction(direction),
        spread,
        draw.current(current),
        draw.realization(realization),
        peakedness,
        drawn(grid),
        wavenumbers,
        still(),
    )


@lru_cache(maxsize=64)
def _sea(
    direction: float,
    spread: float,
    current: Any,
    realization: int,
    peakedness: float,
    grid: Grid,
    wavenumbers: tuple[float, ...],
    water: Water,
) -> Cube:
    """A realisation of a sea of the chain on a grid, with waves between the bins as they are at sea."""
    state = SeaState(direction, spread, peakedness, float(min(grid.lengths[:2])) / (2 * np.pi), current, water)
    return Cube(state.components(realization), grid, np.array(wavenumbers), current)


def pair(grid: Grid, first: tuple[int, int], second: tuple[int, int], near: tuple[float, float]) -> Cube:
    """Two waves exactly on bins (i, j), at the frequency bins that a current closest to `near` puts them on.

    Asked for half-way between their wavenumbers. Their current is exact, and not quite `near`.
    """
    draw = drawing()
    one, two = draw.bins(first, second)
    return _pair(sampling(grid), one, two, draw.near(near), tuple(draw.phases(np.array(_PHASES)).tolist()), still())


@lru_cache(maxsize=64)
def _pair(
    grid: Grid,
    first: tuple[int, int],
    second: tuple[int, int],
    near: tuple[float, float],
    phase: tuple[float, float],
    water: Water,
) -> Cube:
    """Two waves on bins, and the current near the one wished for under which both lie on bins of the frequency too."""
    k = np.array([first, second]) * grid.bin_widths[:2]
    size = np.hypot(*k.T)
    m = np.rint((water.frequency(size) + k @ np.asarray(near)) / grid.frequency_resolution).astype(int)
    components, current = aligned_waves(grid, [(*first, int(m[0])), (*second, int(m[1]))], phase=phase, water=water)
    return Cube(components, grid, np.array([size.mean()]), UniformCurrent((float(current[0]), float(current[1]))))


def waves(
    grid: Grid,
    kx: FloatArray,
    ky: FloatArray,
    wavenumbers: tuple[float, ...],
    current: Current | None = None,
    amplitude: FloatArray | float = 1.0,
) -> Cube:
    """Waves at any wavenumbers (n,) on a current, turned as the seed has it, on a grid that is kept.

    Phases are scattered evenly.
    """
    draw = drawing()
    current, grid, (kx, ky) = draw.current(current), sampling(grid), draw.turn @ np.stack([kx, ky])
    size = np.hypot(kx, ky)
    shift = shift_in("waves", current, size, still())
    omega = still().frequency(size) + kx * shift[:, 0] + ky * shift[:, 1]
    phase = draw.phases(2 * np.pi * (np.arange(kx.size) * np.sqrt(5.0) % 1))
    return Cube(
        Components(kx, ky, omega, np.broadcast_to(amplitude, kx.shape), phase), grid, np.array(wavenumbers), current
    )


def on_bins(
    grid: Grid,
    bins: FloatArray,
    wavenumbers: FloatArray,
    current: Current,
    amplitude: FloatArray | float = 1.0,
    velocities: FloatArray | None = None,
) -> Cube:
    """Waves at bins (i, j), (n, 2), each at the frequency bin nearest to where `velocities` (n, 2), or the current,
    puts it. `bins` are turned already, as the seed has it.
    """
    kx, ky = np.asarray(bins, dtype=np.float64).T * np.array(grid.bin_widths[:2])[:, None]
    size = np.hypot(kx, ky)
    velocities = current.doppler_shift_velocity(size) if velocities is None else velocities
    bin_ = np.rint(
        (still().frequency(size) + kx * velocities[:, 0] + ky * velocities[:, 1]) / grid.frequency_resolution
    )
    phase = drawing().phases(2 * np.pi * (np.arange(kx.size) * np.sqrt(5.0) % 1))
    waves_ = Components(kx, ky, bin_ * grid.frequency_resolution, np.broadcast_to(amplitude, kx.shape), phase)
    return Cube(waves_, grid, wavenumbers, current)


def ring(radius: int, wavenumber: float, periods: int, shape: tuple[int, int, int]) -> Grid:
    """A grid of equal sides on which a `wavenumber` is a whole number of bins, `radius`, and its frequency in still
    water a whole number of them too, `periods`.
    """
    side, duration = 2 * np.pi * radius / wavenumber, 2 * np.pi * periods / float(still().frequency(wavenumber))
    nx, ny, nt = shape
    ny = nx if _SQUARE.get() else ny
    return fitting(Grid((nx, ny, nt), (side / nx, side / ny, duration / nt)))


TWELVE = np.array(
    [(5, 0), (4, 3), (3, 4), (0, 5), (-3, 4), (-4, 3), (-5, 0), (-4, -3), (-3, -4), (0, -5), (3, -4), (4, -3)]
)


def many(shape: tuple[int, int, int], *nears: tuple[float, float]) -> Cube:
    """Twelve waves all round on bins, and as many half as long for a second current if there are two of them.

    Their currents are those closest to `nears` that put each wave on a bin. What omega0 is off a bin is the same for
    all of a length, so that the current is exact.
    """
    draw, grid = drawing(), ring(5, 1.4, 24 if len(nears) < 2 else 18, shape)
    step = grid.frequency_resolution / grid.wavenumber_resolution
    wavenumbers = 1.4 * 2.0 ** np.arange(len(nears))
    velocities = np.array([step * np.rint(np.array(draw.near(near)) / step) for near in nears])
    bins = np.concatenate([TWELVE * 2**n for n in range(len(nears))])
    each = np.repeat(velocities, 12, axis=0)
    return on_bins(grid, bins, wavenumbers, ByShell(wavenumbers, velocities), velocities=each)


def together(*seas: Components) -> Components:
    """Waves of several seas in one."""
    return Components(
        *(np.concatenate([getattr(waves, name) for waves in seas]) for name in Components.__dataclass_fields__)
    )
