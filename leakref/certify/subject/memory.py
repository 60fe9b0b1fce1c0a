"""How much memory processes hold: what is resident, and what is in memory files that they have open but not mapped.

`child` asks this twenty times a second while a program works, and ends one that holds more than its limit. Adding up
resident sizes alone would miss arrays that are kept in memory files, and those are where a program can hide most.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Iterable
from contextlib import suppress

import psutil

__all__ = ["held"]


def held(processes: Iterable[psutil.Process]) -> int:
    """Bytes. A page that several of them have mapped counts for each; those in files of memory once.

    Files of memory are memfd and /dev/shm on Linux. Their pages are resident where they are mapped: what counts is the
    larger of what is mapped of such files and what the open ones hold.

    Processes that are gone, or that may not be looked into, count as nothing. On systems other than Linux only resident
    memory is counted.
    """
    resident = mapped = 0
    files: dict[tuple[int, int], int] = {}
    for process in processes:
        with suppress(psutil.Error):
            resident += process.memory_info().rss
        if sys.platform == "linux":
            with suppress(OSError):
                mapped += _mapped(process.pid)
                files |= _open(process.pid)
    return resident + max(0, sum(files.values()) - mapped)


def _mapped(number: int) -> int:
    """Resident bytes of a process that belong to shared memory."""
    with open(f"/proc/{number}/status", encoding="utf-8", errors="replace") as stream:
        return sum(int(line.split()[1]) * 1024 for line in stream if line.startswith("RssShmem:"))


def _open(number: int) -> dict[tuple[int, int], int]:
    """The files of memory that a process has open, by device and inode, and the bytes in each."""
    found = {}
    with os.scandir(f"/proc/{number}/fd") as descriptors:
        for entry in descriptors:
            with suppress(OSError):
                if os.readlink(entry.path).startswith(("/memfd:", "/dev/shm/")):
                    about = os.stat(entry.path)
                    found[about.st_dev, about.st_ino] = about.st_blocks * 512
    return found
