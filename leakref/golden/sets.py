"""Golden values: where they are, whether they are as they were made, and how far from them a number may be.

A set is a folder `v1`, `v2`, ... of JSON files with a manifest; `golden/README.md` describes it for readers in any
language. An entry has an id, which is never reused, inputs, outputs, and for each output how many digits several routes
agreed on.

A set may extend another one: its folder then holds only what is new, its manifest names the other and the digest of
that one's manifest, and reading it gives the entries of both.

**Tolerance.** One formula, `tolerance`: a margin of 8 times the rounding of float64, 2^-52, times the conditioning that
the entry states: by how much, to first order and in the output's own unit, an output moves if every rounding on the way
is one unit of 2^-52. It is computed when an entry is made (`leakref.golden.entries`), never chosen. Whole numbers and
phases have conditioning 0: they are compared for equality.

NaN equals nothing. Where there is no number the golden value is null and gives its reason.

An entry in its file looks like this, with lists where there are arrays:

    {"id": "dispersion-scaled", "stage": "dispersion", "purpose": "...", "equation": "sec:theory", "decisions": [],
     "supersedes": null, "input": {"wavenumber": [...], "gravity": 1.0}, "output": {"frequency": [...], ...},
     "origin": {"values": "mpmath", "confirmed_by": ["chain"]},
     "accuracy": {"frequency": {"digits": ..., "conditioning": ..., "tolerance": ...}, ...}}
"""

from __future__ import annotations

import hashlib
import io
import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from importlib import resources
from importlib.resources.abc import Traversable
from typing import Any

import numpy as np

from leakref._base import Damaged, FloatArray, LeakrefError
from leakref.golden.digests import PUT_BACK, canonical, sealed, strict

__all__ = [
    "EPSILON",
    "MARGIN",
    "NEWEST",
    "SCHEMA_VERSION",
    "SETS",
    "Entry",
    "Failure",
    "Golden",
    "Report",
    "agreed_digits",
    "archived",
    "compare",
    "entry_digest",
    "locate",
    "tolerance",
]

EPSILON = 2.0**-52
"""The spacing of float64 at 1."""
MARGIN = 8.0
"""Between one rounding of every operation, as the conditioning counts it, and what is let pass."""
NEWEST = 2
"""The number of the set that is used where none is asked for."""
SCHEMA_VERSION = 1
"""Of entries and manifests; another one is another format."""
SETS = ("vectors", "analytic", "realizations", "ensembles")
"""The folders of a set, from quick to slow."""


def tolerance(conditioning: float) -> float:
    """How far from a golden value is still the same: MARGIN x EPSILON x conditioning, in the output's unit.

    With a conditioning of 1 it is 1.8e-15, eight units in the last place of numbers near 1. It is infinite or NaN where
    the conditioning is.
    """
    return MARGIN * EPSILON * conditioning


def agreed_digits(difference: float, scale: float) -> float:
    """Decimal digits to which numbers of size `scale` that differ by `difference` agree, at most those of float64.
    Rounded down to a tenth; `scale` is above zero.
    """
    most = -math.log10(EPSILON)
    agreed = most if difference <= EPSILON * scale else min(most, -math.log10(difference / scale))
    return math.floor(10 * agreed) / 10


@dataclass(frozen=True)
class Failure:
    """`id` of the entry (or the file) that fell short, the `stage` if known, and `message` saying how.

    Printed as `id: message`. The message says what was found and what it should be.
    """

    id: str
    message: str
    stage: str = ""

    def __str__(self) -> str:
        return f"{self.id}: {self.message}"


@dataclass(frozen=True)
class Report:
    """What was looked at: a row for each part of the set, how many golden numbers, what fell short.

    - `sets`: a row for each part, a mapping from column to value; `values`: golden numbers looked at.
    - `failures`: empty if nothing fell short.
    """

    sets: list[dict[str, Any]]
    values: int
    failures: list[Failure] = field(default_factory=list)

    @property
    def ok(self) -> bool:
        """Something was looked at and nothing fell short."""
        return self.values > 0 and not self.failures


@dataclass(frozen=True)
class Entry:
    """One golden record and the file (relative to its set's folder) it is from.

    - `file`: such as `vectors/nsp.json`; `record`: the object in that file, as it is.
    - `arrays`: large inputs, which are kept beside the file and not in the JSON: of an npz by `id.name`, others by the
      name of the file of raw float64 that holds one.
    - `folder`: the name of the set's folder, such as `v1`.
    """

    file: str
    record: Mapping[str, Any]
    arrays: Mapping[str, FloatArray] = field(default_factory=dict)
    folder: str = ""

    @property
    def id(self) -> str:
        """For ever its own."""
        return str(self.record["id"])

    @property
    def stage(self) -> str:
        """What of the chain it is about; a key of `golden.stages.STAGES`, or realization or ensemble."""
        return str(self.record["stage"])

    @cached_property
    def input(self) -> dict[str, Any]:
        """The inputs; arrays kept beside the file are read in. Numbers and lists stay as JSON has them."""
        return {name: self._array(value) for name, value in self.record["input"].items()}

    @cached_property
    def output(self) -> dict[str, FloatArray]:
        """The golden values as float64, NaN where they are null."""
        return {name: np.array(self._array(value), dtype=np.float64) for name, value in self.record["output"].items()}

    def tolerance(self, name: str) -> FloatArray:
        """Of output `name`: one number, or one for each item of its first axis; NaN where it is null.

        Its shape can be broadcast against the output: (), or (n, 1, ...) for an output whose first axis has n items.
        """
        given = np.asarray(self.record["accuracy"][name]["tolerance"], dtype=np.float64)
        return given.reshape(given.shape + (1,) * (self.output[name].ndim - given.ndim if given.ndim else 0))

    def _array(self, value: Any) -> Any:
        name = archived(value)
        return value if name is None else self.arrays[name]

    @property
    def values(self) -> int:
        """How many golden numbers it has."""
        return int(sum(np.isfinite(v).sum() for v in self.output.values()))


def archived(value: Any) -> str | None:
    """Under which name of `Entry.arrays` an input is found, if it is kept beside the file; None if it is not."""
    if isinstance(value, dict) and set(value) in ({"npz", "array"}, {"f64", "shape"}):
        return str(value.get("array") or value["f64"])
    return None


def locate(number: int = NEWEST) -> Traversable:
    """The folder of golden set `number`, as installed. Raises LeakrefError if there is none.

    `number` counts from 1: `v1`, `v2`, ...; the default is the newest.
    """
    folder = resources.files("leakref._golden").joinpath(f"v{number}")
    if not folder.joinpath("manifest.json").is_file():
        raise LeakrefError("golden.locate", f"there is no golden set number {number}", "choose another with --golden")
    return folder


class Golden:
    """A set of golden values in `folder`, with all of the set that it extends.

    Files are read when asked for, and compared with the digests of the manifest before anything in them is used;
    `Damaged` if one cannot be read or was changed.

    `folder` is the newest set as installed unless given; a path or anything that `importlib.resources` gives. The set
    that it extends is looked for beside it.

    For instance, to hold a code of one's own to an entry:

        entry = Golden().entry("dispersion-scaled")
        found = {"frequency": ..., "phase_velocity": ..., "group_velocity": ...}  # from entry.input
        print(compare(entry, found) or "agrees")
    """

    def __init__(self, folder: Traversable | None = None) -> None:
        self.folder = locate() if folder is None else folder

    def _read(self, name: str) -> bytes:
        try:
            return self.folder.joinpath(*name.split("/")).read_bytes()
        except OSError as error:
            raise Damaged("golden", f"{name} cannot be read ({type(error).__name__})", PUT_BACK) from None

    def _json(self, name: str, content: bytes | None = None) -> Any:
        return strict(name, self._read(name) if content is None else content)

    @cached_property
    def manifest(self) -> dict[str, Any]:
        """What the set itself says it holds, without what it extends.

        Read once. `Damaged` is raised if it cannot be read, is not strict JSON, or is not sealed by its own digest.
        """
        said = self._json("manifest.json")
        if not isinstance(said, dict) or not isinstance(said.get("files"), dict) or not sealed(said):
            raise Damaged("golden", "manifest.json was changed: its own SHA-256 is not that of what it says", PUT_BACK)
        return said

    @cached_property
    def base(self) -> Golden | None:
        """The set that this one extends; None if it stands alone. `Damaged` if it is another than it was made for."""
        said = self.manifest.get("extends")
        if said is None:
            return None
        base = Golden(self.folder.parent / said["set"])  # type: ignore[attr-defined]  # a Path; resources do not say so
        if base.manifest["sha256"] != said["sha256"]:
            fault = f"{said['set']} is another than the one that {self.manifest['set']} extends"
            raise Damaged("golden", fault, PUT_BACK)
        return base

    @property
    def chain(self) -> tuple[Golden, ...]:
        """The sets that it is made of, the first of them first and itself last."""
        return (*(self.base.chain if self.base else ()), self)

    def _unchanged(self, name: str) -> bytes:
        """A file of the set that has the digest of the manifest."""
        content = self._read(name)
        if hashlib.sha256(content).hexdigest() != self.manifest["files"].get(name, {}).get("sha256"):
            raise Damaged("golden", f"{name} was changed: its SHA-256 is not the manifest's", PUT_BACK)
        return content

    def file(self, name: str) -> list[Entry]:
        """The entries of one JSON file, those of the set that is extended first, with the arrays that lie beside it.

        Raises `Damaged` if a file cannot be read or has another digest than the manifest's.
        """
        holding = [golden for golden in self.chain if name in golden.manifest["files"]] or [self]
        return [entry for golden in holding for entry in golden.as_it_is(name, golden._unchanged)]

    def as_it_is(self, name: str, read: Callable[[str], bytes] | None = None) -> list[Entry]:
        """What the set itself has of a file, whatever the manifest says: for finding out what was changed.

        `read` gives the bytes of a file by name; the default takes them as they are. `Damaged` is raised for what
        cannot be parsed.
        """
        read = read or self._read
        records = self._json(name, read(name))["entries"]
        beside = name.removesuffix(".json") + ".npz"
        arrays: dict[str, FloatArray] = {}
        if self.folder.joinpath(*beside.split("/")).is_file():
            content = read(beside)
            try:
                with np.load(io.BytesIO(content), allow_pickle=False) as stored:
                    arrays = {key: stored[key] for key in stored.files}
            except Exception as error:  # zip, CRC, header: whatever an edited archive may raise
                raise Damaged("golden", f"{beside} cannot be read ({error})", PUT_BACK) from None
        for value in (value for record in records for value in record["input"].values()):
            if (raw := archived(value)) is not None and "f64" in value:
                arrays[raw] = _raw(f"{name.rpartition('/')[0]}/{raw}", value["shape"], read)
        return [Entry(name, record, arrays, self.folder.name) for record in records]

    def entries(self, *sets: str) -> Iterator[Entry]:
        """The entries of the given parts (default: all there are), set by set in the order of their manifests."""
        for golden in self.chain:
            yield from golden.own(*sets)

    def own(self, *sets: str) -> Iterator[Entry]:
        """The same without those of the set that is extended."""
        for name in self.manifest["files"]:
            if name.endswith(".json") and name != "schema.json" and (not sets or name.split("/")[0] in sets):
                yield from self.as_it_is(name, self._unchanged)

    def entry(self, identifier: str) -> Entry:
        """The entry of that id. Raises LeakrefError.

        Only the file that holds it is read.
        """
        for golden in self.chain:
            for name, row in golden.manifest["files"].items():
                if identifier in row.get("entries", ()):
                    own = golden.as_it_is(name, golden._unchanged)
                    return next(entry for entry in own if entry.id == identifier)
        raise LeakrefError(
            "golden",
            f"no golden value is called {identifier!r}",
            "`leakref golden lint --json` counts what there is; ids are in golden/v1/manifest.json and those after it",
        )


def _raw(name: str, shape: Sequence[int], read: Callable[[str], bytes]) -> FloatArray:
    """The file `name`, little-endian float64 in C order, as an array of that shape. Raises Damaged."""
    try:
        return np.frombuffer(read(name), dtype="<f8").astype(np.float64).reshape(shape)
    except (ValueError, TypeError) as error:
        raise Damaged("golden", f"{name} is not of the shape {shape} ({error})", PUT_BACK) from None


def entry_digest(entry: Entry) -> str:
    """Of the record and of the arrays it names.

    That is of the canonical JSON and, for arrays, of name, shape and little-endian float64 bytes, so that neither an
    indentation nor the way an archive is packed counts.
    """
    given = (value for part in ("input", "output") for value in entry.record[part].values())
    used = sorted({name for name in map(archived, given) if name is not None})
    content = [canonical(entry.record)]
    for name in used:
        array = np.ascontiguousarray(entry.arrays[name], dtype="<f8")
        content += [name.encode(), str(array.shape).encode(), array.tobytes()]
    return hashlib.sha256(b"\0".join(content)).hexdigest()


def compare(entry: Entry, found: Mapping[str, Any], route: str = "") -> list[Failure]:
    """How `found`, arrays by output name, falls short of the golden values; empty if it agrees.

    A number is wanted where there is one, and none (NaN) where the golden value is null with its reason.

    `route` only names itself in the messages. An output that is missing or of another shape is a Failure; of values
    that differ the worst is named, with what is allowed and what the entry is there for. Outputs that the entry does
    not have are not looked at.
    """
    by = f" by route {route}" if route else ""
    failures = []
    for name, golden in entry.output.items():
        if name not in found:
            failures.append(Failure(entry.id, f"{name} is missing{by}", entry.stage))
            continue
        mine = np.asarray(found[name], dtype=np.float64)
        if mine.shape != golden.shape:
            failures.append(
                Failure(entry.id, f"{name} has shape {mine.shape}{by}, but should be {golden.shape}", entry.stage)
            )
            continue
        with np.errstate(invalid="ignore"):
            off = np.abs(mine - golden)
            agrees = (off <= entry.tolerance(name)) | (np.isnan(golden) & np.isnan(mine))
        if not agrees.all():
            worst = np.unravel_index(
                int(np.argmax(np.where(agrees, -1.0, np.where(np.isnan(off), np.inf, off)))), golden.shape
            )
            allowed = np.broadcast_to(entry.tolerance(name), golden.shape)[worst]
            where = list(map(int, worst))
            failures.append(
                Failure(
                    entry.id,
                    f"{name}{where or ''} is {float(mine[worst])!r}{by}, but should be "
                    f"{float(golden[worst])!r} within {allowed:.2g}; {int((~agrees).sum())} of "
                    f"{golden.size} values differ. It is there for: {entry.record['purpose']}",
                    entry.stage,
                )
            )
    return failures
