"""What a plan comes to, in the paper's terms (its recommendations for mitigation), with the figures just computed.

Every sentence states its figures, and says so where the paper's rule does not hold for this campaign: the advice is
what was just simulated, and not a table of rules. A difference counts from two standard errors on.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from leakref.dispersion import Water
from leakref.planning.plan import GRAVITY, Campaign, Expected, Plan
from leakref.scope import Scope

__all__ = ["SHARE", "advice", "ranges", "scope"]

SHARE = 0.2
"""Of the current: errors of single flights up to here are called small."""
_SURE = 2.0  # standard errors from which a difference is one


def ranges(wavelengths: Sequence[float], chosen: Sequence[bool]) -> list[tuple[float, float]]:
    """The runs of `chosen` among `wavelengths`, each as (longest, shortest).

    `wavelengths` are in metres, longest first, and `chosen` as many. A run of one is (w, w).
    """
    found: list[list[float]] = []
    for n, wavelength in enumerate(wavelengths):
        if chosen[n] and n and chosen[n - 1]:
            found[-1].append(wavelength)
        elif chosen[n]:
            found.append([wavelength])
    return [(run[0], run[-1]) for run in found]


def advice(plan: Plan) -> list[str]:
    """Sentences: taper or not, which method, which wavelengths to trust, whether to enlarge the area or the video.

    The list is in the order of importance: frame rate if it aliases, window, method, wavelengths to trust, area against
    duration; and of water that is not deep, what it would cost to take it for deep.
    """
    best = plan.best
    said = []
    lowest = plan.campaign.aliased_below()
    if lowest is not None:
        said.append(
            f"More images a second: waves shorter than {lowest:.3g} m alias in time, which spoils all that follows."
        )
    return [
        *said,
        _against("Taper with a Hann window", best, plan.ways["box", "nsp"], "untapered"),
        _against("Extract by NSP", best, plan.ways["hann", "ls"], "least squares"),
        *_trust(plan.campaign, best),
        _enlarge(plan),
        *_water(plan.campaign),
    ]


def scope(plan: Plan) -> Scope:
    """In which waves, water and current velocities will be had, in the words of certificates."""
    c, lengths = plan.campaign, plan.best.wavelengths
    ends = (float(lengths.min()), float(lengths.max()))
    return Scope(ends, c.depth, c.surface_tension, c.speed, c.peak_wavelength, profile="uniform, ")


def _ratio(other: tuple[float, float], own: tuple[float, float]) -> tuple[float, float]:
    """The ratio of two levels, and its standard error."""
    value = other[0] / own[0]
    return value, value * float(np.hypot(other[1] / other[0], own[1] / own[0]))


def _against(what: str, best: Expected, other: Expected, name: str) -> str:
    """Whether the recommended way is better than the `other` here, and by how much. `other` is on the same seas. Beyond
    two standard errors it is said which is better, else that it makes no difference.
    """
    value, error = _ratio(other.level(), best.level())
    figures = f"{value:.2g} ± {error:.1g} times that of Hann and NSP, at wavelengths up to the peak's"
    if value - 1 > _SURE * error:
        return f"{what}: {name}, the bias is {figures}."
    if 1 - value > _SURE * error:
        return f"Here the paper's rule does not hold ({what}): {name}, the bias is {figures}."
    return f"{what}, though here it makes no difference that could be seen: {name}, the bias is {figures}."


def _stretches(best: Expected, chosen: npt.NDArray[np.bool_]) -> str:
    """Ranges of wavelengths in words."""
    return ", ".join(
        f"{longest:.3g} to {shortest:.3g} m" if longest > shortest else f"{longest:.3g} m"
        for longest, shortest in ranges(best.wavelengths.tolist(), chosen.tolist())
    )


def _trust(campaign: Campaign, best: Expected) -> list[str]:
    """Where a single flight stays within the resolution, and where within a share of the current. A wavelength is
    trusted if bias and twice the random part stay below the resolution, and below the current itself.
    """
    single, trusted = best.single, best.trusted
    worst = int(np.argmax(np.where(trusted, single, -1)))
    limit = "the smaller velocity resolution" + " and the current itself" * bool(campaign.speed)
    said = [
        f"Trust no wavelength: even tapered, by NSP, bias and twice the random part nowhere stay below {limit}. "
        "Enlarge the area."
    ]
    if trusted.any():
        rest = "" if trusted.all() else ", not the others"
        said = [
            f"Trust wavelengths of {_stretches(best, trusted)}{rest}: there a single flight, tapered and by NSP, "
            f"errs by less than {limit} (bias and twice the random part; at most {single[worst]:.2g} m/s, at "
            f"{best.wavelengths[worst]:.3g} m)."
        ]
    if campaign.speed:
        small = single <= SHARE * campaign.speed
        where = f"at {_stretches(best, small)}" if small.any() else "nowhere"
        left = np.hypot(*best.mean_error.T)
        most = int(np.nanargmax(left))
        said.append(
            f"Within {100 * SHARE:.0f} % of the current asked for: {where}. Many flights averaged would still "
            f"be off by {left[most]:.2g} m/s at {best.wavelengths[most]:.3g} m."
        )
    return said


def _water(campaign: Campaign) -> list[str]:
    """What an extraction would err by that takes this water for deep, at the peak; nothing of water that is deep."""
    if campaign.depth == np.inf and not campaign.surface_tension:
        return []
    k = campaign.scales.wavenumber
    off = campaign.phase_velocity - float(Water(GRAVITY).phase_velocity(k))
    what = " and ".join(
        ["the depth"] * (campaign.depth < np.inf) + ["the surface tension"] * bool(campaign.surface_tension)
    )
    where = f"waves of {campaign.peak_wavelength:.3g} m travel at {campaign.phase_velocity:.3g} m/s"
    return [
        f"Give {what} to the extraction: {where} here, and one for deep water without tension would take the "
        f"difference, {abs(off):.2g} m/s, for a current {'with' if off > 0 else 'against'} them."
    ]


def _enlarge(plan: Plan) -> str:
    """What twice the area and twice the duration, the same amount of data, change; and so which to prefer. Both changes
    double the data, so that they can be weighed against each other.
    """
    own = plan.best.level()
    (area, area_error), (longer, longer_error) = (_ratio(e.level(), own) for e in (plan.larger, plan.longer))
    change = f"{100 * (area - 1):+.0f} ± {100 * area_error:.0f} %"
    figures = (
        f"twice the area changes the bias at wavelengths up to the peak's by {change}, twice the duration by "
        f"{100 * (longer - 1):+.0f} ± {100 * longer_error:.0f} %"
    )
    off, error = longer - area, float(np.hypot(area_error, longer_error))
    if off > _SURE * error:
        return f"A larger area before a longer video: {figures}."
    if -off > _SURE * error:
        return f"A longer video before a larger area, against the paper's rule: {figures}."
    return f"Area or duration, no difference that could be seen: {figures}."
