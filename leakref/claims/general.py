"""G: what is said of all cases together.

Six statements, G1 to G6, of the abstract and the conclusions. They are tested on all configurations of the paper's
table, or on those that they name.

- G1: narrower spectra have larger biases.
- G2: a window helps in nearly all cases.
- G3: a window against limited resolution in space and in time: two statements that contradict each other.
- G4: the resolutions are conservative bounds for tapered data.
- G5: biases are worst at low wavenumbers.
- G6: poor resolution makes narrow seas unusable.
"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import pairwise, product

from leakref.cases import PAPER_CASES, Configuration
from leakref.claims.configurations import DIRECTIONS, GAMMAS, LENGTHS, SPREADS, domain, narrow_domain, peaked, sea
from leakref.claims.evidence import Evidence
from leakref.claims.registry import claim
from leakref.claims.words import (
    ABOVE,
    AWAY,
    BELOW,
    MEASURES,
    NEAR,
    RESOLUTIONS,
    WINDOWS,
    Reading,
    Sample,
    Tally,
    above,
    below,
    bias,
    both,
    deviation,
    either,
    magnitude,
    missed,
    pooled,
    random,
    ratio,
    smaller,
)

_ALL = tuple(c for members in PAPER_CASES.values() for c in members)
_STILL = tuple(c for c in _ALL if not c.speed)


@claim(
    "G1",
    "the narrower the spectrum in frequency or direction, the larger the biases",
    "abstract",
    "Bias falls with each step of spread 15, 30, 45, 60 (case-theta0-DeltaTheta) and rises with each step of gamma "
    "1, 3.3, 7 (case-gamma), paired; untapered and Hann.",
)
def _(see: Evidence) -> Iterator[Reading]:
    """Direction and frequency are two parts of one reading: either alone is not what is said."""
    for window in WINDOWS:
        direction = [
            above(bias(see(sea(angle, a), window)) - bias(see(sea(angle, b), window)))
            for angle, (a, b) in product(DIRECTIONS, pairwise(SPREADS))
        ]
        frequency = [
            above(bias(see(peaked(spread, b), window)) - bias(see(peaked(spread, a), window)))
            for spread, (a, b) in product(SPREADS, pairwise(GAMMAS))
        ]
        yield from either({"window": window}, direction=pooled(*direction), frequency=pooled(*frequency))


@claim(
    "G2",
    "a window reduces the severity in nearly all cases",
    "abstract",
    "Bias (with a current: mean of |c| against U, or of |c - U|), or random part, under Hann below that untapered "
    "in nearly all cases, that is about all, 90 %; cases counted as configurations (mean over shells) or as shells.",
)
def _(see: Evidence) -> Iterator[Reading]:
    """Nearly all is taken for nine in ten, as *about* is within a tenth."""
    for words, of in {**MEASURES, "random part": random}.items():
        gains = [of(see(one, "box")) - of(see(one, "hann")) for one in _ALL]
        for counted, samples in (("configurations", [gain.over() for gain in gains]), ("shells", gains)):
            reduced = pooled(*map(above, samples))
            yield Reading(
                {"severity": words, "counted by": counted}, _nearly_all(reduced), reduced.figure, {"reduced": reduced}
            )


def _nearly_all(tally: Tally) -> bool | None:
    """Shown in nine cases of ten, or open if those that are open could make it so."""
    shown, open_ones = int(tally.shown.sum()), int((~tally.shown & ~tally.contradicted).sum())
    if shown >= 0.9 * tally.size:
        return True
    return None if shown + open_ones >= 0.9 * tally.size else False


def _influence(see: Evidence, window: str, pairs: list[tuple[Configuration, Configuration]]) -> Sample:
    """Mean size of the differences of bias between configurations that differ in resolution."""
    parts = [magnitude(bias(see(a, window)) - bias(see(b, window))).over() for a, b in pairs]
    total = parts[0]
    for part in parts[1:]:
        total = total + part
    return 1 / len(parts) * total


@claim(
    "G3",
    "a window mitigates limited resolution more effectively in space than in time (abstract); the influence "
    "of frequency resolution is nearly eliminated (sec:resolution, sec:conclusions)",
    "abstract, sec:conclusions",
    "Influence of L (steps 5, 10, 20 at equal T) and of T (10, 20, 80 at equal L): mean size of the differences of "
    "bias. Abstract: a smaller share of that of L is left under Hann. Conclusions: at most 10 % of that of T is "
    "left, or less than the smaller resolution at the peak for L = 20, T = 80. They contradict: two statements.",
)
def _(see: Evidence) -> Iterator[Reading]:
    """The abstract and the conclusions say opposite things of time and space, so that each is a reading of its own, and
    no reading can make both hold.
    """
    durations = (10.0, 20.0, 80.0)
    in_space = [(domain(a, t), domain(b, t)) for (a, b), t in product(pairwise(LENGTHS), durations)]
    in_time = [(domain(length, a), domain(length, b)) for (a, b), length in product(pairwise(durations), LENGTHS)]
    space, time = ({w: _influence(see, w, pairs) for w in WINDOWS} for pairs in (in_space, in_time))
    left_space, left_time = (ratio(found["hann"], found["box"]) for found in (space, time))
    finest = min(float(x) for x in (1 / 80, 0.5 / 20))  # domega / k and c_g dk / k at k = 1
    figure = {
        "left_of_space": float(f"{left_space.mean[0]:.3g}"),
        "left_of_time": float(f"{left_time.mean[0]:.3g}"),
        "hann_time_c0": float(f"{time['hann'].mean[0]:.3g}"),
        "hann_space_c0": float(f"{space['hann'].mean[0]:.3g}"),
    }
    for words, tally in (
        ("abstract: more in space", above(left_time - left_space)),
        ("conclusions: at most 10 % of time is left", below(left_time, 0.1)),
        ("conclusions: time matters less than a resolution", below(time["hann"], finest)),
    ):
        yield Reading({"statement": words}, tally.every, figure, {"holds": tally})


@claim(
    "G4",
    "the two velocity resolutions are conservative measures of the errors of tapered data",
    "sec:conclusions",
    "Mean of |c| (with a current: against U, or of |c - U|), or mean + 2 sd, below the smaller or larger resolution "
    "under Hann; still water, or all cases.",
)
def _(see: Evidence) -> Iterator[Reading]:
    seas = {"still water": _STILL, "all": _ALL}
    measures = {**MEASURES, "mean + 2 sd of |c - U|": lambda e: missed(e) + 2 * deviation(missed(e))}
    for (cases, members), (words, of), (resolution, choose) in product(
        seas.items(), measures.items(), RESOLUTIONS.items()
    ):
        yield from either(
            {"cases": cases, "error": words, "resolution": resolution},
            conservative=pooled(
                *(below(of(see(one, "hann")), choose(*see(one, "hann").resolutions)) for one in members)
            ),
        )


@claim(
    "G5",
    "biases are most severe at low wavenumbers",
    "sec:conclusions",
    "Bias at k < 1, mean over shells, above that at |k - 1| <= 0.1 (the text: compared to the peak), or at k > 1; "
    "in c0 or in units of the smaller resolution; still water, counted by configuration; untapered and Hann.",
)
def _(see: Evidence) -> Iterator[Reading]:
    """Where k < 1 is compared with the peak, shells near the peak are on one side only."""
    bands = {"the peak": NEAR, "k > 1": ABOVE}
    for unit, (words, band), window in product(("c0", "the resolution"), bands.items(), WINDOWS):
        parts = []
        for one in _STILL:
            e = see(one, window)
            size = bias(e) if unit == "c0" else 1 / smaller(e) * bias(e)
            low = size.at(BELOW).at(AWAY) if band is NEAR else size.at(BELOW)  # no shell on both sides
            parts.append(above(low.over() - size.over(band)))
        yield from either({"unit": unit, "compared to": words, "window": window}, low_is_worst=pooled(*parts))


@claim(
    "G6",
    "untapered, poorer resolution rapidly makes narrow, strongly directional seas unusable",
    "sec:conclusions",
    "theta0 = 60, spread 15: bias rises with each step L 20, 10, 5 (T = 20) and T 80, 20, 10 (L = 10); and at the "
    "poorest (L = 5; T = 10) it is unusable: above the smaller or larger resolution at most shells.",
)
def _(see: Evidence) -> Iterator[Reading]:
    """The rise is tested between neighbours, that it is unusable at the poorest resolution only."""
    of_length = [narrow_domain(20.0, 20.0), sea(60, 15), narrow_domain(5.0, 20.0)]
    of_duration = [narrow_domain(10.0, 80.0), sea(60, 15), narrow_domain(10.0, 10.0)]
    for (words, series), (resolution, choose) in product(
        {"length": of_length, "duration": of_duration}.items(), RESOLUTIONS.items()
    ):
        worse = pooled(*(above(bias(see(b, "box")) - bias(see(a, "box"))) for a, b in pairwise(series)))
        poorest = see(series[-1], "box")
        unusable = above(bias(poorest), choose(*poorest.resolutions))
        for holds_at, answer in (("every shell", worse.every), ("most shells", worse.most)):
            yield Reading(
                {"poorer": words, "resolution": resolution, "rises at": holds_at},
                both(answer, unusable.most),
                {"rises": worse.figure, "unusable": unusable.figure},
                {"rises": worse, "unusable": unusable},
            )
