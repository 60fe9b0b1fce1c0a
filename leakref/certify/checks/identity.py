"""Which of the reference's methods a code of no named method turns out to be.

A bare function says nothing of how it works. It is held to what every algorithm must do; where its answers are those of
one of the reference's methods it is held to what that method does as well, to the digits where they are known.
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

__all__ = ["SAME", "identify"]

SAME = 2e-4
"""In c0: what optimisers at default tolerances were seen to miss by. The median difference may be that."""


def identify(subject: Subject) -> None:
    """Note in `subject.reproduces` which method answers a broad sea as the code does; asked once in a session.

    Nothing is done for a code that names its methods, or that gives one velocity for the band. No answer is no
    identity, and speaks against nothing here: the checks ask for themselves.
    """
    d = subject.declaration
    if subject.reproduces or d.methods or d.band or not subject.offers("extract"):
        return
    subject.reproduces = OWN
    window = next((name for name in ("hann", *d.windows) if name in d.windows), "hann")
    with inputs.asked(square="dy" in d.fixed, seed=PUBLISHED):
        cube = inputs.sea(40.0, 180.0, UniformCurrent(inputs.polar(0.2, 75.0)), realization=3)
        answers = fast.realize(cube.components, cube.grid, cube.wavenumbers, windows=(window,), methods=tuple(METHODS))
        try:
            found = subject.extract(cube.surface, cube.spacing, cube.wavenumbers, window=window).values
        except Unanswered:
            return
    off = {name: np.hypot(*(found - answers[window, name].velocities).T) for name in METHODS}
    alike = [name for name, differences in off.items() if np.median(np.nan_to_num(differences, nan=np.inf)) <= SAME]
    subject.reproduces = alike[0] if alike else OWN
