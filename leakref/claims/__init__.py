"""The paper's statements as predicates: which hold, by how much, and which depend on how they are read.

`configurations` names the seas, `evidence` computes their ensembles, `words` holds the vocabulary in which the
statements are then written down, a module for each group: W windows, N methods, A directions, P peakedness,
R resolution, U currents, G general, M methods beside the paper's own, B inferred depths.
"""

from __future__ import annotations

from leakref.claims import (  # noqa: F401  which register them
    alternatives,
    currents,
    depths,
    directions,
    general,
    methods,
    peakedness,
    resolution,
    windows,
)
from leakref.claims.configurations import EXTRA
from leakref.claims.evidence import Evidence
from leakref.claims.registry import CLAIMS as _CLAIMS
from leakref.claims.registry import Claim, Finding, position, select

__all__ = ["CLAIMS", "EXTRA", "Claim", "Evidence", "Finding", "select"]

CLAIMS: dict[str, Claim] = {id: _CLAIMS[id] for id in sorted(_CLAIMS, key=position)}
"""Every claim by its id, in the order of the paper's list."""
