"""Repairs: what may stand around a code so that its answers come right, by name.

Each is the inverse of a mistake that people make, and called by the mistake where that has a name. `OUTPUTS` change
what the code answered, which costs no call, `INPUTS` what it is handed: parameters first, then the cube and its steps.
`cure` looks for the smallest under which what failed comes right.

All are in the frame and the units that the code declares, since that is where its mistake is. A repair need not undo
the mistake line by line: it is enough that a right code would answer the repaired question as it stands.

- A length or a duration of (n - 1) d is cured by a step that is n / (n - 1) times as long: then (n - 1) times the step
  is the length that the cube has.
- A gravity G that stands in the code is cured by another unit of time: with times multiplied by sqrt(g / G) the gravity
  of the cube is G, and the velocities that come back are multiplied by the same factor.
- A number in m or rad/s that suits other waves is cured by showing the sea smaller or larger by Froude's law, with all
  lengths multiplied by b and all times by sqrt(b), under which gravity is the same.
- A code that reads every second frame and believes that it reads all is cured by a frame interpolated between any two:
  then it reads those that there were, at the step that they had.
- A taper that is missing along an axis is cured by a cube that is tapered along it beforehand, and any window that is
  wrong by a cube that is tapered along all of them and no window asked for.

Some mistakes have no such inverse: an angle in degrees put into a cosine cannot be taken out of it. These are left to
the faults of the reference (`replays`), which know them by what they do.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np
import numpy.typing as npt
import scipy.fft

from leakref._base import FloatArray
from leakref.certify.strength.repaired import Back, Question, Repair, joined
from leakref.dispersion import Scales, Water
from leakref.window import window as named_window

__all__ = [
    "GRAVITIES",
    "IMAGES",
    "INPUTS",
    "KNOWN_GRAVITIES",
    "NUMBERS",
    "OUTPUTS",
    "PAIRS",
    "UNITS",
    "factor",
    "gravity",
    "linear",
    "turned",
]

# ---------------------------------------------------------------- of the answer


def linear(identifier: str, words: str, matrix: npt.ArrayLike) -> Repair:
    """The answer times a matrix (2, 2)."""
    m = np.asarray(matrix, dtype=np.float64)
    rows = (float(m[0, 0]), float(m[0, 1])), (float(m[1, 0]), float(m[1, 1]))
    return Repair(identifier, words, back=lambda v, q: v @ m.T, matrix=rows)


UNITS = {"knots": 1.943844, "km/h": 3.6, "cm/s": 100.0, "mm/s": 1000.0, "feet/s": 1 / 0.3048}
"""In which a velocity of 1 m/s may have come out."""
NUMBERS = {
    "2": 2.0, "1/2": 0.5, "3": 3.0, "1/3": 1 / 3, "the root of 2": 2**0.5, "the root of 1/2": 0.5**0.5, "pi": np.pi,
    "1 / pi": 1 / np.pi, "2 pi": 2 * np.pi, "1 / (2 pi)": 0.5 / np.pi, "9.81": 9.81, "1 / 9.81": 1 / 9.81,
}  # fmt: skip
"""Times which it may have come out."""


def factor(x: float, y: float, digits: float) -> Repair:
    """The answer times a factor, x and y by themselves if they differ, as it was found, to so many `digits`.

    `x` and `y` are what velocities are multiplied by to come right, so that their inverses are what came out too large.
    A factor that is one of `UNITS` or `NUMBERS` to within that is taken for it.
    """
    near = max(3 * 10**-digits, 1e-12)
    if x == y:
        by, out, name = x, _shown(1 / x, digits), "factor"
        for unit, value in UNITS.items():
            if abs(x * value - 1) <= near:
                by, out, name = 1 / value, f"{value:.4g}, as if in {unit}", f"unit:{unit}"
        for words, value in NUMBERS.items():
            if abs(x * value - 1) <= near:
                by, out = 1 / value, words
        told = f"its velocities are multiplied by {_shown(by, max(digits, 3))}: they come out times {out}"
        return linear(name, told, np.diag([by, by]))
    for axis, value, rest, matrix in (("x", x, y, np.diag([x, 1.0])), ("y", y, x, np.diag([1.0, y]))):
        if abs(rest - 1) <= 3 * near:
            words = f"the {axis} component is multiplied by {_shown(value, digits)}"
            return linear(f"factor-{axis}", words, matrix)
    words = f"the x component is multiplied by {_shown(x, digits)} and y by {_shown(y, digits)}"
    return linear("factor-x+factor-y", words, np.diag([x, y]))


def turned(by: complex, digits: float) -> Repair:
    """The answer turned by an angle, and times a factor if it is not one: a complex number."""
    angle, size = float(np.degrees(np.angle(by))), abs(by)
    words = f"its velocities are turned by {angle:.{int(digits > 2)}f} degrees"
    if abs(size - 1) > 10**-digits:
        words += f" and multiplied by {_shown(size, digits)}"
    else:
        by /= size
    return linear("turned", words, [[by.real, -by.imag], [by.imag, by.real]])


def _shown(value: float, digits: float) -> str:
    """To the digits that are known."""
    return f"{value:.{int(np.clip(np.ceil(digits), 2, 7))}g}"


def _polar(turn: Callable[[FloatArray], FloatArray]) -> Back:
    """From rows of speed and angle; `turn` makes of the angle one anticlockwise from x, in radians."""
    return lambda v, q: v[:, :1] * np.stack([np.cos(turn(v[:, 1])), np.sin(turn(v[:, 1]))], axis=1)


IMAGES = (
    linear("negated", "its velocities are negated", [[-1, 0], [0, -1]]),
    linear("flipped-x", "the x component is negated", [[-1, 0], [0, 1]]),
    linear("flipped-y", "the y component is negated", [[1, 0], [0, -1]]),
    linear("exchanged", "the components are exchanged", [[0, 1], [1, 0]]),
    linear("quarter-turn", "its velocities are turned left by a quarter turn", [[0, -1], [1, 0]]),
    linear("quarter-turn-back", "its velocities are turned right by a quarter turn", [[0, 1], [-1, 0]]),
    linear("exchanged-and-negated", "the components are exchanged and negated", [[0, -1], [-1, 0]]),
)
_READ = "its two numbers are read as speed and direction"
_OTHERS = (
    Repair("unit:pixels-per-frame", "its velocities are multiplied by dx / dt and dy / dt: pixels per frame",
           back=lambda v, q: v * np.array(q.steps[:2]) / q.steps[2]),
    Repair("unit:pixels-per-time", "its velocities are multiplied by dx and dy: pixels per time",
           back=lambda v, q: v * np.array(q.steps[:2])),
    Repair("unit:per-frame", "its velocities are divided by dt: lengths per frame", back=lambda v, q: v / q.steps[2]),
    Repair("doppler-frequency", "its velocities are divided by the wavenumber: Doppler shifts k c",
           back=lambda v, q: v / _at(q, v)),
    Repair("multiplied-by-wavenumber", "its velocities are multiplied by the wavenumber",
           back=lambda v, q: v * _at(q, v)),
    Repair("unit:phase-speeds", "its velocities are multiplied by the phase speed of the waves, in whose unit they are",
           back=lambda v, q: v * Water(q.gravity, **q.water).phase_velocity(_at(q, v))),
    Repair("polar", f"{_READ}, in radians from x", back=_polar(lambda a: a)),
    Repair("polar-degrees", f"{_READ}, in degrees from x", back=_polar(np.radians)),
    Repair("compass", f"{_READ}, in degrees clockwise from y", back=_polar(lambda a: np.pi / 2 - np.radians(a))),
    Repair("compass-from", f"{_READ} it comes from, in degrees clockwise from y",
           back=_polar(lambda a: -np.pi / 2 - np.radians(a))),
    Repair("reversed-wavenumbers", "its velocities are taken in the reverse order", back=lambda v, q: v[::-1]),
)  # fmt: skip
OUTPUTS = (*IMAGES, *_OTHERS)
"""Repairs of the answer, which cost no call."""


def _at(q: Question, v: FloatArray) -> FloatArray:
    """The wavenumbers of answers (m, 2), as a column; ones where they are not those asked for."""
    return q.wavenumbers[:, None] if len(v) == q.wavenumbers.size else np.ones((1, 1))


# ---------------------------------------------------------------- of what is handed over


def _stepped(q: Question, x: float = 1.0, y: float = 1.0, t: float = 1.0) -> Question:
    return replace(q, steps=(q.steps[0] * x, q.steps[1] * y, q.steps[2] * t))


def _in_units(length: Callable[[Question], float], time: Callable[[Question], float], **more: Any) -> dict[str, Any]:
    """The same sea with lengths and times multiplied: a right code answers the same."""

    def change(q: Question) -> Question:
        b, a = length(q), time(q)
        handed = _stepped(q, b, b, a)
        units = {"depth": b, "surface_tension": b**3 / a**2}
        water = {name: value * units[name] for name, value in q.water.items()}
        return replace(handed, eta=q.eta * b, gravity=q.gravity * b / a**2, wavenumbers=q.wavenumbers / b, water=water)

    return {"change": change, "back": lambda v, q: v * (time(q) / length(q)), "at": length, **more}


def gravity(value: float, digits: int = 4) -> Repair:
    """In units of time in which gravity is what the code seems to take it for.

    Its rival is a gravity half as large again: under which a code that takes it for `value` is wrong, and one that
    merely does better in other units (since it rounds) is right as well.
    """
    return replace(_of_gravity(value, digits), rival=_of_gravity(1.5 * value, digits))


def _of_gravity(value: float, digits: int) -> Repair:
    words = f"gravity is {value:.{digits}g}, whatever it is told (by the unit of time)"
    unit = Scales(gravity=value).time
    by = _in_units(lambda q: 1.0, lambda q: unit / Scales(gravity=q.gravity).time)
    return Repair("gravity", words, **by)


KNOWN_GRAVITIES = (1.0, 9.81, 9.8, 9.80665, 10.0, 32.2, 981.0)
"""That people write down, in m/s2, ft/s2 and cm/s2."""
GRAVITIES = tuple(map(gravity, KNOWN_GRAVITIES))


def _interval(q: Question, which: str, sign: int) -> Question:
    """Steps of the axes in `which` times n / (n - 1), or the inverse."""
    by = {axis: (n / (n - 1)) ** sign for axis, n in zip("xyt", q.sizes, strict=True) if axis in which}
    return _stepped(q, **by)


def _intervals() -> list[Repair]:
    axes = {"dt": "t", "dx": "x", "dy": "y", "sides": "xy", "lengths": "xyt"}
    said = {"sides": "dx and dy are", "lengths": "dx, dy and dt are"}
    return [
        Repair(f"{name}-interval" + "-back" * (sign < 0),
               f"{said.get(name, f'{name} is')} multiplied by {by}, n the number of samples",
               partial(_interval, which=which, sign=sign))
        for name, which in axes.items() for sign, by in ((1, "n / (n - 1)"), (-1, "(n - 1) / n"))
    ]  # fmt: skip


def _sides(q: Question, x: int, y: int) -> Question:
    """dx times nx / ny to the power x, dy times ny / nx to the power y."""
    nx, ny = q.sizes[:2]
    return _stepped(q, (nx / ny) ** x, (ny / nx) ** y)


def _flipped(q: Question, axis: int) -> Question:
    return replace(q, eta=np.flip(q.eta, axis))


def _tapered(q: Question, axes: tuple[int, ...]) -> Question:
    """Times the window that was asked for: along some axes, beside what the code does along the others, or along all,
    with nothing left to do for it.
    """
    eta = q.eta
    for axis in axes if q.window != "box" else ():
        samples = named_window(q.window).samples(eta.shape[axis])
        eta = eta * samples.reshape([-1 if n == axis else 1 for n in range(3)])
    return replace(q, eta=eta, window="box" if len(axes) == 3 else q.window)


def _resampled(q: Question, sizes: tuple[int, ...]) -> Question:
    """The same lengths with more samples along some axes, interpolated by Fourier's series."""
    eta, steps = q.eta, list(q.steps)
    for axis, (n, more) in enumerate(zip(eta.shape, sizes, strict=True)):
        if n != more:
            spectrum = scipy.fft.rfft(eta, axis=axis)
            if n % 2 == 0:  # the Nyquist bin, which is two in the longer one
                spectrum[tuple(-1 if m == axis else slice(None) for m in range(3))] /= 2
            eta = scipy.fft.irfft(spectrum, more, axis=axis) * (more / n)
            steps[axis] *= n / more
    return replace(q, eta=eta, steps=(steps[0], steps[1], steps[2]), sizes=eta.shape)


def _made(q: Question, axes: tuple[int, ...], odd: int) -> Question:
    """With an odd (or even) number of samples along some axes."""
    return _resampled(q, tuple(n + (axis in axes and n % 2 != odd) for axis, n in enumerate(q.eta.shape)))


def _skipped(q: Question, every: int) -> Question:
    """With frames interpolated, so that every second (or third) is one that there was; the step is said to be theirs.

    Whoever reads these and no others reads the whole cube, whatever waves there are.
    """
    nx, ny, nt = q.eta.shape
    return _stepped(_resampled(q, (nx, ny, nt * every)), t=every)


def _interlaced(q: Question) -> Question:
    """With the frames in such an order that they are in the right one when those of even number are put first."""
    first = np.argsort(np.arange(q.eta.shape[2]) % 2, kind="stable")
    return replace(q, eta=q.eta[:, :, np.argsort(first)])


def _ascending(q: Question) -> Question:
    return replace(q, wavenumbers=np.sort(q.wavenumbers))


def _unsorted(v: FloatArray, q: Question) -> FloatArray:
    return v[np.argsort(np.argsort(q.wavenumbers))] if len(v) == q.wavenumbers.size else v


def _moved(q: Question, bins: float) -> Question:
    return replace(q, wavenumbers=q.wavenumbers + bins * q.bin)


def _times(q: Question, by: float) -> Question:
    return replace(q, wavenumbers=q.wavenumbers * by)


def _froude(scale: float) -> dict[str, Any]:
    """Shown smaller by a factor (or larger, below 1) by Froude's law: gravity is the same."""
    smaller = Scales(peak_wavenumber=scale)
    return _in_units(lambda q: smaller.length, lambda q: smaller.time)


def _deeper(q: Question, by: float) -> Question:
    return replace(q, water={n: v * by if n == "depth" else v for n, v in q.water.items()})


_TAU = 2 * np.pi
_PARAMETERS = (
    Repair("wavenumbers-cycles", "wavenumbers are multiplied by 2 pi: it divides them", partial(_times, by=_TAU)),
    Repair("wavenumbers-times-two-pi", "wavenumbers are divided by 2 pi: it takes cycles per length",
           partial(_times, by=1 / _TAU)),
    Repair("wavenumbers-halved", "wavenumbers are doubled: it halves them", partial(_times, by=2.0)),
    Repair("wavenumbers-doubled", "wavenumbers are halved: it doubles them", partial(_times, by=0.5)),
    Repair("wavenumbers-for-wavelengths", "wavelengths are given in place of wavenumbers",
           lambda q: replace(q, wavenumbers=_TAU / q.wavenumbers)),
    Repair("wavenumbers-squared", "wavenumbers are squared: it compares them with k squared",
           lambda q: replace(q, wavenumbers=q.wavenumbers**2)),
    Repair("wavenumbers-to-bins", "half a bin is added to wavenumbers: answers are at the bin below",
           partial(_moved, bins=0.5)),
    Repair("wavenumbers-bin-up", "a bin is added to wavenumbers", partial(_moved, bins=1.0)),
    Repair("wavenumbers-bin-down", "a bin is taken from wavenumbers", partial(_moved, bins=-1.0)),
    Repair("sorted-wavenumbers", "wavenumbers are given in ascending order", _ascending, _unsorted),
    Repair("one-by-one", "each wavenumber is asked for by itself", alone=True),
    Repair("gravity-per-two-pi", "gravity is multiplied by 2 pi, as in formulas for cycles",
           lambda q: replace(q, gravity=q.gravity * _TAU)),
    Repair("gravity-times-two-pi", "gravity is divided by 2 pi", lambda q: replace(q, gravity=q.gravity / _TAU)),
    Repair("frequency-hertz", "dt is divided by 2 pi: frequencies are in Hz", partial(_stepped, t=1 / _TAU)),
    Repair("frequency-times-two-pi", "dt is multiplied by 2 pi", partial(_stepped, t=_TAU)),
    Repair("lengths-cycles", "dx and dy are divided by 2 pi: wavenumbers are in cycles",
           partial(_stepped, x=1 / _TAU, y=1 / _TAU)),
    Repair("frame-rate", "1 / dt is given for dt", lambda q: _stepped(q, t=q.steps[2] ** -2)),
    Repair("exchanged-spacing", "dx and dy are exchanged", lambda q: _stepped(q, q.steps[1] / q.steps[0],
                                                                              q.steps[0] / q.steps[1])),
    *(Repair(name, f"depth is {said}", partial(_deeper, by=by)) for name, said, by in (
        ("depth-feet", "given in feet: it multiplies it by 0.3048", 1 / 0.3048),
        ("depth-metres-as-feet", "multiplied by 0.3048: it makes feet of it", 0.3048),
        ("depth-cycles", "multiplied by 2 pi: it divides it", _TAU), ("depth-halved", "doubled: it halves it", 2.0),
        ("depth-times-two-pi", "divided by 2 pi: it multiplies it", 1 / _TAU))),
    Repair("unit-time-step", "times are in frames, so that dt is 1",
           **_in_units(lambda q: 1.0, lambda q: 1 / q.steps[2])),
    Repair("unit-dx", "lengths are in pixels, so that dx is 1",
           **_in_units(lambda q: 1 / q.steps[0], lambda q: 1.0)),
)  # fmt: skip
_INPUT = (
    *_intervals(),
    Repair("n-exchanged", "dx is multiplied by nx / ny and dy by ny / nx: their numbers of samples are exchanged",
           partial(_sides, x=1, y=1)),
    Repair("ny-for-nx", "dx is multiplied by nx / ny: ny is used for nx", partial(_sides, x=1, y=0)),
    Repair("nx-for-ny", "dy is multiplied by ny / nx: nx is used for ny", partial(_sides, x=0, y=1)),
    Repair("dt-doubled", "dt is doubled", partial(_stepped, t=2.0)),
    Repair("dt-halved", "dt is halved", partial(_stepped, t=0.5)),
    Repair("frames-dt:2", "a frame is interpolated between any two, as if it read every second",
           partial(_skipped, every=2)),
    Repair("frames-dt:3", "two frames are interpolated between any two, as if it read every third",
           partial(_skipped, every=3)),
    Repair("frames-interlaced", "the frames are given out of order: it puts those of even number first", _interlaced),
    Repair("x-reversed", "the cube is reversed along x", partial(_flipped, axis=0)),
    Repair("y-reversed", "the cube is reversed along y", partial(_flipped, axis=1)),
    Repair("time-reversed", "the frames are given in reverse order", partial(_flipped, axis=2)),
    Repair("cube-exchanged", "the axes x and y of the cube are exchanged, and nothing else",
           lambda q: replace(q, eta=np.swapaxes(q.eta, 0, 1))),
    Repair("mean-removed", "the mean is taken from the cube", lambda q: replace(q, eta=q.eta - q.eta.mean())),
    Repair("normalised", "the cube is divided by its standard deviation",
           lambda q: replace(q, eta=q.eta / (float(q.eta.std()) or 1.0))),
    *(Repair(name, f"the cube is tapered {said} as well, beforehand", partial(_tapered, axes=axes))
      for name, said, axes in (("taper-not-along-x", "along x", (0,)), ("taper-not-along-y", "along y", (1,)),
                               ("taper-in-space-only", "in time", (2,)), ("taper-in-time-only", "in space", (0, 1)))),
    Repair("no-taper", "the cube is tapered beforehand and no window is asked for", partial(_tapered, axes=(0, 1, 2))),
    *(Repair(f"{name}-{parity}", f"the number n of {said} is {parity}, by interpolation: it goes wrong for {other} n",
             partial(_made, axes=axes, odd=odd))
      for name, said, axes in (("frames", "frames", (2,)), ("sides", "samples along x and y", (0, 1)),
                               ("samples", "samples along each axis", (0, 1, 2)))
      for odd, (parity, other) in enumerate((("even", "odd"), ("odd", "even")))),
    Repair("square-pixels", "pixels are square", square=True),
    *(Repair(f"waves:{name}", f"the waves are {said} by Froude's law: a width, range or depth in it is fixed",
             **_froude(scale))
      for name, said, scale in (("1/16", "16 times shorter", 16.0), ("1/4", "4 times shorter", 4.0),
                                ("4", "4 times longer", 0.25), ("16", "16 times longer", 1 / 16))),
)  # fmt: skip
INPUTS = (*_PARAMETERS, *_INPUT)
"""Repairs of what is handed over: parameters first, then the cube and its steps."""
_BY_ID = {repair.id: repair for repair in INPUTS}
PAIRS = tuple(
    joined(_BY_ID[first], _BY_ID[second])
    for first, second in (
        ("dt-interval", "frequency-hertz"), ("sides-interval", "lengths-cycles"), ("dt-interval", "square-pixels"),
        ("sides-interval", "square-pixels"), ("dt-interval", "n-exchanged"), ("dt-interval", "exchanged-spacing"),
        ("wavenumbers-cycles", "lengths-cycles"), ("frequency-hertz", "wavenumbers-cycles"),
        ("dt-interval", "no-taper"), ("sides-interval", "no-taper"),
        ("unit-time-step", "unit-dx"), ("dt-interval", "cube-exchanged"), ("frames-dt:2", "dt-interval"),
        ("dt-interval", "wavenumbers-halved"), ("sides-interval", "wavenumbers-halved"),
    )
)  # fmt: skip
"""Two at once, of what was handed over."""
