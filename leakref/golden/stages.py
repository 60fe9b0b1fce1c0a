"""Every stage that has golden values: its inputs, the routes that compute it, and its conditioning.

A stage takes the `input` of an entry (plain JSON) and gives arrays by name. `routes` are the chain's own: "A" through
the surface, "B" in closed form, "chain" where there is one way only. `witness` is the same from the paper's formulas
with 40 digits (`leakref.golden.oracle`). `conditioning` says by how much each output moves if every rounding on the
way is one unit of 2^-52, to first order (see `leakref.golden`): for a sum of waves the turns of phase that are formed
and the stages of the transform; for a velocity the roundings of F carried through the curvature of N.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from leakref import leakage
from leakref.golden import oracle
from leakref._base import FloatArray
from leakref.cases import Configuration
from leakref.chain import analyse, extract, shell_wavenumbers
from leakref.dispersion import (Current, ExponentialCurrent, LinearCurrent, ProfileCurrent, Scales, UniformCurrent,
                                group_velocity, intrinsic_frequency, phase_velocity, velocity_resolutions)
from leakref.ensemble import Ensemble
from leakref.golden import tolerance
from leakref.grid import Grid
from leakref.nsp import WIDTH, characteristic_function, normalized_scalar_product, score_derivatives
from leakref.sea import Components, SeaState, directional_spreading, jonswap, uniform_phases
from leakref.shell import Extraction, Shell, shell_at, velocity_unit
from leakref.spectrum import Spectrum, fourier
from leakref.synthesis import synthesize
from leakref.window import window

__all__ = ["STAGES", "UNFLAGGED", "Stage", "plain", "softness", "velocity_conditioning"]

Input = Mapping[str, Any]
Output = dict[str, Any]
Route = Callable[[Input], Output]
WAVE = ("kx", "ky", "omega", "amplitude", "phase")


UNFLAGGED = 1e-11
"""In c0: what a rounding of F moves a velocity by where the optimum is not flat, 530 x 2^-52 at worst, with margin."""
_FLAT = 0.05  # c0^2 times curvature over N where `flat` begins: below, the figure grows as the curvature falls
_ILL = 1e3  # the same for LS: of its normal matrix, stiff over soft


@dataclass(frozen=True)
class Stage:
    """How one stage's golden values are computed. `witness` gets what the first route found: optima start there."""

    equation: str
    routes: Mapping[str, Callable[[Input], Output]]
    witness: Callable[[Input, Output], Output] | None
    conditioning: Callable[[Input, Output], Output]


def _plain(value: Any) -> Any:
    """mpmath numbers in nested lists to floats, correctly rounded."""
    if isinstance(value, list | tuple):
        return [_plain(item) for item in value]
    return float(value)


def _largest(value: Any) -> float:
    return float(np.nanmax(np.abs(np.asarray(value, dtype=np.float64)), initial=0.0))


def _relative(factor: float, *exact: str) -> Callable[[Input, Output], Output]:
    """`factor` roundings of the largest item of each output; those named `exact` none."""
    return lambda given, found: {name: 0.0 if name in exact else factor * _largest(value)
                                 for name, value in found.items()}


# ---------------------------------------------------------------- grid, dispersion


def _grid(given: Input) -> Grid:
    return Grid(tuple(given["shape"]), tuple(given["spacing"]))


def _scaled_grid(given: Input) -> Output:
    grid = Grid.scaled(given["length"], given["duration"])
    return {"shape": grid.shape, "spacing": grid.spacing, "bin_widths": grid.bin_widths,
            "wavenumbers": shell_wavenumbers(grid)}


def _scaled_grid_witness(given: Input, _: Output) -> Output:
    mp, mpf = oracle.mp, oracle.mpf
    sizes = [int(mp.nint(mpf(given["length"]) * 28)), int(mp.nint(mpf(given["duration"]) * 14))]
    sides = [2 * mp.pi * mpf(given[name]) for name in ("length", "duration")]
    dk, dw = (2 * mp.pi / side for side in sides)
    first, last = int(mp.ceil(mpf("0.4") / dk)), int(mp.floor(mpf("3.5") / dk))
    x, t = (side / n for side, n in zip(sides, sizes, strict=True))
    return {"shape": [sizes[0], sizes[0], sizes[1]], "spacing": [x, x, t], "bin_widths": [dk, dk, dw],
            "wavenumbers": [n * dk for n in range(first, last + 1)]}


def _bins_of(given: Input) -> Output:
    grid = _grid(given)
    return {"kx": grid.bins(0) * grid.bin_widths[0], "ky": grid.bins(1) * grid.bin_widths[1],
            "omega": grid.bins(2) * grid.frequency_resolution, "nyquist": grid.nyquist,
            "resolution": [grid.wavenumber_resolution, grid.frequency_resolution]}


def _bins_of_witness(given: Input, _: Output) -> Output:
    mp = oracle.mp
    widths = [2 * mp.pi / (n * oracle.mpf(d)) for n, d in zip(given["shape"], given["spacing"], strict=True)]
    nx, ny, nt = given["shape"]
    signed = [[(n if n < (size + 1) // 2 else n - size) * width for n in range(size)]
              for size, width in ((nx, widths[0]), (ny, widths[1]))]
    return {"kx": signed[0], "ky": signed[1], "omega": [m * widths[2] for m in range(nt // 2 + 1)],
            "nyquist": [mp.pi / oracle.mpf(d) for d in given["spacing"]],
            "resolution": [max(widths[:2]), widths[2]]}


def _dispersion(given: Input) -> Output:
    k, g = given["wavenumber"], given["gravity"]
    return {"frequency": intrinsic_frequency(k, g), "phase_velocity": phase_velocity(k, g),
            "group_velocity": group_velocity(k, g)}


def _dispersion_witness(given: Input, _: Output) -> Output:
    g = given["gravity"]
    omega = [oracle.dispersion(k, g) for k in given["wavenumber"]]
    return {"frequency": omega, "phase_velocity": [w / k for w, k in zip(omega, given["wavenumber"], strict=True)],
            "group_velocity": [oracle.mp.diff(lambda k: oracle.dispersion(k, g), oracle.mpf(k))
                               for k in given["wavenumber"]]}


def _resolutions(given: Input) -> Output:
    frequency, wavenumber = velocity_resolutions(given["wavenumber"], given["wavenumber_resolution"],
                                                 given["frequency_resolution"], given["gravity"])
    return {"from_frequency": frequency, "from_wavenumber": wavenumber}


def _resolutions_witness(given: Input, _: Output) -> Output:
    g, dk, dw = (oracle.mpf(given[name]) for name in ("gravity", "wavenumber_resolution", "frequency_resolution"))
    k = [oracle.mpf(v) for v in given["wavenumber"]]
    return {"from_frequency": [dw / v for v in k], "from_wavenumber": [oracle.mp.sqrt(g / v) / 2 * dk / v for v in k]}


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

    def doppler_shift_velocity(self, wavenumber: FloatArray) -> FloatArray:
        return sum((c.doppler_shift_velocity(wavenumber) for c in self.parts), np.zeros((np.size(wavenumber), 2)))


def _closed_current(given: Input) -> Current:
    """The same current from the closed forms."""
    velocity, shear = tuple(given.get("velocity", (0.0, 0.0))), given.get("shear")
    base = LinearCurrent(velocity, tuple(shear)) if shear else UniformCurrent(velocity)
    return _Sum((base, *(ExponentialCurrent((a, b), depth) for a, b, depth in given.get("layers", ()))))


def _shifts(current: Current, given: Input) -> Output:
    return {"velocity": current.doppler_shift_velocity(np.array(given["wavenumber"]))}


def _doppler_witness(given: Input, _: Output) -> Output:
    return {"velocity": [oracle.doppler(given["current"], k) for k in given["wavenumber"]]}


def _scales(given: Input) -> Output:
    s = Scales(given["peak_wavenumber"], given["gravity"])
    return {name: getattr(s, name) for name in ("wavenumber", "frequency", "length", "time", "velocity")}


def _scales_witness(given: Input, _: Output) -> Output:
    k = oracle.mpf(given["peak_wavenumber"])
    omega = oracle.dispersion(k, given["gravity"])
    return {"wavenumber": k, "frequency": omega, "length": 1 / k, "time": 1 / omega, "velocity": omega / k}


# ---------------------------------------------------------------- sea, synthesis


def _jonswap_conditioning(given: Input, found: Output) -> Output:
    """Roundings in the exponents count as often as the exponents are large; the value itself is the scale."""
    w, s = np.asarray(given["frequency"]), np.asarray(found["density"])
    sigma = np.where(w <= 1, 0.07, 0.09)
    r = np.exp(-(((w - 1) / sigma) ** 2) / 2)
    bell = np.log(given["peakedness"]) * r * (2 + ((w - 1) / sigma) ** 2 + np.abs((w - 1) / sigma**2))
    return {"density": (s * (8 + 5 * w**-4.0 + bell)).tolist()}


def _spreading_conditioning(given: Input, found: Output) -> Output:
    turn = (_largest(given["direction"]) + abs(given["mean"]) + 360) / given["spread"]
    return {"density": 4 + np.pi * turn}


def _phases_witness(given: Input, _: Output) -> Output:
    return {"phase": [oracle.lattice_phase(given["realization"], i, j)
                      for i, j in zip(given["i"], given["j"], strict=True)]}


def _sea(given: Input) -> Output:
    state = SeaState(given["direction"], given["spread"], given["peakedness"], given["length"],
                     _closed_current(given["current"]))
    waves = state.components(given["realization"])
    if given.get("rotation"):
        waves = waves.rotated(given["rotation"], given["centre"])
    return {name: getattr(waves, name) for name in WAVE}


def _sea_witness(given: Input, _: Output) -> Output:
    found = oracle.components(given, lambda k: oracle.doppler(given["current"], k))
    return dict(zip(WAVE, found, strict=True))


def _sea_conditioning(given: Input, found: Output) -> Output:
    k = np.hypot(found["kx"], found["ky"])
    a, turning = np.asarray(found["amplitude"]), given.get("rotation", 0) != 0
    centre = np.hypot(*given.get("centre", (0, 0)))
    amplitude = a * (12 + 2.5 / k**2) + a.max() * 720 * np.pi / given["spread"]
    slow = _closed_current(given["current"]).doppler_shift_velocity(k)
    return {"kx": (9 if turning else 3) * k.max(), "ky": (9 if turning else 3) * k.max(),
            "omega": float((4 * np.sqrt(k) + 6 * k * np.hypot(*slow.T)).max()), "amplitude": amplitude.tolist(),
            "phase": float(9 * k.max() * centre + 7) if turning else 0.0}


def _waves(given: Input) -> Components:
    return Components(*(np.asarray(given[name], dtype=np.float64) for name in WAVE))


def _listed(given: Input) -> list[Any]:
    return [given[name] for name in WAVE]


def _surface_conditioning(given: Input, _: Output) -> Output:
    x, y, t = (_largest(given[axis]) for axis in "xyt")
    w = _waves(given)
    turns = np.abs(w.kx) * x + np.abs(w.ky) * y + np.abs(w.omega) * t + np.abs(w.phase)
    return {"eta": float(np.sum(np.abs(w.amplitude) * (4 + 2 * turns)))}


# ---------------------------------------------------------------- windows and spectra


def _response(given: Input) -> Output:
    found = window(given["window"]).response(given["bins"], given["positions"], given["size"])
    return {"real": found.real, "imag": found.imag}


def _summed_response(given: Input) -> Output:
    """Sample by sample, the whole turns taken out first."""
    n, u, m = np.array(given["bins"]), np.array(given["positions"]), np.arange(given["size"])
    turn = (n[:, None, None] - np.rint(u)[:, None]) * m % given["size"] - (u - np.rint(u))[:, None] * m
    found = np.exp(-2j * np.pi * turn / given["size"]) @ window(given["window"]).samples(given["size"])
    return {"real": found.real, "imag": found.imag}


def _response_witness(given: Input, _: Output) -> Output:
    return _rounded([[oracle.kernel(given["window"], n, u, given["size"]) for u in given["positions"]]
                     for n in given["bins"]])


def _response_conditioning(given: Input, _: Output) -> Output:
    """Whole turns are taken out first, only the remainder rounds; Kaiser-Bessel is summed with all its turns."""
    turns = 2 * np.pi * np.abs(given["positions"]).max() if given["window"] == "kaiser-bessel" else 0.0
    rounding = given["size"] * (16 + turns)
    return {"real": float(rounding), "imag": float(rounding)}


def _complex(values: Any) -> Output:
    return {"real": np.real(values), "imag": np.imag(values)}


def _rounded(found: Any) -> Output:
    """Complex numbers of the witness as floats; what is zero but for its own rounding is zero."""
    def part(nested: Any, name: str) -> Any:
        return [part(v, name) for v in nested] if isinstance(nested, list) else float(getattr(nested, name))

    parts = {name: np.array(part(found, name)) for name in ("real", "imag")}
    noise = 1e-30 * max(float(np.abs(v).max()) for v in parts.values())
    return {name: np.where(np.abs(v) < noise, 0.0, v) for name, v in parts.items()}


def _turns(given: Input) -> float:
    """Roundings of an item of S over its largest: turns of phase formed, and the stages of the FFT."""
    grid = _grid(given)
    stages = float(np.log2(np.prod(grid.shape)))
    if "kx" not in given:
        return 4 + stages
    return 4 + stages + float(sum(_largest(given[name]) * side for name, side in
                                  zip(("kx", "ky", "omega"), grid.lengths, strict=True)) + _largest(given["phase"]))


def _all_bins(given: Input) -> oracle.Bins:
    nx, ny, _ = given["shape"]
    return [(i, j) for i in range(nx) for j in range(ny)]


def _spectrum_witness(given: Input, _: Output) -> Output:
    nx, ny, nt = given["shape"]
    found = oracle.spectrum(_listed(given), given["shape"], given["spacing"], given["window"], _all_bins(given),
                             range(nt))
    return {name: v.reshape(nx, ny, nt) for name, v in _rounded(found).items()}


def _transform_witness(given: Input, _: Output) -> Output:
    return _rounded(oracle.transformed(given["surface"], given["window"]))


def _plain_transform(given: Input) -> Output:
    """By matrices of exponentials instead of the FFT."""
    eta = np.asarray(given["surface"], dtype=np.float64)
    for axis, sign in enumerate((-1, -1, 1)):
        n = eta.shape[axis]
        m = np.arange(n)
        matrix = np.exp(sign * 2j * np.pi * (np.outer(m, m) % n) / n) * window(given["window"]).samples(n)
        eta = np.moveaxis(np.tensordot(matrix, eta, axes=(1, axis)), 0, axis)
    return _complex(eta)


def _spectrum_conditioning(given: Input, found: Output) -> Output:
    largest = float(np.hypot(found["real"], found["imag"]).max())
    return {"real": largest * _turns(given), "imag": largest * _turns(given)}


def _by_surface(given: Input) -> Spectrum:
    grid = _grid(given)
    eta = given.get("surface")
    if eta is None:
        eta = synthesize(_waves(given), *(grid.samples(axis) for axis in range(3)))
    return fourier(eta, grid, given["window"], workers=1)


def _closed(given: Input) -> Spectrum:
    return leakage.spectrum(_waves(given), _grid(given), given["window"])


# ---------------------------------------------------------------- shells


def _shell(spectrum: Spectrum, given: Input) -> Shell:
    return shell_at(spectrum, given["wavenumber"], gravity=given["gravity"])


def _order(shell: Shell, given: Input) -> Any:
    """Columns by bin numbers (i, j), ascending."""
    grid = _grid(given)
    i, j = (np.rint(k / dk).astype(int) for k, dk in zip((shell.kx, shell.ky), grid.bin_widths, strict=False))
    return i, j, np.lexsort((j, i))


def _empty(given: Input) -> Spectrum:
    grid = _grid(given)
    nx, ny, nt = grid.shape
    return Spectrum(grid, "box", grid.bins(0), grid.bins(1), np.ones((nx, ny, nt // 2 + 1), dtype=np.complex128))


def _membership(given: Input) -> Output:
    shell = _shell(_empty(given), given)
    i, j, order = _order(shell, given)
    return {"i": i[order], "j": j[order], "intrinsic": shell.intrinsic[order], "weight": shell.weight,
            "omega": shell.omega}


def _membership_witness(given: Input, _: Output) -> Output:
    shell, bins = _witness_shell(given, None)
    return {"i": [i for i, _ in bins], "j": [j for _, j in bins], "intrinsic": shell.omega0, "weight": shell.weight,
            "omega": shell.omega}


def _witness_shell(given: Input, values: Callable[[oracle.Bins], Any] | None,
                   wavenumber: float | None = None) -> tuple[oracle.Shell, oracle.Bins]:
    bins = sorted(oracle.shell_bins(given["shape"], given["spacing"], wavenumber or given["wavenumber"]))
    found = values(bins) if values is not None else None
    return oracle.Shell(found, bins, given["shape"], given["spacing"], given["gravity"]), bins


def _witness_values(given: Input) -> Callable[[oracle.Bins], Any]:
    """S at given columns, from waves or from a surface."""
    if "surface" not in given:
        return lambda bins: oracle.spectrum(_listed(given), given["shape"], given["spacing"], given["window"], bins)
    everything = oracle.transformed(given["surface"], given["window"])
    return lambda bins: [everything[i][j][: given["shape"][2] // 2 + 1] for i, j in bins]


def _magnitude(spectrum: Callable[[Input], Spectrum]) -> Callable[[Input], Output]:
    def run(given: Input) -> Output:
        shell = _shell(spectrum(given), given)
        return {"F": shell.magnitude[_order(shell, given)[2]]}

    return run


def _magnitude_witness(given: Input, _: Output) -> Output:
    return {"F": _witness_shell(given, _witness_values(given))[0].f}


def _width(given: Input) -> float:
    return WIDTH * _grid(given).frequency_resolution


def _characteristic(given: Input) -> Output:
    shell = _shell(_empty(given), given)
    return {"G": characteristic_function(shell, given["velocity"], _width(given))[_order(shell, given)[2]]}


def _characteristic_witness(given: Input, _: Output) -> Output:
    return {"G": oracle.characteristic(_witness_shell(given, None)[0], given["velocity"])}


def _characteristic_conditioning(given: Input, _: Output) -> Output:
    """An exponent 2 z^2 is off by 4 z times the rounding of z, and z exp(-2 z^2) < 0.31."""
    shell = _shell(_empty(given), given)
    reach = shell.omega[-1] + shell.intrinsic.max() + np.hypot(shell.kx, shell.ky).max() * np.hypot(*given["velocity"])
    return {"G": float(4 + 4 * reach / _width(given))}


def _scores(spectrum: Callable[[Input], Spectrum]) -> Callable[[Input], Output]:
    def run(given: Input) -> Output:
        shell = _shell(spectrum(given), given)
        return {"N": [normalized_scalar_product(shell, c, _width(given)) for c in given["velocities"]]}

    return run


def _scores_witness(given: Input, _: Output) -> Output:
    shell = _witness_shell(given, _witness_values(given))[0]
    return {"N": [oracle.score(shell, c)[0] for c in given["velocities"]]}


def _derivatives(spectrum: Callable[[Input], Spectrum]) -> Callable[[Input], Output]:
    def run(given: Input) -> Output:
        shell = _shell(spectrum(given), given)
        n, gradient, hessian = score_derivatives(shell, given["velocity"], _width(given))
        return {"N": n, "gradient": gradient, "hessian": hessian}

    return run


def _derivatives_witness(given: Input, _: Output) -> Output:
    shell = _witness_shell(given, _witness_values(given))[0]
    return dict(zip(("N", "gradient", "hessian"), oracle.score(shell, given["velocity"]), strict=True))


def _sensitivity(shell: Shell, velocity: Any, width: float) -> tuple[float, FloatArray]:
    """How N and its gradient move with F: root of the sum over bins of (dN/dF)^2; sum of the products, (2, 2).

    Of N = scale sum w G F / (sum w G sum w F): derivatives by F at one bin, and those again by the velocity.
    """
    g, slope_x, slope_y = (np.zeros_like(shell.magnitude) for _ in range(3))
    shift = shell.kx * velocity[0] + shell.ky * velocity[1]
    for centre in (shell.intrinsic + shift, shift - shell.intrinsic):
        z = (shell.omega - centre[:, None]) / width
        branch = np.exp(-2 * z**2)
        g += branch
        slope_x += 4 * z / width * branch * shell.kx[:, None]
        slope_y += 4 * z / width * branch * shell.ky[:, None]
    w = np.broadcast_to(shell.weight, g.shape)
    energy, total, overlap = (float((w * v).sum()) for v in (shell.magnitude, g, g * shell.magnitude))
    scale = w.sum() / (energy * total)
    by_f = scale * w * (g - overlap / energy)
    rows = []
    for slope in (slope_x, slope_y):
        t, b = float((w * slope * shell.magnitude).sum()), float((w * slope).sum())
        rows.append(scale * w * (slope - t / energy - b / total * (g - overlap / energy)))
    stacked = np.stack(rows).reshape(2, -1)
    return float(np.sqrt((by_f**2).sum())), stacked @ stacked.T


def _score_conditioning(given: Input, found: Output) -> Output:
    """Roundings of F (see `_turns`) carried into N; its derivatives have a natural step, 4 k / a, in velocity."""
    spectrum = _closed(given)
    shell, width = _shell(spectrum, given), _width(given)
    rounding = spectrum.strongest[0] * _turns(given)
    step = 4 * np.hypot(shell.kx, shell.ky).max() / width
    own = max(_largest(found["N"]) * 4 * (shell.omega[-1] + shell.intrinsic.max()) / width, 4.0)
    velocities = given.get("velocities") or [given["velocity"]]
    value = [_sensitivity(shell, c, width)[0] * rounding + own for c in velocities]
    if "velocities" in given:
        return {"N": value}
    return {"N": value[0], "gradient": value[0] * step, "hessian": value[0] * step**2}


def softness(method: str, score: float, hessian: FloatArray, unit: float = 1.0) -> float:
    """How much worse than `UNFLAGGED` an optimum is conditioned: 1, and more where it is flat; `unit` is c0."""
    curvature = np.abs(np.linalg.eigvalsh(hessian))
    if method == "nsp":
        return float(max(1.0, _FLAT * score / max(curvature[0] * unit**2, 1e-300)))
    return float(max(1.0, curvature[1] / curvature[0] / _ILL))


def velocity_conditioning(spectrum: Spectrum, found: Extraction, rounding: float, gravity: float = 1.0) -> list[float]:
    """Of the velocity at each wavenumber (n,), NaN where there is none; `rounding` of S, in 2^-52 of its largest.

    NSP: the roundings of F move the gradient of N, and the inverse of its Hessian turns that into velocity; besides,
    those of omega over k. LS: those of omega, through the pseudo-inverse of the wavenumbers of the strong bins. To take
    all roundings as large as those of the strongest bin is too much where the shell is far below it: the figure for the
    curvature, `UNFLAGGED` times `softness`, is the most that is allowed.
    """
    largest = spectrum.strongest[0] * rounding
    result = []
    for k, c, score, hessian in zip(found.wavenumbers, found.velocities, found.score, found.hessian, strict=True):
        if not np.isfinite(c).all():
            result.append(float("nan"))
            continue
        shell = shell_at(spectrum, float(k), gravity=gravity)
        own = 4 * (float(shell.omega[-1]) / float(k) + float(np.hypot(*c)))
        if found.method == "nsp":
            width = WIDTH * spectrum.grid.frequency_resolution
            _, spread = _sensitivity(shell, c, width)
            inverse = np.linalg.inv(hessian)
            moved = float(np.sqrt(np.trace(inverse @ spread @ inverse.T))) * largest
            moved += own + 4 * float(score * k) / width * float(np.linalg.norm(inverse, 2))
        else:
            soft, stiff = np.linalg.eigvalsh(hessian / 2)
            count = float(np.trace(hessian / 2)) / float(k) ** 2
            moved = own * float(np.sqrt(count * k**2 / soft) + stiff / soft)
        unit = velocity_unit(float(k), gravity, None)
        most = UNFLAGGED / tolerance(1.0) * unit * softness(found.method, float(score), hessian, unit)
        result.append(min(moved, most))
    return result


def _velocities(spectrum: Callable[[Input], Spectrum], method: str) -> Callable[[Input], Output]:
    def run(given: Input) -> Output:
        found = analyse(spectrum(given), given["wavenumbers"], gravity=given["gravity"], method=method)
        return _record(found)

    return run


def _record(found: Extraction) -> Output:
    return {"velocities": found.velocities, "notes": [note.names for note in found.notes]}


def _velocities_witness(given: Input, first: Output, method: str = "nsp") -> Output:
    values, result = _witness_values(given), []
    for k, start in zip(given["wavenumbers"], np.asarray(first["velocities"]), strict=True):
        if not np.isfinite(start).all() and method == "nsp":
            result.append([np.nan, np.nan])
            continue
        shell = _witness_shell(given, values, k)[0]
        result.append(oracle.newton(shell, start.tolist()) if method == "nsp" else oracle.least_squares(shell))
    return {"velocities": result}


def _velocities_conditioning(given: Input, method: str) -> Output:
    spectrum = _by_surface(given)
    found = analyse(spectrum, given["wavenumbers"], gravity=given["gravity"], method=method, search=False)
    return {"velocities": velocity_conditioning(spectrum, found, _turns(given), given["gravity"])}


def _extract(given: Input) -> Output:
    return _record(extract(given["surface"], tuple(given["spacing"]), given["wavenumbers"], gravity=given["gravity"],
                           window=given["window"], method=given["method"]))


# ---------------------------------------------------------------- statistics, analytic


def _statistics(given: Input) -> Output:
    velocities = np.array(given["velocities"], dtype=np.float64)
    k = np.ones(velocities.shape[1])
    e = Ensemble(Configuration("golden"), "box", "nsp", k, velocities, np.zeros(velocities.shape[:2], dtype=np.int64))
    return {"bias": e.bias, "random": e.random, "mean": e.mean, "standard_error": e.standard_error, "count": e.count}


def _lobes(given: Input) -> Output:
    return {"lobe": window(given["window"]).transform(given["offsets"])}


def _lobes_integrated(given: Input) -> Output:
    """By Gauss-Legendre quadrature of the window itself."""
    nodes, weights = np.polynomial.legendre.leggauss(60)
    s = (nodes + 1) / 2
    taper = np.interp(s, [0, 1], [1, 1]) if given["window"] == "box" else _continuous(given["window"], s)
    return {"lobe": [float(np.sum(weights / 2 * taper * np.cos(2 * np.pi * v * (s - 0.5)))) for v in given["offsets"]]}


def _continuous(name: str, s: FloatArray) -> FloatArray:
    """The window between its samples, (n,)."""
    taper = window(name)
    if taper.coefficients:
        terms = ((-1) ** j * a * np.cos(2 * np.pi * j * s) for j, a in enumerate(taper.coefficients))
        return sum(terms, np.zeros(s.size))
    from scipy.special import i0

    from leakref.window import KAISER_SHAPE

    return i0(KAISER_SHAPE * np.sqrt(1 - (2 * s - 1) ** 2)) / i0(KAISER_SHAPE)


_ZERO = {"box": 1.0, "hann": 2.0, "blackman": 3.0, "kaiser-bessel": 2.0}  # where to look for it


def _tops(level: Callable[[float], Any], zero: float) -> list[float]:
    """Roughly where the sidelobes have their tops, on a lattice."""
    v = np.arange(zero + 0.02, zero + 6, 0.02)
    height = np.abs([float(level(float(u))) for u in v])
    return [float(v[n]) for n in range(1, v.size - 1) if height[n - 1] < height[n] >= height[n + 1]]


def _figures(given: Input) -> Output:
    from scipy.optimize import brentq, minimize_scalar

    taper, start = window(given["window"]), _ZERO[given["window"]]

    def level(v: float) -> float:
        return float(taper.transform(v) / taper.transform(0.0))

    zero = brentq(level, start - 0.02, start + 0.02, xtol=1e-15)
    side = min(minimize_scalar(lambda v: -abs(level(v)), bounds=(top - 0.02, top + 0.02), method="bounded",
                               options={"xatol": 1e-10}).fun for top in _tops(level, zero))
    three, six = (2 * brentq(lambda v, part=part: level(v) - part, 0.01, zero, xtol=1e-15)
                  for part in (np.sqrt(0.5), 0.5))
    nodes, weights = np.polynomial.legendre.leggauss(60)
    square = float(np.sum(weights / 2 * _continuous(given["window"], (nodes + 1) / 2) ** 2))
    gain = float(taper.transform(0.0))
    return {"first_zero": zero, "width_3db": three, "width_6db": six, "peak_sidelobe": -side,
            "peak_sidelobe_db": 20 * np.log10(-side), "noise_bandwidth": square / gain**2, "coherent_gain": gain,
            "scalloping": level(0.5)}


def _figures_witness(given: Input, _: Output) -> Output:
    mp, mpf, name = oracle.mp, oracle.mpf, given["window"]
    gain = oracle.closed_lobe(name, mpf(0))

    def level(v: Any) -> Any:
        return oracle.closed_lobe(name, v) / gain

    zero = oracle.nearest_root(level, _ZERO[name] * 1.001)
    three = oracle.nearest_root(lambda v: level(v) - mp.sqrt(mpf(1) / 2), 0.44 + 0.2 * (_ZERO[name] > 1))
    six = oracle.nearest_root(lambda v: level(v) - mpf(1) / 2, 0.6 + 0.4 * (_ZERO[name] > 1))
    highest = max(_tops(level, _ZERO[name]), key=lambda v: abs(level(v)))
    side = abs(level(mp.findroot(lambda v: mp.diff(level, v), mpf(highest))))
    return {"first_zero": zero, "width_3db": 2 * three, "width_6db": 2 * six, "peak_sidelobe": side,
            "peak_sidelobe_db": 20 * mp.log10(side), "noise_bandwidth": oracle.mean_square(name) / gain**2,
            "coherent_gain": gain, "scalloping": level(mpf(1) / 2)}


def _figures_conditioning(given: Input, found: Output) -> Output:
    """A root moves by the rounding of the lobe over its slope; a quadrature by a rounding for each of its 60 nodes."""
    taper, h = window(given["window"]), 1e-6
    slope = {name: abs(float(taper.transform(v + h) - taper.transform(v - h))) / (2 * h) / found["coherent_gain"]
             for name, v in (("first_zero", found["first_zero"]), ("width_3db", found["width_3db"] / 2),
                             ("width_6db", found["width_6db"] / 2))}
    return {name: 8 / slope[name] if name in slope else
            8 * 20 / np.log(10) / found["peak_sidelobe"] if name == "peak_sidelobe_db" else
            60.0 if name == "noise_bandwidth" else 8.0 for name in found}


def _both(make: Callable[[Callable[[Input], Spectrum]], Route]) -> dict[str, Route]:
    return {"A": make(_by_surface), "B": make(_closed)}


STAGES: dict[str, Stage] = {
    "scaled-grid": Stage("sec:parameters", {"chain": _scaled_grid}, _scaled_grid_witness, _relative(6, "shape")),
    "bins": Stage("app:numdetails", {"chain": _bins_of}, _bins_of_witness, _relative(6)),
    "dispersion": Stage("sec:theory", {"chain": _dispersion}, _dispersion_witness, _relative(4)),
    "resolutions": Stage("eq:dcdwk", {"chain": _resolutions}, _resolutions_witness, _relative(6)),
    "doppler": Stage("eq:SJ", {
        "chain": lambda g: _shifts(_closed_current(g["current"]), g),
        "quadrature": lambda g: _shifts(_profile(g["current"]), g)}, _doppler_witness, _relative(100)),
    "scales": Stage("sec:dimensions", {"chain": _scales}, _scales_witness, _relative(4)),
    "jonswap": Stage("eq:JONSWAP", {"chain": lambda g: {"density": jonswap(g["frequency"], g["peakedness"])}},
                     lambda g, _: {"density": [oracle.jonswap(w, g["peakedness"]) for w in g["frequency"]]},
                     _jonswap_conditioning),
    "spreading": Stage("eq:angularspread", {
        "chain": lambda g: {"density": directional_spreading(g["direction"], g["mean"], g["spread"])}},
        lambda g, _: {"density": [oracle.spreading(d, g["mean"], g["spread"]) for d in g["direction"]]},
        _spreading_conditioning),
    "phases": Stage("sec:spectrum", {
        "chain": lambda g: {"phase": uniform_phases(g["realization"], np.array(g["i"]), np.array(g["j"]))}},
        _phases_witness, _relative(0, "phase")),
    "components": Stage("eq:amplitudes", {"chain": _sea}, _sea_witness, _sea_conditioning),
    "surface": Stage("sec:spectrum", {"chain": lambda g: {"eta": synthesize(_waves(g), g["x"], g["y"], g["t"])}},
                     lambda g, _: {"eta": oracle.surface(_listed(g), g["x"], g["y"], g["t"])}, _surface_conditioning),
    "window": Stage("eq:hann", {"chain": lambda g: {"w": window(g["window"]).samples(g["size"])}},
                    lambda g, _: {"w": [oracle.window(g["window"], oracle.mpf(n) / g["size"])
                                        for n in range(g["size"])]}, _relative(8)),
    "response": Stage("sec:leakage", {"chain": _response, "sum": _summed_response}, _response_witness,
                      _response_conditioning),
    "transform": Stage("sec:leakage", {"chain": lambda g: _complex(_by_surface(g).whole()),
                                       "matrices": _plain_transform},
                       _transform_witness, _spectrum_conditioning),
    "spectrum": Stage("sec:NSP_and_leakage", {"A": lambda g: _complex(_by_surface(g).whole()),
                                              "B": lambda g: _complex(_closed(g).whole())},
                      _spectrum_witness, _spectrum_conditioning),
    "shell": Stage("eq:g", {"chain": _membership}, _membership_witness, _relative(4, "i", "j", "weight")),
    "magnitude": Stage("eq:maskedSpec", _both(_magnitude), _magnitude_witness,
                       lambda g, f: {"F": _closed(g).strongest[0] * _turns(g)}),
    "characteristic": Stage("eq:DSVkernel", {"chain": _characteristic}, _characteristic_witness,
                            _characteristic_conditioning),
    "score": Stage("eq:normSp", _both(_scores), _scores_witness, _score_conditioning),
    "derivatives": Stage("eq:normSp", _both(_derivatives), _derivatives_witness, _score_conditioning),
    "nsp": Stage("eq:normSp", _both(lambda s: _velocities(s, "nsp")), _velocities_witness,
                 lambda g, f: _velocities_conditioning(g, "nsp")),
    "ls": Stage("eq:LS1", _both(lambda s: _velocities(s, "ls")),
                lambda g, first: _velocities_witness(g, first, "ls"), lambda g, f: _velocities_conditioning(g, "ls")),
    "extract": Stage("sec:NSP", {"chain": _extract},
                     lambda g, first: _velocities_witness(g, first, g["method"]),
                     lambda g, f: _velocities_conditioning(g, g["method"])),
    "statistics": Stage("sec:parameters", {"chain": _statistics}, lambda g, _: oracle.statistics(g["velocities"]),
                        _relative(8, "count")),
    "lobes": Stage("fig:leakage_lobes", {"chain": _lobes, "quadrature": _lobes_integrated},
                   lambda g, _: {"lobe": [oracle.lobe(g["window"], v) for v in g["offsets"]]},
                   lambda g, f: {"lobe": 8.0 + np.pi * _largest(g["offsets"])}),
    "figures": Stage("app:window_comparison", {"chain": _figures}, _figures_witness, _figures_conditioning),
}
"""Stages by name, in the order of the chain."""


def plain(found: Output) -> Output:
    """Outputs as floats in nested lists or arrays, whoever computed them."""
    return {name: value if name == "notes" else np.array(_plain(value) if isinstance(value, list | tuple) else
                                                         np.asarray(value, dtype=np.float64), dtype=np.float64)
            for name, value in found.items()}
