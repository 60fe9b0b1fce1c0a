"""`leakref reproduce`: the paper's cases as tables, data and figures."""

from __future__ import annotations

import csv
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from rich.console import Console
from rich.table import Table

from leakref import runs
from leakref._output import console, dump, envelope, folder, progress_bar, write_whole
from leakref.cases import configurations
from leakref.ensemble import Ensemble
from leakref.shell import Note

__all__ = ["run", "table"]


def run(ids: Sequence[str], *, realizations: int, figures: bool, out: Path, route: str, json: bool, workers: int = 1,
        scheduler: str = "") -> bool:
    """Run the configurations named by `ids`, write everything to `out`, print the tables; returns True.

    Realisations already in `out`, of the same source and settings, are not computed again.
    """
    chosen = configurations(ids)
    folder(out)
    done: list[Ensemble] = []
    where = runs.connected(scheduler) if scheduler else runs.pool(workers)
    with progress_bar("realisations", realizations * len(chosen)) as step, where as executor:
        for found in runs.run(chosen, realizations=realizations, route=route, folder=out / "parts", executor=executor,
                              after_each=step):
            done += found
            _write(out, found[0].configuration.id, found)
    result = envelope("reproduce", True, cases=[e.record() for e in done], route=route)
    write_whole(out / "reproduce.json", lambda path: path.write_text(dump(result) + "\n", encoding="utf-8"))
    drawn = _draw(out, done) if figures else []
    if json:
        print(dump(result))
    else:
        for configuration in chosen:
            Console().print(table([e for e in done if e.configuration is configuration]))
    console().print(f"[dim]{len(done)} tables (CSV), reproduce.json and {len(drawn)} figures in {out}[/dim]")
    return True


def _file_name(configuration_id: str) -> str:
    return configuration_id.replace("/", "_").replace(",", "_").replace("=", "")


def _write(out: Path, name: str, ensembles: Sequence[Ensemble]) -> None:
    """A CSV for each window and method, and the velocities of every realisation as an npz."""
    for e in ensembles:
        columns = {"wavenumber": e.wavenumbers, "bias": e.bias, "random": e.random, "mean_x": e.mean[:, 0],
                   "mean_y": e.mean[:, 1], "standard_error": e.standard_error,
                   "resolution_frequency": e.resolutions[0], "resolution_wavenumber": e.resolutions[1],
                   "realizations": e.count}

        def write(path: Path, columns: dict[str, np.ndarray] = columns) -> None:
            with path.open("w", newline="", encoding="utf-8") as stream:
                writer = csv.writer(stream)
                writer.writerow(columns)
                writer.writerows(zip(*(values.tolist() for values in columns.values()), strict=True))

        write_whole(out / f"{_file_name(name)}_{e.window}_{e.method}.csv", write)
    arrays: dict[str, Any] = {"wavenumbers": ensembles[0].wavenumbers}
    arrays |= {f"{e.window}_{e.method}_{what}": values for e in ensembles
              for what, values in (("velocities", e.velocities), ("notes", e.notes))}
    write_whole(out / f"{_file_name(name)}.npz",
                lambda path: np.savez(path, **arrays))


def _draw(out: Path, ensembles: Sequence[Ensemble]) -> list[Path]:
    from leakref.figures import result_figure, save

    groups: dict[str, list[Ensemble]] = {}
    for e in ensembles:
        if e.method == "nsp" or e.configuration.case == "nsp-ls":
            rotated = f"_rotated{e.configuration.rotation:g}" if e.configuration.rotation else ""
            groups.setdefault(e.configuration.case + rotated, []).append(e)
    drawn = []
    for name, members in groups.items():
        count, still = len(members[0].velocities), not any(e.configuration.speed for e in members)
        title = f"case {name.replace('_', ', ')}, {count} realisation{'s' * (count > 1)}"
        drawn += save(result_figure(members, title, logarithmic=still and count > 1), out / f"figure_{name}")
    return drawn


def table(ensembles: Sequence[Ensemble]) -> Table:
    """Bias and random part for each wavenumber, beside both resolutions; those beyond the smaller one in red."""
    first = ensembles[0]
    result = Table(title=f"{first.configuration.id}: mean ± standard deviation of |c|, in c0",
                   caption=_caption(ensembles), caption_justify="left")
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
    flagged = {name: sum(int(e.noted(note).sum()) for e in ensembles) for note in Note for name in note.names}
    shells = sum(e.notes.size for e in ensembles)
    said = ", ".join(f"{name} {count}" for name, count in flagged.items() if count) or "none"
    return (f"{len(ensembles[0].velocities)} realisations; red: the mean is beyond the smaller resolution; "
            f"notes among {shells} shells: {said}")
