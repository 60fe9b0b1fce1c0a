"""The picture of case depth: the mean error over wavenumber, with the depth known and with deep water assumed.

A row for each method and a column for each window. The distance between the full line and the dashed one of a colour is
what the missing depth costs; `depth` has the same in figures.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from leakref.ensemble import Ensemble
from leakref.figures import COLOURS, WINDOW_WORDS, figure, styled
from leakref.methods import METHODS

__all__ = ["depth_figure"]

_WAYS = ((True, "-", "depth known"), (False, "--", "deep water assumed"))


@styled
def depth_figure(ensembles: Sequence[Ensemble], title: str) -> Figure:
    """Mean of |c| in c0 over k / k0 for each depth; `ensembles` are of case depth, known and assumed deep alike.

    Grey are the velocity resolutions: the line that from frequency, the band that from wavenumber over all depths,
    since the group velocity is another one in each.
    """
    methods = list(dict.fromkeys(e.method for e in ensembles))
    windows = list(dict.fromkeys(e.window for e in ensembles))
    depths = sorted({e.configuration.depth for e in ensembles})
    colours = dict(zip(depths, (COLOURS[1], COLOURS[4], COLOURS[2], COLOURS[0]), strict=False))
    ways = {e.configuration.assumed is None for e in ensembles}
    drawing, axes = figure(len(methods), len(windows), width=8.0, height=2.9, sharex=True, sharey=True)
    for e in ensembles:
        ax = axes[methods.index(e.method), windows.index(e.window)]
        known = e.configuration.assumed is None
        colour = colours.get(e.configuration.depth, "black")
        ax.plot(e.wavenumbers, e.bias, color=colour, ls="-" if known else "--", lw=1.4 if known else 1.2)
    k, (from_frequency, _) = ensembles[0].wavenumbers, ensembles[0].resolutions
    from_wavenumber = np.array([e.resolutions[1] for e in ensembles])
    for (row, column), ax in np.ndenumerate(axes):
        ax.plot(k, from_frequency, color="0.45", lw=1, zorder=0)
        ax.fill_between(k, from_wavenumber.min(axis=0), from_wavenumber.max(axis=0), color="0.8", lw=0, zorder=0)
        ax.set_yscale("log")
        ax.set_title(f"{METHODS[methods[row]].title}, {WINDOW_WORDS[windows[column]]}")
    for ax in axes[-1]:
        ax.set_xlabel("$k$ / $k_0$")
    for ax in axes[:, 0]:
        ax.set_ylabel(r"mean of $|\tilde{c}|$ / $c_0$")
    handles = [
        *(Line2D([], [], color=colours.get(kh, "black"), lw=1.4, label=f"$k_0 h$ = {kh:g}") for kh in depths),
        *(Line2D([], [], color="black", ls=line, label=words) for known, line, words in _WAYS if known in ways),
        Line2D([], [], color="0.45", lw=1, label="resolution from frequency"),
        Line2D([], [], color="0.8", lw=6, label="resolution from wavenumber"),
    ]
    drawing.legend(handles=handles, loc="outside lower center", ncols=4)
    drawing.suptitle(title)
    return drawing
