"""Where somebody goes and how the time is spent: the way over the floor with its turns and pauses,
the waves that drive the body, and all that is not periodic. Curves over time, (T,), in degrees
where nothing else is said.
"""

import numpy as np

from ..motion.easing import ease
from ..motion.features import FPS
from . import gait as legs

RAMP = 1.3                       # seconds from walking to standing still, and back
# Degrees: how far an arm is raised to the front and to the side, and its elbow bends, in gestures.
RAISED = {"Arm": (10.0, 150.0), "Out": (-5.0, 100.0), "Elbow": (0.0, 110.0)}
BUSY = {"lean": 9.0, "tilt": 6.0, "twist": 15.0, "look": 20.0, "nod": 8.0}   # trunk, head
_BOW = 70.0                                                      # and the trunk now and then


def drift(rng: np.random.Generator, time: np.ndarray, low: float = 0.1,
          high: float = 0.5) -> np.ndarray:
    """A smooth irregular curve of standard deviation about 1 with frequencies from low to high, in
    hertz.   (T,) seconds  ->  (T,)
    """
    frequency, shift = rng.uniform(low, high, 3), rng.uniform(0.0, 1.0, 3)
    waves = np.sin(2 * np.pi * (np.multiply.outer(time, frequency) + shift))
    return np.sqrt(2.0 / 3.0) * waves.sum(axis=-1)


def path_over_floor(rng: np.random.Generator, frames: int, gait: legs.Gait, turn: float,
                    cadence: float, pause: tuple[float, float] | None = None,
                    heading: float = 0.0) -> tuple[legs.Path, np.ndarray, int]:
    """The way over the floor and three cycles more at both ends; the turn sets in within the first
    0.8 s. Who pauses does it while both feet are on the ground.

    turn : radians / second;  cadence : cycles / second;  pause : seconds from and to, or None
    heading : radians, which way it goes from where it faces, to the left
    ->  Path, the pace along it (n,) from 0, standing, to 1, the clip's first frame on it
    """
    speed, start = gait.speed, int(np.ceil(3.0 / cadence * FPS))
    time = (np.arange(frames + 2 * start) - start) / FPS
    pace = np.ones(len(time))
    if pause:
        pace = 1.0 - ease((time - pause[0] + RAMP) / RAMP) * (1.0 - ease((time - pause[1]) / RAMP))
    wander = (0.03 if speed else 0.0) * drift(rng, time)
    if pause:
        wander = np.cumsum(pace * np.gradient(wander))
    yaw = np.cumsum(turn * pace * ease(time / 0.8)) / FPS + wander
    yaw = yaw - yaw[start]
    # cadence and stride both grow with the square root of the speed
    position = np.cumsum((speed * pace ** 2 / FPS)[:, None] * legs.forward_of(yaw + heading),
                         axis=0)
    begin = rng.uniform()
    phase = begin + cadence * time + 0.008 * drift(rng, time)
    if pause:
        phase = begin + np.cumsum(pace * np.gradient(phase))
        both = 0.5 * (gait.stance - 0.5)             # the other foot is about to leave
        there = phase[np.argmin(np.abs(time - 0.5 * (max(pause[0], time[0])
                                                     + min(pause[1], time[-1]))))]
        phase += both + 0.5 * np.round(2.0 * (there - both)) - there
    return legs.Path(phase, position - position[start], yaw), pace, start


def irregularity(rng: np.random.Generator, time: np.ndarray, tremor: float) -> dict:
    """Nobody is periodic: slow drifts and a tremor.   (T,) seconds  ->  {part: (T,)}"""
    sizes = {"lean": 0.6, "tilt": 0.6, "look": 3.0, "nod": 1.5, "LeftArm": 1.5, "RightArm": 1.5,
             "LeftElbow": 2.0, "RightElbow": 2.0}
    return {name: size * drift(rng, time) + tremor * drift(rng, time, 3.0, 6.0)
            for name, size in sizes.items()}


def gesturing(rng: np.random.Generator, time: np.ndarray, size: float) -> dict:
    """What arms do beside swinging, each for itself: now and then they are raised, bend and wave;
    trunk and head take part.   (T,) seconds, 0 to 1  ->  {part: (T,)}, none for size 0

    >>> sorted(gesturing(np.random.default_rng(0), np.arange(9) / 60, 0.5))[:3]
    ['LeftArm', 'LeftBusy', 'LeftElbow']
    """
    if not size:
        return {}
    found = {name: size * degrees * drift(rng, time) for name, degrees in BUSY.items()}
    found["lean"] += size * _BOW * (0.5 + 0.5 * np.tanh(3.0 * (drift(rng, time) - 1.3)))
    for side in ("Left", "Right"):
        raised = size * (0.5 + 0.5 * np.tanh(2.5 * drift(rng, time, 0.1, 0.4)))
        for part, (low, high) in RAISED.items():
            share = 0.5 + 0.5 * np.tanh(drift(rng, time))
            found[side + part] = raised * (low + (high - low) * share)
        wave = np.sin(2 * np.pi * rng.uniform(0.5, 2.5) * time) * (0.5 + 0.5 * drift(rng, time))
        found[side + "Elbow"] += 25.0 * raised * wave
        found[side + "Busy"] = raised
    return found


def waves(phase: np.ndarray, centre: float, sharpness: float) -> dict:
    r"""The cosines that drive the body, each sharpened to `tanh(k cos) / tanh(k)`.
    (T,) cycles  ->  {name: (T,)}

    step : +1 when the left foot lands;  side : +1 in the middle of the left foot's stance
    arm : step, a little later;  twice : +1 in the middle of either stance, not sharpened
    """
    k = 0.05 + 2.0 * max(sharpness, 0.0)
    found = {name: np.tanh(k * np.cos(2 * np.pi * (phase - shift))) / np.tanh(k)
             for name, shift in (("step", 0.0), ("side", centre), ("arm", 0.03))}
    return found | {"twice": np.cos(4 * np.pi * (phase - centre))}
