"""Points in: the orders of this package and of SMPL, other orders by a mapping, what is refused."""

import numpy as np
import pytest

from refimpl.cli import main
from refimpl.motion.body import make_take, read_take
from refimpl.motion.joints import SLOT, SLOTS, MappingError
from refimpl.motion.points import SMPL, PointsError, read_points

from . import bodies

POINTS = make_take(bodies.walker()).positions


def smpl(count=22, points=POINTS):
    """The points in SMPL's order; what it has besides lies between."""
    out = np.repeat(points[:, :1], count, axis=1)
    for slot, j in SMPL.items():
        if j < count:
            out[:, j] = points[:, SLOT[slot]]
    out[:, 6] = points[:, [SLOT["Spine"], SLOT["Chest"]]].mean(axis=1)
    return out


def saved(path, array):
    np.save(path, array)
    return path


def test_our_own_order_comes_back_point_by_point(tmp_path):
    take = read_take(saved(tmp_path / "a.npy", POINTS))
    np.testing.assert_allclose(take.positions, POINTS, atol=1e-6)
    assert take.clip.fps == 60 and take.clip.names == SLOTS


@pytest.mark.parametrize("count", [22, 24])
@pytest.mark.parametrize("turn", [np.eye(3), [[1, 0, 0], [0, 0, -1], [0, 1, 0]]])
def test_smpls_order_in_metres_at_twenty_frames_in_either_world(tmp_path, count, turn):
    points = 0.01 * smpl(count)[::3] @ np.array(turn).T
    np.savez(tmp_path / "a.npz", joints=points[None])
    take = read_take(tmp_path / "a.npz")
    assert take.clip.fps == 20 and take.leg == pytest.approx(0.8)
    kept = [SLOT[s] for s in SLOTS if "Finger" not in s]
    np.testing.assert_allclose(take.positions[::3][:, kept], 0.01 * POINTS[::3][:, kept], atol=1e-6)
    assert read_take(tmp_path / "a.npz", rate=60.0).clip.fps == 60


def test_another_order_by_a_mapping(tmp_path):
    order = np.random.default_rng(0).permutation(21)
    path = saved(tmp_path / "a.npy", np.concatenate([POINTS[:, order], POINTS[:, :4]], axis=1))
    with pytest.raises(MappingError, match="found 25 points a frame and nothing for Hips"):
        read_points(path)
    by_slot = {slot: str(int(np.flatnonzero(order == n)[0])) for n, slot in enumerate(SLOTS)}
    np.testing.assert_allclose(read_take(path, by_slot).positions, POINTS, atol=1e-6)
    with pytest.raises(MappingError, match="needed a number below 25"):
        read_points(path, {"Hips": "25"})


@pytest.mark.parametrize("array, words", [
    (np.zeros((5, 263)), "needed one array"), (np.zeros((2, 5, 22, 3)), "needed one array"),
    (np.full((5, 22, 3), np.nan), "not finite"),
    (np.array([{"motion": 1}], dtype=object), "needed \\(T, J, 3\\)")])
def test_what_is_no_motion_is_refused(tmp_path, array, words):
    with pytest.raises(PointsError, match=words):
        read_points(saved(tmp_path / "a.npy", array))


def test_points_are_inspected(tmp_path, capsys):
    path = saved(tmp_path / "walk.npy", 0.01 * smpl()[::3])
    assert main(["inspect", str(path)]) == 0
    out = capsys.readouterr().out
    assert "20 frames/s" in out and "metres" in out
