"""How far the velocities move if a decision is taken otherwise, and what becomes of the claims.

Every variant of a decision is an altered chain (`variants`), and is run on the same seas as the reference. `study`
gives the shift of every velocity, `summary` a row of the table, and `rejudged` evaluates the claims by the velocities
of those variants that move some of them. Used by `leakref claims --decisions`; the results kept are `stored`'s.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from concurrent.futures import Executor
from dataclasses import asdict
from functools import cache, lru_cache
from itertools import product, repeat
from pathlib import Path
from typing import Any

import numpy as np

from leakref import kept, leastsquares, runs, sources
from leakref._base import FloatArray
from leakref.cases import Configuration, configurations
from leakref.claims.evidence import PLAIN, Evidence, Setting, kept_velocities, peak_waves, resampled
from leakref.claims.registry import Claim
from leakref.claims.samples import Sample, smaller
from leakref.claims.variants import CONFIGURATIONS, VARIANTS, Variant
from leakref.ensemble import Ensemble
from leakref.fast import spectra
from leakref.methods import DEFAULT
from leakref.window import window as named_window

__all__ = ["MOVED", "Altered", "NotCovered", "Shifts", "moving", "rejudged", "study", "summary", "velocities"]

MOVED = 1e-9
"""In c0: by more than this a shell has moved; less is rounding."""
_SHARE = 0.1  # of the smaller resolution: a variant that moves a velocity by more may change a claim


@lru_cache(maxsize=4)
def _spectra(
    configuration: Configuration, realization: int, windows: tuple[str, ...], radius: float
) -> dict[str, FloatArray]:
    """Magnitudes by the package's own chain, the last four kept: variants that leave spectra alone share them."""
    grid, tapers = configuration.grid, [named_window(name) for name in windows]
    return spectra.magnitudes(configuration.components(realization), grid, tapers, spectra.Disc(grid, radius))


def velocities(
    variant: Variant,
    configuration: Configuration,
    realization: int,
    setting: Setting = PLAIN,
    windows: Sequence[str] | None = None,
) -> FloatArray:
    """Of one realisation by the altered chain, (w, m, n, 2), NaN where there is none: those of `windows` (default: on
    which the variant is tried) that the configuration has, the variant's methods, the configuration's wavenumbers.

    Spectra that a variant leaves alone are made once for all of them.
    """
    windows = tuple(name for name in configuration.windows if name in (windows or variant.windows))
    if variant.setting.resampled:
        return resampled(configuration, realization)
    chain = variant.chain
    own = chain.cases.Configuration(**asdict(configuration))
    waves = own.components(realization)
    chain.fast.magnitudes = chain.fast.spectra.magnitudes
    if setting.without_peak:
        rest = ~peak_waves(waves)
        waves = chain.sea.Components(*(getattr(waves, name)[rest] for name in waves.__dataclass_fields__))
    elif variant.leaves_spectra:
        chain.fast.magnitudes = lambda waves, grid, tapers, disc: _spectra(
            configuration, realization, tuple(taper.name for taper in tapers), disc.radius
        )
    own_threshold = setting.threshold == leastsquares.THRESHOLD
    found = chain.fast.realize(
        waves,
        own.grid,
        own.wavenumbers,
        windows=windows,
        methods=variant.methods,
        water=own.water,
        width=setting.width,
        threshold=chain.leastsquares.THRESHOLD if own_threshold else setting.threshold,
        search=False,
    )
    result = np.full((len(windows), len(variant.methods), configuration.wavenumbers.size, 2), np.nan)
    mine, theirs = np.nonzero(np.abs(configuration.wavenumbers[:, None] - own.wavenumbers) < MOVED)
    for (w, window), (m, method) in product(enumerate(windows), enumerate(variant.methods)):
        result[w, m, mine] = found[window, method].velocities[theirs]
    return result


@cache
def _source_digest() -> str:
    return sources.digest(__name__)


def _about(variant: Variant, configuration: Configuration, setting: Setting, windows: Sequence[str]) -> dict[str, Any]:
    """What velocities under a variant depend on: changes by their text, so that an edited variant is another one."""
    return {
        "changes": [asdict(change) for change in (*variant.changes, *variant.fast)],
        "methods": variant.methods,
        "windows": windows,
        "data": asdict(variant.setting),
        "configuration": asdict(configuration),
        "setting": asdict(setting),
        "source": _source_digest(),
    }


def _kept(
    variants: Sequence[Variant],
    windows: Sequence[Sequence[str]],
    configuration: Configuration,
    realization: int,
    setting: Setting,
    folder: Path | None,
) -> list[FloatArray]:
    """`velocities` of several variants, each under its `windows`, from the folder where they are there, and left there
    where they are not."""
    found = []
    for variant, own in zip(variants, windows, strict=True):
        about = _about(variant, configuration, setting, own)
        path = folder and folder / f"variant-{kept.key(about)}" / f"{realization:05d}.npz"
        shape = (
            sum(name in own for name in configuration.windows),
            len(variant.methods),
            configuration.wavenumbers.size,
            2,
        )
        found.append(
            kept_velocities(
                path,
                {**about, "realization": realization},
                shape,
                velocities,
                variant,
                configuration,
                realization,
                setting,
                own,
            )
        )
    return found


def _turned_back(values: FloatArray, degrees: float) -> FloatArray:
    """Velocities (..., 2) in the frame of the sea before it was rotated by so many degrees."""
    c, s = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
    return values @ np.array([[c, -s], [s, c]])


class Shifts:
    """How far one variant moves what one window and method give, shell by shell: against a reference Ensemble.

    `moved` (R, n) is |c' - c| in c0, `share` the same over the smaller resolution, `flagged` (R, n) where the reference
    has a note, `better` (R, n) the error |c' - U| less |c - U|. Velocities are compared in the frame of the sea before
    its rotation, so that a rotation the other way (D23) is no shift by itself. `lost` (R, n) is where the variant has
    no number and the reference has one.
    """

    def __init__(self, variant: Variant, reference: Ensemble, other: FloatArray) -> None:
        angle, count = reference.configuration.rotation, len(other)
        mine = _turned_back(reference.velocities[:count], angle)
        theirs, truth = _turned_back(other, variant.sense * angle), _turned_back(reference.configuration.current, angle)
        self.variant, self.reference, self.k = variant, reference, reference.wavenumbers
        self.moved = np.hypot(*np.moveaxis(theirs - mine, -1, 0))
        self.share = self.moved / smaller(reference)
        self.flagged = reference.notes[:count] != 0
        self.lost = np.isfinite(mine[..., 0]) & ~np.isfinite(theirs[..., 0])
        error, before = (np.hypot(*np.moveaxis(values - truth, -1, 0)) for values in (theirs, mine))
        self.better = Sample(self.k, np.where(np.isfinite(self.moved), error - before, np.nan))


def _figures(value: Any) -> float | None:
    """Three digits, None where there is no number."""
    return float(f"{value:.3g}") if np.isfinite(value) else None


def _spread(moved: FloatArray, share: FloatArray) -> dict[str, Any]:
    """Median, 95th percentile and largest, in c0 and as a share of the smaller resolution."""
    known = np.isfinite(moved)
    if not known.any():
        return {"shells": 0}
    result: dict[str, Any] = {"shells": int(known.sum()), "moved": int((moved[known] > MOVED).sum())}
    for name, values in (("c0", moved[known]), ("resolution", share[known])):
        result[name] = {
            "median": _figures(np.median(values)),
            "p95": _figures(np.percentile(values, 95)),
            "largest": _figures(values.max()),
        }
    return result


def summary(shifts: Sequence[Shifts], case: str) -> dict[str, Any]:
    """A row of the table: shells without a note, those with one apart, numbers lost, and the change of the bias.

    The bias is the mean of |c - U|; its change is the mean over shells, with the standard error over realisations.
    """
    first = shifts[0]
    moved, share, flagged = (
        np.concatenate([getattr(s, name).ravel() for s in shifts]) for name in ("moved", "share", "flagged")
    )
    means = [s.better.over() for s in shifts if np.isfinite(s.better.values).all()]
    row: dict[str, Any] = {
        "case": case,
        "window": first.reference.window,
        "method": first.reference.method,
        "realizations": len(first.moved),
        "unflagged": _spread(moved[~flagged], share[~flagged]),
        "flagged": _spread(moved[flagged], share[flagged]),
        "lost": int(sum(s.lost.sum() for s in shifts)),
        "bias_change": None,
    }
    if means:
        error = np.sqrt(sum(float(m.error[0]) ** 2 for m in means)) / len(means)
        row["bias_change"] = {"mean": _figures(np.mean([m.mean[0] for m in means])), "standard_error": _figures(error)}
    return row


def study(
    variants: Iterable[Variant] = VARIANTS.values(),
    ids: Sequence[str] = CONFIGURATIONS,
    *,
    realizations: int = 20,
    folder: Path | None = None,
    executor: Executor | None = None,
    after_each: Callable[[], object] = lambda: None,
) -> dict[str, list[list[Shifts]]]:
    """For each variant, a list for each configuration on which it acts of the Shifts of each window and method.

    Resumed from `folder`, which may be that of `leakref reproduce`; there the references are found too. Order is that
    of `ids`. `realizations` is a most: a variant may ask for fewer.
    """
    wanted, tasks = list(variants), []
    found: dict[tuple[str, str], list[FloatArray]] = {}
    for configuration, number in product(configurations(ids), range(realizations)):
        acting = [v for v in wanted if configuration.id in v.configurations and number < v.realizations]
        tasks.append((acting, [v.windows for v in acting], configuration, number, PLAIN, folder))
    columns = list(zip(*tasks, strict=True))
    results = map(_kept, *columns) if executor is None else executor.map(_kept, *columns)
    for (acting, _, configuration, *_), one in zip(tasks, results, strict=True):
        for variant, values in zip(acting, one, strict=True):
            found.setdefault((variant.id, configuration.id), []).append(values)
        after_each()
    whole: dict[str, list[list[Shifts]]] = {v.id: [] for v in wanted}
    by_methods: dict[tuple[str, ...], list[Variant]] = {}
    for variant in wanted:
        by_methods.setdefault(DEFAULT if {*variant.methods} <= {*DEFAULT} else variant.methods, []).append(variant)
    how: dict[str, Any] = {"folder": folder, "executor": executor}
    for methods, members in by_methods.items():
        acting_on = [c for c in configurations(ids) if any(c.id in v.configurations for v in members)]
        most = max(min(realizations, v.realizations) for v in members)
        for ensembles in runs.run(acting_on, realizations=most, methods=methods, **how):
            own = {(e.window, e.method): e for e in ensembles}
            for v in members:
                if (computed := found.get((v.id, ensembles[0].configuration.id))) is not None:
                    windows, at = [w for w in ensembles[0].configuration.windows if w in v.windows], np.array(computed)
                    pairs = product(enumerate(windows), enumerate(v.methods))
                    whole[v.id].append([Shifts(v, own[window, m_], at[:, w, m]) for (w, window), (m, m_) in pairs])
    return whole


def moving(found: dict[str, list[list[Shifts]]]) -> list[Variant]:
    """The variants that move a velocity without a note by more than 10 % of the smaller resolution somewhere.

    None of those with other waves, whose velocities are others anyway, with images of a single sea, or of methods that
    the paper makes no statements about.
    """
    largest = {
        id: max(
            (float(np.nanmax(np.where(s.flagged, 0, s.share), initial=0)) for one in cases for s in one), default=0.0
        )
        for id, cases in found.items()
    }
    return [
        v
        for id, share in largest.items()
        if share > _SHARE and (v := VARIANTS[id]).paired and not v.setting.resampled and {*v.methods} <= {*DEFAULT}
    ]


class NotCovered(LookupError):
    """A claim asks for a configuration that was not to be computed."""


class _Velocities:
    """Those of several variants, (R, w, m, n, 2), computed together so that they share their spectra."""

    def __init__(
        self, variants: Sequence[Variant], realizations: int, folder: Path | None, executor: Executor | None
    ) -> None:
        self.variants, self.realizations, self.folder, self.executor = variants, realizations, folder, executor
        self._found: dict[tuple[Configuration, Setting], dict[str, FloatArray]] = {}

    def __call__(self, variant: Variant, configuration: Configuration, setting: Setting) -> FloatArray:
        if (configuration, setting) not in self._found:
            acting = [v for v in self.variants if v.acts_on(configuration)]
            windows = [v.acts_on(configuration) for v in acting]
            fixed = [repeat(one) for one in (acting, windows, configuration)]
            given = (*fixed, range(self.realizations), repeat(setting), repeat(self.folder))
            results = list(map(_kept, *given) if self.executor is None else self.executor.map(_kept, *given))
            self._found[configuration, setting] = {
                v.id: np.array([one[n] for one in results]) for n, v in enumerate(acting)
            }
        return self._found[configuration, setting][variant.id]


class Altered(Evidence):
    """Evidence by an altered chain, its `velocities` by one `variant` (None: the reference).

    With `ids`, of those configurations only: NotCovered is raised for any other.
    """

    def __init__(
        self,
        reference: Evidence,
        variant: Variant | None = None,
        velocities: _Velocities | None = None,
        ids: Sequence[str] | None = None,
    ) -> None:
        super().__init__(reference.realizations, reference.folder, reference.executor)
        self.reference, self.variant, self.velocities, self.ids, self.asked = reference, variant, velocities, ids, 0

    def __call__(
        self, configuration: Configuration, window: str, method: str = "nsp", setting: Setting = PLAIN
    ) -> Ensemble:
        if self.ids is not None and configuration.id not in self.ids:
            raise NotCovered(configuration.id)
        self.asked += 1
        before, v = self.reference(configuration, window, method, setting), self.variant
        if v is None or self.velocities is None or setting.resampled or method not in v.methods:
            return before
        if window not in v.acts_on(configuration):
            return before
        values = self.velocities(v, configuration, setting)[
            :, v.acts_on(configuration).index(window), v.methods.index(method)
        ]
        return Ensemble(configuration, window, method, before.wavenumbers, values, before.notes)

    def seconds(self, configuration: Configuration) -> dict[str, float]:
        """Timings are of a machine, not of a decision."""
        raise NotCovered(configuration.id)

    def softness(self, configuration: Configuration) -> Any:
        """Curvatures are those of the reference's score."""
        raise NotCovered(configuration.id)

    def depths(self, configuration: Configuration) -> Any:
        """Depths are inferred by the reference alone."""
        raise NotCovered(configuration.id)


def rejudged(
    variants: Sequence[Variant],
    claims: Sequence[Claim],
    *,
    realizations: int,
    folder: Path | None,
    executor: Executor | None,
    ids: Sequence[str] | None,
    after_each: Callable[[], object] = lambda: None,
) -> list[dict[str, Any]]:
    """The claims under each variant, beside what the reference says with as many realisations.

    A claim depends on a decision if a reading of it that held does not hold any more, or the reverse. Those that ask
    for other configurations than `ids`, or for no velocities at all, are left out. Calls `after_each` for every claim.
    Each record has the claim's and the variant's id, both verdicts, the first figure, and the readings that turned.
    """
    results = []
    kept, altered = Evidence(realizations, folder, executor), _Velocities(variants, realizations, folder, executor)
    for claim in claims:
        reference = Altered(kept, ids=ids)
        after_each()
        try:
            before = claim.judge(reference)
        except NotCovered:
            continue
        for variant in variants if reference.asked else ():
            after = claim.judge(Altered(kept, variant, altered))
            flipped = [
                {"reading": a.words, "before": a.holds, "after": b.holds}
                for a, b in zip(before.readings, after.readings, strict=True)
                if {a.holds, b.holds} == {True, False}
            ]
            results.append(
                {
                    "id": claim.id,
                    "decision": variant.decision,
                    "variant": variant.id,
                    "before": before.verdict,
                    "verdict": after.verdict,
                    "figure": after.readings[0].figure,
                    "readings": len(before.readings),
                    "flipped": flipped,
                }
            )
    return results
