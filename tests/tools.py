"""Tools that some tests need beside Python."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from typing import NoReturn

import pytest

REQUIRABLE = {"octave", "chromium", "iwave", "g++", "make", "Rscript"}
"""What LEAKREF_REQUIRE may name, with commas between: where it is absent its tests fail instead of skipping."""


def lacking(name: str, reason: str) -> NoReturn:
    """Skip the test for `reason`, or fail it if LEAKREF_REQUIRE names what is lacking."""
    required = {word.strip() for word in os.environ.get("LEAKREF_REQUIRE", "").split(",")} - {""}
    if unknown := required - REQUIRABLE:
        raise pytest.UsageError(f"LEAKREF_REQUIRE names {sorted(unknown)}, should be some of {sorted(REQUIRABLE)}")
    if name in required:
        pytest.fail(f"{reason}, and it is required (LEAKREF_REQUIRE)")
    pytest.skip(reason)


def requires(tool: str, name: str | None = None) -> str:
    """The path of a program, or `lacking` under `name` (default: the program's)."""
    return shutil.which(tool) or lacking(name or tool, f"{tool} is not installed")


def iwave_python() -> str:
    """The Python of an environment that has iwave, which LEAKREF_IWAVE_PYTHON names, or `lacking`."""
    path = shutil.which(os.environ.get("LEAKREF_IWAVE_PYTHON", ""))
    if path is None:
        lacking("iwave", "LEAKREF_IWAVE_PYTHON does not name the Python of an environment with iwave")
    look = "import sys; from importlib.util import find_spec; sys.exit(not find_spec('iwave'))"
    there = subprocess.run([path, "-c", look], check=False).returncode == 0
    return path if there else lacking("iwave", f"{path} has no iwave")


def peak_memory(code: str) -> int:
    """The most memory, in bytes, that a fresh interpreter held while it ran `code`.

    Linux hands the peak of getrusage down from parent to child, so that a large test run before this one would
    count; VmHWM belongs to the process alone.
    """
    report = (
        "\nimport resource, sys\n"
        "peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * (1 if sys.platform == 'darwin' else 1024)\n"
        "try:\n"
        "    status = open('/proc/self/status').read()\n"
        "    peak = 1024 * int(status.partition('VmHWM:')[2].split()[0])\n"
        "except (OSError, IndexError):\n"
        "    pass\n"
        "print(peak)"
    )
    done = subprocess.run(
        [sys.executable, "-W", "ignore::ResourceWarning", "-c", code + report],
        capture_output=True,
        text=True,
        check=True,
    )
    return int(done.stdout.split()[-1])
