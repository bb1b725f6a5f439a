"""What is measured of bodies is there, and a transfer to the same motion changes none of it."""

import numpy as np
import pytest

from refimpl.embedded.walkers import make_clip
from refimpl.experiments import bodies
from refimpl.motion.body import make_take
from refimpl.motion.canonical import measured
from refimpl.motion.joints import SLOT

TAKE = make_take(make_clip("walk", seconds=2.0).clip)


@pytest.mark.parametrize("body", bodies.BODIES)
def test_bones_are_as_many_times_as_long(body):
    other = measured(make_take(bodies.proportioned(TAKE, bodies.BODIES[body])).positions)
    own, factors = measured(TAKE.positions), bodies.BODIES[body]
    legs = factors.get("Leg", 1.0)
    assert other.leg == pytest.approx(legs * own.leg)
    wide = [np.linalg.norm(b.rest[SLOT["LeftUpLeg"]] - b.rest[SLOT["RightUpLeg"]])
            for b in (own, other)]
    assert wide[1] == pytest.approx(factors.get("UpLeg", 1.0) * wide[0])
    arm = [np.linalg.norm(b.rest[SLOT["LeftHand"]] - b.rest[SLOT["LeftForeArm"]])
           for b in (own, other)]
    assert arm[1] == pytest.approx(factors.get("Hand", 1.0) * arm[0])


def test_what_was_done_is_what_is_measured():
    same = bodies.body_numbers(TAKE.positions, TAKE)
    for name in ("hips off", "shoulders off", "foot pitch off", "hip height off"):
        assert same[name] == pytest.approx(0, abs=1e-9)
    for name in ("slide", "lowest", "acceleration", "acceleration p99.9", "ends"):
        assert same[name] == same[f"{name} of content"]
    torn = TAKE.positions.copy()
    torn[:, SLOT["LeftArm"]] += 0.5 * (torn[:, SLOT["LeftArm"]] - torn[:, SLOT["RightArm"]])
    torn[..., 1] -= 8.0
    torn[60, SLOT["LeftLeg"]] += 5.0
    found = bodies.body_numbers(torn, TAKE)
    assert found["shoulders off"] == pytest.approx(0.5) and found["hips off"] < 1e-9
    assert found["lowest"] == pytest.approx(same["lowest"] - 0.1, abs=1e-3)
    assert found["acceleration"] > 2 * same["acceleration"]
