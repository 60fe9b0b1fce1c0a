"""Parts of long computations, kept in files so that a run goes on where it stopped.

A part says inside what it is of and carries a SHA-256 of that and of its contents. It is taken only if it is of what is
asked for, of the form that is asked for, and as it was written; anything else is as if it were not there.

Used by `runs`, `claims`, `golden` and the strength study. There is no index and no lock: each part is a file of its own
that is written whole or not at all, so that several processes may share a folder and any of them may be killed. A part
that is not taken is never removed.

A part is written and taken back with the same `about`; with any other it is not there:

    about = {"sea": "broad", "number": 3}
    path = folder / f"{key(about)}.json"
    keep_record(path, about, {"bias": 0.1})
    assert record(path, about) == {"bias": 0.1} and record(path, {**about, "number": 4}) is None
"""

from __future__ import annotations

import json
import tokenize
import zipfile
import zlib
from collections.abc import Mapping
from hashlib import sha256
from pathlib import Path
from typing import Any

import numpy as np

from leakref._output import dump, write_whole

__all__ = ["arrays", "keep_arrays", "keep_record", "key", "record"]

About = Mapping[str, Any]
"""Everything that a part depends on, in the types of JSON: configuration, realisation, settings, digest of sources."""
_DAMAGED = (
    OSError,
    ValueError,
    KeyError,
    TypeError,
    EOFError,
    RuntimeError,
    SyntaxError,
    tokenize.TokenError,
    zipfile.BadZipFile,
    zlib.error,
)  # what reading a file of arrays may raise that is not whole


def _text(about: Any) -> str:
    return json.dumps(about, sort_keys=True)


def key(about: About) -> str:
    """A name for the folder or file of what `about` says.

    Twenty hexadecimal digits of SHA-256 over the JSON with sorted keys. The order in which things are named does not
    count.
    """
    return sha256(_text(about).encode()).hexdigest()[:20]


def _seal(about: str, contents: Mapping[str, np.ndarray]) -> str:
    """Names, types, shapes and bytes of all arrays, and what they are of."""
    parts = [about.encode()]
    for name, values in sorted(contents.items()):
        parts += [f"{name} {values.dtype.str} {values.shape}".encode(), np.ascontiguousarray(values).tobytes()]
    return sha256(b"\0".join(parts)).hexdigest()


def keep_arrays(path: Path, about: About, **contents: np.ndarray) -> None:
    """Write arrays and what they are of, whole or not at all.

    `path` is an npz file; folders above are made if need be by `write_whole`. Names are free, but for `about` and
    `sha256`.
    """
    sealed: dict[str, Any] = {
        **contents,
        "about": np.array(_text(about)),
        "sha256": np.array(_seal(_text(about), contents)),
    }
    write_whole(path, lambda beside: np.savez(beside, **sealed))


def arrays(path: Path, about: About, **shapes: tuple[int, ...]) -> dict[str, np.ndarray] | None:
    """The arrays of those names and `shapes` that `keep_arrays` wrote for this `about`; None if they are not there.

    None, too, if there are others beside them, or if a shape, the seal or the file is not right. Nothing is raised for
    a file that is damaged.
    """
    try:
        with path.open("rb") as stream, np.load(stream, allow_pickle=False) as kept:
            if str(kept["about"]) != _text(about) or {*kept.files} != {*shapes, "about", "sha256"}:
                return None
            found = {name: kept[name] for name in shapes}
            sealed = str(kept["sha256"])
    except _DAMAGED:
        return None
    fits = all(found[name].shape == shape for name, shape in shapes.items())
    return found if fits and sealed == _seal(_text(about), found) else None


def keep_record(path: Path, about: About, content: Any) -> None:
    """Write a JSON record and what it is of, whole or not at all."""
    text = dump({"about": about, "sha256": sha256(_text([about, content]).encode()).hexdigest(), "record": content})
    write_whole(path, lambda beside: beside.write_text(text + "\n", encoding="utf-8"))


def record(path: Path, about: About) -> Any | None:
    """The record that `keep_record` wrote for this `about`; None if it is not there.

    Returned is what JSON makes of it: lists for tuples, None for null.
    """
    try:
        kept = json.loads(path.read_text(encoding="utf-8"))
        own = _text(kept["about"]) == _text(about)
        sealed = kept["sha256"] == sha256(_text([kept["about"], kept["record"]]).encode()).hexdigest()
    except (OSError, ValueError, KeyError, TypeError, RecursionError):
        return None
    return kept["record"] if own and sealed else None
