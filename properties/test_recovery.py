"""Recovery: a uniform current known exactly is returned exactly."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given

from leakref.certify.checks.criteria import score, vector, width
from leakref.certify.checks.exact import EXACT, FLATTER, exactly
from leakref.certify.checks.inputs import Cube
from leakref.methods import METHODS

from .examined import PRECISION, Examined
from .strategies import examples, pairs, singles


def too_wide(cube: Cube, method: str) -> bool:
    """Whether G is so wide that its two branches are within 4 a of each other: N then has its maximum elsewhere."""
    if method not in METHODS or METHODS[method].score is None:
        return False
    waves = cube.components
    lowest = min(np.abs(waves.omega).min(), cube.water.frequency(np.hypot(waves.kx, waves.ky)).min())
    return bool(lowest < 2 * width(cube, float(cube.wavenumbers[0]), method))


@examples(30)
@given(cube=pairs())
def test_a_pair_of_waves_on_bins_gives_the_current(examined: Examined, cube: Cube) -> None:
    """Every method of the reference, box, both powers above the threshold, the lower frequency at least 2 a: there N
    has its maximum at the current itself, to exp(-32). The reference to 1e-10 c0; others to 2e-4, three times what
    optimisers at default tolerances miss, or for the NSP a score within 1e-6; another method, or one velocity for all,
    to the resolution. Images of 8 bits add noise, 5e-4 in 20,000 samples and less in more: others are given twice as
    much there."""
    examined.offered("extract", window="box")
    if "wavenumbers" in examined.subject.declaration.untold:
        pytest.skip("has wavenumbers of its own, of which so small a cube may have none")
    for method in examined.methods():
        found = examined.velocities(cube.surface, cube, "box", method, every=True)
        if np.isnan(found).any() or too_wide(cube, method):
            continue
        if examined.is_reference:
            over = np.hypot(*(found - cube.truth).T) / PRECISION
        else:
            over = exactly(examined.subject, cube, "box", method, found, cube.truth) / (1 + 2e4 / cube.surface.size)
        assert over.max() <= 1, (
            f"{method}: got {vector(found[0])} at k = {cube.wavenumbers[0]:.4g}, but should be "
            f"{vector(cube.truth[0])} [{over.max():.2g} times what is allowed]"
        )


@examples(20)
@given(cube=singles())
def test_a_wave_on_a_bin_gives_the_component_along_it(examined: Examined, cube: Cube) -> None:
    """What maximises N, box: one wave says nothing of the component across, and LS has no answer. The reference to
    1e-10 c0, others to 2e-4, three times what optimisers at default tolerances miss, or a score within 1e-6 of the
    best."""
    examined.offered("extract", window="box")
    scored = [name for name in examined.methods(band=False) if name in METHODS and METHODS[name].score]
    if not scored or "wavenumbers" in examined.subject.declaration.untold:
        pytest.skip("offers no NSP at any wavenumber; other methods may decline where one wave is all there is")
    found = examined.velocities(cube.surface, cube, "box", scored[0], every=True)
    if np.isnan(found).any() or too_wide(cube, scored[0]):
        return
    k = np.array([cube.components.kx[0], cube.components.ky[0]]) / cube.wavenumbers[0]
    along, should = float(found[0] @ k), float(cube.truth[0] @ k)
    right = abs(along - should) <= (PRECISION if examined.is_reference else EXACT)
    if not right and not examined.is_reference:
        there = found[0] + (should - along) * k
        own, best = (score(cube, "box", float(cube.wavenumbers[0]), c, scored[0]) for c in (found[0], there))
        right = 1 - own / best <= FLATTER
    assert right, f"along the wave got {along:.8g}, but should be {should:.8g} (its velocity is {vector(found[0])})"
