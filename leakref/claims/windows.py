"""W: what the paper says about windows (sec:leakage, app:window_comparison, app:numdetails).

Eleven statements, W1 to W11. Most are about the windows themselves and need no sea: their transforms are looked at in
bins, over their value at zero.

- W1: how far the box leaks.
- W2, W3, W5: Blackman's lines, its sidelobes, its width against Hann's.
- W4: Hann at long and short range.
- W6, W7: the width a of eq:DSVkernel, fitted and varied.
- W8: in two dimensions leakage runs along the axes.
- W9: velocities under three tapers.
- W10: the central lobes, in one and in two dimensions.
- W11: what a width a that is too small, or too large, does.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from itertools import combinations

import numpy as np
from scipy.optimize import curve_fit

from leakref._base import FloatArray
from leakref.cases import CASES
from leakref.claims.configurations import domain, sea
from leakref.claims.evidence import Evidence, Setting
from leakref.claims.registry import claim
from leakref.claims.samples import STATISTICS, WINDOWS, Sample, in_resolutions, random, smaller
from leakref.claims.words import Reading, above, alike, both, either, every, pooled
from leakref.ensemble import Ensemble
from leakref.window import Window

__all__ = ["lobes"]

_BINS = 280  # of the paper's L = 10, T = 20
_FAR = 64.0


def lobes(window: Window) -> tuple[FloatArray, FloatArray]:
    """Offsets v in bins, and |transform| there, 1 at v = 0. (64001,) each, from 0 to 64 bins, a thousandth apart."""
    v = np.linspace(0.0, _FAR, 64_001)
    return v, np.abs(window.transform(v) / window.transform(0.0))


def _percent(value: float) -> float:
    return float(f"{100 * value:.4g}")


@claim(
    "W1",
    "untapered, the transform's envelope stays above 1 % for more than 20 bins",
    "sec:leakage",
    "The largest offset at which |transform of the box| exceeds 1 % of its maximum, in bins.",
)
def _(see: Evidence) -> Iterator[Reading]:
    """The transform of the box has zeros at every bin, so that its envelope is what stays: the last offset where any
    side lobe still reaches a hundredth is what counts.
    """
    v, height = lobes(see.window("box"))
    reach = float(v[height > 0.01].max())
    yield Reading({}, reach > 20, {"bins": round(reach, 2)})


@claim(
    "W2",
    "Blackman: a wave on a bin gives intensity only at bins 0, 1 and 2 away",
    "sec:leakage",
    "Discrete transform of the sampled window over its value at 0: above 1e-12 at bins 0 to 2, below at all "
    "others. Sampled as t/T is printed, n/N, and the other way, n/(N-1).",
)
def _(see: Evidence) -> Iterator[Reading]:
    """A periodic sampling has exactly three lines on either side; a symmetric one has a little everywhere."""
    for sampling in ("periodic", "symmetric"):
        lines = np.abs(np.fft.rfft(see.window("blackman").samples(_BINS, symmetric=sampling == "symmetric")))
        lines /= lines[0]
        beyond = float(lines[3:].max())
        yield Reading(
            {"sampling (D1)": sampling},
            bool(beyond < 1e-12 < lines[:3].min()),
            {"largest_beyond": float(f"{beyond:.1e}")},
        )


@claim(
    "W3",
    "Blackman falls to the order of 1e-3 outside its central lobe",
    "sec:leakage",
    "The largest |transform| beyond the first zero is of that order, within a factor of 2, or within 10 % of it.",
)
def _(see: Evidence) -> Iterator[Reading]:
    """A power of ten names an order of magnitude."""
    v, height = lobes(see.window("blackman"))
    top = float(height[v >= _first_zero(v, height)].max())
    figure = {"largest_sidelobe": float(f"{top:.4g}")}
    yield Reading({"about": "of that order"}, 0.5e-3 <= top <= 2e-3, figure)
    yield Reading({"about": "within 10 %"}, abs(top / 1e-3 - 1) <= 0.1, figure)


@claim(
    "W4",
    "Hann suppresses long-range leakage to below 1 %, and leaks significantly into frequencies less than two bins away",
    "sec:leakage",
    "|transform| below 1 % everywhere beyond the central lobe (long range is more than one or two bins), or from "
    "three bins on (the caption of fig:leakage_lobes calls one and two bins short range); above 1 % at one bin.",
)
def _(see: Evidence) -> Iterator[Reading]:
    """That it leaks at one bin belongs to the statement, and must hold in both readings."""
    v, height = lobes(see.window("hann"))
    near = float(height[np.searchsorted(v, 1.0)])
    for words, start in (("more than 2 bins away", 2.0), ("3 bins away or more", 3.0)):
        far = float(height[v >= start].max())
        yield Reading(
            {"long range": words},
            both(far < 0.01, near > 0.01),
            {"long_range_percent": _percent(far), "one_bin_percent": _percent(near)},
            parts={"long_range_below_1_percent": far < 0.01, "leaks_within_two_bins": near > 0.01},
        )


def _first_zero(v: FloatArray, height: FloatArray) -> float:
    """The first place where the transform all but vanishes, in bins."""
    falling = np.flatnonzero((height[1:-1] < 1e-3) & (height[1:-1] <= height[:-2]) & (height[1:-1] <= height[2:]))
    return float(v[falling[0] + 1])


@claim(
    "W5",
    "Blackman's central lobe is about 20 % wider than Hann's",
    "app:window_comparison",
    "Ratio of the widths at several levels less 1, within 18 to 22 %: at a tenth of the height, where the paper's 20 % "
    "are found; between zeros, at half power, at half height and at a hundredth.",
)
def _(see: Evidence) -> Iterator[Reading]:
    """The statement names no level, so that there is a reading for each."""
    curves = [lobes(see.window(name)) for name in ("blackman", "hann")]
    for words, level in (
        ("a tenth", 0.1),
        ("zeros", 0.0),
        ("half power", np.sqrt(0.5)),
        ("half height", 0.5),
        ("a hundredth", 0.01),
    ):
        wide, narrow = (v[np.argmax(height < level)] if level else _first_zero(v, height) for v, height in curves)
        wider = float(wide / narrow - 1)
        yield Reading({"level": words}, bool(0.18 <= wider <= 0.22), {"wider_percent": round(100 * wider, 2)})


@claim(
    "W6",
    "fitting G to the transform of a Hann window gives a = 1.62 domega",
    "app:numdetails",
    "Least squares of exp(-2 (v/a)^2), of height 1 or free, and |transform| over the central lobe or over 20 bins; "
    "a within 2 % of 1.62.",
)
def _(see: Evidence) -> Iterator[Reading]:
    """Four fits: the words leave open how far the lobe is fitted, and whether its height is."""
    v, height = lobes(see.window("hann"))
    for words, end in (("central lobe", _first_zero(v, height)), ("20 bins", 20.0)):
        on = v <= end
        for free in (False, True):
            start = [1.5, 1.0] if free else [1.5]
            a = float(curve_fit(_gaussian, v[on], height[on], start)[0][0])
            yield Reading(
                {"over": words, "height": "free" if free else "1"}, bool(abs(a / 1.62 - 1) <= 0.02), {"a": round(a, 4)}
            )


def _gaussian(v: FloatArray, a: float, height: float = 1.0) -> FloatArray:
    """G of eq:DSVkernel as a function of the offset v in bins, a in bins."""
    return height * np.exp(-2 * (v / a) ** 2)


@claim(
    "W7",
    "with a / domega from 2 to 6, results are most stable between 3 and 5",
    "app:numdetails",
    "Stable as scatter (random part, mean over shells, is larger at 2 and at 6 than at 3, 4 and 5) or as change "
    "with a (mean |c(a+1) - c(a)| is larger for the steps 2-3 and 5-6 than for 3-4 and 4-5), in units of the smaller "
    "resolution. Normal sea (theta0 = 90, spread 60 degrees) and narrow one (60, 15), L = 10, T = 20.",
)
def _(see: Evidence) -> Iterator[Reading]:
    """Stable may mean little scatter from sea to sea, or little change with a."""
    for words, one in (("normal", domain(10.0, 20.0)), ("narrow", sea(60.0, 15.0))):
        for window in WINDOWS:
            found = {a: see(one, window, setting=Setting(width=float(a))) for a in range(2, 7)}
            scatter = {a: in_resolutions(random(e), e).over() for a, e in found.items()}
            change = {a: in_resolutions(_moved(e, found[a + 1]), e).over() for a, e in found.items() if a < 6}
            for stable, by, inner, outer in (
                ("scatter", scatter, (3, 4, 5), (2, 6)),
                ("change", change, (3, 4), (2, 5)),
            ):
                yield from every(
                    {"stable": stable, "window": window, "sea": words},
                    outside=pooled(
                        *(above(replace(by[o] - by[i], sea=f"a = {o} against {i}")) for o in outer for i in inner)
                    ),
                )


def _moved(one: Ensemble, other: Ensemble) -> Sample:
    """Its mean is how far the velocities of one are from those of the other, realisation by realisation."""
    return Sample(one.wavenumbers, np.hypot(*np.moveaxis(other.velocities - one.velocities, -1, 0)))


def _envelope(window: Window, v: FloatArray) -> FloatArray:
    """Of the side lobes: the transform of a sum of cosines is sin(pi v) times a smooth function."""
    off = v + 1e-4  # clear of the zeros of the sine
    return np.minimum(np.abs(window.transform(off) / np.sin(np.pi * off)), window.transform(0.0))


@claim(
    "W8",
    "two-dimensional leakage runs along the axes; at a given |k| it is smallest at |kx| = |ky|",
    "sec:NSP_and_leakage",
    "Envelope of the transform along x times that along y, on circles of 3 to 30 bins: largest within the central "
    "lobe about an axis, smallest within 1 degree of the diagonal. Box, as in the text, and Hann.",
)
def _(see: Evidence) -> Iterator[Reading]:
    """Envelopes, not transforms, are compared: zeros between lobes would make any direction the smallest somewhere."""
    angle = np.radians(np.arange(0, 91))
    for window in WINDOWS:
        taper = see.window(window)
        leaked = np.array(
            [_envelope(taper, r * np.cos(angle)) * _envelope(taper, r * np.sin(angle)) for r in range(3, 31)]
        )
        diagonal, axis = (
            np.abs(leaked.argmin(axis=1) - 45) <= 1,
            (np.arange(3, 31) * np.abs(np.sin(2 * angle[leaked.argmax(axis=1)])) / 2 <= _first_zero(*lobes(taper))),
        )
        gain = leaked[7].max() / leaked[7].min()
        yield Reading(
            {"window": window},
            bool(diagonal.all() and axis.all()),
            {
                "circles": len(axis),
                "smallest_on_diagonal": int(diagonal.sum()),
                "largest_on_axis": int(axis.sum()),
                "axis_over_diagonal_at_10_bins": float(f"{gain:.3g}"),
            },
        )


@claim(
    "W9",
    "DSVs after Hann, Blackman and Kaiser-Bessel tapers differ insignificantly, Blackman's biases being "
    "systematically higher",
    "app:window_comparison",
    "No significant difference of bias or random part between Hann and Kaiser-Bessel, or between any two of the "
    "three; Blackman's bias above both others. Normal sea, L = 10, T = 20, paired.",
)
def _(see: Evidence) -> Iterator[Reading]:
    names = ("hann", "kaiser-bessel", "blackman")
    found = {name: see(CASES["windows"][0], name) for name in names}
    higher = pooled(
        *(above(STATISTICS["bias"](found["blackman"]) - STATISTICS["bias"](found[name])) for name in names[:2])
    )
    for words, pairs in (("all but Blackman", [names[:2]]), ("all three", list(combinations(names, 2)))):
        same = pooled(
            *(alike(of(found[a]) - of(found[b]), smaller(found[a])) for a, b in pairs for of in STATISTICS.values())
        )
        yield from either({"alike": words}, alike=same, Blackman_higher=higher)


@claim(
    "W10",
    "central lobes are one (box) and two (Hann) bins wide; in two dimensions Hann broadens by about one bin in all "
    "directions",
    "sec:DSV_example, fig:leakage_illustration2D",
    "The first zero of |transform| at 1 and at 2 bins, within 1 %, or the full width at half height so. On a lattice "
    "of bins a wave on one of them lights that alone (box), and with Hann its neighbours on all eight sides too, and "
    "none beyond; or the first zero in every direction from 0 to 45 degrees moves outwards by 0.9 to 1.1 bins.",
)
def _(see: Evidence) -> Iterator[Reading]:
    """Lobes are named by the distance of their zeros, as is usual; the full width at half height is beside it."""
    curves = {name: lobes(see.window(name)) for name in WINDOWS}
    zeros = {name: _first_zero(*curve) for name, curve in curves.items()}
    halves = {name: 2 * float(v[np.argmax(height < 0.5)]) for name, (v, height) in curves.items()}
    blocks = [np.abs(np.fft.fft(see.window(name).samples(_BINS))) for name in WINDOWS]
    lit = [[n for n in range(-3, 4) if line[n] > 1e-9 * line[0]] for line in blocks]
    on_bins = lit == [[0], [-1, 0, 1]]
    outwards = [(zeros["hann"] - zeros["box"]) / np.cos(angle) for angle in np.radians((0.0, 45.0))]
    radial = all(0.9 <= gain <= 1.1 for gain in outwards)
    for width, found in (("to the first zero", zeros), ("full, at half height", halves)):
        wide = abs(found["box"] - 1) <= 0.01 and abs(found["hann"] - 2) <= 0.02
        for words, broadened in (("of a wave on a bin", on_bins), ("of the first zero", radial)):
            yield Reading(
                {"width": width, "broadening": words},
                both(wide, broadened),
                {
                    "box_bins": round(found["box"], 3),
                    "hann_bins": round(found["hann"], 3),
                    "outwards_along_and_between_axes": [round(float(gain), 3) for gain in outwards],
                },
                parts={"one_and_two_bins": wide, "one_bin_broader": broadened},
            )


@claim(
    "W11",
    "too small a width a lets single bright pixels decide, too large a one raises the influence of leakage",
    "app:numdetails",
    "Untapered, the narrow sea (theta0 = 60, spread 15 degrees) or the normal one (90, 60), means over shells in units "
    "of the smaller resolution: the random part at a = 2 above that at 4; the bias at a = 6, or at 8, above that at 4.",
)
def _(see: Evidence) -> Iterator[Reading]:
    """Single pixels are what differs from realisation to realisation; leakage is what stays in the mean."""
    for words, one in (("narrow", sea(60.0, 15.0)), ("normal", domain(10.0, 20.0))):
        found = {a: see(one, "box", setting=Setting(width=float(a))) for a in (2, 4, 6, 8)}
        scatter, mean = (
            {a: in_resolutions(of(e), e).over() for a, e in found.items()} for of in (random, STATISTICS["bias"])
        )
        for large in (6, 8):
            yield from every(
                {"sea": words, "too large": f"{large}"},
                small_scatters=above(scatter[2] - scatter[4]),
                large_leaks=above(mean[large] - mean[4]),
            )
