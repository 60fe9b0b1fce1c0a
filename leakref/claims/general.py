"""G: what is said of all cases together.

Eight statements, G1 to G8, of the abstract, the text and the conclusions. They are tested on all configurations of the
paper's table, or on those that they name.

- G1: narrower spectra have larger biases.
- G2: a window helps in nearly all cases.
- G3: a window against limited resolution in space and in time: two statements that contradict each other.
- G4: the resolutions are conservative bounds for tapered data.
- G5: biases are worst at low wavenumbers.
- G6: poor resolution makes narrow seas unusable.
- G7: turning the camera tells where leakage is.
- G8: spurious currents look like sheared ones.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import replace
from itertools import pairwise, product

import numpy as np
from scipy import stats

from leakref._base import FloatArray, mean_of_known
from leakref.cases import PAPER_CASES, Configuration
from leakref.claims.configurations import (
    DIRECTIONS,
    GAMMAS,
    LENGTHS,
    SPREADS,
    current,
    domain,
    narrow_domain,
    peaked,
    sea,
    turn,
)
from leakref.claims.evidence import Evidence
from leakref.claims.registry import claim
from leakref.claims.samples import (
    ABOVE,
    AWAY,
    BELOW,
    MEASURES,
    NEAR,
    RESOLUTIONS,
    WINDOWS,
    along,
    bias,
    deviation,
    in_resolutions,
    influence,
    missed,
    random,
    ratio,
    smaller,
)
from leakref.claims.words import Reading, Tally, above, below, both, either, every, pooled, positive


def _distinct(configurations: Iterable[Configuration]) -> tuple[Configuration, ...]:
    """Each sea once: some are of several cases, under other names.

    Counted by cases, the sea of theta0 = 90 and spread 60 degrees would speak five times. The first name is kept.
    """
    found: dict[str, Configuration] = {}
    for c in configurations:
        found.setdefault(repr(replace(c, case="", varied=())), c)
    return tuple(found.values())


_ALL = _distinct(c for members in PAPER_CASES.values() for c in members)
_STILL = tuple(c for c in _ALL if not c.speed)


@claim(
    "G1",
    "the narrower the spectrum in frequency or direction, the larger the biases",
    "abstract",
    "Bias falls with each step of spread 15, 30, 45, 60 (case-theta0-DeltaTheta) and rises with each step of gamma "
    "1, 3.3, 7 (case-gamma), paired; untapered and Hann.",
    starts=True,
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
    "in nearly all cases, that is about all, 90 %; cases counted as configurations (mean over shells in units of the "
    "smaller resolution) or as shells.",
)
def _(see: Evidence) -> Iterator[Reading]:
    """Nearly all is taken for nine in ten, as *about* is within a tenth."""
    for words, of in {**MEASURES, "random part": random}.items():
        gains = [of(see(one, "box")) - of(see(one, "hann")) for one in _ALL]
        whole = [in_resolutions(gain, see(one, "box")).over() for gain, one in zip(gains, _ALL, strict=True)]
        for counted, samples in (("configurations", whole), ("shells", gains)):
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


@claim(
    "G3",
    "a window mitigates limited resolution more effectively in space than in time (abstract); the influence "
    "of frequency resolution is nearly eliminated (sec:resolution, sec:conclusions)",
    "abstract, sec:conclusions",
    "Influence of L (steps 5, 10, 20 at equal T) and of T (10, 20, 80 at equal L): root mean square of the differences "
    "of bias in units of the smaller resolution of both. Abstract: a smaller share of that of L is left under Hann. "
    "Conclusions: at most 10 % of that of T is left, or less than a resolution. They contradict: two statements, each "
    "a part.",
)
def _(see: Evidence) -> Iterator[Reading]:
    """The abstract and the conclusions say opposite things of time and space, so that each is a part of its own: both
    can hardly hold.
    """
    durations = (10.0, 20.0, 80.0)
    in_space = [(domain(a, t), domain(b, t)) for (a, b), t in product(pairwise(LENGTHS), durations)]
    in_time = [(domain(length, a), domain(length, b)) for (a, b), length in product(pairwise(durations), LENGTHS)]
    space, time = (
        {w: influence([(see(a, w), see(b, w)) for a, b in pairs]) for w in WINDOWS} for pairs in (in_space, in_time)
    )
    left_space, left_time = (ratio(found["hann"], found["box"]) for found in (space, time))
    figure = {
        name: float(f"{np.sqrt(max(sample.mean[0], 0.0)):.3g}")
        for name, sample in (
            ("left_of_space", left_space),
            ("left_of_time", left_time),
            ("hann_time_in_resolutions", time["hann"]),
            ("hann_space_in_resolutions", space["hann"]),
        )
    }
    for words, gone in (
        ("at most 10 % of it is left", below(left_time, 0.1**2)),
        ("it is less than a resolution", below(time["hann"], 1.0)),
    ):
        yield from (
            reading.figured(**figure)
            for reading in every(
                {"nearly eliminated": words},
                abstract_more_in_space=above(left_time - left_space),
                conclusions_time_nearly_eliminated=gone,
            )
        )


@claim(
    "G4",
    "the two velocity resolutions are conservative measures of the errors of tapered data",
    "sec:conclusions",
    "Mean of |c| (with a current: against U, or of |c - U|), or mean + 2 sd, below the smaller or larger resolution "
    "under Hann; still water, or all cases.",
)
def _(see: Evidence) -> Iterator[Reading]:
    """Conservative is a bound that no error exceeds. Still water comes first, as the text derives it there; with a
    current the error is taken as the figures show it, and as a vector.
    """
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
    "Bias at k < 1, mean over shells in units of the smaller resolution, above that at |k - 1| <= 0.1 (the text: "
    "compared to the peak), or at k > 1; still water, counted by configuration; untapered and Hann.",
)
def _(see: Evidence) -> Iterator[Reading]:
    """Where k < 1 is compared with the peak, shells near the peak are on one side only."""
    bands = {"the peak": NEAR, "k > 1": ABOVE}
    for (words, band), window in product(bands.items(), WINDOWS):
        parts = []
        for one in _STILL:
            e = see(one, window)
            size = in_resolutions(bias(e), e)
            low = size.at(BELOW).at(AWAY) if band is NEAR else size.at(BELOW)  # no shell on both sides
            parts.append(above(low.over() - size.over(band)))
        yield from either({"compared to": words, "window": window}, low_is_worst=pooled(*parts))


@claim(
    "G6",
    "untapered, poorer resolution rapidly makes narrow, strongly directional seas unusable",
    "sec:conclusions",
    "theta0 = 60, spread 15: bias rises with each step L 20, 10, 5 (T = 20) and T 80, 20, 10 (L = 10); and at the "
    "poorest (L = 5; T = 10) it is unusable: above the smaller or larger resolution at most shells.",
    starts=True,
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
                {"rises": answer, "unusable": unusable.most},
            )


@claim(
    "G7",
    "turning the camera by 30 degrees reveals leakage",
    "sec:current, conclusions",
    "The change of the measured velocity on turning, turned back, ranks seas and shells by their true error: "
    "Spearman's correlation of the mean |c' - c| with the mean |c - U|, both in units of the smaller resolution, "
    "above 0.5, or above 0.7. Untapered and Hann; all shells of case-U (still water, crossing, following, opposing "
    "currents) and of theta0 = 60 with spreads 15 and 60; error by 200 resamplings of the realisations.",
)
def _(see: Evidence) -> Iterator[Reading]:
    """To reveal leakage a user must be able to tell from the change where the error is large."""
    for window, limit in product(WINDOWS, (0.5, 0.7)):
        changes, errors = [], []
        for one, other in _turned():
            e, turned = see(one, window), see(other, window)
            back = turned.velocities @ _rotation(30.0)
            moved = replace(missed(e), values=np.hypot(*np.moveaxis(back - e.velocities, -1, 0)))
            changes.append(in_resolutions(moved, e).values)
            errors.append(in_resolutions(missed(e), e).values)
        change, error = (np.concatenate(found, axis=1) for found in (changes, errors))
        draws = np.random.default_rng(0).integers(len(change), size=(200, len(change)))
        found = np.array([_rank_correlation(change[draw], error[draw]) for draw in (slice(None), *draws)])
        tally = positive(np.zeros(1), found[:1] - limit, found[1:].std(keepdims=True))
        for reading in every({"window": window, "ranks": f"above {limit}"}, ranked=tally):
            yield reading.figured(correlation=round(float(found[0]), 3))


def _turned() -> list[tuple[Configuration, Configuration]]:
    """Seas and the same turned by 30 degrees."""
    still = [(sea(60, spread), sea(60, spread, 30)) for spread in (15, 60)]
    currents = [(one, current(one.speed, one.current_direction, 30.0)) for one in (current(0.0), *turn(0.0))]
    return [*still, *currents]


def _rotation(degrees: float) -> FloatArray:
    """Of row vectors, backwards: v @ R is v turned by minus so many degrees."""
    angle = np.radians(degrees)
    return np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])


def _rank_correlation(change: FloatArray, error: FloatArray) -> float:
    """Spearman's, of the means over realisations."""
    return float(stats.spearmanr(mean_of_known(change), mean_of_known(error), nan_policy="omit").statistic)


@claim(
    "G8",
    "spurious currents vary with k as a sheared current would",
    "sec:NSP_and_leakage, sec:conclusions",
    "Untapered, or Hann, in still water at theta0 = 90: the component along the waves, mean over k = 0.5 to 1 less "
    "that over k = 1 to 3, is above the mean smaller resolution of the first, as of a current that weakens towards "
    "the surface or grows with depth; spread 15, or all spreads.",
)
def _(see: Evidence) -> Iterator[Reading]:
    """Long waves feel the current farther down, so that a Doppler shift that changes with k is read as shear."""
    for window, (words, spreads) in product(WINDOWS, (("15", SPREADS[:1]), ("15 to 60", SPREADS))):
        varies = []
        for spread in spreads:
            e = see(sea(90, spread), window)
            shift = along(e, 90)
            limit = float(smaller(e)[BELOW(e.wavenumbers)].mean())
            varies.append(above(shift.over(BELOW) - shift.over(lambda k: ABOVE(k) & (k <= 3 + 1e-9)), limit))
        yield from every({"window": window, "spread": words}, varies=pooled(*varies))
