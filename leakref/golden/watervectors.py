"""The golden vectors of `v2`: water with a bottom or a surface tension, and more cubes from samples to velocities.

To add one: append a `Vector` to the tables below and run `leakref golden regenerate ID`. Inputs `depth` and
`surface_tension` are of the water, in the units of `gravity`; without them it is deep and has none. No output is
written here. The surfaces of `extract` are kept as raw float64, one file a cube; vectors of one cube share it.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from leakref.currents import LinearCurrent
from leakref.dispersion import DEEP, Water
from leakref.golden.vectors import (
    EASY,
    HARD,
    MODERATE,
    OBLONG,
    PRIME,
    SHORT,
    SQUARE,
    TALL,
    Vector,
    aligned,
    on_grid,
    placed,
    swell,
)
from leakref.grid import Grid
from leakref.sea import Components
from leakref.synthesis import synthesize

__all__ = ["VECTORS"]

DEPTHS = (0.7, 1.2, 2.0)
"""k0 h of the vectors over a bottom."""
TENSION = 7.3e-5
"""Of clean water at 20 degrees over its density, m3 / s2: it is felt by waves shorter than 0.3 m."""
TANK = Grid((20, 17, 48), (0.009, 0.008, 0.021))  # in metres and seconds: waves of 3 to 6 cm
FIELD = Grid((15, 12, 44), (3.0, 2.6, 0.35))  # the same of 10 to 25 m
WIDE = Grid((17, 16, 40), (0.9, 0.85, 0.6))  # odd, even, even
FINE = Grid((28, 14, 40), (0.5, 1.05, 0.6))  # dx is less than half of dy
UNITS, SEA, SEARCH, PROFILE = ("D26",), ("D26", "D27", "D28"), ("D2", "D6", "D18", "D29"), ("D30",)


def _named(water: Water) -> dict[str, float]:
    """What the input of an entry says of its water."""
    said = {"gravity": water.gravity, "depth": water.depth, "surface_tension": water.surface_tension}
    return {name: v for name, v in said.items() if name == "gravity" or (0 < v < np.inf)}


def swell_over(
    water: Water, count: int, smallest: float, largest: float, direction: float, spread: float,
    current: tuple[float, float] = (0.0, 0.0), shear: tuple[float, float] = (0.0, 0.0), first: int = 1,
) -> dict[str, Any]:  # fmt: skip
    """Scattered waves as in deep water, at the frequencies that they have in `water` on such a current."""
    waves = swell(count, smallest, largest, direction, spread, first=first)
    kx, ky = np.array(waves["kx"]), np.array(waves["ky"])
    k = np.hypot(kx, ky)
    u, v = LinearCurrent(current, shear).doppler_shift_velocity(k, water).T
    return {**waves, "omega": [round(float(w), 6) for w in water.frequency(k) + kx * u + ky * v]}


def on(grid: Grid, water: Water, window: str = "hann") -> dict[str, Any]:
    return {**on_grid(grid, window), **_named(water)}


def _without_window(grid: Grid, water: Water) -> dict[str, Any]:
    return {name: value for name, value in on(grid, water).items() if name != "window"}


BOTTOM = {depth: Water(1.0, depth=depth) for depth in DEPTHS}
CAPILLARY, FILM, LAKE = Water(9.81, surface_tension=TENSION), Water(9.81, 0.012, TENSION), Water(9.81, 4.2)


def _laws() -> list[Vector]:
    """Dispersion, resolutions, kernel and shifts, factors, units."""
    k = [0.4, 0.93, 1.0, 2.7, 3.5]
    short = [62.83, 100.0, 125.66, 209.44, 314.16]
    heights = {depth: [0.0, -0.1, -0.5 * depth, -0.99 * depth, -depth] for depth in DEPTHS}
    return [
        *(Vector(f"dispersion-depth-{h:g}", "dispersion", EASY,
                 f"tanh(k h) inside the root, at k0 h = {h:g}; its own share of the group velocity",
                 {"wavenumber": k, **_named(BOTTOM[h])}, (), UNITS) for h in DEPTHS),
        Vector("dispersion-shallow", "dispersion", HARD, "k h near 1e-3: digits lost in 1 - exp(-2 k h)",
               {"wavenumber": [0.8, 1.0, 1.3], "gravity": 1.0, "depth": 0.001}, (), UNITS),
        Vector("dispersion-abyss", "dispersion", HARD, "k h of 1e4: cosh and sinh overflow, and it is deep water",
               {"wavenumber": [0.8, 1.0, 1.3], "gravity": 1.0, "depth": 1e4}, (), UNITS),
        Vector("dispersion-lake", "dispersion", EASY, "metres beside rad/m: not cycles, feet or 1 / k0",
               {"wavenumber": [0.12, 0.25, 0.6], **_named(LAKE)}),
        Vector("dispersion-capillary", "dispersion", MODERATE,
               "waves of 2 to 10 cm: S k^3 and not S k^2, and the tension over density",
               {"wavenumber": short, **_named(CAPILLARY)}),
        Vector("dispersion-film", "dispersion", HARD, "tension and a bottom at 12 mm: one tanh for both terms",
               {"wavenumber": short, **_named(FILM)}),
        Vector("resolutions-depth", "resolutions", MODERATE, "the group velocity over a bottom, not the phase velocity",
               {"wavenumber": k, "wavenumber_resolution": 0.1, "frequency_resolution": 0.05, **_named(BOTTOM[1.2])},
               (), UNITS),
        Vector("resolutions-capillary", "resolutions", MODERATE, "short waves: groups faster than their crests",
               {"wavenumber": short, "wavenumber_resolution": 9.0, "frequency_resolution": 1.5, **_named(CAPILLARY)}),
        *(Vector(f"kernel-depth-{h:g}", "kernel", MODERATE,
                 f"cosh(2k(z + h)) over sinh(2kh) at k0 h = {h:g}, up to the surface and down to the bottom",
                 {"wavenumber": k, "z": heights[h], "depth": h}, (), PROFILE) for h in DEPTHS),
        Vector("kernel-abyss", "kernel", HARD, "k h of 1e3, where cosh overflows: exp(2kz)",
               {"wavenumber": k, "z": [0.0, -0.3, -2.0], "depth": 1000.0}, (), PROFILE),
        *(Vector(f"doppler-shear-depth-{h:g}", "doppler", MODERATE,
                 f"a linear profile over a bottom, k0 h = {h:g}: the depth in omega0 but not in the kernel",
                 {"wavenumber": k, "depth": h, "current": {"velocity": [0.1, -0.2], "shear": [0.05, 0.03]}},
                 (), PROFILE) for h in DEPTHS),
        Vector("doppler-exponential-depth", "doppler", MODERATE, "a decaying profile over a bottom: p is not q",
               {"wavenumber": k, "depth": 1.2, "current": {"layers": [[0.3, -0.1, 0.8]]}}, (), PROFILE),
        Vector("doppler-exponential-equal", "doppler", HARD, "a decay of 2k: 0 / 0 in the closed form",
               {"wavenumber": [0.93, 1.0, 1.0000001, 2.7], "depth": 0.7, "current": {"layers": [[0.3, -0.1, 0.5]]}},
               (), PROFILE),
        Vector("doppler-turning-depth", "doppler", HARD, "a profile whose direction turns with depth, over a bottom",
               {"wavenumber": k, "depth": 2.0, "current": {"velocity": [0.02, 0.05],
                                                           "layers": [[0.3, 0.0, 0.25], [0.0, -0.2, 1.5]]}},
               ("exchanged-axes",), PROFILE),
        *(Vector(f"depth-factor-{h:g}", "depth-factor", MODERATE,
                 f"what a bottom leaves of a sea at k0 h = {h:g} (TMA), and the group velocity in its density",
                 {"wavenumber": k, **_named(BOTTOM[h])}, ("two-thirds-energy",), SEA) for h in DEPTHS),
        Vector("depth-factor-film", "depth-factor", HARD, "with tension: the factor is of the depth alone",
               {"wavenumber": short, **_named(FILM)}, ("two-thirds-energy",), SEA),
        Vector("water-units-sea", "water-units", EASY, "k0 h and S k0^2 / g to metres: divided by k0, not multiplied",
               {"peak_wavenumber": 0.05, "gravity": 9.81, "depth": 1.2, "surface_tension": 1e-8}, (), UNITS),
        Vector("water-units-tank", "water-units", EASY, "k0 > 1, and a tension that counts",
               {"peak_wavenumber": 130.0, "gravity": 9.81, "depth": 0.7, "surface_tension": 0.12}, (), UNITS),
    ]  # fmt: skip


def _seas() -> list[Vector]:
    """Waves of a sea over a bottom, or with tension."""
    sea = {"direction": 70.0, "spread": 40.0, "peakedness": 3.3, "length": 1.0, "realization": 0, "current": {}}
    on_lattice = ("D10", "D11", "D15", "D17")
    sheared = {"velocity": [0.05, 0.0], "shear": [0.02, 0.06]}
    return [
        *(Vector(f"components-depth-{h:g}", "components", MODERATE,
                 f"a sea at k0 h = {h:g}: the depth factor, the peak at omega0(k0), and waves at their own omega0",
                 {**sea, "depth": h, "realization": n}, ("two-thirds-energy",), (*on_lattice, *SEA))
          for n, h in enumerate(DEPTHS)),
        Vector("components-depth-sheared", "components", HARD, "over a bottom each wave is shifted by its own integral",
               {**sea, "spread": 30.0, "depth": 0.7, "realization": 2, "current": sheared}, (),
               (*on_lattice, *SEA, *PROFILE)),
        Vector("components-tension", "components", HARD, "stiff short waves: tension in omega and in energy",
               {**sea, "spread": 30.0, "surface_tension": 0.12, "realization": 1}, (), (*on_lattice, *SEA)),
    ]  # fmt: skip


def _shells() -> list[Vector]:
    """Shells, G, N and velocities of small cubes."""
    nsp, ls = (*SEARCH, "D1", "D3", "D5", "D26"), ("D1", "D3", "D7", "D8", "D19", "D26")
    seven = {**on(OBLONG, BOTTOM[0.7]), **swell_over(BOTTOM[0.7], 9, 1.1, 2.1, 65.0, 80.0, (0.12, -0.07))}
    twelve = {**on(SHORT, BOTTOM[1.2], "box"), **swell_over(BOTTOM[1.2], 7, 1.0, 2.0, -20.0, 110.0, (-0.1, 0.15))}
    twenty = {**on(TALL, BOTTOM[2.0]), **swell_over(BOTTOM[2.0], 10, 0.9, 1.9, 150.0, 90.0, (0.1, 0.14))}
    sheared = {
        **on(OBLONG, BOTTOM[1.2]),
        **swell_over(BOTTOM[1.2], 10, 1.0, 2.2, 20.0, 100.0, (0.15, -0.05), (0.1, 0.08)),
    }
    lake = {**on(FIELD, LAKE), **swell_over(LAKE, 8, 0.3, 0.6, 115.0, 80.0, (0.4, -0.3))}
    tank = {**on(TANK, CAPILLARY), **swell_over(CAPILLARY, 9, 105.0, 210.0, 40.0, 90.0, (0.03, 0.02))}
    film = {**on(TANK, FILM), **swell_over(FILM, 9, 105.0, 210.0, -60.0, 90.0, (-0.02, 0.03), first=3)}
    two = {**on(SQUARE, BOTTOM[1.2], "box"), **aligned(SQUARE, (3, 1, 5), (1, -3, 5), water=BOTTOM[1.2])}
    half = {**on(SQUARE, BOTTOM[0.7]), **placed(SQUARE, (2.5, 1.5, 4.5), (-0.5, 3.5, 4.5), (3.5, -1.5, 4.5))}
    around = [[0.0, 0.0], [0.12, -0.07], [-0.12, 0.07], [0.3, 0.2], [-0.25, 0.4], [0.05, -0.6]]
    slow = [[0.0, 0.0], [0.03, 0.02], [-0.03, -0.02], [0.08, -0.05]]
    signs = ("negated-current", "flipped-x", "flipped-y", "exchanged-axes")
    return [
        Vector("shell-depth", "shell", EASY, "omega0 of each bin over a bottom, at its own k",
               {**_without_window(OBLONG, BOTTOM[1.2]), "wavenumber": 1.5}, (), ("D3", "D20")),
        Vector("shell-film", "shell", MODERATE, "the same with tension, in metres",
               {**_without_window(TANK, FILM), "wavenumber": 140.0}, (), ("D3", "D20")),
        Vector("characteristic-depth", "characteristic", MODERATE, "both branches at the frequencies of this water",
               {**_without_window(SHORT, BOTTOM[0.7]), "wavenumber": 1.5, "velocity": [0.21, -0.13]},
               ("negated-current", "exchanged-axes", "extra-branch", "hard-coded-width"), ("D2",)),
        Vector("characteristic-capillary", "characteristic", MODERATE, "the same for waves of some centimetres",
               {**_without_window(TANK, CAPILLARY), "wavenumber": 140.0, "velocity": [0.04, -0.03]},
               ("hard-coded-width",), ("D2",)),
        Vector("score-depth", "score", EASY, "N over a bottom at six velocities: the largest is at the current",
               {**seven, "wavenumber": 1.5, "velocities": around}, ("negated-current", "extra-branch"), nsp),
        Vector("score-depth-box", "score", MODERATE, "the same untapered at another depth",
               {**twelve, "wavenumber": 1.4, "velocities": around}, ("no-taper",), nsp),
        Vector("score-capillary", "score", MODERATE, "N of waves of some centimetres, in metres per second",
               {**tank, "wavenumber": 150.0, "velocities": slow}, ("hard-coded-width",), nsp),
        Vector("derivatives-depth", "derivatives", MODERATE, "slope and curvature of N over a bottom",
               {**twenty, "wavenumber": 1.4, "velocity": [0.08, 0.11]}, (), nsp),
        Vector("nsp-depth-on-bin", "nsp", EASY, "two waves on bins over a bottom, box: their common current exactly",
               {**two, "wavenumbers": [1.38]}, (*signs, "hard-coded-width"), nsp),
        Vector("nsp-depth-0.7", "nsp", MODERATE, "shallow: whoever takes the water for deep is far off",
               {**seven, "wavenumbers": [1.3, 1.5, 1.9]}, signs, nsp),
        Vector("nsp-depth-1.2", "nsp", MODERATE, "the same untapered, at another depth",
               {**twelve, "wavenumbers": [1.2, 1.45]}, ("no-taper", "negated-current"), nsp),
        Vector("nsp-depth-2", "nsp", MODERATE, "nearly deep: a bottom that still counts",
               {**twenty, "wavenumbers": [1.2, 1.5]}, signs, nsp),
        Vector("nsp-depth-half-bin", "nsp", MODERATE, "three waves half-way between bins, Hann",
               {**half, "wavenumbers": [1.4]}, ("no-taper",), nsp),
        Vector("nsp-depth-sheared", "nsp", HARD, "a sheared current over a bottom: each k has its own",
               {**sheared, "wavenumbers": [1.2, 1.5, 1.8]}, (), (*nsp, *PROFILE)),
        Vector("nsp-lake", "nsp", MODERATE, "metres and seconds, 4.2 m deep", {**lake, "wavenumbers": [0.4, 0.5]},
               ("hard-coded-width",), (*nsp, "D21")),
        Vector("nsp-capillary", "nsp", MODERATE, "waves of 3 to 6 cm, with tension",
               {**tank, "wavenumbers": [130.0, 170.0]}, ("hard-coded-width",), (*nsp, "D21")),
        Vector("nsp-film", "nsp", HARD, "waves of 3 to 6 cm on 12 mm of water, with tension",
               {**film, "wavenumbers": [130.0, 170.0]}, ("hard-coded-width",), (*nsp, "D21")),
        Vector("ls-depth-on-bin", "ls", EASY, "two waves on bins over a bottom, box: their common current exactly",
               {**two, "wavenumbers": [1.38]}, (*signs, "solve-sign-slip"), ls),
        Vector("ls-depth-0.7", "ls", MODERATE, "shallow: omega0 of this water is subtracted from each frequency",
               {**seven, "wavenumbers": [1.3, 1.5, 1.9]}, (*signs, "solve-sign-slip"), ls),
        Vector("ls-depth-1.2", "ls", MODERATE, "the same untapered, at another depth",
               {**twelve, "wavenumbers": [1.2, 1.45]}, ("no-taper", "solve-sign-slip"), ls),
        Vector("ls-depth-2", "ls", MODERATE, "nearly deep: a bottom that still counts",
               {**twenty, "wavenumbers": [1.2, 1.5]}, signs, ls),
        Vector("ls-lake", "ls", MODERATE, "metres and seconds, 4.2 m deep", {**lake, "wavenumbers": [0.4, 0.5]}, (),
               ls),
        Vector("ls-capillary", "ls", MODERATE, "waves of 3 to 6 cm, with tension",
               {**tank, "wavenumbers": [130.0, 170.0]}, (), ls),
        Vector("ls-film", "ls", HARD, "waves of 3 to 6 cm on 12 mm of water, with tension",
               {**film, "wavenumbers": [130.0, 170.0]}, (), ls),
    ]  # fmt: skip


def _cube(name: str, grid: Grid, water: Water, waves: dict[str, Any], *rows: tuple[Any, ...]) -> list[Vector]:
    """Vectors of one cube: for each row an id, window, method, wavenumbers, difficulty, purpose, faults."""
    given = {"shape": list(grid.shape), "spacing": list(grid.spacing), **_named(water), **waves}
    components = Components(*(np.array(waves[n]) for n in ("kx", "ky", "omega", "amplitude", "phase")))
    given["surface"] = synthesize(components, *(grid.samples(axis) for axis in range(3)))
    own = () if water == DEEP else ("D26", "D29")
    decisions = ("D1", "D2", "D3", "D4", "D5", "D6", "D7", "D8", "D18", "D19", "D20", "D21", *own)
    return [Vector(f"extract-{name}-{window}-{method}", "extract", difficulty, purpose,
                   {**given, "window": window, "method": method, "wavenumbers": wavenumbers}, faults,
                   (*decisions, "D14") if window == "kaiser-bessel" else decisions, ("surface",),
                   raw=f"extract-{name}")
            for window, method, wavenumbers, difficulty, purpose, faults in rows]  # fmt: skip


def _cubes() -> list[Vector]:
    """From samples to velocities in one call."""
    wide, fine, tall, back = [1.2, 1.5], [1.3, 1.6], [1.1, 1.4], [1.5, 1.7]
    signs = ("negated-current", "flipped-x", "flipped-y", "exchanged-axes")
    windows = (
        ("box", "no taper: a code that always tapers, or removes a mean, gives another number", ("no-taper",)),
        ("hann", "periodic Hann along all three axes, and not along two", ("no-taper",)),
        ("blackman", "Blackman, 0.42, 0.5, 0.08: another window under its name", ("no-taper",)),
        ("kaiser-bessel", "Kaiser-Bessel with b = pi sqrt 3: another b, or b pi", ("no-taper",)),
    )
    return [
        *_cube("wide", WIDE, DEEP, swell_over(DEEP, 11, 0.9, 1.9, -125.0, 80.0, (-0.11, 0.09), first=2),
               *((window, method, wide, EASY if window == "hann" else MODERATE,
                  f"{purpose}; by {'the normalized scalar product' if method == 'nsp' else 'least squares'}",
                  (*faults, *signs, *(("solve-sign-slip",) if method == "ls" else ())))
                 for window, purpose, faults in windows for method in ("nsp", "ls"))),
        *_cube("fine", FINE, DEEP, swell_over(DEEP, 10, 1.0, 2.1, 35.0, 70.0, (0.06, -0.16), first=5),
               ("hann", "nsp", fine, MODERATE, "dx less than half of dy, more samples along x: axes exchanged in the "
                "cube, in the spacing, or in the answer", signs),
               ("blackman", "ls", fine, MODERATE, "the same by least squares", (*signs, "solve-sign-slip"))),
        *_cube("backwards", SHORT, DEEP, swell_over(DEEP, 8, 1.3, 2.2, 80.0, 120.0, (-0.1, -0.85)),
               ("hann", "nsp", back, HARD, "waves swept backwards by the current: the branch at negative frequencies",
                ("missing-negative-branch", "negated-current"))),
        *_cube("prime", PRIME, Water(9.81), swell_over(Water(9.81), 6, 0.7, 1.5, 115.0, 60.0, (0.3, 0.2)),
               ("hann", "nsp", [1.1], MODERATE, "gravity 9.81, prime sizes: a width or a range fixed in rad/s",
                ("hard-coded-width",)),
               ("box", "ls", [1.1], MODERATE, "the same untapered by least squares", ("solve-sign-slip",))),
        *_cube("depth-0.7", WIDE, BOTTOM[0.7], swell_over(BOTTOM[0.7], 11, 0.9, 1.9, 60.0, 80.0, (0.1, 0.08), first=4),
               ("hann", "nsp", wide, MODERATE, "k0 h = 0.7: deep water taken, or a tanh outside the root", signs),
               ("box", "nsp", wide, MODERATE, "the same untapered", ("no-taper",)),
               ("hann", "ls", wide, MODERATE, "the same by least squares", (*signs, "solve-sign-slip"))),
        *_cube("depth-1.2", TALL, BOTTOM[1.2],
               swell_over(BOTTOM[1.2], 12, 0.9, 1.9, 150.0, 75.0, (0.1, 0.14), (0.06, -0.08)),
               ("hann", "nsp", tall, MODERATE, "k0 h = 1.2, a sheared current: each k has its own velocity", signs),
               ("kaiser-bessel", "ls", tall, MODERATE, "the same by least squares", (*signs, "solve-sign-slip"))),
        *_cube("depth-2", OBLONG, BOTTOM[2.0], swell_over(BOTTOM[2.0], 9, 1.1, 2.1, 65.0, 80.0, (0.12, -0.07), first=6),
               ("blackman", "nsp", wide, MODERATE, "k0 h = 2, nearly deep: a depth that is ignored without being told",
                signs),
               ("box", "ls", wide, MODERATE, "the same untapered by least squares", (*signs, "solve-sign-slip"))),
        *_cube("lake", FIELD, LAKE, swell_over(LAKE, 8, 0.3, 0.6, 115.0, 80.0, (0.4, -0.3)),
               ("hann", "nsp", [0.4, 0.5], MODERATE, "4.2 m deep: depth in feet, negative, or times k in cycles",
                ("hard-coded-width",)),
               ("hann", "ls", [0.4, 0.5], MODERATE, "the same by least squares", ("solve-sign-slip",))),
        *_cube("tank", TANK, CAPILLARY, swell_over(CAPILLARY, 9, 105.0, 210.0, 40.0, 90.0, (0.03, 0.02)),
               ("hann", "nsp", [130.0, 170.0], MODERATE, "waves of 3 to 6 cm: tension left out, or without the density",
                ("hard-coded-width",)),
               ("hann", "ls", [130.0, 170.0], MODERATE, "the same by least squares", ())),
        *_cube("film", TANK, FILM, swell_over(FILM, 9, 105.0, 210.0, -60.0, 90.0, (-0.02, 0.03), first=3),
               ("hann", "nsp", [130.0, 170.0], HARD, "tension and a bottom: k^2 for k^3, or one term's tanh",
                ("hard-coded-width",))),
    ]  # fmt: skip


VECTORS: dict[str, tuple[Vector, ...]] = {
    "vectors": (*_laws(), *_seas(), *_shells(), *_cubes()),
    "analytic": (),
}
"""By part of the set."""
