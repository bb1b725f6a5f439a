"""Are conventions named rightly? Plants faults that follow none, and every rival, and counts the
names. `python -m tests.conformance.attributions`
"""

import functools
import sys

import numpy as np

from refimpl.conformance import cases, judge_all, reference
from refimpl.conformance.specification import as_tuple
from refimpl.conformance.rivals import RIVALS

GOOD = reference().functions


def outputs_changed(function, change):
    """The good function, each of its arrays changed by `change(array, first floating-point
    argument)`.
    """
    def wrong(*arguments, **attributes):
        like = next((a for a in arguments if isinstance(a, np.ndarray) and a.dtype.kind == "f"),
                    np.zeros(1))
        results = as_tuple(GOOD[function](*arguments, **attributes))
        results = tuple(r if r is None else change(r, like) for r in results)
        return results if len(results) > 1 else results[0]
    return wrong


def double_for_single(result, like):
    return result.astype(float) if like.dtype == np.float32 and result.dtype.kind == "f" else result


def rounded_to_single(result, like):
    return result.astype(np.float32).astype(float) if result.dtype == np.float64 else result


def whole_as_floats(result, like):
    return result.astype(float) if result.dtype.kind in "iu" else result


def on_odd_calls(function):
    """Three times the answer on the first, third, fifth ... call."""
    calls = [0]

    def change(result, like):
        return result * 3 if calls[0] % 2 and result.dtype.kind == "f" else result

    def wrong(*arguments, **attributes):
        calls[0] += 1
        return outputs_changed(function, change)(*arguments, **attributes)
    return wrong


def one_element(result, like):
    result = np.array(result)
    if result.size and result.dtype.kind == "f":
        result.flat[np.argmax(np.abs(result))] *= 1.3
    return result


FAULTS = {
    "values right, float64 returned for float32": lambda f: outputs_changed(f, double_for_single),
    "values rounded to float32 for float64": lambda f: outputs_changed(f, rounded_to_single),
    "whole numbers returned as float64": lambda f: outputs_changed(f, whole_as_floats),
    "wrong on every odd call": on_odd_calls,
    "30 % off, the loosest tolerance declared": lambda f:
    outputs_changed(f, lambda r, like: r * r.dtype.type(0.7) if r.dtype.kind == "f" else r),
    "one element off": lambda f: outputs_changed(f, one_element),
    "noise": lambda f: outputs_changed(f, lambda r,
                                       like: r
                                       + np.random.default_rng(0).standard_normal(r.shape).astype(
                                           r.dtype) if r.dtype.kind == "f" else r),
}


@functools.lru_cache(maxsize=None)
def _cases(operation, seed):
    return cases(seed=seed, operations=[operation], profile="small")


def judged(function, wrong, seed, tolerances=None):
    """Failed outcomes of the function's operation with one function replaced."""
    backend = {**GOOD, function: wrong, **({"tolerances": tolerances} if tolerances else {})}
    chosen = [c for c in _cases(function.removesuffix("_backward"), seed) if c.function == function]
    return [o for o in judge_all(backend, chosen) if o.status == "failed"]


def false_names(seed=0):
    """{fault: (failures, failures that name a convention)}"""
    found = {}
    for name, plant in FAULTS.items():
        loosest = {"float64": 0.1, "float32": 0.1} if "tolerance" in name else None
        outcomes = [o for function in RIVALS
                    for o in judged(function, plant(function), seed, loosest)]
        found[name] = len(outcomes), sum(bool(o.rival) for o in outcomes)
    return found


def true_names(seed=0):
    """{(function, rival): (failures, named rightly, named otherwise)}, of failures by value"""
    found = {}
    for function, rivals in RIVALS.items():
        for label, rival in rivals:
            outcomes = [o for o in judged(function, in_precision(rival), seed)
                        if o.grade != "laxer"]
            right = sum(label in o.rival.split(" or ") for o in outcomes)
            found[function, label] = (len(outcomes), right,
                                      sum(bool(o.rival) for o in outcomes) - right)
    return found


def in_precision(rival):
    """A rival whose answers have the precision of its inputs, as an implementation's would."""
    def follows(*arguments, **attributes):
        like = next((a for a in arguments if isinstance(a, np.ndarray) and a.dtype.kind == "f"),
                    None)
        results = tuple(r if r is None or r.dtype.kind != "f" or like is None
                        else r.astype(like.dtype)
                        for r in as_tuple(rival(*arguments, **attributes)))
        return results if len(results) > 1 else results[0]
    return follows


if __name__ == "__main__":
    seed = int(sys.argv[1]) if len(sys.argv) > 1 else 0
    print(
        f"seed {seed}\n\n| fault planted in all {len(RIVALS)} functions that have rivals | "
        "failures | told a convention, all false |\n| --- | --- | --- |")
    for name, (failures, named) in false_names(seed).items():
        print(f"| {name} | {failures} | {named} |")
    rows = true_names(seed)
    total, right, otherwise = (sum(row[i] for row in rows.values()) for i in range(3))
    print(
        f"\nrivals planted: {len(rows)}, failures {total}, named rightly {right}, otherwise "
        f"{otherwise}")
    for (function, label), (failures, good, bad) in rows.items():
        if good < failures or bad:
            print(f"    {function}: {label}: {good} of {failures}, otherwise {bad}")
