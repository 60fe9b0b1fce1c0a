"""The pictures of `leakref plan`: errors against wavelength, and how they change with one parameter.

Wavelengths are in metres, velocities in m/s. What is drawn comes from `Expected` and is not computed here.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from textwrap import fill
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.figure import Figure
from matplotlib.ticker import LogLocator, NullFormatter, ScalarFormatter

from leakref.figures import COLOURS, SIGNS, WINDOW_WORDS, figure, styled
from leakref.methods import METHODS
from leakref.planning.plan import Expected, Plan

__all__ = ["plan_figure", "sweep_figure"]

Ways = Mapping[tuple[str, str], Expected]


def _wavelength_axis(ax: Any) -> None:
    """Logarithmic, in metres, with numbers at 1, 2 and 5."""
    ax.set_xscale("log")
    ax.xaxis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
    ax.xaxis.set_major_formatter(ScalarFormatter())
    ax.xaxis.set_minor_formatter(NullFormatter())


def _lowest(ways: Iterable[Expected]) -> float:
    """Where the axis of the errors begins: at half of the smallest of them."""
    lines = [values for e in ways for values in (e.bias, 2 * e.random)]
    values = np.concatenate(lines)
    return float(values[values > 0].min(initial=np.inf, where=np.isfinite(values[values > 0]))) / 2


@styled
def plan_figure(plan: Plan, title: str) -> Figure:
    """Bias above, twice the random part below, m/s against wavelength; untapered left, tapered right.

    Solid and dashed grey: the velocity resolutions. Shaded: where NSP and a taper can be trusted. Dotted: the current.
    Bands are two standard errors of the bias, where there are two methods. The axis begins below the smallest number
    that is drawn as a line; a band that reaches lower is cut there.
    """
    lowest = _lowest(plan.ways.values())
    windows, methods = (list(dict.fromkeys(key[n] for key in plan.ways)) for n in (0, 1))
    drawing, axes = figure(2, len(windows), width=8.5, sharex=True, sharey=True)
    for (window, method), e in plan.ways.items():
        look = {"color": COLOURS[methods.index(method)], "lw": 1.4, "label": METHODS[method].title}
        if len(methods) > 2:
            n = methods.index(method)
            look |= {"marker": SIGNS[n % len(SIGNS)], "markevery": (n, len(methods)), "ms": 4}
        column = windows.index(window)
        axes[0, column].plot(e.wavelengths, e.bias, **look)
        if len(methods) <= 2:
            axes[0, column].fill_between(
                e.wavelengths,
                np.maximum(e.bias - 2 * e.standard_error, lowest),
                e.bias + 2 * e.standard_error,
                color=look["color"],
                alpha=0.2,
                lw=0,
                label=rf"{METHODS[method].title} $\pm$ 2 standard errors",
            )
        axes[1, column].plot(e.wavelengths, 2 * e.random, **look)
    best = plan.best
    for ax in axes.flat:
        for values, line, what in zip(best.resolutions, ("-", "--"), ("frequency", "wavenumber"), strict=True):
            ax.plot(
                best.wavelengths,
                values,
                color="0.55",
                ls=line,
                lw=1,
                zorder=0,
                label=f"resolution from {what}",
            )
        if plan.campaign.speed:
            ax.axhline(plan.campaign.speed, color="black", ls=":", lw=1, label="the true current")
    for ax in axes[:, windows.index("hann")]:
        ax.fill_between(
            best.wavelengths,
            0,
            1,
            where=best.trusted,
            color=COLOURS[2],
            alpha=0.1,
            lw=0,
            transform=ax.get_xaxis_transform(),
            label="a single flight is to be trusted (NSP)",
        )
    for column, window in enumerate(windows):
        axes[0, column].set_title(WINDOW_WORDS[window])
        axes[1, column].set_xlabel("wavelength (m)")
    axes[0, 0].set_ylabel(r"bias: mean of $|\tilde{c} - U|$ (m/s)")
    axes[1, 0].set_ylabel(r"random: 2 $\sigma$ of $|\tilde{c} - U|$ (m/s)")
    axes[0, 0].set_yscale("log")
    axes[0, 0].set_ylim(bottom=lowest)
    _wavelength_axis(axes[0, 0])
    drawing.legend(*axes[0, windows.index("hann")].get_legend_handles_labels(), loc="outside lower center", ncols=3)
    drawing.suptitle(fill(title, 115), fontsize=9)
    return drawing


@styled
def sweep_figure(label: str, values: Sequence[float], found: Sequence[Ways], title: str) -> Figure:
    """The bias against wavelength for each value of the parameter, a panel for each window and method, in m/s.

    Bands are two standard errors. The axis begins below the smallest bias.

    `label` names the parameter with its unit; dark to bright is its first to its last value. `found` has, for each
    value, what `plan.expected` gives.
    """
    windows, methods = (list(dict.fromkeys(key[n] for key in found[0])) for n in (0, 1))
    drawing, axes = figure(len(methods), len(windows), width=8.5, sharex=True, sharey=True)
    biases = np.concatenate([e.bias for ways in found for e in ways.values()])
    lowest = float(np.nanmin(biases[biases > 0])) / 2
    shades = mpl.colormaps["viridis"](np.linspace(0, 0.92, len(values)))
    for value, ways, shade in zip(values, found, shades, strict=True):
        for (window, method), e in ways.items():
            ax, error = axes[methods.index(method), windows.index(window)], 2 * e.standard_error
            ax.plot(e.wavelengths, e.bias, color=shade, lw=1.4, label=f"{value:.4g}")
            ax.fill_between(
                e.wavelengths, np.maximum(e.bias - error, lowest), e.bias + error, color=shade, alpha=0.15, lw=0
            )
    for row, method in enumerate(methods):
        axes[row, 0].set_ylabel(f"{METHODS[method].title}: bias (m/s)")
    for column, window in enumerate(windows):
        axes[0, column].set_title(WINDOW_WORDS[window])
        axes[-1, column].set_xlabel("wavelength (m)")
    axes[0, 0].set_yscale("log")
    axes[0, 0].set_ylim(bottom=lowest)
    _wavelength_axis(axes[0, 0])
    drawing.legend(
        *axes[0, 0].get_legend_handles_labels(),
        loc="outside right center",
        title=f"{label},\nbands: ± 2\nstandard errors",
    )
    drawing.suptitle(fill(title, 115), fontsize=9)
    return drawing
