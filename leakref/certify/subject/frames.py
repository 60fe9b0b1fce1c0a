"""The implementation as a check sees it: always in the paper's scaled units, axes x, y, t, y upwards, going-to.

What an implementation declares of itself is kept in a `Declaration`; a `Subject` turns arrays into the declared frame
and units, has them worked on, in this process or in another, and turns answers back. A check never sees a frame. The
stages are those of the protocol: `sea`, `window`, `synthesize`, `spectrum` and `extract`.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from leakref._base import FloatArray
from leakref.certify.subject.answers import Velocities, matched, part, refuse_bad, rows
from leakref.certify.subject.declaration import GRAVITY, PEAK, WATER, Declaration
from leakref.certify.subject.seas import Sea
from leakref.certify.verdict import Unanswered, Verdict
from leakref.dispersion import Water
from leakref.scope import waves_words
from leakref.sea import Components
from leakref.window import WINDOWS
from leakref.window import window as named_window

__all__ = [
    "ASKED",
    "BOTTOMLESS",
    "GRAVITY",
    "OUTPUTS",
    "OWN",
    "PEAK",
    "Call",
    "Subject",
    "Velocities",
    "waves_in_words",
]

BOTTOMLESS = 100.0
"""The k0 h that a code which is handed a depth is handed for deep water: tanh(k h) is 1 for all waves in the shells."""
OUTPUTS = {"sea": "eta", "spectrum": "S", "synthesize": "eta", "window": "w"}
"""What the array is called that a stage gives."""
OWN = "own"
"""Stands for the method of a code that names none."""
ASKED = "nsp"
"""What such a code is asked for, since it may have to be told something (guide protocol, section 3)."""


@dataclass(frozen=True, eq=False)
class Call:
    """What was asked of a stage and what came back, in scaled units and the frame of the checks: for the diagnosis.

    - `stage`: one of the four; `asked`: what identifies the question (shape, wavenumbers, window, method, scale).
    - `answer`: the array that came back: velocities (n, 2), S or eta (nx, ny, nt), or w (size,).
    """

    stage: str
    asked: Mapping[str, Any]
    answer: npt.NDArray[Any]


class Subject:
    """An implementation under judgement. Subclasses say in `_work` where the work is done.

    `_work(stage, arrays, parameters)` is handed arrays in the declared frame and units and the parameters of the stage
    (guide protocol, section 4), and returns the answer in the same: {"velocities": ..., "wavenumbers": ...} or {"S":
    ...} and so on. It raises Unanswered. Arrays for surfaces are float64, C-contiguous, and must come back unaltered.

    Whatever is asked of a stage that is not offered raises Unanswered (unsupported) before any work is done; an answer
    of the wrong form raises Unanswered (fail) and says what it should be.
    """

    watched = True
    """Whether it is seen at work: what it does to its input, and whether it says the same twice."""
    followed = True
    """Whether a wrong answer leads to other questions."""

    def __init__(self, declaration: Declaration) -> None:
        self.declaration = declaration
        self.violations: list[str] = []
        """What it did that it must not, such as altering its input; a check of behaviour reads it."""
        self.calls: list[Call] = []
        """Answers since the running check began."""
        self.gaps = ""
        """Where the running check was given null too often, in words (`criteria.answered`)."""
        self.reproduces = ""
        """Of a code that names no method: which of the reference's it turned out to be, or `OWN` (see `identity`)."""
        self.alike: frozenset[str] | None = None
        """The reference's methods as which it answers a broad sea; None until that was asked (see `identity`)."""
        self.scales: set[float] = set()
        """Those at which it has answered, and `fastest`, in c0, what it was asked for: the scope of the certificate."""
        self.fastest = 0.0
        self.waters: set[tuple[Water, float]] = set()
        """Those in which it has answered, scaled, and at which scale."""
        self.asked_as: Declaration | None = None
        """Whose questions it is asked, if not its own: those of a code which the reference is compared with."""
        self.seas: dict[Any, Any] = {}
        """What was measured in the random seas that it has made, by the sea: several checks look at the same ones."""
        self.handled = 0.0
        """Samples of all cubes that it was asked for, times wavenumbers: what the judging cost, on any machine."""

    def shape_of(self, stage: str, arrays: Mapping[str, Any], parameters: Mapping[str, Any]) -> tuple[int, ...]:
        """Of the array that a stage gives, in its axes: none for `extract`, which gives rows."""
        if stage == "spectrum":
            return tuple(np.shape(arrays["eta"]))
        if stage == "synthesize":
            return tuple(np.size(arrays[axis]) for axis in self.declaration.axes)
        if stage == "sea":
            return tuple(parameters["shape"]["xyt".index(axis)] for axis in self.declaration.axes)
        return (int(parameters["size"]),) if stage == "window" else ()

    def _work(self, stage: str, arrays: dict[str, Any], parameters: dict[str, Any]) -> Mapping[str, Any]:
        raise NotImplementedError

    @property
    def methods(self) -> tuple[str, ...]:
        """The methods it is judged by: those it names, or of one that names none what it turned out to be."""
        return self.declaration.methods or (self.reproduces or OWN,)

    def offers(self, stage: str, **asked: str) -> bool:
        """Whether it offers a stage, with this `window`, `method` or window `name`.

        For `extract` the window must be one of `Declaration.windows` and the method one of `methods`; what is not asked
        about is taken to be offered.
        """
        can = self.declaration.can.get(stage)
        if can is None:
            return False
        if stage == "extract":
            return (
                asked.get("window", self.declaration.windows[0]) in self.declaration.windows
                and asked.get("method", self.methods[0]) in self.methods
            )
        offered = can.get("windows" if stage == "spectrum" else "names", tuple(WINDOWS))
        return all(value in offered for value in asked.values())

    def _require(self, stage: str, **asked: str) -> None:
        """Raises Unanswered (unsupported) unless it offers that."""
        if not self.offers(stage, **asked):
            what = ", ".join(f"{name} {value}" for name, value in asked.items())
            raise Unanswered(Verdict.UNSUPPORTED, f"does not offer {stage}" + f" with {what}" * bool(what))

    # ------------------------------------------------------------ frames and units

    def units(self, scale: float, gravity: float = 1.0) -> tuple[float, float, float]:
        """Unit of length, of time, and gravity, of a scaled sea whose peak is shown at `scale` times the usual one,
        under `gravity` times the usual one.

        They are those of `Declaration.scales`. Scaled lengths and times are multiplied by these units, wavenumbers
        divided by that of length.
        """
        scales = self.declaration.scales(scale, gravity)
        return scales.length, scales.time, scales.gravity

    @property
    def told(self) -> tuple[str, ...]:
        """What of the water it is asked about (`Declaration.told`)."""
        return self.shown_as.told

    @property
    def shown_as(self) -> Declaration:
        """Whose water, waves and cubes it is shown: its own, or those of the code that it is compared with."""
        return self.asked_as or self.declaration

    def still(self, scale: float = 1.0) -> Water:
        """The water that it is asked in, in scaled units (`Declaration.still`)."""
        return self.shown_as.still(scale)

    def _water(self, water: Water, scale: float, gravity: float) -> dict[str, float]:
        """What is handed over of a water, in its units. Raises Unanswered where it cannot be told."""
        d, own = self.declaration, self.still(scale)
        for name in WATER:
            if name not in d.told and getattr(water, name) != getattr(own, name):
                knows = f"one {name} only" if name in d.water else "deep water" if name == "depth" else "no tension"
                raise Unanswered(Verdict.UNSUPPORTED, f"knows {knows.replace('_', ' ')}")
        shown = Water(1.0, BOTTOMLESS if water.depth == np.inf else water.depth, water.surface_tension)
        in_units = shown.to_units(d.scales(scale, gravity))
        return {name: float(getattr(in_units, name)) for name in d.told}

    def framed(self, cube: FloatArray) -> FloatArray:
        """A cube [x, y, t] with y upwards, as the implementation wants it. A new array, float64 and contiguous."""
        seen = cube[:, ::-1] if self.declaration.y == "down" else cube
        order = ["xyt".index(axis) for axis in self.declaration.axes]
        return np.array(seen.transpose(order), dtype=np.float64, order="C")

    def unframed(self, cube: npt.ArrayLike) -> npt.NDArray[Any]:
        """The inverse of `framed`, for what has its axes in the declared order, but for the direction of y."""
        return np.transpose(np.asarray(cube), [self.declaration.axes.index(axis) for axis in "xyt"])

    def _surface(
        self, surface: FloatArray, spacing: Sequence[float], scale: float, gravity: float = 1.0
    ) -> tuple[dict[str, Any], list[float], float]:
        """The arrays eta, x, y, t in its units and frame, the steps dx, dy, dt, and gravity. Raises Unanswered for a
        cube whose pixels are not square where it cannot be told so.
        """
        if against := self.declaration.takes(surface.shape):
            raise Unanswered(Verdict.UNSUPPORTED, f"{against}; this has {surface.shape}")
        if "dy" in self.declaration.untold and abs(spacing[1] - spacing[0]) > 1e-9 * spacing[0]:
            raise Unanswered(Verdict.UNSUPPORTED, "knows square pixels only, and dy is not dx here")
        length, time, gravity = self.units(scale, gravity)
        steps = [spacing[0] * length, spacing[1] * length, spacing[2] * time]
        lasts, least = surface.shape[2] * steps[2], self.declaration.least_duration
        if lasts < least * (1 - 1e-9):
            unit = " s" if self.declaration.units == "si" else " / omega0"
            words = f"takes no record shorter than {least:g}{unit}; this has {lasts:.3g}{unit}"
            raise Unanswered(Verdict.UNSUPPORTED, words)
        axes = {name: np.arange(n) * step for name, n, step in zip("xyt", surface.shape, steps, strict=True)}
        return {"eta": self.framed(surface * length), **axes}, steps, gravity

    # ------------------------------------------------------------ the stages

    def extract(
        self,
        surface: FloatArray,
        spacing: Sequence[float],
        wavenumbers: npt.ArrayLike,
        *,
        window: str = "hann",
        method: str | None = None,
        scale: float = 1.0,
        gravity: float = 1.0,
        water: Water | None = None,
        raw: bool = False,
    ) -> Velocities:
        """Velocities (n, 2) at `wavenumbers` (n,), all in scaled units. Raises Unanswered.

        A number that is not finite is a failure; one that is declined is NaN here, and all declined is no answer
        (missing). With `raw` the surface is handed over as it is, whatever it holds, and what comes back is only
        converted.

        `surface` is (nx, ny, nt) in units of `1 / k0`, `spacing` (dx, dy, dt) in `1 / k0` and `1 / omega0`. `method` is
        its main one unless given. `scale` shows the same sea with its peak elsewhere, `gravity` under another gravity
        (`units`). The sea is in `water`, in scaled units; None is the one that the code is asked in. A code that tapers
        nothing is handed a cube that is tapered already, and told `box`.

        Answers are matched to the wavenumbers asked for, to within half a bin; for one that has none that near it
        counts as declined. A band's single answer is repeated for each.
        """
        d = self.declaration
        method = method or self.methods[0]
        self._require("extract", window=window, method=method)
        asked = np.atleast_1d(np.asarray(wavenumbers, dtype=np.float64))
        if not d.tapers and window != "box":
            surface = _tapered(surface, window)
        water = self.still(scale) if water is None else water
        told = self._water(water, scale, gravity)
        if not (shown := self.shown_as).shows(scale):
            words = f"is made for {waves_in_words(shown)}; these are {_long(shown, scale)} long"
            raise Unanswered(Verdict.UNSUPPORTED, words)
        length, time, _ = self.units(scale, gravity)
        arrays, steps, gravity = self._surface(surface, spacing, scale, gravity)
        parameters = {
            "dx": steps[0],
            "dy": steps[1],
            "dt": steps[2],
            "gravity": gravity,
            **told,
            "wavenumbers": (asked / length).tolist(),
            "window": window if d.tapers else "box",
            "method": method if d.methods else ASKED,
        }
        self.handled += surface.size * asked.size
        answer = self._work("extract", arrays, parameters)
        answered, at = rows(answer, asked / length, d)
        if not raw:
            refuse_bad(answered)
        values = answered * time / length
        if d.y == "down":
            values[:, 1] *= -1
        if d.direction == "from":
            values *= -1
        found = matched(asked, values, None if at is None else at * length, steps, surface.shape, length, d)
        if found.declined.all() and not raw:
            raise Unanswered(Verdict.MISSING, f"gave no velocity at any of {asked.size} wavenumbers")
        if water.surface_tension == self.still(scale).surface_tension:
            self.scales.add(scale)  # else it is shown the waves that feel it
        self.waters.add((water, scale))
        about = {"wavenumbers": asked, "window": window, "method": method, "scale": scale, "water": water}
        self._kept("extract", {"shape": surface.shape, **about}, found.values)
        return found

    def spectrum(self, surface: FloatArray, spacing: Sequence[float], window: str) -> npt.NDArray[Any]:
        """S or its magnitude, (nx, ny, nt), of the surface as the array that it is: y is not turned over.

        `spacing` is in scaled units, and of the answer only the shape is checked. Bins are in the order of `fftfreq`
        along every axis, in the axes x, y, t.
        """
        self._require("spectrum", window=window)
        arrays, steps, _ = self._surface(surface, spacing, 1.0)
        if self.declaration.y == "down":  # a transform knows nothing of up and down: array in, array out
            arrays["eta"] = np.ascontiguousarray(
                arrays["eta"][
                    tuple(slice(None, None, -1) if axis == "y" else slice(None) for axis in self.declaration.axes)
                ]
            )
        answer = self._work("spectrum", arrays, {"dx": steps[0], "dy": steps[1], "dt": steps[2], "window": window})
        found = np.asarray(part(answer, "S"))
        if found.shape != arrays["eta"].shape:
            raise Unanswered(Verdict.FAIL, f"S has shape {found.shape}, should be that of eta, {arrays['eta'].shape}")
        return self._kept("spectrum", {"shape": surface.shape, "window": window}, self.unframed(found))

    def synthesize(self, components: Components, x: FloatArray, y: FloatArray, t: FloatArray) -> FloatArray:
        """The surface (nx, ny, nt), in units of 1 / k0.

        `components` are in scaled units; `x` (nx,), `y` (ny,) in `1 / k0`, and `t` (nt,) in `1 / omega0`. For rows that
        count downwards the waves are mirrored and their phases moved, so that the same surface is asked for.
        """
        self._require("synthesize")
        length, time, _ = self.units(1.0)
        flip = self.declaration.y == "down"
        up = (y[-1] + y[0]) if flip else 0.0  # rows counted downwards: y' = up - y
        sign = -1.0 if flip else 1.0
        phase = components.phase + (components.ky * up if flip else 0.0)
        arrays = {
            "kx": components.kx / length,
            "ky": sign * components.ky / length,
            "omega": components.omega / time,
            "amplitude": components.amplitude * length,
            "phase": phase,
            "x": x * length,
            "y": y * length,
            "t": t * time,
        }
        found = np.asarray(part(self._work("synthesize", arrays, {}), "eta"))
        shape = tuple({"x": x.size, "y": y.size, "t": t.size}[axis] for axis in self.declaration.axes)
        if found.shape != shape or found.dtype.kind not in "fiu":
            raise Unanswered(Verdict.FAIL, f"eta has shape {found.shape} of {found.dtype}, should be real, {shape}")
        eta = self.unframed(found)
        eta = np.asarray(eta[:, ::-1] if flip else eta, dtype=np.float64) / length
        return self._kept("synthesize", {"waves": components.kx.size}, eta)

    def sea(self, asked: Sea, seed: int) -> FloatArray:
        """A random sea (nx, ny, nt), in units of 1 / k0. Raises Unanswered, also for what is not finite."""
        self._require("sea")
        if against := self.declaration.takes(asked.grid.shape):
            raise Unanswered(Verdict.UNSUPPORTED, f"{against}; this has {asked.grid.shape}")
        told = self._water(asked.water, 1.0, 1.0)
        parameters = {**asked.parameters(self.declaration, seed), **told}
        found = np.asarray(part(self._work("sea", {}, parameters), "eta"))
        shape = tuple(asked.grid.shape["xyt".index(axis)] for axis in self.declaration.axes)
        if found.shape != shape or found.dtype.kind not in "fiu":
            raise Unanswered(Verdict.FAIL, f"eta has shape {found.shape} of {found.dtype}, should be real, {shape}")
        if not np.isfinite(found).all():
            raise Unanswered(Verdict.FAIL, "eta holds values that are not finite")
        eta = self.unframed(found)
        eta = eta[:, ::-1] if self.declaration.y == "down" else eta
        self.waters.add((asked.water, 1.0))
        self.fastest = max(self.fastest, float(np.hypot(*asked.current)))
        self.handled += eta.size
        return np.asarray(eta, dtype=np.float64) / self.units(1.0)[0]

    def window(self, name: str, size: int) -> FloatArray:
        """Samples of a window, (size,).

        A row or a column of that many numbers is taken as well. They must be real.
        """
        self._require("window", name=name)
        found = np.asarray(part(self._work("window", {}, {"name": name, "size": size}), "w"))
        if found.size != size or found.dtype.kind not in "fiu":
            raise Unanswered(Verdict.FAIL, f"w has shape {found.shape} of {found.dtype}, should be {size} real numbers")
        return self._kept("window", {"name": name, "size": size}, found.astype(np.float64).ravel())

    def _kept(self, stage: str, asked: Mapping[str, Any], answer: npt.NDArray[Any]) -> npt.NDArray[Any]:
        """Written down for the diagnosis, which asks the reference with a fault the same and compares."""
        self.calls.append(Call(stage, asked, answer))
        return answer


def _tapered(surface: FloatArray, window: str) -> FloatArray:
    """A cube times the window along each axis, for a code that tapers nothing itself."""
    wx, wy, wt = (named_window(window).samples(n) for n in surface.shape)
    return surface * wx[:, None, None] * wy[:, None] * wt


def waves_in_words(declaration: Declaration) -> str:
    """Those that it is made for; empty if it does not say."""
    if "peak_wavelength" not in declaration.waves:
        return ""
    return waves_words(*declaration.waves["peak_wavelength"])


def _long(declaration: Declaration, scale: float) -> str:
    return f"{2 * np.pi * declaration.scales(scale).length:.3g} m"
