"""`leakref bench`: what each stage costs, as ratios within one run and as shares of what the machine could do."""

from __future__ import annotations

import importlib
from collections.abc import Callable
from dataclasses import asdict, dataclass, replace
from functools import partial
from pathlib import Path
from statistics import median
from time import perf_counter
from typing import Any

import numpy as np
from rich.console import Console
from rich.table import Table
from scipy import fft

from leakref import chain, fast, leakage, runs
from leakref._output import dump, envelope, folder, progress_bar, write_whole
from leakref.cases import Configuration, configurations
from leakref.sea import Components
from leakref.shell import HALF_WIDTH, Extraction
from leakref.spectrum import fourier
from leakref.synthesis import synthesize

__all__ = ["Row", "literal", "measure", "run", "seconds"]

_WINDOWS = ("box", "hann")


@dataclass(frozen=True)
class Row:
    """`seconds` of what `name` says; `against` says what took `ratio` times as long, in the same run.

    `share` is the part of the machine's limit that was reached, `limit` which one: matrix product or memory.
    """

    name: str
    seconds: float
    against: str = ""
    ratio: float | None = None
    share: float | None = None
    limit: str = ""


def literal(configuration: Configuration, realization: int) -> dict[tuple[str, str], Extraction]:
    """One realisation by the plain chain: route A, the whole Nyquist range, SciPy's Nelder-Mead, all threads."""
    k = configuration.wavenumbers
    spectra = chain.transform(configuration.components(realization), configuration.grid, configuration.windows)
    return {(s.window, method): chain.analyse(s, k, method=method, search=False)
            for s in spectra for method in chain.METHODS}


def seconds(work: Callable[[], object], repeats: int = 3) -> float:
    """Median time of `work`, after one run that is not counted."""
    times = []
    for _ in range(repeats + 1):
        start = perf_counter()
        work()
        times.append(perf_counter() - start)
    return median(times[1:])


def _limits() -> tuple[float, float]:
    """What this machine can do now: real multiply-adds and bytes moved, per second."""
    n = 1500
    a, b = np.random.default_rng(0).standard_normal((2, n, n))
    target, source = np.empty(2**24), np.ones(2**24)
    return n**3 / seconds(lambda: a @ b, 5), 2 * source.nbytes / seconds(lambda: np.copyto(target, source), 5)


def _synthesis_products(waves: Components, shape: tuple[int, int, int]) -> float:
    """Real multiply-adds in the matrix products of synthesize."""
    lattice = waves.separated()
    rows, columns = (lattice[0].size, lattice[2].size) if lattice is not None else (waves.kx.size, 1)
    nx, ny, nt = shape
    return float(4 * rows * ny * columns * nt + 2 * nx * rows * ny * nt)


def _stages(configuration: Configuration, rates: tuple[float, float]) -> list[Row]:
    grid, waves, k = configuration.grid, configuration.components(0), configuration.wavenumbers
    axes = [grid.samples(axis) for axis in range(3)]
    surface = synthesize(waves, *axes)
    reach = float(k[-1] + (HALF_WIDTH + 1) * grid.wavenumber_resolution)
    spectrum = leakage.spectrum(waves, grid, "hann", largest_wavenumber=reach)
    one_thread = seconds(lambda: fourier(surface, grid, "hann", workers=1), 1)
    t = {"synthesis": seconds(lambda: synthesize(waves, *axes, out=surface)),
         "fft": seconds(lambda: fourier(surface, grid, "hann")),
         "closed": seconds(lambda: [leakage.spectrum(waves, grid, w, largest_wavenumber=reach) for w in _WINDOWS]),
         "spectra": _fast(configuration, methods=()), "ls": _fast(configuration, methods=("ls",)),
         "searched": _fast(configuration, methods=("nsp",)),
         "nsp": _fast(configuration, methods=("nsp",), search=False)}
    literal_nsp = seconds(lambda: chain.analyse(spectrum, k, search=False), 1)
    literal_ls = seconds(lambda: chain.analyse(spectrum, k, method="ls"))
    moved = surface.nbytes * 8.0  # taper: read and write; then three passes of half-length complex, read and write
    return [
        Row("synthesis of the surface", t["synthesis"], share=_synthesis_products(waves, grid.shape) / t["synthesis"]
            / rates[0], limit="matrix product"),
        Row("taper and FFT of the surface, all threads", t["fft"], "one thread", one_thread / t["fft"],
            moved / t["fft"] / rates[1], "memory"),
        Row("spectra of both windows, closed form", t["closed"], "surface and two FFTs",
            (t["synthesis"] + 2 * t["fft"]) / t["closed"]),
        Row("spectra of both windows, fast", t["spectra"], "closed form", t["closed"] / t["spectra"]),
        Row("NSP of one window, fast", (t["nsp"] - t["spectra"]) / 2, "literal",
            2 * literal_nsp / (t["nsp"] - t["spectra"])),
        Row("search for other basins, one window, fast", (t["searched"] - t["nsp"]) / 2),
        Row("LS of one window, literal", literal_ls, "NSP of the same shells, literal", literal_nsp / literal_ls),
        Row("LS of one window, fast", (t["ls"] - t["spectra"]) / 2, "NSP of the same shells, fast",
            (t["nsp"] - t["spectra"]) / (t["ls"] - t["spectra"]))]


def _fast(configuration: Configuration, repeats: int = 5, **settings: Any) -> float:
    waves = configuration.components(0)
    grid, k = configuration.grid, configuration.wavenumbers
    with runs.one_thread():
        return seconds(partial(fast.realize, waves, grid, k, windows=_WINDOWS, **settings), repeats)


def _realization(configuration: Configuration) -> Row:
    """The row others read: literal over fast, both without the search for other basins; the fast one on one thread."""
    quick = _fast(configuration, 31, search=False)
    slow = seconds(lambda: literal(configuration, 0), 1)
    return Row("realization", quick, "literal chain, all threads", slow / quick)


def _growth(base: Configuration) -> list[Row]:
    """Cost against L, T, realisations and workers, each with the exponent of a power law through the ends."""
    rows = []
    for name, values in (("length", (5.0, 10.0, 20.0)), ("duration", (10.0, 20.0, 80.0))):
        grown: list[dict[str, Any]] = [{name: value} for value in values]
        times = [_fast(replace(base, **one), 1 if max(one.values()) >= 20 else 3) for one in grown]
        power = np.polyfit(np.log(values), np.log(times), 1)[0]
        rows += [Row(f"realization at {name} {value:g}", time, f"{name} {values[0]:g}; cost grows as power {power:.1f}",
                     times[0] / time) for value, time in zip(values, times, strict=True)]
    small = replace(base, length=5.0, duration=10.0)
    times = [seconds(partial(_run, small, count), 1) for count in (20, 80)]
    power = np.log(times[1] / times[0]) / np.log(4)
    rows.append(Row("80 small realizations", times[1], f"20 of them; cost grows as power {power:.2f}",
                    times[0] / times[1]))
    with runs.pool(2) as executor:
        list(runs.run([base], realizations=4, executor=executor))  # workers started and compiled
        two = seconds(lambda: list(runs.run([base], realizations=40, executor=executor)), 1)
    rows.append(Row("40 realizations, two workers", two, "one worker",
                    seconds(lambda: list(runs.run([base], realizations=40)), 1) / two))
    return rows


def _run(configuration: Configuration, count: int) -> None:
    list(runs.run([configuration], realizations=count))


def _direct(waves: Components, x: np.ndarray, y: np.ndarray, t: np.ndarray) -> np.ndarray:
    """Superposition wave by wave: what one writes first."""
    eta = np.zeros((x.size, y.size, t.size))
    for n in range(waves.kx.size):
        phase = waves.kx[n] * x[:, None, None] + waves.ky[n] * y[:, None] - waves.omega[n] * t + waves.phase[n]
        eta += waves.amplitude[n] * np.cos(phase)
    return eta


def _alternatives(configuration: Configuration) -> list[Row]:
    """Against what a user would pick instead: direct sums, and non-uniform FFTs where they are installed."""
    small = replace(configuration, length=2.0, duration=4.0)
    waves, axes = small.components(0), [small.grid.samples(axis) for axis in range(3)]
    ours = seconds(lambda: synthesize(waves, *axes))
    rows = [Row("synthesis of a small surface", ours, "wave by wave", seconds(lambda: _direct(waves, *axes), 1) / ours)]
    waves, grid = configuration.components(0), configuration.grid
    axes = [grid.samples(axis) for axis in range(3)]
    ours = seconds(lambda: synthesize(waves, *axes), 1)
    for package, work in (("finufft", _finufft), ("ducc0", _ducc)):
        try:
            library = importlib.import_module(package)
        except ModuleNotFoundError:
            continue
        rows.append(Row("synthesis of the surface", ours, f"{package}, one 2D transform a frame, to 1e-12",
                        seconds(partial(work, library, waves, grid, axes[2]), 1) / ours))
    cube = np.random.default_rng(0).standard_normal(grid.shape)
    ours = seconds(lambda: fourier(cube, grid, "box"))
    rows.append(Row("FFT of the surface", ours, "numpy.fft.rfftn", seconds(lambda: np.fft.rfftn(cube), 1) / ours))
    rows.append(Row("FFT of the surface", ours, "scipy.fft.fftn, complex, all threads",
                    seconds(lambda: fft.fftn(cube, workers=-1), 1) / ours))
    return rows


def _finufft(library: Any, waves: Components, grid: Any, times: np.ndarray) -> None:
    kx, ky = waves.kx * grid.spacing[0], waves.ky * grid.spacing[1]
    for t in times:
        strength = waves.amplitude * np.exp(1j * (waves.phase - waves.omega * t))
        library.nufft2d1(kx, ky, strength, grid.shape[:2], eps=1e-12, isign=1)


def _ducc(library: Any, waves: Components, grid: Any, times: np.ndarray) -> None:
    position = np.stack([waves.kx * grid.spacing[0], waves.ky * grid.spacing[1]], axis=1)
    for t in times:
        strength = waves.amplitude * np.exp(1j * (waves.phase - waves.omega * t))
        library.nufft.nu2u(points=strength, coord=position, out=np.empty(grid.shape[:2], complex), forward=False,
                           epsilon=1e-12, nthreads=0, periodicity=2 * np.pi)


def measure(after_each: Callable[[], object] = lambda: None) -> list[Row]:
    """Every row; calls `after_each` five times on the way."""
    configuration = configurations(["nsp-ls"])[0]
    rates = _limits()
    rows = []
    for part in (lambda: [_realization(configuration)], lambda: _stages(configuration, rates),
                 lambda: _growth(configuration), lambda: _alternatives(configuration)):
        rows += part()
        after_each()
    return rows


def run(out: Path, *, json: bool = False) -> bool:
    """Measure, print and draw; returns True."""
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
    for name, justify in (("stage", "left"), ("seconds", "right"), ("ratio", "right"), ("against", "left"),
                          ("share of the limit", "left")):
        table.add_column(name, justify=justify)  # type: ignore[arg-type]
    for row in rows:
        table.add_row(row.name, f"{row.seconds:.4g}", "" if row.ratio is None else f"{row.ratio:.3g}", row.against,
                      "" if row.share is None else f"{row.share:.0%} of {row.limit}")
    Console().print(table)
    Console().print(f"Picture: {pictures[0]}", soft_wrap=True)
    return True


def _draw(rows: list[Row], out: Path) -> list[Path]:
    from leakref.figures import COLOURS, figure, save

    shown = [row for row in rows if row.ratio][::-1]
    drawing, axes = figure(1, 1, width=9.0, height=0.32 * len(shown) + 0.6)
    ax = axes[0, 0]
    places = np.arange(len(shown))
    ax.hlines(places, [r.seconds for r in shown], [r.seconds * (r.ratio or 1) for r in shown], color="0.7", lw=1)
    ax.plot([r.seconds for r in shown], places, "o", color=COLOURS[0], label="as named")
    ax.plot([r.seconds * (r.ratio or 1) for r in shown], places, "s", color=COLOURS[1], label="against")
    for place, row in zip(places, shown, strict=True):
        ratio = row.ratio or 1.0
        ax.annotate(f"{ratio:.3g} x  {row.against}", (max(row.seconds, row.seconds * ratio), place), xytext=(6, 0),
                    textcoords="offset points", va="center", fontsize=7)
    ax.set_yticks(places, [r.name for r in shown])
    ax.set_xscale("log")
    ax.set_xlim(right=ax.get_xlim()[1] * 300)
    ax.set_xlabel("seconds")
    ax.legend(loc="lower right")
    return save(drawing, out / "bench")
