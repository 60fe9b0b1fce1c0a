"""R: resolution in wavenumber and frequency (case-L-T; sec:resolution).

Nine statements, R1 to R9, on domains of different length and duration. Wavenumbers that two domains do not share are
left out of their comparison.

- R1, R6: finer resolution lowers biases, a larger domain more than a longer video.
- R2: the worst wavenumber moves up as the video gets shorter.
- R3: tapered, the duration hardly matters.
- R4: a long video of a small domain is worse than a short one.
- R5: tapered, all is well below the resolutions.
- R7: five periods do as well as ten.
- R8, R9: why the maximum moves, and why a long video of a small domain is worse: the width a.
"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import combinations, pairwise, product

import numpy as np

from leakref._base import FloatArray
from leakref.claims.configurations import LENGTHS, domain
from leakref.claims.evidence import Evidence, Setting
from leakref.claims.registry import claim
from leakref.claims.samples import ABOVE, ALL, LEVELS, RESOLUTIONS, STATISTICS, WINDOWS, Band, bias, magnitude, smaller
from leakref.claims.words import Reading, Tally, above, alike, below, either, every, pooled, positive, within
from leakref.ensemble import Ensemble

_DURATIONS = (10.0, 20.0, 80.0)
# twice the side against twice the duration; four times the area against four times the duration (L, T, factor)
_EXCHANGES = {
    "factor 2 in side, in duration": [(5.0, 10.0, 2), (10.0, 10.0, 2)],
    "factor 4 in area, in duration": [(5.0, 20.0, 4), (10.0, 20.0, 4)],
}


def _larger_helps_more(see: Evidence, window: str, exchange: str) -> Tally:
    """Bias after a larger domain is below that after a longer video; (20, 10) against (10, 20) and so on."""
    return pooled(
        *(
            above(
                bias(see(domain(length, factor * duration), window)) - bias(see(domain(2 * length, duration), window))
            )
            for length, duration, factor in _EXCHANGES[exchange]
        )
    )


@claim(
    "R1",
    "untapered, finer dk or finer domega lowers biases; dk matters more",
    "sec:resolution",
    "Bias falls with each step L 5, 10, 20 at equal T and T 10, 20, 80 at equal L, at the shells that both have; "
    "and is lower after twice the side than after twice the duration, or after four times the area than after four "
    "times the duration.",
)
def _(see: Evidence) -> Iterator[Reading]:
    """The exchange of side against duration is a choice: twice the side is four times the data."""
    finer_dk = [
        above(bias(see(domain(a, t), "box")) - bias(see(domain(b, t), "box")))
        for (a, b), t in product(pairwise(LENGTHS), _DURATIONS)
    ]
    finer_domega = [
        above(bias(see(domain(length, a), "box")) - bias(see(domain(length, b), "box")))
        for (a, b), length in product(pairwise(_DURATIONS), LENGTHS)
    ]
    for exchange in _EXCHANGES:
        yield from either(
            {"compared by": exchange},
            finer_dk=pooled(*finer_dk),
            finer_domega=pooled(*finer_domega),
            dk_more=_larger_helps_more(see, "box", exchange),
        )


def _peak(e: Ensemble, band: Band) -> FloatArray:
    """Wavenumber of the largest bias, and of that of 200 ensembles drawn from this one: (201,). The draws are the same
    for ensembles of one size, so that differences are paired.
    """
    sample = bias(e).at(band)
    draws = np.random.default_rng(0).integers(len(sample.values), size=(200, len(sample.values)))
    means = np.array([sample.mean, *(np.nanmean(sample.values[draw], axis=0) for draw in draws)])
    return sample.k[np.nanargmax(means, axis=1)]


@claim(
    "R2",
    "the maximum of the bias moves to higher k as T falls",
    "sec:resolution",
    "Untapered: the k of the largest bias, among all shells or those at k > 1 (where the paper explains it), rises "
    "with each step T 80, 20, 10, for every L; errors from 200 paired resamplings of the realisations.",
)
def _(see: Evidence) -> Iterator[Reading]:
    """A position of a maximum has no standard error of its own: it is that over resampled ensembles, paired."""
    for words, band in (("k > 1", ABOVE), ("all", ALL)):
        at = {(length, t): _peak(see(domain(length, t), "box"), band) for length, t in product(LENGTHS, _DURATIONS)}
        moves = np.array([at[length, a] - at[length, b] for length, (a, b) in product(LENGTHS, pairwise(_DURATIONS))])
        for reading in either(
            {"among": words}, moves=positive(np.zeros(len(moves)), moves[:, 0], moves[:, 1:].std(axis=1))
        ):
            k = {f"L={length:g}": [round(float(at[length, t][0]), 2) for t in _DURATIONS] for length in LENGTHS}
            yield reading.figured(**{"k at T 10, 20, 80": k})


@claim(
    "R3",
    "with Hann the influence of T is strongly reduced: curves of equal L lie together",
    "sec:resolution",
    "Differences of bias between T = 10, 20, 80 at equal L: under Hann smaller than untapered; and not significant, "
    "or smaller than those between neighbouring L at equal T.",
)
def _(see: Evidence) -> Iterator[Reading]:
    """Closer than others is measured against the nearest length there is on either side."""
    reduced, alone, closer = [], [], []
    for length, (a, b) in product(LENGTHS, combinations(_DURATIONS, 2)):
        box, hann = (bias(see(domain(length, a), w)) - bias(see(domain(length, b), w)) for w in WINDOWS)
        reduced.append(above(magnitude(box) - magnitude(hann)))
        alone.append(alike(hann, np.minimum(*(smaller(see(domain(length, t), "hann")) for t in (a, b)))))
        closer += [
            above(
                magnitude(bias(see(domain(length, a), "hann")) - bias(see(domain(other, a), "hann"))) - magnitude(hann)
            )
            for other in LENGTHS
            if other in (2 * length, length / 2)
        ]
    for words, together in (("not significantly different", alone), ("closer than other L", closer)):
        yield from either({"together": words}, reduced=pooled(*reduced), together=pooled(*together))


@claim(
    "R4",
    "L = 5, T = 80 is worse than L = 5 with T <= 40",
    "sec:resolution",
    "Bias, or random part, at T = 80 above that at T = 10, 20 and 40, paired. The text does not say whether tapered: "
    "both are parts, and each by itself a reading.",
)
def _(see: Evidence) -> Iterator[Reading]:
    """Longer is worse only where the width of G, which shrinks with the duration, becomes narrower than what leaks in
    wavenumber (R9). Where that is so is told by wavenumber.
    """
    for words, of in STATISTICS.items():
        worse = {
            window: pooled(
                *(
                    above(of(see(domain(5.0, 80.0), window)) - of(see(domain(5.0, t), window)))
                    for t in (10.0, 20.0, 40.0)
                )
            )
            for window in WINDOWS
        }
        yield from either({"statistic": words, "window": "both"}, untapered=worse["box"], tapered=worse["hann"])
        for window, tally in worse.items():
            yield from either({"statistic": words, "window": window}, worse=tally)


@claim(
    "R5",
    "with Hann every bias is well below the resolutions",
    "sec:resolution",
    "Mean of |c|, or mean + 2 sd, below the smaller or larger resolution by 10 % of it (significantly) at every "
    "shell of all of the case.",
)
def _(see: Evidence) -> Iterator[Reading]:
    """Well below is taken for below by a tenth of it, as *about* is within a tenth."""
    for (level, of), (resolution, choose) in product(LEVELS.items(), RESOLUTIONS.items()):
        ensembles = [see(domain(length, t), "hann") for length, t in product(LENGTHS, _DURATIONS)]
        yield from every(
            {"level": level, "resolution": resolution},
            well_below=pooled(*(below(of(e), 0.9 * choose(*e.resolutions)) for e in ensembles)),
        )


@claim(
    "R6",
    "a larger domain helps more than a longer video",
    "sec:resolution",
    "Bias after twice the side below that after twice the duration, or after four times the area below that after "
    "four times the duration; Hann, as the text has it there, and untapered.",
)
def _(see: Evidence) -> Iterator[Reading]:
    """Twice the side against twice the duration, or the same amount of data: the words leave that open. They follow
    on biases "provided the data is tapered"; untapered it is a part of R1.
    """
    for exchange, window in product(_EXCHANGES, reversed(WINDOWS)):
        yield from either(
            {"compared by": exchange, "window": window}, larger_domain=_larger_helps_more(see, window, exchange)
        )


@claim(
    "R7",
    "T = 5 shows no relevant difference from T = 10",
    "sec:resolution",
    "Difference of bias at equal L, paired: within 10 % of the smaller resolution at T = 10, untapered and Hann; or, "
    "untapered, below that resolution. Under Hann each of the two is below it, so that this could not fail.",
)
def _(see: Evidence) -> Iterator[Reading]:
    """Not significant, and significant but below the resolution, are two readings of *relevant*."""
    for window in WINDOWS:
        pairs = [(see(domain(length, 5.0), window), see(domain(length, 10.0), window)) for length in LENGTHS]
        insignificant = pooled(*(alike(bias(a) - bias(b), smaller(b)) for a, b in pairs))
        yield from either({"relevant": "over a tenth of the resolution", "window": window}, alike=insignificant)
        if window == "box":
            negligible = pooled(*(within(bias(a) - bias(b), smaller(b)) for a, b in pairs))
            yield from either({"relevant": "over the resolution", "window": window}, alike=negligible)


@claim(
    "R8",
    "the maximum moves with T because the width a = 4 domega of G does",
    "sec:resolution",
    "Untapered, T = 20 held fixed, a = 1, 4 and 8 domega, as wide as those of T = 80, 20 and 10 are: the k of the "
    "largest bias among k > 1, or among all shells, rises with each step, for every L or for L = 10; errors from 200 "
    "paired resamplings.",
)
def _(see: Evidence) -> Iterator[Reading]:
    """If the width is the cause, it moves the maximum while the data stay the same."""
    widths = (1.0, 4.0, 8.0)
    for (words, band), lengths in product((("k > 1", ABOVE), ("all", ALL)), (LENGTHS, (10.0,))):
        at = {
            (length, a): _peak(see(domain(length, 20.0), "box", setting=Setting(width=a)), band)
            for length, a in product(lengths, widths)
        }
        moves = np.array([at[length, b] - at[length, a] for length, (a, b) in product(lengths, pairwise(widths))])
        tally = positive(np.zeros(len(moves)), moves[:, 0], moves[:, 1:].std(axis=1))
        k = {f"L={length:g}": [round(float(at[length, a][0]), 2) for a in widths] for length in lengths}
        for reading in either({"among": words, "L": "5, 10, 20" if len(lengths) > 1 else "10"}, moves=tally):
            yield reading.figured(**{"k at a 1, 4, 8": k})


@claim(
    "R9",
    "L = 5, T = 80 is worse because G is too narrow",
    "sec:resolution",
    "Bias, or random part, at L = 5, T = 80 with a = 16 domega, as wide as at T = 20, below that with a = 4 domega; "
    "and not significantly above that at T = 20. Hann, of which the text speaks there, and untapered; paired.",
)
def _(see: Evidence) -> Iterator[Reading]:
    """If the width is what is wrong, another width mends it."""
    for window, (words, of) in product(("hann", "box"), STATISTICS.items()):
        narrow, wide = (see(domain(5.0, 80.0), window, setting=Setting(width=a)) for a in (4.0, 16.0))
        short = see(domain(5.0, 20.0), window)
        yield from either(
            {"window": window, "statistic": words},
            mended=above(of(narrow) - of(wide)),
            as_good_as_short=below(of(wide) - of(short), 0.1 * smaller(short)),
        )
