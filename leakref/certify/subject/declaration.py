"""What an implementation says of itself: units, axes, directions, what it can do and what it cannot be told.

It is read once, at the start, from what the program says or from `describe()` of a Python object, and printed on the
certificate. Everything that a check asks is put into these terms by `frames.Subject`. What is declared wrongly is
refused here with the name of the field, before any check is run.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from leakref.certify.verdict import Unanswered, Verdict, printable
from leakref.dispersion import Scales, Water

__all__ = ["GIVEN", "GRAVITY", "PEAK", "STAGES", "WATER", "Declaration"]

PEAK = 0.25
"""rad/m: the peak wavenumber at which an implementation in metres and seconds is shown the scaled seas; 25 m waves."""
GRAVITY = 9.81
"""In m/s2, for a code in SI."""
WATER = ("depth", "surface_tension")
"""What may be declared of the water: `GIVEN`, or a number."""
GIVEN = "given"
"""Of a parameter that is handed over with each run."""
_ENDS = 16.0  # times shorter or longer than usual: what a code is shown that says nothing of its waves
_OF_WATER = {
    "si": {"depth": (1e-4, 1.2e4), "surface_tension": (1e-9, 1e-3)},
    "scaled": {"depth": (1e-3, 1e6), "surface_tension": (1e-12, 10.0)},
}  # in which any code's are: the ocean is 11 km deep, and 0.07 is the surface tension of water in N/m
_SHALLOWEST = 0.7  # k0 h: a code with one depth is shown shorter waves rather than such as feel the bottom more

STAGES = ("sea", "window", "synthesize", "spectrum", "extract")
"""In the order of the chain."""
_LONGEST = 120  # characters of a word
_DEFAULT = {"name": "unnamed", "version": "", "units": "scaled", "axes": "xyt", "y": "up", "direction": "to"}


@dataclass(frozen=True)
class Declaration:
    """The declaration of guide protocol, section 3, checked and completed.

    `fixed` are parameters that it cannot be told: `wavenumbers` if it has its own, `dy` if it knows square pixels only,
    `gravity` if it has one. `cube` may hold `smallest`, the samples along x, y and t below which it takes none,
    `multiple`, of which all three must be multiples, or `shape`, the only ones it takes, and `duration`, the time below
    which it takes none. `waves` may hold
    `peak_wavelength`, the shortest and the longest in m that it is made for, and `fastest`, in m/s (SI only). `water`
    may hold `depth` and `surface_tension` (over density): `given` if they are handed over with each run, or the number
    that stands in the code, in its units; without them it knows deep water, and no tension.

    - `name`, `version`: words for the certificate, at most 120 characters each.
    - `units`: `si` (m, s) or `scaled` (lengths in `1 / k0`, times in `1 / omega0`, gravity 1).
    - `axes`: the order of the axes of a cube, a permutation of `xyt`; `y`: `up` or `down`, which way rows count.
    - `direction`: `to` where a current is given by where it goes, `from` where by where it comes from.
    - `format`: of the arrays exchanged with a program, `npz`, `mat` or `raw`.
    - `can`: for each stage offered what of it: `methods`, `windows` and `resolves` of `extract`, `windows` of
      `spectrum`, `names` of `window`, `amplitudes` of `sea`. What is left out has a default.
    """

    name: str = "unnamed"
    version: str = ""
    units: str = "scaled"
    axes: str = "xyt"
    y: str = "up"
    direction: str = "to"
    format: str = "npz"
    fixed: tuple[str, ...] = ()
    cube: Mapping[str, Any] = field(default_factory=dict)
    water: Mapping[str, Any] = field(default_factory=dict)
    waves: Mapping[str, Any] = field(default_factory=dict)
    can: Mapping[str, Mapping[str, Any]] = field(default_factory=lambda: {"extract": {}})

    @classmethod
    def read(cls, given: Mapping[str, Any]) -> Declaration:
        """From an object somebody wrote, whose words are cleaned here and nowhere else.

        Raises Unanswered (error) that names the field that is wrong.

        Keys it does not know are ignored; fields that are missing have the defaults of the class. Lists of names must
        be lists of different words, and `methods` must not be empty.
        """
        known = {**_DEFAULT, "format": "npz", "fixed": (), "can": {"extract": {}}, **_clean(given)}
        choices = {
            "units": ("si", "scaled"),
            "y": ("up", "down"),
            "direction": ("to", "from"),
            "axes": ("xyt", "xty", "yxt", "ytx", "txy", "tyx"),
            "format": ("npz", "mat", "raw"),
        }
        for name, allowed in choices.items():
            if known[name] not in allowed:
                raise Unanswered(
                    Verdict.ERROR, f"declares {name} = {known[name]!r}, should be one of {', '.join(allowed)}"
                )
        can = known["can"]
        if not isinstance(can, Mapping) or not can or not set(can) <= set(STAGES):
            raise Unanswered(
                Verdict.ERROR, f"declares can = {can!r}, should be an object with some of {', '.join(STAGES)}"
            )
        if not all(isinstance(what, Mapping) for what in can.values()):
            raise Unanswered(Verdict.ERROR, f"declares can = {can!r}, should hold an object for each stage")
        for stage, what in can.items():
            for name in sorted({"methods", "windows", "names"} & set(what)):
                if not _names(what[name]) or (name == "methods" and not what[name]):
                    raise Unanswered(
                        Verdict.ERROR,
                        f"declares {name} = {what[name]!r} of {stage}, should be a list of names, each once",
                    )
        if (resolves := can.get("extract", {}).get("resolves", "band")) not in ("wavenumber", "band"):
            raise Unanswered(Verdict.ERROR, f"declares resolves = {resolves!r}, should be wavenumber or band")
        if (amplitudes := can.get("sea", {}).get("amplitudes")) not in (None, "fixed", "random"):
            raise Unanswered(Verdict.ERROR, f"declares amplitudes = {amplitudes!r}, should be fixed or random")
        fixed = known["fixed"]
        if not _names(fixed):
            raise Unanswered(
                Verdict.ERROR, f"declares fixed = {fixed!r}, should be a list of parameter names, each once"
            )
        words: dict[str, Any] = {name: str(known[name]) for name in (*_DEFAULT, "format")}
        rest: dict[str, Any] = {
            "cube": _cube(known.get("cube", {})),
            "water": _water(known.get("water", {}), known["units"]),
        }
        rest |= {"waves": _waves(known.get("waves", {}), words["units"]), "can": dict(can), "fixed": tuple(fixed)}
        return cls(**words, **rest)

    @property
    def methods(self) -> tuple[str, ...]:
        """Methods it names; the first is its main one. None where it says nothing (see `Subject.methods`)."""
        return tuple(self.can.get("extract", {}).get("methods", ()))

    @property
    def windows(self) -> tuple[str, ...]:
        """Windows under which it can extract. One that tapers nothing is run raw, and tapered beforehand. Where nothing
        is declared they are `box` and `hann`.
        """
        offered = self.can.get("extract", {}).get("windows", ("box", "hann"))
        return tuple(offered) or ("box", "hann")

    @property
    def tapers(self) -> bool:
        """Whether it applies the window itself.

        False where it declares an empty list of windows: then `frames.Subject` multiplies the cube by the taper itself.
        """
        return bool(self.can.get("extract", {}).get("windows", ("box", "hann")))

    @property
    def band(self) -> bool:
        """Whether it returns one velocity for the whole band of wavenumbers.

        It does if it declares `resolves` as `band`. Such a code is asked as the others are, and its one answer is held
        against every wavenumber of the band.
        """
        return bool(self.can.get("extract", {}).get("resolves", "wavenumber") == "band")

    @property
    def untold(self) -> frozenset[str]:
        """The parameters that it cannot be told, by the first words of `fixed`: "gravity (9.81)" is gravity."""
        return frozenset(said.split()[0] for said in self.fixed if said.split())

    @property
    def smallest(self) -> tuple[int, int, int]:
        """Samples along x, y and t of the smallest cube that it takes."""
        nx, ny, nt = self.cube.get("smallest", (1, 1, 1))
        return nx, ny, nt

    @property
    def told(self) -> tuple[str, ...]:
        """What of the water is handed over to it: some of `WATER`."""
        return tuple(name for name in WATER if self.water.get(name) == GIVEN)

    def scales(self, scale: float = 1.0, gravity: float = 1.0) -> Scales:
        """Its units of a sea whose peak is shown at `scale` times the usual one, under `gravity` times the usual one.

        A code in SI is shown the sea at 9.81 m/s2 with its peak at `PEAK`, in the middle of the `waves` that it is made
        for if those are others; one in scaled units with gravity 1 and its peak at 1. One that knows one depth only in
        which these would be long is shown shorter ones.
        """
        usual, unit = (PEAK, GRAVITY) if self.units == "si" else (1.0, 1.0)
        longest, shortest = self.peaks
        peak = usual if longest <= usual <= shortest else float(np.sqrt(longest * shortest))
        depth = self.water.get("depth", GIVEN)
        peak = max(peak, 0.0 if depth == GIVEN else min(_SHALLOWEST / depth, shortest))
        return Scales(scale * peak, gravity * unit)

    @property
    def peaks(self) -> tuple[float, float]:
        """The peak wavenumbers of the longest and of the shortest waves that it is made for, rad/m; 0 and infinite
        where it says nothing.
        """
        if "peak_wavelength" not in self.waves:
            return 0.0, np.inf
        shortest, longest = self.waves["peak_wavelength"]
        return 2 * np.pi / longest, 2 * np.pi / shortest

    def scale(self, nominal: float) -> float:
        """At which scale it is shown what others are shown at a `nominal` one, 1/16 to 16: within its `waves`, whose
        ends stand for these.
        """
        if "peak_wavelength" not in self.waves or nominal == 1:
            return nominal
        usual = self.scales().peak_wavenumber
        end = self.peaks[int(nominal > 1)] / usual
        return float(end ** (abs(np.log(nominal)) / np.log(_ENDS)))

    def shows(self, scale: float) -> bool:
        """Whether the waves at a scale are among those that it is made for."""
        longest, shortest = self.peaks
        return longest * (1 - 1e-9) <= self.scales(scale).peak_wavenumber <= shortest * (1 + 1e-9)

    def fastest(self, scale: float = 1.0) -> float:
        """The strongest current that it is made for, in c0 of the peak at a scale; infinite where it does not say."""
        return float(self.waves.get("fastest", np.inf) / self.scales(scale).velocity)

    def takes(self, shape: tuple[int, ...]) -> str:
        """What speaks against a cube of that shape, in words; empty if nothing does."""
        if any(n < least for n, least in zip(shape, self.smallest, strict=True)):
            return f"takes no cube below {self.smallest} samples along x, y, t"
        if any(n % self.multiple for n in shape):
            return f"takes multiples of {self.multiple} samples along each axis only"
        if self.shape is not None and shape != self.shape:
            return f"takes cubes of {self.shape} samples along x, y, t only"
        return ""

    @property
    def least_duration(self) -> float:
        """Of a record that it takes, in its own unit of time; 0 if it takes any."""
        return float(self.cube.get("duration", 0.0))

    @property
    def multiple(self) -> int:
        """Of which the numbers of samples must be multiples."""
        return int(self.cube.get("multiple", 1))

    @property
    def shape(self) -> tuple[int, int, int] | None:
        """The only one that it takes; None if it takes others."""
        if "shape" not in self.cube:
            return None
        nx, ny, nt = self.cube["shape"]
        return nx, ny, nt

    def still(self, scale: float = 1.0) -> Water:
        """The water that it is asked in, in scaled units: deep, or that which stands in the code."""
        fixed = {name: value for name, value in self.water.items() if value != GIVEN}
        units = self.scales(scale)
        return Water(units.gravity, fixed.get("depth", np.inf), fixed.get("surface_tension", 0.0)).to_scaled(units)

    def record(self) -> dict[str, Any]:
        """For the certificate.

        Plain types only, as they are written to JSON and to the page; `format` is left out, since no reader needs it.
        """
        return {
            "name": self.name,
            "version": self.version,
            "units": self.units,
            "axes": self.axes,
            "y": self.y,
            "direction": self.direction,
            "fixed": list(self.fixed),
            "cube": {
                name: list(value) if name in ("smallest", "shape") else value for name, value in self.cube.items()
            },
            "waves": dict(self.waves),
            "water": dict(self.water),
            "can": {stage: dict(what) for stage, what in self.can.items()},
        }


def _names(given: Any) -> bool:
    """Whether it is a list of different names, maybe an empty one."""
    return (
        isinstance(given, list | tuple)
        and all(isinstance(name, str) and name for name in given)
        and len(set(given)) == len(given)
    )


def _cube(cube: Any) -> dict[str, Any]:
    """What it says of the cubes that it takes. Raises Unanswered (error)."""
    found: dict[str, Any] = {}
    good = isinstance(cube, Mapping)
    for name in ("smallest", "shape") if good else ():
        if cube.get(name) is not None:
            good = good and _sizes(cube[name])
            found[name] = tuple(cube[name]) if good else ()
    if good and cube.get("multiple") is not None:
        good = _sizes([cube["multiple"]] * 3)
        found["multiple"] = cube["multiple"]
    if good and cube.get("duration") is not None:
        good = _above_zero(cube["duration"])
        found["duration"] = cube["duration"]
    if not good:
        raise Unanswered(
            Verdict.ERROR,
            f"declares cube = {cube!r}, should be an object with smallest = [nx, ny, nt] or shape = [nx, ny, nt], "
            "three whole numbers above 0, or multiple = n, and duration, a time above 0",
        )
    return found


def _sizes(given: Any) -> bool:
    """Whether it is three whole numbers above zero."""
    return (
        isinstance(given, list | tuple)
        and len(given) == 3
        and all(isinstance(n, int) and not isinstance(n, bool) and n >= 1 for n in given)
    )


def _waves(waves: Any, units: str) -> dict[str, Any]:
    """What it says of the waves that it is made for. Raises Unanswered (error)."""
    good, found = isinstance(waves, Mapping), {}
    if good and (pair := waves.get("peak_wavelength")) is not None:
        good = isinstance(pair, list | tuple) and len(pair) == 2 and all(map(_above_zero, pair)) and pair[0] < pair[1]
        found["peak_wavelength"] = [float(one) for one in pair] if good else []
    if good and (fastest := waves.get("fastest")) is not None:
        good = _above_zero(fastest)
        found["fastest"] = fastest
    if not good or (found and units != "si"):
        raise Unanswered(
            Verdict.ERROR,
            f"declares waves = {waves!r}, should be an object with peak_wavelength = [shortest, longest] in m and "
            "fastest in m/s, for a code in SI",
        )
    return found


def _water(water: Any, units: str) -> dict[str, Any]:
    """What it says of the water. Raises Unanswered (error)."""
    told = {name: water[name] for name in WATER if water.get(name) is not None} if isinstance(water, Mapping) else None
    if told is None or not all(value == GIVEN or _above_zero(value) for value in told.values()):
        raise Unanswered(
            Verdict.ERROR,
            f"declares water = {water!r}, should be an object with depth or surface_tension, each {GIVEN!r} if it is "
            "handed over, or the number that stands in the code, above zero; for deep water leave depth out",
        )
    limits = _OF_WATER[units]
    for name, value in told.items():
        if value != GIVEN and not limits[name][0] <= value <= limits[name][1]:
            raise Unanswered(
                Verdict.ERROR,
                f"declares {name} = {value:g}, which no water has: from {limits[name][0]:g} to {limits[name][1]:g} "
                + ("m" if name == "depth" else "m3/s2, that in N/m over the density") * (units == "si"),
            )
    return {name: value if value == GIVEN else float(value) for name, value in told.items()}


def _above_zero(value: Any) -> bool:
    """Whether it is a finite number above zero."""
    return not isinstance(value, bool) and isinstance(value, int | float) and 0 < value < np.inf


def _clean(value: Any) -> Any:
    """What was declared, with words that can be printed anywhere, and no longer than somebody reads."""
    if isinstance(value, Mapping):
        return {printable(name, _LONGEST): _clean(item) for name, item in value.items()}
    if isinstance(value, list | tuple):
        return [_clean(item) for item in value]
    return value if value is None or isinstance(value, bool | int | float) else printable(value, _LONGEST)
