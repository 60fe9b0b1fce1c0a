"""The figures of the paper that show no results: what leakage is, and how the method works, from their captions.

Four figures, each a function without arguments, drawn from the captions: they share the paper's parameters and not its
drawings. The windows, seas and spectra are the chain's own.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import MultipleLocator
from mpl_toolkits.mplot3d import Axes3D
from scipy.ndimage import map_coordinates

from leakref import leakage, nsp
from leakref._base import FloatArray
from leakref.currents import UniformCurrent
from leakref.dispersion import DEEP
from leakref.figures import COLOURS, WINDOW_WORDS, figure, styled
from leakref.grid import Grid
from leakref.sea import LARGEST_WAVENUMBER, SeaState, jonswap
from leakref.spectrum import Spectrum
from leakref.window import window

__all__ = ["ILLUSTRATIONS", "cylinder", "leakage_lobes", "spectrum_examples", "two_dimensional_leakage"]

_FAINTEST = 1e-5


@styled
def leakage_lobes() -> Figure:
    """fig:leakage_lobes: transforms of the windows over their values at zero, far out and near by. Offsets are in bins;
    long-range leakage is what lies beyond a few of them.
    """
    drawing, axes = figure(1, 2, width=8.5, height=3.2, sharey=True, width_ratios=(2, 1))
    for ax, furthest in zip(axes[0], (25, 4), strict=True):
        v = np.linspace(0, furthest, 200 * furthest + 1)
        for name, colour, line in zip(
            ("box", "hann", "blackman", "kaiser-bessel"), COLOURS, ("-", "-", "-", "--"), strict=False
        ):
            taper = window(name)
            relative = np.abs(taper.transform(v) / taper.transform(0.0))
            ax.semilogy(
                v, np.maximum(relative, _FAINTEST / 10), color=colour, ls=line, lw=1.1, label=WINDOW_WORDS[name]
            )
        ax.set_xlabel(r"$f$ / $\delta\omega$ (pixels)")
        ax.set_xlim(0, furthest)
    axes[0, 0].set_ylim(_FAINTEST, 1.5)
    axes[0, 0].set_ylabel(r"$|\mathcal{F}\{w\}(f)|$ / $\mathcal{F}\{w\}(0)$")
    drawing.legend(*axes[0, 0].get_legend_handles_labels(), loc="outside lower center", ncols=4)
    drawing.suptitle("Transforms of windows: long-range leakage, and its price near by")
    return drawing


@styled
def spectrum_examples() -> Figure:
    """fig:spectrum_examples: S(omega), and the amplitudes along the mean direction, over their peaks. The amplitudes
    are those of eq:amplitudes along the mean direction, and end at the largest wavenumber of the waves.
    """
    drawing, axes = figure(2, 1, width=6.0, height=2.5)
    top, bottom = axes[:, 0]
    k = np.linspace(1e-3, 4.0, 4000)
    for gamma, colour, line in zip((1.0, 3.3, 7.0), COLOURS, ("-", "--", "-."), strict=False):
        energy = jonswap(DEEP.frequency(k), gamma)
        amplitude = np.where(k <= LARGEST_WAVENUMBER, np.sqrt(DEEP.density_factor(k) * energy), 0.0)
        for ax, x, y in ((top, DEEP.frequency(k), energy), (bottom, k, amplitude)):
            ax.plot(x, y / y.max(), color=colour, ls=line, lw=1.3, label=rf"$\gamma$ = {gamma:g}")
    top.set_xscale("function", functions=(np.square, lambda square: np.sqrt(np.maximum(square, 0))))
    top.set_xlim(0, 2)
    top.set_xticks([0.5, 1, 1.25, 1.5, 1.75, 2])
    bottom.set_xlim(0, 4)
    top.set_xlabel(r"$\omega$ / $\omega_0$, drawn over $\omega^2 = k$")
    bottom.set_xlabel("$k$ / $k_0$")
    top.set_ylabel(r"$S(\omega)$ / its peak")
    bottom.set_ylabel(r"$a(k, \theta_0)$ / its peak")
    top.legend(loc="upper right")
    drawing.suptitle("JONSWAP spectra and the amplitudes of their waves")
    return drawing


@styled
def two_dimensional_leakage() -> Figure:
    """fig:leakage_illustration2D: four sine waves, the first on a bin, the last half way between bins.

    Triangles are the waves, circles the bins of the transform; left without a window, right with Hann. Waves are seen
    through `Window.response`, exactly, with their mirror images; no transform is taken.
    """
    size, i, j = 64, np.arange(0, 33), np.arange(0, 17)
    waves = [(5 + 7 * n + n / 6, 8 + n / 6) for n in range(4)]
    drawing, axes = figure(1, 2, width=9.0, height=3.0, sharey=True)
    for ax, name in zip(axes[0], ("box", "hann"), strict=True):
        taper = window(name)
        x, y = np.array(waves).T
        seen = taper.response(i, x, size) @ taper.response(j, y, size).T
        seen = np.abs(seen + taper.response(i, -x, size) @ taper.response(j, -y, size).T)
        level = np.log10(np.maximum(seen / seen.max(), _FAINTEST))
        image = ax.pcolormesh(i, j, level.T, cmap="cividis", vmin=-4, vmax=0, shading="nearest", rasterized=True)
        ax.plot(
            *(values.ravel() for values in np.meshgrid(i, j)), "o", mfc="none", mec="white", ms=1.6, mew=0.3, alpha=0.7
        )
        ax.plot(x, y, "^", color=COLOURS[1], mec="white", ms=6, label="waves")
        ax.set_title(WINDOW_WORDS[name])
        ax.set_xlabel(r"$k_x$ / $\delta k$ (bins)")
        ax.set_aspect("equal")
        ax.yaxis.set_major_locator(MultipleLocator(4))
        ax.grid(visible=False)
    axes[0, 0].set_ylabel(r"$k_y$ / $\delta k$ (bins)")
    drawing.colorbar(image, ax=axes[0], label=r"$\log_{10}$ of $|S|$ / its largest", shrink=0.8)
    bins = Line2D([], [], ls="", marker="o", mfc="none", mec="0.4", ms=4, label="bins of the transform")
    drawing.legend(handles=[bins, axes[0, 0].lines[-1]], loc="outside lower center", ncols=2)
    drawing.suptitle("Leakage in two dimensions runs along the axes")
    return drawing


_RADIUS, _CURRENT = 1.2, (0.25, 0.0)  # k_i of the cylinder in k0, and the current in c0


def _surface(ax: Axes3D, velocity: tuple[float, float], colour: str, title: str) -> None:
    """The dispersion surface omega0(k) + k.U, and where a cylinder of radius k_i cuts it."""
    radius, angle = np.meshgrid(np.linspace(0, 1.7, 25), np.linspace(0, 2 * np.pi, 61))
    x, y = radius * np.cos(angle), radius * np.sin(angle)
    ax.plot_surface(
        x,
        y,
        DEEP.frequency(radius) + x * velocity[0] + y * velocity[1],
        color="0.8",
        alpha=0.45,
        linewidth=0.2,
        edgecolor="0.6",
        rstride=4,
        cstride=4,
    )
    theta, height = np.meshgrid(np.linspace(0, 2 * np.pi, 61), np.array([0.0, 2.0]))
    ax.plot_surface(_RADIUS * np.cos(theta), _RADIUS * np.sin(theta), height, color=COLOURS[5], alpha=0.2, linewidth=0)
    theta = np.linspace(0, 2 * np.pi, 181)
    x, y = _RADIUS * np.cos(theta), _RADIUS * np.sin(theta)
    ax.plot(x, y, DEEP.frequency(_RADIUS) + x * velocity[0] + y * velocity[1], color=colour, lw=2)
    ax.set_title(title)
    ax.set(xticks=(-1, 0, 1), yticks=(-1, 0, 1), zticks=(0, 1, 2))
    ax.set_xlabel("$k_x$ / $k_0$", labelpad=-4)
    ax.set_ylabel("$k_y$ / $k_0$", labelpad=-4)
    ax.set_zlabel(r"$\omega$ / $\omega_0$", labelpad=-6)
    ax.tick_params(labelsize=7, pad=-2)
    ax.set_box_aspect((1, 1, 0.9), zoom=0.95)
    ax.view_init(elev=16, azim=-62)


def _unrolled(spectrum: Spectrum, theta: FloatArray) -> FloatArray:
    """F of eq:maskedSpec at k_i (cos theta, sin theta), by linear interpolation between bins: (theta, nw). What is
    drawn at an angle lies between bins; the chain itself never interpolates.
    """
    order = np.ix_(np.argsort(spectrum.i), np.argsort(spectrum.j))
    magnitude = np.abs(spectrum.values[order])
    dkx, dky, _ = spectrum.grid.bin_widths
    at = np.stack([_RADIUS * np.cos(theta) / dkx - spectrum.i.min(), _RADIUS * np.sin(theta) / dky - spectrum.j.min()])
    return np.stack([map_coordinates(plane, at, order=1) for plane in np.moveaxis(magnitude, 2, 0)], axis=1)


@styled
def cylinder() -> Figure:
    """fig:cylinderIllustration: the dispersion surface cut by a cylinder, in still water and with a current, and the
    magnitude on the cylinder unrolled, with the cut in still water and the fit by NSP.

    The magnitude is that of one realisation of a broad sea (L = 10, T = 20, tapered) on the current. The dashed line is
    where all energy would be in still water, the full one where the fit puts it.
    """
    grid = Grid.scaled(10, 20)
    waves = SeaState(direction=60, spread=180, length=10, current=UniformCurrent(_CURRENT)).components(0)
    spectrum = leakage.spectrum(waves, grid, "hann", largest_wavenumber=_RADIUS + 0.4)
    u, v = nsp.extract(spectrum, [_RADIUS], search=False, gravity=1.0).velocities[0]
    drawing, empty = figure(2, 1, width=7.0, height=3.1, height_ratios=(1.35, 1))
    empty[0, 0].set_axis_off()
    for column, (velocity, colour, title) in enumerate(
        (((0.0, 0.0), COLOURS[0], "(a) still water"), (_CURRENT, COLOURS[1], "(b) with a current"))
    ):
        ax: Any = drawing.add_subplot(2, 2, column + 1, projection="3d", computed_zorder=True)
        _surface(ax, velocity, colour, title)
    ax = empty[1, 0]
    degrees = np.linspace(-180, 180, 361)
    theta = np.radians(degrees)
    seen = _unrolled(spectrum, theta)
    image = ax.pcolormesh(
        degrees, spectrum.omega, (seen / seen.max()).T, cmap="Greys", shading="nearest", rasterized=True
    )
    still = DEEP.frequency(_RADIUS)
    ax.plot(degrees, np.full(theta.size, still), color=COLOURS[0], ls="--", lw=1.6, label="still water")
    fit = still + _RADIUS * (u * np.cos(theta) + v * np.sin(theta))
    ax.plot(degrees, fit, color=COLOURS[1], lw=1.6, label=rf"NSP: $\tilde{{c}}$ = ({u:.2f}, {v:.2f}) $c_0$")
    ax.set_ylim(0.4, 2.0)
    ax.set_xlim(-180, 180)
    ax.set_xticks(range(-180, 181, 60))
    ax.set_xlabel(r"$\theta$ (°)")
    ax.set_ylabel(r"$\omega$ / $\omega_0$")
    ax.set_title(rf"(c) the cylinder $k_i$ = {_RADIUS:g} $k_0$ unrolled")
    ax.legend(loc="upper left")
    drawing.colorbar(image, ax=ax, label="$F_i$ / its largest")
    return drawing


ILLUSTRATIONS: dict[str, tuple[str, Callable[[], Figure]]] = {
    "fig:leakage_lobes": ("leakage_lobes", leakage_lobes),
    "fig:spectrum_examples": ("spectrum_examples", spectrum_examples),
    "fig:leakage_illustration2D": ("leakage_2d", two_dimensional_leakage),
    "fig:cylinderIllustration": ("cylinder", cylinder),
}
"""By the paper's label: the end of the file's name, and what draws it."""
