"""The paper's cases as data (tab:case_collection), and those of other water.

Each case of tab:case_collection is a tuple of configurations, one for each line of a figure. All that the paper leaves
open about them is a decision (D9 to D13, D22, D23). `PAPER_CASES` has the paper's cases and no other, `CASES` has
besides the case `depth`, which is not the paper's (D31). The seas that only the claims need are in
`claims.configurations`; nothing is computed here but grids and currents.

An id is the case and what varies in it, as `leakref reproduce --list` prints them: `nsp-ls`,
`gamma/spread=15,peakedness=7`, `U/rotation=30,current=0.15,current_direction=0`.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import product
from typing import Any

import numpy as np

from leakref._base import FloatArray, LeakrefError, finite, positive
from leakref.chain import shell_wavenumbers
from leakref.currents import UniformCurrent
from leakref.dispersion import DEEP, Water
from leakref.grid import Grid
from leakref.sea import Components, SeaState

__all__ = ["ASSUMED_DEEP", "CASES", "PAPER_CASES", "REALIZATIONS", "SHELLS", "Configuration", "configurations"]

SHELLS = (0.4, 3.5)
"""The first and the last wavenumber of the paper's shells, in k0 (decision D9)."""
REALIZATIONS = 100
"""Realisations of every configuration in the paper (sec:parameters)."""
_SHORT = {
    "direction": "direction",
    "spread": "spread",
    "peakedness": "peakedness",
    "length": "L",
    "duration": "T",
    "speed": "current",
    "current_direction": "current_direction",
    "rotation": "rotation",
    "depth": "kh",
    "surface_tension": "tension",
}


@dataclass(frozen=True)
class Configuration:
    """One line of a case: a sea, a current and a domain, in scaled units; angles in degrees.

    `length` L and `duration` T count wavelengths and periods; `speed` and `current_direction` are those of the uniform
    current; `rotation` turns sea and current about the centre of the domain (decision D13). Periods are those of deep
    water, 2 pi / sqrt(g k0), whatever the depth: the samples are the same in every water (decision D26).

    - `case`: the id of the case; `direction`: theta0, where the waves go to; `spread`: full width (eq:angularspread).
    - `peakedness`: gamma of eq:JONSWAP; `speed`: in `c0`.
    - `current_direction`: where the current goes to, before the rotation.
    - `depth`: k0 h, infinite in deep water; `surface_tension`: S k0^2 / g, S over density.
    - `assumed`: the water in which velocities are measured, if it is another than the waves are in: a mistake.
    - `windows`: under which velocities are measured.

    LeakrefError is raised for angles or speeds that are not finite, and for sizes that are not positive.
    """

    case: str
    direction: float = 90.0
    spread: float = 60.0
    peakedness: float = 3.3
    length: float = 10.0
    duration: float = 20.0
    speed: float = 0.0
    current_direction: float = 0.0
    rotation: float = 0.0
    depth: float = np.inf
    surface_tension: float = 0.0
    assumed: Water | None = None
    windows: tuple[str, ...] = ("box", "hann")
    varied: tuple[str, ...] = ()
    """The parameters that tell the configurations of a case apart: those in its id."""

    def __post_init__(self) -> None:
        for name in ("direction", "speed", "current_direction", "rotation"):
            finite("Configuration", name, getattr(self, name))
        positive(
            "Configuration", spread=self.spread, peakedness=self.peakedness, length=self.length, duration=self.duration
        )
        _ = self.water  # which refuses a depth or tension that is none

    @property
    def id(self) -> str:
        """For instance `gamma/spread=15,peakedness=7`, or `depth/kh=1,assumed=deep` where another depth is assumed."""
        values = [f"{_SHORT[name]}={getattr(self, name):g}" for name in self.varied]
        if self.assumed is not None:
            values.append("assumed=deep" if self.assumed == DEEP else f"assumed={self.assumed.depth:g}")
        return f"{self.case}/{','.join(values)}" if values else self.case

    @cached_property
    def grid(self) -> Grid:
        """The samples of sec:parameters.

        28 samples a peak wavelength along x and y, 14 a peak period: spacing in `1 / k0` and `1 / omega0`.
        """
        return Grid.scaled(self.length, self.duration)

    @cached_property
    def water(self) -> Water:
        """The law of dispersion, in scaled units. Raises LeakrefError for a depth or tension that is none."""
        return Water(1.0, depth=self.depth, surface_tension=self.surface_tension)

    @property
    def measured_in(self) -> Water:
        """The water in which velocities are looked for: its own, unless another one is assumed."""
        return self.water if self.assumed is None else self.assumed

    @property
    def wavenumbers(self) -> FloatArray:
        """Those of the shells, (n,) (decision D9)."""
        return shell_wavenumbers(self.grid, *SHELLS)

    @property
    def current(self) -> FloatArray:
        """The true current (2,), after the rotation."""
        angle = np.radians(self.current_direction + self.rotation)
        return self.speed * np.array([np.cos(angle), np.sin(angle)])

    def components(self, realization: int) -> Components:
        """The waves of one realisation.

        `realization` counts from 0. Waves and phases are those of `SeaState`; a rotation turns waves, current and all,
        about the centre, so that velocities turn by the same angle.
        """
        angle = np.radians(self.current_direction)
        current = UniformCurrent((float(self.speed * np.cos(angle)), float(self.speed * np.sin(angle))))
        state = SeaState(self.direction, self.spread, self.peakedness, self.length, current, self.water)
        sea = state.components(realization)
        return sea.rotated(self.rotation, [side / 2 for side in self.grid.lengths[:2]]) if self.rotation else sea


def _vary(base: Configuration, **values: Iterable[float]) -> tuple[Configuration, ...]:
    base = replace(base, varied=(*base.varied, *values))
    chosen: Iterable[dict[str, Any]] = (dict(zip(values, point, strict=True)) for point in product(*values.values()))
    return tuple(replace(base, **point) for point in chosen)


def _with_currents(rotation: float) -> tuple[Configuration, ...]:
    base = Configuration("U", rotation=rotation, varied=("rotation",))
    speeds = (0.025, 0.075, 0.15)  # three within the paper's range, which names no others (decision D22)
    return _vary(base, speed=(0.0,)) + _vary(base, speed=speeds, current_direction=(90.0, 0.0, -90.0))


PAPER_CASES: dict[str, tuple[Configuration, ...]] = {
    "nsp-ls": (Configuration("nsp-ls", direction=75.0),),
    "theta0-dtheta": _vary(
        Configuration("theta0-dtheta"), direction=(60.0, 75.0, 90.0), spread=(15.0, 30.0, 45.0, 60.0)
    ),
    "gamma": _vary(Configuration("gamma", direction=60.0), spread=(15.0, 30.0, 45.0, 60.0), peakedness=(1.0, 3.3, 7.0)),
    "L-T": _vary(Configuration("L-T"), length=(5.0, 10.0, 20.0), duration=(10.0, 20.0, 80.0)),
    "U": _with_currents(0.0) + _with_currents(30.0),
    "windows": (Configuration("windows", windows=("box", "hann", "blackman", "kaiser-bessel")),),
}
"""Every configuration of every case of the paper by the case's id."""
CASES: dict[str, tuple[Configuration, ...]] = {
    **PAPER_CASES,
    "depth": _vary(Configuration("depth"), depth=(0.7, 1.0, 1.5, 2.0)),
}
"""The same with case depth: the paper's own sea and domain over a bottom that is known (decision D31)."""
ASSUMED_DEEP = tuple(replace(c, assumed=DEEP) for c in CASES["depth"])
"""The seas of case depth as they are measured by whoever takes the water for deep."""


def configurations(ids: Iterable[str]) -> list[Configuration]:
    """The configurations named by `ids`, each of a case or of one configuration, in order and once.

    Those of `ASSUMED_DEEP` are named one by one. Raises LeakrefError for an unknown id, with those that come close.
    """
    known = {c.id: c for members in (*CASES.values(), ASSUMED_DEEP) for c in members}
    chosen: dict[str, Configuration] = {}
    for name in ids:
        found = list(CASES.get(name, ())) or ([known[name]] if name in known else [])
        if not found:
            near = [c for c in known if c.startswith(name.split("/")[0] + "/")][:4] or list(CASES)
            raise LeakrefError(
                "configurations",
                f"no case is called {name!r}",
                f"try {', '.join(near)}; `leakref reproduce --list` prints all",
            )
        chosen.update((c.id, c) for c in found)
    return list(chosen.values())
