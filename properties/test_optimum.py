"""The optimum: it is one, it is where the equations say, and it does not depend on what else is asked for."""

from __future__ import annotations

from typing import Any

import numpy as np
from hypothesis import assume, example, given
from hypothesis import strategies as st

from leakref import Grid
from leakref.certify.checks.inputs import Cube
from leakref.dispersion import DEEP

from .examined import Examined, same
from .strategies import currents, examples, seas


def shells(modules: Any, cube: Cube, window: str) -> list[Any]:
    """The shells of a cube, by the closed form."""
    spectrum = modules.leakage.spectrum(cube.components, cube.grid, window)
    return [modules.shell.shell_at(spectrum, k, water=DEEP) for k in cube.wavenumbers]


@examples(15)
@given(cube=seas(shells=1), window=st.sampled_from(("box", "hann")))
def test_the_score_is_stationary_and_curved_downwards(modules: Any, cube: Cube, window: str) -> None:
    """At an optimum without a note a Newton step, by differences of N alone, is below 1e-7 c0, the Hessian so formed is
    negative, and eight points 1e-3 c0 around score less. 1e-7: differences over h = 1e-3 of fourth order err by h^4 in
    the gradient, 1e-12, and by rounding, 1e-16 / h, over a curvature of at least 0.05."""
    (shell,) = shells(modules, cube, window)
    width = modules.nsp.WIDTH * cube.grid.frequency_resolution
    found = modules.nsp.optimum(shell, width, 1.0)
    c, n = found.velocity, found.score
    assume(not found.note.value)

    def score(u: float, v: float) -> float:
        return float(modules.nsp.normalized_scalar_product(shell, (c[0] + u, c[1] + v), width))

    h = 1e-3
    slope = np.array(
        [
            (8 * (score(*(h * e)) - score(*(-h * e))) - score(*(2 * h * e)) + score(*(-2 * h * e))) / (12 * h)
            for e in np.eye(2)
        ]
    )
    xx, yy = ((score(*(h * e)) - 2 * score(0, 0) + score(*(-h * e))) / h**2 for e in np.eye(2))
    xy = (score(h, h) - score(h, -h) - score(-h, h) + score(-h, -h)) / (4 * h**2)
    hessian = np.array([[xx, xy], [xy, yy]])
    assert abs(n / score(0, 0) - 1) < 1e-13
    assert np.linalg.eigvalsh(hessian)[1] < 0
    assert np.hypot(*np.linalg.solve(hessian, slope)) < 1e-7
    around = [score(h * np.cos(a), h * np.sin(a)) for a in np.arange(8) * np.pi / 4]
    assert max(around) < n


@examples(60)
@given(
    shape=st.tuples(*3 * [st.integers(8, 12)]),
    spacing=st.tuples(*3 * [st.floats(0.8, 1.2)]),
    seed=st.integers(0, 10**6),
    velocity=currents(2.0),
    width=st.floats(0.5, 6.0),
)
@example(shape=(9, 10, 9), spacing=(1.0, 1.1, 0.7), seed=0, velocity=(0.3, -0.2), width=4.0)
@example(shape=(10, 9, 8), spacing=(1.0, 1.1, 0.7), seed=0, velocity=(0.3, -0.2), width=4.0)
def test_the_half_space_stands_for_the_whole(
    modules: Any,
    shape: tuple[int, int, int],
    spacing: tuple[float, float, float],
    seed: int,
    velocity: tuple[float, float],
    width: float,
) -> None:
    """N over omega >= 0 with weights (decision D5) is N of eq:normSp summed over the whole space, odd or even in size,
    a Nyquist plane half at either end: to 1e-11 relative, since exponents of some hundred lose three digits."""
    grid = Grid(shape, spacing)
    k, a, nt = 1.1 * grid.wavenumber_resolution, width * grid.frequency_resolution, shape[2]
    assume(3.1 * grid.wavenumber_resolution < 0.99 * min(grid.nyquist[:2]))
    spectrum = modules.spectrum.fourier(np.random.default_rng(seed).standard_normal(shape), grid, "box", workers=1)
    kx, ky = np.meshgrid(
        *(2 * np.pi * np.fft.fftfreq(n, d) for n, d in zip(shape[:2], spacing, strict=False)), indexing="ij"
    )
    inside = np.abs(np.hypot(kx, ky) - k) <= (2 + 1e-9) * grid.wavenumber_resolution
    m = np.arange(-(nt // 2), nt // 2 + 1)
    weight = np.where(2 * np.abs(m) == nt, 0.5, 1.0)
    centre = (kx * velocity[0] + ky * velocity[1])[inside][:, None]
    rest = np.sqrt(np.hypot(kx, ky))[inside][:, None]
    g = sum(np.exp(-2 * ((m * grid.frequency_resolution - centre - branch * rest) / a) ** 2) for branch in (1, -1))
    f = np.abs(spectrum.whole())[inside][:, m % nt]
    assume((g * weight).sum() > 1e-100)
    literal = (g * f * weight).sum() / (g * weight).sum() / (f * weight).sum() * weight.sum() * inside.sum()
    shell = modules.shell.shell_at(spectrum, k, water=DEEP)
    assert abs(modules.nsp.normalized_scalar_product(shell, velocity, a) / literal - 1) < 1e-11


@examples(40)
@given(cube=seas(shells=1, fastest=0.6), velocity=currents(0.8), window=st.sampled_from(("box", "hann")))
def test_derivatives_of_the_score_are_its_differences(
    modules: Any, cube: Cube, velocity: tuple[float, float], window: str
) -> None:
    """At any velocity, gradient and Hessian against differences of fourth order of N and of the gradient over 1e-3 c0:
    to 1e-6 of the largest, the fifth derivative being some (4 k / a)^5 N and the step to the fourth 1e-12."""
    (shell,) = shells(modules, cube, window)
    width, h = modules.nsp.WIDTH * cube.grid.frequency_resolution, 1e-3
    c = np.array(velocity)
    _, gradient, hessian = modules.nsp.score_derivatives(shell, c, width)

    def difference(f: Any, e: Any) -> Any:
        return (8 * (f(c + h * e) - f(c - h * e)) - f(c + 2 * h * e) + f(c - 2 * h * e)) / (12 * h)

    steep = width / shell.wavenumber  # over which N changes by its own size
    slope = [difference(lambda v: modules.nsp.normalized_scalar_product(shell, v, width), e) for e in np.eye(2)]
    bend = [difference(lambda v: modules.nsp.score_derivatives(shell, v, width)[1], e) for e in np.eye(2)]
    assert np.abs(gradient - slope).max() * steep < 1e-6
    assert np.abs(hessian - bend).max() * steep**2 < 1e-6


@examples(30)
@given(cube=seas(shells=1, narrowest=45.0), window=st.sampled_from(("box", "hann")))
def test_least_squares_satisfies_its_normal_equations(modules: Any, cube: Cube, window: str) -> None:
    """sum of k (k.c - (omega - omega0)) = 0 over the bins with omega >= 0 and P at least a fifth of the shell's largest
    (eq:LS1, decisions D7 and D19), collected bin by bin: to 1e-12 of the sum of the sizes of its terms."""
    spectrum = modules.leakage.spectrum(cube.components, cube.grid, window)
    (c,) = modules.leastsquares.extract(spectrum, cube.wavenumbers, gravity=1.0).velocities
    assume(np.isfinite(c).all())
    kx, ky = (q[:, :, None] for q in np.meshgrid(spectrum.kx, spectrum.ky, indexing="ij"))
    k = np.hypot(kx, ky)
    omega = np.arange(cube.grid.shape[2] // 2 + 1) * 2 * np.pi / cube.grid.lengths[2]
    dk = max(2 * np.pi / n for n in cube.grid.lengths[:2])
    power = np.where(np.abs(k - cube.wavenumbers[0]) <= (2 + 1e-9) * dk, np.abs(spectrum.values) ** 2, 0)
    strong = power >= 0.2 * power.max()
    assume(np.abs(power / power.max() - 0.2).min() > 1e-9)
    residual = np.where(strong, kx * c[0] + ky * c[1] - (omega - np.sqrt(k)), 0)
    for along in (kx, ky):
        assert abs((along * residual).sum()) < 1e-12 * (np.abs(along) * np.abs(omega) * strong).sum()


@examples(12)
@given(cube=seas(shells=4), data=st.data())
def test_splitting_and_permuting_the_wavenumbers_changes_nothing(
    examined: Examined, cube: Cube, data: st.DataObject
) -> None:
    """Shells are independent of each other: exact in the reference, others a tenth of the smaller resolution."""
    order = data.draw(st.permutations(range(4)), label="order")
    cut = data.draw(st.integers(1, 3), label="cut")
    window, method = examined.windows()[0], data.draw(st.sampled_from(list(examined.methods(band=False))))
    should = examined.velocities(cube.surface, cube, window, method)
    found = np.empty_like(should)
    for part in (order[:cut], order[cut:]):
        some = Cube(cube.components, cube.grid, cube.wavenumbers[list(part)], cube.current)
        found[list(part)] = examined.velocities(cube.surface, some, window, method)
    same(examined, cube, window, method, found, should, exact=0.0)
