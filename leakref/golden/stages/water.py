"""What only water with a bottom or a surface tension has: how a profile is weighed, what a bottom leaves of a sea.

The stages are `kernel` (how much the current at a height counts, of which eq:SJ is the deep limit), `depth-factor` (the
factor of the TMA spectrum, and that from a density over frequencies to one over the plane) and `water-units` (from
scaled units to others and back). Dispersion, resolutions, shifts and seas in such water are stages that deep water has
as well; they are in `waves`.

- `kernel`: `wavenumber` (n,), heights `z` (m,), `depth`; `weight` (n, m).
- `depth-factor`: `wavenumber` (n,), the water; `depth_factor` and `density_factor` (n,).
- `water-units`: `peak_wavenumber`, `gravity`, `depth` k0 h and `surface_tension` S k0^2 / g; `depth`,
  `surface_tension` in the units of `gravity`, and both scaled again.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from leakref.currents import weight
from leakref.dispersion import Scales, Water
from leakref.golden import oracle
from leakref.golden.stages.stage import Input, Output, Stage, in_water, relative, water_of, waters

__all__ = ["STAGES"]


def _kernel(given: Input) -> Output:
    k, z = (np.array(given[name], dtype=np.float64) for name in ("wavenumber", "z"))
    return {"weight": weight(k[:, None], z, water_of(given))}


def _kernel_by_oracle(given: Input, _: Output) -> Output:
    """As it is defined: hyperbolic cosine over hyperbolic sine."""
    mp, h = oracle.mp, oracle.mpf(given["depth"])

    def at(k: Any, z: Any) -> Any:
        return 2 * k * mp.cosh(2 * k * (z + h)) / mp.sinh(2 * k * h)

    return {"weight": [[at(oracle.mpf(k), oracle.mpf(z)) for z in given["z"]] for k in given["wavenumber"]]}


def _kernel_conditioning(given: Input, found: Output) -> Output:
    """An exponent is off by as many roundings as it is large; ten more for sums, quotients and what is a factor."""
    most = 4 * max(given["wavenumber"]) * given["depth"]
    return {"weight": float((10 + most) * np.abs(found["weight"]).max())}


def _factors(given: Input) -> Output:
    k, water = given["wavenumber"], water_of(given)
    return {"depth_factor": water.depth_factor(k), "density_factor": water.density_factor(k)}


def _factors_by_oracle(given: Input, _: Output) -> Output:
    """The first by its definition, a quotient of two spectra; the second by the derivative of omega0."""
    k = [oracle.mpf(v) for v in given["wavenumber"]]
    water = waters(given)
    return {
        "depth_factor": [oracle.depth_factor(v, water["depth"]) for v in k],
        "density_factor": [2 * oracle.group_velocity(v, *water.values()) / v for v in k],
    }


def _units(given: Input) -> Output:
    scales = Scales(given["peak_wavenumber"], given["gravity"])
    there = Water(1.0, depth=given["depth"], surface_tension=given["surface_tension"]).to_units(scales)
    again = there.to_scaled(scales)
    return {
        "depth": there.depth,
        "surface_tension": there.surface_tension,
        "scaled_depth": again.depth,
        "scaled_surface_tension": again.surface_tension,
    }


def _units_by_oracle(given: Input, _: Output) -> Output:
    k, g, h, tension = (oracle.mpf(given[n]) for n in ("peak_wavenumber", "gravity", "depth", "surface_tension"))
    return {
        "depth": h / k,
        "surface_tension": tension * g / k**2,
        "scaled_depth": h,
        "scaled_surface_tension": tension,
    }


STAGES = {
    "kernel": Stage("eq:SJ", {"chain": _kernel}, _kernel_by_oracle, _kernel_conditioning),
    "depth-factor": Stage("sec:spectrum", {"chain": _factors}, _factors_by_oracle, in_water(6)),
    "water-units": Stage("sec:dimensions", {"chain": _units}, _units_by_oracle, relative(8)),
}
