"""M: methods that the paper names beside its two, and does not test (Introduction, app:numdetails, sec:LSvsNSP).

Three statements, M1 to M3, on the seas of case-theta0-DeltaTheta, which stand still, and of case-U. What the methods do
is in a module for each: `leakref.pcs`, `leakref.lsiterative`, `leakref.nspadaptive`. Where the words do not say whether
images are tapered, those that are come first: so the paper would have them.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import product

from leakref.cases import Configuration
from leakref.claims.configurations import DIRECTIONS, SPREADS, current, sea, turn
from leakref.claims.evidence import Evidence
from leakref.claims.registry import claim
from leakref.claims.samples import ABOVE, BELOW, Sample, in_resolutions, missed, random, smaller
from leakref.claims.words import Reading, Tally, above, alike, both, either, pooled
from leakref.ensemble import Ensemble

_STILL = tuple(sea(direction, spread) for direction, spread in product(DIRECTIONS, SPREADS))
_CURRENTS = (current(0.0), *turn(0.0))
_SEAS = {"still water and currents": (*_STILL, *_CURRENTS), "still water": _STILL, "currents": _CURRENTS}
_WINDOWS = ("hann", "box")
_ERRORS = {"mean of |c - U|": missed, "random part": random}


def _similar(see: Evidence, seas: Sequence[Configuration], window: str, method: str) -> Tally:
    """Both errors are those of NSP, at every shell of every sea."""
    pairs = [(see(c, window), see(c, window, method)) for c in seas]
    return pooled(*(alike(of(other) - of(nsp), smaller(nsp)) for nsp, other in pairs for of in _ERRORS.values()))


def _gain(nsp: Ensemble, other: Ensemble) -> list[Sample]:
    """By how much the other errs less, in resolutions: the mean over the shells below the peak, and above it."""
    less = in_resolutions(missed(nsp) - missed(other), nsp, other)
    return [less.at(band).over() for band in (BELOW, ABOVE)]


@claim(
    "M1",
    "the polar current shell performs similarly to NSP, and favourably in some circumstances",
    "Introduction",
    "Similar: mean of |c - U| and random part not significantly different from those of NSP, at most shells, since it "
    "is favourable at others. Favourable: in one sea or more its mean of |c - U|, averaged over the shells below or "
    "above the peak, is smaller by over 10 % of the smaller resolution. Still water (theta0 60, 75, 90, spread 15 to "
    "60 degrees) and currents (case-U, not rotated); Hann and untapered.",
)
def _(see: Evidence) -> Iterator[Reading]:
    """Where it is favourable it is not alike, so that similar is no statement about every shell."""
    for (waters, seas), window in product(_SEAS.items(), _WINDOWS):
        pairs = [(see(c, window), see(c, window, "pcs")) for c in seas]
        favourable = pooled(*(above(part, 0.1) for nsp, pcs in pairs for part in _gain(nsp, pcs)))
        tallies = {"similar": _similar(see, seas, window, "pcs"), "favourable": favourable}
        parts = {"similar": tallies["similar"].most, "favourable": favourable.some}
        figure = {name: tally.figure for name, tally in tallies.items()}
        yield Reading({"seas": waters, "window": window}, both(*parts.values()), figure, tallies, parts)


@claim(
    "M2",
    "iterative least squares perform similarly to NSP on currents without shear, as others found",
    "sec:LSvsNSP",
    "Mean of |c - U| and random part not significantly different from those of NSP. Uniform currents of case-U, not "
    "rotated; with still water, too; Hann and untapered.",
)
def _(see: Evidence) -> Iterator[Reading]:
    """The statement is about currents; still water is one of no speed."""
    for seas, window in product(("currents", "still water and currents"), _WINDOWS):
        similar = _similar(see, _SEAS[seas], window, "ls-iterative")
        yield from either({"seas": seas, "window": window}, similar=similar)


@claim(
    "M3",
    "a width a that grows with the group velocity would improve NSP",
    "app:numdetails",
    "Mean of |c - U|, or random part, of NSP above that of NSP with a = 4 sqrt(domega^2 + (cg dk)^2) (D36). Still "
    "water (theta0 60, 75, 90, spread 15 to 60 degrees) and currents (case-U, not rotated); Hann and untapered.",
)
def _(see: Evidence) -> Iterator[Reading]:
    """An improvement is a smaller error, in the mean or in its scatter."""
    for (waters, seas), (error, of), window in product(_SEAS.items(), _ERRORS.items(), _WINDOWS):
        pairs = [(see(c, window), see(c, window, "nsp-adaptive")) for c in seas]
        better = pooled(*(above(of(nsp) - of(wide)) for nsp, wide in pairs))
        yield from either({"seas": waters, "error": error, "window": window}, better=better)
