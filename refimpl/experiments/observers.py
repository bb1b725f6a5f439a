"""What the two observers are worth: noise, lively against weary performers, efforts that are known.
"""

from dataclasses import replace
from typing import Any

import numpy as np

from ..embedded import performers
from ..torresani2006.efforts import BY_PATHS, BY_SWINGS
from ..torresani2006.observe import Observer, fit_observer, observe
from ..torresani2006.poses import Fragment, fit_body, fragment_of
from .torresani import Cast

CAPTURE_NOISE = 0.005                            # radians
LIVELY = "active", "angry", "happy", "youthful"
WEARY = "exhausted", "tired", "sad", "not-confident", "old", "elderly"
EACH = 14                                        # efforts, of each action and formula


def worth(cast: Cast, *, seed: int = 0) -> dict[str, dict[str, Any]]:
    """Of each observer, by effort: how far white noise of `CAPTURE_NOISE` on every joint's angles
    moves it, the largest and the 95th percentile over the fragments; in which share of the pairs of
    one content it sees more in a `LIVELY` performer than in a `WEARY` one (chance: 0.5); and, for
    the embedded performers, correlations within actions with efforts that are known, its own and
    the largest with another effort, formula by formula, beside the 95th percentile of |r| with
    efforts that are shuffled.
    """
    found: dict[str, dict[str, Any]] = {}
    fragments, body = cast.database.fragments, cast.database.body
    known = {} if cast.efforts is None else {
        formula: _performed(formula, seed) for formula in performers.FORMULAS}
    for sight in (BY_SWINGS, BY_PATHS):
        rng = np.random.default_rng([seed, 23])
        watch = fit_observer(fragments, body, sight)
        seen = np.array([observe(f, watch) for f in fragments])
        moved = np.abs([observe(replace(f, angles=f.angles + CAPTURE_NOISE * rng.normal(
            size=f.angles.shape)), watch) for f in fragments] - seen)
        found[f"{sight.name}, noise of {CAPTURE_NOISE:g}"] = {
            "largest": _told(moved.max(axis=0)), "95 %": _told(np.percentile(moved, 95, axis=0))}
        more = [seen[i] > seen[j] for i in range(len(seen)) for j in range(len(seen))
                if fragments[i].content == fragments[j].content
                and cast.performer[i] in LIVELY and cast.performer[j] in WEARY]
        if more:
            found[f"{sight.name}, lively over weary"] = {
                "share": _told(np.mean(more, axis=0)), "pairs": len(more)}
        for formula, (some, efforts, content) in known.items():
            x, e = (_within(values, content) for values in (np.array([observe(f, Observer(
                {None: sight.usual}, watch.gain, own, sight)) for f, own in some]), efforts))
            r = np.corrcoef(x.T, e.T)[:3, 3:]
            chance = [np.corrcoef(x.T, rng.permutation(e).T)[:3, 3:] for _ in range(100)]
            found[f"{sight.name}, {formula}"] = {
                "own r": _told(np.diag(r)), "largest other": _told(
                    np.abs(r - np.diag(np.diag(r))).max(axis=1)),
                "shuffled": round(float(np.percentile(np.abs(chance), 95)), 2)}
    return found


def _performed(formula: str, seed: int) -> tuple[list[tuple[Fragment, Any]], np.ndarray,
                                                 np.ndarray]:
    """->  fragments with their bodies, efforts (N, 3), contents (N,)"""
    rng, made = np.random.default_rng([seed, 24]), []
    for content in performers.ACTIONS:
        for n, effort in enumerate(rng.uniform(-2.9, 2.9, (EACH, 3))):
            clip = performers.perform(content, 300 + n, effort, formula).clip
            body = fit_body([clip])
            made.append(((fragment_of(clip, body, "", fps=clip.fps), body), effort, content))
    some, efforts, contents = zip(*made)
    return list(some), np.array(efforts), np.array(contents)


def _within(values, content):
    """Each content's mean taken out."""
    return values - np.array([values[content == name].mean(axis=0) for name in content])


def _told(x):
    return np.round(x, 2).tolist()
