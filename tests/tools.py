"""Tools that some tests need beside Python."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys

import pytest


def requires(tool: str, name: str | None = None) -> str:
    """The path of a program, or a skip; a failure if LEAKREF_REQUIRE holds `name` (default: the program's)."""
    found = shutil.which(tool)
    if found is None and (name or tool) in os.environ.get("LEAKREF_REQUIRE", ""):
        pytest.fail(f"{tool} is required (LEAKREF_REQUIRE) and not installed")
    if found is None:
        pytest.skip(f"{tool} is not installed")
    return found


def peak_memory(code: str) -> int:
    """The most memory, in bytes, that a fresh interpreter held while it ran `code`.

    Linux hands the peak of getrusage down from parent to child, so that a large test run before this one would
    count; VmHWM belongs to the process alone.
    """
    report = ("\nimport resource, sys\n"
              "peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * (1 if sys.platform == 'darwin' else 1024)\n"
              "try:\n"
              "    status = open('/proc/self/status').read()\n"
              "    peak = 1024 * int(status.partition('VmHWM:')[2].split()[0])\n"
              "except (OSError, IndexError):\n"
              "    pass\n"
              "print(peak)")
    done = subprocess.run([sys.executable, "-W", "ignore::ResourceWarning", "-c", code + report], capture_output=True,
                          text=True, check=True)
    return int(done.stdout.split()[-1])
