"""Why there is no dispersion shell where it should be: the likely causes, each tried, and what comes right.

A wrong step in time, a wrong unit of length or time and a wrong gravity all put the surface at F omega0(k) instead of
omega0(k): what each of them would make of F is known, and the share of the band is taken there. Where none comes right
the factor is looked for over all frequencies; and the axes are tried in their other orders. Water of another depth puts
the surface elsewhere for the long waves alone: it is looked for in `depths`.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from itertools import permutations

import numpy as np

from leakref.cubes.contrast import CONTRAST, GAIN, MISPLACED, NEAR, SHARE, SUSPECT, Band, Found
from leakref.cubes.cube import Cube
from leakref.cubes.depths import ALIKE, Fit, fit
from leakref.cubes.waters import is_metric
from leakref.dispersion import Water
from leakref.planning.quantities import CLEAN_WATER

__all__ = ["Verdict", "judge"]

_AS_GOOD = 0.95  # of the largest share: as good as what explains most
_METRES_IN_A_DEGREE = 111_195.0
_MUCH = 0.05
"""Of the share: what another depth must gain for the surface to be called misplaced, and not a little off."""
_LOST = 0.02  # of the frames: a step in time that is wrong by less is within what velocities are known to


@dataclass(frozen=True)
class Verdict:
    """Whether a cube shows a dispersion shell where it should, and if not why.

    `share` is that of the band at the steps and the gravity of the cube. `words` say what was found, in sentences:
    first what is wrong, then what was tried and comes right, or what else may be the cause. They are a warning if it
    holds all the same, and empty if all is well. `depths` is from the shallowest to the deepest water that fits as well
    as any, None where the band does not tell; the deepest is infinite where deep water fits.
    """

    holds: bool
    share: float
    words: tuple[str, ...] = ()
    depths: tuple[float, float] | None = None


@dataclass(frozen=True)
class _Cause:
    """A mistake, what it makes of F, and how it is put right."""

    words: str
    factor: float
    remedy: str


def _causes(cube: Cube) -> list[_Cause]:
    """What may be wrong with steps, units and gravity, in the order in which it is tried."""
    dx, dy, dt = cube.grid.spacing
    g = cube.gravity

    def spaced(*steps: float) -> str:
        return f"--spacing {','.join(f'{d:.6g}' for d in steps)}"

    def of_gravity(other: float) -> float:
        return float(Water(other).frequency(1.0) / Water(g).frequency(1.0))

    found = [
        _Cause("time in days", 86400.0, spaced(dx, dy, dt * 86400)),
        _Cause("time in hours", 3600.0, spaced(dx, dy, dt * 3600)),
        _Cause("time in minutes", 60.0, spaced(dx, dy, dt * 60)),
        _Cause("time in milliseconds", 1e-3, spaced(dx, dy, dt * 1e-3)),
        _Cause("frames a second taken for seconds", dt**-2, spaced(dx, dy, 1 / dt)),
        _Cause("gravity in cm/s2, lengths in metres", 0.1, f"--gravity {g / 100:.6g}"),
        _Cause("lengths in centimetres, gravity in m/s2", 10.0, spaced(dx / 100, dy / 100, dt)),
        _Cause("lengths in millimetres, gravity in m/s2", 1e3**0.5, spaced(dx / 1e3, dy / 1e3, dt)),
        _Cause("lengths in kilometres, gravity in m/s2", 1e-3**0.5, spaced(dx * 1e3, dy * 1e3, dt)),
        _Cause("lengths in feet, gravity in m/s2", 0.3048**-0.5, spaced(dx * 0.3048, dy * 0.3048, dt)),
        _Cause("lengths in degrees", _METRES_IN_A_DEGREE**-0.5, "lengths in metres (111195 m a degree of latitude)"),
        _Cause("gravity of 1 with metres and seconds", of_gravity(9.81), "--gravity 9.81"),
        _Cause("gravity of 9.81 with scaled units", of_gravity(1.0), "--gravity 1"),
        _Cause("every tenth frame lost", 10 / 9, spaced(dx, dy, dt * 10 / 9)),
        _Cause("every fifth frame lost", 5 / 4, spaced(dx, dy, dt * 5 / 4)),
        _Cause("every second frame lost", 2.0, spaced(dx, dy, dt * 2)),
        _Cause("every frame twice", 0.5, spaced(dx, dy, dt / 2)),
    ]
    return [cause for cause in found if abs(np.log(cause.factor)) > SUSPECT / 2]


def judge(
    band: Band, contrasts: list[float | None], cube: Cube, transposed: Callable[[str], Band | None] | None = None
) -> Verdict:
    """Whether there is a shell, and if not why.

    `contrasts` are those at the wavenumbers of the band. `transposed` gives the band of the same cube with its axes in
    another order, such as "yxt", with the same steps along x, y and t, or None where there is none; without it the
    orders are not tried.
    """
    here = band.at(1.0)
    other = fit(band, is_metric(cube.units, cube.gravity)) if band.tells_the_factor and not band.is_empty else None
    verdict = _judged(band, here, other, contrasts, cube, transposed)
    return verdict if other is None else replace(verdict, depths=(other.shallowest, other.deepest))


def _judged(
    band: Band,
    here: Found,
    other: Fit | None,
    contrasts: list[float | None],
    cube: Cube,
    transposed: Callable[[str], Band | None] | None,
) -> Verdict:
    """The verdict, with what is there at the cube's own steps, gravity and water, and in the `other` that fits best."""
    enough = [(c or 0.0) >= CONTRAST for c in contrasts]
    if here.share >= SHARE and 2 * sum(enough) > len(enough):
        return _placed(band, here, other, cube)
    if band.is_empty:
        return Verdict(False, here.share, ("No dispersion shell: no shell holds more than noise.", _else(cube)))
    first = f"No dispersion shell: one current brings {_percent(here)} of the energy onto the surface (waves: 30 to "
    poor = [c for c, well in zip(contrasts, enough, strict=True) if not well]
    what = "less energy is near it than beside it" if any(c is not None for c in poor) else "no velocity is found"
    low = f", and at {len(poor)} of {len(enough)} wavenumbers {what}"
    first += f"90 %){low if poor else ''}."
    found = band.best(band.everywhere())
    if other is None or other.found.share < max(1.5 * here.share, 1.5 * SHARE) or not _is_water(band, other.found):
        other = None
    if band.tells_the_factor and found.share >= max(1.5 * here.share, 1.5 * SHARE) and _is_water(band, found):
        return Verdict(False, here.share, (first, *_explained(band, found, other, cube), _else(cube)))
    if other is not None:
        return Verdict(False, here.share, (first, _in_other_water(band, other, cube), _else(cube)))
    said = _other_orders(transposed, 1.5 * max(SHARE, here.share), cube) if transposed else []
    tried = "Tried: time in days to milliseconds, frames a second for seconds, other units of length and of gravity, "
    tried += "another depth, lost frames, any other step" + ", and the other orders of the axes" * (
        transposed is not None
    )
    return Verdict(False, here.share, (first, *(said or [f"{tried}: nothing comes right."]), _else(cube)))


def _placed(band: Band, here: Found, other: Fit | None, cube: Cube) -> Verdict:
    """Of a shell that is there: whether it lies where gravity, the steps and the depth put it, nearly so, or not."""
    best = band.best(NEAR) if band.tells_the_factor else here
    off = abs(np.log(best.factor)) if 1 - here.share / best.share > GAIN else 0.0
    gain = 0.0 if other is None or other.water == band.water else 1 - here.share / other.found.share
    if gain <= ALIKE or (other is not None and other.found.share < _AS_GOOD * best.share):
        other, gain = None, 0.0
    lost = _lost_frames(band, here, cube)
    if off <= SUSPECT and other is None and not lost:
        return Verdict(True, here.share)
    said = lost or _explained(band, best if off > SUSPECT else None, other, cube)
    if off <= MISPLACED and gain <= _MUCH and not lost:
        first = (
            "WARNING: the dispersion shell lies a little off where gravity, the steps and the depth put it. A strong "
            "shear does that, or another depth; else the velocities are wrong."
        )
        return Verdict(True, here.share, (first, *said))
    most = max(best, here if other is None else other.found, key=lambda one: one.share)
    first = (
        f"The dispersion shell is not where gravity, the steps and the depth put it: one current brings "
        f"{_percent(here)} of the energy onto it there, and {_percent(most)} elsewhere."
    )
    return Verdict(False, here.share, (first, *said, _else(cube)))


def _lost_frames(band: Band, here: Found, cube: Cube) -> list[str]:
    """That frames are lost, if it seems so, they are many, and the shell comes right with the step that they leave."""
    nt = cube.grid.shape[2]
    factor = (nt + cube.lost_frames) / nt
    if cube.lost_frames < _LOST * nt or not band.tells_the_factor:
        return []
    there = band.at(factor)
    if 1 - here.share / there.share <= GAIN:
        return []
    return [
        f"{cube.lost_frames} of {nt + cube.lost_frames} frames are lost, as the waves say that move on by two steps "
        "there: put them in with --fill-holes, or take the rest as equally spaced with dt x "
        f"{factor:.4g} ({_percent(there)} of the energy)."
    ]


def _in_other_water(band: Band, other: Fit, cube: Cube) -> str:
    """In which water the shell comes right, with the options to type and how well they are known."""
    own, water = band.water, other.water
    options = []
    if water.depth != own.depth:
        options.append("--depth deep" if water.depth == np.inf else f"--depth {water.depth:.3g}")
    if water.surface_tension != own.surface_tension:
        is_clean = water.surface_tension == CLEAN_WATER
        options.append(f"--surface-tension {'water' if is_clean else '0'}")
    if water.depth == own.depth:
        cause = "surface tension left out" if water.surface_tension else "a surface tension that is not there"
    elif own.depth == np.inf:
        cause = "deep water taken for granted where it is shallow"
    else:
        cause = "deep water" if water.depth == np.inf else "another depth"
    alike = f"from {other.shallowest:.3g} up" if other.is_deep else f"{other.shallowest:.3g} to {other.deepest:.3g}"
    known = f"; depths {alike} fit as well" if water.depth != own.depth else ""
    return f"Likely {cause}: comes right with {' '.join(options)} ({_percent(other.found)} of the energy{known})."


def _is_water(band: Band, found: Found) -> bool:
    """Whether a surface is one of waves, and not the plane of a still picture, where omega is k.c whatever F is."""
    k = band.wavenumber
    return bool(np.hypot(*found.current) * k < 0.5 * found.factor * float(band.water.frequency(k)))


def _percent(found: Found) -> str:
    return f"{100 * found.share:.0f} %"


def _at(factor: float) -> str:
    """What a factor means for each of the three that may be wrong."""
    return f"with dt x {factor:.3g} (or gravity x {factor**2:.3g}, or dx and dy x {factor**-2:.3g})"


def _explained(band: Band, best: Found | None, other: Fit | None, cube: Cube) -> list[str]:
    """What comes right as well as what comes most right: another depth, causes with the best factor, that factor."""
    said = [] if other is None else [_in_other_water(band, other, cube)]
    most = max(0.0 if one is None else one.share for one in (best, None if other is None else other.found))
    if best is None or best.share < _AS_GOOD * most:
        return said
    for cause in _causes(cube):
        if abs(np.log(cause.factor / best.factor)) < 0.12:
            there = band.at(cause.factor)
            if there.share >= _AS_GOOD * most:
                said.append(f"Likely {cause.words}: comes right with {cause.remedy} ({_percent(there)} of the energy).")
    dx, dy, _ = cube.grid.spacing
    if dx == dy == 1:
        said.append(f"Or lengths in pixels: comes right with pixels of {best.factor**-2:.3g} (--spacing dx,dy,dt).")
    return [*said, f"Comes right {_at(best.factor)}: {_percent(best)} of the energy."]


def _other_orders(transposed: Callable[[str], Band | None], least: float, cube: Cube) -> list[str]:
    """The orders of the axes that come right, the best first."""
    tried = []
    for order in map("".join, permutations("xyt")):
        other = transposed(order) if order != "xyt" else None
        if other is not None and not other.is_empty:
            tried.append((other.at(1.0).share, order))
    best = max(tried, default=(0.0, ""))
    return [
        f"Comes right with the axes in another order{_axes(cube, order)}: {100 * share:.0f} % of the energy, x, y, t "
        f"being what is now {', '.join(order)}."
        for share, order in sorted(tried, reverse=True)
        if share >= least and share >= _AS_GOOD * best[0]
    ]


def _axes(cube: Cube, order: str) -> str:
    """The option that would read the file in that order of what it is read as now."""
    if cube.assumed is None:
        return ""
    return f", --axes {''.join('xyt'[order.index(name)] for name in cube.assumed.axes)}"


def _else(cube: Cube) -> str:
    """What else may be the cause, that cannot be tried, and what is in force."""
    return (
        "What cannot be tried: no waves in this band (a swell alone, clouds, a camera that moves), a strong shear. In "
        f"force: gravity {cube.gravity:.6g}, {cube.water_words}, steps "
        f"{', '.join(f'{d:.6g}' for d in cube.grid.spacing)}."
    )
