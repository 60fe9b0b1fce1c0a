"""`leakref explain ID`: a check, a fault, a variant, a claim, a decision or a golden value, in words.

What it says is taken from the registers of checks, faults, variants, claims and decisions, and from the golden set: it
has no texts of its own but `TERMS`. Registers are imported only when an id is looked for, so that the command is quick.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from difflib import get_close_matches
from typing import Any

from rich.console import Console
from rich.markup import escape

from leakref._base import Damaged, LeakrefError
from leakref._output import dump, envelope

__all__ = ["STAGES", "TERMS", "explain", "run"]

Explanation = dict[str, Any]
STAGES = {
    "extract": "Given: the surface elevation of a cube over x, y and t, its spacings, gravity, a window, a method and "
    "the wavenumbers wanted; the water is deep, or (family depth) its depth and surface tension are given. Wanted: one "
    "velocity (x, y) at each of them, in the units of the cube.",
    "spectrum": "Given: the surface elevation of a cube, its spacings and a window. Wanted: its complex spectrum.",
    "window": "Given: the name of a window and a number of samples. Wanted: the samples of the window.",
    "sea": "Given: a grid, and what a random sea is to be: its energy, peak, peakedness, direction, spread, current, "
    "depth and a seed, each in several forms. Wanted: the surface.",
    "synthesize": "Given: waves by wave vector, frequency, amplitude and phase, and coordinates. Wanted: the surface.",
}
"""What a code is given at each stage, and what it is to return: in its own axes and units (guide protocol)."""
TERMS = {
    "reference": "leakref's own extraction from the same cube, by the paper's two methods",
    "c0": "the phase velocity of the waves at the peak of the spectrum, the unit of velocities "
    "in all checks; where there are a few waves only, that of a wave of k = 1",
    "|c - U|": "how far the velocity c that was found is from the true one, U, as a length",
    "velocity resolution": "by how much a velocity changes if a wave of that wavenumber k moves by one bin: domega / k "
    "along frequency (domega = 2 pi / duration), cg dk / k along wavenumber (dk = 2 pi / the shorter side, cg the "
    "group velocity); at each k one of the two is smaller, one larger (eq:dcdwk). A fit to many bins does better",
    "nothing to note": "the reference has a velocity there and no reason to doubt it, such as another velocity that "
    "scores higher, or a maximum that is flat (all of them: `leakref.Note`)",
    "NSP": "the paper's normalized scalar product, method `nsp`: the velocity with the highest score",
    "score": "the value of what the NSP maximises, N of eq:normSp, as the reference computes it",
    "least squares": "the paper's second method, `ls`: the velocity that fits the strongest bins best",
    "whole band": 'codes that declare "resolves": "band" give one velocity for all wavenumbers together',
    "on bins": "with a whole number of wavelengths and periods in the cube, so that they do not leak",
    "shell": "the part of the spectrum within two bins of a wavenumber, in which its velocity is found",
    "tapered": "multiplied by a window that falls to zero at the edges, such as Hann's",
    "decision": "what leakref does where the paper leaves a choice; `leakref explain D19` prints that one",
    "golden": "inputs and outputs that were computed by several routes and are kept with the package",
}
"""What words of a check mean, to a reader who has read nothing else."""


def run(identifier: str | None, *, json: bool = False) -> bool:
    """Print what `identifier` stands for, or what there is. Raises LeakrefError, naming those that come close.

    With `json` the explanation, or the list of ids, is one object on standard output.
    """
    if identifier is None:
        return _list(json=json)
    found = explain(identifier)
    if json:
        print(dump(envelope("explain", True, **found)))
        return True
    show = Console()
    show.print(f"[bold]{escape(str(found['id']))}[/], {found['kind']}")
    for name, value in found.items():
        if name in ("id", "kind") or value in (None, "", [], {}):
            continue
        if name == "terms":
            show.print("[dim]in these words:[/]")
            for term, words in value.items():
                show.print(f"    [dim]{escape(term)}:[/] {escape(words)}", soft_wrap=True)
            continue
        show.print(f"[dim]{name.replace('_', ' ')}:[/] {escape(_text(value))}", soft_wrap=True)
    return True


def explain(identifier: str) -> Explanation:
    """`id`, `kind` and what there is to say, by name, of whatever is called `identifier`.

    Looked for in this order: checks (`recovery.pair`, or with `[case]`), families, faults, variants, claims, decisions,
    golden values. Prefixes `fault:` and `variant:` may stand before theirs. LeakrefError is raised for anything else,
    Damaged if the golden set is not whole. Fields differ by kind, and are left out of the print where they are empty:
    of a check its reason, tolerance and cases, of a fault its changes, of a claim its verdict and the variants under
    which it turns, of a decision the reference's answer and the shifts that were measured, of a golden value what it is
    there for.
    """
    for look in (_check, _family, _fault, _variant, _claim, _decision, _golden):
        found = look(identifier)
        if found is not None:
            return found
    from leakref.cases import CASES

    if identifier.partition("/")[0] in CASES:
        raise LeakrefError(
            "explain", f"{identifier} is a case", f"`leakref reproduce {identifier}` runs it; `leakref guide paper`"
        )
    near = get_close_matches(identifier, list(dict.fromkeys(_names())), 4, 0.5)
    raise LeakrefError(
        "explain",
        f"nothing is called {identifier!r}",
        f"perhaps {' or '.join(near)} is meant"
        if near
        else "ids are those of checks, faults, "
        "variants, claims (A4), decisions (D4) and golden values; without one they are listed",
    )


def _text(value: Any) -> str:
    """Lists and dictionaries in a line, for people."""
    if isinstance(value, dict):
        return ", ".join(f"{name} = {_text(item)}" for name, item in value.items())
    return ", ".join(map(_text, value)) if isinstance(value, list | tuple) else str(value)


def _list(*, json: bool) -> bool:
    """All ids there are, but for those of the golden values (in the sets' manifests)."""
    ids = list(dict.fromkeys(_names()))
    if json:
        print(dump(envelope("explain", True, ids=ids)))
    else:
        Console().print(
            "[dim]Checks and their families, faults, variants, claims, decisions:[/]\n" + escape(", ".join(ids))
        )
    return True


def _names() -> Iterator[str]:
    """Every id but those of golden values, of which there are too many to list."""
    from leakref.certify.checks.registry import FAMILIES
    from leakref.certify.runner import select
    from leakref.certify.strength.faults import FAULTS
    from leakref.certify.strength.variants import VARIANTS
    from leakref.claims import CLAIMS
    from leakref.decisions import DECISIONS

    yield from (c.id for c, _ in select())
    for register in (FAMILIES, FAULTS, VARIANTS, CLAIMS, DECISIONS):
        yield from register


def _check(identifier: str) -> Explanation | None:
    """A check, or with `[case]` one of its findings: reason, tolerance, terms in it, and faults that it kills."""
    from leakref.certify.runner import select

    name, _, rest = identifier.partition("[")
    matches = [(c, case) for c, case in select() if c.id == name and (not rest or f"[{case.id}]" == f"[{rest}")]
    if not matches:
        return None
    c, case = matches[0]
    one = (
        {"case": {"id": case.id, **case.given}, "profile": "quick" if case.quick else "full"}
        if rest
        else {"cases": [case.id for _, case in matches]}
    )
    target = f"'{c.id}[{case.id}]'" if rest else c.id
    return {
        "id": identifier,
        "kind": "a check",
        "family": c.family,
        "reason": c.reason,
        **_stands(c.label),
        "stage": c.stage,
        "asked": STAGES.get(c.stage, ""),
        "tolerance": c.tolerance,
        "terms": _terms(f"{c.reason} {c.tolerance}"),
        **one,
        "faults": _killed_by(c.id),
        "repro": f"leakref certify TARGET --only {target} --keep FOLDER",
    }


def _stands(label: str) -> dict[str, str]:
    """What a check leans on: an equation or a section of the paper, or the protocol."""
    return (
        {"rule": "leakref guide protocol, section 8"}
        if label == "protocol"
        else {"equation": f"{label} of the paper (arXiv 2311.01265)"}
    )


def _terms(said: str) -> dict[str, str]:
    """What those words mean that occur in what is said of a check."""
    return {term: words for term, words in TERMS.items() if term in said}


def _killed_by(check: str) -> list[str]:
    """Faults whose killing input is this check."""
    from leakref.certify.strength.faults import FAULTS

    return [fault.id for fault in FAULTS.values() if fault.killing_input.partition("[")[0] == check]


def _family(identifier: str) -> Explanation | None:
    """What a family of checks is about, and which belong to it."""
    from leakref.certify.checks.registry import FAMILIES
    from leakref.certify.runner import select

    if identifier not in FAMILIES:
        return None
    checks = dict.fromkeys(c.id for c, _ in select([identifier]))
    return {"id": identifier, "kind": "a family of checks", "about": FAMILIES[identifier], "checks": list(checks)}


def _fault(identifier: str) -> Explanation | None:
    """What is wrong in the faulty code, and the changes that make it so."""
    from leakref.certify.strength.faults import FAULTS

    fault = FAULTS.get(identifier.removeprefix("fault:"))
    if fault is None:
        return None
    return {
        "id": fault.id,
        "kind": "a fault",
        "what_is_wrong": fault.words,
        "stage": fault.stage,
        "meant_for": fault.family,
        "witness": fault.killing_input,
        "changes": [f"{c.module}: {c.old!r} becomes {c.new!r}" for c in fault.changes],
        "try": f"leakref certify fault:{fault.id}",
    }


def _variant(identifier: str) -> Explanation | None:
    """What is different about a correct code, and the grade it deserves."""
    from leakref.certify.strength.variants import VARIANTS

    variant = VARIANTS.get(identifier.removeprefix("variant:"))
    if variant is None:
        return None
    return {
        "id": variant.id,
        "kind": "a correct alternative code, which must not be rejected",
        "words": variant.words,
        "grade": variant.grade,
        "try": f"leakref certify variant:{variant.id}",
    }


def _claim(identifier: str) -> Explanation | None:
    """The statement, how it was tested, and what came of it (`golden/claims.json`)."""
    from leakref.claims import CLAIMS
    from leakref.claims.stored import stored_claim, turned

    claim = CLAIMS.get(identifier)
    if claim is None:
        return None
    found = stored_claim(claim.id) or {}
    turns = [f"{row.get('variant', row.get('decision'))}" for row in turned(claim.id)]
    return {
        "id": claim.id,
        "kind": "a claim of the paper",
        "claim": claim.words,
        "label": claim.label,
        "tested": claim.test,
        "verdict": found.get("verdict"),
        "parts": found.get("parts"),
        "firm": found and ("yes" if found["robust"] else "no"),
        "depends_on": found.get("depends_on"),
        "figure": found.get("figure"),
        "turns_under": turns,
        "evaluate": f"leakref claims {claim.id} --figures",
    }


def _decision(identifier: str) -> Explanation | None:
    """The question, the reference's answer, and how far velocities move if it is answered otherwise."""
    from leakref.decisions import DECISIONS, PRACTICE

    decision = DECISIONS.get(identifier)
    if decision is None:
        return None
    return {
        "id": decision.id,
        "kind": "a decision",
        "question": decision.question,
        "reference": decision.reference,
        **({"co_author": PRACTICE[decision.id]} if decision.id in PRACTICE else {}),
        "where": f"leakref.{decision.where}",
        "measured": _shifts(decision.id),
        "all_of_it": f"leakref claims --decisions {decision.id}",
    }


def _shifts(identifier: str) -> list[str]:
    """How far each variant of a decision moves the velocities of unnoted shells, in a few words. Over all seas
    together, for each method and window.
    """
    from leakref.claims.stored import stored_decision
    from leakref.decisions import SLIPS

    found = stored_decision(identifier) or {}
    said = [found["no_effect"]] if found.get("no_effect") else []
    for variant in found.get("variants", ()):
        rows = [row for row in variant["rows"] if row["case"] == "all" and row["unflagged"]["shells"]]
        moves = [
            f"{row['method'].upper()} {row['window']} median {row['unflagged']['c0']['median']:.2g}, largest "
            f"{row['unflagged']['c0']['largest']:.2g} c0"
            for row in rows
        ]
        slip = f"; a slip and no choice: {SLIPS[variant['id']]}" if variant["id"] in SLIPS else ""
        said.append(f"{variant['words']} ({'; '.join(moves)}{slip})")
    return said


def _golden(identifier: str) -> Explanation | None:
    """What an entry is there for; None where no entry has that id."""
    from leakref.golden.sets import Golden

    try:
        entry = Golden().entry(identifier)
    except Damaged:
        raise
    except LeakrefError:
        return None
    record = entry.record
    kept: Callable[[str], Any] = record.get
    return {
        "id": entry.id,
        "kind": "a golden value",
        "stage": entry.stage,
        "there_for": kept("purpose"),
        "equation": kept("equation"),
        "difficulty": kept("difficulty"),
        "decisions": kept("decisions"),
        "file": f"golden/{entry.folder}/{entry.file}",
        "outputs": list(entry.output),
    }
