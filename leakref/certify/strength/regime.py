"""The waves in which a code is right, for one that is wrong in others: looked for on the sea of the family scale.

Many codes have constants in rad/s, m/s or metres, and are right in the waves that these were chosen for. A code that
says for which (`waves` in its declaration, or `--waves`) is asked in them; for one that does not they are found here.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from leakref.certify.checks import inputs
from leakref.certify.checks.criteria import in_the_mean, tapered
from leakref.certify.checks.draw import PUBLISHED
from leakref.certify.checks.scale import ENDS, shown_at
from leakref.certify.subject.frames import Subject
from leakref.certify.verdict import Unanswered

__all__ = ["right_between"]

CLOSE = 0.1
"""Of the logarithm of a wavelength: how near an end is found."""
_STEP = 2.0  # between the scales that are tried first


def right_between(subject: Subject) -> tuple[float, float] | None:
    """The shortest and the longest waves, in m, between which the answers of a code in SI are within the tolerance.

    Tried are waves that differ by a factor of two, from the shortest to the longest that the code is shown; the ends of
    the longest range that is right are then looked for more closely. None where it is right nowhere, or everywhere, or
    is not asked in metres. Raises what a session raises that breaks.
    """
    if subject.shown_as.units != "si" or not subject.offers("extract"):
        return None
    try:
        window = tapered(subject)
    except Unanswered:
        return None

    def right(log: float) -> bool:
        try:
            with inputs.asked(subject, PUBLISHED):
                return in_the_mean(subject, shown_at(subject, float(np.exp(log))), window, subject.methods[0]).over <= 1
        except Unanswered:
            return False

    low, high = sorted(float(np.log(subject.shown_as.scale(end))) for end in ENDS)
    tried = np.linspace(low, high, 1 + max(1, round((high - low) / np.log(_STEP))))
    held = np.array([right(log) for log in tried])
    if held.all() or not held.any():
        return None
    runs = np.split(np.arange(held.size), np.flatnonzero(np.diff(held)) + 1)
    first, last = max(((run[0], run[-1]) for run in runs if held[run[0]]), key=lambda ends: ends[1] - ends[0])
    long = tried[first] if first == 0 else _edge(right, tried[first], tried[first - 1])
    short = tried[last] if last == held.size - 1 else _edge(right, tried[last], tried[last + 1])
    shortest, longest = (2 * np.pi * subject.shown_as.scales(float(np.exp(log))).length for log in (short, long))
    return float(shortest), float(longest)


def _edge(right: Callable[[float], bool], good: float, bad: float) -> float:
    """Where it ceases to be right, between one that is and one that is not."""
    while abs(bad - good) > CLOSE:
        middle = (good + bad) / 2
        good, bad = (middle, bad) if right(middle) else (good, middle)
    return good
