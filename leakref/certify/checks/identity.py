"""Which of the reference's methods a code turns out to work as.

A bare function says nothing of how it works. It is held to what every algorithm must do; where its answers are those of
one of the reference's methods it is held to what that method does as well, to the digits where they are known. A code
that names a method of the reference may have made it otherwise, as on an interpolated cylinder in place of the bins of
a shell: then it is held to what that method must do, and not to digits.
"""

from __future__ import annotations

import numpy as np

from leakref import fast
from leakref.certify.checks import inputs
from leakref.certify.checks.draw import PUBLISHED
from leakref.certify.subject.frames import OWN, Subject
from leakref.certify.verdict import Unanswered
from leakref.currents import UniformCurrent
from leakref.methods import METHODS
from leakref.window import WINDOWS

__all__ = ["SAME", "identify"]

SAME = 2e-4
"""In c0: what optimisers at default tolerances were seen to miss by. The median difference may be that."""


def identify(subject: Subject) -> frozenset[str]:
    """The methods by which it answers a broad sea as the reference does; asked once in a session.

    Those it names are asked one by one. Of a code that names none `subject.reproduces` says which of the reference's
    methods it is, or that it is of its own. One velocity for the band is nobody's, and no answer is no identity; that
    speaks against nothing here, since the checks ask for themselves.
    """
    if subject.alike is not None:
        return subject.alike
    subject.alike, d = frozenset(), subject.declaration
    named = [name for name in d.methods if name in METHODS]
    subject.reproduces = OWN if not d.methods else ""
    if d.band or not subject.offers("extract") or (d.methods and not named):
        return subject.alike
    window = next((name for name in ("hann", *d.windows) if name in d.windows and name in WINDOWS), None)
    if window is None:
        return subject.alike
    with inputs.asked(subject, PUBLISHED):
        cube = inputs.sea(40.0, 180.0, UniformCurrent(inputs.polar(0.2, 75.0)), realization=3)
        answers = fast.realize(
            cube.components, cube.grid, cube.wavenumbers, windows=(window,), methods=tuple(METHODS), water=cube.water
        )
        for own in named or (OWN,):
            try:
                found = subject.extract(
                    cube.surface, cube.spacing, cube.wavenumbers, window=window, method=own if named else None
                ).values
            except Unanswered:
                continue
            off = {
                name: np.median(np.nan_to_num(np.hypot(*(found - answers[window, name].velocities).T), nan=np.inf))
                for name in ([own] if named else METHODS)
            }
            subject.alike |= {name for name, median in off.items() if median <= SAME}
    if not d.methods:
        subject.reproduces = next((name for name in METHODS if name in subject.alike), OWN)
    return subject.alike
