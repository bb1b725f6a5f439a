"""Who walks: a style and a person, numbers with a meaning each, so that styles can be blended and
an observer checked against the truth.
"""

from dataclasses import dataclass, fields

import numpy as np


@dataclass(frozen=True)
class Manner:
    """How a content is carried out; the defaults are a neutral adult.

    Factors on the content's own value, 1 is neutral: speed;  stride (at a given speed: below 1
    means more and shorter steps);  clearance of the swinging foot;  roll (heel strike and push-off;
    0: flat feet);  width of the track;  sway of the hips sideways;  twist of pelvis against
    shoulders;  arm_swing.

    Added degrees, 0 is neutral: lean of the trunk, forward;  slump (rounding of the upper back);
    head (drop);  tilt of the trunk, to the left;  arm_forward;  arm_out;  elbow (less the more it
    is bent already);  tremor.  Degrees: toe_out. Added centimetres: crouch, bounce.  Added part of
    the cycle on the ground: stance.

    From 0 to 1: reach (both arms held out in front);  stiffness (knees that hardly bend, feet
    carried around);  limp (a right leg that hurts: short stance, stiff, the body thrown over the
    other leg);  sharpness (the sinusoids of arms and trunk become jerks).
    """

    speed: float = 1.0
    stride: float = 1.0
    clearance: float = 1.0
    roll: float = 1.0
    width: float = 1.0
    sway: float = 1.0
    twist: float = 1.0
    arm_swing: float = 1.0
    lean: float = 0.0
    slump: float = 0.0
    head: float = 0.0
    tilt: float = 0.0
    toe_out: float = 6.0
    arm_forward: float = 0.0
    arm_out: float = 0.0
    elbow: float = 0.0
    tremor: float = 0.0
    crouch: float = 0.0
    bounce: float = 0.0
    stance: float = 0.0
    reach: float = 0.0
    stiffness: float = 0.0
    limp: float = 0.0
    sharpness: float = 0.0


STYLES = {
    "normal": Manner(),
    "old": Manner(speed=0.5, stride=0.74, clearance=0.4, roll=0.3, width=1.3, sway=1.3, twist=0.4,
                  arm_swing=0.3, lean=20.0, slump=24.0, head=6.0, toe_out=11.0, arm_forward=16.0,
                  elbow=55.0, tremor=0.7, crouch=6.0, stance=0.05),
    "zombie": Manner(speed=0.5, stride=0.9, clearance=0.3, roll=0.25, width=1.4, sway=2.6,
                     twist=0.3, arm_swing=0.1, lean=3.0, head=6.0, tilt=7.0, tremor=0.4,
                     stance=0.03, reach=1.0, stiffness=0.8, limp=0.2),
    "depressed": Manner(speed=0.62, stride=0.86, clearance=0.6, roll=0.6, sway=1.1, twist=0.5,
                        arm_swing=0.25, lean=8.0, slump=26.0, head=38.0, arm_forward=4.0,
                        elbow=-8.0, crouch=1.5, stance=0.03),
    "injured": Manner(speed=0.6, stride=0.84, roll=0.8, width=1.1, sway=1.4, arm_swing=0.6,
                      lean=8.0, head=8.0, arm_out=7.0, elbow=16.0, limp=1.0),
    "proud": Manner(speed=1.05, stride=1.08, roll=1.1, twist=1.2, arm_swing=1.35, lean=-5.0,
                    slump=-12.0, head=-10.0, arm_out=8.0, bounce=1.0),
    "childlike": Manner(speed=1.05, stride=0.82, clearance=1.5, sway=1.3, twist=1.6, arm_swing=1.7,
                        head=-6.0, arm_out=16.0, elbow=10.0, bounce=2.2),
    "angry": Manner(speed=1.25, width=1.2, twist=1.4, arm_swing=1.35, lean=12.0, head=10.0,
                    arm_out=9.0, elbow=45.0, sharpness=0.8)}


def blend(style_a: Manner, style_b: Manner, alpha: float) -> Manner:
    r"""Every parameter `(1 - alpha) a + alpha b`; alpha 0 gives a, 1 gives b, a little beyond
    exaggerates.

    >>> round(blend(STYLES["normal"], STYLES["old"], 0.5).lean, 6)
    10.0
    """
    return Manner(**{f.name: (1.0 - alpha) * getattr(style_a, f.name)
                     + alpha * getattr(style_b, f.name) for f in fields(Manner)})


@dataclass(frozen=True)
class Person:
    """A body and its habits.

    scale : of all lengths;  stride, cadence, arm_swing, width, sway : factors
    lean, head, toe_out, arm_out, elbow : degrees added
    """

    scale: float = 1.0
    stride: float = 1.0
    cadence: float = 1.0
    arm_swing: float = 1.0
    width: float = 1.0
    sway: float = 1.0
    lean: float = 0.0
    head: float = 0.0
    toe_out: float = 0.0
    arm_out: float = 0.0
    elbow: float = 0.0


def person(seed: int) -> Person:
    """Somebody, always the same for the same seed.

    >>> person(3) == person(3) != person(4)
    True
    """
    rng = np.random.default_rng([21, seed])
    spread = dict(scale=0.05, stride=0.05, cadence=0.05, arm_swing=0.2, width=0.12, sway=0.2,
                  lean=1.5, head=3.0, toe_out=2.0, arm_out=2.0, elbow=5.0)
    return Person(**{name: value + spread[name] * rng.uniform(-1.0, 1.0)
                     for name, value in vars(Person()).items()})
