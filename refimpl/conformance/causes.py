"""Failures put together by what they have in common, so that one fault is one line.

A cause is a function, a symptom (raises ValueError, answers in float32, other numbers ...) and,
where there is one, the condition that such calls share: an option, an argument left out, a layout,
a precision, a sample. A condition is named only if most of the calls that meet it fail.
"""

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import groupby
import re
from typing import Any

from .variations import PROMISES

# Of what an operation is made, in the order of computing; what is wrong first is looked at first.
_NETWORK = ("conv1d", "relu", "max_pool1d")
PARTS = {
    "encode": _NETWORK, "encode_2016": _NETWORK,
    "decode": ("avg_depool1d", "random_depool1d", "conv_transpose1d"),
    "decode_2016": ("avg_depool1d", "random_depool1d", "conv1d"),
    "transform": ("conv1d", "relu"),
    "autoencoder_loss": ("encode", "decode", "squared_error", "l1"),
    "autoencoder_loss_2016": ("encode_2016", "decode_2016", "squared_error", "l1"),
    "content_loss": ("norm", "mean_squares", "sum_squares"),
    "style_loss": ("gram", "norm", "mean_squares", "sum_squares"),
    "foot_loss": ("sum_squares",), "bone_loss": ("sum_squares",),
    "total_loss": ("transform", "encode", "content_loss", "style_loss", "foot_loss", "bone_loss",
                   "trajectory_loss"),
    "search_loss_2016": ("gram", "mean_squares"), "max_pool1d": ("max_pool1d_indices",),
    "dtw_path": ("dtw_cost",), "one_stage_segmentation": ("dtw_cost",),
    "continuous_exponential_maps": ("rotation_vector",),
    "predicted_style": ("gaussian_kernel", "linear_ridge", "kernel_ridge",
                        "support_vector_regression"),
    "best_alpha": ("golden_section",)}
KIND = re.compile(r"(, float32|, .* alone| apart|, [A-Za-z_0-9 ]+$)")
# of a function's calls: then it is all of it
NEARLY_ALL = 0.9
MOST = 0.75                                             # of the calls that meet a condition


@dataclass(frozen=True)
class Cause:
    """What some failures have in common.

    function, symptom : what is asked, and how it shows;  condition : what the calls share, "" where
    nothing does;  outcomes : the failures;  asked : how many calls met the condition;  first : the
    function that is wrong as well and of which this one is made, "" where there is none
    """

    function: str
    symptom: str
    condition: str
    outcomes: tuple
    asked: int
    first: str = ""

    def __str__(self) -> str:
        """One line.

        >>> str(Cause("gram", "other numbers", "float32", (1, 2), 2))
        'gram: other numbers in all 2 calls with float32'
        """
        count = len(self.outcomes)
        of = f"all {count}" if count == self.asked else f"{count} of {self.asked}"
        where = f"{of} call{'s' * (self.asked != 1)}" + (f" with {self.condition}"
                                                         if self.condition else "")
        return f"{self.function}: {self.symptom} in {where}" + (
            f"; look at {self.first} first, of which it is made and which is wrong too"
            if self.first else "")


def causes(outcomes: Sequence[Any]) -> list[Cause]:
    """The failures among all outcomes, put together; the parts before what is made of them.

    list of Outcome  ->  list of Cause
    """
    wrong = {o.case.function for o in outcomes if o.grade in ("wrong", "convention")}
    found = []
    for function, group in groupby(sorted(outcomes, key=lambda o: o.case.function),
                                   key=lambda o: o.case.function):
        judged = [o for o in group if o.grade != "not offered"]
        first = first_wrong(function, wrong)
        for symptom, failed in _by_symptom(o for o in judged if o.status == "failed"):
            found += _conditions(function, symptom, failed, judged, first)
    return sorted(found, key=lambda cause: (bool(cause.first), -len(cause.outcomes)))


def first_wrong(function: str, wrong: set[str]) -> str:
    """The first of the functions that are wrong of which this one is made, "" where none is.

    >>> first_wrong("total_loss", {"gram", "style_loss"})
    'gram'
    """
    name = function.removesuffix("_backward")
    parts = list(PARTS.get(name, ()))
    if function != name:
        parts += [f"{part}_backward" for part in reversed(parts)]
    for part in parts:
        deeper = first_wrong(part, wrong)
        if deeper or part in wrong:
            return deeper or part
    return ""


def symptom(outcome: Any) -> str:
    """How a failure shows, in a few words that others of its kind share."""
    o = outcome
    if o.rival:
        return o.rival
    if o.error is not None or o.message.split(": ", 1)[-1].startswith("raised "):
        return "raises " + re.split(r"raised |:|\n", o.message.split(": ", 1)[-1])[1]
    if o.grade == "laxer":
        return "takes what is to be refused"
    if o.case.kind.startswith("linear"):
        return "not linear in the upstream gradient"
    if not isinstance(o.found, str):
        return "other numbers"
    return re.sub(r"^shape .*", "another shape", o.found)


def _by_symptom(failed):
    key = symptom
    for name, group in groupby(sorted(failed, key=key), key=key):
        yield name, list(group)


def _conditions(function, said, failed, judged, first):
    """Causes of one symptom: conditions that few agreeing calls meet, the widest first."""
    kinds = {_family(o.case) for o in failed}
    judged = [o for o in judged if _family(o.case) in kinds]
    if len(failed) >= NEARLY_ALL * len(judged):
        return [Cause(function, said, "", tuple(failed), len(judged), first)]
    met = {id(o): conditions_of(o.case) for o in judged}
    asked = Counter(condition for o in judged for condition in met[id(o)])
    found, left = [], list(failed)
    while left:
        here = Counter(condition for o in left for condition in met[id(o)])
        sure = [c for c, n in here.items() if n > 1 and n >= MOST * asked[c]]
        if not sure:
            break
        best = max(sure, key=lambda c: (here[c], -asked[c], -len(c)))
        mine = tuple(o for o in left if best in met[id(o)])
        found.append(Cause(function, said, best, mine, asked[best], first))
        left = [o for o in left if best not in met[id(o)]]
    if left:
        found.append(Cause(function, said, "", tuple(left), len(judged), first))
    return found


def _family(case):
    kind = case.kind.removesuffix(", float32")
    return kind if kind in PROMISES or kind == "refused" else "values"


def conditions_of(case: Any) -> set[str]:
    """What may be said of a call: options, arguments left out, kind, layout, precision.

    >>> from refimpl.conformance import case
    >>> sorted(conditions_of(case("avg_depool1d/three/forward/float64")))
    ['float64', 'the sample "three"', 'width=3']
    """
    found = {f'the sample "{case.id.split("/")[1]}"'}
    if case.kind != "refused":
        found.add(case.precision)
    for name, value in [*case.attributes.items(), *zip(case.names, case.arguments)]:
        if value is None or isinstance(value, (str, bool, int, float, tuple)):
            found.add(f"{name}={value}" if value is not None else f"no {name}")
            if name in case.attributes:
                found.add(f"{name} given")
        elif name in case.attributes:
            found.add(f"{name} given")
    kind = case.kind.removesuffix(", float32")
    if kind not in PROMISES and kind not in ("float64", "float32", "refused"):
        found.add(KIND.sub("", kind))
    return found
