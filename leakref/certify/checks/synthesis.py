"""Energy and statistics of a synthesised surface.

For codes that make surfaces, to test themselves or others: single waves sample by sample, sums, linearity, and the
energy that the amplitudes say. A generator that is wrong here makes every test that it feeds wrong.
"""

from __future__ import annotations

import numpy as np

from leakref._base import FloatArray
from leakref.certify.checks.criteria import vector
from leakref.certify.checks.registry import Case, Outcome, check
from leakref.certify.subject.frames import Subject
from leakref.dispersion import DEEP
from leakref.grid import Grid
from leakref.sea import Components, SeaState

__all__ = ["PRECISION", "check_energy", "check_linearity", "check_mean_energy", "check_single", "check_sum"]

PRECISION = 1e-4
"""Of the sum of the amplitudes: ten times what single precision rounds phases of a hundred radians by."""
SINGLE = (
    "A sample of the surface may be off by 1e-4 of the amplitude, or of the sum of the amplitudes where there "
    "are several waves: ten times what single precision rounds phases of a hundred radians by."
)
NAMES = tuple(Components.__dataclass_fields__)
GRID = Grid((24, 20, 36), (0.9, 1.1, 0.7))


def _axes(grid: Grid) -> tuple[FloatArray, FloatArray, FloatArray]:
    x, y, t = (grid.samples(axis) for axis in range(3))
    return x, y, t


def _plain(waves: Components, x: FloatArray, y: FloatArray, t: FloatArray) -> FloatArray:
    """The sum of cosines itself, wave by wave."""
    eta = np.zeros((x.size, y.size, t.size))
    for kx, ky, omega, amplitude, phase in zip(*(getattr(waves, n) for n in NAMES), strict=True):
        eta += amplitude * np.cos((kx * x + phase)[:, None, None] + (ky * y)[:, None] - omega * t)
    return eta


def _slips(waves: Components) -> dict[str, Components]:
    """What a slip of sign or order makes of waves."""
    kx, ky, omega, a, phase = (getattr(waves, name) for name in NAMES)
    return {
        "travels the other way in time": Components(kx, ky, -omega, a, phase),
        "travels the other way along x": Components(-kx, ky, omega, a, phase),
        "travels the other way along y": Components(kx, -ky, omega, a, phase),
        "has x and y exchanged": Components(ky, kx, omega, a, phase),
        "has the sign of the phase wrong": Components(kx, ky, omega, a, -phase),
        "is a sine": Components(kx, ky, omega, a, phase - np.pi / 2),
    }


def _compared(subject: Subject, waves: Components, axes: tuple[FloatArray, FloatArray, FloatArray]) -> Outcome:
    """Sample by sample with the plain sum; a slip that explains the difference is named."""
    found, should, scale = subject.synthesize(waves, *axes), _plain(waves, *axes), float(np.abs(waves.amplitude).sum())
    over = float(np.abs(found - should).max()) / (PRECISION * scale)
    if over <= 1:
        return Outcome(over, f"the surface is right to {over * PRECISION:.1g} of its amplitude")
    slip = next(
        (
            name
            for name, other in _slips(waves).items()
            if np.abs(found - _plain(other, *axes)).max() <= 10 * PRECISION * scale
        ),
        "",
    )
    factor = float((found * should).sum() / (should**2).sum())
    told = f"the surface {slip}" if slip else f"the surface is off by {over * PRECISION:.2g} of its amplitude"
    return Outcome(over, f"{told}; it is {factor:.4g} of what it should be", figures={"slip": slip, "factor": factor})


@check(
    "synthesis",
    "sec:spectrum",
    SINGLE,
    [Case(f"to-{angle}", {"direction": angle}, quick=angle != 340) for angle in (35, 160, 250, 340)],
    stage="synthesize",
)
def check_single(subject: Subject, case: Case) -> Outcome:
    """One wave, cos(k.x - omega t + phase): it travels the way of its wavenumber, starts at its phase, has its
    amplitude, and x comes first."""
    angle = np.radians(case.given["direction"])
    k = 1.3 * np.array([np.cos(angle), np.sin(angle)])
    one = Components(k[:1], k[1:], *(np.array([v]) for v in (np.sqrt(1.3), 0.8, 0.9)))
    return _compared(subject, one, _axes(GRID))


@check(
    "synthesis",
    "sec:spectrum",
    SINGLE,
    [Case("lattice"), Case("scattered"), Case("backwards"), Case("oblong"), Case("two", quick=False)],
    stage="synthesize",
)
def check_sum(subject: Subject, case: Case) -> Outcome:
    """Waves on a lattice, waves on none, waves of negative frequency, on axes that do not start at zero and are all of
    another length: a transform that wants a lattice, or abs() of a frequency, shows."""
    axes = _axes(Grid((7, 31, 4), (1.7, 0.6, 2.1)) if case.id == "oblong" else GRID)
    if case.id == "lattice":
        return _compared(subject, SeaState(40.0, 70.0, length=2.0).components(3), axes)
    n = np.arange(1, 18 if case.id != "two" else 3)
    k, angle = 0.5 + 1.7 * (n * np.sqrt(2) % 1), 2 * np.pi * (n * np.sqrt(3) % 1)
    shift = 1.6 * np.cos(angle) if case.id == "backwards" else 0.0 * n
    waves = Components(
        k * np.cos(angle),
        k * np.sin(angle),
        DEEP.frequency(k) + k * shift,
        0.2 + (n * np.sqrt(5) % 1),
        2 * np.pi * (n * np.sqrt(7) % 1),
    )
    moved = [axis + start for axis, start in zip(axes, (-3.2, 5.1, 2.3), strict=True)]
    return _compared(subject, waves, (moved[0], moved[1], moved[2]))


def _aligned(count: int, which: int) -> Components:
    """Waves on different bins of GRID short of Nyquist, none the mirror image of another."""
    n = np.arange(count)
    i, j, m = n % 10 + 1, (n // 10 + 3 * n) % 18 - 9, n % 16 + 1
    kx, ky, omega = (bins * width for bins, width in zip((i, j, m), GRID.bin_widths, strict=True))
    return Components(kx, ky, omega, 0.1 + (n * np.sqrt(2) % 1), 2 * np.pi * ((n + 1) * np.sqrt(3 + which) % 1))


@check(
    "synthesis",
    "eq:amplitudes",
    "The mean square of all samples may be off by 1e-4 of the sum of a^2 / 2: single precision errs by far less, and "
    "the smallest of the mistakes that are looked for by a third.",
    [Case("40", {"count": 40}), Case("80", {"count": 80}, quick=False)],
    stage="synthesize",
)
def check_energy(subject: Subject, case: Case) -> Outcome:
    """Waves with whole numbers of wavelengths and periods in the cube, another set for each, are orthogonal: the mean
    square over all places and times is exactly the sum of a^2 / 2. Amplitudes drawn at random, which hold two thirds of
    that in the mean, or heights taken for amplitudes, which hold four times as much, are far off."""
    waves = _aligned(case.given["count"], 0)
    mean = float(np.mean(subject.synthesize(waves, *_axes(GRID)) ** 2))
    return Outcome(
        abs(mean / waves.variance - 1) / PRECISION,
        f"the mean square is {mean / waves.variance:.6g} of the sum of a^2 / 2",
        figures={"ratio": mean / waves.variance},
    )


@check(
    "synthesis",
    "eq:amplitudes",
    "The mean energy may be off by 5 % of what was asked for, which thirty waves on "
    "bins hold exactly in each surface; what is looked for is a third.",
    [Case("eight-surfaces")],
    stage="synthesize",
)
def check_mean_energy(subject: Subject, case: Case) -> Outcome:
    """The energy asked for, in the mean of several surfaces with the same amplitudes and other phases: amplitudes that
    are drawn anew each time hold two thirds of it in the mean."""
    ratios = []
    for which in (0, 2, 4, 5, 7, 8, 10, 11):
        waves = _aligned(30, which)
        ratios.append(float(np.mean(subject.synthesize(waves, *_axes(GRID)) ** 2)) / waves.variance)
    mean = float(np.mean(ratios))
    return Outcome(
        abs(mean - 1) / 0.05,
        f"in the mean of {len(ratios)} surfaces the energy is {mean:.4g} of that "
        f"asked for ({vector(np.array(ratios))})",
        figures={"ratios": ratios},
    )


@check("synthesis", "sec:spectrum", SINGLE, [Case("halves")], stage="synthesize")
def check_linearity(subject: Subject, case: Case) -> Outcome:
    """The surface of all waves is the sum of the surfaces of some and of the others: a surface that is normalised, or
    clipped, is not."""
    waves, axes = _aligned(24, 3), _axes(GRID)
    parts = [Components(*(getattr(waves, name)[part] for name in NAMES)) for part in (slice(0, 9), slice(9, None))]
    whole = subject.synthesize(waves, *axes)
    off = np.abs(whole - sum(subject.synthesize(part, *axes) for part in parts)).max()
    scale = float(waves.amplitude.sum())
    return Outcome(
        float(off) / (PRECISION * scale),
        f"the sum of two surfaces is {off / scale:.2g} of the amplitudes off the surface of all waves",
    )
