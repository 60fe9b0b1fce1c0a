"""Mistakes that people make, each planted by one changed line into one of the two independent extractors.

`named` are the answers to "what is wrong with it?" that count as right: ids of faults of the reference
(`leakref.certify.strength.faults`), ids of repairs under which the code comes right, and, in `says`, a regular
expression for the words of an explanation. Both are empty where nothing that leakref has could describe the mistake:
there only "unexplained" is honest. `mild` are those that a suite may rightly call sound.
"""

from __future__ import annotations

import sys
from dataclasses import dataclass, field
from pathlib import Path
from types import ModuleType

HERE = Path(__file__).parent
NEGATED = (
    "negated-current negated reversed-time time-reversed time-transform-reversed current-sign-in-branch "
    "x-reversed+y-reversed"
)
FLIPPED_X = "flipped-x x-reversed x-transform-reversed"
FLIPPED_Y = "flipped-y y-reversed rows-downwards"
EXCHANGED = "exchanged-axes exchanged nautical"
REPAIRS = """
    x-reversed y-reversed time-reversed cube-exchanged dt-interval dx-interval dy-interval lengths-interval
    n-exchanged mean-removed square-pixels gravity wavenumbers-cycles wavenumbers-halved wavenumbers-to-bins
    frequency-hertz degrees negated flipped-x flipped-y exchanged quarter-turn quarter-turn-back
    exchanged-and-negated factor factor-x factor-y nautical turned lost-x lost-y dt-doubled dt-halved
    frames-interlaced taper-not-along-x stops-early
"""
"""What the diagnosis calls what is done around a code to cure it, but for those with a figure (`frames-dt:2`)."""


@dataclass(frozen=True)
class Mistake:
    """In `file`, `old`, which stands there once, becomes `new`."""

    id: str
    file: str
    old: str
    new: str
    words: str
    named: frozenset[str] = field(default_factory=frozenset)
    says: str = ""
    mild: bool = False

    def plant(self) -> ModuleType:
        """The extractor with it, as a module of its own; a new one each time."""
        text = (HERE / f"{self.file}.py").read_text()
        if text.count(self.old) != 1:
            raise ValueError(f"{self.id}: {self.old!r} stands {text.count(self.old)} times in {self.file}.py, not once")
        module = ModuleType(f"strangers.{self.file}_{self.id.replace('-', '_')}")
        sys.modules[module.__name__] = module  # dataclasses look for their module there
        exec(compile(text.replace(self.old, self.new), module.__name__, "exec"), module.__dict__)
        return module


def nsp(id, old, new, words, named="", says="", mild=False):
    return Mistake(f"nsp-{id}", "nsp", old, new, words, frozenset(named.split()), says, mild)


def ls(id, old, new, words, named="", says="", mild=False):
    return Mistake(f"ls-{id}", "leastsquares", old, new, words, frozenset(named.split()), says, mild)


ANSWER = "velocities.append([east, north])"
READ = "eta = np.array(surface, dtype=float)"
INTRINSIC = "intrinsic = np.sqrt(gravity * k)"
ASKED = "in np.asarray(wavenumbers, dtype=float):"
LENGTHS = "length_x, length_y, duration = nx * dx, ny * dy, nt * dt"
FIRST_TAPER = "eta *= cosine_window(window, nx)[:, None, None]"
RING = "ring = np.abs(spectrum.k - wavenumber) <= half_width * EDGE"

NSP = (
    # frames
    nsp("negated", ANSWER, "velocities.append([-east, -north])", "the current is returned as its negative", NEGATED),
    nsp("west", ANSWER, "velocities.append([-east, north])", "x is counted to the west", FLIPPED_X),
    nsp("south", ANSWER, "velocities.append([east, -north])", "y is counted to the south", FLIPPED_Y),
    nsp("exchanged", ANSWER, "velocities.append([north, east])", "x and y exchanged", EXCHANGED),
    nsp("turned", ANSWER, "velocities.append([-north, east])", "turned by a quarter turn",
        "quarter-turn quarter-turn-back turned"),
    nsp("coming-from", ANSWER, "velocities.append([-north, -east])", "compass bearing of where it comes from, as if "
        "it were an angle from x", "exchanged-and-negated nautical"),
    nsp("degrees", ANSWER, "velocities.append(np.hypot(east, north) * np.array([f(np.degrees(np.arctan2(north, east))) "
        "for f in (np.cos, np.sin)]))", "an angle in degrees is put into cos and sin", "degrees-for-radians degrees"),
    nsp("speed-and-angle", ANSWER, "velocities.append([np.hypot(east, north), np.arctan2(north, east)])",
        "speed and direction are returned as if they were components", says="speed and (the )?(direction|angle)|polar"),
    nsp("absolute", ANSWER, "velocities.append([abs(east), abs(north)])", "components without their signs",
        "absolute-value"),
    nsp("kx-sign", "kx = -dkx * signed(nx)", "kx = dkx * signed(nx)", "one of the signs of the transform is forgotten",
        FLIPPED_X),
    nsp("shift-sign", "shift = kx * u + ky * v", "shift = -kx * u - ky * v", "the sign of the Doppler shift", NEGATED),
    # units
    nsp("knots", ANSWER, "velocities.append([1.943844 * east, 1.943844 * north])", "in knots", "knots unit:knots",
        r"times 1\.94"),
    nsp("third", ANSWER, "velocities.append([east / 3, north / 3])", "a third of it, by a factor from elsewhere",
        "", r"\b1/3\b|times 0\.33"),
    nsp("two-way", ANSWER, "velocities.append([east / 2, north / 2])", "half of it, as for the two-way path of radars",
        "", r"\b1/2\b|times 0\.50?\b"),
    nsp("in-phase-speeds", "return unit * found.x", "return found.x", "in units of the phase speed, not in m/s",
        "", "phase speed|scaled unit|depends on the scale"),
    nsp("times-k", ANSWER, "velocities.append([wavenumber * east, wavenumber * north])", "the Doppler shift k c is "
        "returned", "doppler-frequency"),
    nsp("pixels", ANSWER, "velocities.append([east * spacing[2] / spacing[0], north * spacing[2] / spacing[1]])",
        "in pixels per frame", "pixels-per-frame", "pixels? per frame"),
    nsp("hertz", "omega = domega * np.arange(nt // 2 + 1)", "omega = np.arange(nt // 2 + 1) / duration",
        "frequencies in Hz", "hertz-for-radians frequency-hertz"),
    nsp("cycles", ASKED, "in np.asarray(wavenumbers, dtype=float) / (2 * np.pi):", "wavenumbers are taken for cycles",
        "cycles-for-radians wavenumbers-cycles"),
    nsp("gravity-10", INTRINSIC, "intrinsic = np.sqrt(10.0 * k)", "gravity is 10", "gravity-hard-coded gravity"),
    nsp("gravity-1", INTRINSIC, "intrinsic = np.sqrt(k)", "gravity is left out", "gravity-dropped gravity"),
    nsp("frame-rate", "dx, dy, dt = spacing", "dx, dy, dt = spacing[0], spacing[1], 1 / spacing[2]",
        "frames per second for the time step", "frame-rate"),
    nsp("no-dt", "dx, dy, dt = spacing", "dx, dy, dt = spacing[0], spacing[1], 1.0", "the time step is 1",
        "unit-time-step"),
    nsp("swapped-spacing", "dx, dy, dt = spacing", "dy, dx, dt = spacing", "dx and dy exchanged", "exchanged-spacing"),
    nsp("square", LENGTHS, "length_x, length_y, duration = nx * dx, ny * dx, nt * dt", "dx for dy", "square-pixels"),
    nsp("swapped-n", LENGTHS, "length_x, length_y, duration = ny * dx, nx * dy, nt * dt", "n of one axis for the "
        "other's", "n-exchanged"),
    nsp("intervals", LENGTHS, "length_x, length_y, duration = (nx - 1) * dx, (ny - 1) * dy, (nt - 1) * dt",
        "lengths are (n - 1) d", "one-interval-short lengths-interval"),
    nsp("short-duration", LENGTHS, "length_x, length_y, duration = nx * dx, ny * dy, (nt - 1) * dt",
        "the duration is (n - 1) dt", "duration-short dt-interval"),
    nsp("short-x", LENGTHS, "length_x, length_y, duration = (nx - 1) * dx, ny * dy, nt * dt", "one length is (n - 1) d",
        "dx-interval"),
    # what is read
    nsp("skipped-frames", READ, READ + "[:, :, ::2]", "every second frame, with the step of all", "frames-dt:2",
        "skip"),
    nsp("frames-by-name", READ, READ + "[:, :, sorted(range(np.shape(surface)[2]), key=str)]", "frames sorted by name: "
        "frame 10 before frame 2", "", "out of order|frames? .*order"),
    nsp("uint8", FIRST_TAPER, "eta = (eta.astype(int) % 256) * cosine_window(window, nx)[:, None, None]",
        "images become bytes unscaled, and wrap", "", "\\bwrap|integer|\\bbytes?"),
    nsp("squared", FIRST_TAPER, "eta = eta**2 * cosine_window(window, nx)[:, None, None]", "the surface is squared",
        "rectified", "squared"),
    nsp("padded", "bins = fft.rfftn(eta)", "bins = fft.rfftn(np.pad(eta, [(0, 0), (0, 0), (0, nt)]))[:, :, : nt // 2 + "
        "1]", "padded in time to twice its length, the frequencies as before", "dt-doubled frames-dt:2", "\\bpad"),
    # window
    nsp("space-only", "eta *= cosine_window(window, nt)[None, None, :]", "pass", "the window is not applied in time",
        "taper-in-space-only"),
    nsp("inside-out", "return mean - swing * np.cos(phase)", "return mean + swing * np.cos(phase)",
        "the cosine of the window has the wrong sign", "taper-inside-out"),
    nsp("half-window", "phase = 2 * np.pi * np.arange(size) / size", "phase = np.pi * np.arange(size) / size",
        "the window rises and breaks off", "taper-half-period"),
    nsp("always-hann", "mean, swing = WINDOWS[name]", 'mean, swing = WINDOWS["hann"]', "the window cannot be turned "
        "off", "always-hann"),
    nsp("never-hann", "mean, swing = WINDOWS[name]", 'mean, swing = WINDOWS["box"]', "no window", "no-taper"),
    # spectrum
    nsp("unsigned", "kx = -dkx * signed(nx)", "kx = -dkx * np.arange(nx)", "kx is not wrapped to negative values", "",
        "unsigned|negative wavenumber|\\bwrap"),
    nsp("from-one", "number = np.arange(size)", "number = np.arange(1, size + 1)", "bins are counted from 1",
        "", "off by one|one bin|counted from (1|one)"),
    nsp("to-nyquist", "omega = domega * np.arange(nt // 2 + 1)", "omega = np.linspace(0, np.pi / dt, nt // 2 + 1)",
        "frequencies up to Nyquist's, which an odd number has not", "frequencies-to-nyquist"),
    nsp("power", "magnitude = np.sqrt(power)", "magnitude = power", "F is the power", "power-for-magnitude"),
    nsp("power-squared", "magnitude = np.sqrt(power)", "magnitude = (power**2)", "F is the power squared", "",
        "power.{0,40}(square|magnitude)"),
    nsp("decibels", "magnitude = np.sqrt(power)", "magnitude = np.log10(power + 1e-12)", "F is in decibels", "",
        "logarithm|decibel"),
    nsp("floor", "magnitude = np.sqrt(power)", "magnitude = np.where(power > 1.0, np.sqrt(power), 0.0)", "an absolute "
        "noise floor", "", "threshold|floor|absolute number"),
    nsp("real-part", "power = np.abs(bins) ** 2", "power = bins.real**2", "the imaginary part is dropped", "real-part"),
    # shell
    nsp("shell-in-rad", "half_width = SHELL_HALF_WIDTH * spectrum.dk", "half_width = 0.1", "the width of shells is in "
        "rad/m", "hard-coded-shell", "rad/m|shell.*(fixed|hard)"),
    nsp("thin-shell", "SHELL_HALF_WIDTH = 2.0", "SHELL_HALF_WIDTH = 0.32", "shells of a third of a bin",
        "narrow-shell", "narrow.{0,20}shell|shell.{0,30}narrow", mild=True),
    nsp("next-shell", RING, "ring = np.abs(spectrum.k - wavenumber - spectrum.dk) <= half_width * EDGE",
        "shells one bin too high", "shell-off-by-one", mild=True),
    nsp("disc", RING, "ring = spectrum.k - wavenumber <= half_width * EDGE", "a disc, not a shell", "disc-for-shell"),
    nsp("half-plane", RING, RING + "; ring &= spectrum.kx >= 0", "half of the plane, as if the other were its mirror "
        "image at every frequency", "half-plane", "half of the (plane|waves)"),
    nsp("floored", ASKED, "in np.floor(np.asarray(wavenumbers) / spectrum.dk) * spectrum.dk:", "wavenumbers asked for "
        "are rounded down to bins", "wavenumbers-to-bins"),
    nsp("city-block", "return np.hypot(self.kx, self.ky)", "return np.abs(self.kx) + np.abs(self.ky)",
        "the length of k is the sum of its parts", "sum-for-length"),
    nsp("at-centre", INTRINSIC, "intrinsic = np.sqrt(gravity * wavenumber) + 0 * k", "omega0 at the shell's centre",
        "frequency-at-centre"),
    nsp("doppler-at-centre", "shift = kx * u + ky * v", "shift = (kx * u + ky * v) * wavenumber / k", "the Doppler "
        "shift at the shell's centre", "", "(shift|k\\.c).{0,60}(centre|shell's)"),
    nsp("three-metres", INTRINSIC, "intrinsic = np.sqrt(gravity * k * np.tanh(3.0 * k))", "3 m of water whatever is "
        "asked", "depth-assumed", "depth|shallow"),
    nsp("tension", INTRINSIC, "intrinsic = np.sqrt(gravity * k + 0.074 * k**3)", "surface tension without density",
        "", "tension"),
    nsp("group", INTRINSIC, "intrinsic = np.sqrt(gravity * k) / 2", "k times the group velocity for omega0",
        "group-velocity"),
    # characteristic function and search
    nsp("one-branch", "characteristic = waves + mirrored", "characteristic = waves", "no negative branch",
        "missing-negative-branch"),
    nsp("printed", "(omega + (intrinsic - shift)[:, None])", "(omega + (intrinsic + shift)[:, None])", "the negative "
        "branch as printed", "printed-branch"),
    nsp("spurious", "characteristic = waves + mirrored", "characteristic = waves + mirrored + "
        "np.exp(-2 * ((omega - (intrinsic - shift)[:, None]) / width) ** 2)", "a branch at omega0 - k.c as well",
        "extra-branch", "spurious|extra branch"),
    nsp("twelve", "waves = np.exp(", "waves = np.exp(-2 * ((omega - 12 - shift[:, None]) / width) ** 2) + np.exp(",
        "a branch at 12 rad/s", "", "12(\\.0+)? rad/s|spurious|extra branch"),
    nsp("width-in-rad", "width = GAUSSIAN_WIDTH * spectrum.domega", "width = 0.5", "the width is in rad/s",
        "hard-coded-width", "rad/s"),
    nsp("least", "lambda c: -overlap(unit * c)", "lambda c: overlap(unit * c)", "the least overlap", "least-overlap"),
    nsp("long-step", "FIRST_STEP = 1e-3", "FIRST_STEP = 1.0", "the search begins with steps of a phase speed",
        "far-start", "first step|simplex|starts? (too )?far"),
    nsp("lazy", '"maxfev": 2000', '"maxfev": 15', "the search stops early", "stops-at-start stops-early",
        "stops|tolerance"),
    nsp("clipped", "return unit * found.x", "return np.clip(unit * found.x, -1, 1)", "at most 1 m/s",
        "narrow-bounds", "edge|corner|search range"),
    # behaviour
    nsp("line", "return velocities", "return np.stack([np.polyval(np.polyfit(wavenumbers, c, min(1, len(c) - 1)), "
        "wavenumbers) for c in np.array(velocities, float).T], axis=1)", "a straight line through all shells", "",
        "straight line|smooth|interpolat"),
    nsp("interpolated", "return velocities", "return np.stack([np.interp(wavenumbers, np.sort(wavenumbers)[::2], "
        "c[::2]) for c in np.array(velocities, float)[np.argsort(wavenumbers)].T], axis=1)", "every second is "
        "interpolated", "", "interpolat|smooth"),
    nsp("mean", "return velocities", "return [np.mean(velocities, axis=0)] * len(velocities)", "the mean of the band",
        "mean-over-band"),
    nsp("sorted", ASKED, "in np.sort(np.asarray(wavenumbers, dtype=float)):", "answers by ascending wavenumber",
        "sorted-wavenumbers"),
    nsp("cached", "spectrum = transformed(surface, spacing, window)", 'spectrum = self.__dict__.setdefault("kept", '
        "transformed(surface, spacing, window))", "the first cube's spectrum is kept for ever", "state-kept",
        "kept|call before|earlier"),
    nsp("random", "start = np.array(", "start = np.random.default_rng().normal(0, 0.1, 2) + np.array(", "random starts",
        "random-output", "differs the second time|random|same answer"),
    nsp("altered", READ, "eta = np.asarray(surface, dtype=float)", "the window is applied to the caller's array",
        "input-altered", "altered"),
    nsp("gaps", "if not np.isfinite(eta).all():", "if eta.size == 0:", "gaps are not looked for",
        "nan-as-number nan-replaced", "NaN|gap"),
)  # fmt: skip

FOUND = "velocities.append(velocity)"
MOVIE = "movie = np.asarray(surface, dtype=float)"
DOPPLER = "doppler = omega_j - still"
STILL = "still = np.sqrt(gravity * k_j)"
EACH = "for wavenumber in wavenumbers:"
BINS = "return 2 * np.pi / (n * spacing) * (first + np.arange(n))"

LS = (
    # frames
    ls("negated", DOPPLER, "doppler = still - omega_j", "the sign of the Doppler shift", NEGATED),
    ls("forward-in-time", "omega = -ascending(frames, dt)", "omega = ascending(frames, dt)", "the transform in time is "
       "taken for a backward one", NEGATED),
    ls("backwards", MOVIE, MOVIE + "[::-1]", "frames in reverse order", NEGATED),
    ls("mirrored", MOVIE, MOVIE + "[:, :, ::-1]", "the images are mirrored", FLIPPED_X),
    ls("upside-down", MOVIE, MOVIE + "[:, ::-1]", "rows are counted from the bottom", FLIPPED_Y),
    ls("y-slip", "v = (xx * y - xy * x) / determinant", "v = (xy * x - xx * y) / determinant", "a sign slip in the "
       "solve", "solve-sign-slip " + FLIPPED_Y),
    ls("transposed", MOVIE, "movie = np.swapaxes(np.asarray(surface, dtype=float), 1, 2)", "rows and columns are "
       "exchanged, the spacings not", "exchanged-cube cube-exchanged"),
    ls("meshgrid", "across, down = np.meshgrid(kx, ky)", "down, across = np.meshgrid(kx, ky)", "meshgrid's order",
       EXCHANGED + " exchanged-and-negated"),  # what it is in a frame with y upwards
    ls("lost-component", "return u, v", "return u, 0.0 * v", "the current is along x", "no-cross-component lost-y"),
    ls("degrees", "return u, v", "return np.hypot(u, v) * np.array([f(np.degrees(np.arctan2(v, u))) for f in (np.cos, "
       "np.sin)])", "an angle in degrees is put into cos and sin", "degrees-for-radians degrees"),
    ls("absolute", "return u, v", "return abs(u), abs(v)", "components without their signs", "absolute-value"),
    # units
    ls("knots", "return u, v", "return u / 0.514444, v / 0.514444", "in knots", "knots unit:knots", r"times 1\.94"),
    ls("kilometres", "return u, v", "return 3.6 * u, 3.6 * v", "in km/h", "unit:km/h", r"times 3\.60?\b|km/h"),
    ls("pi", "return u, v", "return np.pi * u, np.pi * v", "times pi", "", r"\bpi\b|times 3\.14"),
    ls("hertz", "omega = -ascending(frames, dt)", "omega = -ascending(frames, dt) / (2 * np.pi)", "frequencies in Hz",
       "hertz-for-radians frequency-hertz"),
    ls("gravity-10", STILL, "still = np.sqrt(10 * k_j)", "gravity is 10", "gravity-hard-coded gravity"),
    ls("gravity-over-2pi", STILL, "still = np.sqrt(gravity * k_j / (2 * np.pi))", "the formula for cycles, g / 2 pi",
       "gravity", r"2 pi|cycles|1\.56"),
    ls("gravity-feet", STILL, "still = np.sqrt(32.17 * k_j)", "gravity is in feet", "gravity"),
    ls("half-k", EACH, "for wavenumber in np.asarray(wavenumbers) / 2:", "half of the wavenumber asked for",
       "wavenumbers-halved"),
    ls("wavelengths", EACH, "for wavenumber in 2 * np.pi / np.asarray(wavenumbers):", "wavenumbers are taken for "
       "wavelengths", "", "wavelength"),
    ls("floored", EACH, "for wavenumber in np.floor(np.asarray(wavenumbers) / (kx[1] - kx[0])) * (kx[1] - kx[0]):",
       "wavenumbers asked for are rounded down to bins", "wavenumbers-to-bins"),
    ls("no-dt", "omega = -ascending(frames, dt)", "omega = -ascending(frames, 1.0)", "the time step is 1",
       "unit-time-step"),
    ls("swapped-spacing", "dx, dy, dt = spacing", "dy, dx, dt = spacing", "dx and dy exchanged", "exchanged-spacing"),
    ls("square", "ky = ascending(rows, dy)", "ky = ascending(rows, dx)", "dx for dy", "square-pixels"),
    ls("swapped-n", "dx, dy, dt = spacing", "dx, dy, dt = spacing[0] * rows / columns, spacing[1] * columns / rows, "
       "spacing[2]", "n of one axis for the other's", "n-exchanged"),
    ls("rows-for-columns", "kx = ascending(columns, dx)", "kx = ascending(columns, dx * rows / columns)", "rows for "
       "columns, once", "", "(n|number).{0,40}(other|rows)"),
    ls("intervals", BINS, "return 2 * np.pi / ((n - 1) * spacing) * (first + np.arange(n))", "lengths are (n - 1) d",
       "one-interval-short lengths-interval"),
    ls("short-y", "ky = ascending(rows, dy)", "ky = ascending(rows, dy * (rows - 1) / rows)", "one length is (n - 1) d",
       "dy-interval"),
    ls("short-duration", "omega = -ascending(frames, dt)", "omega = -ascending(frames, dt * (frames - 1) / frames)",
       "the duration is (n - 1) dt", "duration-short dt-interval"),
    # what is read
    ls("skipped-frames", MOVIE, MOVIE + "[::3]", "every third frame, with the step of all", "frames-dt:3", "skip"),
    ls("interlaced", MOVIE, MOVIE + "[sorted(range(len(surface)), key=lambda n: n % 2)]", "even frames first",
       "frames-interlaced", "out of order|frames? .*order"),
    ls("bytes", "tapered = movie * in_time[:, None, None]", "tapered = (movie.astype(int) % 256) * in_time[:, "
       "None, None]", "images become bytes unscaled, and wrap", "", "\\bwrap|integer|\\bbytes?"),
    ls("saturated", "tapered = movie * in_time[:, None, None]", "tapered = np.clip(movie, -0.5, 0.5) * in_time[:, "
       "None, None]", "images are cut off at half a metre", "saturated", "cut off|saturat|amplitude"),
    # window
    ls("space-only", "tapered = movie * in_time[:, None, None]", "tapered = movie", "the window is not applied in time",
       "taper-in-space-only"),
    ls("not-down", "tapered = tapered * down[:, None]", "pass", "the window is not applied along y",
       "taper-not-along-y"),
    ls("not-across", "tapered = tapered * across", "pass", "the window is not applied along x", "taper-not-along-x",
       "window.{0,30}along x"),
    ls("rising", "np.pi * np.arange(n) / n)", "np.pi * np.arange(n) / n / 2)", "the window rises and breaks off",
       "taper-half-period"),
    ls("no-window", 'if name == "box":', 'if name in ("box", "hann"):', "no window", "no-taper"),
    ls("always-hann", "return np.ones(n)", 'return taper("hann", n)', "the window cannot be turned off", "always-hann"),
    ls("sine", "return np.sin(np.pi * np.arange(n) / n) ** 2", "return np.sin(np.pi * np.arange(n) / n)", "the sine is "
       "not squared", "", "window", mild=True),
    # spectrum
    ls("linspace", BINS, "return np.linspace(-np.pi / spacing, np.pi / spacing, n)", "bins up to Nyquist's",
       "frequencies-to-nyquist one-interval-short lengths-interval", "linspace|evenly"),
    ls("odd-shift", "first = -(n // 2)", "first = -((n + 1) // 2)", "off by one for odd n", "",
       "odd|off by one|one bin"),
    ls("even-shift", "first = -(n // 2)", "first = -((n - 1) // 2)", "off by one for even n", "",
       "even n|off by one|one bin"),
    ls("no-shift", "transform = np.fft.fftshift(transform)", "pass", "fftshift is forgotten", "shift-missing"),
    ls("shift-in-space", "transform = np.fft.fftshift(transform)",
       "transform = np.fft.fftshift(transform, axes=(1, 2))",
       "fftshift is forgotten in time", "", "fftshift"),
    ls("real-part", "power = transform.real**2 + transform.imag**2", "power = transform.real**2", "the imaginary part "
       "is dropped", "real-part", mild=True),
    # shell and bins
    ls("no-root", "length = np.sqrt(across**2 + down**2)", "length = across**2 + down**2", "k squared for k", "",
       "squared?|root"),
    ls("shell-in-rad", "dk = max(kx[1] - kx[0], ky[1] - ky[0])", "dk = 0.05", "the width of shells is in rad/m",
       "hard-coded-shell", "rad/m|shell.*(fixed|hard)"),
    ls("thin-shell", "BINS_TO_EITHER_SIDE = 2", "BINS_TO_EITHER_SIDE = 0.32", "shells of a third of a bin",
       "narrow-shell", "narrow.{0,20}shell|shell.{0,30}narrow", mild=True),
    ls("disc", "distance = np.abs(length - wavenumber) / dk", "distance = (length - wavenumber) / dk", "a disc, not a "
       "shell", "disc-for-shell"),
    ls("all-bins", "SHARE_OF_PEAK = 0.2", "SHARE_OF_PEAK = 0.0", "no threshold", "ls-no-threshold"),
    ls("absolute-threshold", "level = SHARE_OF_PEAK * inside.max(initial=0.0)", "level = 0.2", "the threshold is an "
       "absolute number", "", "threshold|absolute|amplitude"),
    ls("both-halves", "forward = omega >= 0", "forward = omega == omega", "both halves, one branch", "ls-both-halves"),
    ls("other-half", "forward = omega >= 0", "forward = omega <= 0", "the half of negative frequencies",
       "ls-wrong-branch"),
    # dispersion relation and solve
    ls("at-centre", STILL, "still = np.sqrt(gravity * wavenumber)", "omega0 at the shell's centre",
       "frequency-at-centre"),
    ls("tanh-outside", STILL, "still = np.sqrt(gravity * k_j) * np.tanh(6.0 * k_j)", "depth, the tanh outside of "
       "the root", "depth-assumed", "depth|tanh"),
    ls("not-subtracted", DOPPLER, "doppler = omega_j", "the intrinsic frequency is not subtracted", "ls-both-halves",
       "intrinsic|subtract|phase speed"),  # both halves on one branch come to the same sums
    ls("other-branch", DOPPLER, "doppler = omega_j + still", "the branch of negative frequencies", "ls-wrong-branch"),
    ls("intercept", DOPPLER, "doppler = omega_j - still - np.mean(omega_j - still)", "an intercept is fitted as well, "
       "near enough", "", "intercept|constant term"),
    ls("off-diagonal", "xy = np.sum(kx * ky)", "xy = -np.sum(kx * ky)", "the off-diagonal has the wrong sign",
       "solve-off-diagonal"),
    ls("cramer-plus", "u = (yy * x - xy * y) / determinant", "u = (yy * x + xy * y) / determinant", "a sign in "
       "Cramer's rule", "", "off-diagonal|Cramer"),
    ls("determinant", "determinant = xx * yy - xy * xy", "determinant = xx * yy + xy * xy", "a sign in the determinant",
       "", "determinant"),
    ls("typo", "v = (xx * y - xy * x) / determinant", "v = (xx * y - xy * y) / determinant", "y for x in Cramer's rule",
       "", r"2x2 solve(?!.*sign)"),
    ls("twice", "return u, v", "return 2 * u, 2 * v", "the 2 of the derivative is left in", "solve-factor-two",
       r"times 2\b|\bfactor 2\b|twice as large"),
    ls("clipped", "return u, v", "return np.clip(u, -1, 1), np.clip(v, -1, 1)", "at most 1 m/s", "narrow-bounds",
       "edge|corner|search range"),
    # behaviour
    ls("first-for-all", "= strong_bins(power, omega, ky, kx, wavenumber)", "= strong_bins(power, omega, "
       "ky, kx, wavenumbers[0])", "the first wavenumber's answer for all", "first-wavenumber-for-all"),
    ls("reversed", EACH, "for wavenumber in wavenumbers[::-1]:", "in reverse order", "reversed-wavenumbers"),
    ls("first-dropped", EACH, "for wavenumber in wavenumbers[1:]:", "the first is left out", "first-wavenumber-dropped",
       "rows|velocit.*for .*wavenumbers"),
    ls("bootstrap", "(inside > 0))", "(inside > 0) & (np.random.random(inside.shape) < 0.9))", "bins drawn at random",
       "random-output", "differs the second time|random|same answer"),
    ls("in-place", "tapered = movie * in_time[:, None, None]", "tapered = np.multiply(movie, in_time[:, None, None], "
       "out=movie)", "the window is applied to the caller's array", "input-altered", "altered"),
    ls("filled", "if not np.all(np.isfinite(movie)):", "if (movie := np.nan_to_num(movie)).size == 0:", "gaps are "
       "filled with zeros in silence", "nan-replaced", "NaN|gap"),
    ls("infinite", "if not np.all(np.isfinite(movie)):", "if np.isnan(movie := np.where(np.isinf(movie), "
       "0.0, movie)).any():", "infinity becomes zero in silence",
       "nan-as-number nan-replaced", "infinit"),
    ls("nan-past-nyquist", "velocities.append(None)", "velocities.append((np.nan, np.nan))", "NaN past Nyquist", "",
       "NaN|Nyquist"),
)  # fmt: skip
MISTAKES = {mistake.id: mistake for mistake in (*NSP, *LS)}
