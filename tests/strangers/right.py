"""Right codes of other algorithms than leakref's, each declared as an honest owner would. None may be rejected.

Right means: within the resolution (eq:dcdwk) in a sea of enough periods, whatever its sizes, and the signs and units
what they are said to be. How they get there is theirs: `tests/test_strangers.py` holds them to seas of its own.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from types import MappingProxyType

import numpy as np
from scipy.ndimage import map_coordinates

from strangers.parts import (
    climb,
    cosines,
    gated,
    overlap_in,
    read,
    spectrum_of,
    straight_fit,
    strong_fit,
)

CLOSER = (0.8, 0.6, 0.4, 0.3, 0.2, 0.1, 0, 0, 0)
"""Half widths of a gate around the dispersion relation, of omega0: from none at all to a few bins."""
TURN = np.linspace(0, 2 * np.pi, 24, endpoint=False)


class Code:
    """A velocity for each wavenumber from the spectrum of the tapered cube; classes below say how, in `velocity`."""

    method = ""
    windows = ("box", "hann")
    said: Mapping[str, object] = MappingProxyType({})

    def describe(self):
        named = {"methods": [self.method]} if self.method else {}
        can = {"extract": {**named, "windows": list(self.windows)}}
        return {"name": type(self).__doc__ or "", "units": "si", "can": can, **self.said}

    def extract(self, surface, spacing, wavenumbers, *, gravity, window):
        spectrum = self.spectrum(read(surface), spacing, window)
        return [
            self.velocity(spectrum, float(k), gravity) if spectrum.reaches(k) and spectrum.power.any() else None
            for k in wavenumbers
        ]

    def spectrum(self, eta, spacing, window):
        return spectrum_of(eta, spacing, [cosines(window, n) for n in eta.shape])

    def velocity(self, spectrum, k, gravity):
        return climb(overlap_in(spectrum.shell(k), gravity, 4 * spectrum.domega), np.sqrt(gravity / k))


class Cylinder(Code):
    """NSP on the cylinder |k| = k_i, interpolated (eq:maskedSpec as printed)"""

    method = "nsp-cylinder"

    def velocity(self, spectrum, k, gravity):
        nx, ny, _ = spectrum.shape
        angle = np.linspace(0, 2 * np.pi, 8 * int(np.ceil(k / min(spectrum.widths[:2]))), endpoint=False)
        kx, ky = k * np.cos(angle), k * np.sin(angle)
        places = [-kx / spectrum.widths[0] % nx, -ky / spectrum.widths[1] % ny]  # the order of the transform
        cube = np.sqrt(spectrum.power).reshape(nx, ny, -1)
        frames = [map_coordinates(frame, places, order=1, mode="grid-wrap") for frame in np.moveaxis(cube, 2, 0)]
        shell = replace(spectrum, kx=kx, ky=ky, power=np.stack(frames, axis=1) ** 2)
        return climb(overlap_in(shell, gravity, 4 * spectrum.domega), np.sqrt(gravity / k))


class IterativeLeastSquares(Code):
    """iterative least squares (Senet, Seemann and Ziemer 2001), three bins at least"""

    method = "ls-iterative"
    gate, share = 3.0, 0.05

    def velocity(self, spectrum, k, gravity):
        shell = spectrum.shell(k)
        c = strong_fit(shell, gravity)
        for _ in range(12):
            if c is None:
                return None
            kx, ky, doppler, power = gated(shell, gravity, c, self.gate, self.share)
            if kx.size < 2 * 3:  # each stands in both halves
                return None
            c = self.fit(kx, ky, doppler, power)
        return c

    def fit(self, kx, ky, doppler, power):
        return straight_fit(kx, ky, doppler)


class Huber(IterativeLeastSquares):
    """Huber regression, three bins at least"""

    method = "huber"
    gate = 6.0

    def fit(self, kx, ky, doppler, power):
        weight = np.ones(kx.size)
        for _ in range(10):
            if (c := straight_fit(kx, ky, doppler, weight)) is None:
                return None
            rest = np.abs(doppler - kx * c[0] - ky * c[1])
            weight = 1 / np.maximum(rest / (1.345 * 1.483 * np.median(rest) + 1e-9), 1)
        return c


class WeightedLeastSquares(IterativeLeastSquares):
    """least squares weighted by power"""

    method = "ls-weighted"
    share = 0.01

    def fit(self, kx, ky, doppler, power):
        return straight_fit(kx, ky, doppler, power)


class Slices(Code):
    """the strongest bins of each frequency, of both halves of the spectrum, to one branch"""

    method = "ls-slices"
    windows = ("hann",)

    def velocity(self, spectrum, k, gravity):
        shell, c = spectrum.shell(k), np.zeros(2)
        for part in CLOSER:
            gate = max(3, part * np.sqrt(gravity * k) / shell.domega)
            kx, ky, doppler, power = gated(shell, gravity, c, gate, 0.01)
            slice_ = np.rint((doppler + np.sqrt(gravity * np.hypot(kx, ky))) / shell.domega).astype(int)
            top = np.full(2 * shell.omega.size + 1, 0.0)
            np.maximum.at(top, slice_, power)
            strong = power >= 0.3 * top[slice_]
            new = straight_fit(kx[strong], ky[strong], doppler[strong], power[strong])
            c = c if new is None else new
        return c


class Band(Code):
    """one velocity for the whole band, by least squares, always tapered"""

    method = "ls-band"
    windows = ("hann",)

    def describe(self):
        said = super().describe()
        said["can"]["extract"]["resolves"] = "band"
        return said

    def extract(self, surface, spacing, wavenumbers, *, gravity):
        spectrum = self.spectrum(read(surface), spacing, "hann")
        shells = [s for s in (spectrum.shell(float(k)) for k in wavenumbers) if s.power.any()]
        if not shells:
            return [None]
        c = np.zeros(2)
        for part in CLOSER:
            gate = max(3, part * np.sqrt(gravity * np.mean(wavenumbers)) / spectrum.domega)
            kx, ky, doppler, _ = np.concatenate([gated(s, gravity, c, gate, 0.05) for s in shells], axis=1)
            new = straight_fit(kx, ky, doppler)
            c = c if new is None else new
        return [c]


class Welch(Code):
    """NSP of the mean power of three half-overlapping segments, for at least eight periods of the peak"""

    method = "nsp-welch"
    said = MappingProxyType({"cube": {"smallest": [16, 16, 60]}})

    def spectrum(self, eta, spacing, window):
        half = eta.shape[2] // 2
        parts = [super(Welch, self).spectrum(eta[:, :, n : n + half], spacing, window) for n in (0, half // 2, half)]
        return replace(parts[0], power=sum(part.power for part in parts) / 3)


class Denoised(Code):
    """NSP of the bins that stand out of the noise: above four times the median of their shell"""

    method = "nsp-denoised"

    def velocity(self, spectrum, k, gravity):
        shell = spectrum.shell(k)
        magnitude = np.sqrt(np.where(shell.power > 4 * np.median(shell.power), shell.power, 0.0))
        return climb(overlap_in(shell, gravity, 4 * shell.domega, magnitude), np.sqrt(gravity / k))


class Positive(Code):
    """the paper's NSP, omega > 0 only and in full weight"""

    method = "nsp"

    def velocity(self, spectrum, k, gravity):
        shell = spectrum.shell(k)
        weight = (shell.omega > 0).astype(float)
        return climb(overlap_in(shell, gravity, 4 * shell.domega, weight=weight), np.sqrt(gravity / k))


def even(surface, spacing, wavenumbers, *, gravity, window):
    """NSP of an even number of frames: the last of an odd number is dropped. A bare function."""
    eta = read(surface)
    code = Scaled()
    return code.extract(eta[:, :, : eta.shape[2] // 2 * 2], spacing, wavenumbers, gravity=gravity, window=window)


class Scaled(Code):
    """NSP in scaled units"""

    method = "nsp"
    said = MappingProxyType({"units": "scaled"})


class Lattice(Code):
    """NSP from the best point of a lattice of velocities"""

    method = "nsp-lattice"

    def velocity(self, spectrum, k, gravity):
        shell, unit = spectrum.shell(k), np.sqrt(gravity / k)
        overlap = overlap_in(shell, gravity, 4 * shell.domega)
        fastest = min(unit, (shell.omega[-1] - np.sqrt(gravity * k)) / k - 3 * 4 * shell.domega / k)
        steps = np.linspace(-fastest, fastest, 15) if fastest > 0 else [0.0]
        tried = [(u, v) for u in steps for v in steps if np.hypot(u, v) <= fastest]
        return climb(overlap, unit, max(tried, key=overlap) if tried else (0.0, 0.0))


class PolarSearch(Code):
    """the paper's NSP, its maximum looked for in speed and direction"""

    method = "nsp"

    def velocity(self, spectrum, k, gravity):
        shell, unit = spectrum.shell(k), np.sqrt(gravity / k)
        overlap = overlap_in(shell, gravity, 4 * shell.domega)
        first = max(TURN, key=lambda angle: overlap(1e-2 * unit * np.array([np.cos(angle), np.sin(angle)])))

        def polar(there):
            speed, angle = there[0], first + there[1]
            return overlap(unit * speed * np.array([np.cos(angle), np.sin(angle)]))

        speed, angle = climb(polar, 1.0, (1e-2, 0.0), step=1e-2)
        return unit * speed * np.array([np.cos(first + angle), np.sin(first + angle)])


class PolarCurrentShell(Code):
    """polar current shell (Shen and Huang 2015): a cosine through the ridge of power over direction and frequency"""

    method = "pcs"
    windows = ("hann",)
    said = MappingProxyType({"axes": "tyx", "y": "down"})

    def extract(self, surface, spacing, wavenumbers, *, gravity, window):
        return super().extract(np.transpose(surface, (2, 1, 0)), spacing, wavenumbers, gravity=gravity, window=window)

    def velocity(self, spectrum, k, gravity):
        shell, c = spectrum.shell(k), np.zeros(2)
        for part in CLOSER:
            gate = max(4, part * np.sqrt(gravity * k) / shell.domega)
            kx, ky, doppler, power = gated(shell, gravity, c, gate, 0.0)
            sector = np.floor((np.arctan2(ky, kx) / (2 * np.pi) % 1) * TURN.size).astype(int) % TURN.size
            energy = np.bincount(sector, power, TURN.size)
            known = energy > 0.02 * energy.max()
            mean = [np.bincount(sector, power * x, TURN.size)[known] / energy[known] for x in (kx, ky, doppler)]
            new = straight_fit(*mean, energy[known])
            c = c if new is None else new
        return c


class HannOnly(Code):
    """NSP, always tapered"""

    method = "nsp"
    windows = ("hann",)


class BlackmanOnly(Code):
    """NSP under a Blackman window, always"""

    method = "nsp-blackman"
    windows = ("blackman",)


class Multitaper(Code):
    """NSP of the mean power under sine tapers, two for each axis"""

    method = "nsp-multitaper"
    windows = ("sine",)

    def spectrum(self, eta, spacing, window):
        tapers = [[np.sin(np.pi * j * np.arange(n) / n) for j in (1, 2)] for n in eta.shape]
        parts = [spectrum_of(eta, spacing, (x, y, t)) for x in tapers[0] for y in tapers[1] for t in tapers[2]]
        return replace(parts[0], power=sum(part.power for part in parts))


class SinglePrecision(Code):
    """NSP in single precision"""

    method = "nsp"

    def spectrum(self, eta, spacing, window):
        eta = eta / np.abs(eta).max() if eta.any() else eta
        tapers = [cosines(window, n).astype(np.float32) for n in eta.shape]
        return spectrum_of(eta.astype(np.float32), spacing, tapers)


class Adaptive(Code):
    """NSP whose width grows with the group velocity (appendix A 2)"""

    method = "nsp-adaptive"

    def velocity(self, spectrum, k, gravity):
        group = np.sqrt(gravity / k) / 2
        width = np.hypot(3 * spectrum.domega, group * spectrum.dk)
        return climb(overlap_in(spectrum.shell(k), gravity, width), np.sqrt(gravity / k))


class Energy(Code):
    """the energy within a band around the dispersion relation, compared with the band's width"""

    method = "energy"
    windows = ("hann",)

    def velocity(self, spectrum, k, gravity):
        shell = spectrum.shell(k)
        return climb(overlap_in(shell, gravity, 4 * shell.domega, shell.power), np.sqrt(gravity / k))


class FromLeastSquares(Code):
    """NSP from the least-squares current on, coming-from"""

    method = "nsp-from-ls"
    said = MappingProxyType({"direction": "from"})

    def velocity(self, spectrum, k, gravity):
        shell, unit = spectrum.shell(k), np.sqrt(gravity / k)
        start = strong_fit(shell, gravity)
        overlap = overlap_in(shell, gravity, 4 * shell.domega)
        candidates = [np.zeros(2)] + ([start] if start is not None and np.hypot(*start) < unit else [])
        return -climb(overlap, unit, max(candidates, key=overlap))


def called(kind, method):
    """A code that goes by another method's name, or by none."""
    code = kind()
    code.method = method
    return code


RIGHT = {
    "cylinder": Cylinder,
    "cylinder-called-nsp": lambda: called(Cylinder, "nsp"),  # as its equation stands in the paper
    "cylinder-unnamed": lambda: called(Cylinder, ""),
    "ls-iterative": IterativeLeastSquares,
    "huber": Huber,
    "ls-weighted": WeightedLeastSquares,
    "ls-slices": Slices,
    "ls-band": Band,
    "welch": Welch,
    "denoised": Denoised,
    "positive": Positive,
    "even": lambda: even,
    "scaled": Scaled,
    "lattice": Lattice,
    "lattice-called-nsp": lambda: called(Lattice, "nsp"),  # as the paper's co-author does
    "adaptive-unnamed": lambda: called(Adaptive, ""),
    "huber-unnamed": lambda: called(Huber, ""),
    "polar-search": PolarSearch,
    "pcs": PolarCurrentShell,
    "hann-only": HannOnly,
    "blackman-only": BlackmanOnly,
    "multitaper": Multitaper,
    "single-precision": SinglePrecision,
    "adaptive": Adaptive,
    "energy": Energy,
    "from-ls": FromLeastSquares,
}
"""Makers of codes by id."""
