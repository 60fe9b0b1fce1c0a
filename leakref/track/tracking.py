"""What is kept of a version: the error of every realisation of some seas, and what it was measured with.

The *error* is |c - U|, the length of the difference between the velocity measured and the true current; in still water
that is the |c| whose mean the paper calls bias. Realisations have common phases, so those of two versions are compared
in pairs. The reference goes the fast way; any other target is shown the cubes, as in certification.
"""

from __future__ import annotations

import platform
import sys
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass
from datetime import UTC, datetime
from functools import cached_property, partial
from hashlib import sha256
from importlib import machinery, util
from pathlib import Path
from shutil import which
from typing import Any

import numpy as np
import scipy

from leakref import __version__, fast, runs, sources
from leakref._base import FloatArray, LeakrefError, Trouble, deviation_of_known, mean_of_known, refusal
from leakref._output import plain
from leakref.cases import Configuration, configurations
from leakref.certify.checks.inputs import Cube
from leakref.certify.measures.bias import SEAS
from leakref.certify.subject.frames import ASKED, GRAVITY, PEAK, Subject
from leakref.certify.verdict import Unanswered, printable
from leakref.currents import UniformCurrent
from leakref.decisions import DECISIONS
from leakref.golden.digests import digest
from leakref.methods import DEFAULT

__all__ = [
    "COARSE",
    "PAPER",
    "UNIT",
    "Scene",
    "Series",
    "fields",
    "measure",
    "measure_reference",
    "scene",
    "source_of",
    "source_of_program",
    "source_of_reference",
]

UNIT = 1e-6
"""In c0: errors are kept as whole multiples of this. Rounding by it moves a mean over 100 by 3e-8 c0."""
PAPER = ("nsp-ls", "U/rotation=0,current=0.15,current_direction=90")
"""The cases recorded of the reference, unless others are named."""
COARSE = ("broad", "following")
"""The same for any other target: about the same two seas in a cube of 1.4 MB instead of 176."""
_WINDOWS = ("box", "hann")
_REFERENCE = "the reference chain, NumPy, SciPy and Numba"
_DIGITS = 7  # decimals of the waves that count in the digest of a case: no library's last bit is among them

Progress = Callable[[], object]


@dataclass(frozen=True)
class Scene:
    """A sea to be measured in: a case of the paper, or one of the coarser seas of certification, by its `id`.

    `windows` are those under which it is measured, as far as the target offers them.
    """

    id: str
    windows: tuple[str, ...]
    cube: Callable[[int], Cube]
    """One realisation, counted from 0."""

    @cached_property
    def digest(self) -> str:
        """SHA-256 of what is shown: grid, wavenumbers, truth, and the waves of realisations 0 and 1. Waves count to
        seven decimals, so that the last bits of a library do not make another case.
        """
        first, second = self.cube(0), self.cube(1)
        waves = [
            [
                np.rint(getattr(cube.components, name) * 10.0**_DIGITS).astype("<i8").tobytes()
                for name in ("kx", "ky", "omega", "amplitude", "phase")
            ]
            for cube in (first, second)
        ]
        numbers = {"spacing": np.array(first.spacing), "wavenumbers": first.wavenumbers, "truth": first.truth}
        return digest(
            {
                "shape": list(first.grid.shape),
                "waves": [sha256(b"".join(own)).hexdigest() for own in waves],
                "shown_at": [PEAK, GRAVITY],
                **{name: (value.round(_DIGITS) + 0.0).tolist() for name, value in numbers.items()},
            }
        )


@dataclass(frozen=True, eq=False)
class Series:
    """Errors (R, n) in c0 of realisations `first`, `first` + 1, ... at n `wavenumbers`; NaN where there is no answer.

    `resolution` (n,) is the smaller of the two of eq:dcdwk; `digest` that of the `case`.
    """

    case: str
    digest: str
    window: str
    method: str
    wavenumbers: FloatArray
    resolution: FloatArray
    first: int
    errors: FloatArray

    @property
    def key(self) -> tuple[str, str, str]:
        """Case, window, method."""
        return self.case, self.window, self.method

    @property
    def count(self) -> FloatArray:
        """Realisations with an answer, (n,)."""
        return np.isfinite(self.errors).sum(axis=0)

    @property
    def bias(self) -> FloatArray:
        """Mean error, (n,); NaN without an answer."""
        return mean_of_known(self.errors)

    @property
    def random(self) -> FloatArray:
        """Standard deviation of the error, (n,), with n - 1 (decision D12); NaN below two answers."""
        return deviation_of_known(self.errors)

    def record(self) -> dict[str, Any]:
        """As in a history: `errors` as rows of whole multiples of `unit`, null where there is no answer."""
        rows = [[None if e != e else round(e / UNIT) for e in row] for row in self.errors.tolist()]
        return {
            "case": self.case,
            "case_sha256": self.digest,
            "window": self.window,
            "method": self.method,
            "wavenumbers": _rounded(self.wavenumbers),
            "resolution": _rounded(self.resolution),
            "bias": _rounded(self.bias),
            "random": _rounded(self.random),
            "count": self.count.tolist(),
            "first": self.first,
            "unit": UNIT,
            "errors": rows,
        }

    @classmethod
    def read(cls, kept: Mapping[str, Any]) -> Series:
        """From a history. Raises Trouble if it is not what `record` gives."""
        try:
            errors = np.array(kept["errors"], dtype=np.float64).reshape(len(kept["errors"]), -1) * kept["unit"]
            return cls(
                kept["case"],
                kept["case_sha256"],
                kept["window"],
                kept["method"],
                np.array(kept["wavenumbers"]),
                np.array(kept["resolution"]),
                kept["first"],
                errors,
            )
        except (KeyError, TypeError, ValueError, AttributeError) as error:
            raise Trouble(
                "track",
                f"an entry of the history is not whole ({type(error).__name__}: {error})",
                "put its line back from version control",
            ) from None


def _rounded(values: FloatArray) -> list[float | None]:
    """Decimals enough for any reader: the errors themselves are kept beside."""
    return [None if v != v else round(v, 8) for v in values.tolist()]


def scene(name: str) -> Scene:
    """The scene called `name`: a configuration of the paper, or a sea of `measures.bias.SEAS`. LeakrefError if none.

    A case of several configurations is refused: each is a scene.
    """
    if name in SEAS:
        return Scene(name, _WINDOWS, SEAS[name].cube)
    found = configurations([name])
    if len(found) > 1:
        raise LeakrefError(
            "track",
            f"case {name!r} has {len(found)} configurations",
            f"name one, such as {found[0].id}, or a coarser sea: {', '.join(SEAS)}",
        )
    return Scene(found[0].id, found[0].windows, partial(_cube, found[0]))


def _cube(configuration: Configuration, realization: int) -> Cube:
    x, y = configuration.current
    return Cube(
        configuration.components(realization),
        configuration.grid,
        configuration.wavenumbers,
        UniformCurrent((float(x), float(y))),
    )


# ------------------------------------------------------------ measuring


def _by_reference(name: str, methods: Sequence[str], realization: int) -> FloatArray:
    """Errors (w, m, n) of the reference under the scene's windows."""
    shown = scene(name)
    cube = shown.cube(realization)
    with runs.one_thread():
        found = fast.realize(
            cube.components, cube.grid, cube.wavenumbers, windows=shown.windows, methods=methods, gravity=1.0
        )
    return np.array([[np.hypot(*(found[w, m].velocities - cube.truth).T) for m in methods] for w in shown.windows])


def measure_reference(
    scenes: Sequence[Scene],
    realizations: range,
    *,
    methods: Sequence[str] = DEFAULT,
    executor: Executor | None = None,
    after_each: Progress = lambda: None,
) -> list[Series]:
    """The reference by its fast path; realisations are tasks for `executor` (default: this process)."""
    series = []
    for one in scenes:
        work = partial(_by_reference, one.id, methods)
        parts = []
        for part in executor.map(work, realizations) if executor else map(work, realizations):
            parts.append(part)
            after_each()
        errors = np.array(parts)
        series += [
            _series(one, window, method, realizations.start, errors[:, w, m])
            for w, window in enumerate(one.windows)
            for m, method in enumerate(methods)
        ]
    return series


def measure(
    subject: Subject, scenes: Sequence[Scene], realizations: range, *, after_each: Progress = lambda: None
) -> tuple[list[Series], list[str]]:
    """Any implementation, under the windows and methods it offers: its series, and what it gave no answer for and why.

    Windows are those of the scene that it offers, or all its own if there is none among them. A realisation without an
    answer is a row of NaN; a series without any is left out. Errors are in `c0`, whatever the units of the target.
    """
    offered = subject.declaration
    series, said = [], []
    for one in scenes:
        windows = [name for name in one.windows if name in offered.windows] or list(offered.windows)
        errors = {
            (w, m): np.full((len(realizations), one.cube(0).wavenumbers.size), np.nan)
            for w in windows
            for m in offered.methods or (ASKED,)
        }
        silent: dict[tuple[str, str], list[str]] = {}
        for row, number in enumerate(realizations):
            cube = one.cube(number)
            for (window, method), kept in errors.items():
                try:
                    kept[row] = _error(subject, cube, window, method if offered.methods else None)
                except Unanswered as nothing:
                    silent.setdefault((window, method), []).append(nothing.message)
            after_each()
        subject.calls.clear()  # kept for diagnoses, of which there are none here
        said += [
            f"{one.id}, {window}, {method}: no answer in {len(why)} of {len(realizations)} realisations; the "
            f"first time: {printable(why[0])}"
            for (window, method), why in silent.items()
        ]
        series += [
            _series(one, window, method, realizations.start, kept)
            for (window, method), kept in errors.items()
            if np.isfinite(kept).any()
        ]
    return series, said


def _error(subject: Subject, cube: Cube, window: str, method: str | None) -> FloatArray:
    answer = subject.extract(cube.surface, cube.spacing, cube.wavenumbers, window=window, method=method)
    return np.hypot(*(answer.values - cube.truth).T)


def _series(one: Scene, window: str, method: str, first: int, errors: FloatArray) -> Series:
    cube = one.cube(0)
    return Series(one.id, one.digest, window, method, cube.wavenumbers, cube.resolutions[0], first, errors)


# ------------------------------------------------------------ what it was measured with


def fields(
    label: str,
    target: str,
    said: Mapping[str, Any],
    source: Mapping[str, Any],
    series: Sequence[Series],
    timings: Mapping[str, Any] | None = None,
) -> dict[str, Any]:
    """The fields of an entry (`history.append` adds digests). `said` is the target's name and version."""
    system = {
        "platform": f"{platform.system()} {platform.machine()}",
        "python": platform.python_version(),
        "numpy": np.__version__,
        "scipy": scipy.__version__,
        "leakref": __version__,
    }
    made: dict[str, Any] = plain(
        {
            "label": label,
            "target": target,
            "name": said["name"],
            "version": said["version"],
            "recorded": datetime.now(UTC).isoformat(timespec="seconds"),
            **system,
            "source": dict(source),
            "decisions": {one.id: one.reference for one in DECISIONS.values()},
            "measurements": [one.record() for one in series],
            "timings": timings,
        }
    )
    return made


def source_of_reference() -> dict[str, Any]:
    """`runs.source_digest`: all modules between a sea and its velocities, and the versions of the libraries."""
    return {"sha256": runs.source_digest(), "of": _REFERENCE}


def source_of(target: str, more: Sequence[Path] = ()) -> dict[str, Any]:
    """Of a Python target: every source and extension module of its top-level package, and the files in `more`.

    Nothing is imported. A fault or a variant is the reference with the module it is from.
    """
    kind = target.partition(":")[0]
    if kind in ("reference", "fault", "variant"):
        own = _hashed(more)
        lists = "" if kind == "reference" else sources.digest(f"leakref.certify.strength.{kind}s")
        return {
            "sha256": digest([runs.source_digest(), lists, target, own["sha256"]]),
            "of": f"{_REFERENCE}, {f'{kind}s, ' * bool(lists)}{own['of']}".removesuffix(", nothing"),
        }
    if str(Path.cwd()) not in sys.path:
        sys.path.insert(0, str(Path.cwd()))
    found = util.find_spec(kind.split(".")[0])
    places = list(found.submodule_search_locations or []) if found else []
    if found and found.origin and not places:
        places = [found.origin]
    endings = tuple(machinery.all_suffixes())
    modules = [path for place in places for path in _files(Path(place)) if path.name.endswith(endings)]
    return _hashed([*modules, *more])


def source_of_program(command: Sequence[str], more: Sequence[Path] = ()) -> dict[str, Any]:
    """Of a program: its own file, every argument that is a file, and the files in `more`."""
    program = which(command[0])
    named = [Path(word) for word in command[1:] if Path(word).is_file()]
    return _hashed([*([Path(program)] if program else []), *named, *more])


def _files(place: Path) -> list[Path]:
    """A file, or all in a folder but for what is hidden or made by Python."""
    if not place.is_dir():
        return [place]
    return sorted(
        path
        for path in place.rglob("*")
        if path.is_file()
        and not any(part.startswith(".") or part == "__pycache__" for part in path.relative_to(place).parts)
    )


def _hashed(places: Sequence[Path]) -> dict[str, Any]:
    """SHA-256 of the contents of files and folders, by name, not by where they are."""
    kept = []
    for place in places:
        for path in _files(place):
            try:
                kept.append((path.name, sha256(path.read_bytes()).hexdigest()))
            except OSError as error:
                raise refusal(
                    "track",
                    f"{path} cannot be read ({error.strerror})",
                    "give files or folders of the source with --source",
                    error,
                ) from None
    names = ", ".join(name for name, _ in kept[:6]) + f" and {len(kept) - 6} more" * (len(kept) > 6)
    return {"sha256": digest(sorted(kept)), "of": names or "nothing"}
