"""`leakref plan`: from quantities with units to a table, advice, figures, JSON and CSV.

Options come as typed, with units, and are refused here with the option's name; the simulation is `plan`'s. Written are
`plan.json`, tables as CSV and figures; printed is a table and the advice, or the same as JSON.
"""

from __future__ import annotations

import csv
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from rich.box import SIMPLE_HEAD
from rich.console import Console

from leakref import runs
from leakref._base import LeakrefError
from leakref._output import console, dump, envelope, folder, progress_bar, write_whole
from leakref._tables import Table
from leakref.methods import DEFAULT, METHODS
from leakref.planning.advice import advice, scope
from leakref.planning.flight import default_realizations, work
from leakref.planning.plan import GRAVITY, Campaign, Expected, Plan, expected, plan, swept
from leakref.planning.quantities import CLEAN_WATER, DEEP_WATER, depth_words, number, quantity, tension_words

__all__ = ["PARAMETERS", "parse_sweep", "run"]

PARAMETERS = {
    "field-of-view": ("field_of_view", "m"),
    "duration": ("duration", "s"),
    "peak-wavelength": ("peak_wavelength", "m"),
    "direction": ("direction", "deg"),
    "spread": ("spread", "deg"),
    "gamma": ("peakedness", ""),
    "current": ("speed", "m/s"),
    "current-direction": ("current_direction", "deg"),
    "pixel": ("pixel", "m"),
    "frame-rate": ("frame_rate", "Hz"),
    "depth": ("depth", "m"),
    "surface-tension": ("surface_tension", "m^3/s^2"),
}
"""What can be swept over, as on the command line: the Campaign's name for it, and its unit."""
_WORDS = {("depth", "deep"): np.inf, ("surface-tension", "water"): CLEAN_WATER}
_MOST_VALUES = 40
_POOL = 60e6  # bins in all realisations together from which starting processes pays
_SHOWN = (1.5, 1.0, 0.5)  # wavelengths in a sweep's table, in those of the peak
_WINDOWS = {"box": "untapered", "hann": "Hann"}


def _value(option: str, text: str) -> float:
    """An option as a number in its unit, or a plain one if it has none; or a word that stands for one."""
    if (option, text.strip().lower()) in _WORDS:
        return _WORDS[option, text.strip().lower()]
    unit = PARAMETERS[option][1]
    example = "4m" if option == "depth" else None
    return quantity("plan", f"--{option}", text, unit, example) if unit else number("plan", f"--{option}", text)


def _campaign(given: Mapping[str, str | None]) -> Campaign:
    """From the options as typed; a rectangular area is written 128m x 96m. A current without a direction goes with the
    waves. Raises LeakrefError as the options are read.
    """
    values: dict[str, Any] = {
        PARAMETERS[name][0]: _value(name, text)
        for name, text in given.items()
        if text is not None and name != "field-of-view"
    }
    sides = [_value("field-of-view", side) for side in str(given["field-of-view"]).split("x")]
    if len(sides) > 2:
        raise LeakrefError(
            "plan",
            f"--field-of-view {given['field-of-view']} has {len(sides)} sides",
            "write it as in --field-of-view 128m, or '128m x 96m' along x and y",
        )
    values.setdefault("current_direction", values.get("direction", Campaign.direction))
    return Campaign(field_of_view=(sides[0], sides[-1]), **values)


def parse_sweep(text: str) -> tuple[str, list[float]]:
    """A parameter and its values from "spread=15deg:90deg:6", first, last and how many. Raises LeakrefError.

    Returned are the option's name (a key of `PARAMETERS`) and 2 to 40 equally spaced values in its unit.
    """
    name, _, values = text.partition("=")
    parts = values.split(":")
    if name not in PARAMETERS or len(parts) != 3:
        raise LeakrefError(
            "plan",
            f"--sweep {text} is not NAME=FIRST:LAST:HOW-MANY",
            f"write it as in --sweep spread=15deg:90deg:6; names are {', '.join(PARAMETERS)}",
        )
    if not parts[2].isdecimal() or not 2 <= int(parts[2]) <= _MOST_VALUES:
        raise LeakrefError(
            "plan",
            f"--sweep {text} asks for {parts[2]!r} values",
            f"ask for 2 to {_MOST_VALUES}: NAME=FIRST:LAST:HOW-MANY",
        )
    first, last = (_value(name, part) for part in parts[:2])
    if not np.isfinite([first, last]).all():
        raise LeakrefError("plan", f"--sweep {text} has no end", "give two numbers with their unit: depth=2m:20m:4")
    return name, np.linspace(first, last, int(parts[2])).tolist()


def run(
    given: Mapping[str, str | None],
    *,
    sweep: str | None,
    realizations: int | None,
    out: Path,
    workers: int,
    cores: int,
    json: bool,
    methods: Sequence[str] = DEFAULT,
) -> bool:
    """Simulate the campaign that the options describe, write everything to `out`, print it; returns True.

    `workers` 0 takes all `cores` where that pays. Raises LeakrefError.

    `given` are the options by name, None where they were left out; `sweep` as `parse_sweep` takes it. A sweep uses a
    third of the realisations for each value, but at least five, unless `realizations` says how many. The JSON has at
    its top what Hann and NSP give, arrays over wavelengths in m and m/s; under `campaign` what was asked for; under
    `ways` every window and method; under `enlarged` the level as asked for, with twice the area and with twice the
    duration; and the `recommendations` in words.
    """
    campaign = _campaign(given)
    name, values = parse_sweep(sweep) if sweep else ("", [])
    campaigns = swept(campaign, PARAMETERS[name][0], values) if sweep else []
    count = realizations or default_realizations(campaign.flight)
    fewer = realizations or max(5, count // 3)  # of each value of a sweep
    folder(out)
    total = count + 2 * max(2, count // 2) + fewer * len(campaigns)
    effort = 2 * count * work(campaign.flight) + sum(fewer * work(c.flight) for c in campaigns)
    with (
        progress_bar("realisations", total) as step,
        runs.pool(workers or (cores if effort > _POOL else 1)) as executor,
    ):
        found = plan(campaign, count, methods=methods, executor=executor, after_each=step)
        asked = tuple(dict.fromkeys(method for _, method in found.ways))
        sweeps = expected(campaigns, fewer, methods=asked, executor=executor, after_each=step) if campaigns else []
    record = _record(found, advice(found), count)
    if sweep:
        record["sweep"] = {
            "parameter": name,
            "unit": PARAMETERS[name][1],
            "realizations": fewer,
            "values": [
                {"value": value, "ways": [e.record() for e in ways.values()]}
                for value, ways in zip(values, sweeps, strict=True)
            ],
        }
    pictures = _write(out, found, record, name, values, sweeps)
    if json:
        print(dump(record))
    else:
        _show(found, record["recommendations"], name, values, sweeps)
    console().print(
        f"[dim]plan.json, {1 + bool(sweep)} table{'s' * bool(sweep)} (CSV) and {len(pictures)} pictures in {out}[/dim]"
    )
    return True


def _record(found: Plan, said: Sequence[str], count: int) -> dict[str, Any]:
    """The object of `--json`: at the top what Hann and NSP give, under `ways` all of them."""
    c, grid, scales = found.campaign, found.campaign.flight.grid, found.campaign.scales
    asked = {
        "field_of_view": c.field_of_view,
        "duration": c.duration,
        "peak_wavelength": c.peak_wavelength,
        "direction": c.direction,
        "spread": c.spread,
        "gamma": c.peakedness,
        "current": c.speed,
        "current_direction": c.current_direction,
        "pixel": [d * scales.length for d in grid.spacing[:2]],
        "frame_rate": 1 / (grid.spacing[2] * scales.time),
        "gravity": GRAVITY,
        "depth": DEEP_WATER if c.depth == np.inf else c.depth,
        "surface_tension": c.surface_tension,
        "phase_velocity": c.phase_velocity,
        "shape": grid.shape,
    }
    levels = [
        (what, e.level(), len(e.measured.velocities))
        for what, e in (
            ("as asked", found.best),
            ("twice the area", found.larger),
            ("twice the duration", found.longer),
        )
    ]
    return envelope(
        "plan",
        True,
        **found.best.record(),
        realizations=count,
        campaign=asked,
        true_current=found.best.measured.configuration.current * scales.velocity,
        units={"wavelengths": "m", "velocities": "m/s", "angles": "degrees"},
        definitions={
            "bias": "mean of |c - U|",
            "random": "standard deviation of |c - U|",
            "mean_error": "mean of c - U",
            "speed": "mean of |c|",
            "level": "bias, mean over the wavelengths up to the peak's",
        },
        ways=[e.record() for e in found.ways.values()],
        enlarged=[
            {"what": what, "level": level[0], "standard_error": level[1], "realizations": number}
            for what, level, number in levels
        ],
        recommendations=said,
        scope=scope(found).record(),
    )


def _columns(e: Expected) -> dict[str, Sequence[Any]]:
    """The columns of a CSV for one way to measure, by heading."""
    record = e.record()
    mean = np.asarray(record.pop("mean_error"))
    first = {"window": [e.window] * len(mean), "method": [e.method] * len(mean)}
    return {
        **first,
        **{name: np.asarray(values).tolist() for name, values in record.items() if name not in first},
        "mean_error_x": mean[:, 0].tolist(),
        "mean_error_y": mean[:, 1].tolist(),
    }


def _table(path: Path, rows: Sequence[tuple[dict[str, Any], Expected]]) -> None:
    """One CSV: for each (leading columns, way) a row a wavelength; metres and metres a second."""

    def write(beside: Path) -> None:
        with beside.open("w", newline="", encoding="utf-8") as stream:
            writer = csv.writer(stream)
            writer.writerow([*rows[0][0], *_columns(rows[0][1])])
            for leading, e in rows:
                writer.writerows([*leading.values(), *row] for row in zip(*_columns(e).values(), strict=True))

    write_whole(path, write)


def _title(c: Campaign, swept: str = "") -> str:
    """What was asked for, in a line, for the pictures; but for the parameter that is `swept`, which has many values."""
    sides = dict.fromkeys(f"{side:.4g}" for side in c.field_of_view)
    current = f"current {c.speed:.3g} m/s at {c.current_direction:.4g}°" if c.speed else "no current"
    if swept in ("current", "current-direction"):
        current = f"current at {c.current_direction:.4g}°" if swept == "current" else f"current {c.speed:.3g} m/s"
    said = {
        "field-of-view": f"{' x '.join(sides)} m",
        "duration": f"for {c.duration:.4g} s",
        "peak-wavelength": f"waves of {c.peak_wavelength:.4g} m",
        "direction": f"going to {c.direction:.4g}°",
        "spread": f"spread {c.spread:.4g}°",
        "gamma": rf"$\gamma$ = {c.peakedness:.3g}",
        "depth": depth_words(c.depth),
        "surface-tension": tension_words(c.surface_tension),
    }
    return ", ".join([*(words for name, words in said.items() if words and name != swept), current])


def _write(
    out: Path,
    found: Plan,
    record: Mapping[str, Any],
    name: str,
    values: Sequence[float],
    sweeps: Sequence[Mapping[tuple[str, str], Expected]],
) -> list[Path]:
    """Everything to the folder; the pictures' paths.

    `plan.json`, `plan.csv`, the figure, and of a sweep another table and figure; the first column of that table is the
    parameter.
    """
    from leakref.figures import save
    from leakref.planning.figures import plan_figure, sweep_figure

    write_whole(out / "plan.json", lambda path: path.write_text(dump(record) + "\n", encoding="utf-8"))
    _table(out / "plan.csv", [({}, e) for e in found.ways.values()])
    pictures = save(plan_figure(found, _title(found.campaign)), out / "plan")
    if sweeps:
        _table(
            out / "plan_sweep.csv",
            [({name: value}, e) for value, ways in zip(values, sweeps, strict=True) for e in ways.values()],
        )
        unit, words = PARAMETERS[name][1], name.replace("-", " ")
        label = f"{words} ({unit})" if unit else words
        count = len(sweeps[0]["hann", "nsp"].measured.velocities)
        title = f"Sweep over the {words}, {count} realisations of each: {_title(found.campaign, name)}"
        pictures += save(sweep_figure(label, values, sweeps, title), out / "plan_sweep")
    return pictures


def _show(
    found: Plan,
    said: Sequence[str],
    name: str,
    values: Sequence[float],
    sweeps: Sequence[Mapping[tuple[str, str], Expected]],
) -> None:
    """The table, green where a wavelength can be trusted, the sweep, and the advice."""
    show = Console()
    methods = list(dict.fromkeys(method for _, method in found.ways))
    for first in range(0, len(methods), 2):  # wider is no table any more
        show.print(_ways_table(found, methods[first : first + 2]))
    if sweeps:
        show.print(_sweep_table(name, values, sweeps))
    for sentence in said:
        show.print(f"- {sentence}", soft_wrap=True, highlight=False)
    for sentence in (scope(found).words, scope(found).advice):
        show.print(f"{sentence}.", soft_wrap=True, highlight=False, markup=False)


def _ways_table(found: Plan, methods: Sequence[str]) -> Table:
    """Errors by both windows and some methods, green where a wavelength can be trusted."""
    best = found.best
    count = len(best.measured.velocities)
    words = (depth_words(found.campaign.depth), tension_words(found.campaign.surface_tension))
    in_water = ", ".join(word for word in words if word)
    table = Table(
        title=f"Expected errors |c - U| in m/s, {in_water}: mean ± standard deviation",
        title_justify="left",
        caption=f"{count} simulated flights, so that the mean is uncertain by the deviation over "
        f"{np.sqrt(count):.1f}. Green: mean and twice the deviation are within the smaller of the velocity "
        "resolutions, domega / k and cg dk / k" + ", and of the current." * bool(found.campaign.speed),
        caption_justify="left",
        box=SIMPLE_HEAD,
        pad_edge=False,
        padding=(0, 1, 0, 0),
    )
    for heading in ("length\n(m)", *(f"{words}\n{METHODS[m].title}" for m in methods for words in _WINDOWS.values())):
        table.add_column(heading, justify="right")
    for heading in ("domega\n/ k", "cg dk\n/ k"):
        table.add_column(heading, justify="right", style="dim")
    for row, wavelength in enumerate(best.wavelengths):
        cells = [
            f"[green]{text}[/green]" if e.trusted[row] else text
            for e in (found.ways[window, m] for m in methods for window in _WINDOWS)
            for text in [f"{e.bias[row]:.3f}±{e.random[row]:.3f}"]
        ]
        table.add_row(f"{wavelength:.2f}", *cells, *(f"{values[row]:.3f}" for values in best.resolutions))
    return table


def _sweep_table(name: str, values: Sequence[float], sweeps: Sequence[Mapping[tuple[str, str], Expected]]) -> Table:
    """Bias at three wavelengths for each value, untapered and tapered, by NSP. Nearest is in the ratio of wavelengths,
    not in their difference.
    """
    unit = PARAMETERS[name][1]
    count = len(sweeps[0]["hann", "nsp"].measured.velocities)
    table = Table(
        title="Mean of |c - U| by NSP in m/s ± its standard error, at about 1.5, 1 and 0.5 of the peak's wavelength",
        title_justify="left",
        caption=f"{count} realisations of each value.",
        caption_justify="left",
        box=SIMPLE_HEAD,
        pad_edge=False,
        padding=(0, 1, 0, 0),
    )
    table.add_column(f"{name}\n({unit})" if unit else name, justify="right")
    for share in _SHOWN:
        for words in ("untapered", "Hann"):
            table.add_column(f"{share:g}\n{words}", justify="right")
    for value, ways in zip(values, sweeps, strict=True):
        cells = []
        for share in _SHOWN:
            peak = 2 * np.pi * ways["hann", "nsp"].scales.length
            at = int(np.abs(np.log(ways["hann", "nsp"].wavelengths / (share * peak))).argmin())
            for e in (ways[window, "nsp"] for window in ("box", "hann")):
                cells.append(f"{e.bias[at]:.3f}±{e.standard_error[at]:.3f}")
        table.add_row(f"{value:.4g}", *cells)
    return table
