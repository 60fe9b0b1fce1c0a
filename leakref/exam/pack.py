"""The golden values as one archive for other languages: vectors of every stage, tolerances, and runners that compare.

    vectors.tsv            a line for each vector: id, stage, its input and what is right, with their sums
    inputs/, golden/       the arrays, a file or a folder each; beside each value NAME there is allowed_NAME
    leakref_check.*        for unit tests in MATLAB, C++ and R
    SHA256SUMS, README.md

It says of every value how far from it one may be: the tolerance of the set (`leakref.golden.sets`), and NaN where there
should be no number. Nothing is computed here.
"""

from __future__ import annotations

import hashlib
import tempfile
from collections.abc import Iterator, Mapping
from importlib import resources
from pathlib import Path
from typing import Any
from zipfile import ZIP_DEFLATED, ZipFile, ZipInfo

import numpy as np
from rich.console import Console
from rich.markup import escape

from leakref._base import FloatArray, LeakrefError
from leakref._output import dump, envelope, folder, progress_bar, write_whole
from leakref.exam import storing
from leakref.exam.folder import filled
from leakref.golden.sets import Entry, Golden, locate

__all__ = ["SCHEMA", "flattened", "pack", "run", "vectors"]

SCHEMA = "leakref/pack/1"
RUNNERS = {"raw": ("leakref_check.m", "leakref_check.hpp", "leakref_exam.hpp", "leakref_check.R", "leakref_exam.R"),
           "mat": ("leakref_check.m",)}  # fmt: skip
"""By format, those that read it; those that compare lean on those that ask."""


def vectors(number: int) -> list[Entry]:
    """The entries of a golden set that are small: all stages, and the figures of windows."""
    return [entry for entry in Golden(locate(number)).entries("vectors", "analytic") if entry.output]


def flattened(given: Mapping[str, Any], prefix: str = "") -> Iterator[tuple[str, Any]]:
    """An input as words, numbers and arrays; of a current `current_velocity`, `current_shear`, `current_layers`. What
    is empty is left out.
    """
    for name, value in given.items():
        if isinstance(value, Mapping):
            yield from flattened(value, f"{prefix}{name}_")
        elif isinstance(value, str | int | float):
            yield prefix + name, value
        elif np.size(value):
            yield prefix + name, np.asarray(value, dtype=np.float64)


def _written(place: Path, form: str, entries: list[Entry], step: Any) -> str:
    """The arrays below `place`, and the table of them."""
    lines = [f"{SCHEMA}\t{form}\n", "id\tstage\tinput\tsum\tgolden\tsum\tparameters\n"]
    for number, entry in enumerate(entries, 1):
        given = dict(flattened(entry.input))
        arrays = {name: value for name, value in given.items() if isinstance(value, np.ndarray)}
        right: dict[str, FloatArray] = {}
        for name, value in entry.output.items():
            right[name] = np.atleast_1d(value)
            right[f"allowed_{name}"] = np.broadcast_to(np.atleast_1d(entry.tolerance(name)), right[name].shape)
        cells = [entry.id, entry.stage]
        for top, held in (("inputs", arrays), ("golden", right)):
            path = Path(top) / f"{number:03}{storing.SUFFIX[form]}"
            if held:
                storing.write(place / path, form, held)
            content = b"".join(one.read_bytes() for one in storing.files(place / path)) if held else b""
            cells += [path.as_posix() if held else "-", str(storing.checksum(content) if held else 0)]
        cells += [
            f"{name}={value if isinstance(value, str) else dump(value)}"
            for name, value in given.items()
            if name not in arrays
        ]
        cells += [f"shape_{name}={_shape(value)}" for name, value in arrays.items()]
        cells += [f"golden_shape_{name}={_shape(value)}" for name, value in right.items()]
        lines.append("\t".join(cells) + "\n")
        step()
    return "".join(lines)


def _shape(value: FloatArray) -> str:
    return ",".join(map(str, value.shape))


def _text(name: str) -> str:
    """A runner. That for MATLAB, where a file has one public function, holds what it needs of the other."""
    templates = resources.files("leakref.exam").joinpath("templates")
    text = templates.joinpath(name).read_text("utf-8")
    if name != "leakref_check.m":
        return text
    asking = templates.joinpath("leakref_exam.m").read_text("utf-8")
    shared = asking[asking.index("function p = parameters(") : asking.index("function rest = velocities(")]
    return text.replace("@SHARED@\n", shared.rstrip() + "\n")


def pack(out: Path, form: str, number: int, step: Any = lambda: None) -> dict[str, Any]:
    """Write the archive: how many entries and values it has, its size and its SHA-256. Raises LeakrefError."""
    storing.format_named("golden pack", form)
    entries = vectors(number)
    if out.is_dir():
        raise LeakrefError("golden pack", f"{out} is a folder", "name the file to write, such as golden.zip")
    folder(out.parent)
    with tempfile.TemporaryDirectory() as name:
        place = Path(name)
        texts = {"vectors.tsv": _written(place, form, entries, step)}
        words = {"@FORMAT@": form, "@SET@": f"v{number}", "@COUNT@": str(len(entries))}
        texts["README.md"] = filled(_text("PACK.md"), form, words)
        texts |= {runner: _text(runner) for runner in RUNNERS.get(form, ())}
        for file, text in texts.items():
            (place / file).write_text(text, encoding="utf-8", newline="\n")
        files = sorted(path for path in place.rglob("*") if path.is_file())
        contents = {path.relative_to(place).as_posix(): path.read_bytes() for path in files}
    sums = "".join(f"{storing.sha256(content)}  {path}\n" for path, content in contents.items())
    contents["SHA256SUMS"] = sums.encode()

    def write(beside: Path) -> None:
        with ZipFile(beside, "w", ZIP_DEFLATED) as archive:
            for path, content in contents.items():
                archive.writestr(ZipInfo(path), content, ZIP_DEFLATED)  # without a date: the same set, the same bytes

    write_whole(out, write)
    with out.open("rb") as stream:
        digest = hashlib.file_digest(stream, "sha256").hexdigest()
    values = sum(entry.values for entry in entries)
    return {"entries": len(entries), "values": values, "bytes": out.stat().st_size, "sha256": digest}


def run(out: Path, form: str, number: int, *, json: bool = False) -> bool:
    """The command; returns True. Raises LeakrefError as `pack` does."""
    with progress_bar("golden vectors", len(vectors(number))) as step:
        about = pack(out, form, number, step)
    if json:
        print(dump(envelope("golden", True, action="pack", path=out, format=form, golden=f"v{number}", **about)))
    else:
        words = f"{about['entries']} vectors, {about['values']} values, {about['bytes'] / 1e6:.1f} MB, in {out}"
        Console().print(f"{escape(words)}; SHA-256 {about['sha256']}.", soft_wrap=True)
    return True
