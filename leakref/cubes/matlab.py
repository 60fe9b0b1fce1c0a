"""The variables of a mat file of MATLAB, version 5 to 7, read with suspicion.

Arrays of numbers are read here, element by element: scipy.io.loadmat crashes on some damaged files. Structures are left
to it, and only where a field of one is asked for.
"""

from __future__ import annotations

import math
import zlib
from collections.abc import Iterator, Sequence
from itertools import islice
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np
from scipy import io

from leakref.cubes.suspicion import DENSEST, HEADER, claim, refuse, size_of

Listing = dict[str, tuple[tuple[int, ...], str]]
__all__ = ["list_mat", "read_mat", "tree"]


def read_mat(path: Path, stream: BinaryIO, names: Sequence[str], most: int | None) -> dict[str, Any]:
    """The variables `names` of a mat file, v5 to v7; a name with a dot in it is the field of a structure, and one as
    FILM(3).IMG that of the third in an array of them.
    """
    content, order = _content(stream, most)
    found: dict[str, Any] = {}
    for kind, element in _elements(path, content, order):
        if kind == _COMPRESSED:
            start = zlib.decompressobj().decompress(element, 8 + HEADER)
            kind, length = (int(n) for n in np.frombuffer(start[:8], f"{order}u4"))
            name, _, shape = _mat_header(path, memoryview(start)[8:], order)
            if name not in names:
                continue
            if most is not None and length > 16 * most + HEADER:
                claim(path, name, shape if math.prod(shape) > most else (length,), 1, length, most=most)
            claim(path, "a variable", (length,), 1, DENSEST * len(element))
            unpacked = memoryview(zlib.decompressobj().decompress(element, 8 + length))
            ((kind, element),) = _elements(path, unpacked, order)
        if kind == _MATRIX:
            found |= _mat_variable(path, element, order, names, most)
    tops = {name.partition(".")[0].partition("(")[0] for name in names if "." in name}
    for top in () if most is not None else sorted(tops):
        fields = _structure(path, top)
        found |= {name: fields[name] for name in names if name in fields}
    return found


def list_mat(path: Path, stream: BinaryIO) -> Listing:
    """Name, shape and kind of each variable, and of each field of a structure."""
    content, order = _content(stream, None)
    found: Listing = {}
    for kind, element in _elements(path, content, order):
        if kind == _COMPRESSED:
            element = memoryview(zlib.decompressobj().decompress(element, 8 + HEADER))[8:]
        elif kind != _MATRIX:
            continue
        name, flags, shape = _mat_header(path, element, order)
        number = flags & 0xFF
        if number == _STRUCTURE:
            fields = {
                field: (np.shape(value), str(np.asarray(value).dtype))
                for field, value in _structure(path, name).items()
            }
            found |= fields or {name: (shape, "a structure")}
        else:
            found[name] = (shape, _CLASSES.get(number) or _NOT_NUMBERS.get(number, "something else"))
    return found


def _content(stream: BinaryIO, most: int | None) -> tuple[memoryview, str]:
    """What follows the header, and the order of bytes. What others may still cut (`most` is given) is read, not mapped:
    a page that is gone would end us.
    """
    content = memoryview(np.memmap(stream, np.uint8, "r") if most is None else stream.read(size_of(stream)))
    return content[128:], "<" if bytes(content[126:128]) == b"IM" else ">"


def _structure(path: Path, name: str) -> dict[str, Any]:
    """The fields of a structure, and of those in it, by dotted names: by scipy.io, {} if there is no such variable."""
    held = io.loadmat(path, variable_names=[name], struct_as_record=False, squeeze_me=True, appendmat=False)
    return dict(_fields(name, held[name])) if name in held else {}


def _fields(name: str, value: Any) -> Iterator[tuple[str, Any]]:
    """What is in a structure, as deep as it goes. Those in an array are numbered from 1, as in MATLAB."""
    if isinstance(value, np.ndarray) and value.dtype == object:
        for n, one in enumerate(value.ravel(order="F"), 1):
            yield from _fields(f"{name}({n})", one)
    for field in getattr(value, "_fieldnames", ()):
        inner = getattr(value, field)
        if hasattr(inner, "_fieldnames") or (isinstance(inner, np.ndarray) and inner.dtype == object):
            yield from _fields(f"{name}.{field}", inner)
        else:
            yield f"{name}.{field}", np.asarray(inner)


def tree(path: Path, content: bytes, largest: int) -> dict[str, Any]:
    """All that a mat file says, version 5 to 7, by name: structures as dictionaries, arrays of them and cells as lists,
    text as words, the rest as arrays. Packed or not it may not be more than `largest` bytes in all.
    """
    if content[124:128] not in (b"\x00\x01IM", b"\x01\x00MI"):
        refuse(path, "is no mat file of version 5", "save it with -v6 or -v7")
    order = "<" if content[126:128] == b"IM" else ">"
    found: dict[str, Any] = {}
    left = largest
    for kind, element in _elements(path, memoryview(content)[128:], order):
        if kind == _COMPRESSED:
            unpacking = zlib.decompressobj()
            unpacked = unpacking.decompress(element, left + 1)
            if len(unpacked) > left:
                refuse(path, f"holds more than {largest} bytes when it is unpacked", "save what was asked for")
            ((kind, element),) = _elements(path, memoryview(unpacked), order)
        left -= len(element)
        if kind == _MATRIX:
            name, _, _ = _mat_header(path, element, order)
            found[name] = _value(path, element, order, 0)
    return found


def _value(path: Path, content: memoryview, order: str, depth: int) -> Any:
    """What a variable, a field or a cell holds."""
    if depth > _DEEPEST:
        refuse(path, "holds structures within each other beyond reason", "save what was asked for")
    if not len(content):
        return np.zeros((0, 0))
    _, flags, shape = _mat_header(path, content, order)
    kind, parts = flags & 0xFF, list(islice(_elements(path, content, order), 3, None))
    if kind == _STRUCTURE:
        (_, width), (_, labels), *values = parts
        size = max(1, int(np.frombuffer(width, f"{order}i4")[0]))
        names = [bytes(labels[at : at + size]).partition(b"\0")[0].decode() for at in range(0, len(labels), size)]
        held = iter([_value(path, part, order, depth + 1) for _, part in values])
        rows = (
            [dict(zip(names, row, strict=False)) for row in zip(*[held] * len(names), strict=True)] if names else [{}]
        )
        return rows[0] if math.prod(shape) == 1 else rows
    if kind == _CELL:
        return [_value(path, part, order, depth + 1) for _, part in parts]
    if kind not in _CLASSES:
        refuse(path, f"holds {_NOT_NUMBERS.get(kind, 'something else')}", "save numbers, text, cells and structures")
    values_ = [np.frombuffer(part, f"{order}{_STORED[stored]}") for stored, part in parts]
    if kind == 4:
        return "".join(map(chr, values_[0].tolist())) if values_ else ""
    return values_[0].astype(_CLASSES[kind]).reshape(shape, order="F")


_STORED = {
    1: "i1",
    2: "u1",
    3: "i2",
    4: "u2",
    5: "i4",
    6: "u4",
    7: "f4",
    9: "f8",
    12: "i8",
    13: "u8",
    16: "u1",
    17: "u2",
    18: "u4",
}  # as the samples are stored, by the tag's number; the last three are text
_CLASSES = {4: "U1", 6: "f8", 7: "f4", 8: "i1", 9: "u1", 10: "i2", 11: "u2", 12: "i4", 13: "u4", 14: "i8", 15: "u8"}
_NOT_NUMBERS = {1: "cells", 2: "a structure", 3: "an object", 5: "a sparse matrix"}
_CELL, _STRUCTURE, _MATRIX, _COMPRESSED = 1, 2, 14, 15
_DEEPEST = 20  # structures within each other


def _elements(path: Path, content: memoryview, order: str) -> Iterator[tuple[int, memoryview]]:
    """Number and content of each element of a mat file, or of a variable in it. No claim may lead out of `content`. A
    tag is a number for the type and a length; up to four bytes of content stand in the tag itself.
    """
    at = 0
    while at < len(content):
        kind, length = (int(v) for v in np.frombuffer(content[at : at + 8].tobytes().ljust(8, b"\0"), f"{order}u4"))
        small = kind >> 16  # up to four bytes stand in the tag itself
        start, kind, length = (at + 4, kind & 0xFFFF, small) if small else (at + 8, kind, length)
        if start + length > len(content) or small > 4:
            refuse(
                path,
                f"is cut short: an element of {length} bytes in the place of {len(content) - start}",
                "copy or export it again",
            )
        yield kind, content[start : start + length]
        at = at + 8 if small else start + length + (0 if kind == _COMPRESSED else -length % 8)


def _mat_header(path: Path, content: memoryview, order: str) -> tuple[str, int, tuple[int, ...]]:
    """Name, flags and shape of a variable, from its beginning."""
    parts = islice(_elements(path, content, order), 3)
    flags, dims, label = (np.frombuffer(part, f"{order}{_STORED[stored]}") for stored, part in parts)
    return label.tobytes().decode("latin1"), int(flags[0]), tuple(int(n) for n in dims)


def _mat_variable(
    path: Path, content: memoryview, order: str, names: Sequence[str], most: int | None
) -> dict[str, Any]:
    """{name: array} of a variable that is one of `names`, empty for others."""
    name, flags, shape = _mat_header(path, content, order)
    kind = flags & 0xFF
    if name not in names:
        return {}
    if kind not in _CLASSES:
        refuse(
            path,
            f"holds {name} as {_NOT_NUMBERS.get(kind, 'something else')}",
            "save it as an array of numbers, or name a field of it: --variable NAME.FIELD",
        )
    parts = islice(_elements(path, content, order), 3, None)
    values = [np.frombuffer(part, f"{order}{_STORED[stored]}") for stored, part in parts]
    claim(path, name, shape, 1, values[0].size if values else 0, most=most)
    if kind == 4:
        return {name: np.array("".join(map(chr, values[0].tolist())))}
    array = values[0].astype(_CLASSES[kind]).reshape(shape, order="F")
    return {name: array + 1j * values[1].reshape(shape, order="F") if flags & 0x800 else array}
