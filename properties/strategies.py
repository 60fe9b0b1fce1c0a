"""What the properties are tried on: hostile sizes, waves on bins and off them, small seas; and how many of them.

Sizes are odd, prime, a power of two or tiny, sides very unequal, dx far from dy. Seas and waves are in scaled units, in
the range where a sound code must be right; each strategy says which margins that takes.
"""

from __future__ import annotations

import os
from dataclasses import dataclass, field
from importlib import import_module
from pkgutil import walk_packages
from typing import Any

import numpy as np
from hypothesis import HealthCheck, Phase, assume, settings
from hypothesis import strategies as st

import leakref
from leakref import Components, Grid, SeaState, UniformCurrent, aligned_waves
from leakref.certify.checks.inputs import Cube, polar
from leakref.dispersion import DEEP
from leakref.window import WINDOWS

__all__ = [
    "PROFILES",
    "Drawn",
    "currents",
    "examples",
    "grids",
    "offsets",
    "pairs",
    "positions",
    "seas",
    "singles",
    "sizes",
    "waves",
    "windows",
]

_COMMON: dict[str, Any] = {
    "database": None,
    "deadline": None,
    "print_blob": True,
    "report_multiple_bugs": False,
    # an example is a whole extraction, by a program perhaps, and one that declines a wavenumber drops the example:
    # to be slow, or to drop many, is no fault of the implementation
    "suppress_health_check": [HealthCheck.too_slow, HealthCheck.filter_too_much],
}
for _module in walk_packages(leakref.__path__, "leakref."):
    # Hypothesis draws constants from the modules that are loaded: from all, so that examples do not depend on what ran
    if not _module.name.startswith(("leakref.properties", "leakref._golden")):
        import_module(_module.name)
PROFILES = {"ci": (settings(derandomize=True, **_COMMON), 1), "thorough": (settings(derandomize=False, **_COMMON), 20)}
"""Settings, and how many times the examples of the quick one: `ci` is the same every time, `thorough` is for nights."""


@dataclass(frozen=True, eq=False, repr=False)
class Drawn(Cube):
    """A cube that says in a line how it was made."""

    words: str = field(kw_only=True)

    def __repr__(self) -> str:
        return self.words

    def _repr_pretty_(self, printer: Any, cycle: bool) -> None:  # what hypothesis prints of it
        printer.text(self.words)


SIDES = (11, 12, 13, 16, 17, 19, 23, 25, 31, 32, 36)


def examples(count: int, *, shrink: bool = False) -> settings:
    """Settings of a property for which `count` examples are enough every day; `shrink` where an example is cheap.

    The profile is that of the environment variable LEAKREF_PROPERTIES, which the plugin sets.
    """
    profile, times = PROFILES[os.environ.get("LEAKREF_PROPERTIES", "ci")]
    phases = [Phase.explicit, Phase.generate, *([Phase.shrink] if shrink else [])]
    return settings(profile, max_examples=count * times, phases=phases)


def sizes(largest: int = 64) -> st.SearchStrategy[int]:
    """Sizes of an axis: mostly small, odd and prime ones among them."""
    hostile = [n for n in (2, 3, 4, 5, 7, 8, 11, 13, 16, 31, 32, 61, 64, 127, 128) if n <= largest]
    return st.one_of(st.sampled_from(hostile), st.integers(2, largest))


def windows() -> st.SearchStrategy[str]:
    """Names of the paper's windows."""
    return st.sampled_from(list(WINDOWS))


def offsets(reach: float = 12.0) -> st.SearchStrategy[float]:
    """Distances from a line in bins: any, on bins, and within rounding of them."""
    near = st.sampled_from([0.0, 1e-12, 1e-9, 1e-6, 1e-3, 0.25, 0.5])
    any_ = st.floats(-reach, reach).filter(lambda v: v == 0 or abs(v) > 1e-300)  # whose reciprocal is a number
    return st.one_of(
        any_, st.builds(lambda n, r, s: n + s * r, st.integers(-int(reach), int(reach)), near, st.sampled_from([-1, 1]))
    )


def positions(size: int) -> st.SearchStrategy[float]:
    """Where a wave may be, in bins of an axis of `size` samples: within Nyquist."""
    return offsets(max(1.0, size / 2 - 1))


@st.composite
def grids(draw: st.DrawFn, largest: int = 14) -> Grid:
    """Small boxes for the FFT: all three sizes and spacings different more often than not, sides up to ten to one."""
    shape = tuple(draw(sizes(largest)) for _ in range(3))
    spacing = tuple(draw(st.floats(0.1, 10.0).map(lambda d: float(f"{d:.3g}"))) for _ in range(3))
    return Grid(shape, spacing)  # type: ignore[arg-type]  # three of each


@st.composite
def waves(draw: st.DrawFn, grid: Grid, most: int = 4) -> Components:
    """A few waves on bins, between them, and within rounding of them; not on any dispersion surface."""
    count = draw(st.integers(1, most))
    at = np.array([[draw(positions(n)) for n in grid.shape] for _ in range(count)])
    kx, ky, omega = (at * np.array(grid.bin_widths)).T
    amplitude = [draw(st.floats(0.1, 2.0)) for _ in range(count)]
    phase = [draw(st.floats(0.0, 6.28)) for _ in range(count)]
    return Components(kx, ky, omega, np.array(amplitude), np.array(phase))


def currents(fastest: float = 0.25) -> st.SearchStrategy[tuple[float, float]]:
    """Velocities up to `fastest` in any direction."""
    return st.builds(polar, st.floats(0.0, fastest), st.floats(-180.0, 180.0))


def _boxed(draw: st.DrawFn, bins: list[tuple[int, int]], stretch: float) -> tuple[Grid, list[int]]:
    """A grid on which waves at `bins` (i, j), dkx / dky = `stretch`, are well below Nyquist, and their omega0 in bins.

    Along time the shell around them, moved by any current within 1.2 phase velocities, stays four widths a below
    Nyquist: an optimiser that looks so far must not find G where it has left the band. And a is some third of their
    frequency, so that one that looks along lines sees the basin it starts in.
    """
    size = np.hypot(*(np.array(bins) * [stretch, 1]).T)
    dk = max(stretch, 1.0)
    k0 = draw(st.sampled_from([0.9, 1.1, 1.3, 1.6]))
    unit = k0 / size.mean()  # of dky
    outer = size.mean() + 2.2 * dk
    least = [int(2 * outer / d) + 2 for d in (stretch, 1.0)]
    nx, ny = (draw(st.sampled_from([n for n in (*SIDES, 41, 53, 64, 81, 97, 128) if n >= m][:4])) for m in least)
    low, high = (float(DEEP.frequency(unit * k)) for k in (size.min(), outer))
    domega = low / draw(st.floats(11.6, 12.6))
    nt = int(2 * (high + 1.2 * unit * outer / np.sqrt(k0)) / domega) + 34 + draw(st.integers(0, 7))
    grid = Grid((nx, ny, nt), (2 * np.pi / (nx * stretch * unit), 2 * np.pi / (ny * unit), 2 * np.pi / (nt * domega)))
    return grid, [round(float(DEEP.frequency(unit * k)) / domega) for k in size]


@st.composite
def _bins(draw: st.DrawFn, stretch: float) -> tuple[int, int]:
    """Two and a half to four and a half dk from zero, in bins of dkx = `stretch` dky."""
    r, angle = draw(st.floats(2.5, 4.5)) * max(stretch, 1.0), draw(st.floats(-180.0, 180.0))
    u, v = polar(r, angle)
    return round(u / stretch), round(v)


def _aligned(
    grid: Grid, bins: list[tuple[int, int, int]], amplitude: tuple[float, ...], phase: tuple[float, ...]
) -> Drawn:
    components, (u, v) = aligned_waves(grid, bins, amplitude=amplitude, phase=phase, gravity=1.0)
    k = np.hypot(components.kx, components.ky).mean()
    return Drawn(
        components,
        grid,
        np.array([k]),
        UniformCurrent((float(u), float(v))),
        words=f"aligned_waves({grid}, {bins}, amplitude={amplitude}, phase={phase}) at {k:.6g}",
    )


@st.composite
def pairs(draw: st.DrawFn) -> Cube:
    """Two waves exactly on bins, and the current of at most 0.35 c0 that puts them there, asked for at their mean k.

    The lower frequency is 2 a and more, so that NSP is exact under a box, and each is at most 0.75 a from where it
    would be at rest, so that an optimiser that starts there finds it.
    """
    stretch = draw(st.sampled_from([1.0, 0.8, 1.3, 2.0, 0.4, 3.0]))
    first, second = draw(_bins(stretch)), draw(_bins(stretch))
    k = np.array([first, second]) * [stretch, 1]
    size = np.hypot(*k.T)
    assume(size.min() > 2 and abs(np.diff(size)[0]) < 2 * max(stretch, 1.0))
    assume(abs(np.linalg.det(k)) > 0.5 * size.prod())
    grid, rest = _boxed(draw, [first, second], stretch)
    m = [n + draw(st.integers(-3, 3)) for n in rest]
    amplitude = (1.0, draw(st.floats(0.6, 1.0)))
    phase = draw(st.floats(0, 6.28)), draw(st.floats(0, 6.28))
    cube = _aligned(grid, [(*first, m[0]), (*second, m[1])], amplitude, phase)
    assume(np.hypot(*cube.truth[0]) < 0.35)
    return cube


@st.composite
def singles(draw: st.DrawFn) -> Cube:
    """One wave exactly on a bin, asked for at its own k; the current is the component along it."""
    stretch = draw(st.sampled_from([1.0, 0.8, 1.3, 2.0, 0.4, 3.0]))
    at = draw(_bins(stretch))
    assume(np.hypot(at[0] * stretch, at[1]) > 2)
    grid, (rest,) = _boxed(draw, [at], stretch)
    return _aligned(grid, [(*at, rest + draw(st.integers(-3, 3)))], (1.0,), (draw(st.floats(0, 6.28)),))


@st.composite
def seas(draw: st.DrawFn, *, shells: int = 2, narrowest: float = 90.0, fastest: float = 0.25) -> Cube:
    """Broad seas on a current, three to five wavelengths by three to six periods, odd, prime and unequal sides.

    Asked for where shells keep clear of the bins around zero and of Nyquist: 3.6 to 5.5 dk.
    """
    nx, ny = (draw(st.sampled_from((27, 29, 32, 35, 37, 40, 41))) for _ in range(2))
    dx, dy = (draw(st.sampled_from((0.62, 0.7, 0.78))) for _ in range(2))
    nt, dt = draw(st.sampled_from((41, 47, 48, 53, 55, 64))), draw(st.sampled_from((0.5, 0.6, 0.7)))
    grid = Grid((nx, ny, nt), (dx, dy, dt))
    spread, direction = draw(st.floats(narrowest, 360.0)), draw(st.floats(-180.0, 180.0))
    length = float(min(grid.lengths[:2])) / (2 * np.pi)
    state = SeaState(
        direction, spread, draw(st.sampled_from((1.0, 3.3, 7.0))), length, UniformCurrent(draw(currents(fastest)))
    )
    k = grid.wavenumber_resolution * np.array([draw(st.floats(3.6, 5.5)) for _ in range(shells)])
    assume(k.max() + 2.2 * grid.wavenumber_resolution < min(grid.nyquist[:2]))
    n = draw(st.integers(0, 1000))
    return Drawn(
        state.components(n),
        grid,
        np.sort(k),
        state.current,
        words=f"{state}.components({n}) on {grid} at {np.sort(k).tolist()}",
    )
