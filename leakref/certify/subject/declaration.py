"""What an implementation says of itself: units, axes, directions, what it can do and what it cannot be told.

It is read once, at the start, from what the program says or from `describe()` of a Python object, and printed on the
certificate. Everything that a check asks is put into these terms by `frames.Subject`. What is declared wrongly is
refused here with the name of the field, before any check is run.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from leakref.certify.verdict import Unanswered, Verdict, printable

__all__ = ["STAGES", "Declaration"]

STAGES = ("window", "synthesize", "spectrum", "extract")
"""In the order of the chain."""
_LONGEST = 120  # characters of a word
_DEFAULT = {"name": "unnamed", "version": "", "units": "scaled", "axes": "xyt", "y": "up", "direction": "to"}


@dataclass(frozen=True)
class Declaration:
    """The declaration of guide protocol, section 3, checked and completed.

    `fixed` are parameters that it cannot be told: `wavenumbers` if it has its own, `dy` if it knows square pixels only,
    `gravity` if it has one. `cube` may hold `smallest`, the samples along x, y and t below which it takes none.

    - `name`, `version`: words for the certificate, at most 120 characters each.
    - `units`: `si` (m, s) or `scaled` (lengths in `1 / k0`, times in `1 / omega0`, gravity 1).
    - `axes`: the order of the axes of a cube, a permutation of `xyt`; `y`: `up` or `down`, which way rows count.
    - `direction`: `to` where a current is given by where it goes, `from` where by where it comes from.
    - `format`: of the arrays exchanged with a program, `npz`, `mat` or `raw`.
    - `can`: for each stage offered what of it: `methods`, `windows` and `resolves` of `extract`, `windows` of
      `spectrum`, `names` of `window`. What is left out has a default.
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
        fixed = known["fixed"]
        if not _names(fixed):
            raise Unanswered(
                Verdict.ERROR, f"declares fixed = {fixed!r}, should be a list of parameter names, each once"
            )
        words = {name: str(known[name]) for name in (*_DEFAULT, "format")}
        return cls(**words, fixed=tuple(fixed), cube=_cube(known.get("cube", {})), can=dict(can))

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
            "cube": {name: list(value) for name, value in self.cube.items()},
            "can": {stage: dict(what) for stage, what in self.can.items()},
        }


def _names(given: Any) -> bool:
    """Whether it is a list of different names, maybe an empty one."""
    return (
        isinstance(given, list | tuple)
        and all(isinstance(name, str) and name for name in given)
        and len(set(given)) == len(given)
    )


def _cube(cube: Any) -> dict[str, tuple[int, int, int]]:
    """What it says of the cubes that it takes. Raises Unanswered (error)."""
    if isinstance(cube, Mapping) and "smallest" not in cube:
        return {}
    given: Any = cube["smallest"] if isinstance(cube, Mapping) else None
    good = isinstance(given, list | tuple) and len(given) == 3
    if not good or any(isinstance(n, bool) or not isinstance(n, int) or n < 1 for n in given):
        raise Unanswered(
            Verdict.ERROR,
            f"declares cube = {cube!r}, should be an object with smallest = [nx, ny, nt], three whole numbers above 0",
        )
    return {"smallest": tuple(given)}


def _clean(value: Any) -> Any:
    """What was declared, with words that can be printed anywhere, and no longer than somebody reads."""
    if isinstance(value, Mapping):
        return {printable(name, _LONGEST): _clean(item) for name, item in value.items()}
    if isinstance(value, list | tuple):
        return [_clean(item) for item in value]
    return value if value is None or isinstance(value, bool | int | float) else printable(value, _LONGEST)
