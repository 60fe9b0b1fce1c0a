"""The JSON of golden files: read strictly, and its digests.

Used wherever a digest is made or compared: sets, manifests, the history of `leakref track`. Strict means that what JSON
readers treat differently is refused: NaN and Infinity as bare words, and a key that stands twice in one object.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from typing import Any

from leakref._base import Damaged

__all__ = ["PUT_BACK", "canonical", "digest", "sealed", "strict"]

PUT_BACK = "put the file back: install again, or take it from version control"
"""What there is to do about a file that is not as it was made."""


def canonical(record: Any) -> bytes:
    """The bytes a digest is taken of: strict JSON, sorted keys, no spaces, floats as short as round-trips."""
    return json.dumps(record, sort_keys=True, separators=(",", ":"), ensure_ascii=False, allow_nan=False).encode()


def digest(record: Any) -> str:
    """SHA-256 of `canonical`. Of the record, not of the file: another indentation is the same record."""
    return hashlib.sha256(canonical(record)).hexdigest()


def strict(name: str, content: bytes) -> Any:
    """What the file `name` says; `Damaged` if it is not strict JSON. That is: not text, not JSON, a number that is
    none, or a key given twice.

    """
    try:
        return json.loads(content.decode("utf-8"), parse_constant=_no_constant, object_pairs_hook=_no_twins)
    except (ValueError, RecursionError) as error:
        raise Damaged("golden", f"{name} is not strict JSON ({error})", PUT_BACK) from None


def sealed(manifest: Mapping[str, Any]) -> bool:
    """Whether a manifest is as it was written, by its own digest.

    A manifest carries its digest under `sha256`, taken of all else that it says. This is against accidents: who
    computes the digest anew can write what he likes.
    """
    return manifest.get("sha256") == digest({key: value for key, value in manifest.items() if key != "sha256"})


def _no_constant(name: str) -> float:
    raise ValueError(f"{name} is not JSON")


def _no_twins(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    """A key given twice hides a number: refuse it."""
    if len({key for key, _ in pairs}) != len(pairs):
        raise ValueError(f"a key is there twice among {[key for key, _ in pairs][:6]}")
    return dict(pairs)
