"""In water of which depth do the waves of a cube lie best on one surface?

A bottom slows the long waves and leaves the short ones alone: no current does that, and no factor of time. So the share
of the band (`contrast`) is taken in water of many depths. Where k h is large for every wave of the band all depths fit
alike, and what is known is only that the water is no shallower than some depth.

Very short waves of a cube in metres are tried with the surface tension of clean water as well, and without it.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from leakref.cubes.contrast import Band, Found
from leakref.dispersion import Water
from leakref.planning.quantities import CLEAN_WATER

__all__ = ["ALIKE", "Fit", "fit"]

ALIKE = 0.025
"""Of the share: depths that bring as much onto the surface but for this part of it fit alike. In seas of a known depth
another one, always a larger one, gains up to 0.014, since a window mixes the long waves with shorter ones.
"""

_STEP = 0.15  # between two depths, in the logarithm
_SHALLOWEST, _DEEPEST = 0.15, 4.0  # k h of the shortest and of the longest wave of the band: beyond, nothing changes
_FELT = 0.02  # of a frequency: a surface tension that changes none of them by more is not looked for


@dataclass(frozen=True)
class Fit:
    """The water in which most of the energy lies on one surface: `found` there, and the depths that fit as well.

    Any depth from `shallowest` to `deepest` brings as much onto the surface, but for `ALIKE` of it; `deepest`
    is infinite if deep water does.
    """

    found: Found
    water: Water
    shallowest: float
    deepest: float

    @property
    def is_deep(self) -> bool:
        """Whether deep water fits as well as any."""
        return bool(self.deepest == np.inf)


def fit(band: Band, metric: bool) -> Fit:
    """The depth that fits best, and if the cube is `metric` and its waves are short enough, with a surface tension.

    `band` is not empty. Its own water is among those that are tried, and deep water is.
    """
    own = band.water
    tensions = [own.surface_tension]
    k = float(np.hypot(band.kx, band.ky).max())
    felt = Water(own.gravity, np.inf, CLEAN_WATER).frequency(k) > (1 + _FELT) * Water(own.gravity).frequency(k)
    if metric and felt:
        tensions += [CLEAN_WATER] if own.surface_tension == 0 else [0.0]
    return max((_at_best_depth(band, tension) for tension in tensions), key=_preferred(own.surface_tension))


def _preferred(own: float) -> Callable[[Fit], float]:
    """As large a share as can be, but for a gain without meaning the surface tension that was given."""
    return lambda one: one.found.share * (1 + ALIKE * (one.water.surface_tension == own))


def _at_best_depth(band: Band, tension: float) -> Fit:
    """The best depth with one surface tension: a lattice of depths, then finer ones around the best."""
    k, own = np.hypot(band.kx, band.ky), band.water
    lattice = np.arange(np.log(_SHALLOWEST / k.max()), np.log(_DEEPEST / k.min()), _STEP)
    tried: dict[float, Found] = {}

    def at(depth: float) -> None:
        if depth not in tried:
            tried[depth] = replace(band, water=Water(own.gravity, depth, tension)).at(1.0)

    for depth in [*np.exp(lattice).tolist(), own.depth, np.inf]:
        at(depth)
    for finer in (_STEP / 2, _STEP / 4):
        best = max(tried, key=lambda depth: tried[depth].share)
        if best < np.inf:
            at(best * np.exp(finer))
            at(best * np.exp(-finer))
    share = max(one.share for one in tried.values())
    alike = sorted(depth for depth, one in tried.items() if one.share >= (1 - ALIKE) * share)
    best = max(alike, key=lambda depth: (tried[depth].share, depth))
    if own.depth in alike:
        best = own.depth  # what is taken for granted stays so unless another is better
    return Fit(tried[best], Water(own.gravity, best, tension), alike[0], alike[-1])
