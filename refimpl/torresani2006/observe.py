r"""Styles as points e = (flow, weight, time) in [-3, 3]^3: from an analyst (`labels`) or from a
computed observer.

A computed observer is no analyst. `efforts` has the two that are used; `PUBLISHED`, here, is kept
as the literature has it, unfiltered: on recorded clips it measures the noise of their capture. It
starts from three descriptors that Larboulette and Gibet 2015, "A review of computable expressive
descriptors of human motion", collect from the literature, here with alpha_k the weight of joint k,
T a window of time and the numbers of their equations:

    Weight(T) = max over t in T of sum_k alpha_k |v_k(t)|^2   (22 and 23; large: strong)
    Time(T)   = sum_k alpha_k 1/T sum_t |a_k(t)|              (24 and 25; large: sudden)
    Flow(T)   = sum_k alpha_k 1/T sum_t |jerk_k(t)|           (29 and 30; large: bound)

Ours are these with all joints of one weight and the whole fragment as the window, and depart from
them in five points (choices): derivatives are differences of neighbouring frames (theirs are
central, over two frames for velocity and four for jerk); logarithms are taken, so that a fragment
twice as fast is as far from the usual as one half as fast; time is relative to speed and flow to
acceleration (`descriptors`); flow has the opposite sign, free above bound as in Torresani 2006; and
the result says how far a fragment lies from the others of its content, in standard deviations
(`observe`), since a kick is stronger than a wave whoever does it.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

import numpy as np

from .poses import Body, Fragment, fragment_positions

EFFORTS = ("flow", "weight", "time")
POLES = ("bound -3 .. free 3", "light -3 .. strong 3", "sustained -3 .. sudden 3")
LIMIT = 3.0
GAIN = 1.5                                  # two standard deviations reach the limit


class ObserveError(ValueError):
    """A motion too short to observe, or no fragments to compare with."""


def measures(positions: np.ndarray, fps: float) -> np.ndarray:
    r"""Four numbers from the joints' paths p_j, by differences of neighbouring frames:
    v(t) = fps (p(t+1) - p(t)), likewise a from v, jerk from a

        energy       max over t of 1/2 sum_j |v_j|^2      (all joints of one mass, 1)
        speed        mean over t and j of |v_j|
        acceleration mean over t and j of |a_j|
        jerk         mean over t and j of |jerk_j|

    positions : (T, J, 3), T at least 4   ->  (4,) in powers of their unit and of seconds, all NaN
    where a position is.
    Raises ObserveError for another shape.

    >>> measures(np.arange(12.0).reshape(4, 1, 3) * [1, 0, 0], 10.0)     # 30 units a second
    array([450.,  30.,   0.,   0.])
    """
    positions = np.asarray(positions, dtype=float)
    if positions.shape[2:] != (3,) or not positions.shape[1] or len(positions) < 4:
        raise ObserveError(f"positions: found shape {positions.shape}, needed (frames, joints, 3) "
                           "with at least 4 frames to see a jerk")
    if not fps > 0:
        raise ObserveError(f"fps: found {fps}, needed frames a second above 0")
    velocity = np.diff(positions, axis=0) * fps
    acceleration = np.diff(velocity, axis=0) * fps
    jerk = np.diff(acceleration, axis=0) * fps
    means = [np.linalg.norm(x, axis=-1).mean() for x in (velocity, acceleration, jerk)]
    return np.array([0.5 * np.sum(velocity ** 2, axis=(1, 2)).max(), *means])


def kinematics(fragment: Fragment, body: Body) -> np.ndarray:
    """`measures` of a fragment.   ->  (4,) energy, speed, acceleration, jerk.
    Raises ObserveError for fewer than four frames.
    """
    if fragment.frames < 4:
        raise ObserveError(f"{fragment.name}: found {fragment.frames} frames, needed at least 4 to "
                           "see a jerk")
    return measures(fragment_positions(fragment, body), fragment.fps)


def descriptors(fragment: Fragment, body: Body, relative: bool = True) -> np.ndarray:
    r"""Flow, weight and time before they are scaled.

        weight = log energy
        time   = log (acceleration / speed)
        flow   = -log (jerk / acceleration)

    Energy, acceleration and jerk all grow with speed; each of the higher ones is therefore taken
    relative to the one below (a choice), or a fast motion would always be strong, sudden and bound
    at once. relative=False gives log energy, log acceleration, -log jerk, the published ones but
    for their logarithms and signs. A measure below 1e-12 counts as 1e-12: a body that stands still
    has a style too.
    ->  (3,) flow, weight, time
    """
    energy, speed, acceleration, jerk = np.log(np.maximum(kinematics(fragment, body), 1e-12))
    return np.array([acceleration - jerk, energy, acceleration - speed] if relative else
                    [-jerk, energy, acceleration])


@dataclass(frozen=True)
class Sight:
    """What a computed observer looks at.

    measure : of (fragment, body), flow, weight and time before they are scaled, (3,);
    usual : (3,) what counts as 0 where no fragments tell, and alone : (3,) efforts a unit there;
    gain : (3,) efforts a unit where the content is known, or None: then 1.5 a standard deviation
    within the contents of the fragments learnt on, held within -3 and 3
    """

    name: str
    measure: Callable[[Fragment, Body], np.ndarray] = field(repr=False)
    usual: np.ndarray = field(default_factory=lambda: np.zeros(3), repr=False)
    gain: np.ndarray | None = field(default=None, repr=False)
    alone: np.ndarray | None = field(default=None, repr=False)


PUBLISHED = Sight("published", descriptors)


@dataclass(frozen=True)
class Observer:
    """A computed observer: what is usual for each content, and how much a difference counts.

    usual : {content: (3,)} with None for all together;  gain : (3,) efforts a unit;
    body : of the fragments;  sight : what it looks at.
    """

    usual: dict[str | None, np.ndarray]
    gain: np.ndarray
    body: Body = field(repr=False)
    sight: Sight


def fit_observer(fragments: Sequence[Fragment], body: Body, sight: Sight) -> Observer:
    """Learn what is usual: the mean measures of each content; and, where the sight has no gain of
    its own, the standard deviation within the contents.

    Raises ObserveError without at least two fragments of one content that differ.
    """
    found = np.array([sight.measure(f, body) for f in fragments]).reshape(-1, 3)
    contents = np.array([str(fragment.content) for fragment in fragments])
    usual, squares = {}, np.zeros(3)
    for content in dict.fromkeys(contents):
        members = found[contents == content]
        usual[content] = members.mean(axis=0)
        squares = squares + ((members - usual[content]) ** 2).sum(axis=0)
    freedom = len(found) - len(usual)
    spread = np.sqrt(squares / freedom) if freedom > 0 else np.zeros(3)
    if not (spread > 1e-9).all():
        raise ObserveError(
            f"fragments: found {len(found)} of {len(usual)} contents with nothing to compare, "
            "needed two different ones of one content; are the contents right?")
    gain = GAIN / spread if sight.gain is None else sight.gain
    return Observer({**usual, None: found.mean(axis=0)}, gain, body, sight)


def observe(fragment: Fragment, observer: Observer, content: str | None = None) -> np.ndarray:
    r"""The style of a fragment as a computed observer has it:
    e = clip(gain (measures - usual), -3, 3) for a gain that was fitted; one that is the sight's own
    is bent instead of cut off, e = 3 tanh(gain (measures - usual) / 3)

    content : whose usual to compare with, the fragment's own unless given; unknown ones with all
    together   ->  (3,) flow, weight, time
    """
    content = str(fragment.content if content is None else content)
    usual = observer.usual.get(content, observer.usual[None])
    seen = observer.sight.measure(fragment, observer.body)
    raw = observer.gain * (seen - usual)
    return (np.clip(raw, -LIMIT, LIMIT) if observer.sight.gain is None else
            LIMIT * np.tanh(raw / LIMIT))
