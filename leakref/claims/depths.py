"""B: what leakage does to a depth inferred from the waves, which the paper leaves open (its Introduction).

One statement, B1, on seas of case-L-T over bottoms at k0 h = 0.7, 1, 1.5, 2, by the extension of NSP in
`leakref.depth`.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from leakref._base import FloatArray
from leakref.claims.evidence import Evidence
from leakref.claims.registry import claim
from leakref.claims.samples import WINDOWS, Sample
from leakref.claims.words import Reading, Tally, every, most, pooled, significant
from leakref.paper.inferred import BAND, DEPTHS, WAVENUMBERS, Depths, domain

_LOW = (WAVENUMBERS >= 0.5) & (WAVENUMBERS < 1)  # the paper shows nothing below 0.5
_SOURCES = {
    "shells at 0.5 <= k < 1, current known": "known",
    "shells at 0.5 <= k < 1, current inferred along": "along",
    "the whole band, current inferred along": "band",
}


def _errors(e: Depths, source: str) -> tuple[Sample, FloatArray]:
    """h / h_true - 1 of the shells or of the band, and the smaller depth resolution there; of the band, that at k0."""
    if source == "band":
        at_peak = np.abs(WAVENUMBERS - 1).argmin()
        return Sample(np.zeros(1), e.off[:, [BAND]]), e.resolution[[at_peak]]
    return Sample(WAVENUMBERS[_LOW], e.off[:, :BAND][:, _LOW]), e.resolution[_LOW]


@claim(
    "B1",
    "leakage at low k disturbs an inferred depth",
    "Introduction",
    "The paper leaves it open. k0 h = 0.7, 1, 1.5, 2, L = 10, T = 20: the mean of h / h_true - 1 differs significantly "
    "from zero, by over two standard errors and over 10 % of the smaller depth resolution (by how much h changes where "
    "the dispersion surface moves by a bin). Shells below the peak with the current known (the nearest reading) or "
    "inferred along, and the whole band; untapered and Hann. Realisations without a depth are counted, not judged.",
)
def _(see: Evidence) -> Iterator[Reading]:
    """With a known current a shell fixes its depth, so that what is wrong is not the ambiguity with a current."""
    for (words, source), window in ((item, name) for item in _SOURCES.items() for name in WINDOWS):
        current = "known" if source == "known" else "along"
        found = [e for kh in DEPTHS for e in see.depths(domain(kh)) if (e.window, e.current) == (window, current)]
        each = [_errors(e, source) for e in found]
        disturbed = pooled(*(significant(sample, resolution) for sample, resolution in each))
        for holds, counted in ((most, "most"), (every, "every")):
            (reading,) = holds({"source": words, "window": window, "holds at": counted}, disturbed=disturbed)
            yield replace(reading, figure=_figure(disturbed, each))


def _figure(disturbed: Tally, each: list[tuple[Sample, FloatArray]]) -> dict[str, object]:
    """Counts as of every claim; the smallest and the largest mean error in percent; and the share without a depth."""
    means = np.concatenate([sample.mean for sample, _ in each])
    known = 100 * means[np.isfinite(means)]
    without = np.mean(np.concatenate([np.isnan(sample.values).ravel() for sample, _ in each]))
    span = [round(float(one), 1) for one in (known.min(), known.max())] if known.size else None
    return {**disturbed.figure, "error in percent": span, "without a depth": round(float(without), 3)}
