"""P: peakedness (case-gamma; sec:peakedness).

Seven statements, P1 to P7, on seas that differ in gamma and spread.

- P1, P2: a larger gamma makes narrow seas worse, and wide ones hardly.
- P3: above 45 degrees of spread nothing changes any more, at this resolution.
- P4: untapered, nothing below the peak can be relied on.
- P5, P6: tapered, even the most peaked and narrow sea is below resolution, and the spread does not matter.
- P7: near the peak a larger gamma helps.
"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import combinations, pairwise, product

import numpy as np

from leakref.claims.configurations import GAMMAS, SPREADS, peaked, sea
from leakref.claims.evidence import Evidence
from leakref.claims.registry import claim
from leakref.claims.samples import (
    ABOVE,
    ALL,
    AWAY,
    BELOW,
    LEVELS,
    NEAR,
    RESOLUTIONS,
    STATISTICS,
    WINDOWS,
    bias,
    in_resolutions,
    influence,
    magnitude,
    random,
    ratio,
    smaller,
)
from leakref.claims.words import Reading, above, alike, below, both, either, every, pooled

_PARTS = {name.replace(" ", "_"): of for name, of in STATISTICS.items()}


@claim(
    "P1",
    "narrow spread: a larger gamma raises bias and random part at all k but near k = 1",
    "sec:peakedness",
    "Spread 15: both rise from gamma 1 to 7, or in each step 1, 3.3, 7, at every |k - 1| > 0.1, paired; untapered "
    "and Hann.",
    starts=True,
)
def _(see: Evidence) -> Iterator[Reading]:
    """The paper shows three values of gamma and speaks of a larger one: from the least to the largest, or by steps."""
    for words, steps in (("1 to 7", [(1.0, 7.0)]), ("each", list(pairwise(GAMMAS)))):
        for window in WINDOWS:
            yield from every(
                {"step": words, "window": window},
                **{
                    name: pooled(
                        *(
                            above((of(see(peaked(15, b), window)) - of(see(peaked(15, a), window))).at(AWAY))
                            for a, b in steps
                        )
                    )
                    for name, of in _PARTS.items()
                },
            )


@claim(
    "P2",
    "a wider spread removes most of that, especially at high k, where biases become sub-resolution",
    "sec:peakedness",
    "The rise of bias and random part from gamma 1 to 7, mean over |k - 1| > 0.1 in units of the smaller resolution, "
    "is at spread 60 less than half of that at 15; the share that is left is smaller at k > 1 than at k < 1; at "
    "spread 60 and k > 1 the mean of |c|, or mean + 2 sd, is below the smaller or larger resolution. Untapered and "
    "Hann.",
)
def _(see: Evidence) -> Iterator[Reading]:
    """Three parts that must hold together: most is removed, more of it at high wavenumbers, and there it is below
    resolution.
    """
    for window, level, resolution in product(WINDOWS, LEVELS, RESOLUTIONS):
        removed, better_high = [], []
        for of in STATISTICS.values():
            narrow, wide = (
                in_resolutions(of(strong) - of(see(peaked(spread, 1.0), window)), strong).at(AWAY)
                for spread, strong in ((spread, see(peaked(spread, 7.0), window)) for spread in (15, 60))
            )
            removed.append(above(0.5 * narrow.over() - wide.over()))
            low, high = (ratio(wide.over(band), narrow.over(band)) for band in (BELOW, ABOVE))
            better_high.append(above(low - high))
        ensembles = [see(peaked(60, gamma), window) for gamma in GAMMAS]
        fine = pooled(
            *(
                below(LEVELS[level](e).at(ABOVE), RESOLUTIONS[resolution](*e.resolutions)[ABOVE(e.wavenumbers)])
                for e in ensembles
            )
        )
        yield from every(
            {"window": window, "level": level, "resolution": resolution},
            most_removed=pooled(*removed),
            above_all_high_k=pooled(*better_high),
            sub_resolution=fine,
        )


@claim(
    "P3",
    "untapered, above 45 deg the DSVs no longer depend on the spread (this changes with resolution)",
    "sec:peakedness",
    "Bias and random part at spreads 45 and 60, or 60 and 90, do not differ significantly (theta0 = 60, gamma 3.3, "
    "L = 10); and the change of bias from 45 to 60, mean over shells in units of the smaller resolution, is another at "
    "L = 5 or at L = 20, by two standard errors.",
)
def _(see: Evidence) -> Iterator[Reading]:
    """That this changes with resolution is part of the statement, and is tested beside it at other lengths."""
    change = {}
    for length in (5.0, 10.0, 20.0):
        narrow, wide = (see(peaked(spread, 3.3, length), "box") for spread in (45, 60))
        change[length] = in_resolutions(bias(narrow) - bias(wide), narrow).over()
    off = pooled(*(above(magnitude(change[length] - change[10.0])) for length in (5.0, 20.0)))
    for words, (a, b) in (("45 and 60", (peaked(45), peaked(60))), ("60 and 90", (peaked(60), sea(60, 90)))):
        one, other = see(a, "box"), see(b, "box")
        same = pooled(*(alike(of(one) - of(other), smaller(one)) for of in STATISTICS.values()))
        for reading in either({"spreads": words}, independent=same):
            parts = {"independent": reading.holds, "changes_with_resolution": off.some}
            tallies = {"independent": same, "changes_with_resolution": off}
            figure = {name: tally.figure for name, tally in tallies.items()}
            yield Reading(reading.choices, both(*parts.values()), figure, tallies, parts)


@claim(
    "P4",
    "untapered, every DSV at k < 1 is unreliable",
    "sec:peakedness",
    "Unreliable: mean of |c|, or mean + 2 sd, above the smaller or larger resolution; all of the case; at every "
    "k < 1, or leaving out k about 1 (k < 0.9).",
)
def _(see: Evidence) -> Iterator[Reading]:
    """Whether k < 1 includes the neighbourhood of the peak is left open."""
    bands = {"k < 1": BELOW, "k < 0.9": lambda k: BELOW(k) & AWAY(k)}
    for (band, inside), level, resolution in product(bands.items(), LEVELS, RESOLUTIONS):
        ensembles = [see(peaked(spread, gamma), "box") for spread, gamma in product(SPREADS, GAMMAS)]
        yield from every(
            {"band": band, "level": level, "resolution": resolution},
            unreliable=pooled(
                *(
                    above(LEVELS[level](e).at(inside), RESOLUTIONS[resolution](*e.resolutions)[inside(e.wavenumbers)])
                    for e in ensembles
                )
            ),
        )


@claim(
    "P5",
    "with Hann, below resolution even for gamma = 7, spread 15 deg",
    "sec:peakedness",
    "Random and mean biases: mean and one, or two, sd of |c|, or mean + 2 sd, below the smaller or larger "
    "resolution at every shell.",
)
def _(see: Evidence) -> Iterator[Reading]:
    e = see(peaked(15, 7.0), "hann")
    levels = {
        "mean and 1 sd": [bias(e), random(e)],
        "mean and 2 sd": [bias(e), 2 * random(e)],
        "mean + 2 sd": [LEVELS["mean + 2 sd"](e)],
    }
    for (words, samples), resolution in product(levels.items(), RESOLUTIONS):
        limit = RESOLUTIONS[resolution](*e.resolutions)
        yield from every(
            {"level": words, "resolution": resolution},
            sub_resolution=pooled(*(below(s.at(ALL), limit) for s in samples)),
        )


@claim(
    "P6",
    "with Hann the dependence on the spread is effectively gone",
    "sec:peakedness",
    "Bias, or random part, at any two spreads 15 to 60, equal gamma: within 10 % of the smaller resolution of each "
    "other. Below the resolution itself they are in any case, since each of them is. Or at most 10 % is left of the "
    "root mean square of the untapered differences, as in G3.",
)
def _(see: Evidence) -> Iterator[Reading]:
    """Effectively gone is taken for less than what counts as significant, or for a tenth of what it is untapered."""
    steps = list(product(GAMMAS, combinations(SPREADS, 2)))
    pairs = {w: [(see(peaked(a, gamma), w), see(peaked(b, gamma), w)) for gamma, (a, b) in steps] for w in WINDOWS}
    for words, of in STATISTICS.items():
        same = pooled(*(alike(of(a) - of(b), smaller(a)) for a, b in pairs["hann"]))
        yield from either({"gone": "not significant", "statistic": words}, alike=same)
    for words, of in STATISTICS.items():
        left = ratio(influence(pairs["hann"], of), influence(pairs["box"], of))
        yield from every({"gone": "at most 10 % is left", "statistic": words}, little_left=below(left, 0.1**2))


@claim(
    "P7",
    "near k = 1 a larger gamma reduces the influence of leakage",
    "sec:peakedness",
    "Spread 15 degrees: bias at |k - 1| <= 0.1, or at k = 1 alone, falls from gamma 1 to 7, or in each step 1, 3.3, 7, "
    "paired; untapered and Hann.",
)
def _(see: Evidence) -> Iterator[Reading]:
    """The small range around the peak is a tenth about it, as *about* is, or the peak itself."""
    bands = {"0.9 to 1.1": NEAR, "1": lambda k: np.abs(k - 1) < 1e-6}
    steps = {"1 to 7": [(1.0, 7.0)], "each": list(pairwise(GAMMAS))}
    for window, (band, inside), (words, pairs) in product(WINDOWS, bands.items(), steps.items()):
        falls = [
            above((bias(see(peaked(15, a), window)) - bias(see(peaked(15, b), window))).at(inside)) for a, b in pairs
        ]
        yield from either({"window": window, "k": band, "step": words}, falls=pooled(*falls))
