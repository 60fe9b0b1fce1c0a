"""Pictures: one style, colours that the colour-blind can tell apart, vector and PNG.

`figure` makes axes in the house style, `result_figure` draws what the paper's figures of results show, `save` writes
PNG and SVG. No window is ever opened, and nothing depends on a display. Importing this module imports matplotlib.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from pathlib import Path
from typing import Any, Protocol

import matplotlib as mpl
import numpy as np
from cycler import cycler
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from leakref._base import FloatArray
from leakref._output import write_whole
from leakref.cases import Configuration
from leakref.methods import METHODS
from leakref.window import WINDOWS

__all__ = ["COLOURS", "SIGNS", "WINDOW_WORDS", "Result", "figure", "result_figure", "save", "styled"]

COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#000000")
"""Okabe and Ito."""
_STYLE: Any = {
    "font.size": 9,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "grid.alpha": 0.25,
    "legend.frameon": False,
    "legend.fontsize": 8.6,  # so that its subscripts, 0.7 of it, are of 6 points
    "axes.titlesize": 10,
    "axes.prop_cycle": cycler(color=COLOURS),
    "svg.hashsalt": "leakref",
    "figure.dpi": 150,
}
styled = mpl.rc_context(_STYLE)
"""Decorates what draws: within it every artist has the style of the house."""
_LINES = ("-", "--", ":", "-.")
_MARKERS = ("", "o", "^", "s")
SIGNS = ("o", "s", "^", "D", "v", "X")
"""Of methods, where there are so many that their lines may lie on each other."""
_WORDS = {
    "direction": r"$\theta_0$ = {:g}°",
    "spread": r"$\Delta\theta$ = {:g}°",
    "peakedness": r"$\gamma$ = {:g}",
    "length": "$L$ = {:g}",
    "duration": "$T$ = {:g}",
    "speed": "$U$ = {:g}",
    "current_direction": r"$\theta_U$ = {:g}°",
    "rotation": "rotated by {:g}°",
}
_TURN = 120.0  # degrees
WINDOW_WORDS = {window.name: window.title or window.name for window in WINDOWS.values()}
"""Windows as a reader calls them."""


class Result(Protocol):
    """Statistics of a configuration under one window and method: an Ensemble, or what a golden set keeps of one. Arrays
    are (n,), `mean` (n, 2), in `c0`.
    """

    @property
    def configuration(self) -> Configuration: ...
    @property
    def window(self) -> str: ...
    @property
    def method(self) -> str: ...
    @property
    def wavenumbers(self) -> FloatArray: ...
    @property
    def bias(self) -> FloatArray: ...
    @property
    def random(self) -> FloatArray: ...
    @property
    def mean(self) -> FloatArray: ...
    @property
    def resolutions(self) -> tuple[FloatArray, FloatArray]: ...


@styled
def figure(rows: int, columns: int, *, width: float = 8.0, height: float = 2.7, **kwargs: Any) -> tuple[Figure, Any]:
    """An empty figure in the house style with its axes, (rows, columns).

    `width` is that of the figure and `height` that of a row, in inches; further keywords are those of `subplots`.
    """
    drawing = Figure(figsize=(width, height * rows + 0.4), layout="constrained")
    FigureCanvasAgg(drawing)
    return drawing, drawing.subplots(rows, columns, squeeze=False, **kwargs)


@styled
def save(drawing: Figure, path: Path) -> list[Path]:
    """Write `path` as PNG and as SVG, each whole or not at all; the same figure gives the same bytes. `path` has no
    suffix. Returned are both paths, the PNG first.
    """
    kinds: dict[str, dict[str, Any]] = {".png": {"Software": None}, ".svg": {"Date": None}}
    return [
        write_whole(path.with_name(path.name + kind), partial(drawing.savefig, metadata=metadata, dpi=150))
        for kind, metadata in kinds.items()
    ]


@styled
def result_figure(ensembles: Sequence[Result], title: str, *, logarithmic: bool = False) -> Figure:
    """The form of fig:spec_ex: a column for each of two windows; mean of |c| above, twice its standard deviation below.

    Solid and dashed grey: the velocity resolutions from frequency and from wavenumber, with the duration or the length
    that each belongs to where there are several. With a current a third row gives the direction of the mean velocity
    (fig:ConstCurr), dash-dotted lines the true speeds, and the second row is logarithmic, since it is small beside its
    first points. Colour, line and marker follow the first, second and third parameter that differs. `ensembles` are all
    of one case; more than two windows are drawn in one column. With `logarithmic` both upper rows are.
    """
    windows = list(dict.fromkeys(e.window for e in ensembles))
    beside = windows if len(windows) <= 2 else [""]  # more are compared in one column (fig:DSV_win_comp_results)
    methods = list(dict.fromkeys(e.method for e in ensembles))
    varied = dict.fromkeys(name for e in ensembles for name in e.configuration.varied)
    differing = [name for name in varied if len({getattr(e.configuration, name) for e in ensembles}) > 1]
    with_current = any(e.configuration.speed for e in ensembles)
    drawing, axes = figure(
        3 if with_current else 2, len(beside), width=8.0 if len(beside) > 1 else 6.0, sharex=True, sharey="row"
    )
    keys = (
        [("window", windows)] * (len(beside) == 1 < len(windows))
        + [("method", methods)] * (len(methods) > 1)
        + [(name, sorted({getattr(e.configuration, name) for e in ensembles})) for name in differing]
    )
    looks: list[tuple[str, Sequence[Any]]] = [("color", COLOURS), ("linestyle", _LINES), ("marker", _MARKERS)]
    if len(keys) > 3:
        looks = [*looks, ("alpha", (1.0, 0.6, 0.4))]
    known = WINDOW_WORDS | {record.id: record.title for record in METHODS.values()}
    for e in ensembles:
        column = beside.index(e.window) if e.window in beside else 0
        own = {"window": e.window, "method": e.method, **{name: getattr(e.configuration, name) for name in differing}}
        look = {
            what: choices[values.index(own[key]) % len(choices)]
            for (key, values), (what, choices) in zip(keys, looks, strict=False)
        }
        look = {"color": COLOURS[0], "lw": 1.3, "ms": 3, "markevery": 3, **look}
        if len(methods) > 2:  # which may well lie on each other: each has a sign of its own, where no other has one
            n = methods.index(e.method)
            look |= {"marker": SIGNS[n % len(SIGNS)], "markevery": (n, len(methods)), "ms": 4}
        k = e.wavenumbers
        words = [
            known.get(own[key]) or _WORDS[key].format(own[key])
            for key, _ in keys
            if key != "current_direction" or e.configuration.speed
        ]
        label = ", ".join(words) or METHODS[e.method].title
        axes[0, column].plot(k, e.bias, label=label, **look)
        axes[1, column].plot(k, 2 * e.random, **look)
        if with_current:
            _directions(axes[2, column], k, np.degrees(np.arctan2(*e.mean.T[::-1])), look)
    for ax in axes[:2].flat:
        _resolutions(ax, ensembles, named=ax in axes[:, -1])
    for column, name in enumerate(beside):
        axes[0, column].set_title(WINDOW_WORDS.get(name, name))
        axes[-1, column].set_xlabel("$k$ / $k_0$")
    for row, what in enumerate((r"mean of $|\tilde{c}|$ / $c_0$", r"2 $\sigma$ of $|\tilde{c}|$ / $c_0$")):
        axes[row, 0].set_ylabel(what)
        if logarithmic or (row == 1 and with_current and any((e.random > 0).any() for e in ensembles)):
            axes[row, 0].set_yscale("log")
        else:
            axes[row, 0].set_ylim(bottom=0)
    for speed in sorted({e.configuration.speed for e in ensembles} - {0.0}):
        for ax in axes[0]:
            ax.axhline(speed, color="black", ls="-.", lw=0.8, zorder=0, label="true speed")
    if with_current:
        axes[2, 0].set_ylabel("direction of the mean (°)")
        axes[2, 0].set_ylim(-180, 180)
        axes[2, 0].set_yticks(range(-180, 181, 90))
    once = dict(zip(*axes[0, 0].get_legend_handles_labels()[::-1], strict=True))  # each label once
    labels = list(once)
    drawing.legend(
        [once[label] for label in labels],
        labels,
        loc="outside right upper" if len(labels) > 8 else "outside lower center",
        ncols=1 if len(labels) > 8 else min(2 + len(beside), len(labels)),
    )
    drawing.suptitle(title)
    return drawing


def _directions(ax: Any, k: FloatArray, degrees: FloatArray, look: dict[str, Any]) -> None:
    """A line of directions, with a dot at each, that is broken where it turns by more than `_TURN`: from 179 to -179
    degrees is no way round, and a mean that passes through zero has none in between.
    """
    broken = np.flatnonzero(np.abs(np.diff(degrees)) > _TURN) + 1
    x, y = np.insert(k, broken, np.nan), np.insert(degrees, broken, np.nan)
    ax.plot(x, y, **{**look, "marker": ".", "markevery": 1})


def _resolutions(ax: Any, ensembles: Sequence[Result], *, named: bool) -> None:
    """The two resolutions of every grid, each once; `named`, with its duration or its length at the end of the line."""
    ways = (("-", "resolution from frequency", "duration", "T"), ("--", "resolution from wavenumber", "length", "L"))
    last = max(e.wavenumbers[-1] for e in ensembles)
    for n, (line, words, quantity, letter) in enumerate(ways):
        each = {getattr(e.configuration, quantity): (e.wavenumbers, e.resolutions[n]) for e in ensembles}
        for number, (size, (k, resolution)) in enumerate(each.items()):
            ax.plot(k, resolution, color="0.45", ls=line, lw=1, zorder=0, label=words if number == 0 else None)
            if named and len(each) > 1:
                ax.annotate(
                    f"${letter}$ = {size:g}",
                    (last, resolution[-1]),
                    (4 + 34 * n, 0),  # in two columns: the lines of the two kinds may well end together
                    textcoords="offset points",
                    va="center",
                    fontsize=7,
                    color="0.35",
                    annotation_clip=False,
                )
