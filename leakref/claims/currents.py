"""U: a uniform current (case-U; sec:current). Waves at 90 deg; following, crossing and opposing currents.

Twelve statements, U1 to U12. Errors are |c - U|, or the mean of |c| against U as the paper's figures show it: where the
two could differ both are readings. Rotated seas are turned either way (D23) where that could matter.

- U1, U2: the sign of the errors along the waves, and their size against still water.
- U3: a crossing current, untapered, turns velocities towards the waves' line at low wavenumbers.
- U4: a taper reduces errors of size and direction for currents along the waves.
- U5, U6: tapered, a crossing current keeps a bias of about a tenth of `c0`, and errors of direction.
- U7, U8: rotated by 30 degrees, untapered, biases are stronger, down to half of the current.
- U9, U10: tapered, a rotation does not matter, and other angles are alike.
- U11: with a current errors are mostly below resolution.
- U12: near k = 0.5 a crossing current seems to turn towards the waves.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace
from itertools import product

import numpy as np

from leakref._base import FloatArray
from leakref.claims.configurations import CURRENTS, SPEEDS, current, turn
from leakref.claims.evidence import Evidence
from leakref.claims.registry import claim
from leakref.claims.samples import (
    ABOVE,
    ALL,
    BELOW,
    MEASURES,
    NEAR,
    RESOLUTIONS,
    WINDOWS,
    Band,
    Sample,
    across,
    along,
    bias,
    direction,
    in_resolutions,
    magnitude,
    missed,
    smaller,
)
from leakref.claims.words import Reading, Tally, above, alike, below, either, every, most, pooled, significant, within
from leakref.ensemble import Ensemble

_FOLLOWING, _CROSSING, _OPPOSING = CURRENTS.values()
_ALIGNED = (_FOLLOWING, _OPPOSING)
_SENSES = {"anticlockwise": 30.0, "clockwise": -30.0}


def _heading(e: Ensemble) -> float:
    """Direction of the true current, degrees."""
    return e.configuration.current_direction + e.configuration.rotation


def _vector(e: Ensemble) -> Sample:
    """Its mean is the size of the mean error, as a vector."""
    u, v = (of(e, _heading(e)) for of in (along, across))
    u = replace(u, values=u.values - e.configuration.speed)
    size = np.maximum(np.hypot(u.mean, v.mean), 1e-300)
    return replace(u, values=(u.mean * u.values + v.mean * v.values) / size)


def _angles(e: Ensemble) -> Sample:
    """Its mean is that of the angle, of either sign, between c and U, degrees."""
    u, v = (of(e, _heading(e)) for of in (along, across))
    return replace(u, values=np.degrees(np.abs(np.arctan2(v.values, u.values))))


def _mean_angle(e: Ensemble) -> Sample:
    """Its mean is the angle, of either sign, between the mean vector and U, degrees."""
    return magnitude(direction(e, _heading(e)))


_ANGLES = {"mean vector": _mean_angle, "each DSV": _angles}


@claim(
    "U1",
    "k > 1: bias against the waves; k < 1: with the waves",
    "sec:current",
    "Component of the mean error c - U along the waves; or the mean of |c|: at k > 1 below U when following, above "
    "when opposing, at k < 1 the reverse. Not rotated; untapered and Hann.",
)
def _(see: Evidence) -> Iterator[Reading]:
    """The error as a vector is compared with the waves' direction, its size with the speed of the current, whose sense
    changes the sign for opposing ones.
    """
    for window in WINDOWS:
        vector, size = [], []
        for one in turn(0.0):
            e = see(one, window)
            waves = along(e, 90)
            off = replace(waves, values=waves.values - one.current[1])
            vector.append(off)
            if one.current_direction in _ALIGNED:
                size_off = replace(bias(e), values=e.magnitudes - one.speed)
                with_waves = np.sign(one.current[1]) * size_off
                size.append(with_waves)
        for words, along_waves in (("mean of |c| against U", size), ("component along the waves", vector)):
            yield from either(
                {"bias": words, "window": window},
                above_the_peak=pooled(*(below(one.at(ABOVE)) for one in along_waves)),
                below_the_peak=pooled(*(above(one.at(BELOW)) for one in along_waves)),
            )


@claim(
    "U2",
    "the size of the errors is that of quiescent water",
    "sec:current",
    "Mean of |c - U|, the size of an error, or mean of |c| against U, and the bias at U = 0, same phases: not "
    "significantly different, as *similar* is elsewhere, or within 10 % of that. Not rotated; untapered and Hann.",
)
def _(see: Evidence) -> Iterator[Reading]:
    """Still water has the same phases, so that the difference is paired."""
    for (measure, of), window in product(reversed(MEASURES.items()), WINDOWS):
        still = see(current(0.0), window)
        differences = [of(see(one, window)) - bias(still) for one in turn(0.0)]
        for words, same in (
            ("not significantly different", [alike(d, smaller(still)) for d in differences]),
            ("within 10 %", [within(d, 0.1 * still.bias) for d in differences]),
        ):
            yield from either({"error": measure, "same": words, "window": window}, same=pooled(*same))


@claim(
    "U3",
    "crossing current, untapered: DSVs turn towards +-90 deg for k < about 1.5",
    "sec:current",
    "The mean vector's component along +-90 deg is significant at k < 1.5; and, if the limit is meant as one, not "
    "significant at k > 1.65. Not rotated, all speeds.",
)
def _(see: Evidence) -> Iterator[Reading]:
    """That they turn below a limit, and that they do not beyond it, are two statements; a reading has one or both."""

    def turning(test: Callable[[Sample, FloatArray], Tally], inside: Band) -> Tally:
        ensembles = [see(current(speed, _CROSSING), "box") for speed in SPEEDS]
        return pooled(*(test(across(e, 0).at(inside), smaller(e)[inside(e.wavenumbers)]) for e in ensembles))

    turn, rest = turning(significant, lambda k: k < 1.5 - 1e-9), turning(alike, lambda k: k > 1.65)
    yield from either({"limit": "below 1.5 they turn"}, turned=turn)
    yield from either({"limit": "and beyond they do not"}, turned=turn, not_turned=rest)


@claim(
    "U4",
    "with Hann, following and opposing: biases in size and direction are much reduced",
    "sec:current",
    "Error of size (mean of |c - U|, or mean of |c| against U) below that untapered by a significant amount; error of "
    "direction (of the mean vector, or the mean over DSVs) at k < 1, of which the text speaks, below that untapered. "
    "Not rotated.",
)
def _(see: Evidence) -> Iterator[Reading]:
    """The two directions along the waves are pooled; errors of direction are those of the mean vector, or of each
    velocity.
    """
    for (measure, size), (words, angle) in product(MEASURES.items(), _ANGLES.items()):
        sizes, angles = [], []
        for one in turn(0.0, _ALIGNED):
            box, hann = (see(one, window) for window in WINDOWS)
            gain = size(box) - size(hann)
            sizes.append(above(gain, 0.1 * smaller(box)))
            angles.append(above((angle(box) - angle(hann)).at(BELOW)))
        yield from either({"error": measure, "direction of": words}, size=pooled(*sizes), direction=pooled(*angles))


@claim(
    "U5",
    "with Hann, crossing: the mean bias stays significant, about 10 % of the peak phase velocity, also near the peak",
    "sec:current",
    "Mean error (of |c| against U, of |c - U|, or as a vector) significant, and of the order of 10 % (within a factor "
    "of 2), or within 10 % of it, over all shells and at |k - 1| <= 0.1; 10 % of c0, as the text has it, or of the "
    "current. Not rotated, all speeds. The figure has the largest error as a share of either.",
)
def _(see: Evidence) -> Iterator[Reading]:
    """A mean is about a tenth if it is between two limits; at each shell the nearer one counts."""
    measures = {**MEASURES, "mean vector against U": _vector}
    orders = (("of that order", 0.05, 0.2), ("within 10 %", 0.09, 0.11))
    for whole, (measure, of), (words, low, high) in product(("c0", "the current"), measures.items(), orders):
        parts: dict[str, list[Tally]] = {"significant": [], "about": [], "about_near_peak": []}
        largest = {}
        for speed in SPEEDS:
            e = see(current(speed, _CROSSING), "hann")
            share = (1.0 if whole == "c0" else 1 / speed) * of(e)
            largest[f"U={speed:g}"] = round(100 * float(np.nanmax(share.mean)), 2)
            parts["significant"].append(significant(of(e), smaller(e)))
            for name, band in (("about", ALL), ("about_near_peak", NEAR)):
                parts[name].append(_between(share.at(band), low, high))
        tallies = {name: pooled(*t) for name, t in parts.items()}
        for reading in either({"10 % of": whole, "bias": measure, "about": words}, **tallies):
            yield reading.figured(**{f"largest in percent of {whole}": largest})


def _between(sample: Sample, low: float, high: float) -> Tally:
    """The mean is from `low` to `high`: at each shell the nearer of the two limits counts."""
    off = magnitude(replace(sample, values=sample.values - (low + high) / 2))
    return below(off, (high - low) / 2)


@claim(
    "U6",
    "with Hann, crossing current: direction errors of 10 to 45 deg if the current is weak or k is near 0.5",
    "sec:current",
    "Angle between U and the mean vector, or mean of the angles: for the weakest current at k < 1 (the text speaks of "
    "k below the peak), and for all at k = 0.45 to 0.55. That it is at least 10 deg, so that errors remain, and that "
    "it is at most 45 deg are parts of their own. Not rotated.",
)
def _(see: Evidence) -> Iterator[Reading]:
    """The degrees themselves stand in the figure, since the paper names a range. An error above 45 degrees is against
    the range, not against there being an error.
    """
    for words, of in _ANGLES.items():
        weak = of(see(current(SPEEDS[0], _CROSSING), "hann")).at(BELOW)
        low = [
            of(see(current(speed, _CROSSING), "hann")).at(lambda k: np.abs(k - 0.5) <= 0.05 + 1e-9) for speed in SPEEDS
        ]
        for reading in either(
            {"direction of": words},
            weak_at_least_10=above(weak, 10),
            near_half_at_least_10=pooled(*(above(s, 10) for s in low)),
            weak_at_most_45=below(weak, 45),
            near_half_at_most_45=pooled(*(below(s, 45) for s in low)),
        ):
            degrees = {
                "weak, by k": weak.mean.round(1).tolist(),
                "k = 0.5, by speed": [round(float(s.mean[0]), 1) for s in low],
            }
            yield reading.figured(degrees=degrees)


@claim(
    "U7",
    "rotated by 30 deg, untapered: stronger biases, above all for a crossing current",
    "sec:current",
    "Error (mean of |c| against U, or of |c - U|) above that of the same sea not rotated, all currents; and the "
    "rise, mean over shells in units of the smaller resolution, for a crossing current above those of the others. "
    "Rotated either way (D23).",
)
def _(see: Evidence) -> Iterator[Reading]:
    """An aligned current may be turned either way with the same result, mirrored; a crossing one may not."""
    for (measure, of), (sense, angle) in product(MEASURES.items(), _SENSES.items()):
        rise = {
            (speed, way): of(see(current(speed, way, angle if way == _CROSSING else 30.0), "box"))
            - of(see(current(speed, way), "box"))
            for speed, way in product(SPEEDS, CURRENTS.values())
        }
        e = see(current(0.0), "box")
        pooled_rise = {key: in_resolutions(sample, e).over() for key, sample in rise.items()}
        most_of_all = [
            above(pooled_rise[speed, _CROSSING] - pooled_rise[speed, way]) for speed, way in product(SPEEDS, _ALIGNED)
        ]  # aligned: either sense is the mirror image
        yield from either(
            {"error": measure, "rotated (D23)": sense},
            stronger=pooled(*map(above, rise.values())),
            crossing_most=pooled(*most_of_all),
        )


@claim(
    "U8",
    "there, DSVs around k = 1 drop below 50 % of the current",
    "sec:current",
    "Rotated by 30 deg either way (D23), crossing, untapered, |k - 1| <= 0.1, all speeds: mean of |c|, size of the "
    "mean vector, or component along U below U / 2; at every shell, most, or the lowest for each speed.",
)
def _(see: Evidence) -> Iterator[Reading]:
    """The lowest shell of each speed is a reading of its own: the words may mean that such velocities occur."""
    sizes = {
        "mean of |c|": bias,
        "mean vector": lambda e: replace(bias(e), values=_length(e)),
        "component along U": lambda e: along(e, _heading(e)),
    }
    for (words, of), (sense, angle) in product(sizes.items(), _SENSES.items()):
        shares = [1 / speed * of(see(current(speed, _CROSSING, angle), "box")).at(NEAR) for speed in SPEEDS]
        tallies = [below(share, 0.5) for share in shares]
        yield from either({"size": words, "rotated (D23)": sense}, below_half=pooled(*tallies))
        lowest = pooled(*(below(share.at(lambda k, s=share: k == k[np.argmin(s.mean)]), 0.5) for share in shares))
        for reading in every({"size": words, "rotated (D23)": sense, "holds at": "the lowest"}, below_half=lowest):
            least = {f"U={speed:g}": round(float(s.mean.min()), 3) for speed, s in zip(SPEEDS, shares, strict=True)}
            yield reading.figured(lowest_over_U=least)


def _length(e: Ensemble) -> np.ndarray:
    """Values (R, n) whose mean is the size of the mean vector."""
    unit = e.mean / np.maximum(np.hypot(*e.mean.T), 1e-300)[:, None]
    return np.einsum("rnc,nc->rn", e.velocities, unit)


@claim(
    "U9",
    "with Hann, rotated and unrotated results are virtually indistinguishable",
    "sec:current",
    "Rotated by 30 deg against the same sea not rotated, paired: mean of |c|, mean of |c - U|, or both components "
    "of the mean vector turned back, within 10 % of the smaller resolution.",
)
def _(see: Evidence) -> Iterator[Reading]:
    """The mean vector is compared in the frame of the current, component by component."""
    pairs = [(see(current(one.speed, one.current_direction, 30.0), "hann"), see(one, "hann")) for one in turn(0.0)]
    differences = {
        "mean of |c|": [bias(a) - bias(b) for a, b in pairs],
        "mean of |c - U|": [missed(a) - missed(b) for a, b in pairs],
        "mean vector": [of(a, _heading(a)) - of(b, _heading(b)) for a, b in pairs for of in (along, across)],
    }
    for measure, samples in differences.items():
        limit = smaller(pairs[0][0])
        yield from either({"result": measure}, same=pooled(*(alike(d, limit) for d in samples)))


@claim(
    "U10",
    "rotations from 15 to 45 deg give similar results",
    "sec:current",
    "Rotated by 15 and by 45 deg against 30 deg, paired: mean of |c|, or of |c - U|, within 10 %, or not "
    "significantly different; untapered and Hann.",
)
def _(see: Evidence) -> Iterator[Reading]:
    """30 degrees is the angle of the figures, with which the others are compared."""
    for (measure, of), window in product({"mean of |c|": bias, "mean of |c - U|": missed}.items(), WINDOWS):
        pairs = [
            (of(see(one, window)), of(see(current(one.speed, one.current_direction, 30.0), window)))
            for angle in (15.0, 45.0)
            for one in turn(angle)
        ]
        limit = smaller(see(current(0.0), window))
        for words, same in (
            ("within 10 %", [within(a - b, 0.1 * b.mean) for a, b in pairs]),
            ("within 10 % of the smaller resolution", [alike(a - b, limit) for a, b in pairs]),
        ):
            yield from either({"result": measure, "same": words, "window": window}, similar=pooled(*same))


@claim(
    "U11",
    "with a current the spurious magnitudes are mostly below resolution, with a direction bias near k = 1 "
    "when crossing",
    "sec:conclusions",
    "Error (mean of |c| against U, or of |c - U|) below the smaller or larger resolution at most shells, all "
    "currents; crossing, the mean vector's component across U significant at most shells with |k - 1| <= 0.1. Not "
    "rotated; untapered and Hann.",
)
def _(see: Evidence) -> Iterator[Reading]:
    """At most shells, since the words say mostly; the bias of direction is looked for near the peak only."""
    for (measure, of), (resolution, choose), window in product(MEASURES.items(), RESOLUTIONS.items(), WINDOWS):
        ensembles = [see(one, window) for one in turn(0.0)]
        crossing = [see(current(speed, _CROSSING), window) for speed in SPEEDS]
        yield from most(
            {"error": measure, "resolution": resolution, "window": window},
            sub_resolution=pooled(*(below(of(e), choose(*e.resolutions)) for e in ensembles)),
            turned=pooled(*(significant(across(e, 0).at(NEAR), smaller(e)[NEAR(e.wavenumbers)]) for e in crossing)),
        )


@claim(
    "U12",
    "with a crossing current DSVs near k = 0.5 turn towards the waves",
    "sec:current",
    "Untapered, of which the text speaks there, or Hann: the component of the mean vector along the waves above 10 % "
    "of the smaller resolution, and its direction more than 10 degrees from the current towards them, at k = 0.45 to "
    "0.55. Not rotated, all speeds.",
)
def _(see: Evidence) -> Iterator[Reading]:
    """The current is towards 0 degrees, the waves towards 90."""

    def half(k: FloatArray) -> FloatArray:
        return np.abs(k - 0.5) <= 0.05 + 1e-9

    for window in WINDOWS:
        ensembles = [see(current(speed, _CROSSING), window) for speed in SPEEDS]
        yield from either(
            {"window": window},
            towards_the_waves=pooled(
                *(above(along(e, 90).at(half), 0.1 * smaller(e)[half(e.wavenumbers)]) for e in ensembles)
            ),
            turned_by_10_degrees=pooled(*(above(direction(e, 0).at(half), 10.0) for e in ensembles)),
        )
