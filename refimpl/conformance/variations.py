"""What is asked about a sample: both precisions, every layout of every argument, promises, and what
`extremes` adds."""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace
import zlib

import numpy as np

from ..gradcheck.contract import LAYOUTS
from ..gradcheck.structure import is_float
from .calls import Case, answered, in_single, precisions
from .extremes import beside, poisoned, ranges
from .specification import Operation, Sample, cast, cast_attributes

APART = 4                           # of so many samples one has large and small clips side by side
OF_VALUES = ("leaves its inputs alone", "same bits twice", "memory of its own",
             "reads its arguments anew")
COARSE = {"tf32": 2.0 ** -10, "bfloat16": 2.0 ** -7}      # the last digit of what is multiplied
PROMISES = (*OF_VALUES, "linear in the upstream gradient")


def generator(operation: Operation, seed: int) -> np.random.Generator:
    """The random numbers of an operation depend on the seed and its name alone, so that a new
    operation changes no other's cases."""
    return np.random.default_rng([seed, zlib.crc32(operation.name.encode())])


def ground_of(operation: Operation, seed: int, again: int = 0) -> list[Sample]:
    """The samples of an operation's ground.   again : for others of the same kinds"""
    key = [seed, 1 + again, zlib.crc32(operation.name.encode())]
    found = operation.ground(np.random.default_rng(key))
    if not again:
        return found
    names: dict[str, int] = {}
    for sample in found:
        names[sample.label] = names.get(sample.label, 0) + 1
    return [replace(sample, label=f"{sample.label}, again {again}") for sample in found
            if names[sample.label] == 1]


def of_coarse(operation: Operation, samples: Iterable[Sample], seed: int,
              profile: str) -> Iterator[Case]:
    """Values in float32, for backends that round what they multiply to fewer digits; not where a
    last digit decides, nor beyond the range."""
    if "float32" not in operation.precisions:
        return
    rng = generator(operation, seed + 3)
    for sample in samples:
        plain = sample.smooth and not (sample.exact or sample.firm or sample.large)
        for call, reference, known in _calls(operation, sample, rng, seed) if plain else ():
            case = answered(in_single(call), reference, profile)
            sizes = [np.abs(x[x != 0]) for x in (*call.arguments, *(case.expected or ()))
                     if is_float(x)]
            usual = all(not x.size or (x.min() > 1e-6 and x.max() < 1e6) for x in sizes)
            if usual and case.yardstick is not None:
                yield replace(case, digits=COARSE[profile],
                              yardstick=case.yardstick.coarse(COARSE[profile]))


def of_samples(operation: Operation, samples: Sequence[Sample], seed: int,
               profile: int) -> Iterator[Case]:
    """All that is asked about an operation's own samples.

    profile : 0 for few questions, 1 for many about some samples, 2 for many about all
    """
    thorough = profile > 0
    rng, smooth = generator(operation, seed + 2), [s for s in samples if s.smooth]
    others = _other_calls(operation, seed)
    for number, sample in enumerate(samples):
        calls = list(_calls(operation, sample, rng, seed))
        for call, reference, known in calls:
            yield from _values(call, reference, known, sample)
        chosen = number == 0 or (thorough and any(sample is other for other in (
            smooth if profile > 1 else (smooth[-1], _most_axes(smooth)))))
        for call, reference, _ in calls if chosen else ():
            yield from _layouts(call, reference, sample, thorough)
            if thorough and call.function.endswith("_backward"):
                yield from _plain_upstream(call, reference)
            if thorough and operation.backward:
                yield from _spread_out(call, reference)
            yield from _promises(call, reference, others, thorough)
            if thorough:
                yield from _alike(call, reference)
        if number == 0 and operation.batched:
            yield from _empty_batch(operation, sample, rng, seed, thorough)
        elif thorough and sample.smooth and not chosen:
            for call, reference, _ in calls:
                yield from _own_memory(call, reference)
        if chosen and thorough:
            for call, reference, _ in calls:
                yield from poisoned(call, reference)
                if "float32" in operation.precisions:
                    yield from ranges(call, reference)


def of_ground(operation: Operation, samples: Iterable[Sample], seed: int) -> Iterator[Case]:
    """Values in both precisions."""
    rng = generator(operation, seed + 3)
    for number, sample in enumerate(samples):
        for call, reference, known in _calls(operation, sample, rng, seed):
            yield from _values(call, reference, known, sample)
            if not sample.large:
                yield from _own_memory(call, reference)
            plain = sample.smooth and not (sample.large or sample.exact or sample.firm)
            if number % APART == 0 and operation.whole_range and operation.batched and plain:
                yield from beside(call, reference)


def in_float32(call: Case) -> Case | None:
    """The same call in single precision, None where the arguments have none."""
    kinds = {x.dtype for x in call.arguments if is_float(x)}
    if kinds != {np.dtype(float)}:
        return None
    return replace(in_single(call), id=f"{call.id}, float32")


def _calls(operation, sample, rng, seed):
    """The forward and the backward call of a sample.

    ->  yields Case without a kind, reference, known answer or None
    """
    known = sample.known or {}
    call = Case(f"{operation.name}/{sample.label}/forward", operation, operation.name, "",
                sample.inputs, sample.attributes, seed=seed, factors=sample.factors)
    yield call, operation.f, known.get("outputs") if operation.backward else None
    if operation.backward and (sample.smooth or known or sample.exact):
        shape = np.shape(operation.f(*sample.inputs, **sample.attributes))
        upstream = (known["upstream"] if known else rng.standard_normal(shape)
                    if sample.upstream is None else np.full(shape, sample.upstream))
        yield (replace(call, id=f"{operation.name}/{sample.label}/backward",
                       function=f"{operation.name}_backward",
                       arguments=(np.asarray(upstream), *sample.inputs)),
               operation.backward, known.get("gradients"))


def _values(call, reference, known, sample):
    decided = not sample.smooth or sample.exact
    for one, _ in precisions(call):
        exact = sample.exact or (decided and known is not None and not one.single)
        case = answered(one, reference, one.precision, whole=decided, exact=exact,
                        firm=sample.firm)
        yield replace(case, expected=known) if known else case


def _layouts(call, reference, sample, thorough):
    for one, precision in precisions(call, thorough):
        arrays = [i for i, x in enumerate(one.arguments) if isinstance(x, np.ndarray) and x.ndim]
        alone = arrays if thorough and len(arrays) > 1 else []
        found = answered(one, reference, "")
        for number, layout in enumerate(LAYOUTS):
            for only in [None, *(alone if not precision or number % 2 == 0 else ())]:
                kind = layout + precision + (f", {one.names[only]} alone" if only in alone else "")
                yield replace(found, id=found.id + kind, kind=kind, layout=layout, only=only)


def _spread_out(call, reference):
    """Each argument in turn as np.broadcast_to gives it: one clip, or element, read many times."""
    for one, precision in precisions(call):
        for i, x in enumerate(one.arguments):
            if is_float(x) and x.ndim and len(x) > 1:
                for layout, same in (("stride 0", np.repeat(x[:1], len(x), axis=0)),
                                     ("stride 0 of the last axis", np.repeat(
                                         x[..., :1], x.shape[-1], axis=-1)),
                                     ("every stride 0", np.full_like(x, x.flat[0]))):
                    put = replace(one, arguments=(*one.arguments[:i], same, *one.arguments[i + 1:]))
                    try:
                        yield answered(put, reference, f"{layout}, {one.names[i]}{precision}",
                                       layout=layout, only=i)
                    except ValueError:                           # a special matrix or sequence
                        continue


def _promises(call, reference, others, thorough):
    for one, precision in precisions(call, thorough):
        found = answered(one, reference, "")
        for promise in PROMISES if call.function.endswith("_backward") else OF_VALUES:
            other = tuple((cast(a, np.float32), cast_attributes(k, np.float32)) if precision
                          else (a, k) for a, k in others[call.function])
            yield _promise(found, promise + precision, others=other)


def _alike(call, reference):
    """The call after one of the same sizes, ends and sums, that differs in the middle alone: what
    remembers its arguments by less than all of them answers for the first."""
    def _first_call(x):
        y = x.copy()
        if x.ndim == 2 and np.array_equal(x, x.T):               # a kernel, or distances
            order = np.arange(len(x))
            order[1:-1] = order[-2:0:-1]
            return x[order][:, order]
        if x.shape[-2:] == (3, 3):                               # rotations
            y[1:-1] = y[-2:0:-1]
            return y
        inner = y.reshape(-1)[1:-1]
        inner[:] = inner[::-1].copy()
        return y
    for one, precision in precisions(call):
        arrays = [i for i, x in enumerate(one.arguments) if is_float(x) and x.size > 3]
        fresh = tuple(x * x.dtype.type(1.25) if i in arrays and x.shape[-2:] != (3, 3) else x
                      for i, x in enumerate(one.arguments))      # no call before had these
        for chosen in [arrays, *([i] for i in arrays if len(arrays) > 1)]:
            moved = tuple(_first_call(x) if i in chosen else x for i, x in enumerate(fresh))
            what = "" if chosen == arrays else f" but for {one.names[chosen[0]]}"
            try:
                reference(*moved, **one.attributes)
            except ValueError:                                   # it has to be a special one
                continue
            yield answered(replace(one, arguments=fresh), reference, f"after one like it{what}"
                           f"{precision}", others=((moved, one.attributes),))


def _own_memory(call, reference):
    for one, precision in precisions(call):
        yield _promise(answered(one, reference, ""), "memory of its own" + precision)


def _plain_upstream(call, reference):
    """Where a factor comes to 1, the argument itself would be the answer."""
    for factor in (1.0, 0.5):
        one = replace(call, id=f"{call.id}/upstream of {factor:g}", arguments=(
            np.full_like(call.arguments[0], factor), *call.arguments[1:]))
        yield from _own_memory(one, reference)


def _promise(found, kind, **changes):
    return replace(found, id=found.id + kind, kind=kind, **changes)


def _most_axes(samples):
    """The first sample with the most axes: of a vector every layout is alike."""
    return max(samples, key=lambda s: sum(np.ndim(x) for x in s.inputs if x is not None))


def _other_calls(operation, seed):
    """Valid calls with other numbers: of the first sample's shapes, and of the second's.

    ->  {function: ((arguments, attributes), ...)}
    """
    rng = generator(operation, seed + 1)
    found: dict[str, tuple] = {}
    for sample in operation.samples(rng)[:2]:
        for call, _, _ in _calls(operation, sample, rng, seed):
            there = found.get(call.function, ())
            found[call.function] = (*there, (call.arguments, call.attributes))
    return found


def _empty_batch(operation, sample, rng, seed, thorough):
    empty = tuple(a[:0] if i in operation.batched else a for i, a in enumerate(sample.inputs))
    upstream = np.zeros(np.shape(operation.f(*empty, **sample.attributes)))
    sample = Sample(sample.label, empty, sample.attributes, known={"upstream": upstream})
    for call, reference, _ in _calls(operation, sample, rng, seed):
        for one, precision in precisions(call, thorough):
            yield answered(one, reference, "empty batch" + precision)
