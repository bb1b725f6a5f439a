"""Experiments of section 8: casts, Figure 1, blends of two and of three. `learning` has Table 1,
`phrases` contents, segmentation and synthesis, `sheets` what an analyst sees and fills in.
"""

from collections.abc import Callable
from dataclasses import dataclass, field
import os
from pathlib import Path
from typing import Any

import numpy as np

from ..motion.dataset import PATTERN, find_clips, labels_by_pattern
from ..embedded import performers as embedded
from ..embedded.sample import BANDAI
from ..torresani2006.align import HIGHEST, LOWEST
from ..torresani2006.blend import as_printed, peak_acceleration, steady_blend
from ..torresani2006.database import (Database, blend_inputs, coefficients, embedded_database,
                                      random_pairs, read_database, without)
from ..torresani2006.efforts import BY_SWINGS
from ..torresani2006.observe import Sight, observe
from ..torresani2006.pca import PrincipalComponents
from ..torresani2006.regress import StyleModel, linear_interpolation, predict

CAST_ACTIONS, PERFORMERS = 5, 12


class ExperimentError(ValueError):
    """Clips that do not make the experiment."""


@dataclass(frozen=True)
class Cast:
    """A database of every action by every performer.

    performer : (N,) names, one for each fragment;  efforts : (N, 3) where they are known.
    """

    database: Database
    performer: np.ndarray = field(repr=False)
    efforts: np.ndarray | None = field(default=None, repr=False)


def embedded_cast(performers: int = PERFORMERS, sight: Sight = BY_SWINGS) -> Cast:
    """The five actions of the embedded performers.

    >>> embedded_cast(2).performer.tolist()[:4]
    ['000', '001', '000', '001']
    """
    database = embedded_database(performers, sight=sight)
    who = np.array([f.name.rsplit("_", 1)[1] for f in database.fragments])
    return Cast(database, who, np.array([embedded.own_effort(int(name)) for name in who]))


def folder_cast(folder: str | Path, pattern: str = PATTERN, actions: int = CAST_ACTIONS,
                performers: int = PERFORMERS,
                report: Callable[[Path], None] = lambda path: None) -> Cast:
    """Five actions by twelve performers from a folder of clips, or as many as it has: the actions
    that most performers do, then the first performers of all of them, both by the alphabet where
    equal. The style in a file's name stands for the performer; of several takes the first is taken.

    Raises ExperimentError when the folder has not two actions by the same three performers.
    """
    named = labels_by_pattern(find_clips(folder), pattern)
    first: dict[tuple[str, str], Path] = {}
    by_action: dict[str, set[str]] = {}
    for path in sorted(named):
        first.setdefault(named[path], path)
    for content, style in first:
        by_action.setdefault(content, set()).add(style)
    chosen = sorted(by_action, key=lambda content: (-len(by_action[content]), content))[:actions]
    shared = set.intersection(*(by_action[content] for content in chosen)) if chosen else set()
    common = sorted(shared)[:performers]
    if len(chosen) < 2 or len(common) < min(3, performers):
        raise ExperimentError(
            f"{folder}: found {len(chosen)} actions by the same {len(common)} performers, needed "
            f"{actions} by {performers}, and 2 by 3 at least; are content and style in the file "
            "names? See --pattern")

    def _wanted(content, style):
        return content in chosen and style in common
    wanted = {path.stem: label for label, path in first.items() if _wanted(*label)}
    database = read_database(folder, pattern=pattern, report=report, keep=_wanted)
    database = without(database, np.array([f.name in wanted for f in database.fragments]))
    return Cast(database, np.array([wanted[f.name][1] for f in database.fragments]))


def sample_cast(performers: int = PERFORMERS) -> tuple[Cast, str]:
    """A cast to look at, and whose motion it is: real clips where REFIMPL_MOCAP names a folder that
    has the cast, else the embedded performers.

    Raises FileNotFoundError where REFIMPL_MOCAP names no folder of clips.
    """
    folder = os.environ.get("REFIMPL_MOCAP")
    try:
        real = folder_cast(folder, performers=performers) if folder else None
    except ExperimentError:                                  # a folder of other motions
        real = None
    if real is None:
        return embedded_cast(performers), "performers made by refimpl"
    bandai = all(fragment.name.startswith("dataset-") for fragment in real.database.fragments)
    return real, BANDAI if bandai else "clips of REFIMPL_MOCAP"


@dataclass(frozen=True)
class Curves:
    """Efforts against alpha for one pair of fragments.

    pair : (i, j) fragment numbers;  alpha : (points,);  predicted, linear : (points, 3) by f and by
    linear interpolation;  tried : (looks,) alphas of blends that were made;  observed : (looks, 3)
    as the computed observer sees these.
    """

    pair: tuple[int, int]
    alpha: np.ndarray = field(repr=False)
    predicted: np.ndarray = field(repr=False)
    linear: np.ndarray = field(repr=False)
    tried: np.ndarray = field(repr=False)
    observed: np.ndarray = field(repr=False)


def figure_1(database: Database, model: StyleModel, pca: PrincipalComponents, *, pairs: int = 3,
             points: int = 61, looks: int = 13, seed: int = 0) -> list[Curves]:
    """Predicted efforts against alpha for some pairs, each of another content as far as there are,
    and what is observed.
    """
    rng = np.random.default_rng([seed, 12])
    contents = list(dict.fromkeys(fragment.content for fragment in database.fragments))
    rng.shuffle(contents)
    alpha, tried = np.linspace(LOWEST, HIGHEST, points), np.linspace(LOWEST, HIGHEST, looks)
    c, e, found = coefficients(database, pca), database.styles, []
    for n in range(pairs):
        members = [k for k, fragment in enumerate(database.fragments)
                   if fragment.content == contents[n % len(contents)]]
        i, j = (int(k) for k in rng.choice(members, 2, replace=False))
        Z = blend_inputs(c, e, np.tile([i, j], (points, 1)), alpha)
        observed = np.array([observe(database.blend(i, j, a), database.observer) for a in tried])
        found.append(Curves((i, j), alpha, predict(model, Z), linear_interpolation(Z), tried,
                            observed))
    return found


def three_way(database: Database, *, trials: int = 60, seed: int = 0) -> dict[str, Any]:
    """Three fragments of one content in equal parts (the paper's future work): a blend of a blend,
    and how far the observer sees it from the mean of the three, beside blends of two, and beside
    style 0 for both.

    ->  {row: {"error": mean squared, by effort, "pops": share above twice the larger parent's peak
    acceleration}}
    """
    rng = np.random.default_rng([seed, 20])
    by: dict[Any, list[int]] = {}
    for n, f in enumerate(database.fragments):
        by.setdefault(f.content, []).append(n)
    able = [members for members in by.values() if len(members) > 2]
    found: dict[str, list[np.ndarray]] = {}
    pops: dict[str, list[bool]] = {}
    for _ in range(trials):
        some = rng.choice(able[rng.integers(len(able))], 3, replace=False)
        two = database.blend(some[0], some[1], 0.5)
        three = database.between(two, database.fragments[some[2]], 1 / 3, database.body)
        for row, made, parents in (("blends of two", two, some[:2]),
                                   ("blends of three", three, some)):
            seen, larger = observe(made, database.observer), max(
                peak_acceleration(database.fragments[n], database.body) for n in parents)
            pops.setdefault(row, []).append(
                peak_acceleration(made, database.body) > 2.0 * larger * (1 + 1e-9))
            found.setdefault(row, []).append(
                (seen - database.styles[parents].mean(axis=0)) ** 2)
            found.setdefault(f"style 0 for {row}", []).append(seen ** 2)
    return {row: {"error": np.mean(x, axis=0).round(3).tolist(),
                  **({"pops": float(np.mean(pops[row]))} if row in pops else {})}
            for row, x in found.items()}


def blends_that_pop(database: Database, count: int = 1000, *, seed: int = 0,
                    report: Callable[[str], None] = lambda text: None) -> dict[str, float]:
    """Random blends, alpha in [-0.25, 1.25]: shares whose peak acceleration is above twice the
    larger parent's, as printed and as `steady_blend` makes them, and what that took.
    """
    rng = np.random.default_rng([seed, 21])
    pairs, alpha = random_pairs(database, count, rng), rng.uniform(LOWEST, HIGHEST, count)
    printed, took = [], []
    for (i, j), a in zip(pairs, alpha):
        parents = database.fragments[i], database.fragments[j]
        larger = max(peak_acceleration(f, database.body) for f in parents)
        printed.append(peak_acceleration(as_printed(*parents, a, database.body), database.body)
                       > 2 * larger)
        made = steady_blend(*parents, a, database.body)
        took.append((peak_acceleration(made.fragment, database.body) > 2 * larger * (1 + 1e-9),
                     not made.limited, made.straight > 0, made.slower > 1))
        report("")
    return {"as printed": float(np.mean(printed)), **dict(zip(
        ("now", "no limited path", "drawn straight", "slowed"), np.mean(took, axis=0).tolist()))}
