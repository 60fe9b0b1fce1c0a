"""Exact recovery: what is known exactly is returned exactly.

Waves with whole numbers of wavelengths and periods in the cube do not leak, and two of them fix the current: the right
answer is known to all digits, without a reference. What is off here is off because of the code, not of the method.
"""

from __future__ import annotations

import numpy as np

from leakref.certify.checks import inputs
from leakref.certify.checks.criteria import (
    FRACTION,
    IN_THE_MEAN,
    ask,
    each_method,
    expected,
    in_the_mean,
    scored_method,
    tapered,
    vector,
    verdict,
)
from leakref.certify.checks.depth import explained
from leakref.certify.checks.draw import drawing
from leakref.certify.checks.exact import (
    EXACT,
    EXACT_OR_SCORE,
    EXACTLY,
    FINE,
    MORE,
    NOISY,
    OTHERS,
    TAPERED,
    WITHIN_A_TENTH,
    aligned_window,
    deep_only,
    held_to_digits,
    judge_exactly,
    others_in_words,
    right,
)
from leakref.certify.checks.inputs import GRIDS, polar
from leakref.certify.checks.registry import Case, Outcome, check
from leakref.certify.subject.frames import Subject
from leakref.certify.verdict import Unanswered, Verdict
from leakref.currents import UniformCurrent
from leakref.dispersion import DEEP
from leakref.sea import aligned_waves

__all__ = [
    "check_half_width",
    "check_pair",
    "check_ring",
    "check_sea",
    "check_shells",
    "check_single",
    "check_two_shells",
    "check_weights",
]

PAIRS = [
    Case(f"{grid}-{n}", {"grid": grid, "bins": bins, "near": near}, quick=quick)
    for grid, n, bins, near, quick in (
        ("even", 1, ((5, 3), (-2, 5)), (0.21, -0.13), True),
        ("even", 2, ((6, -1), (4, 4)), (-0.1, 0.02), True),
        ("odd", 1, ((-4, 4), (5, 2)), (0.05, 0.3), True),
        ("odd", 2, ((0, -6), (6, 0)), (-0.2, -0.15), True),
        ("prime", 1, ((3, -5), (6, 1)), (0.0, 0.0), True),
        ("prime", 2, ((-6, -2), (-1, 6)), (0.15, 0.1), True),
        ("even", 3, ((5, 3), (-2, 5)), (-0.3, -0.2), False),
        ("odd", 3, ((1, 6), (-5, 2)), (0.33, -0.02), True),
        ("prime", 3, ((7, 0), (0, -6)), (-0.02, -0.3), False),
        ("prime", 4, ((4, 5), (7, -1)), (0.1, 0.25), False),
    )
]


@check("recovery", "eq:normSp", EXACTLY + MORE, PAIRS)
def check_pair(subject: Subject, case: Case) -> Outcome:
    """Two waves on bins of an untapered cube fix a uniform current exactly: lengths of (n - 1) d instead of n d, the
    gravity or the root of the dispersion relation, a wrong bin or a wrong branch all show; so does a shell
    less than half a bin wide to either side, which holds neither of two waves of unlike length."""
    first, second = case.given["bins"]
    grid, near = GRIDS[case.given["grid"]], case.given["near"]
    cube = inputs.pair(grid, first, second, near)
    more = inputs.many(grid.shape, near)
    far = np.abs(np.hypot(cube.components.kx, cube.components.ky) - cube.wavenumbers) > grid.wavenumber_resolution / 2
    others = 2.0 if far.any() else 1.0  # what is interpolated at the wavenumber itself sees little of such waves

    def judge(method: str) -> Outcome:
        outcome = judge_exactly(subject, cube, method, others=others, more=more)
        return outcome if cube.water == DEEP else explained(subject, cube, outcome)  # as in which depth it answers

    return each_method(subject, judge)


@check(
    "recovery",
    "eq:SnJ",
    "The velocity along the wave may be off by 2e-4 c0, three times what optimisers with "
    "default tolerances were seen to miss by; that of an NSP which is not the reference's by the smaller of the two "
    "velocity resolutions." + TAPERED,
    [
        Case("even", {"grid": "even", "bin": (5, 2), "shift": 2}),
        Case("odd", {"grid": "odd", "bin": (-3, 5), "shift": -2}),
        Case("prime", {"grid": "prime", "bin": (1, -6), "shift": 3}, quick=False),
    ],
)
def check_single(subject: Subject, case: Case) -> Outcome:
    """One wave fixes the component of the current along it and no more: what is returned along it must be right."""
    method = scored_method(subject, "offers no NSP; other methods may decline where one wave is all there is")
    draw, window, grid = drawing(), aligned_window(subject), inputs.sampling(GRIDS[case.given["grid"]])
    ((i, j),) = draw.bins(case.given["bin"])
    k = np.array([i, j]) * grid.bin_widths[:2]
    size = float(np.hypot(*k))
    m = round(float(inputs.still().frequency(size)) / grid.frequency_resolution) + case.given["shift"]
    phase = draw.phases(np.array([0.3])).tolist()
    waves, current = aligned_waves(grid, [(i, j, m)], phase=phase, water=inputs.still())
    cube = inputs.Cube(waves, grid, np.array([size]), UniformCurrent((float(current[0]), float(current[1]))))
    found, _ = ask(subject, cube, window, method)
    allowed = EXACT if held_to_digits(subject, window, method) else float(cube.resolutions[0, 0])
    along = float(found[0] @ k) / size
    should = min((float(one[0] @ k) / size for one in right(cube, window, method)), key=lambda one: abs(along - one))
    return Outcome(
        abs(along - should) / allowed,
        f"along the wave got {along:.6g}, should be {should:.6g} (its velocity is {vector(found[0])})",
        figures={"along": along, "should_be": should},
    )


BESIDE = ((5, 0), (0, 5), (-5, 0), (0, -5), (6, 0), (0, 6))
"""The longer waves go all round, the shorter ones, on bins in 21 sqrt(6 / 5) = 23.004 periods, one way."""


@check(
    "recovery",
    "eq:maskedSpec",
    EXACT_OR_SCORE + others_in_words("a tenth of ") + TAPERED + NOISY,
    [
        Case("still", {"bins": ((5, 0), (4, 3), (3, 4), (0, 5)), "current": (0, 0)}),
        Case("beside-still", {"bins": BESIDE, "current": (0, 0), "periods": 21}),
        Case("beside-moving", {"bins": BESIDE, "current": (5, -5), "periods": 21}),
        Case("moving", {"bins": ((5, 0), (0, 5), (-5, 0), (0, -5)), "current": (3, -4)}),
        # not two bins along an axis: at a / 2 the slope of G has its extremum, and Newton's method stands still there
        Case("one-sided", {"bins": ((5, 0), (0, 5), (-5, 0)), "current": (-3, -1)}),
        Case("still-2", {"bins": ((-5, 0), (-4, 3), (-3, 4), (0, -5)), "current": (0, 0)}, quick=False),
    ],
)
def check_ring(subject: Subject, case: Case) -> Outcome:
    """Several waves of one length, on bins, asked for at just that wavenumber: there is nothing to interpolate and
    nothing to weigh, so that every algorithm is right to a few digits and what is off is off because of a length, a
    duration, a gravity or a factor. Shorter waves beside them, in the next bin, tell whether omega0 and the Doppler
    shift are taken at each bin's own wavenumber or at the shell's."""
    if "periods" in case.given:
        deep_only()
    grid, draw = inputs.ring(5, 1.4, case.given.get("periods", 24), (30, 33, 100)), drawing()
    step = grid.frequency_resolution / 1.4
    current = UniformCurrent(tuple((step * draw.turn @ np.array(case.given["current"])).tolist()))
    # under a window their lobes reach bins on the very edge of a shell, which may belong to it or not (decision D3)
    beside = 1.06 if "periods" in case.given and aligned_window(subject) != "box" else 1.0
    cube = inputs.on_bins(grid, np.array(draw.bins(*case.given["bins"])), np.array([1.4 * beside]), current)
    twelve = inputs.on_bins(grid, inputs.TWELVE, cube.wavenumbers, current)
    return each_method(subject, lambda method: judge_exactly(subject, cube, method, others=FINE, noisy=twelve))


@check(
    "recovery",
    "eq:maskedSpec",
    WITHIN_A_TENTH + OTHERS + TAPERED + NOISY,
    [
        Case("alternating", {"radii": (4, 9, 14, 19), "shifts": ((4, -3), (-3, 4), (4, 3), (-4, -4))}),
        Case(
            "touching",
            {"radii": (4, 8, 12, 16, 20), "shifts": ((4, 3), (-4, -3), (3, -4), (-4, 4), (3, 3))},
            quick=False,
        ),
    ],
)
def check_shells(subject: Subject, case: Case) -> Outcome:
    """Rings of waves on bins, each with a current of its own: what interpolates over every second wavenumber, smooths
    over neighbours, puts a straight line through all of them, or looks at a shell several bins away, finds another."""
    if subject.declaration.band:
        raise Unanswered(Verdict.UNSUPPORTED, "gives one velocity for the whole band: see recovery.two-shells")
    grid, draw = inputs.ring(4, 0.6, 10, (50, 54, 90)), drawing()
    radii, shifts = np.array(case.given["radii"]), np.array(case.given["shifts"]) @ draw.turn.T
    wavenumbers = radii * grid.wavenumber_resolution
    velocities = shifts * (grid.frequency_resolution / wavenumbers)[:, None]
    along = np.array([(1, 0), (0, 1), (-1, 0), (0, -1)])
    cube = inputs.on_bins(
        grid,
        np.concatenate([r * along for r in radii]),
        wavenumbers,
        inputs.ByShell(wavenumbers, velocities),
        velocities=np.repeat(velocities, 4, axis=0),
    )
    return each_method(subject, lambda method: judge_exactly(subject, cube, method, FRACTION * cube.resolutions[0]))


@check(
    "recovery",
    "eq:maskedSpec",
    "The velocity may be off by the smaller of the two velocity resolutions from that of the strong waves.",
    [Case("strong-beside", {"current": (1, -1)})],
)
def check_half_width(subject: Subject, case: Case) -> Outcome:
    """Twelve strong waves four tenths of a bin longer than asked for, and at the very wavenumber weak ones, a twentieth
    as high, on the opposite current: a shell that is narrower than a bin sees the weak ones alone."""
    if subject.declaration.band:
        raise Unanswered(Verdict.UNSUPPORTED, "gives one velocity for the whole band: see recovery.two-shells")
    grid, draw = inputs.ring(5, 1.4, 24, (30, 33, 100)), drawing()
    weak = np.array(draw.bins(*((a * i, b * j) for a, b in ((4, 2), (2, 4)) for i in (1, -1) for j in (1, -1))))
    step = grid.frequency_resolution / grid.wavenumber_resolution
    current = step * draw.turn @ np.array(case.given["current"])
    cube = inputs.on_bins(
        grid,
        np.concatenate([inputs.TWELVE, weak]),
        np.array([4.58 * grid.wavenumber_resolution]),
        UniformCurrent((float(current[0]), float(current[1]))),
        np.repeat([1.0, 0.05], [12, 8]),
        np.repeat([current, -current], [12, 8], axis=0),
    )

    def judge(method: str) -> Outcome:
        found, there = ask(subject, cube, aligned_window(subject), method)
        over = np.hypot(*(found - cube.truth).T) / cube.resolutions[0]
        return verdict(np.where(there, over, np.nan), cube, found, cube.truth)

    return each_method(subject, judge)


@check(
    "recovery",
    "eq:maskedSpec",
    "The velocity may be off by the smaller of the two velocity resolutions from where the reference's NSP has its "
    "maximum: with F the square root of the power the many weak waves decide, with the power itself, four resolutions "
    "away, the few strong ones.",
    [Case("many-weak", {"strong": (2.5, 0.0), "weak": (-2.0, 0.0), "amplitude": 0.25})],
)
def check_weights(subject: Subject, case: Case) -> Outcome:
    """Four strong waves on one current and two dozen weak ones on another, in one shell: F is the square root of the
    power, and where the power or its square is taken instead, the strong waves alone are seen."""
    method = scored_method(subject, "offers no NSP; other methods weigh waves otherwise")
    grid, draw = inputs.ring(5, 1.4, 24, (30, 33, 100)), drawing()
    strong = [(5, 0), (0, 5), (-5, 0), (0, -5)]
    near = [(i, j) for i in range(-6, 7) for j in range(-6, 7) if abs(np.hypot(i, j) - 5) <= 0.45]
    weak = [bin_ for bin_ in near if bin_ not in strong]
    number = [len(strong), len(weak)]
    step = grid.frequency_resolution / 1.4
    velocities = np.repeat([case.given["strong"], case.given["weak"]], number, axis=0) @ draw.turn.T * step
    amplitude = np.repeat([1.0, case.given["amplitude"]], number)
    bins = np.array(draw.bins(*strong, *weak))
    cube = inputs.on_bins(grid, bins, np.array([1.4]), UniformCurrent(), amplitude, velocities)
    window = aligned_window(subject)
    found, _ = ask(subject, cube, window, method)
    should = expected(cube, window, method).velocities
    return verdict(np.hypot(*(found - should).T) / cube.resolutions[0], cube, found, should)


def _both(low: inputs.Cube, high: inputs.Cube) -> inputs.Cube:
    """Two cubes on one grid added, each with its own current at its own wavenumbers."""
    wavenumbers, truth = (
        np.concatenate(pair) for pair in ((low.wavenumbers, high.wavenumbers), (low.truth, high.truth))
    )
    waves = inputs.together(low.components, high.components)
    return inputs.Cube(waves, low.grid, wavenumbers, inputs.ByShell(wavenumbers, truth))


@check(
    "recovery",
    "eq:g",
    EXACTLY + MORE + " One velocity for the whole band may be anywhere between the two currents, or "
    "outside by that resolution or half the distance between them: each wave fixes no more than one component.",
    [Case("even", {"grid": "even"}), Case("prime", {"grid": "prime"}, quick=False)],
)
def check_two_shells(subject: Subject, case: Case) -> Outcome:
    """Two pairs of waves, each with its own current, in shells that do not touch: a shell that is too wide, an answer
    at the wrong wavenumber or one answer for all mixes them up."""
    grid = GRIDS[case.given["grid"]]
    slow, fast = (0.2, -0.1), (-0.15, 0.1)
    both = _both(inputs.pair(grid, (4, 1), (-2, 4), slow), inputs.pair(grid, (9, -4), (5, 8), fast))
    more = inputs.many(grid.shape, slow, fast)
    should = both.truth

    def judge(method: str) -> Outcome:
        if not subject.declaration.band:
            return judge_exactly(subject, both, method, more=more)
        found, _ = ask(subject, both, aligned_window(subject), method)
        outside = np.maximum(should.min(axis=0) - found, found - should.max(axis=0)).max(axis=1)
        allowed = np.maximum(both.resolutions[0], np.hypot(*(should[1] - should[0])) / 2)
        return verdict(np.maximum(outside, 0) / allowed, both, found, should)

    return each_method(subject, judge)


@check(
    "recovery",
    "eq:dcdwk",
    IN_THE_MEAN + " The reference stays below a third of the tolerance.",
    [
        Case("broad", {"direction": 40.0, "spread": 180.0, "current": polar(0.2, 75.0)}),
        Case("all-round", {"direction": 0.0, "spread": 360.0, "current": polar(0.25, -160.0)}),
        Case("broad-2", {"direction": -80.0, "spread": 120.0, "current": polar(0.15, 20.0)}, quick=False),
    ],
)
def check_sea(subject: Subject, case: Case) -> Outcome:
    """A broad sea, tapered, as in the field: whatever the algorithm, it is right within the resolution."""
    given = case.given
    cube = inputs.sea(given["direction"], given["spread"], UniformCurrent(given["current"]), realization=3)
    return each_method(subject, lambda method: in_the_mean(subject, cube, tapered(subject), method))
