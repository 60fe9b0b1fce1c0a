"""What golden vectors there are: for each its inputs and the class of mistake it exists for.

These are those of `v1`, which are as they are; to add one see `defined`. An id is never reused: a correction is a new
id with `supersedes` set to the old one. Inputs are short decimals or follow from the grid; no output is written here.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from leakref.dispersion import DEEP, Water
from leakref.grid import Grid
from leakref.sea import Components, aligned_waves
from leakref.synthesis import synthesize
from leakref.window import WINDOWS

__all__ = ["VECTORS", "Vector"]

EASY, MODERATE, HARD = "easy", "moderate", "hard"


@dataclass(frozen=True)
class Vector:
    """`input` as written to JSON, but those named in `archived` beside it: in an npz, or in a file of float64 named
    `raw`, which vectors may share. `faults` are ids of faults."""

    id: str
    stage: str
    difficulty: str
    purpose: str
    input: dict[str, Any]
    faults: tuple[str, ...] = ()
    decisions: tuple[str, ...] = ()
    archived: tuple[str, ...] = ()
    supersedes: str | None = None
    raw: str = ""


OBLONG = Grid((20, 17, 48), (0.9, 0.8, 0.6))  # even, odd, even; dx != dy
TALL = Grid((13, 16, 45), (1.0, 0.85, 0.6))  # odd, even, odd
PRIME = Grid((11, 13, 53), (1.2, 0.9, 0.2))  # with gravity 9.81
SQUARE = Grid((16, 16, 48), (0.9, 0.9, 0.6))
SHORT = Grid((14, 12, 48), (1.0, 1.1, 0.45))  # wide frequency bins: strong currents stay within the width
BRIEF = Grid((14, 12, 10), (1.0, 1.1, 0.9))
TINY = Grid((7, 6, 5), (1.1, 0.7, 0.9))
COUNTER = Grid((6, 5, 8), (0.8, 1.3, 0.6))


def _fraction(n: int, which: int) -> float:
    """The n-th of an evenly scattered sequence in [0, 1): multiples of roots of primes, modulo 1."""
    return float(n * np.sqrt((2, 3, 5, 7, 11)[which]) % 1)


def _short(values: Any) -> list[float]:
    return [round(float(v), 6) for v in values]


def swell(count: int, smallest: float, largest: float, direction: float, spread: float,
          current: tuple[float, float] = (0.0, 0.0), gravity: float = 1.0, first: int = 1) -> dict[str, Any]:
    """`count` scattered waves between two wavenumbers and within `spread` degrees of `direction`, on a current."""
    n = range(first, first + count)
    k = np.array([smallest + (largest - smallest) * _fraction(i, 0) for i in n])
    angle = np.radians([direction + spread * (_fraction(i, 1) - 0.5) for i in n])
    kx, ky = k * np.cos(angle), k * np.sin(angle)
    omega = Water(gravity).frequency(k) + kx * current[0] + ky * current[1]
    return {"kx": _short(kx), "ky": _short(ky), "omega": _short(omega),
            "amplitude": _short([0.3 + _fraction(i, 2) for i in n]),
            "phase": _short([2 * np.pi * _fraction(i, 3) for i in n])}


def on_grid(grid: Grid, window: str = "hann", gravity: float = 1.0) -> dict[str, Any]:
    return {"shape": list(grid.shape), "spacing": list(grid.spacing), "window": window, "gravity": gravity}


def aligned(grid: Grid, *bins: tuple[int, int, int], **how: Any) -> dict[str, Any]:
    """One or two waves exactly on bins."""
    waves, _ = aligned_waves(grid, bins, **(how if "water" in how else {"gravity": 1.0, **how}))
    return {name: getattr(waves, name).tolist() for name in ("kx", "ky", "omega", "amplitude", "phase")}


def placed(grid: Grid, *bins: tuple[float, float, float], amplitude: tuple[float, ...] = (1.0, 0.6, 0.35)) -> dict[str,
Any]:
    """Waves at any positions in bins, whole or not."""
    k = [[float(u * width) for u, width in zip(wave, grid.bin_widths, strict=True)] for wave in bins]
    kx, ky, omega = ([wave[axis] for wave in k] for axis in range(3))
    return {"kx": kx, "ky": ky, "omega": omega, "amplitude": list(amplitude[: len(bins)]),
            "phase": _short([0.4 + 1.7 * n for n in range(len(bins))])}


def bumps(grid: Grid) -> list[Any]:
    """A surface without any symmetry, not made of waves."""
    nx, ny, nt = grid.shape
    return [[[round(_fraction(1 + a + 7 * b + 31 * c, 4) - 0.3 + 0.1 * a - 0.2 * b * c, 6) for c in range(nt)]
             for b in range(ny)] for a in range(nx)]


def _small() -> list[Vector]:
    """Grids, dispersion, currents, the sea."""
    k = [0.4, 0.93, 1.0, 2.7, 3.5]
    sea = {"direction": 70.0, "spread": 40.0, "peakedness": 3.3, "length": 1.0, "realization": 0, "current": {}}
    w = [0.45, 0.7, 0.9, 0.97, 1.0, 1.02, 1.1, 1.4, 1.9]
    return [
        Vector("grid-paper", "scaled-grid", EASY, "sampling of sec:parameters: 28 samples a wavelength, 14 a period",
               {"length": 10.0, "duration": 20.0}, decisions=("D9",)),
        Vector("grid-small", "scaled-grid", EASY, "the smallest domain, where the list of shells starts at 2 dk",
               {"length": 5.0, "duration": 10.0}, decisions=("D9",)),
        Vector("grid-rounded", "scaled-grid", MODERATE,
               "a domain that is no whole number of samples: spacing gives way, "
               "not length", {"length": 7.33, "duration": 11.07}, decisions=("D9",)),
        Vector("grid-first-shell", "scaled-grid", HARD, "5 dk is 0.397, just below 0.4: not a shell",
               {"length": 12.6, "duration": 10.1}, decisions=("D9",)),
        Vector("grid-last-shell", "scaled-grid", HARD, "50 dk is 3.521, just beyond 3.5: not a shell",
               {"length": 14.2, "duration": 12.3}, decisions=("D9",)),
        Vector("bins-oblong", "bins", EASY, "axes of even and odd size, dkx != dky; n d and not (n - 1) d",
               {"shape": [20, 17, 22], "spacing": [0.9, 0.8, 0.7]}, ("exchanged-axes",), ("D20",)),
        Vector("bins-odd-time", "bins", MODERATE, "an odd number of frames has no Nyquist plane; dky is the coarser",
               {"shape": [13, 8, 15], "spacing": [1.0, 0.5, 0.8]}, ("exchanged-axes",), ("D20",)),
        Vector("dispersion-scaled", "dispersion", EASY, "the square root of the dispersion relation",
               {"wavenumber": k, "gravity": 1.0}),
        Vector("dispersion-si", "dispersion", EASY, "gravity forgotten, or its root",
               {"wavenumber": [0.02, 0.11, 0.7], "gravity": 9.81}),
        Vector("resolutions-scaled", "resolutions", EASY,
               "domega / k against cg dk / k: factor 1/2 of the group velocity",
               {"wavenumber": k, "wavenumber_resolution": 0.1, "frequency_resolution": 0.05, "gravity": 1.0}),
        Vector("resolutions-si", "resolutions", MODERATE, "gravity in the group velocity",
               {"wavenumber": [0.05, 0.2], "wavenumber_resolution": 0.013, "frequency_resolution": 0.11,
                "gravity": 9.81}),
        Vector("doppler-uniform", "doppler", EASY, "a uniform current shifts all waves alike",
               {"wavenumber": k, "current": {"velocity": [0.1, -0.2]}}),
        Vector("doppler-shear", "doppler", MODERATE, "the 2k of eq:SJ: U at depth 1 / 2k for a linear profile",
               {"wavenumber": k, "current": {"velocity": [0.1, -0.2], "shear": [0.05, 0.03]}}, ("hard-coded-width",)),
        Vector("doppler-exponential", "doppler", MODERATE, "eq:SJ for a profile that decays with depth",
               {"wavenumber": k, "current": {"layers": [[0.3, -0.1, 0.8]]}}),
        Vector("doppler-turning", "doppler", HARD, "a profile whose direction turns with depth, so that c turns with k",
               {"wavenumber": k, "current": {"velocity": [0.02, 0.05], "layers": [[0.3, 0.0, 0.25], [0.0, -0.2, 1.5]]}},
               ("exchanged-axes",)),
        Vector("scales-sea", "scales", EASY, "from scaled units to metres and seconds",
               {"peak_wavenumber": 0.05, "gravity": 9.81}),
        Vector("scales-tank", "scales", EASY, "k0 > 1: lengths divided by it and not multiplied",
               {"peak_wavenumber": 7.5, "gravity": 9.81}),
        Vector("jonswap-33", "jonswap", EASY, "0.07 and 0.09 on the two sides of the peak, exponents -5, -4, 5/4",
               {"frequency": w, "peakedness": 3.3}),
        Vector("jonswap-1", "jonswap", EASY, "Pierson-Moskowitz: no peak enhancement, only exponents",
               {"frequency": w, "peakedness": 1.0}),
        Vector("jonswap-7", "jonswap", MODERATE, "a sharp peak: gamma to the power of a Gaussian, with its 1/2",
               {"frequency": w, "peakedness": 7.0}),
        Vector("spreading-60", "spreading", EASY, "full width, not half width: zero from 30 degrees off",
               {"direction": [40.0, 44.8, 45.2, 58.0, 75.0, 88.0, 103.0, 104.8, 105.2, -80.0], "mean": 75.0,
               "spread": 60.0}),
        Vector("spreading-15", "spreading", MODERATE, "the narrowest sea of the paper",
               {"direction": [67.0, 68.0, 71.0, 75.0, 81.0, 83.0], "mean": 75.0, "spread": 15.0}),
        Vector("spreading-wrapped", "spreading", HARD, "a mean direction where angles jump from 180 to -180 degrees",
               {"direction": [-179.0, -160.0, 165.0, 179.5, 0.0, 150.0], "mean": 175.0, "spread": 70.0}),
        Vector("phases-0", "phases", EASY, "counter-based phases: word, bits, order of (i, j)",
               {"realization": 0, "i": [0, 0, 1, -1, 5, -12, 40], "j": [1, -1, 0, 3, -7, 11, 2]}, decisions=("D11",)),
        Vector("phases-12345", "phases", MODERATE, "the realisation is the key, not an offset of the counter",
               {"realization": 12345, "i": [3, -3, 3, -3], "j": [2, 2, -2, -2]}, decisions=("D11",)),
        Vector("components-still", "components", EASY, "lattice 0.341 / L, cut at 3.5, energy k^-3/2 S f dk^2",
               sea, ("two-thirds-energy", "exchanged-axes"), ("D10", "D11", "D15")),
        Vector("components-narrow", "components", MODERATE, "a narrow sea with a sharp peak near the y axis",
               {**sea, "direction": 97.0, "spread": 17.0, "peakedness": 7.0, "length": 1.6, "realization": 3},
               ("two-thirds-energy",), ("D10", "D11", "D15")),
        Vector("components-opposing", "components", HARD,
               "a current so strong that omega0 + k.U < 0; S still at omega0",
               {**sea, "realization": 1, "current": {"velocity": [-0.1, -0.9]}},
               ("negated-current", "missing-negative-branch"), ("D10", "D11", "D15", "D17")),
        Vector("components-sheared", "components", HARD, "each wave shifted by its own eq:SJ",
               {**sea, "spread": 30.0, "realization": 2, "current": {"velocity": [0.05, 0.0], "shear": [0.02, 0.06]}},
               decisions=("D10", "D11", "D15", "D17")),
        Vector("components-rotated", "components", HARD,
               "sea and current turned anticlockwise about the centre: phases "
               "move too", {**sea, "spread": 30.0, "rotation": 30.0, "centre": [3.1, 2.4],
                            "current": {"velocity": [0.1, 0.0]}}, ("flipped-y", "exchanged-axes"), ("D13", "D23")),
    ]


def _surfaces() -> list[Vector]:
    """Synthesis, windows, spectra."""
    axes = {"x": [0.0, 0.9, 1.8], "y": [0.0, 0.8, 1.6, 2.4], "t": [0.0, 0.7]}
    on_bin = aligned(COUNTER, (1, -2, 3), (2, 1, 1))
    return [
        Vector("surface-one-wave", "surface", EASY, "cos(k.x - omega t + phase): each sign, and [x, y, t]",
               {**axes, "kx": [0.8], "ky": [-0.5], "omega": [0.97], "amplitude": [1.3], "phase": [0.4]},
               ("flipped-x", "flipped-y", "negated-current", "exchanged-axes")),
        Vector("surface-scattered", "surface", MODERATE, "waves on no lattice, seven of them",
               {**axes, **swell(7, 0.6, 2.4, 50.0, 90.0, (0.1, -0.05))}, ("flipped-y", "exchanged-axes")),
        Vector("surface-lattice", "surface", MODERATE, "waves on a lattice with one missing, by matrix products",
               {**axes, "kx": [0.5, 0.5, 1.0], "ky": [-0.4, 0.8, 0.8], "omega": [0.8, 0.97, 1.13],
                "amplitude": [1.0, 0.5, 0.25], "phase": [0.1, 2.2, 4.3]}, ("exchanged-axes",)),
        Vector("surface-backwards", "surface", HARD, "negative frequency: a wave swept backwards by the current",
               {**axes, **swell(4, 2.0, 3.2, 80.0, 30.0, (-0.1, -0.9))}, ("missing-negative-branch",)),
        *(Vector(f"window-{name}-{size}", "window", EASY if name in ("box", "hann") else MODERATE,
                 f"periodic sampling n / {size}, {'even' if size % 2 == 0 else 'odd'} size: not n / (size - 1)",
                 {"window": name, "size": size}, ("no-taper",), ("D1", *(("D14",) if name == "kaiser-bessel" else ())))
          for name in WINDOWS for size in (7, 12)),
        Vector("response-on-bin", "response", EASY, "a wave exactly on a bin: 0 / 0 in the closed form",
               {"window": "box", "bins": [-3, -1, 0, 1, 2, 4], "positions": [0.0, 2.0, -3.0], "size": 9}),
        Vector("response-half-bin", "response", EASY, "half-way between bins, box: the largest leakage",
               {"window": "box", "bins": [-2, 0, 1, 3], "positions": [0.5, -1.5, 2.5], "size": 8}, ("no-taper",)),
        Vector("response-near-bin", "response", HARD, "1e-3 and 1e-9 of a bin off: formed carelessly it errs by 1e-6",
               {"window": "box", "bins": [17, 36, 37, 38, 60], "positions": [37.001, 37.000000001, 36.999999999],
                "size": 128}),
        Vector("response-hann", "response", MODERATE, "Hann: three bins where the wave is on one, fast decay elsewhere",
               {"window": "hann", "bins": [-2, -1, 0, 1, 2, 3], "positions": [1.0, 0.5, -1.3], "size": 11},
               ("no-taper",), ("D1",)),
        Vector("response-blackman", "response", MODERATE, "Blackman: a stencil of five bins",
               {"window": "blackman", "bins": [-3, -1, 0, 1, 2, 4], "positions": [1.0, 0.5, -1.3], "size": 14},
               ("no-taper",), ("D1",)),
        Vector("response-kaiser", "response", MODERATE, "Kaiser-Bessel: not a sum of cosines",
               {"window": "kaiser-bessel", "bins": [-2, 0, 1, 3], "positions": [1.0, 0.5, -1.3], "size": 10},
               ("no-taper",), ("D1", "D14")),
        Vector("response-wrapped", "response", HARD, "beyond the Nyquist bin: aliased, with the phase of the far bin",
               {"window": "hann", "bins": [-4, -3, 3, 4], "positions": [4.2, 9.7, -4.5], "size": 9}),
        Vector("transform-box", "transform", EASY,
               "sign and order of the spectrum of an arbitrary surface, even and odd",
               {"surface": bumps(TINY), "spacing": list(TINY.spacing), "shape": list(TINY.shape), "window": "box"},
               ("negated-current", "exchanged-axes", "flipped-x", "flipped-y")),
        Vector("transform-hann", "transform", MODERATE, "taper along all three axes, each of its own size",
               {"surface": bumps(COUNTER), "spacing": list(COUNTER.spacing), "shape": list(COUNTER.shape),
                "window": "hann"}, ("no-taper", "negated-current"), ("D1",)),
        Vector("spectrum-on-bin", "spectrum", EASY, "two waves on bins, box: all other bins are zero",
               {**on_grid(COUNTER, "box"), **on_bin}, ("negated-current", "flipped-x", "flipped-y", "exchanged-axes")),
        Vector("spectrum-on-bin-hann", "spectrum", EASY, "the same under Hann: 27 bins a wave",
               {**on_grid(COUNTER, "hann"), **on_bin}, ("no-taper",), ("D1",)),
        Vector("spectrum-half-bin", "spectrum", MODERATE, "half-way between bins along every axis, box",
               {**on_grid(TINY, "box"), **placed(TINY, (1.5, -0.5, 1.5))}, ("no-taper",)),
        Vector("spectrum-near-nyquist", "spectrum", HARD, "near Nyquist along x and t: aliases meet the wave",
               {**on_grid(COUNTER, "hann"), **placed(COUNTER, (2.9, 0.3, 3.8), (-2.6, 1.4, 0.2))}, (), ("D1", "D4")),
        Vector("spectrum-backwards", "spectrum", HARD, "omega0 + k.U < 0: the wave is at negative omega",
               {**on_grid(TINY, "hann"), **swell(3, 1.6, 2.6, 75.0, 25.0, (-0.1, -0.9))},
               ("missing-negative-branch", "negated-current"), ("D1",)),
        Vector("spectrum-scattered", "spectrum", MODERATE, "five waves anywhere, Blackman",
               {**on_grid(TINY, "blackman"), **swell(5, 0.5, 2.2, 30.0, 120.0)}, ("no-taper",), ("D1",)),
        Vector("spectrum-kaiser", "spectrum", MODERATE, "Kaiser-Bessel, whose closed form is summed numerically",
               {**on_grid(COUNTER, "kaiser-bessel"), **swell(3, 0.5, 2.0, 140.0, 60.0, (0.2, 0.1))}, ("no-taper",),
               ("D1", "D14")),
    ]


def _bin_off(grid: Grid, i: int, j: int, widths: float) -> float:
    """A wavenumber that bin (i, j) is `widths` dk away from."""
    dkx, dky, _ = grid.bin_widths
    return float(np.hypot(i * dkx, j * dky) - widths * grid.wavenumber_resolution)


def _shells() -> list[Vector]:
    """Shells, the score, velocities."""
    bare = {name: {k: v for k, v in on_grid(grid).items() if k != "window"}
            for name, grid in (("oblong", OBLONG), ("prime", PRIME), ("square", SQUARE), ("brief", BRIEF))}
    oblong = {**on_grid(OBLONG), **swell(9, 1.1, 2.1, 65.0, 80.0, (0.12, -0.07))}
    untapered = {**on_grid(SHORT, "box"), **swell(7, 1.0, 2.0, -20.0, 110.0, (-0.1, 0.15))}
    backwards = {**on_grid(SHORT), **swell(8, 1.3, 2.2, 80.0, 120.0, (-0.1, -0.85))}
    around = [[0.0, 0.0], [0.12, -0.07], [-0.12, 0.07], [0.3, 0.2], [-0.25, 0.4], [0.05, -0.6]]
    return [
        Vector("shell-edge", "shell", MODERATE, "bins exactly on the edge are inside: k_i = 4 dk of a square domain",
               {**bare["square"], "wavenumber": 4 * SQUARE.bin_widths[0]}, (), ("D3", "D9")),
        Vector("shell-oblong", "shell", EASY, "dkx != dky: dk is the larger, and x is not y",
               {**bare["oblong"], "wavenumber": 1.5}, ("exchanged-axes",), ("D3", "D20")),
        Vector("shell-prime", "shell", MODERATE, "prime sizes: no bin at -Nyquist, no plane at Nyquist",
               {**bare["prime"], "wavenumber": 1.1}, (), ("D3", "D5", "D20")),
        Vector("shell-just-outside", "shell", HARD, "a bin 2.01 dk off is outside",
               {**bare["oblong"], "wavenumber": _bin_off(OBLONG, 5, 4, 2.01)}, (), ("D3", "D20")),
        Vector("shell-just-inside", "shell", HARD, "a bin 1.99 dk off is inside",
               {**bare["oblong"], "wavenumber": _bin_off(OBLONG, 5, -4, 1.99)}, (), ("D3", "D20")),
        Vector("shell-si", "shell", MODERATE, "omega0 at each bin's own k, with gravity in it",
               {**bare["brief"], "gravity": 9.81, "wavenumber": 1.3}, (), ("D3",)),
        Vector("magnitude-hann", "magnitude", EASY, "F is the square root of P: |S|, not |S|^2",
               {**on_grid(BRIEF), **swell(5, 0.9, 1.8, 40.0, 60.0), "wavenumber": 1.3}, ("no-taper",), ("D1",)),
        Vector("magnitude-box", "magnitude", MODERATE, "what leaks into a shell that holds no wave",
               {**on_grid(BRIEF, "box"), **swell(5, 0.5, 0.7, 40.0, 60.0), "wavenumber": 1.6}, ("no-taper",)),
        Vector("magnitude-backwards", "magnitude", HARD, "F of waves swept backwards",
               {**on_grid(BRIEF), **swell(6, 1.1, 1.9, 80.0, 70.0, (-0.1, -0.85)), "wavenumber": 1.4},
               ("missing-negative-branch",)),
        Vector("characteristic-rest", "characteristic", EASY, "the factor 2 in the Gaussian's exponent, a = 4 domega",
               {**bare["brief"], "wavenumber": 1.3, "velocity": [0.0, 0.0]},
               ("hard-coded-width", "missing-negative-branch", "extra-branch"), ("D2",)),
        Vector("characteristic-moving", "characteristic", MODERATE, "the mirror branch is at k.c - omega0",
               {**bare["brief"], "wavenumber": 1.5, "velocity": [0.21, -0.13]},
               ("negated-current", "exchanged-axes", "extra-branch", "hard-coded-width"), ("D2",)),
        Vector("characteristic-strong", "characteristic", HARD, "a current that brings the mirror branch to omega > 0",
               {**bare["brief"], "wavenumber": 1.5, "velocity": [-0.1, -0.95]},
               ("missing-negative-branch", "extra-branch"), ("D2",)),
        Vector("score-hann", "score", EASY, "N at six velocities: the largest is not at the opposite one",
               {**oblong, "wavenumber": 1.5, "velocities": around}, ("negated-current", "extra-branch"),
               ("D2", "D5", "D18")),
        Vector("score-box", "score", MODERATE, "N untapered; weights of the planes omega = 0 and Nyquist",
               {**untapered, "wavenumber": 1.4, "velocities": around}, ("no-taper",), ("D2", "D5", "D18")),
        Vector("score-backwards", "score", HARD, "N with waves on the mirror branch",
               {**backwards, "wavenumber": 1.4, "velocities": [*around, [-0.1, -0.85], [0.1, 0.85]]},
               ("missing-negative-branch", "negated-current"), ("D2", "D5", "D18")),
        Vector("score-si", "score", MODERATE, "N with gravity 9.81 and odd sizes",
               {**on_grid(PRIME, gravity=9.81), **swell(6, 0.7, 1.5, 115.0, 60.0, (0.3, 0.2), 9.81), "wavenumber": 1.2,
                "velocities": [[0.0, 0.0], [0.3, 0.2], [1.0, -0.7]]}, ("hard-coded-width",), ("D2", "D5", "D18")),
        Vector("derivatives-rest", "derivatives", MODERATE, "gradient and Hessian where the search starts",
               {**oblong, "wavenumber": 1.5, "velocity": [0.0, 0.0]}, (), ("D2", "D5", "D6")),
        Vector("derivatives-moving", "derivatives", HARD, "gradient and Hessian off the optimum, untapered",
               {**untapered, "wavenumber": 1.4, "velocity": [-0.2, 0.05]}, ("exchanged-axes",), ("D2", "D5", "D6")),
        *_extractions(oblong, untapered, backwards),
        Vector("statistics-plain", "statistics", EASY, "n - 1; bias is the mean of |c| and not |mean|",
               {"velocities": [[[0.1, 0.0], [0.02, -0.3]], [[-0.2, 0.1], [0.05, 0.1]], [[0.05, -0.3], [-0.1, 0.0]],
                               [[0.0, 0.02], [0.3, 0.1]]]}, (), ("D12",)),
        Vector("statistics-missing", "statistics", HARD, "a realisation without a number is left out of every sum",
               {"velocities": [[[0.1, 0.0], [0.02, -0.3]], [[None, None], [0.05, 0.1]], [[0.05, -0.3], [-0.1, 0.0]]]},
               ("nan-as-number",), ("D12",)),
    ]


def _extractions(oblong: dict[str, Any], untapered: dict[str, Any], backwards: dict[str, Any]) -> list[Vector]:
    decisions = ("D2", "D5", "D6", "D7", "D8", "D18", "D19", "D20")
    nsp, ls = ("D2", "D5", "D6", "D18"), ("D7", "D8", "D19")
    two = aligned(SQUARE, (3, 1, 5), (-1, 3, 6))
    three = placed(SQUARE, (3, 1, 5), (-1, 3, 6), (2, -3, 6), amplitude=(1.0, float(np.sqrt(0.201)),
    float(np.sqrt(0.199))))
    si = {**on_grid(PRIME, gravity=9.81), **swell(6, 0.7, 1.5, 115.0, 60.0, (0.3, 0.2), 9.81)}
    empty = {**on_grid(SQUARE, "box"), **aligned(SQUARE, (1, 0, 3))}
    one = {**on_grid(SQUARE, "box"), **aligned(SQUARE, (3, 1, 5))}
    sheared = {**on_grid(OBLONG), **_sheared(10, 1.0, 2.2, 20.0, 100.0)}
    cube = {"shape": list(TALL.shape), "spacing": list(TALL.spacing), "gravity": 1.0,
            **swell(12, 0.9, 1.9, 150.0, 75.0, (0.1, 0.14))}
    surface = synthesize(Components(*(np.array(cube[n]) for n in ("kx", "ky", "omega", "amplitude", "phase"))),
                         *(TALL.samples(axis) for axis in range(3))).tolist()
    return [
        Vector("nsp-on-bin", "nsp", EASY, "two bin-aligned waves under box: their common current exactly",
               {**on_grid(SQUARE, "box"), **two, "wavenumbers": [1.38]},
               ("negated-current", "flipped-x", "flipped-y", "exchanged-axes", "hard-coded-width"), nsp),
        Vector("nsp-oblong", "nsp", MODERATE, "nine waves, Hann, a domain with no two sides alike: signs and axes",
               {**oblong, "wavenumbers": [1.3, 1.5, 1.9]},
               ("negated-current", "flipped-x", "flipped-y", "exchanged-axes", "hard-coded-width", "extra-branch"),
               nsp),
        Vector("nsp-untapered", "nsp", MODERATE, "the same without a taper: leakage moves the optimum",
               {**untapered, "wavenumbers": [1.2, 1.45]}, ("no-taper", "negated-current"), nsp),
        Vector("nsp-half-bin", "nsp", MODERATE, "three waves half-way between bins, Hann",
               {**on_grid(SQUARE), **placed(SQUARE, (2.5, 1.5, 5.5), (-0.5, 3.5, 5.5), (3.5, -1.5, 5.5)),
                "wavenumbers": [1.4]}, ("no-taper",), nsp),
        Vector("nsp-narrow", "nsp", HARD, "a narrow sea: the optimum is soft across it",
               {**on_grid(SHORT), **swell(8, 1.1, 1.9, 63.0, 18.0), "wavenumbers": [1.4, 1.6]}, ("exchanged-axes",),
               nsp),
        Vector("nsp-backwards", "nsp", HARD, "opposing current, omega0 + k.U < 0 for some waves",
               {**backwards, "wavenumbers": [1.5, 1.7]}, ("missing-negative-branch", "negated-current"), nsp),
        Vector("nsp-wrong-basin", "nsp", HARD,
               "a narrower sea on such a current: the search from rest ends in the basin "
               "of the mirror image, and the reference says so",
               {**on_grid(SHORT), **swell(8, 1.1, 1.9, 80.0, 70.0, (-0.1, -0.85)), "wavenumbers": [1.5]},
               ("missing-negative-branch", "extra-branch"), nsp),
        Vector("nsp-sheared", "nsp", HARD, "a sheared current: the velocity changes with wavenumber (eq:SJ)",
               {**sheared, "wavenumbers": [1.2, 1.5, 1.8]}, (), nsp),
        Vector("nsp-si", "nsp", MODERATE, "gravity 9.81, prime sizes: nothing may be fixed in rad/s",
               {**si, "wavenumbers": [1.1]}, ("hard-coded-width",), (*nsp, "D21")),
        Vector("nsp-nothing", "nsp", HARD, "a shell that holds rounding only has no number",
               {**empty, "wavenumbers": [1.9]}, ("nan-as-number",), (*nsp, "D25")),
        Vector("ls-on-bin", "ls", EASY, "two bin-aligned waves under box: their common current exactly",
               {**on_grid(SQUARE, "box"), **two, "wavenumbers": [1.38]},
               ("negated-current", "flipped-x", "flipped-y", "exchanged-axes", "solve-sign-slip"), ls),
        Vector("ls-oblong", "ls", MODERATE, "nine waves, Hann: a coupled 2x2 system, both components at once",
               {**oblong, "wavenumbers": [1.3, 1.5, 1.9]},
               ("negated-current", "flipped-x", "flipped-y", "exchanged-axes", "solve-sign-slip"), ls),
        Vector("ls-untapered", "ls", MODERATE, "untapered, where leaked bins pass the threshold",
               {**untapered, "wavenumbers": [1.2, 1.45]}, ("no-taper", "solve-sign-slip"), ls),
        Vector("ls-threshold", "ls", HARD, "powers of 1, 0.201 and 0.199: two bins are above 0.2 of the largest",
               {**on_grid(SQUARE, "box"), **three, "wavenumbers": [1.38]}, ("solve-sign-slip",), ls),
        Vector("ls-si", "ls", MODERATE, "gravity 9.81, prime sizes", {**si, "wavenumbers": [1.1]}, (), ls),
        Vector("ls-one-wave", "ls", HARD, "one wave does not fix a current: no number",
               {**one, "wavenumbers": [1.38]}, ("nan-as-number",), (*ls, "D25")),
        Vector("extract-cube-nsp", "extract", MODERATE, "from samples to velocities in one call, Hann and NSP",
               {**cube, "surface": surface, "window": "hann", "method": "nsp", "wavenumbers": [1.2, 1.5]},
               ("negated-current", "flipped-x", "flipped-y", "exchanged-axes", "no-taper", "hard-coded-width"),
               decisions,
               ("surface",)),
        Vector("extract-cube-ls", "extract", MODERATE, "the same cube untapered, by least squares",
               {**cube, "surface": surface, "window": "box", "method": "ls", "wavenumbers": [1.2, 1.5]},
               ("negated-current", "flipped-x", "flipped-y", "exchanged-axes", "solve-sign-slip"), decisions,
               ("surface",)),
    ]


def _sheared(count: int, smallest: float, largest: float, direction: float, spread: float) -> dict[str, Any]:
    """Waves on U(z) = (0.15, -0.05) + (0.1, 0.08) z, each shifted by its own eq:SJ in closed form."""
    waves = swell(count, smallest, largest, direction, spread)
    kx, ky = np.array(waves["kx"]), np.array(waves["ky"])
    k = np.hypot(kx, ky)
    return {**waves, "omega": _short(DEEP.frequency(k) + kx * (0.15 - 0.1 / (2 * k)) + ky * (-0.05 - 0.08 / (2 * k)))}


def _analytic() -> list[Vector]:
    # whole offsets, where a cosine sum is zero, are left to the first zero
    offsets = [0.0, 0.25, 0.5, 0.75, 1.25, 1.5, 1.75, 2.25, 2.5, 2.75, 3.3, 3.5, 4.5, 5.5, 6.25, 7.5, 8.5, 10.5, 12.5]
    decisions = {"kaiser-bessel": ("D14",)}
    return [vector for name in WINDOWS for vector in (
        Vector(f"lobes-{name}", "lobes", EASY, "the continuous transform of the window: main lobe and sidelobes",
               {"window": name, "offsets": offsets}, ("no-taper",), decisions.get(name, ())),
        Vector(f"figures-{name}", "figures", MODERATE, "first zero, widths, peak sidelobe, noise bandwidth, gain",
               {"window": name}, ("no-taper",), decisions.get(name, ())))]


VECTORS: dict[str, tuple[Vector, ...]] = {"vectors": (*_small(), *_surfaces(), *_shells()),
"analytic": tuple(_analytic())}
"""By part of the set."""
