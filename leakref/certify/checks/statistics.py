"""The one statistical judgement: whether a code's error exceeds the reference's by more than a margin."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
from scipy.special import stdtrit

from leakref._base import LeakrefError, finite, positive

__all__ = ["FALSE_ALARMS", "TESTS", "Excess", "excess", "share"]

FALSE_ALARMS = 1e-3
"""How often a whole run may reject a code that is no worse than the margin allows."""
TESTS = 6
"""Statistical tests in a full run: the cases of `leakage.bias`."""


@dataclass(frozen=True)
class Excess:
    """The `mean` of paired differences, its `standard_error`, and the `limit` that the mean must not exceed."""

    mean: float
    standard_error: float
    limit: float

    @property
    def over(self) -> float:
        """Error over tolerance: above 1 the mean exceeds the limit."""
        return max(self.mean, 0.0) / self.limit


def share(methods: int) -> float:
    """The false-alarm rate of one test, Bonferroni: a run's divided among its tests, and those among `methods`."""
    return FALSE_ALARMS / (TESTS * methods)


def excess(differences: npt.ArrayLike, margin: float, alpha: float) -> Excess:
    """Student's one-sided test that the mean of paired `differences` (R,) exceeds `margin`, at the rate `alpha`.

    The limit is margin + t(1 - alpha, R - 1) standard errors: a code whose true mean is at most the margin exceeds it
    with a probability of `alpha`, or less. Raises LeakrefError for fewer than two differences.
    """
    d = finite("excess", "differences", differences, 1)
    positive("excess", margin=margin, alpha=alpha)
    if d.size < 2:
        raise LeakrefError("excess", f"{d.size} differences", "give at least two")
    error = float(d.std(ddof=1) / np.sqrt(d.size))
    return Excess(float(d.mean()), error, margin - float(stdtrit(d.size - 1, alpha)) * error)
