"""`leakref bench`: what each stage costs, as ratios within one run and as shares of what the machine could do.

A time in seconds says little: so each row is also a ratio to something timed in the same run, and a share of what the
machine could do at best (`limits`). Rows are stages of a realisation, its growth with size, and what one would use
instead. Timings are medians, or the least where they are subtracted from each other. Nothing is judged here. The first
row, `realization`, is the literal chain over the compiled one, both without looking for other basins.
"""

from __future__ import annotations

import importlib
from collections.abc import Callable
from dataclasses import asdict, dataclass, replace
from functools import partial
from pathlib import Path
from statistics import median
from typing import Any

import numpy as np
from rich.console import Console
from scipy import fft

from leakref import chain, fast, leakage, runs
from leakref._output import dump, envelope, folder, progress_bar, write_whole
from leakref._tables import Table
from leakref.bench.limits import (
    MATRIX,
    MATRIX_ONE,
    MEMORY,
    Machine,
    closed_form_products,
    fast_products,
    fft_traffic,
    magnitudes_traffic,
    seconds,
    synthesis_products,
)
from leakref.cases import Configuration, configurations
from leakref.methods import DEFAULT
from leakref.sea import Components
from leakref.shell import HALF_WIDTH, Extraction
from leakref.spectrum import fourier
from leakref.synthesis import synthesize

__all__ = ["Row", "literal", "measure", "run"]

_WINDOWS = ("box", "hann")


@dataclass(frozen=True)
class Row:
    """`seconds` of what `name` says; `against` says what took `ratio` times as long, in the same run.

    `share` is the part of the machine's limit that was reached, `limit` which one. Of memory, what must be read at
    least counts: a stage with a small share computes on what it has read.

    `ratio` is None, and `against` empty, where there is nothing to compare with; `share` is above 0, and near 1 where
    the stage does nothing but what the limit counts.
    """

    name: str
    seconds: float
    against: str
    ratio: float | None
    share: float
    limit: str


def literal(configuration: Configuration, realization: int) -> dict[tuple[str, str], Extraction]:
    """One realisation by the plain chain: route A, the whole Nyquist range, SciPy's Nelder-Mead, all threads. This is
    what the compiled chain is held against; other basins are not looked for.
    """
    k = configuration.wavenumbers
    spectra = chain.transform(configuration.components(realization), configuration.grid, configuration.windows)
    return {
        (s.window, method): chain.analyse(s, k, method=method, search=False, gravity=1.0)
        for s in spectra
        for method in DEFAULT
    }


def _stages(configuration: Configuration, machine: Machine) -> list[Row]:
    """Parts of a fast realisation cannot be timed apart; they are differences of runs with and without them, of least
    times.
    """
    grid, waves, k = configuration.grid, configuration.components(0), configuration.wavenumbers
    axes = [grid.samples(axis) for axis in range(3)]
    surface = synthesize(waves, *axes)
    reach = _reach(configuration)
    spectrum = leakage.spectrum(waves, grid, "hann", largest_wavenumber=reach)
    one_thread = seconds(lambda: fourier(surface, grid, "hann", workers=1), 1)
    t = {
        "synthesis": seconds(lambda: synthesize(waves, *axes, out=surface)),
        "fft": seconds(lambda: fourier(surface, grid, "hann")),
        "closed": seconds(lambda: [leakage.spectrum(waves, grid, w, largest_wavenumber=reach) for w in _WINDOWS]),
        "spectra": _fast(configuration, methods=()),
    }
    parts: dict[str, dict[str, Any]] = {
        "none": {"methods": ()},
        "ls": {"methods": ("ls",)},
        "searched": {"methods": ("nsp",)},
        "nsp": {"methods": ("nsp",), "search": False},
    }
    least = {name: _fast(configuration, 15, min, **settings) for name, settings in parts.items()}  # for differences
    literal_nsp = seconds(lambda: chain.analyse(spectrum, k, search=False, gravity=1.0), 1)
    literal_ls = seconds(lambda: chain.analyse(spectrum, k, method="ls", gravity=1.0))
    read = magnitudes_traffic(grid, k)

    def row(name: str, time: float, limit: str, asked: float, against: str = "", ratio: float | None = None) -> Row:
        return Row(name, time, against, ratio, machine.share(limit, asked, time), limit)

    nsp, searched, ls = (
        (least[name] - least[less]) / len(_WINDOWS)
        for name, less in (("nsp", "none"), ("searched", "nsp"), ("ls", "none"))
    )
    return [
        row("synthesis of the surface", t["synthesis"], MATRIX, synthesis_products(waves, grid.shape)),
        row(
            "taper and FFT of the surface, all threads",
            t["fft"],
            MEMORY,
            fft_traffic(grid.shape),
            "one thread",
            one_thread / t["fft"],
        ),
        row(
            "spectra of both windows, closed form",
            t["closed"],
            MATRIX,
            closed_form_products(waves, grid, reach, len(_WINDOWS)),
            "surface and two FFTs",
            (t["synthesis"] + 2 * t["fft"]) / t["closed"],
        ),
        row(
            "spectra of both windows, fast",
            t["spectra"],
            MATRIX_ONE,
            fast_products(waves, grid, reach),
            "closed form",
            t["closed"] / t["spectra"],
        ),
        row("NSP of one window, literal", literal_nsp, MEMORY, read),
        row("NSP of one window, fast", nsp, MEMORY, read, "literal", literal_nsp / nsp),
        row("search for other basins, one window, fast", searched, MEMORY, read),
        row(
            "LS of one window, literal",
            literal_ls,
            MEMORY,
            read,
            "NSP of the same shells, literal",
            literal_nsp / literal_ls,
        ),
        row("LS of one window, fast", ls, MEMORY, read, "NSP of the same shells, fast", nsp / ls),
    ]


def _reach(configuration: Configuration) -> float:
    """The largest wavenumber that the shells need, and a bin more."""
    return float(configuration.wavenumbers[-1] + (HALF_WIDTH + 1) * configuration.grid.wavenumber_resolution)


def _share(
    machine: Machine, configuration: Configuration, time: float, count: int = 1, limit: str = MATRIX_ONE
) -> dict[str, Any]:
    """Of `count` fast realisations in `time`: the products of their spectra, which bound them, over the limit."""
    asked = count * fast_products(configuration.components(0), configuration.grid, _reach(configuration))
    return {"share": machine.share(limit, asked, time), "limit": limit}


def _fast(
    configuration: Configuration, repeats: int = 5, pick: Callable[[list[float]], float] = median, **settings: Any
) -> float:
    """Seconds of the compiled realisation on one thread, with the settings given."""
    waves = configuration.components(0)
    grid, k = configuration.grid, configuration.wavenumbers
    with runs.one_thread():
        return seconds(partial(fast.realize, waves, grid, k, windows=_WINDOWS, **settings), repeats, pick)


def _realization(configuration: Configuration, machine: Machine) -> Row:
    """The row others read: literal over fast, both without the search for other basins; the fast one on one thread.
    Both give the same velocities, which tests hold to 1e-11 `c0`.
    """
    quick = _fast(configuration, 31, search=False)
    slow = seconds(lambda: literal(configuration, 0), 1)
    return Row(
        "realization", quick, "literal chain, all threads", slow / quick, **_share(machine, configuration, quick)
    )


def _growth(base: Configuration, machine: Machine) -> list[Row]:
    """Cost against L, T, realisations and workers, each with the exponent of a power law through the ends. Exponents
    are those of a line through logarithms of all sizes.
    """
    rows = []
    for name, values in (("length", (5.0, 10.0, 20.0)), ("duration", (10.0, 20.0, 80.0))):
        grown: list[dict[str, Any]] = [{name: value} for value in values]
        times = [_fast(replace(base, **one), 1 if max(one.values()) >= 20 else 3) for one in grown]
        power = np.polyfit(np.log(values), np.log(times), 1)[0]
        rows += [
            Row(
                f"realization at {name} {value:g}",
                time,
                f"{name} {values[0]:g}; cost grows as power {power:.1f}",
                times[0] / time,
                **_share(machine, replace(base, **one), time),
            )
            for one, value, time in zip(grown, values, times, strict=True)
        ]
    small = replace(base, length=5.0, duration=10.0)
    times = [seconds(partial(_run, small, count), 1) for count in (20, 80)]
    power = np.log(times[1] / times[0]) / np.log(4)
    rows.append(
        Row(
            "80 small realizations",
            times[1],
            f"20 of them; cost grows as power {power:.2f}",
            times[0] / times[1],
            **_share(machine, small, times[1], 80),
        )
    )
    with runs.pool(2) as executor:
        list(runs.run([base], realizations=4, executor=executor))  # workers started and compiled
        two = seconds(lambda: list(runs.run([base], realizations=40, executor=executor)), 1)
    one = seconds(lambda: list(runs.run([base], realizations=40)), 1)
    rows.append(
        Row("40 realizations, two workers", two, "one worker", one / two, **_share(machine, base, two, 40, MATRIX))
    )
    return rows


def _run(configuration: Configuration, count: int) -> None:
    """Small realisations, one after the other in this process."""
    list(runs.run([configuration], realizations=count))


def _direct(waves: Components, x: np.ndarray, y: np.ndarray, t: np.ndarray) -> np.ndarray:
    """Superposition wave by wave: what one writes first."""
    eta = np.zeros((x.size, y.size, t.size))
    for n in range(waves.kx.size):
        phase = waves.kx[n] * x[:, None, None] + waves.ky[n] * y[:, None] - waves.omega[n] * t + waves.phase[n]
        eta += waves.amplitude[n] * np.cos(phase)
    return eta


def _alternatives(configuration: Configuration, machine: Machine) -> list[Row]:
    """Against what a user would pick instead: direct sums, and non-uniform FFTs where they are installed. Direct sums
    are timed on a small surface, since they would take far too long on the paper's.
    """
    small = replace(configuration, length=2.0, duration=4.0)
    waves, axes = small.components(0), [small.grid.samples(axis) for axis in range(3)]
    ours = seconds(lambda: synthesize(waves, *axes))
    share = machine.share(MATRIX, synthesis_products(waves, small.grid.shape), ours)
    rows = [
        Row(
            "synthesis of a small surface",
            ours,
            "wave by wave",
            seconds(lambda: _direct(waves, *axes), 1) / ours,
            share,
            MATRIX,
        )
    ]
    waves, grid = configuration.components(0), configuration.grid
    axes = [grid.samples(axis) for axis in range(3)]
    ours = seconds(lambda: synthesize(waves, *axes), 1)
    share = machine.share(MATRIX, synthesis_products(waves, grid.shape), ours)
    for package, work in (("finufft", _finufft), ("ducc0", _ducc)):
        try:
            library = importlib.import_module(package)
        except ModuleNotFoundError:
            continue
        rows.append(
            Row(
                "synthesis of the surface",
                ours,
                f"{package}, one 2D transform a frame, to 1e-12",
                seconds(partial(work, library, waves, grid, axes[2]), 1) / ours,
                share,
                MATRIX,
            )
        )
    cube = np.random.default_rng(0).standard_normal(grid.shape)
    ours = seconds(lambda: fourier(cube, grid, "box"))
    share = machine.share(MEMORY, fft_traffic(grid.shape), ours)
    others = {
        "numpy.fft.rfftn": lambda: np.fft.rfftn(cube),
        "scipy.fft.fftn, complex, all threads": lambda: fft.fftn(cube, workers=-1),
    }
    return rows + [
        Row("FFT of the surface", ours, name, seconds(work, 1) / ours, share, MEMORY) for name, work in others.items()
    ]


def _finufft(library: Any, waves: Components, grid: Any, times: np.ndarray) -> None:
    """The same surface by a non-uniform FFT for each frame."""
    kx, ky = waves.kx * grid.spacing[0], waves.ky * grid.spacing[1]
    for t in times:
        strength = waves.amplitude * np.exp(1j * (waves.phase - waves.omega * t))
        library.nufft2d1(kx, ky, strength, grid.shape[:2], eps=1e-12, isign=1)


def _ducc(library: Any, waves: Components, grid: Any, times: np.ndarray) -> None:
    """Likewise, by another library."""
    position = np.stack([waves.kx * grid.spacing[0], waves.ky * grid.spacing[1]], axis=1)
    for t in times:
        strength = waves.amplitude * np.exp(1j * (waves.phase - waves.omega * t))
        library.nufft.nu2u(
            points=strength,
            coord=position,
            out=np.empty(grid.shape[:2], complex),
            forward=False,
            epsilon=1e-12,
            nthreads=0,
            periodicity=2 * np.pi,
        )


def measure(after_each: Callable[[], object] = lambda: None) -> list[Row]:
    """Every row; calls `after_each` five times on the way. It takes minutes and should have the machine for itself."""
    configuration = configurations(["nsp-ls"])[0]
    machine = Machine.measured()
    rows = []
    for part in (
        lambda: [_realization(configuration, machine)],
        lambda: _stages(configuration, machine),
        lambda: _growth(configuration, machine),
        lambda: _alternatives(configuration, machine),
    ):
        rows += part()
        after_each()
    return rows


def run(out: Path, *, json: bool = False) -> bool:
    """Measure, print and draw; returns True. Written are `bench.json` and a picture, in `out`."""
    folder(out)
    with progress_bar("stages, growth, alternatives", 4) as step:
        rows = measure(step)
    result = envelope("bench", True, rows=[asdict(row) for row in rows])
    write_whole(out / "bench.json", lambda path: path.write_text(dump(result) + "\n", encoding="utf-8"))
    pictures = _draw(rows, out)
    if json:
        print(dump(result))
        return True
    table = Table(title="Medians of one run", caption="ratio: how many times as long the other takes")
    for name, justify in (
        ("stage", "left"),
        ("seconds", "right"),
        ("ratio", "right"),
        ("against", "left"),
        ("share of the limit", "left"),
    ):
        table.add_column(name, justify=justify)
    for row in rows:
        table.add_row(
            row.name,
            f"{row.seconds:.4g}",
            "" if row.ratio is None else f"{row.ratio:.3g}",
            row.against,
            f"{100 * row.share:.2g} % of {row.limit}",
        )
    Console().print(table)
    Console().print(f"Picture: {pictures[0]}", soft_wrap=True)
    return True


def _draw(rows: list[Row], out: Path) -> list[Path]:
    """Both times of every row that has a ratio, on a logarithmic axis."""
    from leakref.figures import COLOURS, figure, save

    shown = [row for row in rows if row.ratio][::-1]
    drawing, axes = figure(1, 1, width=9.0, height=0.32 * len(shown) + 0.6)
    ax = axes[0, 0]
    places = np.arange(len(shown))
    ax.hlines(places, [r.seconds for r in shown], [r.seconds * (r.ratio or 1) for r in shown], color="0.7", lw=1)
    ax.plot([r.seconds for r in shown], places, "o", color=COLOURS[0], label="as named")
    ax.plot([r.seconds * (r.ratio or 1) for r in shown], places, "s", color=COLOURS[1], label="against")
    ax.set_yticks(places, [r.name for r in shown])
    ax.set_xscale("log")
    ax.set_xlabel("time (s)")
    ax.set_ylabel("what is timed (each once)")
    beside = ax.secondary_yaxis("right")
    beside.set_yticks(places, [f"{row.ratio:.3g} x  {row.against}" for row in shown], fontsize=7)
    drawing.legend(loc="outside lower center", ncols=2)
    return save(drawing, out / "bench")
