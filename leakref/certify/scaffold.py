"""A working adapter to start from, in several languages, and files for CI that judge it: copied from `templates/`, a
folder for each kind.

Used by `leakref scaffold`. The adapters work as they are, with something simple that is to be replaced.
"""

from __future__ import annotations

from importlib import resources
from pathlib import Path

from leakref._base import LeakrefError
from leakref._output import write_whole

__all__ = ["NEXT", "write"]

NEXT = {
    "python": "leakref certify adapter:Code",
    "octave": 'leakref certify --command "octave-cli --quiet --no-init-file adapter.m"',
    "shell": 'leakref certify --command "sh adapter.sh"',
    "cpp": "make && leakref certify --command ./adapter",
    "ci": "set LEAKREF and TARGET at the top of each, then git add .github/workflows/leakref.yml .gitlab-ci.yml; or "
    "LEAKREF and ANSWER in those of an examination, for a code that no Python is beside (leakref guide exam)",
}
"""By kind, what to do next in the folder."""
_PLACES = {
    "github.yml": ".github/workflows/leakref.yml",
    "gitlab.yml": ".gitlab-ci.yml",
    "github-exam.yml": ".github/workflows/leakref-exam.yml",
    "gitlab-exam.yml": ".gitlab-ci-exam.yml",
}


def write(kind: str, folder: Path) -> list[Path]:
    """Write the files of a `kind` (a key of NEXT) to `folder`: their paths.

    Raises LeakrefError for another kind, and writes nothing if one of the files is already there.
    """
    if kind not in NEXT:
        raise LeakrefError("scaffold", f"there is none for {kind!r}", f"choose one of {', '.join(NEXT)}")
    templates = resources.files("leakref.certify").joinpath("templates", kind)
    texts = {
        Path(folder) / _PLACES.get(file.name, file.name): file.read_bytes()
        for file in templates.iterdir()
        if file.is_file()
    }
    for path in texts:
        if path.exists():
            raise LeakrefError("scaffold", f"{path} is there already", "name another folder")
    for path, text in texts.items():
        write_whole(path, lambda beside, text=text: beside.write_bytes(text))  # type: ignore[misc]  # a default binds it
    return sorted(texts)
