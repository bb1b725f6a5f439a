"""The cases of the kit: every operation with every sample, forwards and backwards, in both
precisions, in odd layouts, at the ends of the ranges, and what must be refused."""

from collections.abc import Iterable, Iterator
import functools
from typing import Any

from .backend import OPERATIONS, as_backend, meant
from .calls import Case
from .capabilities import covering
from .specification import Operation
from .variations import (COARSE, generator, ground_of, in_float32, of_coarse, of_ground,
                         of_samples)

PROFILES = ("small", "core", "full", *COARSE)


def cases(*, seed: int = 0, operations: Iterable[str] | None = None,
          supported_by: Any = None, profile: str = "core") -> list[Case]:
    """All cases, the same for the same seed.

    operations : names to limit them to;  supported_by : a backend whose functions limit them
    profile : "core"; "full", three times its ground and every sample in every layout; "small", the
    operations' own samples, none of them large; "tf32" or "bfloat16": values in float32, as near as
    products and sums of such numbers allow
    ->  list of Case.   Raises ValueError for an unknown operation or profile.

    >>> [str(c) for c in cases(operations=["gram"]) if c.kind == "refused"]
    ['gram/two dimensions/forward/refused', 'gram/two dimensions/forward/refused, float32']
    """
    names = list(OPERATIONS) if operations is None else list(operations)
    for name in names:
        known_operation(name)
    if profile not in PROFILES:
        raise ValueError(f"profile: found {profile!r}, needed one of {', '.join(PROFILES)}")
    found = [case for name in names for case in _of_operation(OPERATIONS[name], seed, profile)]
    if supported_by is not None:
        functions = as_backend(supported_by).functions
        found = [case for case in found if case.function in functions]
    return found


def answerable(seed: int = 0, operations: Iterable[str] | None = None) -> list[Case]:
    """The cases of the profile small that golden vectors are made of: a call and its answer."""
    return [case for case in cases(seed=seed, operations=operations, profile="small")
            if case.kind in ("float64", "float32", "empty batch")]


def parametrize(backend: Any, *, operations: Iterable[str] | None = None, profile: str = "small",
                seed: int = 0) -> Any:
    """A decorator for pytest: one test for each case of what a backend offers.

    backend : whatever `as_backend` takes;  operations, profile, seed : as for `cases`

        @conformance.parametrize(MINE)
        def test_mine(case, backend):
            case.check(backend)

    Each is called after its case's id, in the same order in every process.
    Raises ValueError for an unknown operation or profile, and where nothing is offered.
    """
    import pytest
    mine = as_backend(backend)
    if operations is None:
        operations = [name for name in OPERATIONS
                      if {name, f"{name}_backward"} & set(mine.functions)]
    chosen = [case for case in cases(seed=seed, operations=operations, supported_by=mine,
                                     profile=profile) if not covering(case, mine.lacks)]
    if not chosen:
        raise ValueError(f"operations: found {', '.join(operations)}, needed some that the backend "
                         "offers")
    return pytest.mark.parametrize("case, backend", [
        pytest.param(case, mine, id=case.id) for case in chosen])


def known_operation(name: str) -> None:
    """Raise ValueError for a name that is no operation."""
    if name not in OPERATIONS:
        raise ValueError(f"operations: found {name!r}, needed some of {', '.join(OPERATIONS)}"
                         + meant(name, OPERATIONS))


@functools.lru_cache(maxsize=8)
def _by_id(name, seed, profile):
    found = cases(seed=seed, operations=[name], profile=profile) if name in OPERATIONS else ()
    return {case.id: case for case in found}


def case(identity: str, *, seed: int = 0) -> Case:
    """The case with this id, to look at a failure.

    ->  Case.   Raises ValueError for an unknown id.
    """
    kind = identity.rpartition("/")[2]
    for profile in (kind,) if kind in COARSE else ("small", "core", "full"):
        found = _by_id(identity.partition("/")[0], seed, profile)
        if identity in found:
            return found[identity]
    raise ValueError(f"case: found no {identity!r}, needed an id as `refimpl check` prints it")


def _of_operation(operation: Operation, seed: int, profile: str) -> Iterator[Case]:
    samples = operation.samples(generator(operation, seed))
    if profile in COARSE:
        yield from of_coarse(operation, [*samples, *ground_of(operation, seed)], seed, profile)
        return
    yield from of_samples(operation, samples, seed, PROFILES.index(profile))
    for again in {"small": (), "core": (0,), "full": (0, 1, 2)}[profile]:
        yield from of_ground(operation, ground_of(operation, seed, again), seed)
    for bad in operation.bad():
        call = Case(f"{operation.name}/{bad.label}/forward/refused", operation, operation.name,
                    "refused", bad.inputs, bad.attributes, argument=bad.argument, seed=seed)
        yield call
        single = in_float32(call)
        if "float32" in operation.precisions and profile != "small" and single is not None:
            yield single
