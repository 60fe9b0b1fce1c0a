"""Grids, dispersion, currents, seas and surfaces.

The stages, with the labels they are held to: `scaled-grid` (sec:parameters), `bins` (app:numdetails), `dispersion`
(sec:theory), `resolutions` (eq:dcdwk), `doppler` (eq:SJ, in closed form and by quadrature), `scales` (sec:dimensions),
`jonswap` (eq:JONSWAP), `spreading` (eq:angularspread), `phases` (decision D11), `components` (eq:amplitudes) and
`surface`.

What goes in and what comes out, scaled units unless a gravity is given; wherever a gravity may stand there may be a
`depth` and a `surface_tension` as well, and without them the water is deep and has none:

- `scaled-grid`: `length`, `duration`; `shape` (3,), `spacing` (3,), `bin_widths` (3,), `wavenumbers` (n,).
- `bins`: `shape`, `spacing`; `kx` (nx,), `ky` (ny,), `omega` (nt // 2 + 1,), `nyquist` (3,), `resolution` (2,).
- `dispersion`: `wavenumber` (n,), the water; `frequency`, `phase_velocity`, `group_velocity`, (n,) each.
- `resolutions`: those, dk and domega; `from_frequency`, `from_wavenumber`, (n,) each.
- `doppler`: `wavenumber` (n,), a `current` (velocity, shear, layers) and a depth; `velocity` (n, 2).
- `scales`: `peak_wavenumber`, `gravity`; a wavenumber, a frequency, a length, a time and a velocity.
- `jonswap`, `spreading`: `frequency` or `direction` (n,) and parameters; `density` (n,).
- `phases`: `realization`, `i`, `j` (n,); `phase` (n,). `components`: a sea and its water; five arrays (n,).
- `surface`: five arrays of waves and the axes `x`, `y`, `t`; `eta` (nx, ny, nt).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from leakref._base import FloatArray
from leakref.cases import SHELLS
from leakref.chain import shell_wavenumbers
from leakref.currents import Current, ExponentialCurrent, LinearCurrent, ProfileCurrent, UniformCurrent, shift_in
from leakref.dispersion import DEEP, Scales, Water, velocity_resolutions
from leakref.golden import oracle
from leakref.golden.stages.stage import (
    WAVE,
    Input,
    Output,
    Stage,
    grid_of,
    in_water,
    largest,
    listed,
    relative,
    water_of,
    waters,
    waves_of,
)
from leakref.grid import Grid
from leakref.sea import SeaState, directional_spreading, jonswap, uniform_phases
from leakref.synthesis import synthesize

__all__ = ["STAGES"]


def _scaled_grid(given: Input) -> Output:
    grid = Grid.scaled(given["length"], given["duration"])
    return {
        "shape": grid.shape,
        "spacing": grid.spacing,
        "bin_widths": grid.bin_widths,
        "wavenumbers": shell_wavenumbers(grid, *SHELLS),
    }


def _scaled_grid_by_oracle(given: Input, _: Output) -> Output:
    """By the rules of sec:parameters alone: 28 samples a wavelength, 14 a period, shells from 0.4 to 3.5."""
    mp, mpf = oracle.mp, oracle.mpf
    sizes = [int(mp.nint(mpf(given["length"]) * 28)), int(mp.nint(mpf(given["duration"]) * 14))]
    sides = [2 * mp.pi * mpf(given[name]) for name in ("length", "duration")]
    dk, dw = (2 * mp.pi / side for side in sides)
    first, last = int(mp.ceil(mpf("0.4") / dk)), int(mp.floor(mpf("3.5") / dk))
    x, t = (side / n for side, n in zip(sides, sizes, strict=True))
    return {
        "shape": [sizes[0], sizes[0], sizes[1]],
        "spacing": [x, x, t],
        "bin_widths": [dk, dk, dw],
        "wavenumbers": [n * dk for n in range(first, last + 1)],
    }


def _bins_of(given: Input) -> Output:
    grid = grid_of(given)
    return {
        "kx": grid.bins(0) * grid.bin_widths[0],
        "ky": grid.bins(1) * grid.bin_widths[1],
        "omega": grid.bins(2) * grid.frequency_resolution,
        "nyquist": grid.nyquist,
        "resolution": [grid.wavenumber_resolution, grid.frequency_resolution],
    }


def _bins_of_by_oracle(given: Input, _: Output) -> Output:
    """The lattice of bins from its definition with 40 digits, in the order of the discrete transform."""
    mp = oracle.mp
    widths = [2 * mp.pi / (n * oracle.mpf(d)) for n, d in zip(given["shape"], given["spacing"], strict=True)]
    nx, ny, nt = given["shape"]
    signed = [
        [(n if n < (size + 1) // 2 else n - size) * width for n in range(size)]
        for size, width in ((nx, widths[0]), (ny, widths[1]))
    ]
    return {
        "kx": signed[0],
        "ky": signed[1],
        "omega": [m * widths[2] for m in range(nt // 2 + 1)],
        "nyquist": [mp.pi / oracle.mpf(d) for d in given["spacing"]],
        "resolution": [max(widths[:2]), widths[2]],
    }


def _dispersion(given: Input) -> Output:
    k, water = given["wavenumber"], water_of(given)
    return {
        "frequency": water.frequency(k),
        "phase_velocity": water.phase_velocity(k),
        "group_velocity": water.group_velocity(k),
    }


def _dispersion_by_oracle(given: Input, _: Output) -> Output:
    """The group velocity as the derivative of omega0, and not by a formula of its own."""
    water = waters(given)
    omega = [oracle.dispersion(k, **water) for k in given["wavenumber"]]
    return {
        "frequency": omega,
        "phase_velocity": [w / k for w, k in zip(omega, given["wavenumber"], strict=True)],
        "group_velocity": [oracle.group_velocity(k, *water.values()) for k in given["wavenumber"]],
    }


def _resolutions(given: Input) -> Output:
    frequency, wavenumber = velocity_resolutions(
        given["wavenumber"], given["wavenumber_resolution"], given["frequency_resolution"], water_of(given)
    )
    return {"from_frequency": frequency, "from_wavenumber": wavenumber}


def _resolutions_by_oracle(given: Input, _: Output) -> Output:
    """eq:dcdwk: domega / k, and the group velocity, a derivative, times dk / k."""
    dk, dw = (oracle.mpf(given[name]) for name in ("wavenumber_resolution", "frequency_resolution"))
    k = [oracle.mpf(v) for v in given["wavenumber"]]
    group = [oracle.group_velocity(v, *waters(given).values()) for v in k]
    from_wavenumber = [c * dk / v for c, v in zip(group, k, strict=True)]
    return {"from_frequency": [dw / v for v in k], "from_wavenumber": from_wavenumber}


def _profile(given: Input) -> ProfileCurrent:
    """Any current of golden/README.md as a profile, to be integrated."""

    def velocity(z: FloatArray) -> FloatArray:
        u = np.asarray(given.get("velocity", (0, 0))) + np.outer(z, given.get("shear", (0, 0)))
        return u + sum((np.outer(np.exp(z / d), (a, b)) for a, b, d in given.get("layers", ())), np.zeros((1, 2)))

    return ProfileCurrent(velocity)


@dataclass(frozen=True)
class _Sum:
    """Currents add up, and so do their shifts: eq:SJ is linear."""

    parts: tuple[Current, ...]

    def doppler_shift_velocity(self, wavenumber: FloatArray, water: Water = DEEP) -> FloatArray:
        each = (shift_in("golden", c, wavenumber, water) for c in self.parts)
        return sum(each, np.zeros((np.size(wavenumber), 2)))


def _closed_current(given: Input) -> Current:
    """The same current from the closed forms."""
    velocity, shear = tuple(given.get("velocity", (0.0, 0.0))), given.get("shear")
    base = LinearCurrent(velocity, tuple(shear)) if shear else UniformCurrent(velocity)
    return _Sum((base, *(ExponentialCurrent((a, b), depth) for a, b, depth in given.get("layers", ()))))


def _shifts(current: Current, given: Input) -> Output:
    """eq:SJ at the wavenumbers of the entry, (n, 2), or what it becomes above a bottom."""
    return {"velocity": shift_in("golden", current, np.array(given["wavenumber"]), water_of(given))}


def _doppler_by_oracle(given: Input, _: Output) -> Output:
    depth = given.get("depth")
    return {"velocity": [oracle.doppler(given["current"], k, depth) for k in given["wavenumber"]]}


def _scales(given: Input) -> Output:
    s = Scales(given["peak_wavenumber"], given["gravity"])
    return {name: getattr(s, name) for name in ("wavenumber", "frequency", "length", "time", "velocity")}


def _scales_by_oracle(given: Input, _: Output) -> Output:
    k = oracle.mpf(given["peak_wavenumber"])
    omega = oracle.dispersion(k, given["gravity"])
    return {"wavenumber": k, "frequency": omega, "length": 1 / k, "time": 1 / omega, "velocity": omega / k}


def _jonswap_conditioning(given: Input, found: Output) -> Output:
    """Roundings in the exponents count as often as the exponents are large; the value itself is the scale."""
    w, s = np.asarray(given["frequency"]), np.asarray(found["density"])
    return {"density": (s * (8 + 5 * w**-4.0 + _bell(w, given["peakedness"]))).tolist()}


def _bell(w: FloatArray, peakedness: float) -> FloatArray:
    """Roundings in the exponent of the peak's enhancement, for one of `w`."""
    sigma = np.where(w <= 1, 0.07, 0.09)
    r = np.exp(-(((w - 1) / sigma) ** 2) / 2)
    return np.log(peakedness) * r * (2 + ((w - 1) / sigma) ** 2 + np.abs((w - 1) / sigma**2))


def _spreading_conditioning(given: Input, found: Output) -> Output:
    """The argument of the cosine is a difference of angles over the spread: its turns are what rounds."""
    turn = (largest(given["direction"]) + abs(given["mean"]) + 360) / given["spread"]
    return {"density": 4 + np.pi * turn}


def _phases_by_oracle(given: Input, _: Output) -> Output:
    """By Python's integers, word by word of Philox."""
    return {
        "phase": [oracle.lattice_phase(given["realization"], i, j) for i, j in zip(given["i"], given["j"], strict=True)]
    }


def _sea(given: Input) -> Output:
    """The five arrays of the waves, turned about a centre if the entry says so."""
    current = _closed_current(given["current"])
    direction, spread, peakedness, length = (given[n] for n in ("direction", "spread", "peakedness", "length"))
    state = SeaState(direction, spread, peakedness, length, current, water_of(given))
    waves = state.components(given["realization"])
    if given.get("rotation"):
        waves = waves.rotated(given["rotation"], given["centre"])
    return {name: getattr(waves, name) for name in WAVE}


def _sea_by_oracle(given: Input, _: Output) -> Output:
    found = oracle.components(given, lambda k: oracle.doppler(given["current"], k, given.get("depth")))
    return dict(zip(WAVE, found, strict=True))


def _sea_conditioning(given: Input, found: Output) -> Output:
    """Wavenumbers are products of whole numbers with dk; amplitudes round with the exponents of eq:JONSWAP and the
    cosine of the spreading; phases are exact unless the sea is turned about a centre.

    Where the water is not deep S is taken at w = omega0(k) / omega0(k0), which has three roundings in each of the two:
    half of its exponents, 5 / 4 w^-4 and the bell's, times six is the second line of the amplitude.
    """
    k = np.hypot(found["kx"], found["ky"])
    water = water_of(given)
    a, turning = np.asarray(found["amplitude"]), given.get("rotation", 0) != 0
    centre = np.hypot(*given.get("centre", (0, 0)))
    amplitude = a * (12 + 2.5 / k**2) + a.max() * 720 * np.pi / given["spread"]
    if water != DEEP:
        w = water.frequency(k) / water.frequency(1.0)
        amplitude += a * 3 * (5 * w**-4.0 + _bell(w, given["peakedness"]))
    slow = shift_in("golden", _closed_current(given["current"]), k, water)
    return {
        "kx": (9 if turning else 3) * k.max(),
        "ky": (9 if turning else 3) * k.max(),
        "omega": float(((4 if water == DEEP else 8) * water.frequency(k) + 6 * k * np.hypot(*slow.T)).max()),
        "amplitude": amplitude.tolist(),
        "phase": float(9 * k.max() * centre + 7) if turning else 0.0,
    }


def _surface_conditioning(given: Input, _: Output) -> Output:
    """Each wave by its amplitude times the radians of its phase, all added as if none cancelled."""
    x, y, t = (largest(given[axis]) for axis in "xyt")
    w = waves_of(given)
    turns = np.abs(w.kx) * x + np.abs(w.ky) * y + np.abs(w.omega) * t + np.abs(w.phase)
    return {"eta": float(np.sum(np.abs(w.amplitude) * (4 + 2 * turns)))}


STAGES = {
    "scaled-grid": Stage("sec:parameters", {"chain": _scaled_grid}, _scaled_grid_by_oracle, relative(6, "shape")),
    "bins": Stage("app:numdetails", {"chain": _bins_of}, _bins_of_by_oracle, relative(6)),
    "dispersion": Stage("sec:theory", {"chain": _dispersion}, _dispersion_by_oracle, in_water(4)),
    "resolutions": Stage("eq:dcdwk", {"chain": _resolutions}, _resolutions_by_oracle, in_water(6)),
    "doppler": Stage(
        "eq:SJ",
        {
            "chain": lambda g: _shifts(_closed_current(g["current"]), g),
            "quadrature": lambda g: _shifts(_profile(g["current"]), g),
        },
        _doppler_by_oracle,
        relative(100),
    ),
    "scales": Stage("sec:dimensions", {"chain": _scales}, _scales_by_oracle, relative(4)),
    "jonswap": Stage(
        "eq:JONSWAP",
        {"chain": lambda g: {"density": jonswap(g["frequency"], g["peakedness"])}},
        lambda g, _: {"density": [oracle.jonswap(w, g["peakedness"]) for w in g["frequency"]]},
        _jonswap_conditioning,
    ),
    "spreading": Stage(
        "eq:angularspread",
        {"chain": lambda g: {"density": directional_spreading(g["direction"], g["mean"], g["spread"])}},
        lambda g, _: {"density": [oracle.spreading(d, g["mean"], g["spread"]) for d in g["direction"]]},
        _spreading_conditioning,
    ),
    "phases": Stage(
        "sec:spectrum",
        {"chain": lambda g: {"phase": uniform_phases(g["realization"], np.array(g["i"]), np.array(g["j"]))}},
        _phases_by_oracle,
        relative(0, "phase"),
    ),
    "components": Stage("eq:amplitudes", {"chain": _sea}, _sea_by_oracle, _sea_conditioning),
    "surface": Stage(
        "sec:spectrum",
        {"chain": lambda g: {"eta": synthesize(waves_of(g), g["x"], g["y"], g["t"])}},
        lambda g, _: {"eta": oracle.surface(listed(g), g["x"], g["y"], g["t"])},
        _surface_conditioning,
    ),
}
