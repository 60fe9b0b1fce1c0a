"""Suspicion: what a file claims is held against what it can hold, and a refusal names file, fault and remedy.

All readers of files lean on this. What is too large for the file it stands in was never written; what is too large for
memory is refused before it is read.
"""

from __future__ import annotations

import errno
import math
import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import BinaryIO, NoReturn

from leakref._base import LeakrefError, Trouble

__all__ = ["AS_NPY", "DENSEST", "HEADER", "TooLarge", "claim", "refuse", "size_of", "told"]

DENSEST = 1032
"""Deflate shrinks no further: what claims to hold more than this many times its bytes cannot."""
HEADER = 1 << 12
"""Bytes in which a variable says what it is; numpy's own limit is some more."""
AS_NPY = "save eta with numpy.save as .npy, which is read in blocks, and pass --spacing dx,dy,dt"
"""What helps where a cube does not fit into memory."""


class TooLarge(LeakrefError):
    """A file holds more than there can be.

    Raised only where the caller has said how much there can be at `most`: an output under judgement.
    """


def refuse(path: Path, fault: str, remedy: str) -> NoReturn:
    """Raise the LeakrefError that names the file, what is wrong with it and what to do."""
    raise LeakrefError("extract", f"{path} {fault}", remedy)


_AROUND = (errno.EIO, errno.EMFILE, errno.ENFILE, errno.ENOMEM, errno.ESTALE)  # not the file's fault


@contextmanager
def told(path: Path) -> Iterator[list[str]]:
    """Whatever goes wrong while a file is read becomes a LeakrefError that names it, or a Trouble if the machine is to
    blame. Yields a list for the name of the kind of file, once it is known.
    """
    kind: list[str] = []
    try:
        yield kind
    except LeakrefError:
        raise
    except FileNotFoundError:
        refuse(path, "does not exist", "check the name")
    except PermissionError:
        refuse(path, "may not be read by you", "ask for permission to read it (chmod +r) or copy it")
    except MemoryError:
        refuse(path, "does not fit into memory", AS_NPY)
    except Exception as error:  # parsers of damaged files raise anything: struct.error, zlib.error, KeyError, OSError
        if isinstance(error, OSError) and error.errno in _AROUND:
            raise Trouble("extract", f"{path} cannot be read ({error.strerror})", "see to that and try again") from None
        words = " ".join(str(error).split()) or type(error).__name__
        refuse(
            path,
            f"is damaged or cut short (reading it as {''.join(kind) or 'a file'} failed: {words})",
            "copy or export it again",
        )


def claim(
    path: Path,
    name: str,
    shape: tuple[int, ...],
    itemsize: int,
    available: float = math.inf,
    loaded: bool = True,
    most: int | None = None,
) -> None:
    """Refuse what a header claims but the file cannot hold, or memory cannot (a transform needs it four times).

    And what is more than `most` numbers, of 32 bytes or fewer. `available` is what the file has left, in bytes, times
    what packing can have saved; `loaded` is False for what is mapped.
    """
    count = math.prod(int(n) for n in shape)
    if most is not None and (count > most or count * itemsize > 32 * most):
        raise TooLarge(
            "extract",
            f"{path} holds {name} of shape {shape}, {count * itemsize} bytes, should be {most} "
            f"number{'s' * (most != 1)}",
            "write what was asked for",
        )
    if count * itemsize > available:
        refuse(
            path,
            f"is cut short: {name} of shape {shape} takes {count * itemsize} bytes, at most {available} are there",
            "copy or export it again",
        )
    memory = os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES") if hasattr(os, "sysconf") else math.inf
    if loaded and 4 * 8 * count > memory:
        refuse(path, f"holds {name} of shape {shape}, too large for this machine's memory", AS_NPY)


def size_of(stream: BinaryIO) -> int:
    """Of the file that is open, whatever has become of its name."""
    return os.fstat(stream.fileno()).st_size
