"""Faults: the reference chain with one thing wrong, by name.

One list serves twice. As mutants the faults measure the suite: each has a *killing input*, a finding where its effect
is at least ten times the tolerance, and each is killed by the family of checks meant for it. As hypotheses they
explain: what a failing implementation does is compared with what each fault does. Nearly all are one changed line of
the chain; `altered` proves that the line is there. What no line of the chain can do, such as remembering the last call,
is a few lines around it.

A fault may leave a code *sound* in the sense of the grades: a bin more or less in a shell is another algorithm, not a
wrong one. Such faults are killed by `conformance` alone.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from leakref._base import LeakrefError
from leakref.altered import Change, altered
from leakref.certify.strength.fault import (
    CENTRES,
    DEEP_ROOT,
    FOURIER,
    HALF,
    INTRINSIC,
    KX,
    LENGTHS,
    POLISH,
    SHIFTED,
    SI,
    TAPER_SPACE,
    UNPOLISHED,
    WAVES,
    WIDE,
    Drifting,
    Fault,
    Remembering,
    answer,
    asked,
    unchecked,
)
from leakref.certify.subject.named import Named

__all__ = ["FAULTS", "implementation"]

_FRAME = (
    Fault("negated-current", "frame", "signs", "the current is returned as its negative", (answer("-FOUND"),)),
    Fault("flipped-x", "frame", "signs", "the x component has the wrong sign", (answer("FOUND * [-1, 1]"),)),
    Fault("flipped-y", "frame", "signs", "the y component has the wrong sign", (answer("FOUND * [1, -1]"),)),
    Fault("exchanged-axes", "frame", "signs", "x and y exchanged", (answer("FOUND[:, ::-1]"),)),
    Fault("quarter-turn", "frame", "signs", "the current is turned by a quarter turn",
          (answer("FOUND[:, ::-1] * [-1, 1]"),)),
    Fault("rows-downwards", "frame", "signs", "the rows of the cube are counted downwards",
          (asked("surface", "np.asarray(surface)[:, ::-1]"),)),
    Fault("reversed-time", "frame", "signs", "the frames are read in reverse order",
          (asked("surface", "np.asarray(surface)[:, :, ::-1]"),)),
    Fault("exchanged-cube", "frame", "signs", "the cube is read with x and y exchanged, its spacings are not",
          (asked("surface", "np.swapaxes(surface, 0, 1)"),)),
    Fault("absolute-value", "frame", "signs", "the components are returned without their signs",
          (answer("np.abs(FOUND)"),)),
    Fault("no-cross-component", "frame", "signs", "the y component is always zero", (answer("FOUND * [1, 0]"),)),
    Fault("frames-out-of-order", "frame", "recovery", "the frames are in the order of their names: 10 before 2",
          (asked("surface", "np.asarray(surface)[:, :, sorted(range(np.shape(surface)[2]), key=str)]"),)),
    Fault("frames-skipped", "frame", "recovery", "every second frame is left out, the time step is that of all",
          (asked("surface", "np.asarray(surface)[:, :, ::2]"),)),
    Fault("exchanged-spacing", "frame", "recovery", "dx and dy exchanged",
          (asked("spacing", "(spacing[1], spacing[0], spacing[2])"),)),
    Fault("square-pixels", "frame", "recovery", "dx is used for dy as well",
          (asked("spacing", "(spacing[0], spacing[0], spacing[2])"),)),
)
_UNITS = (
    Fault("hertz-for-radians", "units", "recovery", "frequencies are in Hz where rad/s are meant",
          (Change("spectrum", "self.grid.bins(2) * self.grid.frequency_resolution",
                  "self.grid.bins(2) * self.grid.frequency_resolution / (2 * np.pi)"),)),
    Fault("cycles-for-radians", "units", "recovery", "the wavenumbers asked for are divided by 2 pi",
          (asked("wavenumbers", "np.asarray(wavenumbers) / (2 * np.pi)"),)),
    Fault("degrees-for-radians", "units", "signs", "the direction of the current is put into cos and sin in degrees",
          (answer("(lambda v: np.hypot(*v.T)[:, None] * np.stack([f(np.degrees(np.arctan2(v[:, 1], v[:, 0]))) "
                   "for f in (np.cos, np.sin)], axis=1))(FOUND)"),)),
    Fault("gravity-dropped", "units", "recovery", "gravity is taken as 1 in metres and seconds",
          (SI, Change("shell", INTRINSIC, "DEEP.frequency(k[a, b])"))),
    Fault("gravity-hard-coded", "units", "recovery", "gravity is 10 whatever is asked for",
          (SI, Change("shell", INTRINSIC, "Water(10.0).frequency(k[a, b])"))),
    Fault("knots", "units", "recovery", "the current is returned in knots",
          (SI, answer("FOUND * 1.943844"))),
    Fault("pixels-per-frame", "units", "recovery", "the current is returned in pixels per frame",
          (answer("FOUND * spacing[2] / np.asarray(spacing[:2])"),)),
    Fault("frame-rate", "units", "recovery", "the frame rate is used for the time step",
          (asked("spacing", "(spacing[0], spacing[1], 1 / spacing[2])"),)),
    Fault("unit-time-step", "units", "recovery", "the time step is taken as 1",
          (asked("spacing", "(spacing[0], spacing[1], 1.0)"),)),
    Fault("doppler-frequency", "units", "recovery", "the velocity is multiplied by its wavenumber",
          (answer("FOUND * np.asarray(wavenumbers)[:, None]"),)),
    Fault("one-interval-short", "units", "recovery", "lengths and the duration are (n - 1) d",
          (Change("grid", LENGTHS, "return (nx - 1) * dx, (ny - 1) * dy, (nt - 1) * dt"),)),
    Fault("width-short", "units", "recovery", "the length along x alone is (n - 1) dx",
          (Change("grid", LENGTHS, LENGTHS.replace("nx * dx", "(nx - 1) * dx")),)),
    Fault("exchanged-counts", "units", "recovery", "the numbers of samples along x and y exchanged in the lengths",
          (Change("grid", LENGTHS, LENGTHS.replace("nx * dx, ny * dy", "ny * dx, nx * dy")),)),
    Fault("duration-short", "units", "recovery", "the duration is (n - 1) dt",
          (Change("grid", LENGTHS, LENGTHS.replace("nt *", "(nt - 1) *")),)),
)
_SYNTHESIS = (
    Fault("two-thirds-energy", "synthesis", "synthesis", "the surface holds 2/3 of the energy asked for",
          (Change("synthesis", WAVES, WAVES.replace("amplitude *", "amplitude * np.sqrt(2 / 3) *")),)),
    Fault("random-amplitudes", "synthesis", "synthesis", "amplitudes are multiplied by random numbers",
          (Change("synthesis", WAVES, WAVES.replace("amplitude *", "amplitude * np.sqrt(3) * "
                                                      "np.random.default_rng(1).random(components.kx.size) *")),)),
    Fault("amplitude-squared", "synthesis", "synthesis", "amplitudes are squared",
          (Change("synthesis", WAVES, WAVES.replace("amplitude *", "amplitude**2 *")),)),
    Fault("half-amplitude", "synthesis", "synthesis", "the surface is half as high, as one exponential of the cosine",
          (Change("synthesis", WAVES, WAVES.replace("amplitude *", "amplitude / 2 *")),)),
    Fault("double-energy", "synthesis", "synthesis", "the surface holds twice the energy asked for",
          (Change("synthesis", WAVES, WAVES.replace("amplitude *", "amplitude * np.sqrt(2) *")),)),
    Fault("phase-sign", "synthesis", "synthesis", "phases have the wrong sign",
          (Change("synthesis", WAVES, WAVES.replace("1j", "-1j")),)),
    Fault("phase-in-degrees", "synthesis", "synthesis", "phases are taken for degrees",
          (Change("synthesis", WAVES, WAVES.replace("1j *", "1j * np.pi / 180 *")),)),
    Fault("no-phases", "synthesis", "synthesis", "all phases are zero",
          (Change("synthesis", WAVES, WAVES.replace("1j", "0j")),)),
    Fault("sine-for-cosine", "synthesis", "synthesis", "waves are sines instead of cosines",
          (Change("synthesis", WAVES, WAVES.replace("components.phase", "(components.phase - np.pi / 2)")),)),
    Fault("omega-sign", "synthesis", "synthesis", "waves run backwards: the sign of omega t is wrong",
          (Change("synthesis", "np.exp(-1j * np.outer(components.omega, times))",
                  "np.exp(1j * np.outer(components.omega, times))"),)),
    Fault("standing-waves", "synthesis", "synthesis", "waves stand instead of running",
          (Change("synthesis", "np.exp(-1j * np.outer(components.omega, times))",
                  "np.cos(np.outer(components.omega, times))"),)),
    Fault("absolute-frequency", "synthesis", "synthesis", "waves swept backwards run forwards: omega without its sign",
          (Change("synthesis", "np.outer(components.omega, times)", "np.outer(np.abs(components.omega), times)"),)),
    Fault("current-left-out", "synthesis", "synthesis", "waves have their intrinsic frequency: the current is left out",
          (Change("synthesis", "np.outer(components.omega, times)",
                  "np.outer(np.sqrt(np.hypot(components.kx, components.ky)), times)"),)),
    Fault("origin-off-by-one", "synthesis", "synthesis", "x is counted from 1 instead of 0",
          (Change("synthesis", "np.exp(1j * np.outer(x, kx))", "np.exp(1j * np.outer(x + x[1], kx))"),)),
    Fault("synthesis-exchanged-axes", "synthesis", "synthesis", "kx and ky exchanged in the surface",
          (Change("synthesis", "lattice if lattice is not None else (components.kx, None, components.ky, None)",
                  "(components.ky, None, components.kx, None)"),
           Change("synthesis", "lattice = components.separated()", "lattice = None"))),
)
_WINDOW = (
    Fault("no-taper", "window", "leakage", "no window is applied",
          (Change("spectrum", "named_window(window).samples", 'named_window("box").samples'),)),
    Fault("taper-in-time-only", "window", "leakage", "the window is applied in time only",
          (Change("spectrum", TAPER_SPACE, "tapered *= 1"),)),
    Fault("taper-in-space-only", "window", "leakage", "the window is applied in space only",
          (Change("spectrum", "tapered = eta * wt", "tapered = eta * 1"),)),
    Fault("taper-not-along-y", "window", "leakage", "the window is not applied along y",
          (Change("spectrum", TAPER_SPACE, "tapered *= wx[:, None, None]"),)),
    Fault("taper-inside-out", "window", "leakage", "the window is largest at the edges: its cosine has the wrong sign",
          (Change("window", "(-1) ** j * a * np.cos(2 * np.pi * j * s)", "a * np.cos(2 * np.pi * j * s)"),)),
    Fault("taper-half-period", "window", "leakage", "the window rises over the whole length and breaks off",
          (Change("window", "np.cos(2 * np.pi * j * s)", "np.cos(np.pi * j * s)"),)),
    Fault("always-hann", "window", "recovery", "the Hann window is applied whatever window is asked for",
          (Change("spectrum", "named_window(window).samples", 'named_window("hann").samples'),)),
    Fault("taper-twice", "window", "conformance", "the window is applied twice",
          (Change("spectrum", TAPER_SPACE, "tapered *= (wx[:, None] * wy)[:, :, None] ** 2 * wt"),)),
    Fault("symmetric-taper", "window", "conformance", "the window is sampled symmetrically, over n - 1 (D1)",
          (Change("window", "(size - 1 if symmetric else size)", "(size - 1)"),)),
    Fault("hamming-for-hann", "window", "conformance", "the Hamming window stands in place of Hann's",
          (Change("window", 'Window("hann", "Hann", (0.5, 0.5))', 'Window("hann", "Hann", (0.54, 0.46))'),)),
    Fault("blackman-sign", "window", "conformance", "the third coefficient of the Blackman window has the wrong sign",
          (Change("window", "(0.42, 0.5, 0.08)", "(0.42, 0.5, -0.08)"),)),
    Fault("kaiser-without-pi", "window", "conformance", "the shape of the Kaiser-Bessel window lacks the factor pi",
          (Change("window", "float(np.pi * np.sqrt(3))", "float(np.sqrt(3))"),)),
)
_SPECTRUM = (
    Fault("time-transform-reversed", "spectrum", "signs",
          "the transform in time is a forward one: a wave appears at (-k, +omega)",
          (Change("spectrum", "np.conj(values, out=values)", "pass"),)),
    Fault("x-transform-reversed", "spectrum", "signs", "the transform along x is an inverse one",
          (Change("spectrum", FOURIER, "values = fft.fft(fft.ifft(values, axis=0), axis=1)"),)),
    Fault("shift-missing", "spectrum", "recovery", "fftshift is missing: bins carry the wrong wavenumbers",
          (Change("grid", SHIFTED, "np.arange(n) - n // 2"),)),
    Fault("frequencies-off-by-one", "spectrum", "recovery", "frequencies are one bin too high",
          (Change("spectrum", "self.grid.bins(2) * self.grid.frequency_resolution",
                  "(self.grid.bins(2) + 1) * self.grid.frequency_resolution"),)),
    Fault("wavenumbers-off-by-one", "spectrum", "recovery", "kx is one bin too high",
          (Change("spectrum", KX, f"(self.i + 1) * {WIDE}"),)),
    Fault("shift-off-by-one-odd", "spectrum", "recovery", "for odd n the wavenumbers are one bin too high",
          (Change("spectrum", KX, f"(self.i + (self.grid.shape[0] % 2 == 1)) * {WIDE}"),)),
    Fault("shift-off-by-one-even", "spectrum", "recovery", "for even n the wavenumbers are one bin too high",
          (Change("spectrum", KX, f"(self.i + (self.grid.shape[0] % 2 == 0)) * {WIDE}"),)),
    Fault("linspace-for-fftfreq", "spectrum", "recovery",
          "wavenumbers are spread evenly from minus to plus Nyquist, both ends included",
          (Change("spectrum", KX, f"((self.i + {HALF}) * (1 + 1 / (2 * {HALF} - 1)) - {HALF}) * {WIDE}"),)),
    Fault("unsigned-wavenumbers", "spectrum", "recovery", "the upper half of kx is not wrapped to negative wavenumbers",
          (Change("spectrum", KX, f"(self.i % self.grid.shape[0]) * {WIDE}"),)),
    Fault("wrapped-images", "spectrum", "recovery", "the surface is taken as whole numbers of one byte, which wrap",
          (Change("spectrum", "tapered = eta * wt", "tapered = (100 * eta).astype(np.int64).astype(np.int8) * wt"),)),
    Fault("frequencies-to-nyquist", "spectrum", "recovery",
          "frequencies are spread evenly up to the Nyquist frequency, which an odd number of frames does not have",
          (Change("spectrum", "self.grid.bins(2) * self.grid.frequency_resolution",
                  "np.linspace(0, self.grid.nyquist[2], self.grid.shape[2] // 2 + 1)"),)),
    Fault("rectified", "spectrum", "recovery", "the surface is squared before the transform",
          (Change("spectrum", "tapered = eta * wt", "tapered = eta**2 * wt"),)),
    Fault("half-precision", "spectrum", "metamorphic", "the surface is rounded to half precision",
          (Change("spectrum", "tapered = eta * wt", "tapered = eta.astype(np.float16) * wt"),)),
    Fault("saturated", "spectrum", "metamorphic", "the surface is cut off at a height of 1/2",
          (Change("spectrum", "tapered = eta * wt", "tapered = eta.clip(-0.5, 0.5) * wt"),)),
    Fault("power-returned", "spectrum", "conformance", "the spectrum returned is the power instead of S",
          (Change("chain", "Grid(eta.shape, spacing), window).whole()",
                  "Grid(eta.shape, spacing), window).whole().__abs__() ** 2"),)),
    Fault("mirror-not-conjugate", "spectrum", "conformance",
          "the half omega < 0 of the spectrum is not the mirror image of the other",
          (Change("spectrum", "np.conj(self.values[np.ix_(-self.i, -self.j)])", "np.conj(self.values)"),)),
)
_SHELL = (
    Fault("frequency-at-centre", "shell", "recovery", "omega0 is taken at the shell's wavenumber, not at each bin's",
          (Change("shell", INTRINSIC, "water.frequency(np.full(a.size, wavenumber))"),)),
    Fault("root-missing", "shell", "recovery", "omega0 is g k: the square root is missing",
          (Change("dispersion", DEEP_ROOT,
                  "return self.gravity * np.asarray(wavenumber, dtype=np.float64)"),)),
    Fault("group-velocity", "shell", "recovery", "omega0 is half as large, as if k times the group velocity",
          (Change("dispersion", DEEP_ROOT,
                  "return np.sqrt(self.gravity * np.asarray(wavenumber, dtype=np.float64)) / 2"),)),
    Fault("depth-assumed", "shell", "recovery", "water of depth 1 is assumed instead of deep water",
          (Change("dispersion", DEEP_ROOT,
                  "return np.sqrt(self.gravity * np.asarray(wavenumber) * np.tanh(np.asarray(wavenumber)))"),)),
    Fault("depth-of-half", "shell", "recovery", "water of depth 1/2 is assumed instead of deep water",
          (Change("dispersion", DEEP_ROOT, DEEP_ROOT.replace("dtype=np.float64))", "dtype=np.float64) * "
                  "np.tanh(0.5 * np.asarray(wavenumber)))")),)),
    Fault("sum-for-length", "shell", "recovery", "the length of k is |kx| + |ky|",
          (Change("shell", 'k = np.hypot(*np.meshgrid(spectrum.kx, spectrum.ky, indexing="ij"))',
                  'k = np.add(*np.abs(np.meshgrid(spectrum.kx, spectrum.ky, indexing="ij")))'),)),
    Fault("shell-off-by-one", "shell", "conformance", "shells lie one bin too high",
          (Change("shell", "np.abs(k - wavenumber) / dk", "np.abs(k - wavenumber - dk) / dk"),)),
    Fault("disc-for-shell", "shell", "shear", "all bins below the shell belong to it",
          (Change("shell", "np.abs(k - wavenumber) / dk", "(k - wavenumber) / dk"),)),
    Fault("half-plane", "shell", "metamorphic", "only waves going towards +y are looked at",
          (Change("shell", "a, b = np.nonzero(np.abs(k - wavenumber)", "a, b = np.nonzero((spectrum.ky > 0) & "
                  "(np.abs(k - wavenumber)"), Change("shell", "<= half_width + EDGE_MARGIN)",
                                                     "<= half_width + EDGE_MARGIN))"))),
    Fault("hard-coded-shell", "shell", "scale", "the width of a shell is a fixed number instead of 2 dk",
          (Change("shell", "np.abs(k - wavenumber) / dk <= half_width + EDGE_MARGIN",
                  "np.abs(k - wavenumber) <= 0.3"),)),
    Fault("edge-bins-excluded", "shell", "conformance", "bins on the edge of a shell are left out (D3)",
          (Change("shell", "/ dk <= half_width + EDGE_MARGIN", "/ dk < half_width - EDGE_MARGIN"),)),
    Fault("narrow-shell", "shell", "conformance", "shells are half as wide, 1 dk to either side",
          (Change("shell", "HALF_WIDTH = 2.0", "HALF_WIDTH = 1.0"),)),
    Fault("wide-shell", "shell", "conformance", "shells are 3 dk wide to either side",
          (Change("shell", "HALF_WIDTH = 2.0", "HALF_WIDTH = 3.0"),)),
    Fault("finer-bin", "shell", "conformance", "dk is the smaller of dkx and dky (D20)",
          (Change("grid", "return max(self.bin_widths[:2])", "return min(self.bin_widths[:2])"),)),
    Fault("real-part", "shell", "metamorphic", "the magnitude of the spectrum is that of its real part",
          (Change("shell", "np.abs(spectrum.values[a, b])", "np.abs(spectrum.values[a, b].real)"),)),
    Fault("zero-frequency-left-out", "shell", "conformance", "omega = 0 is left out of the sums (D5)",
          (Change("spectrum", "np.where((m == 0) | (2 * m == self.grid.shape[2]), 0.5, 1.0)",
                  "np.where(m == 0, 0.0, np.where(2 * m == self.grid.shape[2], 0.5, 1.0))"),)),
    Fault("unweighted-half", "shell", "conformance", "omega = 0 and the Nyquist plane count twice (D5)",
          (Change("spectrum", "np.where((m == 0) | (2 * m == self.grid.shape[2]), 0.5, 1.0)", "np.ones(m.size)"),)),
)
_NSP = (
    Fault("missing-negative-branch", "nsp", "currents", "G lacks the branch of negative frequencies",
          (Change("nsp", CENTRES, "return shell.intrinsic + shift, np.full_like(shift, -1e6)"),)),
    Fault("printed-branch", "nsp", "currents", "the negative branch of G is at -omega0 - k.c, as printed (D2)",
          (Change("nsp", CENTRES, "return shell.intrinsic + shift, -shell.intrinsic - shift"), UNPOLISHED)),
    Fault("extra-branch", "nsp", "signs", "G has extra branches, at omega0 - k.c and its mirror image",
          (Change("nsp", CENTRES, "return (shell.intrinsic + shift, -shell.intrinsic + shift, "
                  "shell.intrinsic - shift, -shell.intrinsic - shift)"),
           Change("nsp", "positive_branch, negative_branch = (", "return sum("), UNPOLISHED)),
    Fault("only-negative-branch", "nsp", "recovery", "G lacks the branch of positive frequencies",
          (Change("nsp", CENTRES, "return np.full_like(shift, -1e6), -shell.intrinsic + shift"),)),
    Fault("current-sign-in-branch", "nsp", "signs", "the Doppler shift in G has the wrong sign",
          (Change("nsp", "shift = shell.kx * u + shell.ky * v", "shift = -shell.kx * u - shell.ky * v"), UNPOLISHED)),
    Fault("shift-at-centre", "nsp", "recovery",
          "the Doppler shift in G is taken at the shell's wavenumber, not at each bin's",
          (Change("nsp", "shift = shell.kx * u + shell.ky * v", "shift = (shell.kx * u + shell.ky * v) * "
                  "(shell.wavenumber / np.hypot(shell.kx, shell.ky))"), UNPOLISHED)),
    Fault("hard-coded-width", "nsp", "scale", "the width a of G is a fixed number instead of 4 domega",
          (Change("nsp", "a, water = width * spectrum.grid.frequency_resolution,", "a, water = 0.4,"),)),
    Fault("frequency-cut", "nsp", "scale", "frequencies above 3 are left out whatever the units (D4)",
          (Change("shell", "spectrum.omega, weight", "spectrum.omega, weight * (spectrum.omega <= 3)"),)),
    Fault("least-overlap", "nsp", "recovery", "the least overlap is looked for instead of the largest",
          (Change("nsp", "lambda c: -normalized_scalar_product", "lambda c: normalized_scalar_product"), UNPOLISHED)),
    Fault("stops-at-start", "nsp", "recovery", "the search stops where it starts",
          (Change("nsp", '"xatol": 1e-8', '"xatol": 1e-2'), UNPOLISHED)),
    Fault("far-start", "nsp", "recovery", "the search starts far off, at 2 c0 along x",
          (Change("nsp", "simplex = np.array([[0.0, 0.0], [START, 0.0], [0.0, START]])",
                  "simplex = np.array([[2.0, 0.0], [2 + START, 0.0], [2.0, START]])"),)),
    Fault("narrow-bounds", "nsp", "currents", "currents faster than 0.1 c0 are cut off",
          (Change("nsp", POLISH, POLISH + "\n    velocity = np.clip(velocity, -0.1 * unit, 0.1 * unit)"),)),
    Fault("narrow-width", "nsp", "conformance", "the width a of G is half as large, 2 domega",
          (Change("nsp", "WIDTH = 4.0", "WIDTH = 2.0"),)),
    Fault("wide-width", "nsp", "currents", "the width a of G is twice as large, 8 domega",
          (Change("nsp", "WIDTH = 4.0", "WIDTH = 8.0"),)),
    Fault("power-for-magnitude", "nsp", "recovery", "F is the power instead of its square root",
          (Change("nsp", "    if shell.is_empty:", "    from dataclasses import replace\n"
                  "    shell = replace(shell, magnitude=shell.magnitude**2)\n    if shell.is_empty:"),)),
    Fault("smoothed", "nsp", "recovery", "each velocity is the mean of its own and its neighbours'",
          (answer("(lambda v: sum(v.take(np.arange(n, n + len(v)), axis=0, mode='clip') for n in (-1, 0, 1)) / 3)"
                   "(FOUND)"),)),
    Fault("mean-over-band", "nsp", "shear", "every wavenumber is given the mean over the band",
          (answer("np.broadcast_to(np.nanmean(FOUND, axis=0), (np.size(wavenumbers), 2))"),)),
)
_LS = (
    Fault("solve-sign-slip", "ls", "signs", "one component of the 2x2 solve has the wrong sign",
          (Change("leastsquares", "np.linalg.solve(normal, k @ shift)",
                  "np.linalg.solve(normal, k @ shift) * [1, -1]"),)),
    Fault("solve-off-diagonal", "ls", "recovery", "the off-diagonal of the 2x2 solve has the wrong sign",
          (Change("leastsquares", "np.linalg.solve(normal, k @ shift)",
                  "np.linalg.solve(normal * [[1, -1], [-1, 1]], k @ shift)"),)),
    Fault("solve-factor-two", "ls", "recovery", "the least-squares current is twice as large",
          (Change("leastsquares", "np.linalg.solve(normal, k @ shift)", "np.linalg.solve(normal, 2 * k @ shift)"),)),
    Fault("ls-wrong-branch", "ls", "recovery", "least squares fits the branch of negative frequencies",
          (Change("leastsquares", "shift = shell.omega[m] - shell.intrinsic[column]",
                  "shift = shell.omega[m] + shell.intrinsic[column]"),)),
    Fault("ls-both-halves", "ls", "recovery", "least squares uses the bins of both halves on one branch (D19)",
          (Change("leastsquares", "k = np.stack([shell.kx[column], shell.ky[column]])",
                  "k = np.stack([np.r_[x[column], -x[column]] for x in (shell.kx, shell.ky)])"),
           Change("leastsquares", "shift = shell.omega[m] - shell.intrinsic[column]",
                  "shift = np.r_[shell.omega[m], -shell.omega[m]] - np.tile(shell.intrinsic[column], 2)"))),
    Fault("ls-no-threshold", "ls", "leakage", "least squares uses all bins, however weak",
          (Change("leastsquares", "THRESHOLD = 0.2", "THRESHOLD = 1e-9"),)),
    Fault("ls-threshold-on-magnitude", "ls", "conformance",
          "the threshold is of the magnitude instead of the power (D7)",
          (Change("leastsquares", "(shell.magnitude / shell.magnitude.max()) ** 2",
                  "shell.magnitude / shell.magnitude.max()"),)),
    Fault("ls-intercept", "ls", "shear", "the straight line of the least squares has an intercept",
          (Change("leastsquares", "shift = shell.omega[m] - shell.intrinsic[column]",
                  "shift = shell.omega[m] - shell.intrinsic[column]\n    shift = shift - shift.mean()\n"
                  "    k = k - k.mean(axis=1, keepdims=True)"),)),
    Fault("ls-weighted", "ls", "conformance", "bins are weighted by their power in the least squares",
          (Change("leastsquares", "normal = k @ k.T", "normal = (k * power[column, m]) @ k.T"),
           Change("leastsquares", "np.linalg.solve(normal, k @ shift)",
                  "np.linalg.solve(normal, (k * power[column, m]) @ shift)"))),
    Fault("method-ignored", "ls", "conformance", "the scalar product is used where least squares is asked for",
          (Change("methods", "leastsquares.extract, {", "nsp.extract, {"),)),
)
_BEHAVIOUR = (
    Fault("nan-as-number", "behaviour", "behaviour", "a surface that holds NaN is not refused and gives NaN velocities",
          unchecked("np.asarray(surface)")),
    Fault("nan-replaced", "behaviour", "behaviour", "NaN in the surface is silently replaced by zero",
          unchecked("np.nan_to_num(surface)")),
    Fault("input-altered", "behaviour", "behaviour", "the window is applied to the caller's own array",
          (Change("spectrum", "tapered = eta * wt", "tapered = np.multiply(eta, wt, out=eta)"),)),
    Fault("random-output", "behaviour", "behaviour", "no two calls give the same answer", instead=Drifting),
    Fault("state-kept", "behaviour", "behaviour", "the cube of the call before is mixed in", instead=Remembering),
    Fault("sorted-wavenumbers", "behaviour", "behaviour", "the answer is in ascending order of wavenumber",
          (asked("wavenumbers", "np.sort(wavenumbers)"),)),
    Fault("reversed-wavenumbers", "behaviour", "shear", "the answer is in the reverse order of wavenumbers",
          (answer("FOUND[::-1]"),)),
    Fault("first-wavenumber-dropped", "behaviour", "behaviour", "the first wavenumber is left out of the answer",
          (answer("FOUND[1:]"),)),
    Fault("first-wavenumber-for-all", "behaviour", "shear", "every wavenumber is given the first one's velocity",
          (answer("np.broadcast_to(FOUND[:1], (np.size(wavenumbers), 2))"),)),
    Fault("rounded-answer", "behaviour", "recovery", "velocities are rounded to one decimal",
          (answer("np.round(FOUND, 1)"),)),
)
_KILLING_INPUTS = {
    "recovery.pair[even-1]":
        "negated-current flipped-x flipped-y exchanged-axes quarter-turn rows-downwards reversed-time exchanged-cube "
        "absolute-value no-cross-component exchanged-spacing square-pixels hertz-for-radians "
        "degrees-for-radians gravity-dropped gravity-hard-coded knots pixels-per-frame unit-time-step "
        "doppler-frequency one-interval-short duration-short time-transform-reversed x-transform-reversed "
        "frequencies-off-by-one wavenumbers-off-by-one frequency-at-centre group-velocity depth-assumed "
        "solve-sign-slip solve-off-diagonal "
        "solve-factor-two ls-wrong-branch ls-both-halves rounded-answer always-hann",
    "recovery.two-shells[even]":
        "frame-rate rectified root-missing sum-for-length disc-for-shell mean-over-band reversed-wavenumbers "
        "frames-out-of-order width-short exchanged-counts shift-off-by-one-even linspace-for-fftfreq depth-of-half "
        "first-wavenumber-for-all only-negative-branch",
    "synthesis.energy[40]":
        "two-thirds-energy random-amplitudes amplitude-squared half-amplitude double-energy standing-waves",
    "synthesis.single[to-250]":
        "phase-sign phase-in-degrees no-phases sine-for-cosine omega-sign origin-off-by-one synthesis-exchanged-axes",
    "synthesis.sum[backwards]": "absolute-frequency current-left-out",
    "conformance.spectrum[spectrum-on-bin-hann]":
        "no-taper taper-in-time-only taper-in-space-only taper-twice symmetric-taper hamming-for-hann power-returned "
        "mirror-not-conjugate",
    "leakage.swell[low]": "taper-not-along-y",
    "leakage.flicker[fast]": "taper-inside-out",
    "conformance.window[window-hann-7]": "taper-half-period",
    "conformance.spectrum[spectrum-scattered]": "blackman-sign",
    "conformance.spectrum[spectrum-half-bin]": "half-precision",
    "conformance.window[window-kaiser-bessel-12]": "kaiser-without-pi",
    "recovery.sea[broad]": "shift-missing",
    "recovery.pair[odd-2]": "least-overlap frequencies-to-nyquist",
    "recovery.pair[even-2]": "far-start",
    "recovery.pair[prime-1]": "frames-skipped shift-off-by-one-odd wrapped-images",
    "conformance.extract[nsp-narrow]": "zero-frequency-left-out",
    "conformance.extract[nsp-backwards]": "shift-at-centre",
    "metamorphic.amplitude[1e+06-tapered]": "saturated",
    "conformance.extract[nsp-oblong]": "shell-off-by-one",
    "metamorphic.symmetry[exchange-tapered]": "half-plane",
    "scale.peak[4-untapered]": "hard-coded-shell frequency-cut",
    "conformance.sea[edges-box-nsp]": "edge-bins-excluded narrow-width power-for-magnitude",
    "conformance.sea[strong-box-ls]":
        "narrow-shell wide-shell finer-bin real-part smoothed ls-threshold-on-magnitude "
        "ls-weighted ls-intercept unsigned-wavenumbers method-ignored",
    "conformance.sea[strong-hann-nsp]": "unweighted-half wide-width missing-negative-branch",
    "conformance.sea[strong-hann-ls]": "cycles-for-radians",
    "recovery.ring[beside-moving]": "extra-branch stops-at-start current-sign-in-branch narrow-bounds",
    "currents.backwards[oblique]": "printed-branch",
    "conformance.extract[nsp-untapered]": "hard-coded-width",
    "conformance.extract[ls-oblong]": "ls-no-threshold",
    "behaviour.refuses[nan]": "nan-as-number nan-replaced",
    "behaviour.input[all-stages]": "input-altered",
    "behaviour.deterministic[twice]": "random-output state-kept",
    "behaviour.order[shuffled]": "sorted-wavenumbers",
    "behaviour.order[reversed]": "first-wavenumber-dropped",
}
"""Findings, and the faults that each is the killing input of."""
_KILLING_BY = {name: finding for finding, names in _KILLING_INPUTS.items() for name in names.split()}
FAULTS: dict[str, Fault] = {fault.id: replace(fault, killing_input=_KILLING_BY.get(fault.id, "")) for fault in (
    *_FRAME, *_UNITS, *_SYNTHESIS, *_WINDOW, *_SPECTRUM, *_SHELL, *_NSP, *_LS, *_BEHAVIOUR)}
"""Every fault by id, stage by stage."""


def implementation(identifier: str) -> Any:
    """The reference with that fault, offering the four stages; a new one each time. Raises LeakrefError."""
    if identifier not in FAULTS:
        raise LeakrefError("faults", f"no fault is called {identifier!r}", "`leakref strength --json` lists them all")
    fault = FAULTS[identifier]
    inner = fault.instead() if fault.instead else altered(fault.changes).chain.Reference()
    return Named(inner, f"fault:{identifier}", null=identifier != "nan-as-number")
