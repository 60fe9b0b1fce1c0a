"""N: the normalized scalar product against least squares (case-NSP-LS, sec:LSvsNSP).

Six statements, N1 to N6, on the one sea of that case. Where the threshold of LS could be read in two ways (D7) both are
readings; N6 is a timing of this machine.

- N1: LS exceeds the resolutions at most wavenumbers.
- N2, N3, N4: NSP is fine above the peak, worse than LS below it, where both are unusable.
- N5: LS is never better for practical purposes; k > 1 and k < 1 are parts of their own, against N3.
- N6: LS is up to three times faster.
"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import product

from leakref.cases import CASES
from leakref.claims.configurations import SPEEDS
from leakref.claims.evidence import PLAIN, Evidence, Setting
from leakref.claims.registry import claim
from leakref.claims.samples import ABOVE, BELOW, LEVELS, RESOLUTIONS, STATISTICS, WINDOWS, Band, Sample, random, smaller
from leakref.claims.words import Reading, Tally, above, below, both, either, every, most, pooled
from leakref.ensemble import Ensemble

_CASE = CASES["nsp-ls"][0]
_THRESHOLDS = {"0.2 of P": PLAIN, "0.2 of sqrt P": Setting(threshold=0.2**2)}
"""Readings of the LS threshold, decision D7: both of the largest in the shell."""


_CURRENTS = {f"a current of {speed:g}": speed for speed in (SPEEDS[0], SPEEDS[-1])}
"""What one would measure: a scatter as large as the weakest, or the strongest, of the paper's currents hides it."""


def _over_limit(e: Ensemble, level: Sample, limit: str, band: Band) -> Tally:
    """Where a level is above a limit, the `smaller` or `larger` resolution or a current, within a band."""
    inside = band(e.wavenumbers)
    return above(level.at(band), _CURRENTS.get(limit) or RESOLUTIONS[limit](*e.resolutions)[inside])


@claim(
    "N1",
    "LS biases exceed the velocity resolutions at most wavenumbers",
    "sec:LSvsNSP",
    "Mean of |c|, or mean + 2 sd, above the larger (both resolutions) or smaller (one) at over half of the shells; "
    "untapered and Hann. LS keeps bins above 0.2 of the largest P of the shell, or of sqrt P (D7).",
)
def _(see: Evidence) -> Iterator[Reading]:
    """Both resolutions and one of them are readings of the plural."""
    for (cut, setting), (level, of), resolution, window in product(
        _THRESHOLDS.items(), LEVELS.items(), ("larger", "smaller"), WINDOWS
    ):
        e = see(_CASE, window, "ls", setting)
        yield from most(
            {"threshold (D7)": cut, "level": level, "resolution": resolution, "window": window},
            exceeds=above(of(e), RESOLUTIONS[resolution](*e.resolutions)),
        )


@claim(
    "N2",
    "NSP is below resolution for all k > 1",
    "sec:LSvsNSP",
    "Mean of |c|, or mean + 2 sd, below the smaller or larger resolution at every k > 1; untapered and Hann.",
)
def _(see: Evidence) -> Iterator[Reading]:
    """Both levels are tested against either resolution, with and without a taper: the text speaks of one figure, which
    shows the mean and twice the deviation beside both of them.
    """
    for level, resolution, window in product(LEVELS, RESOLUTIONS, WINDOWS):
        e = see(_CASE, window)
        limit = RESOLUTIONS[resolution](*e.resolutions)[ABOVE(e.wavenumbers)]
        yield from every(
            {"level": level, "resolution": resolution, "window": window},
            sub_resolution=below(LEVELS[level](e).at(ABOVE), limit),
        )


@claim(
    "N3",
    "for k < 1 NSP is worse than LS",
    "sec:LSvsNSP",
    "Bias, or random part, of NSP above that of LS at k < 1, paired; untapered and Hann.",
)
def _(see: Evidence) -> Iterator[Reading]:
    """Worse in the mean, or worse in scatter."""
    for (cut, setting), (words, of), window in product(_THRESHOLDS.items(), STATISTICS.items(), WINDOWS):
        worse = of(see(_CASE, window)) - of(see(_CASE, window, "ls", setting))
        yield from either(
            {"threshold (D7)": cut, "statistic": words, "window": window}, nsp_worse=above(worse.at(BELOW))
        )


@claim(
    "N4",
    "for k < 1 the random part makes both unusable",
    "sec:LSvsNSP",
    "Unusable: one, or two, standard deviations of |c| above the larger or smaller resolution, or above the weakest or "
    "strongest current of case-U, for NSP and for LS, at k < 1; untapered and Hann.",
)
def _(see: Evidence) -> Iterator[Reading]:
    """Unusable is what cannot be told from nothing: a scatter as large as the resolution itself. Twice the deviation,
    as the figures show it, comes first.
    """
    limits = ("larger", "smaller", *_CURRENTS)
    for (cut, setting), sd, limit, window in product(_THRESHOLDS.items(), (2, 1), limits, WINDOWS):
        nsp, ls = (
            _over_limit(e, sd * random(e), limit, BELOW)
            for e in (see(_CASE, window), see(_CASE, window, "ls", setting))
        )
        yield from either(
            {"threshold (D7)": cut, "level": f"{sd} sd", "limit": limit, "window": window}, nsp=nsp, ls=ls
        )


@claim(
    "N5",
    "LS is consistently worse than NSP, never better, for practical purposes",
    "sec:LSvsNSP",
    "Bias and random part of LS above those of NSP, k > 1 and k < 1 apart: at most shells, and nowhere below by over "
    "10 % of the smaller resolution, which is what practical purposes see; or at every shell. Untapered and Hann.",
)
def _(see: Evidence) -> Iterator[Reading]:
    """Where LS has no number nothing is told, for or against; how many such shells there are stands in the figure."""
    bands = {"above the peak": ABOVE, "below the peak": BELOW}
    for (cut, setting), window in product(_THRESHOLDS.items(), WINDOWS):
        nsp, ls = see(_CASE, window), see(_CASE, window, "ls", setting)
        worse, never_better = {}, {}
        for band, inside in bands.items():
            differences = [(of(ls) - of(nsp)).at(inside) for of in STATISTICS.values()]
            worse[band] = pooled(*map(above, differences))
            limit = 0.1 * smaller(nsp)[inside(nsp.wavenumbers)]
            never_better[band] = pooled(*(above(d, -limit) for d in differences))
        answers = {
            "most shells, never better": {
                # None: nothing contradicts it, though not all shells show it
                band: both(worse[band].most, never_better[band].every is not False)
                for band in bands
            },
            "every shell": {band: worse[band].every for band in bands},
        }
        for words, parts in answers.items():
            tallies = {**worse, **{f"{band}, never better": tally for band, tally in never_better.items()}}
            yield Reading(
                {"threshold (D7)": cut, "window": window, "holds at": words},
                both(*parts.values()),
                {name: tally.figure for name, tally in tallies.items()},
                tallies,
                parts,
            )


@claim(
    "N6",
    "LS is up to 3 times faster",
    "sec:LSvsNSP",
    "Seconds of NSP over seconds of LS on this machine, the best of three: of the whole analysis of a spectrum, taper "
    "and transform included, both minimised by Nelder-Mead to MATLAB's tolerances as in the paper; of the "
    "minimisations alone; or with LS in closed form. LS is faster, and NSP takes up to 3 times as long, within 10 %. "
    "A timing: it changes from run to run.",
)
def _(see: Evidence) -> Iterator[Reading]:
    """A timing has no sampling error that is known: it holds or does not, of this run."""
    seconds = see.seconds(_CASE)
    for words, shared in (("whole analysis", seconds["transform"] + seconds["shells"]), ("minimisation alone", 0.0)):
        for name, least in (("Nelder-Mead", "ls by Nelder-Mead"), ("closed form (D8)", "ls")):
            ratio = (seconds["nsp"] + shared) / (seconds[least] + shared)
            yield Reading({"timed": words, "LS": name}, 1 < ratio <= 3.3, {"ratio": float(f"{ratio:.3g}")})
