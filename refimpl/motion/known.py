r"""Does a clip lie within what a style has learnt?

Eleven numbers a frame tell how a body moves (`QUANTITIES`), each a mean over a quarter of a second
on the body that the networks know, in its legs. What a style knows is the range of each over the
clips that it learnt on. Beyond it T answers with something that it has seen: a sitter stands up. So
a style fades where it knows too little (`Known.trust`), and says where that is (`Known.outside`).
The error of P does not tell: P gives back much that T has never seen.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from scipy.ndimage import gaussian_filter1d, maximum_filter1d, uniform_filter1d

from .features import FLOOR, FORWARD, FPS, POSITIONS, SIDEWAYS, TURN, in_pieces
from .joints import HEELS, JOINTS, SLOT

# Name and unit of each; a speed in legs a second. And how wide a range is at least, so that a style
# that learnt on little does not find everything strange.
QUANTITIES = {"speed forward": "legs/s", "speed sideways": "legs/s", "turning": "degrees/s",
              "height of the hips": "legs", "lean of the trunk": "degrees",
              "height of a foot": "legs", "hands above the hips": "legs",
              "feet apart": "legs", "feet apart sideways": "legs", "speed of a hand": "legs/s",
              "twist of the shoulders": "degrees"}
LEAST = np.array([0.3, 0.3, 20.0, 0.1, 8.0, 0.1, 0.2, 0.2, 0.15, 0.5, 10.0])
MEAN = 15                        # frames of a mean
STILL = 1e-4                     # legs: what moves less stands still like no body
RARE = 0.002                     # share of the frames to either side that makes no range
BEYOND = 0.15                    # of a range: a little beyond it is not outside
FADES = 0.25, 0.8                # of a range beyond it: where a style begins to fade, and is gone
FADING = 24                      # frames before it is gone, that it fades in
STRANGE = 0.25                   # share of the frames outside of which it is told


@dataclass(frozen=True)
class Known:
    """The range of each of `QUANTITIES` in what was learnt on.   low, high : (11,)"""

    low: np.ndarray = field(repr=False)
    high: np.ndarray = field(repr=False)

    def excess(self, features: np.ndarray, leg: float) -> np.ndarray:
        """How far each lies beyond its range, in widths of the range.

        features : (T, 66);  leg : in their unit   ->  (T, 11), 0 within
        """
        found = quantities(features, leg)
        over = np.maximum(np.maximum(self.low - found, found - self.high), 0.0)
        return over / np.maximum(self.high - self.low, LEAST)

    def trust(self, features: np.ndarray, leg: float) -> np.ndarray:
        """How much of a style each frame takes: 1 where it is known, 0 where nothing is like it.
        ->  (T,)"""
        over = self.excess(features, leg).max(axis=1)
        gone = np.clip((over - FADES[0]) / (FADES[1] - FADES[0]), 0.0, 1.0)
        ahead = maximum_filter1d(gone, 2 * FADING + 1, mode="nearest")
        return 1.0 - gaussian_filter1d(ahead, FADING / 2, mode="nearest")

    def outside(self, features: np.ndarray, leg: float) -> tuple[float, str]:
        """The share of the frames that lie outside, and what lies farthest, in words. A clip that
        shows no motion, or too little of one, lies outside as a whole."""
        if len(features) < MEAN or np.ptp(features, axis=0).max() < STILL * leg:
            return 1.0, f"{len(features) / FPS:.2g} s in which nothing can be seen to move"
        over, found = self.excess(features, leg), quantities(features, leg)
        worst = int(np.argmax(over.mean(axis=0)))
        at = int(np.argmax(over[:, worst]))
        name, unit = list(QUANTITIES.items())[worst]
        return (float((over.max(axis=1) > BEYOND).mean()),
                f"{name} {found[at, worst]:.3g} {unit}, learnt were {self.low[worst]:.3g} to "
                f"{self.high[worst]:.3g}")

    @property
    def said(self) -> str:
        """The range in a few words."""
        low, high = (dict(zip(QUANTITIES, ends)) for ends in (self.low, self.high))
        return ", ".join(f"{name} {low[name]:.1f} to {high[name]:.1f} {QUANTITIES[name]}"
                         for name in ("speed forward", "height of the hips")) + "".join(
            f", {name} up to {high[name]:.0f} {QUANTITIES[name]}"
            for name in ("turning", "lean of the trunk"))


def known(clips: Sequence[np.ndarray], leg: float) -> Known:
    """What a style knows after these clips.   at least one of (T, 66);  leg : in their unit"""
    ends = np.quantile(np.concatenate([quantities(clip, leg) for clip in clips]),
                       (RARE, 1.0 - RARE), axis=0)
    return Known(*ends)


def quantities(features: np.ndarray, leg: float) -> np.ndarray:
    """How a body moves in each frame.

    features : (T, 66);  leg : in their unit   ->  (T, 11) in the units of `QUANTITIES`

    >>> quantities(np.zeros((3, 66)), 80.0)[0, :4]
    array([0., 0., 0., 0.])
    """
    found = in_pieces(lambda some: _each_frame(features, some, leg), len(features))
    return uniform_filter1d(found, MEAN, axis=0, mode="nearest")


def _each_frame(features, some, leg):
    """What `quantities` takes the means of."""
    before = features[max(some.start - 1, 0)]
    features = features[some]
    points, first = (x[:, POSITIONS].reshape(len(x), JOINTS, 3) / leg
                     for x in (features, before[None]))
    hips, ankles = points[:, SLOT["Hips"]], points[:, list(HEELS)]
    hands = points[:, [SLOT["LeftHand"], SLOT["RightHand"]]]
    shoulders = points[:, SLOT["LeftArm"]] - points[:, SLOT["RightArm"]]
    trunk, apart = points[:, SLOT["Neck"]] - hips, ankles[:, 0] - ankles[:, 1]
    level = np.linalg.norm(trunk[:, FLOOR["y"]], axis=1)
    steps = np.diff(hands, axis=0, prepend=first[:, [SLOT["LeftHand"], SLOT["RightHand"]]])
    return np.stack([
        FPS / leg * features[:, FORWARD], FPS / leg * np.abs(features[:, SIDEWAYS]),
        FPS * np.degrees(np.abs(features[:, TURN])), hips[:, 1],
        np.degrees(np.arctan2(level, trunk[:, 1])), ankles[..., 1].max(axis=1),
        hands[..., 1].max(axis=1) - hips[:, 1], np.linalg.norm(apart[:, FLOOR["y"]], axis=1),
        np.abs(apart[:, 0]), FPS * np.linalg.norm(steps, axis=-1).max(axis=1),
        np.degrees(np.arctan2(np.abs(shoulders[:, 2]), shoulders[:, 0]))], axis=1)
