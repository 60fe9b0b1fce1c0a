"""Signs and axes: a current comes back in its own direction, and not in another that a slip would give it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from leakref._base import FloatArray
from leakref.certify.checks import inputs
from leakref.certify.checks.criteria import ALONG, ask, each_method, like, tapered, vector, with_the_crests
from leakref.certify.checks.exact import aligned_window
from leakref.certify.checks.inputs import polar
from leakref.certify.checks.registry import Case, Outcome, check
from leakref.certify.subject.frames import Subject
from leakref.certify.verdict import Unanswered, Verdict
from leakref.currents import UniformCurrent

__all__ = ["check_aligned", "check_sea", "image"]

SPEED = 0.3
ON_BINS = 0.39
"""In c0: (2, 1) steps of what puts the waves on bins, or turned and mirrored so."""
LIKE = 0.75
"""Of the true speed: how near a velocity is to an image of the true one that it is called by that name."""
RESOLVED = 2.0
"""Velocity resolutions that a current must have for its sign to be seen; the usual ones have five and more."""
IMAGES = {
    "negated": ((-1, 0), (0, -1)),
    "with x flipped": ((-1, 0), (0, 1)),
    "with y flipped": ((1, 0), (0, -1)),
    "with x and y exchanged": ((0, 1), (1, 0)),
    "with x and y exchanged, and negated": ((0, -1), (-1, 0)),
    "turned left by 90 degrees": ((0, -1), (1, 0)),
    "turned right by 90 degrees": ((0, 1), (-1, 0)),
}
"""What slips of sign and order make of a velocity."""
# 22.5 degrees off an axis: as far from its mirror image in that axis as from that in the diagonal
CASES = [
    Case(f"to-{angle:g}", {"direction": angle}, quick=n % 2 == 0)
    for n, angle in enumerate(np.arange(22.5, 360, 45).tolist())
]


def image(found: FloatArray, should: FloatArray) -> str:
    """What `found` (2,) looks like if it is not `should` (2,) but nearer to one of its images; else empty.

    What is further than `LIKE` from all of them is just wrong: a speed four times the true one is no slip of sign.
    """
    off = {name: float(np.hypot(*(np.asarray(matrix) @ should - found))) for name, matrix in IMAGES.items()}
    nearest = min(off, key=lambda name: off[name])
    near = min(float(np.hypot(*(found - should))), LIKE * float(np.hypot(*should)))
    return nearest if off[nearest] < near else ""


def _told(over: float, found: FloatArray, should: FloatArray) -> Outcome:
    """In words: the true current, what came back, and of which of its images that is, if it is too far off and like
    one.
    """
    looks = image(found, should) if over > 1 else ""
    told = (
        f"a current of {vector(should)} comes back {looks}, as"
        if looks
        else f"a current of {vector(should)} comes back as"
    )
    return Outcome(
        over,
        f"{told} {vector(found)}",
        figures={"velocity": found.tolist(), "should_be": should.tolist(), "image": looks},
    )


def _plain(subject: Subject, cube: inputs.Cube) -> None:
    """Raises Unanswered (unsupported) where the currents that a code is made for are too slow to tell a slip by: less
    than `RESOLVED` of the smaller velocity resolutions.
    """
    least = RESOLVED * float(cube.resolutions[0].mean())
    if np.hypot(*cube.truth[0]) < least:
        limit, unit = subject.shown_as.waves["fastest"], subject.shown_as.scales().velocity
        raise Unanswered(
            Verdict.UNSUPPORTED,
            f"is made for currents up to {limit:g} m/s, too slow to tell a slip of sign by in these waves, which takes "
            f"{least * unit:.2g} m/s",
        )


def _ways(should: FloatArray) -> list[FloatArray]:
    """From the truth to each of its images."""
    return [np.asarray(matrix) @ should - should for matrix in IMAGES.values()]


def _sided(found: FloatArray, should: FloatArray) -> Outcome:
    """Nearer to the truth than half-way to the nearest of its images."""
    halfway = min(float(np.hypot(*way)) for way in _ways(should)) / 2
    return _told(float(np.hypot(*(found - should))) / halfway, found, should)


def _turned_away(found: FloatArray, should: FloatArray) -> Outcome:
    """Less than two fifths of the way to each of its images, whatever else is wrong with it."""
    return _told(max(float((found - should) @ way / (way @ way)) for way in _ways(should)) / 0.4, found, should)


@check(
    "signs",
    "eq:SnJ",
    "The velocity, in c0, may go two fifths of the way from the true one to any that a slip of "
    "sign or order would give. Correct codes of all kinds were seen to go half as far; a code that loses one "
    "component goes half of the way. From a velocity of least squares, or of a method that the reference does not "
    "have, the error of the reference's own least squares in the same sea may be taken away first.",
    CASES,
)
def check_sea(subject: Subject, case: Case) -> Outcome:
    """A transform forward in time, rows counted downwards or columns taken for rows turn the current of a sea into
    another one of the same speed: negated, one component flipped, x and y exchanged."""
    current = UniformCurrent(polar(SPEED, case.given["direction"]))
    cube = inputs.sea(case.given["direction"] + 60, 180.0, current, realization=7)
    window = tapered(subject)
    _plain(subject, cube)

    def judge(method: str) -> Outcome:
        found, there = ask(subject, cube, window, method)
        mean, truth = found[there].mean(axis=0), cube.truth[0]
        outcome = _turned_away(mean, truth)
        if outcome.over > 1 and with_the_crests(cube, mean):
            figures = {**outcome.figures, "crests": True}
            outcome = replace(outcome, message=outcome.message + ALONG, figures=figures)
        if outcome.over > 1 and (least_squares := like(cube, window, method)) is not None:
            without = _turned_away(mean - least_squares[there].mean(axis=0) + truth, truth)
            return without if without.over <= 1 else outcome
        return outcome

    return each_method(subject, judge)


@check(
    "signs",
    "eq:SnJ",
    "The length of the error may be half of the distance from the true velocity to the nearest of those that a slip "
    "would give: the true one with x, y or both reversed, or with x and y exchanged. In all cases that is more than "
    "0.08 c0, though the true velocity is known exactly.",
    CASES,
)
def check_aligned(subject: Subject, case: Case) -> Outcome:
    """Twelve waves with whole numbers of wavelengths and periods in the cube, on a current towards what its id says, in
    degrees anticlockwise from x: a slip of sign in one component, which a sea may hide, shows here whatever the window
    does."""
    cube = inputs.many(inputs.EVEN.shape, polar(ON_BINS, case.given["direction"]))
    window = aligned_window(subject)
    _plain(subject, cube)

    def judge(method: str) -> Outcome:
        found, there = ask(subject, cube, window, method)
        return _sided(found[there].mean(axis=0), cube.truth[0])

    return each_method(subject, judge)
