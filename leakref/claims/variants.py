"""Every decision's variants: what another reader of the paper might have done, as changes to the chain.

Each is written as changes to the text of the literal chain and, where the compiled one does not follow by itself, of
that too; tests hold the two against each other. A decision without a variant stands in `NONE`, with the reason.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

from leakref.altered import Change, altered
from leakref.cases import Configuration
from leakref.claims.evidence import PLAIN, Setting
from leakref.decisions import DECISIONS
from leakref.methods import DEFAULT

__all__ = ["CONFIGURATIONS", "NONE", "VARIANTS", "Variant"]

CONFIGURATIONS = ("nsp-ls", "theta0-dtheta/direction=60,spread=15", "gamma/spread=15,peakedness=7", "L-T/L=5,T=10",
                  "L-T/L=5,T=80", "U/rotation=0,current=0.15,current_direction=-90",
                  "U/rotation=30,current=0.15,current_direction=0", "windows")
"""The eight on which the decisions are tried: a broad, a narrow and a peaked sea, coarse and long videos, an opposing
current (where the frequency of encounter matters), a crossing one that is rotated, the normal sea of the windows."""
_OPPOSING, _ROTATED, _WINDOWS = CONFIGURATIONS[5:]
_SPECTRA = {"grid", "dispersion", "sea", "cases", "window", "leakage", "fast.spectra"}


@dataclass(frozen=True)
class Variant:
    """In `words`, what is done instead of a `decision`; the same in the literal chain (`changes`) and, with those of
    `fast` beside them, in the compiled one.

    It acts on some `methods` only, and is tried on `windows` and `configurations`; if it `needs` a speed or a rotation,
    it acts on no other sea. If not `paired`, the waves are others, so that only statistics can be compared. `sense` is
    that of the rotation of the sea. Where the change is one of the data and not of the chain, it is a `setting`.
    `realizations` are the most that are worth while.

    Tests hold the two altered chains to each other's velocities.

    - `id`: what `leakref claims --decisions` and `leakref explain` call it; `decision`: the id of the one it goes
      against.
    - `methods`: those whose velocities it may change; the others are not computed.
    - `needs`: `speed`, `rotation`, or empty.
    """

    id: str
    decision: str
    words: str
    changes: tuple[Change, ...] = ()
    fast: tuple[Change, ...] = ()
    methods: tuple[str, ...] = DEFAULT
    windows: tuple[str, ...] = ("box", "hann")
    configurations: tuple[str, ...] = CONFIGURATIONS
    needs: str = ""
    paired: bool = True
    sense: int = 1
    setting: Setting = PLAIN
    realizations: int = 20

    @cached_property
    def chain(self) -> Any:
        """The chain so altered, compiled modules and cases included (`altered.altered`)."""
        return altered((*self.changes, *self.fast), fast=True)

    def acts_on(self, configuration: Configuration) -> tuple[str, ...]:
        """The windows of a configuration under which it changes anything: none, one, the tapers, or all. A variant
        tried on Hann acts on all tapers.
        """
        if self.needs and not getattr(configuration, self.needs):
            return ()
        if "box" in self.windows:
            return configuration.windows
        return tuple(w for w in configuration.windows if w in self.windows or ("hann" in self.windows and w != "box"))

    @property
    def leaves_spectra(self) -> bool:
        """The spectra are those of the reference: only what is made of them differs."""
        return not _SPECTRA & {change.module for change in (*self.changes, *self.fast)}


def _one(module: str, old: str, new: str) -> tuple[Change, ...]:
    return (Change(module, old, new),)


def _beside(method: str) -> Any:
    """Of a method beside the paper's: on a broad, a narrow and a coarse sea, ten times."""
    return {"methods": (method,), "configurations": (*CONFIGURATIONS[:2], CONFIGURATIONS[3]), "realizations": 10}


def _simplex(options: str) -> tuple[tuple[Change, ...], tuple[Change, ...]]:
    """C minimised by Nelder-Mead: over the bins themselves, and as the parabola that it is.

    The second pair of changes is for the compiled chain, where C is known as a parabola about its minimum and is
    minimised by the same search.
    """
    scipy = "import numpy as np\nfrom scipy.optimize import minimize\n"
    rest = f'np.zeros(2), method="Nelder-Mead", options={{{options}}}).x'
    return ((Change("leastsquares", "import numpy as np\n", scipy),
             Change("leastsquares", "np.linalg.solve(normal, k @ shift)",
                    f"minimize(lambda c: np.sum((c @ k - shift) ** 2), {rest}")),
            (Change("fast", "import numpy as np\n", scipy),
             Change("fast", "return Optimum(out[:2], float(out[2]), 2 * out[6:],",
                    "normal = out[[3, 4, 4, 5]].reshape(2, 2)\n        found = minimize(lambda c: out[2] + "
                    f"(c - out[:2]) @ normal @ (c - out[:2]), {rest}\n"
                    "        return Optimum(found, float(out[2]), 2 * out[6:],")))


_MEASURE = """def _measure(shell):
    k = np.hypot(shell.kx, shell.ky)
    return np.divide(1.0, k, out=np.zeros_like(k), where=k > 0)


def characteristic_function("""
_CONSTANT = "clipped = ring.width < DENSE or np.abs(centres).max() > nw - 3 - half"  # sum of the Gaussian
_COLUMNS = "        kx, ky = ring.kx[start : start + n] / ring.largest, ring.ky[start : start + n] / ring.largest\n"
_MEASURED = """        for i in range(n):
            k = np.hypot(ring.kx[start + i], ring.ky[start + i])
            for sums in (moments, ones):
                sums[:, i] *= ring.wavenumber / k if k > 0 else 0.0
"""
_POLISH = "_ascend(shell, fit.x * unit, width, unit)"
_CLIMB = "steps, arrived = _ascend(ring, models, simplex[0] * unit, 0.0, c, d)"
_NORM = "ring.columns.size * self.weight.sum() / self.sums[ring.columns].sum()"
_SEEN = "_Seen(disc, name, magnitude, rings)"
_LOW = "np.ascontiguousarray(magnitude[:, grid.bins(2) * grid.frequency_resolution <= 3 + 1e-9])"

VARIANTS: dict[str, Variant] = {v.id: v for v in (
    Variant("symmetric-hann", "D1", "Hann sampled symmetrically, n / (N - 1)",
            _one("window", "symmetric: bool = False", "symmetric: bool = True"),
            (Change("window", "if self.coefficients:\n            lines", 'if self.name == "box":\n            lines'),
             Change("fast.spectra", "for w in windows if w.coefficients]", 'for w in windows if w.name == "box"]'),
             Change("fast.spectra", "if not w.coefficients:", 'if w.name != "box":')), windows=("hann",)),
    Variant("printed-branch", "D2", "negative branch of G as printed, at -omega0 - k.c",
            (Change("nsp", "return shell.intrinsic + shift, -shell.intrinsic + shift",
                    "return shell.intrinsic + shift, -shell.intrinsic - shift"),
             Change("nsp", "for centre in _centres(shell, velocity):",
                    "for sign, centre in zip((1, -1), _centres(shell, velocity), strict=True):"),
             Change("nsp", "(g, 4 * z / width * g,", "(g, sign * 4 * z / width * g,")),
            _one("fast.score", "f[column if m + j >= 0 else f.shape[0] - 1 - column, n]", "f[column, n]"), ("nsp",)),
    Variant("edge-bins-out", "D3", "bins on the edge of a shell left out",
            _one("shell", "EDGE_MARGIN = 1e-9", "EDGE_MARGIN = -1e-9")),
    Variant("cut-at-3", "D4", "frequencies above omega = 3 left out",
            (Change("shell", "magnitude = np.abs(spectrum.values[a, b])",
                    "magnitude = np.abs(spectrum.values[a, b]) * (spectrum.omega <= 3 + 1e-9)"),
             Change("shell", "spectrum.omega, weight, magnitude",
                    "spectrum.omega, weight * (spectrum.omega <= 3 + 1e-9), magnitude")),
            (Change("fast", _SEEN, _SEEN.replace("magnitude", _LOW)),
             Change("fast", "self.even, m = grid.frequency_resolution, grid.shape[2] % 2 == 0, grid.bins(2)",
                    "self.even, m = grid.frequency_resolution, False, grid.bins(2)[: magnitude.shape[1]]"),
             Change("fast", "ring.centre, self.disc.grid.bins(2))", "ring.centre, np.arange(self.magnitude.shape[1]))"),
             Change("fast", "taps, is_even = _taps(width), grid.shape[2] % 2 == 0",
                    "taps, is_even = _taps(width), False"))),
    Variant("whole-weights", "D5", "weight 1, not 1/2, on omega = 0 and the Nyquist plane",
            _one("spectrum", "np.where((m == 0) | (2 * m == self.grid.shape[2]), 0.5, 1.0)", "np.ones(m.size)"),
            (Change("fast", "np.where((m == 0) | (2 * m == grid.shape[2]), 0.5, 1.0)", "np.ones(m.size)"),
             Change("fast.score", "if n == top and ring.even:\n                out[j] *= 0.5",
                    "if n == 0:\n                out[j] *= 2"),
             Change("fast.score", _CONSTANT, "clipped = True")), ("nsp",)),
    Variant("early-stop", "D6", "Nelder-Mead stopped at the defaults of MATLAB and SciPy, 1e-4 in c and N; no polish",
            (Change("nsp", '"xatol": 1e-8, "fatol": np.inf', '"xatol": 1e-4, "fatol": 1e-4'),
             Change("nsp", _POLISH, "fit.x * unit, 0, True")),
            (Change("fast", "ring, velocity, d = ring._replace(magnitude=self.magnitude)",
                    f"ring, velocity, d = ring._replace(magnitude=self.magnitude * ({_NORM}))"),
             Change("fast", f"        d *= {_NORM}\n", ""),
             Change("fast", "self.models.made[:] = 0\n        first",  # moments are kept, F is in another unit now
                    "self.models.made[:] = 0\n        self.models.cells[:] = np.iinfo(np.int64).min\n        first"),
             Change("fast.score", "if size <= 1e-8:",
                    "if size <= 1e-4 and max(abs(values[1] - values[0]), abs(values[2] - values[0])) <= 1e-4:"),
             Change("fast.score", _CLIMB, "c[:] = simplex[0] * unit\n    steps, arrived = 0, True\n"
                                         "    _derivatives(ring, models, c, _RADIUS, _RADIUS, d)")), ("nsp",)),
    Variant("large-simplex", "D6", "Nelder-Mead started with a simplex of 0.1 c0",
            _one("nsp", "START = 2.5e-4", "START = 0.1"), methods=("nsp",)),
    Variant("newton-from-rest", "D6", "Newton's method from c = 0, no simplex",
            _one("nsp", _POLISH, _POLISH.replace("fit.x * unit", "np.zeros(2)")),
            _one("fast.score", _CLIMB, _CLIMB.replace("simplex[0] * unit", "np.zeros(2)")), ("nsp",)),
    Variant("threshold-of-amplitude", "D7", "LS keeps bins above 0.2 of the shell's largest sqrt P, not P",
            _one("leastsquares", "THRESHOLD = 0.2", "THRESHOLD = 0.2**2"), methods=("ls",)),
    Variant("threshold-of-all", "D7", "LS keeps bins above 0.2 of the largest P of the whole spectrum",
            (Change("shell", "weight, magnitude, floor", "weight, magnitude / largest, floor"),
             Change("leastsquares", "(shell.magnitude / shell.magnitude.max()) ** 2", "shell.magnitude**2")),
            _one("fast", "least_squares(ring, self.largest, threshold, ",
                 "least_squares(ring, self.largest, threshold * (self.largest.max() / "
                 "self.largest[ring.columns].max()) ** 2, "), ("ls",)),
    Variant("ls-by-simplex", "D8", "C minimised by Nelder-Mead, to 1e-8",
            *_simplex('"xatol": 1e-8, "fatol": 1e-8, "maxfev": 5000, "maxiter": 5000'), methods=("ls",)),
    Variant("ls-early-stop", "D8", "C minimised by Nelder-Mead, stopped at the defaults of MATLAB and SciPy: 1e-4 in c "
            "and C, or 400 evaluations",
            *_simplex('"xatol": 1e-4, "fatol": 1e-4'), methods=("ls",)),
    Variant("denser-shells", "D9", "shells listed twice as densely, overlapping by 7/8",
            _one("chain", "return np.arange(np.ceil(smallest / dk - 1e-9), np.floor(largest / dk + 1e-9) + 1) * dk",
                 "return np.arange(2 * np.ceil(smallest / dk - 1e-9), 2 * np.floor(largest / dk + 1e-9) + 1) "
                 "* (dk / 2)"), realizations=5),
    Variant("finer-lattice", "D10", "spacing of the waves 0.25 / L", _one("sea", "INPUT_SPACING = 0.341",
                                                                          "INPUT_SPACING = 0.25"), paired=False),
    Variant("lattice-off-origin", "D10", "origin midway between the waves' lattice points",
            (Change("sea", "(index.ravel() for index in np.mgrid", "(index.ravel() + 0.5 for index in np.mgrid"),
             Change("sea", "uniform_phases(int(realization), i, j))",
                    "uniform_phases(int(realization), *((n - 0.5).astype(np.int64) for n in (i, j))))")), paired=False),
    Variant("waves-to-4", "D10", "waves up to 4 k_p, the largest wavenumber named, not 3.5",
            _one("sea", "LARGEST_WAVENUMBER = 3.5", "LARGEST_WAVENUMBER = 4.0")),
    Variant("other-phases", "D11", "another stream of random phases",
            _one("sea", "key=np.array([realization, 0]", "key=np.array([realization, 1]"), paired=False),
    Variant("about-corner", "D13", "sea and current turned about the corner (0, 0)",
            _one("sea", "shift = (self.kx - kx) * centre[0] + (self.ky - ky) * centre[1]", "shift = np.zeros(kx.size)"),
            configurations=(_ROTATED,), needs="rotation"),
    Variant("images-turned", "D13", "the images turned (cubic splines, cropped from larger ones), not the sea",
            configurations=(_ROTATED,), needs="rotation", setting=Setting(resampled=True), realizations=5),
    Variant("kaiser-2-pi", "D14", "Kaiser-Bessel with b = 2 pi: first zero at 2.24 bins",
            _one("window", "KAISER_SHAPE = float(np.pi * np.sqrt(3))", "KAISER_SHAPE = float(2 * np.pi)"),
            windows=("kaiser-bessel",), configurations=(_WINDOWS,)),
    Variant("kaiser-as-blackman", "D14", "Kaiser-Bessel with b = pi sqrt 8: first zero at three bins, as Blackman's",
            _one("window", "KAISER_SHAPE = float(np.pi * np.sqrt(3))", "KAISER_SHAPE = float(np.pi * np.sqrt(8))"),
            windows=("kaiser-bessel",), configurations=(_WINDOWS,)),
    Variant("printed-amplitudes", "D15", "amplitudes as printed: 2 k^-3/2 S f dk",
            _one("sea", "* f * dk**2", "* f * 2 * dk"), realizations=3),
    Variant("encounter-frequency", "D17", "S at the Doppler-shifted frequency",
            _one("sea", "jonswap(water.frequency(k) / peak, self.peakedness)",
                 "jonswap((water.frequency(k) + dk * np.sum(np.stack([i, j], axis=1) * "
                 "self.current.doppler_shift_velocity(k), axis=1)) / peak, self.peakedness)"),
            configurations=(_OPPOSING, _ROTATED), needs="speed"),
    Variant("polar-measure", "D18", "integrals with the measure dtheta dk: weight 1 / k (none at k = 0)",
            (Change("nsp", "def characteristic_function(", _MEASURE),
             Change("nsp", "np.sum(v @ shell.weight)) for v", "np.sum(v @ shell.weight * _measure(shell))) for v"),
             Change("nsp", "g = np.exp(-2 * z**2) * shell.weight\n",
                    "g = np.exp(-2 * z**2) * shell.weight * _measure(shell)[:, None]\n")),
            (Change("fast.score", _COLUMNS, _MEASURED + _COLUMNS), Change("fast.score", _CONSTANT, "clipped = True")),
            ("nsp",)),
    Variant("both-halves", "D19", "LS on both halves of the space",
            _one("leastsquares", "shift = shell.omega[m] - shell.intrinsic[column]\n",
                 "shift = np.concatenate([sign * shell.omega[m] - shell.intrinsic[column] for sign in (1, -1)])\n"
                 "    k = np.concatenate([k, -k], axis=1)\n"),
            _one("fast.leastsquares", "bx + kx * (m - ring.centre[n]), by + ky * (m - ring.centre[n])",
                 "bx + kx * m, by + ky * m"), ("ls",)),
    Variant("unit-by-shell", "D21", "the phase velocity at the shell's own wavenumber as the unit of the simplex",
            _one("nsp", "velocity_unit(k_i, water, peak_wavenumber)", "velocity_unit(k_i, water, k_i)"),
            _one("fast", "velocity_unit(float(k_i), water, peak_wavenumber)", "velocity_unit(k_i, water, k_i)"),
            ("nsp",)),
    Variant("other-sense", "D23", "video rotated clockwise", _one("cases", "sea.rotated(self.rotation,",
                                                                  "sea.rotated(-self.rotation,"),
            configurations=(_ROTATED,), needs="rotation", sense=-1),
    Variant("pcs-bin-alone", "D33", "a point of the polar current shell at the strongest bin itself",
            _one("pcs", "np.array([-1, 0, 1])", "np.array([0, 0, 0])"), **_beside("pcs")),
    Variant("pcs-weak-too", "D34", "columns from 0.05 of the largest power on, not 0.2",
            _one("pcs", "tops >= threshold)", "tops >= threshold / 4)"), **_beside("pcs")),
    Variant("pcs-plain-fit", "D34", "the sine curve fitted by least squares, outliers and all",
            _one("pcs", "np.where(inside, (1 - z**2) ** 2, 0.0)", "np.ones_like(z)")
            + _one("pcs", "np.where(inside, (1 - z**2) * (1 - 5 * z**2), 0.0)", "np.ones_like(z)"), **_beside("pcs")),
    Variant("lattice-of-0.05", "D35", "a lattice twice as fine, 0.05 c0",
            _one("nspgrid", "np.arange(-10, 11) / 10", "np.arange(-20, 21) / 20"), **_beside("nsp-grid")),
    Variant("widths-added", "D36", "a = 4 (domega + cg dk), not the root of the squares",
            _one("nspadaptive", "np.hypot(1.0, along_k / grid.frequency_resolution)",
                 "1.0 + along_k / grid.frequency_resolution"), **_beside("nsp-adaptive")),
    Variant("half-the-spread", "D36", "a = 4 sqrt(domega^2 + (cg dk / 2)^2)",
            _one("nspadaptive", "along_k / grid.frequency_resolution", "along_k / (2 * grid.frequency_resolution)"),
            **_beside("nsp-adaptive")),
    Variant("iterated-from-0.05", "D37", "weak bins from 0.05 of the largest power on, not 0.02",
            _one("lsiterative", "LOWER = 0.02", "LOWER = 0.05"), **_beside("ls-iterative")),
    Variant("iterated-from-0.005", "D37", "weak bins from 0.005 of the largest power on, not 0.02",
            _one("lsiterative", "LOWER = 0.02", "LOWER = 0.005"), **_beside("ls-iterative")),
    Variant("iterated-within-2", "D38", "bins within 2 domega of the dispersion surface, not 4",
            _one("lsiterative", "REACH = 4.0", "REACH = 2.0"), **_beside("ls-iterative")),
)}
"""Every variant that is computed, by id."""

NONE: dict[str, str] = {
    "D12": "a statistic of the velocities, not a velocity: with n the random part is 0.5 % smaller at n = 100",
    "D16": "both are always computed and shown",
    "D20": "every domain of the paper is square",
    "D22": "says which seas are run, not how",
    "D24": "no shell of the paper reaches the Nyquist wavenumber",
    "D25": "every shell of the paper has a number under NSP; see the variants of D7 for LS",
    **dict.fromkeys(("D26", "D27", "D28", "D29", "D30", "D31", "D32"),
                    "all water of the paper is deep, without surface tension"),
}
"""Decisions that move no velocity of the paper's cases by construction, and why."""

assert {v.decision for v in VARIANTS.values()} | set(NONE) == set(DECISIONS)
