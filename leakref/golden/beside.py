"""What stands in `golden/` beside the sets: results about the paper, the history, a page for readers, sets' manifests.

`golden/manifest.json` has the SHA-256 of each. What is read of them is compared with it first; commands that write one
of them write its digest in the same step (`noted`), and for what is edited by hand `leakref golden regenerate files`.
"""

from __future__ import annotations

import hashlib
from collections.abc import Iterator
from functools import partial
from importlib import resources
from importlib.resources.abc import Traversable
from pathlib import Path
from typing import Any

from leakref._base import Damaged, LeakrefError
from leakref._output import write_whole
from leakref.golden.digests import PUT_BACK, digest, sealed, strict
from leakref.golden.sets import Failure

__all__ = ["MANIFEST", "SCHEMA", "home", "lint", "noted", "read", "record"]

MANIFEST = "manifest.json"
"""In the folder of all sets and in each of them."""
SCHEMA = "leakref/golden-files/1"
"""Of the manifest in the folder of all sets."""
_TAKE = "`leakref golden regenerate files`"
_AGAIN = f"put it back or, if it was made anew, {_TAKE}"


def home() -> Traversable:
    """The folder with all sets, as installed.

    It is where the package has its data: in a checkout the folder `golden/`, in an installation a copy of it.
    """
    return resources.files("leakref._golden")


def _there(folder: Traversable) -> Iterator[str]:
    """The files that the manifest covers: all in the folder itself, and the manifests of the sets."""
    for child in folder.iterdir():
        if child.is_file() and child.name != MANIFEST:
            yield child.name
        elif child.is_dir() and child.joinpath(MANIFEST).is_file():
            yield f"{child.name}/{MANIFEST}"


def _sha256(folder: Traversable, name: str) -> str:
    return hashlib.sha256(folder.joinpath(*name.split("/")).read_bytes()).hexdigest()


def _manifest(folder: Traversable) -> dict[str, Any]:
    """What the folder says it holds. Raises Damaged."""
    try:
        said = strict(f"golden/{MANIFEST}", folder.joinpath(MANIFEST).read_bytes())
    except OSError as error:
        raise Damaged("golden", f"golden/{MANIFEST} cannot be read ({type(error).__name__})", PUT_BACK) from None
    if not isinstance(said, dict) or said.get("schema") != SCHEMA or not sealed(said):
        raise Damaged("golden", f"golden/{MANIFEST} was changed: its own SHA-256 is not that of what it says", PUT_BACK)
    return said


def read(name: str, folder: Traversable | None = None) -> Any:
    """The JSON of `golden/name`, as it was made. Raises Damaged.

    `folder` is `home()` unless given. Damaged is raised where the file or the manifest cannot be read, is not strict
    JSON, or has another digest than the manifest's.
    """
    folder = folder or home()
    try:
        content = folder.joinpath(name).read_bytes()
    except OSError as error:
        raise Damaged("golden", f"golden/{name} cannot be read ({type(error).__name__})", PUT_BACK) from None
    if hashlib.sha256(content).hexdigest() != _manifest(folder)["files"].get(name):
        raise Damaged("golden", f"golden/{name} was changed: its SHA-256 is not the manifest's", _AGAIN)
    return strict(f"golden/{name}", content)


def lint(folder: Traversable) -> tuple[dict[str, Any], list[Failure]]:
    """A row of the report for the files beside the sets, and what is amiss with them.

    A file may be changed, missing, or not in the manifest; each is one Failure that names it. The row has the columns
    of those of the sets, so that both stand in one table.
    """
    row = {"name": "beside", "set": "", "state": "complete", "files": 0, "entries": 0, "values": 0}
    try:
        files = _manifest(folder)["files"]
    except LeakrefError as error:
        return row, [Failure(f"golden/{MANIFEST}", error.fault)]
    there = set(_there(folder))
    faults = [
        Failure(f"golden/{name}", f"was changed: its SHA-256 is not that of golden/{MANIFEST}; {_AGAIN}")
        for name in sorted(there & set(files))
        if _sha256(folder, name) != files[name]
    ]
    faults += [Failure(f"golden/{name}", f"is missing; {PUT_BACK}") for name in sorted(set(files) - there)]
    faults += [
        Failure(f"golden/{name}", f"is not in golden/{MANIFEST}: remove it, or {_TAKE}")
        for name in sorted(there - set(files))
    ]
    return {**row, "files": len(there)}, faults


def _write(folder: Path, files: dict[str, str]) -> None:
    said: dict[str, Any] = {"schema": SCHEMA, "license": "CC0-1.0", "files": dict(sorted(files.items()))}
    rows = ",\n".join(f'    "{name}": "{value}"' for name, value in said["files"].items())
    text = (
        f'{{\n  "schema": "{SCHEMA}",\n  "license": "CC0-1.0",\n  "files": {{\n{rows}\n  }},\n'
        f'  "sha256": "{digest(said)}"\n}}\n'
    )
    write_whole(folder / MANIFEST, partial(Path.write_text, data=text, encoding="utf-8", newline="\n"))


def record(folder: Path) -> list[str]:
    """Write down what lies in `folder` as it is; the names of those that were other before.

    The manifest is made anew, and is written even if nothing differs. Names are relative to `folder`, sorted, those
    that have come or gone among them.
    """
    try:
        before = _manifest(folder)["files"]
    except LeakrefError:
        before = {}
    now = {name: _sha256(folder, name) for name in _there(folder)}
    _write(folder, now)
    return sorted(name for name in {*before, *now} if before.get(name) != now.get(name))


def noted(path: Path) -> None:
    """Write down the digest of a file that was just written, if it is one of those that a manifest keeps.

    Looked at are the manifests in its folder and in the one above. A manifest that is damaged is left alone: a digest
    written into it would hide that.
    """
    path = path.resolve()
    for folder in path.parents[:2]:
        if not (folder / MANIFEST).is_file() or path == folder / MANIFEST:
            continue
        try:
            files = _manifest(folder)["files"]
        except LeakrefError:
            continue  # another's, or damaged, which is for lint to say
        name = path.relative_to(folder).as_posix()
        if name in files:
            _write(folder, {**files, name: _sha256(folder, name)})
