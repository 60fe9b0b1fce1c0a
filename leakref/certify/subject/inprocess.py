"""An implementation in this process: a Python object or function, called directly, without limits.

What such an object offers and returns is in the guide protocol, section 5.

Used by pytest (`certify.pytesting`), by the study of the suite's strength and by the diagnosis, where thousands of
questions make a process for each too slow. `offer`, `describe` and `call` are shared with `certify.worker`, so that an
object means the same in both. There is no protection: what hangs here hangs whoever called.
"""

from __future__ import annotations

import inspect
from collections.abc import Callable, Mapping
from typing import Any, Protocol

import numpy as np

from leakref._base import ComplexArray, FloatArray
from leakref.certify.subject.declaration import GIVEN, STAGES, WATER, Declaration
from leakref.certify.subject.frames import Subject
from leakref.certify.subject.seas import FORMS
from leakref.certify.verdict import Refused, Unanswered, Verdict
from leakref.sea import Components

__all__ = ["Implementation", "InProcess", "accepts", "call", "describe", "offer", "takes_wavenumbers"]


class Implementation(Protocol):
    """What can be judged: any subset of these methods (guide protocol, section 5). A bare function is `extract`.

    - `describe()`: a declaration, a mapping of the fields of `Declaration`.
    - `window(name, size)`: samples (size,).
    - `synthesize(components, x, y, t)`: the surface on these axes, in the order of axes that is declared.
    - `spectrum(surface, spacing, window=)`: S or its magnitude, of the shape of the surface.
    - `extract(surface, spacing, wavenumbers, ...)`: velocities (n, 2), None or a masked row where there is no number.

    Arrays come in the units and the frame that it declares. NotImplementedError refuses what was offered: `missing`.
    """

    def describe(self) -> Mapping[str, object]: ...
    def window(self, name: str, size: int) -> FloatArray: ...
    def synthesize(self, components: Components, x: FloatArray, y: FloatArray, t: FloatArray) -> FloatArray: ...
    def spectrum(self, surface: FloatArray, spacing: tuple[float, float, float], *, window: str) -> ComplexArray: ...
    def extract(
        self,
        surface: FloatArray,
        spacing: tuple[float, float, float],
        wavenumbers: FloatArray,
        *,
        gravity: float,
        window: str,
        method: str,
    ) -> FloatArray: ...


class InProcess(Subject):
    """A Python object or function called directly: for pytest and for the study of the suite, without limits.

    `implementation` is an instance or a function (a class is not called here). `functions` are the stages it offers, by
    name. An input that a call has altered is noted in `violations`; an exception becomes Unanswered with its type and
    words. On construction Unanswered is raised where it offers nothing or declares what cannot be.
    """

    def __init__(self, implementation: Any, name: str = "") -> None:
        self.functions = offer(implementation)
        given = dict(implementation.describe()) if hasattr(implementation, "describe") else {}
        super().__init__(describe(given, self.functions, name or _name(implementation)))

    def _work(self, stage: str, arrays: dict[str, Any], parameters: dict[str, Any]) -> Mapping[str, Any]:
        """Call the function of a stage, and see whether it left its inputs alone; what it raises is its own fault."""
        before = {name: np.array(value) for name, value in arrays.items()}
        try:
            answer = call(self.functions[stage], stage, arrays, parameters)
            self.violations += [
                f"{stage} altered its input {name}"
                for name, value in before.items()
                if not np.array_equal(value, arrays[name], equal_nan=True)
            ]
            return answer
        except NotImplementedError as error:
            raise Refused(str(error) or f"{stage} is not implemented") from error
        except Unanswered:
            raise
        except Exception as error:
            raise Unanswered(Verdict.ERROR, f"{type(error).__name__}: {error}") from error


def _name(implementation: Any) -> str:
    """What it is called where it does not say: module and qualified name."""
    own = getattr(implementation, "__qualname__", None) or type(implementation).__qualname__
    return f"{getattr(implementation, '__module__', '')}:{own}"


def offer(implementation: Any) -> dict[str, Callable[..., Any]]:
    """The stages an object offers; a bare function is `extract`. Raises Unanswered if there are none."""
    found = {s: getattr(implementation, s) for s in STAGES if callable(getattr(implementation, s, None))}
    if not found and callable(implementation) and not isinstance(implementation, type):
        found = {"extract": implementation}
    if not found:
        raise Unanswered(Verdict.ERROR, f"{_name(implementation)} offers none of {', '.join(STAGES)}")
    return found


def describe(given: dict[str, Any], calls: Mapping[str, Callable[..., Any]], name: str) -> Declaration:
    """What an object says of itself, completed by what its signatures show: keywords that are lacking are fixed.

    `given` is what its `describe()` returned, `calls` the stages from `offer`, `name` what it is called if it does not
    say. A stage that it declares and does not have is dropped. An `extract` without a `window` keyword tapers nothing;
    one that names a keyword `depth` or `surface_tension` is handed it. Raises Unanswered as `Declaration.read` does,
    and where a depth is declared as given that the signature does not take.
    """
    can = {stage: dict(given.get("can", {}).get(stage, {})) for stage in calls if stage in given.get("can", calls)}
    fixed = list(given.get("fixed", ()))
    if "extract" in can:
        lacking = [key for key in ("gravity", "window", "method") if not accepts(calls["extract"], key)]
        lacking += ["wavenumbers"] * (not takes_wavenumbers(calls["extract"]))
        fixed += [key for key in lacking if key not in fixed]
        if "window" in lacking:
            can["extract"].setdefault("windows", [])
        water = given.get("water") or {}
        if isinstance(water, Mapping):
            given["water"] = {key: GIVEN for key in WATER if accepts(calls["extract"], key, by_name=True)} | dict(water)
    if "sea" in can:
        fixed += [key for key, forms in FORMS.items() if not any(accepts(calls["sea"], one) for one in forms)]
        if "extract" not in can:
            told = {key: GIVEN for key in WATER if accepts(calls["sea"], key, by_name=True)}
            given["water"] = told | dict(given.get("water") or {})
    declared = Declaration.read({"name": name, **given, "fixed": fixed, "can": can})
    for key in declared.told:
        if "extract" in can and not accepts(calls["extract"], key):
            raise Unanswered(Verdict.ERROR, f"declares {key} as {GIVEN}, and its extract takes no {key}")
    return declared


def accepts(function: Callable[..., Any], keyword: str, *, by_name: bool = False) -> bool:
    """Whether `function` takes the keyword; one whose signature cannot be seen takes all. `**keywords` take all as
    well, unless the keyword is to be there `by_name`.
    """
    try:
        parameters = inspect.signature(function).parameters
    except (TypeError, ValueError):
        return not by_name
    return keyword in parameters or (not by_name and any(p.kind is p.VAR_KEYWORD for p in parameters.values()))


def takes_wavenumbers(function: Callable[..., Any]) -> bool:
    """Whether it has a third positional parameter, whatever its name.

    The keywords `gravity`, `window`, `method` and those of the water do not count. One that does not take them has
    wavenumbers of its own, and must say with each answer which they are.
    """
    try:
        parameters = inspect.signature(function).parameters.values()
    except (TypeError, ValueError):
        return True
    positional = [p for p in parameters if p.kind in (p.POSITIONAL_ONLY, p.POSITIONAL_OR_KEYWORD)]
    named = {"gravity", "window", "method", *WATER}
    many = len([p for p in positional if p.name not in named]) >= 3
    return many or any(p.kind is p.VAR_POSITIONAL for p in parameters)


def call(
    function: Callable[..., Any], stage: str, arrays: Mapping[str, Any], parameters: Mapping[str, Any]
) -> dict[str, Any]:
    """Call a Python stage with what the protocol hands over, passing only the keywords it takes.

    `arrays` and `parameters` are those of guide protocol, section 4; returned are the outputs by name, as they came. Of
    `extract` three forms are understood: a mapping, a pair of velocities (n, 2) and wavenumbers (n,), and velocities
    alone. Whatever the function raises is passed on.
    """

    def taken(**keywords: Any) -> dict[str, Any]:
        return {name: value for name, value in keywords.items() if accepts(function, name)}

    p = parameters
    if stage == "window":
        return {"w": function(p["name"], p["size"])}
    if stage == "sea":
        forms = (*(one for some in FORMS.values() for one in some), "gravity", *(key for key in WATER if key in p))
        return {"eta": function(tuple(p["shape"]), (p["dx"], p["dy"], p["dt"]), **taken(**{k: p[k] for k in forms}))}
    if stage == "synthesize":
        waves = Components(*(np.asarray(arrays[name]).ravel() for name in ("kx", "ky", "omega", "amplitude", "phase")))
        return {"eta": function(waves, *(np.asarray(arrays[name]).ravel() for name in "xyt"))}
    spacing = (p["dx"], p["dy"], p["dt"])
    if stage == "spectrum":
        return {"S": function(arrays["eta"], spacing, **taken(window=p["window"]))}
    names = ("gravity", "window", "method", *(name for name in WATER if name in p))
    keywords = taken(**{name: p[name] for name in names})
    if takes_wavenumbers(function):
        answer = function(arrays["eta"], spacing, np.asarray(p["wavenumbers"]), **keywords)
    else:
        answer = function(arrays["eta"], spacing, **keywords)
    if isinstance(answer, Mapping):
        return dict(answer)
    if isinstance(answer, tuple) and len(answer) == 2 and _has_rows(answer[0]):
        return {"velocities": answer[0], "wavenumbers": answer[1]}
    return {"velocities": answer}


def _has_rows(values: Any) -> bool:
    """Whether these are rows of two, or None in place of a row, as the first of a pair: not two numbers of one row."""
    return isinstance(values, list | tuple | np.ndarray) and all(row is None or np.shape(row) == (2,) for row in values)
