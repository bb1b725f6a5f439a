"""Table 1 of Torresani 2006 with what it has to be held against: the mean of the labels, linear
interpolation (also as printed, plus a constant, made affine), several draws of blends with their
spread, both orders of a pair, more examples; and labels of a computed observer, of known efforts,
or of an analyst's sheet.

Errors are mean squared errors over the efforts' scale from -3 to 3; R2 is 1 - error / error of the
mean. The spread is the standard error over draws of blends, each the mean of its splits.
"""

from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from ..torresani2006.database import Blends, Database, blend_inputs, coefficients, random_blends
from ..torresani2006.observe import EFFORTS
from ..torresani2006.pca import fit_pca
from ..torresani2006.regress import (ALPHA, E_I, E_J, fit_model, linear_interpolation, predict)
from ..torresani2006.synthesise import rank_pairs

PAPER_BLENDS, TRAINING, DRAWS, SPLITS = 105, 85, 20, 5
PAPER_TABLE_1 = {                                                # Table 1: flow, weight, time
    "linear interpolation": (0.65, 0.97, 1.01), "linear ridge": (1.03, 1.04, 1.01),
    "kernel ridge": (0.50, 0.39, 0.60), "support vector": (0.48, 0.48, 0.61)}
LEARNT = ("linear ridge", "kernel ridge", "support vector")
SIZES, TRIED = (85, 200, 400, 1000), 200         # blends learnt from and tried, learning curve


def swapped(Z: np.ndarray) -> np.ndarray:
    """The same blends with their parents in the other order: z(i, j, alpha) and z(j, i, 1 - alpha)
    are one blend.   (M, 2 components + 7)  ->  the same

    >>> swapped(np.array([[1.0, 2.0, 3, 3, 3, 4, 4, 4, 0.25]]))
    array([[2.  , 1.  , 4.  , 4.  , 4.  , 3.  , 3.  , 3.  , 0.75]])
    """
    n = (Z.shape[1] - 7) // 2
    return np.concatenate([Z[:, n:2 * n], Z[:, :n], Z[:, E_J], Z[:, E_I], 1 - Z[:, ALPHA]], axis=1)


def answers(Z: np.ndarray, Y: np.ndarray, new: np.ndarray, rng: np.random.Generator,
            learnt: tuple[str, ...] = LEARNT) -> dict[str, np.ndarray]:
    """What every row of the table says of new blends.

    Z, Y : (N, d), (N, 3) to learn from;  new : (M, d);  rng : deals the folds   ->  {row: (M, 3)}
    """
    line, there = linear_interpolation(Z), linear_interpolation(new)
    slope, constant = (np.stack(x) for x in zip(*(np.polyfit(line[:, n], Y[:, n], 1)
                                                  for n in range(3))))
    found = {"mean of the labels": np.broadcast_to(Y.mean(axis=0), (len(new), 3)),
             "linear interpolation as printed": linear_interpolation(
                 np.concatenate([new[:, :-1], 1 - new[:, ALPHA]], axis=1)),
             "linear interpolation": there,
             "plus a constant": there + (Y - line).mean(axis=0),
             "affine": slope * there + constant}
    twice = np.concatenate([Z, swapped(Z)]), np.concatenate([Y, Y])
    for kind in learnt:
        found[kind] = predict(fit_model(kind, Z, Y, rng), new)
    found["kernel ridge, both orders"] = predict(fit_model("kernel ridge", *twice, rng), new)
    return found


def inputs_of(database: Database, made: Blends) -> np.ndarray:
    """z of blends.   ->  (M, d)"""
    pca = fit_pca([fragment.angles for fragment in database.fragments])
    return blend_inputs(coefficients(database, pca), database.styles, made.pairs, made.alpha)


def table_1(draw: Callable[[np.random.Generator], tuple[np.ndarray, np.ndarray]],
            draws: int = DRAWS, splits: int = SPLITS, *, training: int = TRAINING, seed: int = 0,
            learnt: tuple[str, ...] = LEARNT,
            report: Callable[[str], None] = lambda text: None) -> dict[str, np.ndarray]:
    """Mean squared errors over random splits of random draws of blends; each model chooses its
    hyper-parameters anew in every split, by ten-fold cross-validation on its examples alone.

    draw : of a generator, blends' z (N, d) and labels (N, 3);  training : how many to learn from
    ->  {row: (draws, 3)}
    """
    found: dict[str, list[np.ndarray]] = {}
    for n in range(draws):
        rng = np.random.default_rng([seed, 11, n])
        Z, Y = draw(rng)
        errors: dict[str, list[np.ndarray]] = {}
        for _ in range(splits):
            order = rng.permutation(len(Z))
            known, new = order[:training], order[training:]
            for row, said in answers(Z[known], Y[known], Z[new], rng, learnt).items():
                errors.setdefault(row, []).append(((said - Y[new]) ** 2).mean(axis=0))
        for row, values in errors.items():
            found.setdefault(row, []).append(np.mean(values, axis=0))
        report("")
    return {row: np.array(values) for row, values in found.items()}


def drawn(database: Database, blends: int = PAPER_BLENDS
          ) -> Callable[[np.random.Generator], tuple[np.ndarray, np.ndarray]]:
    """Blends of a database, as `table_1` draws them, labelled by its observer."""
    def _draw(rng):
        made = random_blends(database, blends, rng)
        return inputs_of(database, made), made.styles
    return _draw


def remembered(database: Database) -> Database:
    """The same database, which makes a blend only once, however often it is labelled."""
    made: dict[tuple[str, str, float], Any] = {}

    def _between(a, b, alpha, body):
        key = a.name, b.name, float(alpha)
        if key not in made:
            made[key] = database.between(a, b, alpha, body)
        return made[key]
    return replace(database, between=_between)


def over_draws(errors: Mapping[str, np.ndarray]) -> dict[str, dict[str, list[float]]]:
    """Of `table_1`: mean, standard error and R2 of every row, rounded to three digits.

    >>> errors = {"mean of the labels": np.ones((2, 3)), "affine": np.full((2, 3), 0.25)}
    >>> over_draws(errors)["affine"]
    {'error': [0.25, 0.25, 0.25], 'spread': [0.0, 0.0, 0.0], 'R2': [0.75, 0.75, 0.75]}
    """
    null = errors["mean of the labels"].mean(axis=0)
    spread = {row: x.std(axis=0, ddof=1) / np.sqrt(len(x)) if len(x) > 1 else np.zeros(3)
              for row, x in errors.items()}
    return {row: {"error": x.mean(axis=0).round(3).tolist(),
                  "spread": spread[row].round(3).tolist(),
                  "R2": (1 - x.mean(axis=0) / np.maximum(null, 1e-12)).round(3).tolist()}
            for row, x in errors.items()}


def table_rows(found: Mapping[str, Mapping[str, list[float]]]) -> list[list[str]]:
    """A over_draws as a table, beside the paper's.

    >>> table_rows({"affine": {"error": [1, 2, 3], "spread": [0, 0, 0], "R2": [0.5, 0, -1]}})[1][:3]
    ['affine', '1.00 ± 0.00', '2.00 ± 0.00']
    """
    rows = [["model", *EFFORTS, *(f"R2 {effort}" for effort in EFFORTS), "paper"]]
    for row, x in found.items():
        paper = PAPER_TABLE_1.get(row)
        rows.append([row, *(f"{e:.2f} ± {s:.2f}" for e, s in zip(x["error"], x["spread"])),
                     *(f"{r:.2f}" for r in x["R2"]),
                     " ".join(f"{p:.2f}" for p in paper) if paper else ""])
    return rows


def learning_curve(database: Database, *, sizes: tuple[int, ...] = SIZES, draws: int = 3,
                   seed: int = 0, report: Callable[[str], None] = lambda text: None
                   ) -> dict[str, dict[str, list[float]]]:
    """Errors, mean of the three efforts, with ever more blends to learn from: one pool of blends,
    dealt anew `draws` times.

    A large pool has every pair of fragments several times. About `TRIED` others to try on are
    therefore dealt twice: with pairs that were learnt from, too, at other alphas; and with pairs
    that were not.   ->  {size: {row: mean and standard error over the deals}}
    """
    rng, found = np.random.default_rng([seed, 17]), {}
    made = random_blends(database, max(sizes) + 5 * TRIED // 2, rng, lambda done: report(""))
    Z, Y = inputs_of(database, made), made.styles
    pair = np.unique(np.sort(made.pairs, axis=1), axis=0, return_inverse=True)[1].ravel()
    count = (pair.max() + 1) * TRIED // len(Z)
    deals = []
    for _ in range(draws):
        deal = rng.permutation(len(Z))
        kept = np.isin(pair[deal], rng.permutation(pair.max() + 1)[:count])
        deals.append((deal[~kept], deal[kept]))
    for size in sizes:
        errors: dict[str, list[dict[str, float]]] = {}
        for rest, unknown in deals:
            new = np.concatenate([rest[-TRIED:], unknown])
            said = answers(Z[rest[:size]], Y[rest[:size]], Z[new], rng, ("kernel ridge",))
            for name, some in ((f"{size}", slice(None, TRIED)),
                               (f"{size}, other pairs", slice(TRIED, None))):
                errors.setdefault(name, []).append({
                    row: ((said[row] - Y[new])[some] ** 2).mean() for row in (
                        "mean of the labels", "linear interpolation", "affine", "kernel ridge",
                        "kernel ridge, both orders")})
        for name, rows in errors.items():
            found[name] = {row: _mean([some[row] for some in rows]) for row in rows[0]}
    return found


def support_vectors(draw: Callable[[np.random.Generator], tuple[np.ndarray, np.ndarray]],
                    draws: int = 5, *, training: int = TRAINING, seed: int = 0
                    ) -> dict[str, dict[str, Any]]:
    """How sparse support vector regression is: the share of the examples that it keeps, by effort,
    and its error beside that of a mean."""
    shares, errors = [], []
    for n in range(draws):
        rng = np.random.default_rng([seed, 22, n])
        Z, Y = draw(rng)
        machine = fit_model("support vector", Z[:training], Y[:training], rng)
        shares.append((np.abs(machine.weights) > 1e-9).mean(axis=0))
        new = Y[training:]
        errors.append(((predict(machine, Z[training:]) - new) ** 2).mean(axis=0)
                      / ((Y[:training].mean(axis=0) - new) ** 2).mean(axis=0))
    return {f"of {training} examples": {
        "kept": np.mean(shares, axis=0).round(2).tolist(),
        "error beside the mean's": np.mean(errors, axis=0).round(2).tolist()}}


def samples_tried(database: Database, model: Any, pca: Any, *, seed: int = 0,
                  samples: tuple[int, ...] = (2, 3, 5, 9, 13, 25, 49)
                  ) -> dict[str, dict[str, list[float]]]:
    """How far predictions stay from 20 random styles (equation 12), by M.

    ->  {M: {"best pair", "all pairs": mean of || e - f || and its standard error}}
    """
    rng = np.random.default_rng([seed, 18])
    members = np.flatnonzero([f.content == database.fragments[0].content
                              for f in database.fragments])
    targets, found = rng.uniform(-3, 3, (20, 3)), {}
    for M in samples:
        errors = [[c.error for c in rank_pairs(database, model, pca, members, target, M)]
                  for target in targets]
        found[str(M)] = {"best pair": _mean([x[0] for x in errors]),
                         "all pairs": _mean(np.mean(errors, axis=1))}
    return found


def _mean(x):
    """Mean and standard error, rounded."""
    return [round(float(np.mean(x)), 3), round(float(np.std(x, ddof=1) / np.sqrt(len(x))), 3)]
