"""Places for what numba and matplotlib keep: their own or, where they may not write, a private one for this run.

Compiled code is kept beside the package where that can be written, as numba does by itself; only where it cannot is a
private folder made, which is removed at the end. Imported by every module that compiles.
"""

from __future__ import annotations

import atexit
import os
import shutil
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

__all__ = ["folder", "njit", "prepare"]


def prepare() -> None:
    """See that numba and matplotlib can keep what they make. Nothing heavy is imported, nothing is made needlessly.

    In a container the package often belongs to root and there is no home. What is made for them then is handed down
    to processes started from here, and goes with this one.
    """
    lacking = [
        name
        for name, has_a_place in (("NUMBA_CACHE_DIR", _of_numba()), ("MPLCONFIGDIR", _of_matplotlib()))
        if not has_a_place
    ]
    if not lacking:
        return
    try:
        private = tempfile.mkdtemp(prefix="leakref-cache-")
    except OSError:
        return  # nowhere at all: `njit` compiles without keeping, and who draws will say what is wrong
    atexit.register(_remove, private, os.getpid())
    for name in lacking:
        os.environ[name] = os.path.join(private, name.partition("_")[0].lower())
        os.mkdir(os.environ[name])


def folder() -> Path | None:
    """Where leakref may keep what can be worked out again: `leakref` below the user's caches; None if nowhere."""
    place = _at_home("XDG_CACHE_HOME", ".cache") / "leakref"
    return place if place.is_absolute() and _usable(place) else None


def njit(**options: Any) -> Callable[[Any], Any]:
    """numba's decorator; what is compiled is kept where that can be."""
    prepare()
    import numba

    def compiled(function: Any) -> Any:
        if os.path.isfile(function.__code__.co_filename):  # numba keeps code by its file: altered modules have none
            try:
                return numba.njit(cache=True, **options)(function)
            except RuntimeError:  # no place after all
                pass
        return numba.njit(**options)(function)

    return compiled


def _remove(folder: str, maker: int) -> None:
    if os.getpid() == maker:
        shutil.rmtree(folder, ignore_errors=True)


def _of_numba() -> bool:
    """Whether one of the places where numba looks can be written."""
    package = Path(__file__).parent
    beside = all(_usable(folder / "__pycache__") for folder in (package / "fast", package / "certify" / "strength"))
    given = os.environ.get("NUMBA_CACHE_DIR")
    return beside or (bool(given) and _usable(Path(str(given)))) or _usable_at_home("XDG_CACHE_HOME", ".cache")


def _of_matplotlib() -> bool:
    """Whether matplotlib can write its settings and its list of fonts."""
    given = os.environ.get("MPLCONFIGDIR")
    if given:
        return _usable(Path(given))
    return all(_usable_at_home(*place) for place in (("XDG_CACHE_HOME", ".cache"), ("XDG_CONFIG_HOME", ".config")))


def _usable_at_home(variable: str, folder: str) -> bool:
    place = _at_home(variable, folder)
    return place.is_absolute() and _usable(place)


def _at_home(variable: str, folder: str) -> Path:
    return Path(os.environ.get(variable) or os.path.join(os.path.expanduser("~"), folder))


def _usable(folder: Path) -> bool:
    """Whether files can be made in a folder, which may have to be made first."""
    there = next((place for place in (folder, *folder.parents) if os.path.exists(place)), folder)
    return os.path.isdir(there) and os.access(there, os.W_OK | os.X_OK)
