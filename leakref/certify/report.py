"""The certificate as a page to send to a colleague, and as a badge.

The page and the badge are templates in `pages/`; nothing in them is fetched from elsewhere, and all words of an
implementation are escaped. Arrows are drawn as SVG from the figures that a finding carries: what should have come out,
and what did. The module computes nothing that is not in the certificate.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from leakref import __version__
from leakref._base import FloatArray
from leakref._output import template
from leakref.certify.certificate import CONFORMANT, NO_GRADE, REJECTED, Certificate
from leakref.certify.checks.registry import FAMILIES, Check
from leakref.certify.runner import select
from leakref.certify.subject.declaration import GIVEN
from leakref.certify.verdict import Finding, Verdict

__all__ = ["badge", "page", "sentence"]

_COLOURS = {"conformant": "#00695c", "sound": "#00695c", "rejected": "#b3261e", NO_GRADE: "#8a6100"}
_SENSORS = ("noise", "a camera that moves")
_MOST = 12  # wavenumbers in a drawing


def sentence(certificate: Certificate) -> str:
    """What the grade means, and what it rests on.

    It is what the command prints after the grade, and what stands at the top of the page. How many questions that were
    stands in the grade line beside it.
    """
    n, missing = len(certificate.judged), certificate.coverage["missing"]
    if certificate.grade == REJECTED:
        wrong = len(certificate.wrong)
        return f"{wrong} of {n} answers {'is' if wrong == 1 else 'are'} wrong."
    if certificate.unasked:
        return f"The run was {certificate.cut_short}: there is no verdict."
    if not n:
        return "Nothing that was asked is offered." if not missing else "It answered nothing of what it offers."
    if certificate.thin:
        if not all(admitted for _, _, admitted in certificate.thin):
            return "Nothing of the signs could be asked of it: which way its velocities point is not known."
        told = ", ".join(f"{judged} of {admitted} in {family}" for family, judged, admitted in certificate.thin)
        return f"Too little was answered of what it offers: {told}. Of each at least half must be."
    refused = f" To {missing} it gave no answer, though it offers one." if missing else ""
    if certificate.grade == CONFORMANT:
        rest = certificate.coverage["unsupported"]
        more = f"; {rest} are about what it does not offer" if rest else ""
        return f"All {n} that were judged agree with the reference{more}." if n > 1 else "It agrees with the reference."
    if any(f.family == "conformance" for f in certificate.wrong):
        return f"Another algorithm than the reference, and right wherever any algorithm must be.{refused}"
    compared = any(f.family == "conformance" for f in certificate.judged)
    return f"Right wherever it was judged{'' if compared else ', and compared with no golden value'}.{refused}"


def page(certificate: Certificate, pictures: Sequence[Mapping[str, Any]] = ()) -> str:
    """One self-contained page of HTML, readable without scripts. `pictures`: title, words, and data, PNG in base64; a
    `table` of `head` and `rows` stands above where there is one.

    First stands what was certified: grade, coverage, scope, diagnosis, whose it is and when. Findings follow by family;
    of each check the first one that is wrong is open, the others are folded away, and what is unsupported is one line.
    """
    known = {f"{c.id}[{case.id}]": c for c, case in select(golden=certificate.set_number)}
    first = {f.id.partition("[")[0]: f for f in reversed(certificate.wrong)}  # of each check: these are opened
    rows = []
    for family, _ in certificate.families():
        own = [f for f in certificate.findings if f.family == family]
        asked = [_row(f, known.get(f.id), f in first.values()) for f in own if f.verdict is not Verdict.UNSUPPORTED]
        rows.append((family, asked, [f for f in own if f.verdict is Verdict.UNSUPPORTED]))
    return template("certificate.html").render(
        certificate=certificate,
        said=certificate.declaration,
        scope=certificate.scope()["words"],
        untested=_untested(certificate),
        version=__version__,
        pictures=pictures,
        grade_class=certificate.grade or "unjudged",
        sentence=sentence(certificate),
        families=FAMILIES,
        findings=rows,
        verdicts=[str(v) for v in Verdict if str(v) in certificate.counts],
        declared=list(_declared(certificate.declaration)),
    )


def badge(certificate: Certificate) -> str:
    """A small SVG with the grade line: the grade, and of how many questions it is.

    Its width follows the length of the words. The text of the file is returned.
    """
    line, colour = certificate.grade_line, _COLOURS[certificate.grade or NO_GRADE]
    return template("badge.svg").render(grade=line, width=62 + round(6.4 * len(line)), colour=colour)


def _untested(certificate: Certificate) -> str:
    """What no question was about: other depths unless several were shown, tension unless waves felt it, sensors."""
    scope = certificate.scope()
    words = ["other depths"] if scope["depth"] != "deep and finite" else []
    words += [] if scope["surface_tension"] else ["surface tension"]
    sensors = ["poor sensors beyond what stands below under stress"] if certificate.stress else _SENSORS
    said = ", ".join([*words, "breaking or nonlinear waves", *sensors])
    return said[0].upper() + said[1:]


def _declared(said: Mapping[str, Any]) -> Iterator[tuple[str, str]]:
    """The declaration in rows of a name and words, for the table on the page."""
    for name in ("units", "axes", "y", "direction"):
        yield name, str(said[name])
    yield "fixed", ", ".join(said["fixed"]) or "nothing"
    if said.get("cube"):
        for name, value in said["cube"].items():
            if name == "duration":
                yield "cube: shortest record", f"{value:g}" + (" s" if said["units"] == "si" else " / omega0")
                continue
            sizes = f"{value} samples along each axis" if name == "multiple" else " x ".join(map(str, value))
            yield f"cube: {name}", sizes + " samples along x, y, t" * (name != "multiple")
    for name, value in (said.get("waves") or {}).items():
        words = "{:g} to {:g} m".format(*value) if name == "peak_wavelength" else f"{value:g} m/s"
        yield {"peak_wavelength": "waves", "fastest": "fastest current"}[name], words
    for name, value in (said.get("water") or {}).items():
        yield name.replace("_", " "), "given with each run" if value == GIVEN else f"{value:.4g}, in the code"
    for stage, what in said["can"].items():
        told = "; ".join(
            f"{name} {', '.join(map(str, v)) or 'none' if isinstance(v, list | tuple) else v}"
            for name, v in what.items()
        )
        yield stage, told or "offered"


def _row(finding: Finding, check: Check | None, is_open: bool) -> dict[str, Any]:
    """What the template needs of one finding: itself, its check's reason and tolerance, and drawings of its figures."""
    drawings = list(_drawings(finding.figures, finding.over or 0.0))
    return {
        "finding": finding,
        "reason": check.reason if check else "",
        "open": is_open,
        "tolerance": check.tolerance if check else "",
        "drawings": drawings,
    }


def _drawings(figures: Mapping[str, Any], over: float, title: str = "velocities") -> Iterator[dict[str, Any]]:
    """Arrows of every part of the figures that has velocities (n, 2) and what they should be; `over` of the finding.
    Figures may hold figures of several methods or windows: each part that has velocities is drawn.
    """
    if {"wavenumbers", "velocities", "should_be"} <= set(figures):
        labels = [f"k = {k:.3g}" for k in figures["wavenumbers"]]
        yield _arrows(
            title, labels, figures["velocities"], figures["should_be"], figures.get("over", np.full(len(labels), over))
        )
        return
    if {"velocity", "should_be"} <= set(figures):
        yield _arrows(title, ["mean"], [figures["velocity"]], [figures["should_be"]], [over])
        return
    for name, part in figures.items():
        if isinstance(part, Mapping):
            yield from _drawings(part, over, str(name))


def _arrows(title: str, labels: Sequence[str], *values: npt.ArrayLike) -> dict[str, Any]:
    """`values`: found (n, 2), should be (n, 2), effect over tolerance (n,). All arrows are drawn to one scale, the
    longest 45 units; at most `_MOST` wavenumbers are shown. Red are those that are beyond the tolerance.
    """
    found, should, over = (np.asarray(value, dtype=np.float64) for value in values)
    longest = np.nanmax(np.abs(np.concatenate([found, should])), initial=1e-12)
    x = 60 + 110 * np.arange(len(labels))

    def end(n: int, c: FloatArray) -> tuple[float, float]:
        u, v = np.nan_to_num(c) / longest * 45
        return round(float(x[n] + u), 1), round(float(55 - v), 1)

    arrows = []
    for n, label in enumerate(labels[:_MOST]):
        (tx, ty), (fx, fy) = end(n, should[n]), end(n, found[n])
        arrows.append(
            {
                "x": int(x[n]),
                "tx": tx,
                "ty": ty,
                "fx": fx,
                "fy": fy,
                "label": label,
                "colour": "#b3261e" if over[n] > 1 else "#00695c",
            }
        )
    return {"title": title, "width": 120 + 110 * max(0, len(arrows) - 1), "arrows": arrows}
