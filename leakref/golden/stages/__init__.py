"""Every stage that has golden values: its inputs, the routes that compute it, and its conditioning.

A stage takes the `input` of an entry (plain JSON) and gives arrays by name. `routes` are the chain's own: "A" through
the surface, "B" in closed form, "chain" where there is one way only. `oracle` is the same from the paper's formulas
with 40 digits (`leakref.golden.oracle`). `conditioning` says by how much each output moves if every rounding on the
way is one unit of 2^-52, to first order (see `leakref.golden.sets`): for a sum of waves the turns of phase that are
formed and the stages of the transform; for a velocity the roundings of F carried through the curvature of N.
"""

from __future__ import annotations

from leakref.golden.stages import spectra, velocities, water, waves, windows

__all__ = ["STAGES"]

STAGES = {**waves.STAGES, **water.STAGES, **windows.STAGES, **spectra.STAGES, **velocities.STAGES}
"""Stages by name."""
