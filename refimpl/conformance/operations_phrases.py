"""The specifications of whole poses and phrases of 2006: from joints to angles and back, the
computed observer, cross-validation, joining, and a phrase in another style.
"""

import numpy as np

from . import (definitions_learning as learning, definitions_phrases as definitions,
               definitions_torresani as plain, functions_phrases as functions)
from .ground_learning import kernel
from .specification import Sample, called, operation, refused

PARENTS = np.array([-1, 0, 1, 1, 3])
# Beside an alpha, which may be near 0 and is found to 1e-5, all of a phrase is known better.
OF_ALPHAS = (0.01, 0.01, 0.01, 0.01, 1.0, 0.01)


def _body(rng, up="y", carrier=1):
    parents = PARENTS if carrier else np.array([-1, 0, 0, 2, 2])
    reference = learning.exponential_map(rng.standard_normal((len(parents), 3)))
    if carrier:
        reference[0] = np.eye(3)
    return {"parents": parents, "bones": rng.standard_normal((len(parents), 3)),
            "reference": reference, "carrier": carrier, "up": up}


def _performance(rng, frames, joints=5, still=()):
    """Smooth angles and a way over the floor."""
    angles = rng.standard_normal((frames, 3 * joints)).cumsum(axis=0) * 0.1
    if frames > 1:
        angles = np.array(plain._smoothed(angles, 2.0))
    for joint in still:
        angles[:, 3 * joint:3 * joint + 3] = 0.0
    return angles, rng.standard_normal((frames, 4)).cumsum(axis=0) * 0.15


def _performances(rng, lengths, still=(0,)):
    angles, root = zip(*(_performance(rng, frames, still=still) for frames in lengths))
    return np.concatenate(angles), np.concatenate(root)


def _clip_samples(rng):
    def _clips(label, lengths, fps, free, parents=PARENTS, turn=1.0, tall=2, sizes=1.0, jump=0.05):
        T, J = sum(lengths), len(parents)
        steps = rng.standard_normal((T, J, 3)) * jump
        R = learning.exponential_map(steps.cumsum(axis=0) + rng.standard_normal((J, 3)) * 0.3)
        about = np.outer(np.arange(T) * turn, np.eye(3)[tall])
        R[:, free[0]] = learning.exponential_map(about) @ R[:, free[0]]
        bones = rng.standard_normal((J, 3)) * np.where(np.arange(3) == tall, 3.0, 0.4)
        bones = np.stack([bones * (1.0 if n == 0 else sizes) for n in range(len(lengths))])
        return called(label, R, rng.standard_normal((T, 3)).cumsum(axis=0),
                      lengths=lengths, parents=parents, bones=bones, free=free, fps=fps)
    branching = np.array([-1, 0, 0, 2, 2])
    return [_clips("plain", (9, 7), 30.0, (0,), branching, 0.1, 1),
            _clips("from 60 frames a second", (13,), 60.0, (0,), branching, 0.05),
            _clips("between frames", (11, 8), 45.0, (1,), turn=0.3),
            _clips("carried below the root", (6, 5, 9), 30.0, (0, 1), turn=-0.4),
            _clips("nobody is free below the root", (6, 5), 30.0, (0,), turn=0.5, tall=1),
            _clips("bodies of two sizes", (6, 5), 30.0, (0,), branching, 0.4, 1, 1.5),
            _clips("a hair larger", (6, 5), 30.0, (0,), branching, 0.4, 2, 1.0005)]


def _pose_samples(rng):
    return [called("plain", *_performance(rng, 6, still=(0,)), **_body(rng)),
            called("z is up", *_performance(rng, 5, still=(0,)), **_body(rng, "z")),
            called("carried by the root", *_performance(rng, 4), **_body(rng, carrier=0)),
            called("one frame", *_performance(rng, 1, still=(0,)), **_body(rng))]


def _observed_samples(rng):
    lengths = (6, 9, 7, 5, 8)

    def _sample(label, contents, asked, relative=True, still=False, **body):
        angles, root = _performances(rng, lengths)
        if still:
            angles[:6], root[:6] = angles[0], root[0]
        return called(label, angles, root, lengths=lengths, contents=contents,
                      asked=asked, fps=30.0, relative=relative, **_body(rng, **body))
    return [_sample("plain", (0, 1, 0, 1, 1), (0, 1, 0, 1, 1)),
            _sample("not relative, one content", (3, 3, 3, 3, 3), (3,) * 5, False, up="z"),
            _sample("an unknown content, and another's", (0, 1, 0, 1, 0), (7, 0, 1, 7, 0)),
            _sample("one content with one fragment", (0, 1, 0, 0, 0), (0, 1, 0, 0, 0)),
            _sample("standing still", (0, 0, 0, 1, 1), (0, 0, 0, 1, 1), still=True)]


def _bad_observers():
    rng = np.random.default_rng(0)
    angles, root = _performances(rng, (5, 5))
    good = {"lengths": (5, 5), "contents": (0, 0), "asked": (0, 0), "fps": 30.0, "relative": True,
            **_body(rng)}
    alike = np.concatenate([angles[:5]] * 2), np.concatenate([root[:5]] * 2)
    return [refused("two contents of one fragment",
                    "fragments", angles, root, **good | {"contents": (0, 1)}),
            refused("three frames",
                    "fragment 1", angles[:8], root[:8], **good | {"lengths": (5, 3)}),
            refused("twice the same", "fragments", *alike, **good)]


def _cost_samples(rng):
    n, sizes = rng.standard_normal, {"plain": (5, 3, 9, 4), "one frame each": (1, 1, 1),
                                     "two alike": (4, 4, 6)}
    return [called(label, n((sum(lengths), 3)), lengths=lengths)
            for label, lengths in sizes.items()]


def _kernel(rng, count):
    A = rng.standard_normal((count, 2))
    return kernel(A, A)


def _ridge_samples(rng):
    n = rng.standard_normal
    few = n((9, 3))
    return [called("plain", _kernel(rng, 11),
                   n((11, 3)), ridges=np.array([0.1, 1.0, 9.0]), folds=rng.permutation(11) % 4),
            called("each left out alone",
                   _kernel(rng, 6), n((6, 1)), ridges=np.array([0.5]), folds=rng.permutation(6)),
            called("a kernel of low rank",
                   few @ few.T, n((9, 2)), ridges=np.array([0.01, 3.0]), folds=np.arange(9) // 3)]


def _machine_samples(rng):
    Ks = np.stack([_kernel(rng, 8), _kernel(rng, 8)])
    return [called("plain", Ks, rng.standard_normal((8, 2)) * 2, boxes=np.array([1.0, 5.0]),
                   epsilons=np.array([0.05, 0.4]), folds=rng.permutation(8) % 3)]


def _violation_samples(rng):
    K, y = _kernel(rng, 6), rng.standard_normal(6)
    beta = np.array([0.5, -0.5, 1.0, -1.0, 0.0, 0.0])
    return [called("plain", K, y, beta, C=1.0, epsilon=0.1),
            called("out of the box", K, y, beta, C=0.7, epsilon=0.3),
            called("a sum", K, y, np.abs(beta), C=2.0, epsilon=0.0),
            called("all at one end", K, y, np.ones(6), C=1.0, epsilon=0.2),
            called("a wide tube, nothing wrong", K, y, 0 * y, C=1.0, epsilon=9.0)]


def _fitted_samples(rng):
    n = rng.standard_normal
    return [called(f"{kind}, {count} examples", n((count, 9)), rng.uniform(-3, 3, (count, efforts)),
                   n((4, 9)), kind=kind, dealt=rng.permutation(count))
            for kind, count, efforts in (("linear ridge", 12, 9), ("kernel ridge", 11, 9),
                                         ("kernel ridge", 5, 3), ("linear interpolation", 5, 3))]


def machines(rng: np.random.Generator) -> list[Sample]:
    """A choice among thirty machines, which takes too long in loops."""
    n = rng.standard_normal
    A = n((14, 2))
    Y = np.stack([2 * np.sin(A[:, 0]), A.sum(axis=1), A[:, 0] * A[:, 1]], axis=1)
    return [called("support vector", A,
                   Y, n((5, 2)), kind="support vector", dealt=rng.permutation(14), factors=(1e5,))]


def _bad_fits():
    Z, Y = np.eye(5), np.ones((5, 3))
    good = {"kind": "linear ridge", "dealt": np.arange(5)}
    return [refused("another kind", "kind", Z, Y, Z, **good | {"kind": "ridge"}),
            refused("three examples", "Z, Y", Z[:3], Y[:3], Z, **good | {"dealt": np.arange(3)}),
            refused("one axis", "Z, Y", Z, Y[:, 0], Z, **good),
            refused("not as many", "Z, Y", Z, Y[:4], Z, **good),
            refused("not a number", "Z, Y", Z, Y * np.nan, Z, **good),
            refused("other inputs", "Z", Z, Y, Z[:, :4], **good)]


def _joined_samples(rng):
    reference = learning.exponential_map(rng.standard_normal((5, 3)))

    def _sample(label, lengths, **how):
        return called(label,
                      *_performances(rng, lengths, ()), lengths=lengths, reference=reference, **how)
    return [_sample("two parts", (9, 12), fps=10.0), _sample("alone", (5,), fps=30.0),
            _sample("three parts, z is up", (8, 5, 11), fps=12.0, up="z"),
            _sample("shorter than the seam", (6, 7, 4), fps=30.0),
            _sample("two frames each", (2, 2), fps=5.0),
            _sample("no seam", (6, 6), fps=10.0, seam=0.0)]


def _phrase_samples(rng):
    def _sample(label, lengths, contents, kind="linear ridge", labelled=False, up="y", **how):
        angles, root = _performances(rng, lengths)
        pieces = plain.sequences(angles, lengths)
        Y = np.concatenate([pieces[0], pieces[-1]])
        count = len(lengths)
        alike = [c for c in range(count) if contents is None or contents[c] == contents[0]]
        pairs = np.array([(k, m) for k in alike for m in alike if k != m])[:4]
        styles = rng.uniform(-2, 2, (count, 3)) if labelled else None
        return called(label, Y + 0.01 * rng.standard_normal(Y.shape),
                      root_Y=rng.standard_normal((len(Y), 4)).cumsum(axis=0),
                      angles=angles, root=root, lengths=lengths, contents=contents, styles=styles,
                      fps=10.0, pairs=pairs, alpha=rng.uniform(-0.25, 1.25, len(pairs)),
                      dealt=rng.permutation(len(pairs) + 2 * count),
                      kind=kind, target=rng.uniform(-2, 2, 3),
                      components=2, **_body(rng, up), **how, factors=OF_ALPHAS)
    return [_sample("plain", (6, 5, 7), (0, 0, 0), looks=2),
            _sample("an analyst's styles", (8, 10, 9, 7), (0, 0, 0, 0), labelled=True),
            _sample("two contents", (8, 9, 10, 8, 9), (0, 0, 1, 1, 1)),
            _sample("contents to be found",
                    (9, 8, 10, 9), None, "kernel ridge", up="z", relative=False, looks=3),
            _sample("more than enough neighbours", (4,) * 14, (0,) * 14),
            _sample("few neighbours", (5, 6, 5), (2, 2, 2), count=2)]


def _bad_phrases():
    good, = (s for s in _phrase_samples(np.random.default_rng(0)) if s.label == "plain")
    changes: list[tuple[str, str, dict]] = [
        ("a style out of reach", "style", {"target": np.array([0.0, 3.5, 0.0])}),
        ("two numbers", "style", {"target": np.zeros(2)}), ("no looks", "looks", {"looks": 0}),
        ("one neighbour", "frames 0 to 6 match '0'", {"count": 1}),
        ("one fragment", "fragments", {"lengths": (6,)})]
    return [refused(label, argument, *good.inputs, **good.attributes | change)
            for label, argument, change in changes]


def _one(f, arguments, samples, part, bad=list, **rest):
    definition = learning if hasattr(learning, f.__name__) else definitions
    return operation(f, arguments, definition, samples,
                     bad, f"2006, {part}", **{"batched": (), "precisions": ("float64",), **rest})


OPERATIONS = (
    _one(functions.motion_to_poses, "rotations places", _clip_samples, "section 3", tolerance=1e3),
    _one(functions.posed_joints, "angles root", _pose_samples, "section 3", tolerance=10.0),
    _one(functions.observed_styles, "angles root", _observed_samples, "section 4", _bad_observers,
         tolerance=1e4), _one(functions.all_dtw_costs, "frames", _cost_samples, "section 4"),
    _one(functions.ridge_errors, "K Y", _ridge_samples, "section 6", tolerance=1e3),
    _one(functions.machine_errors, "Ks Y", _machine_samples, "section 6", tolerance=1e6),
    _one(functions.machine_violation, "K y beta", _violation_samples, "section 6", tolerance=10.0),
    _one(functions.fitted_style,
         "Z Y new", _fitted_samples, "section 6", _bad_fits, tolerance=1e3, ground=machines),
    _one(functions.joined_motions, "angles root", _joined_samples, "section 7",
         lambda: [refused("no parts", "parts", np.zeros((0, 3)), np.zeros((0, 4)),
                          lengths=(), reference=np.eye(3)[None], fps=30.0)], tolerance=1e3),
    _one(functions.styled_phrase, "Y", _phrase_samples, "section 7", _bad_phrases, tolerance=1e9))
