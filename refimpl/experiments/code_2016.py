"""What each statement of the 2016 code does: its style transfer with one statement changed at a
time.

Measured on the searched rows themselves, before they are brought onto a skeleton, in the network's
own scale, and told beside the content. Lengths are in units of the 2016 code, of which a leg has
14.8.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from .. import nn
from ..fast import networks
from .holden import TableRow, own_jerk
from ..holden2016 import bridge, losses, own, rows, search
from ..holden2016.network import decode, encode, project
from ..holden2017 import losses as losses_2017
from ..nn.adam import annealed
from ..motion.features import Start, bone_lengths, decode as world
from ..motion.joints import FEET, JOINTS


@dataclass(frozen=True)
class Way:
    """The search with what may be changed of it.

    scaled : G scaled to the content's frames;  noise : its standard deviation in normalised units,
    None for the code's;  again : encoded again between the searches;  floor : the floor term;
    own_bones : the content's lengths for the code's;  tail : the last seven rows replaced;
    anneal : Adam's rate falling to 0;  start : "noise" or "content"
    """

    name: str
    amount: float = search.AMOUNT
    scaled: bool = False
    noise: float | None = None
    again: bool = True
    epsilon: float = search.EPSILON
    rate: float = search.RATE
    anneal: bool = False
    floor: bool = True
    own_bones: bool = False
    tail: bool = True
    start: str = "noise"


CODE = Way("as the code is")
WAYS = (CODE, Way("G scaled to the content's frames", scaled=True),
        Way("s = 0.003 / 1.003", amount=0.003), Way("noise of deviation 1", noise=1.0),
        Way("begun at the content", start="content"), Way("not encoded again", again=False),
        Way("Adam's epsilon 1e-8", epsilon=1e-8), Way("no floor term", floor=False),
        Way("bones of the content's length", own_bones=True),
        Way("velocities not replaced", tail=False),
        Way("rate 0.1, annealed", rate=0.1, anneal=True),
        Way("G scaled, rate 0.1, annealed, own bones", scaled=True, rate=0.1, anneal=True,
            own_bones=True))
OWN_FORM = "this package's own form"


def search_changed(content: np.ndarray, style: np.ndarray, network: bridge.Network, way: Way,
                   seed: int = 0) -> tuple[np.ndarray, np.ndarray]:
    """`search.transfer`, changed.

    content : (T, 73), style : (T_s, 73), both even  ->  (T, 73) at the end and after the first
    search
    """
    p, normaliser = network.params, network.normaliser
    dtype, one = p["We"].dtype, np.ones(1, p["We"].dtype)
    C, S = (normaliser.apply(r)[None].astype(dtype) for r in (content, style))
    H_content, H_style = encode(C, p), encode(S, p)
    gram = nn.gram(H_style) * (H_content.shape[2] / H_style.shape[2] if way.scaled else 1.0)
    rng = np.random.default_rng([seed, 4])
    start = (search.noise(rng, len(content)) if way.noise is None else
             way.noise * rng.standard_normal(C.shape))
    H = H_content if way.start == "content" else encode(start.astype(dtype), p)
    G = gram.astype(dtype)

    def _rate(step):
        return annealed(way.rate, step, search.ITERATIONS) if way.anneal else way.rate
    H = search.minimise(
        H, None, lambda H: losses.search_loss_backward(one, H, H_content, G, amount=way.amount),
        search.ITERATIONS, rate=_rate, epsilon=way.epsilon)
    X = decode(H, p)
    tail = search.tail(content, normaliser.undo(X[0]))
    contacts = content[:, rows.CONTACTS].T[None].astype(dtype)
    wanted = tail[:, :3].T[None].astype(dtype)
    lengths = _lengths(content) if way.own_bones else losses.LENGTHS

    def _backward(H):
        return _constraints_backward(H, network, contacts, wanted, lengths, way.floor)
    H = search.minimise(encode(X, p) if way.again else H, None, _backward,
                        search.CONSTRAINT_ITERATIONS, epsilon=way.epsilon)
    result = normaliser.undo(decode(H, p)[0])
    if way.tail:
        result[:, rows.TRAJECTORY.start:] = tail
    return result, normaliser.undo(X[0])


def _constraints_backward(H, network, contacts, wanted, lengths, floor):
    """`search.constrained_loss_backward` with other lengths of bones, or without the floor term."""
    third = np.full(len(H), 1 / 3, H.dtype)
    motion = search.decoded_motion(H, network.params, network.normaliser)
    dmotion = losses.foot_loss_backward(third, motion, contacts)
    if not floor:                                # all that feet cost where none is planted
        dmotion -= losses.foot_loss_backward(third, motion, 0 * contacts)
    share = third / (len(losses.BONES) * motion.shape[2])
    dmotion += losses.as_66_backward(losses_2017.bone_loss_backward(
        share, losses.as_66(motion), lengths, bones=losses.BONES), motion)
    dmotion += losses.trajectory_loss_backward(third, motion, wanted)
    return search.decoded_motion_backward(dmotion, H, network.params, network.normaliser)


def _lengths(content):
    """Median length of each of the code's bones.   (T, 73)  ->  (20,)"""
    points = content[:, rows.POSITIONS].reshape(len(content), JOINTS, 3)
    return np.array([np.median(np.linalg.norm(points[:, a] - points[:, b], axis=-1))
                     for a, b in losses.BONES])


def measure_rows(result: np.ndarray, styled: np.ndarray, content: np.ndarray, style: np.ndarray,
                 network: bridge.Network, fps: float) -> TableRow:
    """What there is to say about rows (T, 73) beside their content's.

    *left*: distance of the Gram matrix a frame from the style's, the content's own = 1;  *first*:
    the same of `styled`, the motion after the first search;  *excursion*: how far the joints move
    about, *speed*, *jerk* at the recording's rate, over the content's; *moved*: mean distance of a
    joint from the content's, and *sunk*: how deep the lower foot is under the floor on average,
    both in units;  *bones*: mean relative change of a bone's length
    """
    params = {name: array.astype(float) for name, array in network.params.items()}

    def _gram(r):
        X = network.normaliser.apply(r)[None].astype(float)
        return nn.gram(encode(X, params))[0] / (len(r) // 2)

    def _excursion(r):
        return np.std(r[:, rows.POSITIONS], axis=0).sum()

    def _speed(r):
        return np.linalg.norm(r[:, rows.VELOCITY], axis=1).mean()
    wanted = _gram(style)
    left = [np.linalg.norm(_gram(r) - wanted) for r in (result, styled, content)]
    points = [r[:, rows.POSITIONS].reshape(len(r), JOINTS, 3) for r in (result, content)]
    jerks = [own_jerk(bridge.to_features(r), fps) for r in (result, content)]
    lengths = [np.stack([np.linalg.norm(p[:, a] - p[:, b], axis=-1) for a, b in losses_2017.BONES])
               for p in points]
    return {
        "first": left[1] / left[2], "left": left[0] / left[2],
        "excursion": _excursion(result) / _excursion(content),
        "speed": _speed(result) / max(_speed(content), 1e-9), "jerk": jerks[0] / jerks[1],
        "bones": float(np.mean(np.abs(lengths[0] / np.median(lengths[1], axis=1)[:, None] - 1))),
        "moved": float(np.linalg.norm(points[0] - points[1], axis=-1).mean()),
        "sunk": float(np.maximum(0, -points[0][:, FEET, 1].min(axis=1)).mean())}


def own_form(content: np.ndarray, style: np.ndarray, network: bridge.Network, seed: int = 0, *,
             first: bool = False) -> np.ndarray:
    """The same with `own.optimise` on this network as a loss network of 2017, for the content's
    bones.   first : without the second search   ->  (T, 73)
    """
    features = bridge.to_features(content)
    settings = own.Settings(constraint_iterations=0) if first else own.Settings()
    moved = own.optimise(features, content[:, rows.CONTACTS], [bridge.to_features(style)],
                         network.manifold(), bones=bone_lengths(world(features, Start())),
                         settings=settings, seed=seed, networks=networks)
    return bridge.to_rows(moved, content[:, rows.CONTACTS])


def ablation_rows(pairs: Sequence[tuple[str, np.ndarray, np.ndarray, float]],
                  network: bridge.Network, seed: int = 0) -> Iterator[TableRow]:
    """Every way on every pair, beside the content itself and its projection.

    pairs : (name, content (T, 73), style (T_s, 73), the content's frames a second), of which the
    style's first 240 rows are taken   ->  yields a row for each
    """
    for name, content, style, fps in pairs:
        style = style[:min(len(style) - len(style) % 2, rows.WINDOW)]
        content = content[:len(content) - len(content) % 2]
        X = network.normaliser.apply(content)[None].astype(network.params["We"].dtype)
        projected = network.normaliser.undo(project(X, network.params)[0])
        results = {"the content itself": (content, content),
                   "the content, projected": (projected, projected),
                   **{way.name: search_changed(content, style, network, way, seed) for way in WAYS},
                   OWN_FORM: (own_form(content, style, network, seed),
                              own_form(content, style, network, seed, first=True))}
        for way, both in results.items():
            yield {"way": way, "pair": name, **measure_rows(*both, content, style, network, fps)}
