"""Scores, velocities and their statistics.

The stages are `score` and `derivatives` (N of eq:normSp, its gradient and Hessian), one for each method (the velocities
that maximise it, or minimise eq:LS1, and so on), `extract` (the whole chain from a surface) and `statistics` (bias and
random part of sec:parameters). The conditioning of a velocity is the hardest of all and has its own functions here,
which `entries` uses for whole seas.

- `score`: waves or a surface, a shell and `velocities` (m, 2); `N` (m,).
- `derivatives`: likewise with one `velocity`; `N`, `gradient` (2,), `hessian` (2, 2).
- each method, `nsp`, `ls` and so on: waves or a surface and `wavenumbers` (n,); `velocities` (n, 2) and notes.
- `extract`: a surface, `spacing`, `wavenumbers`, the water, `window`, `method`; the same.
- `statistics`: `velocities` (R, n, 2); `bias`, `random`, `standard_error`, `count` (n,), `mean` (n, 2).
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from leakref._base import FloatArray
from leakref.cases import Configuration
from leakref.chain import analyse, extract
from leakref.dispersion import DEEP, Water, velocity_unit
from leakref.ensemble import Ensemble
from leakref.golden import oracle, oraclemethods
from leakref.golden.sets import tolerance
from leakref.golden.stages.spectra import oracle_shell, oracle_values, shell_of, width_of
from leakref.golden.stages.stage import (
    Input,
    Output,
    Stage,
    both_routes,
    by_surface,
    in_closed_form,
    largest,
    relative,
    turns,
    water_of,
)
from leakref.methods import METHODS
from leakref.nsp import WIDTH, normalized_scalar_product, score_derivatives
from leakref.shell import Extraction, Shell, shell_at
from leakref.spectrum import Spectrum

__all__ = ["STAGES", "UNFLAGGED", "softness", "velocity_conditioning"]

UNFLAGGED = 1e-11
"""In c0: what a rounding of F moves a velocity by where the optimum is not flat, 530 x 2^-52 at worst, with margin."""
_FLAT = 0.05  # c0^2 times curvature over N where `flat` begins: below, the figure grows as the curvature falls
_ILL = 1e3  # the same for LS: of its normal matrix, stiff over soft


def _scores(spectrum: Callable[[Input], Spectrum]) -> Callable[[Input], Output]:
    def run(given: Input) -> Output:
        shell = shell_of(spectrum(given), given)
        return {"N": [normalized_scalar_product(shell, c, width_of(given)) for c in given["velocities"]]}

    return run


def _scores_by_oracle(given: Input, _: Output) -> Output:
    shell = oracle_shell(given, oracle_values(given))[0]
    return {"N": [oracle.score(shell, c)[0] for c in given["velocities"]]}


def _derivatives(spectrum: Callable[[Input], Spectrum]) -> Callable[[Input], Output]:
    def run(given: Input) -> Output:
        shell = shell_of(spectrum(given), given)
        n, gradient, hessian = score_derivatives(shell, given["velocity"], width_of(given))
        return {"N": n, "gradient": gradient, "hessian": hessian}

    return run


def _derivatives_by_oracle(given: Input, _: Output) -> Output:
    shell = oracle_shell(given, oracle_values(given))[0]
    return dict(zip(("N", "gradient", "hessian"), oracle.score(shell, given["velocity"]), strict=True))


def _sensitivity(shell: Shell, velocity: Any, width: float) -> tuple[float, FloatArray]:
    """How N and its gradient move with F: root of the sum over bins of (dN/dF)^2; sum of the products, (2, 2).

    Of N = scale sum w G F / (sum w G sum w F): derivatives by F at one bin, and those again by the velocity. N does not
    change if all of F is multiplied by a number, which is why a bin counts by how much G there differs from the mean of
    G over the energy (`g - overlap / energy`).
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
    """Roundings of F (see `_turns`) carried into N; its derivatives have a natural step, 4 k / a, in velocity. A
    derivative by the velocity is larger by the step, and worse conditioned by as much.
    """
    spectrum = in_closed_form(given)
    shell, width = shell_of(spectrum, given), width_of(given)
    rounding = spectrum.strongest[0] * turns(given)
    step = 4 * np.hypot(shell.kx, shell.ky).max() / width
    own = max(largest(found["N"]) * 4 * (shell.omega[-1] + shell.intrinsic.max()) / width, 4.0)
    velocities = given.get("velocities") or [given["velocity"]]
    value = [_sensitivity(shell, c, width)[0] * rounding + own for c in velocities]
    if "velocities" in given:
        return {"N": value}
    return {"N": value[0], "gradient": value[0] * step, "hessian": value[0] * step**2}


def softness(method: str, score: float, hessian: FloatArray, unit: float = 1.0) -> float:
    """How much worse than `UNFLAGGED` an optimum is conditioned: 1, and more where it is flat; `unit` is c0.

    `hessian` (2, 2) is that of N for a method that maximises it, else of a sum of squares; `score` is N. Of N the
    smaller curvature counts, in `c0^2` over N; of squares the ratio of the two, how stiff the normal matrix is over how
    soft.
    """
    curvature = np.abs(np.linalg.eigvalsh(hessian))
    if METHODS[method].score:
        return float(max(1.0, _FLAT * score / max(curvature[0] * unit**2, 1e-300)))
    return float(max(1.0, curvature[1] / curvature[0] / _ILL))


def velocity_conditioning(spectrum: Spectrum, found: Extraction, rounding: float, water: Water = DEEP) -> list[float]:
    """Of the velocity at each wavenumber (n,), NaN where there is none; `rounding` of S, in 2^-52 of its largest.

    NSP: the roundings of F move the gradient of N, and the inverse of its Hessian turns that into velocity; besides,
    those of omega over k. LS: those of omega, through the pseudo-inverse of the wavenumbers of the strong bins; where
    points of a crest are fitted also those of F, which move a point by a bin times as much. To take
    all roundings as large as those of the strongest bin is too much where the shell is far below it: the figure for the
    curvature, `UNFLAGGED` times `softness`, is the most that is allowed.
    """
    largest = spectrum.strongest[0] * rounding
    result = []
    for k, c, score, hessian in zip(found.wavenumbers, found.velocities, found.score, found.hessian, strict=True):
        if not np.isfinite(c).all():
            result.append(float("nan"))
            continue
        shell = shell_at(spectrum, float(k), water=water)
        own = 4 * (float(shell.omega[-1]) / float(k) + float(np.hypot(*c)))
        record, domega = METHODS[found.method], spectrum.grid.frequency_resolution
        if record.score:
            width = WIDTH * domega * record.spread(spectrum.grid, water, float(k))
            _, spread = _sensitivity(shell, c, width)
            inverse = np.linalg.inv(hessian)
            moved = float(np.sqrt(np.trace(inverse @ spread @ inverse.T))) * largest
            moved += own + 4 * float(score * k) / width * float(np.linalg.norm(inverse, 2))
        else:
            soft, stiff = np.linalg.eigvalsh(hessian / 2)
            count = float(np.trace(hessian / 2)) / float(k) ** 2
            moved = own * float(np.sqrt(count * k**2 / soft) + stiff / soft)
            if record.optimum:
                moved += 4 * domega * largest / float(shell.magnitude.max()) * float(np.sqrt(2 / soft))
        unit = velocity_unit(float(k), water, None)
        most = UNFLAGGED / tolerance(1.0) * unit * softness(found.method, float(score), hessian, unit)
        result.append(min(moved, most))
    return result


def _velocities(spectrum: Callable[[Input], Spectrum], method: str) -> Callable[[Input], Output]:
    def run(given: Input) -> Output:
        found = analyse(spectrum(given), given["wavenumbers"], water=water_of(given), method=method)
        return _record(found)

    return run


def _record(found: Extraction) -> Output:
    return {"velocities": found.velocities, "notes": [note.names for note in found.notes]}


def _velocities_by_oracle(given: Input, first: Output, method: str) -> Output:
    """With 40 digits: maxima of N from the velocity that the chain found, so that both are the same maximum; else from
    nothing (`oraclemethods`).
    """
    values, result = oracle_values(given), []
    for k, start in zip(given["wavenumbers"], np.asarray(first["velocities"]), strict=True):
        if not np.isfinite(start).all() and METHODS[method].score:
            result.append([np.nan, np.nan])
            continue
        result.append(oraclemethods.velocity(method, oracle_shell(given, values, k)[0], start.tolist(), k, given))
    return {"velocities": result}


def _velocities_conditioning(given: Input, method: str) -> Output:
    """Of the velocities that the chain finds on the surface, by `velocity_conditioning`."""
    spectrum, water = by_surface(given), water_of(given)
    found = analyse(spectrum, given["wavenumbers"], water=water, method=method, search=False)
    return {"velocities": velocity_conditioning(spectrum, found, turns(given), water)}


def _extract(given: Input) -> Output:
    return _record(
        extract(
            given["surface"],
            tuple(given["spacing"]),
            given["wavenumbers"],
            water=water_of(given),
            window=given["window"],
            method=given["method"],
        )
    )


def _statistics(given: Input) -> Output:
    velocities = np.array(given["velocities"], dtype=np.float64)
    k = np.ones(velocities.shape[1])
    e = Ensemble(Configuration("golden"), "box", "nsp", k, velocities, np.zeros(velocities.shape[:2], dtype=np.int64))
    return {"bias": e.bias, "random": e.random, "mean": e.mean, "standard_error": e.standard_error, "count": e.count}


def _stage(method: str) -> Stage:
    """The velocities by a method."""
    return Stage(
        "eq:normSp" if METHODS[method].score else "eq:LS1",
        both_routes(lambda s: _velocities(s, method)),
        lambda given, first: _velocities_by_oracle(given, first, method),
        lambda given, _: _velocities_conditioning(given, method),
    )


STAGES = {
    "score": Stage("eq:normSp", both_routes(_scores), _scores_by_oracle, _score_conditioning),
    "derivatives": Stage("eq:normSp", both_routes(_derivatives), _derivatives_by_oracle, _score_conditioning),
    **{name: _stage(name) for name in METHODS},
    "extract": Stage(
        "sec:NSP",
        {"chain": _extract},
        lambda g, first: _velocities_by_oracle(g, first, g["method"]),
        lambda g, f: _velocities_conditioning(g, g["method"]),
    ),
    "statistics": Stage(
        "sec:parameters", {"chain": _statistics}, lambda g, _: oracle.statistics(g["velocities"]), relative(8, "count")
    ),
}
