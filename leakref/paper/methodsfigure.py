"""How methods do beside each other, over several seas: the figure of `leakref guide methods`.

Of each sea and method it shows the error |c - U| from the peak up, its mean and its standard deviation over
realisations in units of the smaller velocity resolution, and in how many shells there is no number.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib.figure import Figure

from leakref._base import FloatArray
from leakref.ensemble import Ensemble
from leakref.figures import COLOURS, SIGNS, WINDOW_WORDS, figure, styled
from leakref.methods import METHODS

__all__ = ["methods_figure", "summary"]

ROWS = (r"mean of $|\tilde{c} - U|$", r"$\sigma$ of $|\tilde{c} - U|$", "shells without\na number (%)")


def summary(e: Ensemble) -> tuple[float, float, float]:
    """Mean and standard deviation of |c - U| from k = 1 up over the smaller resolution, and the share of shells of all
    wavenumbers without a number. With a sheared current U is that of each wavenumber.
    """
    truth = np.asarray(getattr(e.configuration, "truth", e.configuration.current))
    error = np.hypot(*np.moveaxis(e.velocities - truth, -1, 0))
    known, high = np.isfinite(error), e.wavenumbers >= 1 - 1e-9
    unit = np.minimum(*e.resolutions)

    def over(values: FloatArray) -> float:
        return float(np.nanmean((values / unit)[high]))

    return over(np.nanmean(error, axis=0)), over(np.nanstd(error, axis=0, ddof=1)), float(1 - known.mean())


@styled
def methods_figure(ensembles: Sequence[Ensemble], title: str) -> Figure:
    """A column for each window, a point for each method and configuration; the resolution is the grey line at one."""
    windows = list(dict.fromkeys(e.window for e in ensembles))
    methods = list(dict.fromkeys(e.method for e in ensembles))
    seas = list(dict.fromkeys(e.configuration.id for e in ensembles))
    drawing, axes = figure(3, len(windows), width=9.0, height=2.4, sharex=True, sharey="row")
    found = {(e.window, e.method, e.configuration.id): summary(e) for e in ensembles}
    for column, window in enumerate(windows):
        for n, method in enumerate(methods):
            x = np.arange(len(seas)) + (n - (len(methods) - 1) / 2) * 0.11  # beside each other, not on each other
            values = np.array([found[window, method, sea] for sea in seas]) * [1, 1, 100]
            look = {"color": COLOURS[n % len(COLOURS)], "marker": SIGNS[n % len(SIGNS)], "ms": 4, "ls": ""}
            for row in range(3):
                axes[row, column].plot(x, values[:, row], label=METHODS[method].title, **look)
        axes[0, column].set_title(WINDOW_WORDS[window])
        axes[2, column].set_xticks(range(len(seas)), _words(seas), fontsize=7, rotation=30, ha="right")
    for row, words in enumerate(ROWS):
        axes[row, 0].set_ylabel(words + "\nover the resolution" * (row < 2))
        if row < 2:
            axes[row, 0].set_yscale("log")
            for ax in axes[row]:
                ax.axhline(1, color="0.55", lw=1, zorder=0)
    drawing.legend(*axes[0, 0].get_legend_handles_labels(), loc="outside lower center", ncols=len(methods))
    drawing.suptitle(title)
    return drawing


def _words(identifiers: Sequence[str]) -> list[str]:
    """Ids below an axis: what distinguishes each from others of its case, and the case."""
    parts = {one: set(one.partition("/")[2].split(",")) for one in identifiers}
    said = []
    for one in identifiers:
        case, _, rest = one.partition("/")
        others = [parts[other] for other in identifiers if other.partition("/")[0] == case and other != one]
        own = [word for word in rest.split(",") if not others or not all(word in other for other in others)]
        said.append(", ".join(own) + f"\n{case}")
    return said
