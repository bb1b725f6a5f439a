"""The front door: two commands, four lines, any body, and what a style does not know."""

from dataclasses import replace
import functools
import subprocess
import sys
import warnings

import numpy as np
import pytest

import refimpl
from refimpl.cli import main
from refimpl.embedded import crowd
from refimpl.embedded.walkers import make_clip
from refimpl.motion import bvh
from refimpl.motion.body import make_take
from refimpl.motion.features import bone_lengths_by_frame
from refimpl.motion.joints import FEET, SLOT
from refimpl.styles import box, make
from refimpl.styles.files import load_manifold, load_style
from tests.motion import bodies


@pytest.fixture
def here(tmp_path, monkeypatch):
    """A folder with a walk that no style has seen, and the current one."""
    monkeypatch.chdir(tmp_path)
    bvh.write_bvh("walk.bvh", make_clip("walk", seconds=4.0, seed=901).clip)
    return tmp_path


def lean(positions):
    trunk = positions[:, SLOT["Neck"]] - positions[:, SLOT["Hips"]]
    return np.degrees(np.arctan2(np.hypot(trunk[:, 0], trunk[:, 2]), trunk[:, 1])).mean()


def test_two_commands(here, capsys):
    assert main(["styles"]) == 0
    listed = capsys.readouterr().out.splitlines()
    assert [line.split()[0] for line in listed] == list(box.STYLES_SAID) and len(listed) >= 4
    assert all("legs/s" in line and "degrees" in line for line in listed)
    assert main(["transfer", "old", "walk.bvh", "-o", "old_walk.bvh"]) == 0
    said = capsys.readouterr()
    assert "in style 'old'" in said.out and said.err == ""
    content, result = bvh.read_bvh("walk.bvh"), bvh.read_bvh("old_walk.bvh")
    assert result.joints == content.joints and result.values.shape == content.values.shape
    assert result.fps == content.fps


def test_four_lines_give_what_the_command_gives(here):
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        walk = refimpl.read("walk.bvh")
        old = refimpl.style("old")
        result = old.transform(walk, strength=1.0)
        result.save("old_walk.bvh")
    assert main(["transfer", "old", "walk.bvh", "-o", "again.bvh"]) == 0
    assert (here / "old_walk.bvh").read_bytes() == (here / "again.bvh").read_bytes()
    assert "</" in result.show()._repr_html_()
    with pytest.raises(ValueError, match="does not end in .bvh"):
        result.save("old_walk.fbx")
    np.save("walk.npy", walk.positions)
    points = old.transform(refimpl.read("walk.npy"))
    assert points.clip.frames == result.clip.frames


@pytest.mark.parametrize("style, seed", [("old", 3), ("zombie", 4), ("proud", 5)])
def test_more_strength_is_more_change_from_none_on(style, seed):
    """And a little more strength a little more, also below that at which feet are planted."""
    rng = np.random.default_rng(seed)
    walk = make_take(make_clip(("walk", "jog", "turn-left")[seed % 3], seconds=3.0, seed=seed).clip)
    strengths = [0.0, *np.sort(rng.uniform(0.0, 0.3, 6)), 0.6, 1.0]
    made = [refimpl.style(style).transform(walk, strength=s).stylised.positions for s in strengths]
    np.testing.assert_allclose(made[0], walk.positions, atol=1e-9)
    far = [np.linalg.norm(p - walk.positions, axis=-1) for p in made]
    assert (np.diff([f.mean() for f in far]) > 0).all()
    for before, after, step in zip(made, made[1:], np.diff(strengths)):
        assert np.linalg.norm(after - before, axis=-1).max() < 3 * step * far[-1].max()


def test_options_of_the_four_lines(here):
    walk, old = refimpl.read("walk.bvh"), refimpl.style("old")
    none, half, whole = (old.transform(walk, strength=s).stylised.positions for s in (0, 0.5, 1))
    np.testing.assert_allclose(none, walk.positions, atol=1e-9)
    far, near = (np.linalg.norm(p - walk.positions, axis=-1).mean() for p in (whole, half))
    assert 0.2 * far < near < 0.9 * far and lean(walk.positions) < lean(half) < lean(whole)
    arms = old.transform(walk, only="arms").stylised.positions
    still = [SLOT[name] for name in ("Hips", "Head", "LeftUpLeg")]
    np.testing.assert_allclose(arms[:, still], walk.positions[:, still], atol=1e-6)
    assert old.transform(walk, fps=30).clip.fps == 30
    for wrong in ({"strength": -1}, {"strength": np.nan}):
        with pytest.raises(ValueError, match="strength: found"):
            old.transform(walk, **wrong)
    with pytest.raises(ValueError, match="no style of that name in the box, needed one of old"):
        refimpl.style("vampire")


@pytest.mark.parametrize("content, how", [
    ("walk", {}), ("walk", {"speed": 50.0, "pause": (1.5, 3.0)}), ("walk", {"turn": 0.8}),
    ("walk", {"gestures": 0.8}), ("jog", {"speed": 300.0}), ("stand", {})],
    ids=["walk", "halt", "turn", "gestures", "run", "stand"])
@pytest.mark.parametrize("scheme", ["CMU", "Mixamo", "Bandai"])
def test_on_any_body_nothing_is_wrong_with_the_result(scheme, content, how):
    """Clips of seeds that were not learnt on, on other skeletons: silent, the same joints, frames
    and bones, no foot under the floor, the path kept.
    """
    clip = bodies.on_scheme(make_clip(content, seconds=4.0, seed=77, **how).clip, scheme)[0]
    take = make_take(clip)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        result = refimpl.style("old").transform(take)
    after, before = make_take(result.clip).positions, take.positions
    assert result.clip.joints == clip.joints and result.clip.values.shape == clip.values.shape
    leg = take.leg
    np.testing.assert_allclose(bone_lengths_by_frame(after), bone_lengths_by_frame(before),
                               atol=1e-3 * leg)
    assert after[:, FEET, 1].min() > before[:, FEET, 1].min() - 0.02 * leg
    apart = np.linalg.norm((after - before)[:, 0, [0, 2]], axis=-1)
    way = np.linalg.norm(np.diff(before[:, 0, [0, 2]], axis=0), axis=-1).sum()
    assert apart.mean() < 0.05 * way + 0.1 * leg
    assert lean(after) > lean(before) + 8


def test_what_a_style_does_not_know_is_told_and_left_alone(here):
    walk, old = refimpl.read("walk.bvh"), refimpl.style("old")
    down = np.clip((np.arange(240) - 160) / 30, 0, 1)[:, None] * np.pi / 2
    x, y, z = np.moveaxis(walk.positions - walk.positions[:, :1] * [0, 0, 1], -1, 0)
    falling = np.stack([x, y * np.cos(down) + 15 * np.sin(down), z + y * np.sin(down)], axis=-1)
    np.save("lies_down.npy", falling + walk.positions[:, :1] * [0, 0, 1])
    take = refimpl.read("lies_down.npy")
    with pytest.warns(UserWarning, match="of the clip lies outside of what the style learnt on"):
        result = old.transform(take)
    assert len(result.warnings) == 1 and result.warnings[0].count("\n") == 0
    moved = np.linalg.norm(result.stylised.positions - take.positions, axis=-1).mean(axis=1)
    assert moved[:60].mean() > 3 * moved[200:].mean()
    short = make_take(replace(walk.clip, values=walk.clip.values[:3]))
    with pytest.warns(UserWarning, match="nothing can be seen to move"):
        assert old.transform(short).clip.frames == 3


def test_the_box_is_small_and_each_style_is_itself():
    files = [box.FOLDER / f"{name}.npz" for name in (box.LOSS_NETWORK, *box.STYLES_SAID)]
    assert sum(path.stat().st_size for path in files) < 3e6
    assert {path.name for path in box.FOLDER.glob("*.npz")} == {path.name for path in files}
    take = make_take(make_clip("walk", seconds=3.0, seed=901).clip)
    before, hand, chest = take.positions, SLOT["LeftHand"], SLOT["Chest"]
    after = {name: refimpl.style(name).transform(take).stylised.positions
             for name in box.STYLES_SAID}
    swing = {name: p[:, hand] - p[:, chest] for name, p in after.items()}
    assert lean(after["old"]) > lean(before) + 10 and lean(after["depressed"]) > lean(before) + 5
    assert after["old"][:, 0, 1].mean() < before[:, 0, 1].mean() - 3
    assert swing["zombie"][:, 1].mean() > swing["proud"][:, 1].mean() + 15     # held out
    assert swing["childlike"].std(axis=0).max() > 1.5 * swing["zombie"].std(axis=0).max()
    assert after["depressed"][:, SLOT["Head"], 1].mean() < after["proud"][:, SLOT["Head"],
                                                                          1].mean() - 5


def test_each_is_made_again_by_one_command(tmp_path, monkeypatch, capsys):
    """The way is the same, the networks are tiny."""
    monkeypatch.setattr(make, "made_style", functools.partial(make.made_style, scenes=4, epochs=1,
                                                              channels=4))
    monkeypatch.setattr(make, "made_manifold", functools.partial(make.made_manifold, scenes=10,
                                                                 epochs=1, hidden=6, width=9))
    made = {}
    for run in ("first", "again"):
        (tmp_path / run).mkdir()
        for name in ("old", box.LOSS_NETWORK):
            assert main(["styles", "--make", str(tmp_path / run), "--only", name]) == 0
        made[run] = {path.name: path.read_bytes() for path in (tmp_path / run).iterdir()}
    assert made["first"] == made["again"] and set(made["first"]) == {"old.npz", "loss_network.npz"}
    assert "old.npz: old, " in capsys.readouterr().out
    assert load_style(tmp_path / "first/old.npz", box.boxed_manifold()).params["b1"].size == 4
    assert load_manifold(tmp_path / "first/loss_network.npz").params["W0"].dtype == np.float32


def test_rooms_open_when_somebody_looks_in():
    code = ("import sys, refimpl\n"
            "assert not {'numpy', 'refimpl.motion'} & set(sys.modules)\n"
            "names = {'nn', 'motion', 'holden2017', 'styles', 'read', 'style'}\n"
            "assert names <= set(dir(refimpl))\n"
            "assert callable(refimpl.holden2017.networks.encode) and refimpl.nn.gram\n"
            "assert 'bvh' in dir(refimpl.motion) and refimpl.torresani2006.align.dtw\n"
            "try: refimpl.nowhere\n"
            "except AttributeError as why: assert 'nowhere' in str(why)\n"
            "else: raise AssertionError")
    subprocess.run([sys.executable, "-c", code], check=True)


def test_a_crowd_is_varied_and_plays_in_any_style():
    scenes = crowd.crowd(20)
    assert {scene.kind for scene in scenes} == set(crowd.KINDS)
    speeds = [scene.how["speed"] or 0 for scene in scenes]
    assert min(speeds) == 0 and max(speeds) > 250
    for scene in scenes[:10]:
        plain, old = (scene.played(style) for style in ("normal", "old"))
        assert plain.clip.values.shape == old.clip.values.shape
        heights = [m.clip.values[:, 1].mean() for m in (plain, old)]
        assert heights[1] < heights[0]


def test_a_style_is_learnt_from_clips():
    shown = [make_take(make_clip("walk", "proud", seconds=3.0, seed=s).clip) for s in (1, 2)]
    got = make.fitted({"walk": shown}, "mine", scenes=10, epochs=1, channels=4, width=9)
    assert got.name == "mine" and got.known is not None and set(got.pairs) == set(make.KINDS)
    assert refimpl.front.StyleTransfer(got).range.startswith("speed forward")
    for wrong in ([], {"swim": shown}, {"walk": []}):
        with pytest.raises(ValueError, match="shown: found"):
            make.fitted(wrong, "mine")
