"""The reference for whole poses and phrases of 2006 as functions of arrays alone: from joints to
angles and back, the computed observer, cross-validation, joining, and a phrase in another style.

Clips, fragments and parts come end to end in one array, with their lengths. Everything is float64.
"""

from collections.abc import Sequence
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np

from ..motion.clip import POSITION_CHANNELS, Clip, Joint
from ..motion.skeleton import with_pose
from ..torresani2006 import align, blend, database, observe, poses, regress, svr, synthesise
from .dealt import Dealt, said
from .definitions_torresani import sequences
from .specification import Array

ROTATIONS = ("Zrotation", "Xrotation", "Yrotation")


def _joints(parents, bones, free=()):
    return tuple(Joint(f"joint {j}", int(parent), tuple(map(float, bone)),
                       (*POSITION_CHANNELS * (j in free), *ROTATIONS))
                 for j, (parent, bone) in enumerate(zip(parents, bones)))


def _body(parents, bones, reference, carrier, up):
    return poses.Body(_joints(parents, bones), carrier, bones, reference, up)


def _fragments(angles, root, lengths, fps, contents=None, styles=None):
    parts = zip(sequences(angles, lengths), sequences(root, lengths))
    return [poses.Fragment(f"fragment {n}", None if contents is None else str(contents[n]),
                           None if styles is None else styles[n], *part, float(fps))
            for n, part in enumerate(parts)]


def motion_to_poses(rotations: Array, places: Array, *, lengths: Sequence[int], parents: Array,
                    bones: Array, free: Sequence[int], fps: float,) -> tuple[Array, ...]:
    """Section 3: clips of one skeleton as angles from their mean pose, 30 frames a second.

    1. The carrier: down from joint 0 as long as there is one child, the last of these joints that
       is free, else joint 0. The joints above it stand still.
    2. Up is the axis, y or z, over which a pose spreads further (the mean over frames, then clips,
       of largest minus smallest place of a joint from the carrier on; y where equal).
    3. heading(R, A) = 2 atan2(q_up, q_w) of the unit quaternion of R A^T, without jumps. The
       reference of a joint is the rotation nearest (Frobenius) to the sum over the clips of its
       mean rotation; of a joint above the carrier it is I; of the carrier the rotations are those
       in the world, each turned about the vertical by minus its heading from the first of clip 0.
    4. bones: the median over the clips of the first frame's places in their parents, above the
       carrier those of clip 0.
    5. A clip is read at 30 frames a second, in between along the shortest turn and a straight line.
       angles: `continuous_exponential_maps` of each joint, the carrier's as in the world, turned by
       minus its heading from its reference. root: the carrier's place in the world times the ratio
       of sizes (sums of the bones' lengths below the carrier, `bones` over the clip's own; 1 within
       0.001), and that heading.

    rotations : (T, J, 3, 3) in the parent's frame, places : (T, 3) of the free joints' first, which
    stands there in place of its bone;  lengths : frames of each clip;  parents : (J,), -1 for
    joint 0;  bones : (clips, J, 3);  free : joints that can be moved;  fps : 30 or more
    ->  carrier, 0 for y and 1 for z, bones (J, 3), reference (J, 3, 3), angles, root (T', 4)
    """
    clips = []
    for R, place, own in zip(sequences(rotations, lengths), sequences(places, lengths), bones):
        at = np.repeat(own[None], len(R), axis=0)
        at[:, free[0]] = place
        rest = Clip(_joints(parents, own, free), 1 / fps, np.zeros((1, 0)))
        clips.append(with_pose(rest, R, at, 1 / fps))
    body = poses.fit_body(clips)
    made = [poses.fragment_of(clip, body, "clip") for clip in clips]
    return (np.array(body.carrier), np.array("yz".index(body.up)), body.bones, body.reference,
            np.concatenate([f.angles for f in made]), np.concatenate([f.root for f in made]))


def posed_joints(angles: Array, root: Array, *, parents: Array, bones: Array,
                 reference: Array, carrier: int, up: str) -> Array:
    """The way back: where the joints are in the world.

        R_j = reference_j exp(v_j),   of the carrier turned about the vertical by the heading;
        a joint stands at its bone in its parent's frame, the carrier where root minus the bones
        above it says

    angles : (T, 3 J), root : (T, 4): x, y, z and heading;  parents : (J,), bones : (J, 3),
    reference : (J, 3, 3);  carrier : joint;  up : "y" or "z"   ->  (T, J, 3)
    """
    body = _body(parents, bones, reference, carrier, up)
    fragment, = _fragments(angles, root, (len(angles),), 30.0)
    return poses.fragment_positions(fragment, body)


def _sight(relative):
    return observe.Sight("", partial(observe.descriptors, relative=relative))


def observed_styles(angles: Array, root: Array, *, lengths: Sequence[int],
                    contents: Sequence[int], asked: Sequence[int], fps: float, relative: bool,
                    parents: Array, bones: Array, reference: Array, carrier: int, up: str) -> Array:
    """The computed observer, of the fragments that it has learnt from. d = (flow, weight, time) of
    the logarithms (of 1e-12 at least) of the `effort_measures` of `posed_joints`:

        relative      (acceleration - jerk, energy, acceleration - speed)
        otherwise     (-jerk, energy, acceleration)
        style         1.5 (d - mean of its content) / spread, held within -3 and 3

    spread : the root of the sum of the squares about the means of the contents over (fragments -
    contents);  an unknown content is compared with the mean of all

    angles, root : fragments end to end, lengths : frames of each;  contents : of each;  asked : as
    which it is observed;  fps : frames a second;  parents ... up : as for `posed_joints`
    ->  (N, 3)
    """
    body = _body(parents, bones, reference, carrier, up)
    fragments = _fragments(angles, root, lengths, fps, contents)
    observer = observe.fit_observer(fragments, body, _sight(relative))
    return np.array([observe.observe(f, observer, str(a)) for f, a in zip(fragments, asked)])


def all_dtw_costs(frames: Array, *, lengths: Sequence[int]) -> Array:
    """`dtw_cost` of each two sequences.

    frames : (sum of lengths, D), the sequences end to end, lengths : frames of each   ->  (N, N)
    """
    return align.all_pairs(sequences(frames, lengths))


def ridge_errors(K: Array, Y: Array, *, ridges: Array, folds: Array) -> Array:
    """Mean over the examples of the squared error of `kernel_ridge` where it was not trained: of
    each fold by the examples of the others.

    K : (N, N) positive, Y : (N, E);  ridges : (L,);  folds : (N,) whole numbers   ->  (L, E)
    """
    return regress.ridge_errors(K, Y, ridges.tolist(), folds)


def machine_errors(Ks: Array, Y: Array, *, boxes: Array, epsilons: Array, folds: Array) -> Array:
    """The same of `support_vector_regression`, of each kernel, C, epsilon and effort.

    Ks : (G, N, N), Y : (N, E);  boxes : (B,), epsilons : (P,);  folds : (N,)   ->  (G, B, P, E)
    """
    return regress.svr_errors(Ks, Y, boxes.tolist(), epsilons.tolist(), folds, tolerance=1e-12)


def machine_violation(K: Array, y: Array, beta: Array, *, C: float, epsilon: float) -> float:
    """How far from the Karush-Kuhn-Tucker conditions the betas of a support vector machine are:
    with r = y - K beta, how far the largest r - epsilon (r + epsilon where beta < 0) of those with
    beta < C lies above the least r - epsilon (r + epsilon where beta <= 0) of those with beta > -C,
    plus the largest |beta| - C if that is positive, plus |sum beta|.

    K : (N, N), y, beta : (N,)   ->  scalar
    """
    return svr.kkt_violation(K, y, beta, C, epsilon)


def fitted_style(Z: Array, Y: Array, new: Array, *, kind: str, dealt: Array) -> Array:
    """`predicted_style` with the hyper-parameters of each effort chosen by cross-validation: those
    of the least error (`ridge_errors`, `machine_errors`; the first of equals, the last named
    running fastest), means and deviations being those of all examples.

        linear ridge     ridge 10^-2, 10^-1.5 ... 10^3, K the products of the inputs
        kernel ridge     gamma (0.02, 0.06, 0.2, 0.6, 2) / d, ridge 10^-4, 10^-3.5 ... 10^1
        support vector   gamma as before, C 1, 5, 25, epsilon 0.05, 0.2

    Z : (N, d), Y : (N, E), new : (M, d);  dealt : (N,), a permutation: example n is of fold
    dealt[n] mod 10 (mod N where N is smaller)   ->  (M, E)
    """
    rng: Any = Dealt(dealt)
    return regress.predict(regress.fit_model(kind, Z, Y, rng), new)


def joined_motions(angles: Array, root: Array, *, lengths: Sequence[int], reference: Array,
                   fps: float, seam: float | None = None, up: str = "y") -> tuple[Array, Array]:
    """Section 7: parts one after the other.

    1. A part is set down where the one before ends: turned about the vertical so that its heading
       goes on from that one's last by the mean of that one's last step and its own first, and moved
       over the floor so that its first place is that one's last place plus the mean of that one's
       last step and its own first.
    2. Jumps are those that remain:   delta = log((A_last exp(v))^T B_first) for each joint, with
       v = (log(A_before^T A_last) + log(B_first^T B_second)) / 2, and likewise that of the height.
    3. fade(n) = 1 - (6 u^5 - 15 u^4 + 10 u^3), u = min(n / w, 1), w the frames of the seam (at
       least 1) or half of the part's frames where these are fewer. A is followed by exp(fade delta
       / 2), n counted back from its last frame, B by exp(-fade delta / 2), n from its first; the
       height gets fade / 2 times its jump, and minus that.
    4. angles: `continuous_exponential_maps` of all frames.

    angles, root : parts end to end, lengths : frames of each, at least two;  reference : (J, 3, 3);
    fps : frames a second;  seam : seconds, 0.6 unless given   ->  angles (T, 3 J), root (T, 4)
    """
    bones = np.zeros((len(reference), 3))
    body = _body(range(-1, len(bones) - 1), bones, reference, 0, up)
    made = synthesise.join(_fragments(angles, root, lengths, fps), body, **said(seam=seam))
    return made.angles, made.root


def styled_phrase(Y: Array, *, root_Y: Array, angles: Array, root: Array,
                  lengths: Sequence[int], contents: Sequence[int] | None, styles: Array | None,
                  parents: Array, bones: Array, reference: Array, carrier: int,
                  up: str, fps: float, pairs: Array, alpha: Array, dealt: Array, kind: str,
                  target: Array, components: int = 3, clusters: int = 1, relative: bool = True,
                  count: int | None = None, looks: int | None = None) -> tuple[Array, ...]:
    """Sections 4 to 7 together: a phrase in another style.

    1. contents, where none are given: `content_clusters` of `all_dtw_costs` with the
       `cluster_threshold` for so many clusters. styles, where none are given: `observed_styles`.
    2. f learns (`fitted_style`) from the blends of pairs at alpha, then from every fragment with
       the nearest of its content, at alpha 0, then the other way round at alpha 1. z has the
       `principal_components` (as many as `components`, of 50 frames) of both, their styles, alpha.
       The style of a blend is the observed one; where styles are given it is the interpolation of
       both plus what the observer sees beside the interpolation of what it sees in both, held
       within -3 and 3; the style of a fragment is its own.
    3. Each piece of Y (`one_stage_segmentation`): among the `count` nearest fragments of the
       content of the fragment that it matches (this one among them), each two in both orders, the
       `looks` best (`best_pair`) are blended, and that blend is taken which the observer sees
       nearest to the target (with one look, the best).
    4. The first piece stands and faces as Y begins; `joined_motions`.

    Y : (P, D), root_Y : (P, 4), at fps frames a second;  angles, root, lengths : the fragments;
    parents ... up : as for `posed_joints`;  relative : as for `observed_styles`;
    pairs : (M, 2), alpha : (M,);  dealt : (M + 2 N,);  count : 12 unless given;  looks : unless
    given 8 where the styles are observed and 1 where they are not
    ->  angles, root, first frames of the pieces and the end, k and l of each piece, alphas, and the
    mean over the pieces of four frames or more of what the observer sees in each
    """
    body = _body(parents, bones, reference, carrier, up)
    known = database.database_of(_fragments(angles, root, lengths, fps, contents, styles), body,
                                 contents=clusters, sight=_sight(relative))
    known = replace(known, between=blend.as_printed)
    rng: Any = Dealt(dealt)
    model, pca = database.train_on(database.blends_of(known, pairs, alpha), known, kind, components,
                                   rng)
    phrase, = _fragments(Y, root_Y, (len(Y),), fps)
    made = synthesise.synthesise(phrase, known, model, pca, target, looks=looks,
                                 **said(count=count))
    found = made.fragment
    seen = synthesise.observed_style(found, made.cuts, synthesise.contents_of(known, made.pieces),
                                     known.observer)
    return (found.angles, found.root, np.array(made.cuts),
            np.array([[c.i, c.j] for c in made.choices]), np.array([c.alpha for c in made.choices]),
            seen)
