"""Random seas from parameters: what a generator that takes no list of waves makes, in the mean over realisations.

Nothing of such a sea is known sample by sample. Its energy, how that is spread over wavenumbers and directions, how the
waves move, and that chance has its part in it are measured in `COUNT` realisations, and held against the same measures
of leakref's own seas, made from the same parameters with waves between the bins and amplitudes drawn like phases: the
sea whose measures scatter most. What one realisation scatters by decides how far the mean of many may be off.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy.special import ndtri

from leakref.certify.checks import inputs
from leakref.certify.checks.draw import asked_seed, drawing
from leakref.certify.checks.inputs import polar
from leakref.certify.checks.registry import Case, Outcome, check
from leakref.certify.checks.seameasures import (
    BANDS,
    COUNT,
    STATEMENTS,
    STRONG,
    Measured,
    added,
    apart,
    collected,
    correlated,
    measure,
    own,
)
from leakref.certify.checks.statistics import FALSE_ALARMS
from leakref.certify.subject.frames import Subject
from leakref.certify.subject.seas import Sea
from leakref.certify.verdict import Unanswered, Verdict
from leakref.currents import UniformCurrent
from leakref.grid import Grid

__all__ = [
    "CASES",
    "asked_of",
    "check_amplitudes",
    "check_backwards",
    "check_directions",
    "check_energy",
    "check_motion",
    "check_phases",
    "check_realizations",
    "check_repeats",
    "check_spectrum",
    "check_spread",
]

GRID = Grid((74, 70, 40), (0.85, 0.88, 1.0))
"""Ten peak wavelengths by six periods, enough for waves 3.5 times as short as those of the peak."""
_VARIANCE = 6e-4  # a significant height of a tenth of 1 / k0
_SEEDS = 2 * 10**9  # below which every generator of random numbers takes one
_AGAIN = 1e-9  # of the deviation: two surfaces of one seed

CASES = [
    Case("broad", {"direction": 30.0, "spread": 100.0, "peakedness": 3.3, "current": polar(0.2, -35.0)}),
    Case(
        "peaked", {"direction": -115.0, "spread": 60.0, "peakedness": 7.0, "current": polar(0.2, 100.0), "depth": 0.7}
    ),
]
CHANCE = (
    f"In the mean over {COUNT} realisations it may differ from leakref's own seas by {{}}, and by what chance does to "
    "such means: Student's t of the scatter of single realisations, two-sided, so that all statements of a run about "
    "chance together reject a right generator once in a thousand runs."
)


def asked_of(subject: Subject, case: Case, *told: str) -> Sea:
    """The sea of a case, in the water that the code knows; still water for one that cannot be told a current. Raises
    Unanswered (unsupported) for one that offers no seas, or cannot be `told` what the question is about.
    """
    if not subject.offers("sea"):
        raise Unanswered(Verdict.UNSUPPORTED, "does not offer sea")
    for name in ("peak", *told):
        if name in subject.declaration.untold:
            raise Unanswered(Verdict.UNSUPPORTED, f"cannot be told the {name} of a sea")
    given, draw, water = case.given, drawing(), inputs.still()
    if "depth" in given and "depth" in subject.told:
        water = replace(water, depth=float(given["depth"]))
    current = UniformCurrent((0.0, 0.0) if "current" in subject.declaration.untold else given["current"])
    u, v = np.asarray(draw.current(current).velocity).tolist()
    direction = draw.direction(given["direction"])
    return Sea(inputs.drawn(GRID), direction, given["spread"], given["peakedness"], _VARIANCE, (u, v), water)


def _seen(subject: Subject, sea: Sea) -> Measured:
    """Its realisations of a sea, which it is asked for once. One without waves fails."""
    first = 1000 * asked_seed.get() % _SEEDS
    key = (sea, first)
    if key not in subject.seas:
        subject.seas[key] = collected([measure(sea, subject.sea(sea, first + n)) for n in range(COUNT)])
    found: Measured = subject.seas[key]
    return found


def _apart(found: Measured, sea: Sea, names: tuple[str, ...]) -> tuple[float, str, float, float]:
    """The worst of some scalars: over, its name, its mean, and what it should be."""
    other = own(sea)
    over = {name: apart(found, other, name) for name in names}
    name = max(over, key=lambda key: over[key])
    return over[name], name, found.mean(name), other.mean(name)


@check("sea", "eq:amplitudes", CHANCE.format("7 % of the energy, since the tail may end elsewhere"), CASES, stage="sea")
def check_energy(subject: Subject, case: Case) -> Outcome:
    """The mean square elevation that was asked for: amplitudes drawn at random without a factor hold two thirds of the
    energy, a height taken for a deviation sixteen times as much, a spectrum of one side taken for one of two half."""
    sea = asked_of(subject, case, "energy")
    over, _, ratio, _ = _apart(_seen(subject, sea), sea, ("energy",))
    return Outcome(over, f"its seas hold {ratio:.3g} of the energy asked for", figures={"ratio": ratio})


@check("sea", "eq:JONSWAP", CHANCE.format("3 % of the whole in each of four bands"), CASES, stage="sea")
def check_spectrum(subject: Subject, case: Case) -> Outcome:
    """The energy is spread over wavenumbers as the spectrum says: a peak in Hz for one in rad/s, a peakedness that is
    not used, and a density over frequencies taken for one over wavenumbers, without the group velocity, are seen."""
    sea = asked_of(subject, case, "peakedness")
    names = tuple(f"band-{n}" for n in range(len(BANDS) - 1))
    over, name, share, should = _apart(_seen(subject, sea), sea, names)
    low, high = BANDS[int(name[-1])], BANDS[int(name[-1]) + 1]
    return Outcome(
        over,
        f"{100 * share:.3g} % of the energy lie between {low:g} and {high:g} times the peak's wavenumber, should be "
        f"{100 * should:.3g} %",
        figures={
            "shares": [_seen(subject, sea).mean(one) for one in names],
            "should": [own(sea).mean(n) for n in names],
        },
    )


@check("sea", "eq:angularspread", CHANCE.format("2 degrees"), CASES, stage="sea")
def check_directions(subject: Subject, case: Case) -> Outcome:
    """The waves go where they were told to: where they come from taken for where they go to, degrees for radians, a
    compass for a mathematical angle, x and y exchanged or rows counted downwards turn the sea."""
    sea = asked_of(subject, case, "direction")
    over, _, turn, _ = _apart(_seen(subject, sea), sea, ("turn",))
    return Outcome(over, f"its waves go {turn:+.3g} degrees off the direction asked for", figures={"turn": turn})


@check("sea", "eq:angularspread", CHANCE.format("12 % of the width, whatever the law of spreading"), CASES, stage="sea")
def check_spread(subject: Subject, case: Case) -> Outcome:
    """The directions deviate from their mean by as much as was asked for: a full width taken for half of it, for a
    deviation or for an exponent makes the sea too broad or too narrow."""
    sea = asked_of(subject, case, "spread", "direction")
    over, _, width, should = _apart(_seen(subject, sea), sea, ("width",))
    words = f"its directions deviate by {width / should:.3g} of what was asked for"
    return Outcome(over, words, figures={"ratio": width / should})


@check("sea", "eq:SnJ", CHANCE.format("5 % of the energy"), CASES, stage="sea")
def check_backwards(subject: Subject, case: Case) -> Outcome:
    """Waves run one way: where a surface is the real part of amplitudes that do not turn with time, or both signs of
    the frequency are given to each wave, half of the energy runs against it."""
    sea = asked_of(subject, case, "direction")
    over, _, share, _ = _apart(_seen(subject, sea), sea, ("behind",))
    return Outcome(over, f"{100 * share:.3g} % of the energy run against the sea", figures={"share": share})


@check("sea", "eq:SnJ", CHANCE.format("0.02 c0 in each component"), CASES, stage="sea")
def check_motion(subject: Subject, case: Case) -> Outcome:
    """The waves move as the dispersion relation in that water and the current have it: a current with the wrong sign,
    left out or counted twice, a depth that is not used or a frequency in Hz is seen as another current."""
    sea = asked_of(subject, case)
    found = _seen(subject, sea)
    over, _, _, _ = _apart(found, sea, ("u", "v"))
    seen = [found.mean(name) - own(sea).mean(name) + true for name, true in zip("uv", sea.current, strict=True)]
    u, v = sea.current
    return Outcome(
        over,
        f"its waves move as on a current of ({seen[0]:.3g}, {seen[1]:.3g}) c0, should be ({u:.3g}, {v:.3g})",
        figures={"current": seen, "true": list(sea.current)},
    )


@check(
    "sea",
    "sec:spectrum",
    "The square of the sum of the phase factors of a bin over realisations, over their number, is 1 in the mean for "
    "phases that are uniform and independent, as is that of all bins in one realisation. The mean of the first over "
    "bins, of the second over realisations, may be as large as chance makes it once in thirty thousand times, a "
    "quarter of the bins being taken for independent.",
    CASES,
    stage="sea",
)
def check_phases(subject: Subject, case: Case) -> Outcome:
    """Phases are uniform, other ones for each wave and each realisation: phases in half of the circle, none at all, or
    one for all waves give a crest at the same place again and again."""
    sea = asked_of(subject, case)
    over, seen, where = added(_seen(subject, sea).bins)
    words = f"its phases {where} add up to {seen:.3g} times what independent ones do"
    return Outcome(over, words, figures={"times": seen})


@check(
    "sea",
    "sec:spectrum",
    "The correlation of two surfaces is normal about zero for seas that have nothing in common, as wide as it is "
    "between leakref's own; the largest of all pairs may be what chance makes it once in thirty thousand times.",
    CASES,
    stage="sea",
)
def check_realizations(subject: Subject, case: Case) -> Outcome:
    """Another seed is another sea: a seed that is not used, or cut to a few values, gives the same surface again."""
    sea = asked_of(subject, case)
    largest, wide = (correlated(one.frames) for one in (_seen(subject, sea), own(sea)))
    pairs = COUNT * (COUNT - 1) / 2
    limit = float(-ndtri(FALSE_ALARMS / STATEMENTS / 2 / pairs)) * wide[1]
    return Outcome(
        largest[0] / limit,
        f"two of {COUNT} seas of different seeds correlate by {largest[0]:.3g}, should be below {limit:.2g}",
        figures={"correlation": largest[0]},
    )


@check(
    "sea",
    "eq:amplitudes",
    "The variance of the energy at a bin over the square of its mean is 1 where amplitudes are drawn as those of a "
    "Gaussian sea and 0 where they are those of the spectrum: half-way decides, six deviations from either.",
    CASES,
    stage="sea",
)
def check_amplitudes(subject: Subject, case: Case) -> Outcome:
    """Amplitudes are drawn, or are not, as declared: a sea of fixed amplitudes has too even a height from one
    realisation to the next for statistics of extremes, one of random ones too uneven a one for tests to all digits."""
    sea = asked_of(subject, case)
    declared = subject.declaration.can["sea"].get("amplitudes")
    if declared is None:
        raise Unanswered(Verdict.UNSUPPORTED, "does not say whether it draws amplitudes")
    energy = np.abs(_seen(subject, sea).bins) ** 2
    energy = energy[:, energy.mean(axis=0) >= STRONG * energy.mean(axis=0).max()]  # wherever the sea goes
    uneven = float(np.mean(energy.var(axis=0, ddof=1) / energy.mean(axis=0) ** 2))
    over = uneven / 0.5 if declared == "fixed" else max(1 - uneven, 0.0) / 0.5
    words = f"the energy at a bin varies by {uneven:.3g} of its square, and its amplitudes are declared {declared}"
    return Outcome(over, words, figures={"uneven": uneven})


@check(
    "sea", "protocol", "Two surfaces of one seed may differ by 1e-9 of their deviation.", [Case("twice")], stage="sea"
)
def check_repeats(subject: Subject, case: Case) -> Outcome:
    """The same seed is the same sea: what is tested with it can be tested again."""
    sea = asked_of(subject, replace(CASES[0], seed=case.seed), "seed")
    first, second = (subject.sea(sea, 7) for _ in range(2))
    deviation = max(float(np.sqrt(np.mean(first**2))), 1e-300)
    off = float(np.abs(first - second).max()) / deviation
    return Outcome(off / _AGAIN, f"two surfaces of one seed differ by {off:.2g} of their deviation")
