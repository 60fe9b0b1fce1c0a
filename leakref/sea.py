"""The sea: a directional JONSWAP spectrum as plane waves on a lattice, or any waves one lists.

A wave of wave vector k on a lattice of spacing dk has the amplitude (eq:amplitudes, equation 12; decision D15)

    a(k) = sqrt(S(omega0 / omega_p) D(k h) f(theta) 2 (d omega0 / d k) / k) dk,

with S the density over frequencies of eq:JONSWAP (equation 8), f that over directions of eq:angularspread (equation
11), theta the direction of k, omega0(k) the frequency in still water and omega_p = omega0(k0), k0 being the wavenumber
of the spectral peak (rad per length). D is the depth factor of the TMA spectrum (`Water.depth_factor`), 1 in deep
water. Scaled units: lengths in 1 / k0, times in 1 / sqrt(g k0), which is 1 / omega_p in deep water.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
import numpy.typing as npt

from leakref._base import FloatArray, IntArray, LeakrefError, finite, integer, positive
from leakref.currents import Current, UniformCurrent, is_current, shift_in
from leakref.dispersion import DEEP, Scales, Water, law
from leakref.grid import Grid

__all__ = [
    "INPUT_SPACING", "LARGEST_WAVENUMBER", "Components", "SeaState", "aligned_waves", "directional_spreading",
    "jonswap", "uniform_phases",
]  # fmt: skip

INPUT_SPACING = 0.341
"""Lattice spacing of the input waves in units of 1 / L (sec:parameters, decision D10)."""
LARGEST_WAVENUMBER = 3.5
"""No wave beyond this many peak wavenumbers (below eq:amplitudes)."""
_ORIGIN = 1 << 32  # lattice index (0, 0) in the counter of the phases: far from either end of a word


@dataclass(frozen=True, eq=False)
class Components:
    """Plane waves `amplitude cos(kx x + ky y - omega t + phase)`, five arrays of shape (n,).

    Angular units; omega includes the Doppler shift and may be negative (a wave swept backwards).
    Raises LeakrefError for unequal sizes, no waves at all or values that are not finite.
    """

    kx: FloatArray
    ky: FloatArray
    omega: FloatArray
    amplitude: FloatArray
    phase: FloatArray

    def __post_init__(self) -> None:
        for name in self.__dataclass_fields__:
            object.__setattr__(self, name, finite("Components", name, np.atleast_1d(getattr(self, name)), 1))
        sizes = {name: getattr(self, name).size for name in self.__dataclass_fields__}
        if len(set(sizes.values())) != 1 or not self.kx.size:
            raise LeakrefError("Components", f"sizes {sizes}", "give five arrays of one size, at least one wave")

    @property
    def variance(self) -> float:
        """Mean square elevation, sum of amplitude^2 / 2."""
        return float(np.sum(self.amplitude**2) / 2)

    def rotated(self, angle: float, centre: Sequence[float]) -> Components:
        """The same sea, current and all, turned by `angle` degrees about `centre` (x, y) (decision D13)."""
        c, s = np.cos(np.radians(angle)), np.sin(np.radians(angle))
        kx, ky = c * self.kx - s * self.ky, s * self.kx + c * self.ky
        shift = (self.kx - kx) * centre[0] + (self.ky - ky) * centre[1]
        return Components(kx, ky, self.omega, self.amplitude, self.phase + shift)

    def to_units(self, scales: Scales) -> Components:
        """From scaled units to those of `scales`."""
        kx, ky = self.kx * scales.wavenumber, self.ky * scales.wavenumber
        return Components(kx, ky, self.omega * scales.frequency, self.amplitude * scales.length, self.phase)

    def separated(self) -> tuple[FloatArray, IntArray, FloatArray, IntArray] | None:
        """The lattice behind the waves: kx = a[i], ky = b[j], as (a, i, b, j).

        None if the waves share too few wavenumbers along the axes for a dense matrix to pay.
        """
        a, i = np.unique(self.kx, return_inverse=True)
        b, j = np.unique(self.ky, return_inverse=True)
        dense = a.size * b.size <= 8 * self.kx.size and len(set(zip(i, j, strict=True))) == self.kx.size
        return (a, i, b, j) if dense else None


def jonswap(frequency: npt.ArrayLike, peakedness: float = 3.3) -> FloatArray:
    """S(omega) of eq:JONSWAP with eq:JONSWAP_params, N = 1; `frequency` in units of that of the peak."""
    w = np.maximum(np.asarray(frequency, dtype=np.float64), 1e-3)  # where it has vanished, and no power overflows
    sigma = np.where(w <= 1, 0.07, 0.09)
    r = np.exp(-0.5 * ((w - 1) / sigma) ** 2)
    return w**-5 * np.exp(-1.25 * w**-4) * peakedness**r


def directional_spreading(direction: npt.ArrayLike, mean: float, spread: float) -> FloatArray:
    """f(theta) of eq:angularspread, not normalised: its integral is half the `spread`. All in degrees."""
    off = (np.asarray(direction, dtype=np.float64) - mean + 180) % 360 - 180
    return np.where(np.abs(off) <= spread / 2, np.cos(np.pi * off / spread) ** 2, 0.0)


def uniform_phases(realization: int, i: IntArray, j: IntArray) -> FloatArray:
    """Random phases in [0, 2 pi) that depend on nothing but the realisation and the lattice point (i, j).

    The first 53 bits of the first word of Philox4x64-10 at counter (j + 2^32, i + 2^32, 0, 0) and key
    (realization, 0), over 2^53: the same on every platform and library version, and for every sea
    state on the same lattice (decision D11).
    """
    phases = np.empty(np.shape(i))
    for row in np.unique(i):  # one stream a row; a block of four words for each j, of which the first is used
        on = i == row
        low, high = int(j[on].min()), int(j[on].max())
        counter = np.array([low + _ORIGIN - 1, int(row) + _ORIGIN, 0, 0], dtype=np.uint64)
        stream = np.random.Philox(counter=counter, key=np.array([realization, 0], dtype=np.uint64))
        words = stream.random_raw(4 * (high - low + 1))[::4]
        phases[on] = (words[j[on] - low] >> np.uint64(11)) * (2 * np.pi * 2.0**-53)
    return phases


@dataclass(frozen=True)
class SeaState:
    """A JONSWAP sea with cosine-square spreading in scaled units (sec:spectrum), on a lattice of waves.

    `direction` theta0 (going-to) and `spread` (full width) in degrees, `peakedness` gamma, `length` the domain L that
    sets the lattice spacing, `current` what shifts the waves, `water` of gravity 1 and depth k0 h. Raises LeakrefError.
    """

    direction: float = 90.0
    spread: float = 60.0
    peakedness: float = 3.3
    length: float = 10.0
    current: Current = field(default_factory=UniformCurrent)
    water: Water = DEEP

    def __post_init__(self) -> None:
        finite("SeaState", "direction", self.direction)
        is_current("SeaState", self.current)
        positive("SeaState", spread=self.spread, peakedness=self.peakedness, length=self.length)
        if law("SeaState", None, self.water).gravity != 1:
            raise LeakrefError("SeaState", f"water = {self.water} is not in scaled units", "give Water(depth=k0 h)")
        if self.spread > 360:
            raise LeakrefError("SeaState", f"spread = {self.spread} degrees", "give a full width of at most 360")

    def components(self, realization: int) -> Components:
        """The waves of one realisation (counted from 0), on those lattice points where the sea has energy.

        The energy in a cell is a(k)^2 / 2, S f k^-3/2 / 2 dk^2 in deep water (decision D15: printed is another power
        of dk and a factor 2); S is taken at the intrinsic frequency (D17) over the peak's (D27), omega is eq:SnJ.
        """
        if integer("SeaState.components", "realization", realization) >= 2**63:
            raise LeakrefError("SeaState.components", f"realization = {realization}", "count them 0, 1, 2, ...")
        dk = INPUT_SPACING / self.length
        m = int(LARGEST_WAVENUMBER / dk)
        i, j = (index.ravel() for index in np.mgrid[-m : m + 1, -m : m + 1])
        k = dk * np.hypot(i, j)
        f = directional_spreading(np.degrees(np.arctan2(j, i)), self.direction, self.spread)
        inside = (k > 0) & (k <= LARGEST_WAVENUMBER) & (f > 0)
        i, j, k, f = i[inside], j[inside], k[inside], f[inside]
        water, peak = self.water, self.water.frequency(1.0)
        density = jonswap(water.frequency(k) / peak, self.peakedness) * water.depth_factor(k)
        energy = water.density_factor(k) * density * f * dk**2
        i, j, k, energy = (values[energy > 0] for values in (i, j, k, energy))
        if not k.size:
            fault = f"no lattice point lies within the spread of {self.spread} degrees at length {self.length}"
            raise LeakrefError("SeaState.components", fault, "widen the spread or enlarge the domain")
        shift = shift_in("SeaState.components", self.current, k, water)
        omega = water.frequency(k) + dk * (i * shift[:, 0] + j * shift[:, 1])
        return Components(dk * i, dk * j, omega, np.sqrt(energy), uniform_phases(int(realization), i, j))


def aligned_waves(
    grid: Grid,
    bins: Sequence[tuple[int, int, int]],
    *,
    amplitude: Sequence[float] = (1.0, 0.7),
    phase: Sequence[float] = (0.3, 1.9),
    gravity: float | None = None,
    water: Water | None = None,
) -> tuple[Components, FloatArray]:
    """One or two waves exactly on bins (i, j, m) of `grid`, and the uniform current (2,) that puts them there.

    Two waves that are not parallel fix the current: omega0(k) + k.U = m domega is a 2x2 system. One wave fixes its
    component along the wave, and that is returned. `water` is given, or a `gravity`. Raises LeakrefError otherwise.
    """
    if len(bins) not in (1, 2):
        raise LeakrefError("aligned_waves", f"{len(bins)} waves", "give one or two bins (i, j, m)")
    number = np.asarray(bins)
    outside = 2 * np.abs(number) >= np.asarray(grid.shape)
    if number.shape[1:] != (3,) or not np.array_equal(number, np.rint(number)) or outside.any():
        nyquist = tuple(n // 2 for n in grid.shape)
        fault = f"bins {list(bins)} are not all on the grid, short of its Nyquist bins {nyquist}"
        raise LeakrefError("aligned_waves", fault, "give whole numbers (i, j, m) within them")
    k = number[:, :2] * np.asarray(grid.bin_widths[:2])
    omega = number[:, 2] * grid.frequency_resolution
    if len(bins) == 2 and abs(np.linalg.det(number[:, :2].astype(float))) < 0.5:
        raise LeakrefError("aligned_waves", f"the waves {list(bins)} are parallel", "choose two directions")
    if not k.any(axis=1).all():
        raise LeakrefError("aligned_waves", "a wave has wavenumber zero", "choose bins with i or j other than 0")
    shift = omega - law("aligned_waves", gravity, water).frequency(np.hypot(*k.T))
    current = np.linalg.lstsq(k, shift, rcond=None)[0]
    return Components(k[:, 0], k[:, 1], omega, *[np.asarray(v[: len(bins)]) for v in (amplitude, phase)]), current
