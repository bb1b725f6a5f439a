"""Pictures: every figure is there, names its units and can be read, and the same motion makes the
same bytes.
"""

import subprocess
import sys

import numpy as np
import pytest

from refimpl.pictures import plot
from refimpl.pictures.staging import COLOURS
from refimpl.motion import skeleton
from refimpl.motion.body import make_take
from refimpl.motion.joints import SLOT
from refimpl.embedded.walkers import make_clip

PNG = b"\x89PNG\r\n\x1a\n"


def world(*arguments, **options):
    clip = make_clip(*arguments, **options).clip
    return skeleton.forward_kinematics(clip.parents, *skeleton.local_pose(clip))[1]


@pytest.fixture(scope="module")
def motions():
    return {"style": world("walk", "zombie", seconds=2.0),
            "content": world("turn-left", "normal", seconds=2.0),
            "result": world("walk", "old", seconds=1.5)}


def texts(ax):
    return [text.get_text() for text in ax.texts] + [ax.get_xlabel(), ax.get_ylabel()]


def test_projection_keeps_right_up_and_near():
    points = np.eye(3)
    flat, near = plot.seen_from(points, "front")
    assert (flat == pytest.approx(np.array([[1, 0], [0, 1], [0, 0]]))
            and near == pytest.approx([0, 0, 1]))
    flat, near = plot.seen_from(points, "side")
    assert (flat == pytest.approx(np.array([[0, 0], [0, 1], [1, 0]]))
            and near == pytest.approx([-1, 0, 0]))
    flat, near = plot.seen_from(np.random.default_rng(0).normal(size=(5, 3)), (33.0, 21.0))
    again, _ = plot.seen_from(np.eye(3), (33.0, 21.0))
    # an isometry in the plane
    assert again.T @ again == pytest.approx(np.eye(2))
    with pytest.raises(ValueError, match="view.*three-quarter"):
        plot.seen_from(points, "below")


def test_the_far_side_is_pale():
    pose = world("walk", seconds=0.1)[0]
    ax = plot._figure(3, 3).subplots()
    artists = plot.draw_pose(ax, pose, "side", colour="#000000")
    # seen from its right
    assert (sum(artists["Left leg"].get_color()) > 1 and artists["Right leg"].get_color()
            == "#000000")
    # half a turn
    plot.move_pose(artists, pose * [-1, 1, -1], "side", colour="#000000")
    assert (sum(artists["Right leg"].get_color()) > 1 and artists["Left leg"].get_zorder()
            > artists["trunk"].get_zorder())


def test_facing_forward_turns_the_whole_motion():
    motion = world("turn-right", seconds=1.0)
    c, s = np.cos(2.0), np.sin(2.0)
    turned = (motion @ np.array([[c, 0, -s], [0, 1, 0], [s, 0, c]])) + [300.0, 0.0, -70.0]
    assert plot.facing_forward(turned) == pytest.approx(plot.facing_forward(motion), abs=1e-9)
    across = (plot.facing_forward(turned)[0, SLOT["LeftArm"]]
              - plot.facing_forward(turned)[0, SLOT["RightArm"]])
    assert (across[0] > 25 and plot.facing_forward(turned)[0, 0, [0, 2]]
            == pytest.approx([0, 0], abs=1e-9))


def test_strip_has_a_row_each_a_bar_and_seconds(motions, tmp_path):
    figure = plot.strip(motions, tmp_path / "strip.png", every=12, title="A title")
    assert len(figure.axes) == 3 and (tmp_path / "strip.png").read_bytes().startswith(PNG)
    for ax, label, colour in zip(figure.axes, motions, COLOURS.values()):
        assert label in texts(ax) and "100 cm" in texts(ax)
        assert len(ax.patches) == len(motions[label][::12])                     # a head each
    assert [t.get_text() for t in figure.axes[-1].get_xticklabels()][:3] == ["0.00", "0.20", "0.40"]
    assert "time [s]" in texts(figure.axes[-1])


@pytest.mark.parametrize("view", sorted(plot.VIEWS))
def test_poses_of_a_strip_do_not_overlap(motions, view):
    figure = plot.strip(motions, every=10, view=view)
    for ax in figure.axes:
        boxes = sorted((head.get_xy()[:, 0].min(), head.get_xy()[:, 0].max())
                       for head in ax.patches)
        assert all(right < left for (_, right), (left, _) in zip(boxes, boxes[1:]))


def test_metres_and_other_labels_work(motions, tmp_path):
    figure = plot.strip({"a rather long label of a row": motions["style"] / 100.0}, unit="m",
                        every=20)
    assert "1 m" in texts(figure.axes[0])
    plot.save(figure, tmp_path / "metres.png")
    assert len(set(plot.colours(["style", "content", "result", "a", "b", "c"]).values())) == 6
    assert len(plot.colours([str(n) for n in range(30)])) == 30


def test_paths_have_units_and_true_angles(motions, tmp_path):
    figure = plot.paths(motions, tmp_path / "paths.png", unit="cm")
    ax, = figure.axes
    assert ax.get_aspect() == 1.0 and "[cm]" in ax.get_xlabel() and "[cm]" in ax.get_ylabel()
    assert [t.get_text() for t in ax.get_legend().get_texts()] == list(motions)
    assert (tmp_path / "paths.png").read_bytes().startswith(PNG)
    assert plot.paths({"one frame": motions["style"][:1]}).axes


def test_curves_choose_their_scale(tmp_path):
    records = [{"epoch": n, "total": 10.0 ** -n, "foot": 2.0} for n in range(4)]
    figure = plot.curves(records, ["total", "foot"], tmp_path / "loss.png")
    ax, = figure.axes
    assert ax.get_yscale() == "log" and ax.get_xlabel() == "epoch" and len(ax.lines) == 2
    assert ax.lines[0].get_linestyle() != ax.lines[1].get_linestyle()
    assert plot.curves([{"total": 1.0}, {"total": -1.0}, {"total": float("nan")}],
                       "total").axes[0].get_yscale() == "linear"
    with pytest.raises(ValueError, match="missing.*bone"):
        plot.curves(records, ["bone"])


def test_the_same_figure_makes_the_same_bytes(motions, tmp_path):
    for name in ("a.png", "b.png"):
        plot.strip(motions, tmp_path / name, every=30)
    data = (tmp_path / "a.png").read_bytes()
    assert (data == (tmp_path / "b.png").read_bytes() and b"Software" not in data
            and b"tIME" not in data)
    assert 600 < int.from_bytes(data[16:20], "big") <= 1600                     # pixels wide


@pytest.mark.parametrize("bad, says", [
    ({}, "none"), ({"a": np.zeros((4, 20, 3))}, r"'a'.*\(4, 20, 3\)"),
    ({"a": np.full((2, 21, 3), np.nan)}, "finite")])
def test_refuses_what_is_no_motion(bad, says):
    for draw in (plot.strip, plot.paths):
        with pytest.raises(ValueError, match=says):
            draw(bad)


def test_refuses_bad_steps(motions):
    with pytest.raises(ValueError, match="every"):
        plot.strip(motions, every=0)


def test_pictures_do_not_touch_pyplot():
    code = ("import sys, refimpl.pictures.plot; "
            "assert 'matplotlib.pyplot' not in sys.modules")
    subprocess.run([sys.executable, "-c", code], check=True)


def test_a_notebook_shows_figures(motions):
    picture = plot.strip({"a": motions["result"]}, every=30)
    assert picture._repr_png_().startswith(PNG) and picture._repr_png_() == picture._repr_png_()


def test_the_ground_is_drawn_where_the_feet_stand():
    positions = make_take(make_clip("walk", "normal", seconds=2.0).clip).positions
    for lift in (0.0, 100.0):
        assert abs(plot.ground_height(positions + [0.0, lift, 0.0]) - lift) < 0.5
    heights = [ax.get_ylim() for ax in plot.strip({"a": positions}).axes
               + plot.strip({"a": positions + [0.0, 100.0, 0.0]}).axes]
    np.testing.assert_allclose(heights[0], heights[1], atol=1e-6)
