"""Many people who do many things: the embedded walkers as varied as strangers' clips are.

They stand, walk and run at all speeds, turn, stop and go on, walk backwards, use their hands, and
each carries the body another way. The same scene can be played in any style.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from .manner import STYLES, Manner, Person, person
from .walkers import Motion, make_clip

_SECONDS = 4.0
# What is done, in turn: the content of `walkers` that it is, cm/s from and to.
ERRANDS = {"walk": ("walk", 35.0, 175.0), "run": ("jog", 140.0, 380.0),
           "halt": ("walk", 50.0, 140.0), "stand": ("stand", 0.0, 0.0),
           "turn": ("walk", 35.0, 110.0), "back": ("walk", 30.0, 95.0)}
TURNS = ("walk", "run", "halt", "stand", "run", "turn", "walk", "stand", "back", "halt")
KINDS = {"walk": ("walk", "halt", "turn", "back"), "run": ("run",), "stand": ("stand",)}
# Between what a person's own manner lies.
_OWN = {"lean": (-4.0, 10.0), "slump": (-10.0, 14.0), "head": (-12.0, 14.0), "tilt": (-3.0, 3.0),
        "arm_out": (-3.0, 22.0), "elbow": (-10.0, 40.0), "arm_forward": (-8.0, 14.0),
        "arm_swing": (0.3, 1.8), "width": (0.7, 1.8), "toe_out": (-3.0, 18.0),
        "clearance": (0.7, 1.5), "roll": (0.4, 1.15), "twist": (0.3, 2.5), "stride": (0.85, 1.15),
        "sway": (0.6, 1.6), "bounce": (-0.3, 0.8), "crouch": (0.0, 5.0)}
# ... and where it is another in what is done.
SPECIAL = {"run": {"clearance": (0.7, 3.3), "lean": (-8.0, 24.0), "twist": (0.3, 3.0)},
           "stand": {"width": (0.5, 3.0)}, "back": {"roll": (0.1, 0.4)}}
SLOWER = (1.0, 0.85, 0.7, 0.55, 0.4)     # who cannot go so fast in a style goes slower


@dataclass(frozen=True)
class Scene:
    """What somebody does, before any style.

    kind : of `KINDS`;  content, how : arguments of `walkers.make_clip`;  manner : the person's own
    """

    kind: str
    content: str
    manner: Manner
    who: Person
    how: Mapping[str, Any] = field(repr=False)

    def played(self, style: str) -> Motion:
        """In a style, with the same steps: its speed and its stride are the scene's."""
        worn = {}
        for name, neutral in vars(Manner()).items():
            own, other = getattr(self.manner, name), getattr(STYLES[style], name)
            worn[name] = own * other if neutral == 1.0 else own + other - neutral
        manner = Manner(**{**worn, "speed": 1.0, "stride": self.manner.stride})
        speed = self.how["speed"]
        for share in SLOWER:
            try:
                return make_clip(self.content, manner, self.who,
                                 **{**self.how, "speed": speed and speed * share})
            except ValueError:
                if share == SLOWER[-1]:
                    raise
        raise AssertionError("unreachable")


def crowd(count: int, seed: int = 0) -> list[Scene]:
    """So many scenes; fewer are the first of more.

    >>> [scene.kind for scene in crowd(4)], crowd(2)[1] == crowd(3)[1]
    (['walk', 'run', 'walk', 'stand'], True)
    """
    return [_scene(np.random.default_rng([seed, 7, number]), number) for number in range(count)]


def _scene(rng, number):
    errand = TURNS[number % len(TURNS)]
    content, slowest, fastest = ERRANDS[errand]
    manner = Manner(**{name: rng.uniform(*SPECIAL.get(errand, {}).get(name, ends))
                       for name, ends in _OWN.items()})
    if rng.random() < 0.3:
        manner = replace(manner, crouch=rng.uniform(5.0, 14.0))
    how: dict[str, Any] = {"seconds": _SECONDS, "seed": int(rng.integers(10 ** 6)),
                           "speed": rng.uniform(slowest, fastest) if fastest else None,
                           "turn": _turning(rng, errand), "gestures": _busy(rng, errand)}
    if errand == "halt":
        begin, most = rng.uniform(0.0, _SECONDS), rng.random()
        end = np.inf if most > 0.7 else begin + rng.uniform(0.5, 2.5)
        how["pause"] = (-np.inf if most < 0.3 else begin, end)
    elif errand != "stand":
        how["heading"] = np.pi + rng.uniform(-0.3, 0.3) if errand == "back" else rng.normal(0, 0.15)
    kind = next(kind for kind, errands in KINDS.items() if errand in errands)
    return Scene(kind, content, manner, replace(person(number), scale=1.0), how)


def _turning(rng, errand):
    """Radians a second."""
    if errand == "turn":
        return rng.uniform(-2.4, 2.4)
    return rng.uniform(-0.25, 0.25) if errand != "stand" and rng.random() < 0.4 else 0.0


def _busy(rng, errand):
    """How much the arms do beside swinging."""
    return rng.choice([0.0, 0.0, 0.0, 0.4] if errand == "run" else [0.0, 0.0, 0.35, 0.7, 1.0])
