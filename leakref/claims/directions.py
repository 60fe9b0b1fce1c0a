"""A: direction and spread (case-theta0-DeltaTheta; sec:NSP_and_leakage, sec:DSV_example, sec:angwidth).

Sixteen statements, A1 to A16, each a predicate that yields readings; what is tested is said in its registration. Their
seas differ in direction and spread alone, so that realisations are compared in pairs with the same phases.

- A1, A2: untapered, the mean velocity points along the waves below the peak and against them above.
- A3: for oblique narrow seas it is the component across the waves that dominates above the peak.
- A4, A5: a wider spread lowers bias and random part, up to 60 degrees.
- A6: near the peak spurious velocities are negligible.
- A7, A11: untapered the direction matters, most at 45 degrees; tapered much less.
- A8: a taper helps less below the peak than above.
- A9: turned videos are like seas that go that way.
- A10, A13: tapered narrow seas, and wide ones, are below the resolutions.
- A12: how large biases can get.
- A14: leakage from the peak that misses the cylinder does no harm.
- A15: under Hann the frequency found lies between those of two neighbours.
- A16: in narrow seas the score is soft across the waves.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from itertools import combinations, pairwise, product

import numpy as np

from leakref._base import FloatArray
from leakref.claims.configurations import CLEAR_OF_PEAK, DIRECTIONS, GAMMAS, ROTATIONS, SPREADS, WIDER, peaked, sea
from leakref.claims.evidence import Evidence, Setting, peak_waves
from leakref.claims.registry import SMALLEST, claim
from leakref.claims.samples import (
    ABOVE,
    AWAY,
    BELOW,
    LEVELS,
    NEAR,
    RESOLUTIONS,
    STATISTICS,
    WINDOWS,
    Sample,
    across,
    along,
    bias,
    in_resolutions,
    magnitude,
    ratio,
    smaller,
    squared,
)
from leakref.claims.words import Mask, Reading, above, alike, below, either, every, pooled, significant
from leakref.dispersion import DEEP


@claim(
    "A1",
    "theta0 = 90 deg, untapered, k < 1: the mean DSV points along the waves",
    "sec:NSP_and_leakage",
    "Component of the mean vector along 90 deg above zero, for each spread.",
)
def _(see: Evidence) -> Iterator[Reading]:
    for spread in SPREADS:
        yield from either({"spread": f"{spread:g}"}, along=above(along(see(sea(90, spread), "box"), 90).at(BELOW)))


@claim(
    "A2",
    "theta0 = 90 deg, untapered, k > 1: the mean DSV points against the waves",
    "sec:NSP_and_leakage",
    "Component of the mean vector along 90 deg below zero, for each spread.",
)
def _(see: Evidence) -> Iterator[Reading]:
    for spread in SPREADS:
        yield from either({"spread": f"{spread:g}"}, against=below(along(see(sea(90, spread), "box"), 90).at(ABOVE)))


@claim(
    "A3",
    "0 < theta0 < 90 deg, untapered, narrow spread, k > 1: the component across the waves dominates, the one "
    "along them is near zero",
    "sec:NSP_and_leakage",
    "Size across theta0 above size along it, and that along below the smaller resolution; sizes of the mean vector, "
    "or means of sizes. Spread 15, theta0 = 45, 60, 75 deg together.",
    starts=True,
)
def _(see: Evidence) -> Iterator[Reading]:
    """Sizes of means and means of sizes differ where a component changes its sign from sea to sea: so both are
    readings.
    """
    ensembles = {angle: see(sea(angle, 15), "box") for angle in (45.0, 60.0, 75.0)}

    def mean_of_sizes(sample: Sample) -> Sample:
        return Sample(sample.k, np.abs(sample.values))

    for words, size in (("mean vector", magnitude), ("each DSV", mean_of_sizes)):
        lengthwise, sideways = (
            {angle: size(of(e, angle)).at(ABOVE) for angle, e in ensembles.items()} for of in (along, across)
        )
        yield from either(
            {"component of": words},
            across_dominates=pooled(*(above(sideways[a] - lengthwise[a]) for a in ensembles)),
            along_near_zero=pooled(
                *(below(lengthwise[a], smaller(e)[ABOVE(e.wavenumbers)]) for a, e in ensembles.items())
            ),
        )


@claim(
    "A4",
    "a wider spread lowers bias and random part at every k",
    "sec:angwidth",
    "Each falls from a narrower to a wider spread at every shell, paired; theta0 = 60, 75, 90. In the steps 15, 30, "
    "45, 60 deg, or from 15 to 60, the two that are shown; untapered and Hann.",
    starts=True,
)
def _(see: Evidence) -> Iterator[Reading]:
    for words, steps in (("15 to 60", [(15, 60)]), ("each", list(pairwise(SPREADS)))):
        for window in WINDOWS:
            yield from every(
                {"step": words, "window": window},
                **{
                    name.replace(" ", "_"): pooled(
                        *(
                            above(of(see(sea(angle, narrow), window)) - of(see(sea(angle, wide), window)))
                            for angle, (narrow, wide) in product(DIRECTIONS, steps)
                        )
                    )
                    for name, of in STATISTICS.items()
                },
            )


@claim(
    "A5",
    "beyond 60 deg no notable further improvement",
    "sec:angwidth",
    "Bias, or random part, at 75, 90 and 120 deg below that at 60 by less than 10 % of the smaller resolution, paired; "
    "theta0 = 60, 75, 90; untapered and Hann.",
)
def _(see: Evidence) -> Iterator[Reading]:
    """A change for the worse is no improvement, however large it is."""
    for (words, of), window in product(STATISTICS.items(), WINDOWS):
        parts = []
        for angle, wide in product(DIRECTIONS, WIDER):
            e = see(sea(angle, 60), window)
            parts.append(below(of(e) - of(see(sea(angle, wide), window)), 0.1 * smaller(e)))
        yield from either({"statistic": words, "window": window}, no_improvement=pooled(*parts))


@claim(
    "A6",
    "around k = 1 spurious DSVs are negligible in every case",
    "sec:angwidth",
    "Mean of |c|, or mean + 2 sd, below the smaller resolution at |k - 1| <= 0.1, or at k = 1 alone, in all of the "
    "case; untapered and Hann.",
)
def _(see: Evidence) -> Iterator[Reading]:
    """The peak alone, or a tenth about it, is what *around* may mean."""
    bands = {"0.9 to 1.1": NEAR, "1": lambda k: np.abs(k - 1) < 1e-6}
    for (level, of), window, (band, inside) in product(LEVELS.items(), WINDOWS, bands.items()):
        ensembles = [see(sea(angle, spread), window) for angle, spread in product(DIRECTIONS, SPREADS)]
        yield from every(
            {"level": level, "window": window, "k": band},
            negligible=pooled(*(below(of(e).at(inside), smaller(e)[inside(e.wavenumbers)]) for e in ensembles)),
        )


@claim(
    "A7",
    "untapered, theta0 matters strongly; tapered, its influence is greatly reduced",
    "sec:DSV_example",
    "Differences between theta0 = 60, 75, 90 at equal spread: untapered significant; under Hann less than half of "
    "those untapered. Root mean square over shells in units of the smaller resolution, or shell by shell.",
)
def _(see: Evidence) -> Iterator[Reading]:
    """Reduced greatly is taken for reduced by more than half, as *most* is over half."""
    for words, of in STATISTICS.items():
        matters, reduced, together = [], [], []
        for (a, b), spread in product(combinations(DIRECTIONS, 2), SPREADS):
            first, second = ({w: see(sea(angle, spread), w) for w in WINDOWS} for angle in (a, b))
            box, hann = (of(first[w]) - of(second[w]) for w in WINDOWS)
            limit = smaller(first["box"])
            matters.append(significant(box, limit))
            reduced.append(above(0.5 * magnitude(box) - magnitude(hann)))
            squares = [squared(in_resolutions(d, first["box"])).over() for d in (box, hann)]
            together.append((above(squares[0], 0.1**2), above(0.5**2 * squares[0] - squares[1])))
        overall, less = (pooled(*some) for some in zip(*together, strict=True))
        yield from every({"statistic": words, "holds at": "shells together"}, untapered_matters=overall, reduced=less)
        yield from either({"statistic": words}, untapered_matters=pooled(*matters), reduced=pooled(*reduced))


@claim(
    "A8",
    "Hann helps less for k < 1 than for k > 1",
    "sec:DSV_example",
    "Help is the share of the untapered bias that Hann removes, or the amount, mean over the shells of a band in units "
    "of the smaller resolution; for all of the case, counted by configuration.",
)
def _(see: Evidence) -> Iterator[Reading]:
    """What is left is the ratio of the biases, so that the band where it is larger is the one that is helped less."""
    share, amount = [], []
    for angle, spread in product(DIRECTIONS, SPREADS):
        box, hann = (in_resolutions(bias(e), e) for e in (see(sea(angle, spread), window) for window in WINDOWS))
        share.append(above(ratio(hann.over(BELOW), box.over(BELOW)) - ratio(hann.over(ABOVE), box.over(ABOVE))))
        amount.append(below((box - hann).over(BELOW) - (box - hann).over(ABOVE)))
    for words, found in (("share", share), ("amount", amount)):
        yield from either({"help": words}, helps_less=pooled(*found))


@claim(
    "A9",
    "rotated videos: results with equal theta0 + theta_rot do not differ significantly",
    "sec:angwidth",
    "Bias and random part of seas at theta0 turned by theta_rot (60 + 15, 60 + 30, 75 + 15, 45 + 45) against those "
    "at the sum, spreads 15 and 60. Resampled images: 5 realisations of 60 + 30 deg with spread 60, L = 10, T = 20, "
    "each image turned by cubic splines and cropped from a larger one, against the same sea turned exactly.",
)
def _(see: Evidence) -> Iterator[Reading]:
    """Turned seas need no images; for turned images the camera sees a larger square, and few realisations must do."""
    for window in WINDOWS:
        same = []
        for (angle, turn), spread, of in product(ROTATIONS, (15, 60), STATISTICS.values()):
            turned, straight = see(sea(angle, spread, turn), window), see(sea(angle + turn, spread), window)
            same.append(alike(of(turned) - of(straight), smaller(straight)))
        yield from either({"turned": "sea", "window": window}, alike=pooled(*same))
        one = sea(60, 60, 30)
        images, exact = see(one, window, setting=Setting(resampled=True)), see(one, window)
        yield from either(
            {"turned": "images", "window": window}, alike=alike(bias(images) - bias(exact), smaller(exact))
        )


@claim(
    "A10",
    "with Hann, even narrow spectra are below both resolutions",
    "sec:angwidth",
    "Mean of |c|, or mean + 2 sd, below the smaller resolution at every shell; spread 15, theta0 = 60, 75, 90.",
)
def _(see: Evidence) -> Iterator[Reading]:
    """All shells are meant, so that there is no reading of most of them."""
    for level, of in LEVELS.items():
        ensembles = [see(sea(angle, 15), "hann") for angle in DIRECTIONS]
        yield from every({"level": level}, sub_resolution=pooled(*(below(of(e), smaller(e)) for e in ensembles)))


@claim(
    "A11",
    "untapered biases grow towards theta0 = 45 deg, away from the peak",
    "sec:conclusions",
    "Bias rises with each step 90, 75, 60, 45 deg, or from 90 to 45, at |k - 1| > 0.1; all spreads together.",
    starts=True,
)
def _(see: Evidence) -> Iterator[Reading]:
    for words, steps in (("90 to 45", [(90, 45)]), ("each", list(pairwise((90, 75, 60, 45))))):
        grows = [
            above((bias(see(sea(b, spread), "box")) - bias(see(sea(a, spread), "box"))).at(AWAY))
            for (a, b), spread in product(steps, SPREADS)
        ]
        yield from either({"step": words}, grows=pooled(*grows))


@claim(
    "A12",
    "without current, untapered biases can reach a significant fraction of the peak phase velocity; for "
    "spreads below 60 deg, the order of the group velocity",
    "abstract, sec:conclusions",
    "Largest bias of all seas of case-theta0-DeltaTheta and case-gamma over 10 % of c0; the largest for each spread "
    "below 60 deg over the group velocity, at the shell or of the peak, is 1 within a factor of 2.",
)
def _(see: Evidence) -> Iterator[Reading]:
    """Of each spread the sea and the shell with the largest share stand for all, since the statement is about what can
    be reached.
    """
    seas = {
        spread: [
            see(one, "box")
            for one in (*(sea(a, spread) for a in DIRECTIONS), *(peaked(spread, gamma) for gamma in GAMMAS))
        ]
        for spread in SPREADS
    }
    largest = max((e for members in seas.values() for e in members), key=lambda e: float(np.nanmax(e.bias)))
    top = int(np.nanargmax(largest.bias))
    reach = bias(largest).at(lambda k: k == largest.wavenumbers[top])
    for words in ("at the shell", "of the peak"):
        order = []
        for spread in SPREADS[:-1]:
            shares = [bias(e).at(lambda k: k > 0) for e in seas[spread]]
            speeds = [DEEP.group_velocity(s.k if words == "at the shell" else np.ones_like(s.k)) for s in shares]
            s, speed = max(zip(shares, speeds, strict=True), key=lambda pair: float(np.nanmax(pair[0].mean / pair[1])))
            best = s.k == s.k[np.nanargmax(s.mean / speed)]
            share = Sample(s.k[best], s.values[:, best] / speed[best])
            order += [above(share, 0.5), below(share, 2.0)]
        yield from every(
            {"group velocity": words}, a_fraction_of_c0=above(reach, 0.1), order_of_group_velocity=pooled(*order)
        )


@claim(
    "A13",
    "for spreads above 60 deg spurious DSVs are below resolution",
    "sec:conclusions",
    "Mean of |c|, or mean + 2 sd, below the smaller or larger resolution; spreads 75, 90, 120, theta0 = 60, 75, 90; "
    "untapered and Hann.",
)
def _(see: Evidence) -> Iterator[Reading]:
    """Wider seas than the paper's table has."""
    for level, resolution, window in product(LEVELS, RESOLUTIONS, WINDOWS):
        ensembles = [see(sea(angle, spread), window) for angle, spread in product(DIRECTIONS, WIDER)]
        yield from either(
            {"level": level, "resolution": resolution, "window": window},
            sub_resolution=pooled(
                *(below(LEVELS[level](e), RESOLUTIONS[resolution](*e.resolutions)) for e in ensembles)
            ),
        )


@claim(
    "A14",
    "0 < theta0 < 90 deg, k < 1: leakage from the peak may have no axis-parallel projection on the cylinder; "
    "then it does not affect the DSV",
    "sec:NSP_and_leakage",
    "theta0 = 45, spread 15, L = 20, T = 20, at the shells that no line along an axis from a wave within 10 % of "
    "k = 1 meets: those waves left out, paired, the mean change of the DSV is below 10 % of the smaller resolution "
    "(not significant), or below it (negligible). The change at theta0 = 90 is given beside it.",
    smallest=0.0,  # no shell above 0.5 is clear of the peak
)
def _(see: Evidence) -> Iterator[Reading]:
    """Leaving out the waves of the peak and pairing with the whole sea shows what comes from the peak alone, at shells
    where the geometry says that nothing should.
    """
    waves = CLEAR_OF_PEAK.components(0)
    peak = peak_waves(waves)
    nearest = float(min(np.abs(waves.kx[peak]).min(), np.abs(waves.ky[peak]).min()))
    width = 2 * CLEAR_OF_PEAK.grid.wavenumber_resolution
    for window, (words, part) in product(WINDOWS, (("10 % of the resolution", 0.1), ("the resolution", 1.0))):
        changes = []
        for one in (CLEAR_OF_PEAK, replace(CLEAR_OF_PEAK, direction=90.0)):
            whole, rest = see(one, window), see(one, window, setting=Setting(without_peak=True))
            moved = Sample(whole.wavenumbers, np.hypot(*np.moveaxis(whole.velocities - rest.velocities, -1, 0)))
            changes.append(moved.at(lambda k: k + width < nearest))
        limit = part * smaller(whole)[whole.wavenumbers + width < nearest]
        for reading in every({"window": window, "no effect": f"below {words}"}, unaffected=below(changes[0], limit)):
            yield Reading(
                reading.choices,
                reading.holds,
                {
                    "shells": changes[0].k.size,
                    "change_over_limit": [float(f"{x:.3g}") for x in changes[0].mean / limit],
                    "change_over_limit_at_90": [float(f"{x:.3g}") for x in changes[1].mean / limit],
                },
                reading.tallies,
            )


@claim(
    "A15",
    "under Hann at k about 0.6 the frequency found lies between omega0(k) and omega0(k + dk)",
    "sec:DSV_example",
    "omega0(k) + k times the component along the waves of the mean velocity, or of each, at |k - 0.6| <= 0.06: above "
    "omega0(k) and below omega0(k + dk), dk = 1/L. Spread 15 degrees, where the effect is largest; theta0 = 60, 75, "
    "90; or all spreads of the case.",
)
def _(see: Evidence) -> Iterator[Reading]:
    """In still water the whole shift is spurious."""

    def about(k: FloatArray) -> Mask:
        return np.abs(k - 0.6) <= 0.06 + 1e-9

    for words, spreads in (("15", SPREADS[:1]), ("15 to 60", SPREADS)):
        low, high = [], []
        for angle, spread in product(DIRECTIONS, spreads):
            one = sea(angle, spread)
            shift = along(see(one, "hann"), angle).at(about)
            dk = one.grid.wavenumber_resolution
            room = (DEEP.frequency(shift.k + dk) - DEEP.frequency(shift.k)) / shift.k
            low.append(above(shift))
            high.append(below(shift, room))
        yield from every({"spread": words}, above_the_shell_s_own=pooled(*low), below_the_neighbour_s=pooled(*high))


@claim(
    "A16",
    "in narrow seas the current across the waves is the soft component",
    "sec:angwidth",
    "The curvature of log N at its maximum, across the waves over along them, under Hann: below 1 at every shell for "
    "spread 15 degrees, and less than at spread 30, that than at 45, that than at 60. theta0 = 90, or 60; 12 "
    "realisations by the literal chain.",
)
def _(see: Evidence) -> Iterator[Reading]:
    """A maximum that is flat across the waves lets any false intensity move it that way."""
    for angle in (90.0, 60.0):
        softness = {
            spread: Sample(one.wavenumbers, see.softness(one), f"spread {spread:g}").at(lambda k: k >= SMALLEST - 1e-9)
            for spread, one in ((spread, sea(angle, spread)) for spread in SPREADS)
        }
        yield from either(
            {"theta0": f"{angle:g}"},
            soft_across=below(softness[15.0], 1.0),
            softer_when_narrower=pooled(*(above(softness[b] - softness[a]) for a, b in pairwise(SPREADS))),
        )
