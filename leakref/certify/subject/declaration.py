"""What an implementation says of itself: units, axes, directions, what it can do and what it cannot be told."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from leakref.certify.verdict import Unanswered, Verdict, printable

__all__ = ["STAGES", "Declaration"]

STAGES = ("window", "synthesize", "spectrum", "extract")
_LONGEST = 120  # characters of a word
_DEFAULT = {"name": "unnamed", "version": "", "units": "scaled", "axes": "xyt", "y": "up", "direction": "to"}


@dataclass(frozen=True)
class Declaration:
    """The declaration of guide protocol, section 3, checked and completed.

    `fixed` are parameters that it cannot be told: `wavenumbers` if it has its own, `dy` if it knows square pixels only.
    """

    name: str = "unnamed"
    version: str = ""
    units: str = "scaled"
    axes: str = "xyt"
    y: str = "up"
    direction: str = "to"
    format: str = "npz"
    fixed: tuple[str, ...] = ()
    can: Mapping[str, Mapping[str, Any]] = field(default_factory=lambda: {"extract": {}})

    @classmethod
    def read(cls, given: Mapping[str, Any]) -> Declaration:
        """From an object somebody wrote, whose words are cleaned here and nowhere else.

        Raises Unanswered (error) that names the field that is wrong.
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
        return cls(**{name: str(known[name]) for name in (*_DEFAULT, "format")}, fixed=tuple(fixed), can=dict(can))

    @property
    def methods(self) -> tuple[str, ...]:
        """Extractions offered; the first is its main one."""
        return tuple(self.can.get("extract", {}).get("methods", ("nsp",)))

    @property
    def windows(self) -> tuple[str, ...]:
        """Windows under which it can extract. One that tapers nothing is run raw, and tapered beforehand."""
        offered = self.can.get("extract", {}).get("windows", ("box", "hann"))
        return tuple(offered) or ("box", "hann")

    @property
    def tapers(self) -> bool:
        """Whether it applies the window itself."""
        return bool(self.can.get("extract", {}).get("windows", ("box", "hann")))

    @property
    def band(self) -> bool:
        """Whether it returns one velocity for the whole band of wavenumbers."""
        return bool(self.can.get("extract", {}).get("resolves", "wavenumber") == "band")

    def record(self) -> dict[str, Any]:
        """For the certificate."""
        return {
            "name": self.name,
            "version": self.version,
            "units": self.units,
            "axes": self.axes,
            "y": self.y,
            "direction": self.direction,
            "fixed": list(self.fixed),
            "can": {stage: dict(what) for stage, what in self.can.items()},
        }


def _names(given: Any) -> bool:
    """Whether it is a list of different names, maybe an empty one."""
    return (
        isinstance(given, list | tuple)
        and all(isinstance(name, str) and name for name in given)
        and len(set(given)) == len(given)
    )


def _clean(value: Any) -> Any:
    """What was declared, with words that can be printed anywhere, and no longer than somebody reads."""
    if isinstance(value, Mapping):
        return {printable(name, _LONGEST): _clean(item) for name, item in value.items()}
    if isinstance(value, list | tuple):
        return [_clean(item) for item in value]
    return value if value is None or isinstance(value, bool | int | float) else printable(value, _LONGEST)
