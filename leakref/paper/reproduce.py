"""`leakref reproduce`: the paper's cases as tables, data and figures.

Everything that a run computes is written: tables as CSV, velocities and notes as npz, one JSON of all, and figures if
asked for. Parts lie in `OUT/parts`, from where `claims` and a second run take them.
"""

from __future__ import annotations

import csv
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from rich.box import SIMPLE_HEAD
from rich.console import Console

from leakref import runs
from leakref._output import console, dump, envelope, folder, progress_bar, write_whole
from leakref._tables import Table
from leakref.cases import ASSUMED_DEEP, Configuration, configurations
from leakref.dispersion import DEEP
from leakref.ensemble import Ensemble
from leakref.methods import DEFAULT
from leakref.paper import depth, inferredtables
from leakref.paper.shear import DIRECTIONS, Inferred, Sheared, answer, inferred, sheared
from leakref.shell import Note

__all__ = ["run", "table"]


def _named(ids: Sequence[str]) -> list[Configuration]:
    """Configurations of the paper and of cases shear and depth, in order and once. Raises LeakrefError for an unknown
    id. Case depth is measured twice: with the depth known, and taken for deep.
    """
    found = [c for name in ids for c in (sheared(name) or configurations([name]))]
    found += ASSUMED_DEEP if depth.CASE in ids else ()
    return list({c.id: c for c in found}.values())


def run(
    ids: Sequence[str],
    *,
    realizations: int,
    figures: bool,
    out: Path,
    route: str,
    json: bool,
    workers: int = 1,
    scheduler: str = "",
    everything: bool = False,
    methods: Sequence[str] = DEFAULT,
) -> bool:
    """Run the configurations named by `ids`, write everything to `out`, print the tables; returns True.

    Realisations already in `out`, of the same source and settings, are not computed again. With `everything`, `figures`
    are those of the paper that show no results as well.

    `route` is `A` or `B`; `scheduler` the address of a dask cluster, which goes before `workers`. LeakrefError is
    raised for an unknown id and for what `runs` refuses. For case shear there is also a table of inferred shears, and
    the answer in words; for case depth one of what it costs to take the water for deep.
    """
    if inferredtables.NAME in ids:
        return inferredtables.run(ids, realizations=realizations, figures=figures, out=out, json=json, workers=workers)
    chosen = _named(ids)
    folder(out)
    done: list[Ensemble] = []
    where = runs.connected(scheduler) if scheduler else runs.pool(workers)
    with progress_bar("realisations", realizations * len(chosen)) as step, where as executor:
        for found in runs.run(
            chosen,
            realizations=realizations,
            methods=methods,
            route=route,
            folder=out / "parts",
            executor=executor,
            after_each=step,
        ):
            done += found
            _write(out, found[0].configuration.id, found)
        depths = inferredtables.inferred(chosen, realizations, folder=out / "parts", executor=executor)
    shears = [row for e in done if isinstance(e.configuration, Sheared) for row in inferred(e)]
    result = envelope("reproduce", True, cases=[_record(e) for e in done], route=route)
    if wrong := depth.mistakes(done):
        result |= {"assumed_deep": [row.record() for row in wrong]}
    if shears:
        result |= {"shear": [row.record() for row in shears], "answer": answer(shears)}
    result |= inferredtables.fields(depths)
    write_whole(out / "reproduce.json", lambda path: path.write_text(dump(result) + "\n", encoding="utf-8"))
    drawn = _draw(out, done, realizations, everything) + inferredtables.drawn(out, depths) if figures else []
    if json:
        print(dump(result))
    else:
        for configuration in chosen:
            if not isinstance(configuration, Sheared):
                Console().print(table([e for e in done if e.configuration is configuration]))
        if wrong:
            Console().print(depth.mistakes_table(wrong, realizations))
        if shears:
            Console().print(_shear_table(shears, realizations))
            Console().print(answer(shears), soft_wrap=True, highlight=False)
        inferredtables.shown(depths)
    console().print(f"[dim]{len(done)} tables (CSV), reproduce.json and {len(drawn)} figures in {out}[/dim]")
    return True


def _file_name(configuration_id: str) -> str:
    """An id as part of a file's name: `gamma_spread15_peakedness7`."""
    return configuration_id.replace("/", "_").replace(",", "_").replace("=", "")


def _write(out: Path, name: str, ensembles: Sequence[Ensemble]) -> None:
    """A CSV for each window and method, and the velocities of every realisation as an npz. Arrays in the npz are named
    `WINDOW_METHOD_velocities` (R, n, 2) and `..._notes` (R, n).
    """
    for e in ensembles:
        columns = {
            "wavenumber": e.wavenumbers,
            "bias": e.bias,
            "random": e.random,
            "mean_x": e.mean[:, 0],
            "mean_y": e.mean[:, 1],
            "standard_error": e.standard_error,
            "resolution_frequency": e.resolutions[0],
            "resolution_wavenumber": e.resolutions[1],
            "realizations": e.count,
        }

        def write(path: Path, columns: dict[str, np.ndarray] = columns) -> None:
            with path.open("w", newline="", encoding="utf-8") as stream:
                writer = csv.writer(stream)
                writer.writerow(columns)
                writer.writerows(zip(*(values.tolist() for values in columns.values()), strict=True))

        write_whole(out / f"{_file_name(name)}_{e.window}_{e.method}.csv", write)
    arrays: dict[str, Any] = {"wavenumbers": ensembles[0].wavenumbers}
    arrays |= {
        f"{e.window}_{e.method}_{what}": values
        for e in ensembles
        for what, values in (("velocities", e.velocities), ("notes", e.notes))
    }
    write_whole(out / f"{_file_name(name)}.npz", lambda path: np.savez(path, **arrays))


def _record(e: Ensemble) -> dict[str, Any]:
    """With the profile and its truth, if the current is sheared: `current` is then that at the surface. Where the
    water is not deep also its depth and tension, and the depth that the velocities were measured with, null if none.
    """
    c = e.configuration
    said: dict[str, Any] = {"profile": c.profile, "truth": c.truth} if isinstance(c, Sheared) else {}
    if c.water != DEEP:
        assumed = c.measured_in.depth
        said |= {"depth": c.depth, "surface_tension": c.surface_tension, "assumed_depth": assumed}
    return e.record() | said


def _draw(out: Path, ensembles: Sequence[Ensemble], realizations: int, everything: bool) -> list[Path]:
    """Paths of all pictures; of cases shear and depth one each of its own."""
    from leakref.figures import save
    from leakref.paper.figures import draw_illustrations, draw_results

    over_bottom = [e for e in ensembles if e.configuration.case == depth.CASE]
    others = [e for e in ensembles if not isinstance(e.configuration, Sheared) and e not in over_bottom]
    drawn = draw_results(out, others, realizations)
    if everything:
        drawn += draw_illustrations(out)
    of_shear = [e for e in ensembles if isinstance(e.configuration, Sheared)]
    paths = [path for one in drawn for path in one["files"]]
    count = f"{realizations} realisation{'s' * (realizations > 1)}"
    if len({e.method for e in ensembles}) > 2 and len({e.configuration.id for e in ensembles}) > 1:
        from leakref.paper.methodsfigure import methods_figure

        paths += save(methods_figure(ensembles, f"from the peak up, {count}"), out / "figure_methods")
    if over_bottom:
        from leakref.paper.depthfigure import depth_figure

        words = f"What it costs to take water for deep: errors in still water, {count}"
        paths += save(depth_figure(over_bottom, words), out / "figure_depth")
    if of_shear:
        from leakref.paper.shearfigure import shear_figure

        words = f"sheared currents by NSP, {realizations} realisation{'s' * (realizations > 1)}"
        paths += save(shear_figure(of_shear, words), out / "figure_shear")
    return paths


def _shear_table(rows: Sequence[Inferred], realizations: int) -> Table:
    """The shear inferred along the current by profile, direction, band, method and window, beside the true one."""
    result = Table(
        title="Shear inferred along the current, in c0 k0: mean ± standard deviation",
        caption=f"{realizations} realisations; slope of velocities over effective depths -1 / 2k",
        caption_justify="left",
        title_justify="left",
        box=SIMPLE_HEAD,
    )
    for heading in ("profile", "current", "band", "method"):
        result.add_column(heading)
    for heading in ("true", "untapered", "Hann"):
        result.add_column(heading, justify="right")
    by_window: dict[tuple[Any, ...], dict[str, Inferred]] = {}
    for row in rows:
        key = (row.profile, DIRECTIONS[row.direction], "all" if row.band == "all" else "k >= 1", row.method)
        by_window.setdefault(key, {})[row.window] = row
    for key, found in by_window.items():
        cells = [f"{found[name].mean:+.3f} ± {found[name].random:.3f}" for name in ("box", "hann")]
        result.add_row(*key, f"{found['box'].true:.3f}", *cells)
    return result


def table(ensembles: Sequence[Ensemble]) -> Table:
    """Bias and random part for each wavenumber, beside both resolutions; those beyond the smaller one in red.

    `ensembles` are those of one configuration, a column each; the notes of all are counted in the caption. With a
    current nothing is red, since |c| is no error then.
    """
    first = ensembles[0]
    result = Table(
        title=f"{first.configuration.id}: mean ± standard deviation of |c|, in c0",
        caption=_caption(ensembles),
        caption_justify="left",
    )
    result.add_column("k / k0", justify="right")
    for e in ensembles:
        result.add_column(f"{e.window} {e.method}", justify="right")
    for what in ("domega / k", "cg dk / k"):
        result.add_column(what, justify="right", style="dim")
    frequency, wavenumber = first.resolutions
    for row, k in enumerate(first.wavenumbers):
        cells = []
        for e in ensembles:
            text = f"{e.bias[row]:.4f} ± {e.random[row]:.4f}"
            beyond = not e.bias[row] <= min(frequency[row], wavenumber[row])
            cells.append(f"[red]{text}[/red]" if beyond and not first.configuration.speed else text)
        result.add_row(f"{k:.2f}", *cells, f"{frequency[row]:.4f}", f"{wavenumber[row]:.4f}")
    return result


def _caption(ensembles: Sequence[Ensemble]) -> str:
    """Realisations, what is red, and how often each note was made."""
    flagged = {name: sum(int(e.noted(note).sum()) for e in ensembles) for note in Note for name in note.names}
    shells = sum(e.notes.size for e in ensembles)
    said = ", ".join(f"{name} {count}" for name, count in flagged.items() if count) or "none"
    return (
        f"{len(ensembles[0].velocities)} realisations; red: the mean is beyond the smaller resolution; "
        f"notes among {shells} shells: {said}"
    )
