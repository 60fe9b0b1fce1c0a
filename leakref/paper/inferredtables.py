"""What leakage does to an inferred depth, as JSON, as a table and in words; and the run over all domains of case-L-T.

`leakref reproduce depth` adds what is here to its cases: `inferred`, then `fields`, `shown` and `drawn`. `leakref
reproduce inferred-depth` goes through all depths and domains and writes `inferred_depth.json`. All numbers are parts of
the true depth.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from concurrent.futures import Executor
from pathlib import Path
from typing import Any

import numpy as np
from rich.box import SIMPLE_HEAD
from rich.console import Console

from leakref import runs
from leakref._base import LeakrefError, mean_of_known
from leakref._output import console, dump, envelope, folder, progress_bar, write_whole
from leakref._tables import Table
from leakref.cases import Configuration
from leakref.paper.inferred import ALIKE, BAND, DEPTHS, DOMAINS, WAVENUMBERS, Depths, domain, ensembles
from leakref.shell import Note

__all__ = ["NAME", "answer", "drawn", "fewer", "fields", "inferred", "record", "rows", "run", "shown", "table"]

NAME = "inferred-depth"
"""Of the run over all depths and domains, as `leakref reproduce` takes it."""
_WORDS = {"box": "untapered", "hann": "tapered"}


def rows(found: Sequence[Depths]) -> list[dict[str, Any]]:
    """As in the JSON of `leakref reproduce depth`: the band's depth, the current inferred along, a row a window.

    `bias` and `random` are the mean of h / h_true - 1 and its standard deviation, null where no realisation (or only
    one) has a number; `count` of `realizations` have one.
    """
    return [
        {
            "kh": e.configuration.depth,
            "window": e.window,
            "bias": float(e.bias[BAND]),
            "random": float(e.random[BAND]),
            "count": int(e.count[BAND]),
            "realizations": len(e.depths),
        }
        for e in found
        if e.current == "along"
    ]


def record(e: Depths) -> dict[str, Any]:
    """All statistics of one ensemble for JSON: of the shells (lists), of the band, and of it with all alike.

    `current_x` and `current_y` are means of the velocity, which is zero in truth; `curvature` is the median of that of
    N over ln h.
    """
    velocity = mean_of_known(e.velocities)
    known = np.where(np.isfinite(e.curvature), e.curvature, 0.0)
    each = {"bias": e.bias, "random": e.random, "count": e.count, "current_x": velocity[:, 0],
            "current_y": velocity[:, 1], "curvature": np.median(known, axis=0)}  # fmt: skip
    c = e.configuration
    return {
        "case": c.id,
        "kh": c.depth,
        "length": c.length,
        "duration": c.duration,
        "window": e.window,
        "current": e.current,
        "realizations": len(e.depths),
        "shells": {"wavenumbers": WAVENUMBERS, "resolution": e.resolution}
        | {name: values[:BAND] for name, values in each.items()},
        "band": {name: values[BAND] for name, values in each.items()},
        "band_alike": {name: values[ALIKE] for name, values in each.items()},
        "flagged": {name: e.noted(note) for note in Note for name in note.names if e.noted(note).any()},
    }


def answer(found: Iterable[dict[str, Any]]) -> str:
    """What leakage does to the depth of the band, a sentence a window; of `rows`."""
    found, said = list(found), []
    for window, words in _WORDS.items():
        parts = [f"k0 h = {row['kh']:g}: {_part(row)}" for row in found if row["window"] == window]
        if parts:
            said.append(f"The depth inferred along with the current, {words}: {'; '.join(parts)}.")
    return " ".join(said)


def _part(row: dict[str, Any]) -> str:
    """Bias and standard deviation in percent; or in how many realisations there is no depth, if in most."""
    missing = row["realizations"] - row["count"]
    if 2 * row["count"] < row["realizations"]:
        return f"none in {missing} of {row['realizations']}, where it cannot be told apart"
    random = "" if not np.isfinite(row["random"]) else f" ± {100 * row['random']:.1f}"
    return f"{100 * row['bias']:+.1f}{random} %" + (f" (none in {missing})" if missing else "")


def table(found: Sequence[Depths], title: str) -> Table:
    """Mean and standard deviation of h / h_true - 1 in percent: a row a wavenumber, a column a window and current.

    Then the band, each bin by its magnitude and each wavenumber alike. In brackets how many have a depth, if not all.
    """
    result = Table(
        title=title,
        title_justify="left",
        box=SIMPLE_HEAD,
        caption=f"error of the depth in %, mean ± standard deviation of {len(found[0].depths)} realisations; in "
        "brackets how many have a depth, if not all; alike: every wavenumber has one say",
        caption_justify="left",
    )
    result.add_column("k / k0")
    for e in found:
        current = "current inferred" if e.current == "along" else "current known"
        result.add_column(f"{_WORDS.get(e.window, e.window)},\n{current}", justify="right")
    for n, place in enumerate((*(f"{k:.1f}" for k in WAVENUMBERS), "band", "band, alike")):
        result.add_row(place, *(_cell(e, n) for e in found))
    return result


def _cell(e: Depths, place: int) -> str:
    count, every, digits = int(e.count[place]), len(e.depths), 0 if abs(e.bias[place]) >= 0.1 else 1
    if not count:
        return "none"
    random = f" ± {100 * e.random[place]:.{digits}f}" if count > 1 else ""
    return f"{100 * e.bias[place]:+.{digits}f}{random}" + (f" ({count})" if count < every else "")


# ---- beside the cases of `leakref reproduce depth`


def inferred(
    chosen: Sequence[Configuration], realizations: int, *, folder: Path | None, executor: Executor | None
) -> list[Depths]:
    """The depths inferred in those `chosen` that are of case depth, once in each sea; none of others."""
    members = [c for c in chosen if c.case == "depth" and np.isfinite(c.depth) and getattr(c, "assumed", None) is None]
    if not members:
        return []
    found = []
    with progress_bar("inferred depths", realizations * len(members)) as step:
        for c in members:
            found += ensembles(c, realizations, folder=folder, executor=executor, after_each=step)
    return found


def fields(found: Sequence[Depths]) -> dict[str, Any]:
    """What the JSON of `leakref reproduce` gains by them; nothing if there are none."""
    return {"inferred_depth": rows(found), "inferred_depth_answer": answer(rows(found))} if found else {}


def shown(found: Sequence[Depths]) -> None:
    """Print a table a sea, and the answer; nothing if there are none."""
    for id in dict.fromkeys(e.configuration.id for e in found):
        Console().print(table([e for e in found if e.configuration.id == id], f"{id}: the depth inferred"))
    if found and len({(e.configuration.length, e.configuration.duration) for e in found}) == 1:
        Console().print(answer(rows(found)), soft_wrap=True, highlight=False)


def drawn(out: Path, found: Sequence[Depths]) -> list[Path]:
    """The figures of them in the folder `out`, PNG and SVG each; none if there is nothing to draw."""
    if not found:
        return []
    from leakref.paper.inferredfigure import draw

    return draw(out, [record(e) for e in found])


# ---- all depths and domains


def fewer(realizations: int, length: float, duration: float) -> int:
    """How many realisations of a domain there are in a run of so many: a fifth of the largest, which takes long."""
    return max(2, realizations // 5) if (length, duration) == (20.0, 80.0) else realizations


def run(ids: Sequence[str], *, realizations: int, figures: bool, out: Path, json: bool, workers: int = 1) -> bool:
    """All depths on all domains of case-L-T: `inferred_depth.json` in `out`, tables, figures if asked for; True.

    Realisations already in `out` are not computed again. Raises LeakrefError if something else is named beside it.
    """
    if list(ids) != [NAME]:
        raise LeakrefError("reproduce", f"{NAME} beside other cases", f"run `leakref reproduce {NAME}` by itself")
    seas = [(domain(kh, *size), fewer(realizations, *size)) for size in DOMAINS for kh in DEPTHS]
    found: list[Depths] = []
    folder(out)
    with progress_bar("inferred depths", sum(number for _, number in seas)) as step, runs.pool(workers) as executor:
        for c, number in seas:
            found += ensembles(c, number, folder=out / "parts", executor=executor, after_each=step)
    result = envelope("reproduce", True, realizations=realizations, depths=[record(e) for e in found])
    write_whole(out / "inferred_depth.json", lambda path: path.write_text(dump(result) + "\n", encoding="utf-8"))
    paths = drawn(out, found) if figures else []
    if json:
        print(dump(result))
    else:
        shown(found)
    console().print(f"[dim]inferred_depth.json and {len(paths)} figures in {out}[/dim]")
    return True
