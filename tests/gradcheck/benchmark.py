"""How well checkers of gradients judge 34 wrong gradients and 37 right ones (`cases.py`,
`cases_right.py`), and whether what they say is true.

    python -m tests.gradcheck.benchmark

runs `check_gradient` and, where they are installed, PyTorch's `gradcheck` and JAX's `check_grads`
over 20 draws of each case and writes BENCHMARK.md beside this file. `--draws 3 --only relu --out
FOLDER/page.md` is shorter.
"""

import argparse
from collections import Counter
from importlib import metadata
import importlib.util
from pathlib import Path
import re
from typing import Callable, NamedTuple
import warnings

import numpy as np

from refimpl import gradcheck
from tests.gradcheck.cases import Case, WRONG
from tests.gradcheck.cases_right import RIGHT
from tests.gradcheck.witness import Witness, leaves, replaced

# From the best to the worst that a checker can do with a case; a case counts by its worst draw.
VERDICTS = {False: ("refused", "undecided", "not taken", "accepted"),
            True: ("accepted", "undecided", "not taken", "refused")}
INTRODUCTION = """# How well checkers of gradients judge

Written by `python -m tests.gradcheck.benchmark`: {wrong} wrong gradients and {right} right ones
(`cases.py`, `cases_right.py`), draws of the inputs for each: {draws}. A peer in PyTorch or JAX gets
the same NumPy functions through a custom function, with its default settings, and one draw of the
case of 60,000 elements. {versions}

A case counts by its worst draw. *False sentences* are the cases in which some draw was told what is
not so: a wrong gradient accepted, a right one called wrong, or a wrong one refused with a "needed"
or a reason that is not the truth. Of the peers' messages the verdict alone is judged. *Not taken*
are errors other than a verdict: inputs, outputs or a backward that the checker cannot handle.
"""
HEADER = [
    "| checker | wrong: refused | by a true sentence | undecided | not taken | accepted "
    "| right: accepted | undecided | not taken | refused | false sentences |",
    "| --- " + "| --: " * 10 + "|"]


class Answer(NamedTuple):
    """What a checker says of one draw, and whether that is true."""
    verdict: str
    true: bool
    message: str = ""


def ours(case: Case, seed: int) -> Answer:
    """`check_gradient`; whatever else it raises than its own errors counts as not taken."""
    witness, message = Witness(case), ""
    inputs = case.inputs(seed)
    try:
        gradcheck.check_gradient(witness.f, witness.f_backward, *inputs, seed=seed)
        verdict = "accepted"
    except gradcheck.GradientError as error:    # older versions know no UndecidedError
        undecided = isinstance(error, getattr(gradcheck, "UndecidedError", ()))
        verdict, message = "undecided" if undecided else "refused", str(error)
    except Exception as error:
        verdict, message = "not taken", f"{type(error).__name__}: {error}"
    true = (case.right == (verdict == "accepted") if verdict in ("accepted", "not taken") else
            not (case.right and verdict == "refused") and witness.bears_out(message))
    return Answer(verdict, true or verdict == "not taken", message)


def moving(case: Case, inputs: tuple) -> tuple[list, Callable, Callable]:
    """The arrays that have a gradient, f and f_backward of them alone, as NumPy's arrays."""
    y = case.f(*inputs)
    dy = tuple(map(np.ones_like, y)) if isinstance(y, tuple) else np.ones_like(y)
    truth, arrays = leaves(case.truth(dy, *inputs), inputs), leaves(inputs, inputs)
    kept = [i for i, t in enumerate(truth) if t is not None]

    def whole(values):
        place = dict(zip(kept, map(np.asarray, values)))
        return replaced(inputs, [place.get(i, x) for i, x in enumerate(arrays)])

    def f(*values):
        y = case.f(*whole(values))
        return tuple(map(np.asarray, y)) if isinstance(y, tuple) else np.asarray(y)

    def back(dy, *values):
        inputs = whole(values)
        gradients = leaves(case.f_backward(dy, *inputs), inputs)
        return tuple(np.asarray(gradients[i]) for i in kept)
    return [arrays[i] for i in kept], f, back


def torch_checker(fast: bool) -> Callable:
    import torch
    from torch.autograd.gradcheck import GradcheckError

    def check(case: Case, seed: int) -> Answer:
        arrays, f, back = moving(case, case.inputs(seed))

        class Adapted(torch.autograd.Function):
            @staticmethod
            def forward(ctx, *tensors):
                ctx.save_for_backward(*tensors)
                y = f(*(t.detach().numpy() for t in tensors))
                return (tuple(map(torch.tensor, y)) if isinstance(y, tuple) else torch.tensor(y))

            @staticmethod
            def backward(ctx, *dy):
                dy = tuple(d.numpy() for d in dy)
                gradients = back(dy if len(dy) > 1 else dy[0],
                                 *(t.detach().numpy() for t in ctx.saved_tensors))
                return tuple(map(torch.from_numpy, gradients))

        try:
            torch.autograd.gradcheck(Adapted.apply, [
                torch.tensor(x, requires_grad=True) for x in arrays], fast_mode=fast)
        except GradcheckError as error:
            return Answer("refused", not case.right, str(error))
        return Answer("accepted", case.right)
    return check


def jax_checker() -> Callable:
    import jax
    from jax.test_util import check_grads
    jax.config.update("jax_enable_x64", True)

    def check(case: Case, seed: int) -> Answer:
        arrays, f, back = moving(case, case.inputs(seed))
        shapes = jax.tree.map(lambda x: jax.ShapeDtypeStruct(x.shape, x.dtype),
                              (f(*arrays), tuple(arrays)))

        @jax.custom_vjp
        def adapted(*values):
            return jax.pure_callback(f, shapes[0], *values)

        def backward(values, dy):
            return jax.pure_callback(lambda dy, *values: back(
                jax.tree.map(np.array, dy), *values), shapes[1], dy, *values)

        adapted.defvjp(lambda *values: (adapted(*values), values), backward)
        try:
            check_grads(adapted, tuple(arrays), order=1, modes=["rev"])
        except AssertionError as error:
            return Answer("refused", not case.right, str(error))
        return Answer("accepted", case.right)
    return check


def checkers() -> dict[str, Callable]:
    """`check_gradient` and the peers that are installed, by name."""
    found = {"`check_gradient`": ours}
    if importlib.util.find_spec("torch"):
        found |= {"PyTorch": torch_checker(False), "PyTorch, fast": torch_checker(True)}
    return found | ({"JAX": jax_checker()} if importlib.util.find_spec("jax") else {})


def answers(check: Callable, case: Case, draws: int) -> list[Answer]:
    """One for each draw; a peer gets a single one of the largest case."""
    if check is not ours and sum(x.size for x in leaves(*[case.inputs(0)] * 2)) > 10_000:
        draws = 1
    said = []
    for seed in range(draws):
        try:
            with warnings.catch_warnings(), np.errstate(all="ignore"):
                warnings.simplefilter("ignore")
                said.append(check(case, seed))
        except Exception as error:
            said.append(Answer("not taken", True, f"{type(error).__name__}: {error}"))
    return said


def worst(case: Case, said: list[Answer]) -> str:
    return max((a.verdict for a in said), key=VERDICTS[case.right].index)


def totals(results: list[tuple[Case, list[Answer]]]) -> list[int]:
    """The cells of one line of the page's first table."""
    count = Counter((case.right, worst(case, said)) for case, said in results)
    true = sum(all(a.true for a in said) and not case.right and worst(case, said) == "refused"
               for case, said in results)
    return [count[False, "refused"], true, *(count[False, v] for v in VERDICTS[False][1:]),
            *(count[True, v] for v in VERDICTS[True]),
            sum(not all(a.true for a in said) for _, said in results)]


def cell(said: list[Answer]) -> str:
    told = Counter(a.verdict + ("" if a.true else " (false)") for a in said)
    return ", ".join(word if len(told) == 1 else f"{word} {n}" for word, n in told.most_common())


def versions() -> str:
    return "Versions: " + ", ".join(f"{name} {metadata.version(name)}" for name in (
        "numpy", "torch", "jax") if importlib.util.find_spec(name)) + "."


def page(results: dict[str, list[tuple[Case, list[Answer]]]], draws: int) -> str:
    """Counts first, then case by case."""
    some = next(iter(results.values()))
    nulls = {f"null: {word} everything": [
        (case, [Answer(verdict, case.right == (verdict == "accepted"))]) for case, _ in some]
        for word, verdict in (("accept", "accepted"), ("refuse", "refused"))}
    right = sum(case.right for case, _ in some)
    lines = [INTRODUCTION.format(draws=draws, versions=versions(), wrong=len(some) - right,
                                 right=right), *HEADER]
    lines += [f"| {name} | " + " | ".join(map(str, totals(result))) + " |"
              for name, result in (nulls | results).items()]
    for right, title in ((False, "Wrong gradients"), (True, "Right gradients")):
        lines += ["", f"## {title}", "", "| case | what is special | " + " | ".join(results) + " |",
                  "| --- " * (2 + len(results)) + "|"]
        for row in zip(*results.values()):
            if row[0][0].right == right:
                cells = [row[0][0].name, row[0][0].special, *(cell(said) for _, said in row)]
                lines.append("| " + " | ".join(c.replace("|", "\\|") for c in cells) + " |")
    return "\n".join(lines) + "\n"


def main(cases: list[Case] = WRONG + RIGHT, out: Path = Path(__file__).with_name("BENCHMARK.md")):
    """Judge the checkers by the cases, write the page, print it."""
    parser = argparse.ArgumentParser(description=main.__doc__)
    parser.add_argument("--draws", type=int, default=20)
    parser.add_argument("--only", default="", help="a regular expression that names must match")
    parser.add_argument("--out", type=Path, default=out)
    parser.add_argument("--ours", action="store_true", help="no peers")
    parser.add_argument("--messages", action="store_true", help="print what is false, in full")
    asked = parser.parse_args()
    chosen = [case for case in cases if re.search(asked.only, case.name)]
    checks = {"`check_gradient`": ours} if asked.ours else checkers()
    results = {name: [(case, answers(check, case, asked.draws)) for case in chosen]
               for name, check in checks.items()}
    if asked.messages:
        for case, said in next(iter(results.values())):
            for seed, a in enumerate(said):
                if not a.true or a.verdict == "not taken":
                    print(f"--- {case.name}, draw {seed}: {a.verdict}\n{a.message}")
    asked.out.write_text(page(results, asked.draws), encoding="utf-8")
    print(asked.out.read_text(encoding="utf-8"))


if __name__ == "__main__":
    main()
