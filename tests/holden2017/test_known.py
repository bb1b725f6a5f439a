"""A clip that the style cannot know is told and fades, and one that it knows is not; the path is
the content's.
"""

from dataclasses import replace

import numpy as np
import pytest

from refimpl.holden2017 import networks
from refimpl.motion.known import QUANTITIES, STRANGE, known, quantities
from refimpl.holden2017.trained import Manifold, Style
from refimpl.styles.files import load_style, save_style
from refimpl.holden2017.transfer import transfer
from refimpl.motion.features import SIDEWAYS, bone_lengths, path_error, path_length
from refimpl.motion.joints import SLOT
from refimpl.motion.windows import fit_normaliser
from refimpl.embedded.walkers import make_clip, make_database
from refimpl.motion.body import make_take, seen
from refimpl.motion.canonical import measured


@pytest.fixture(scope="module")
def learnt():
    return [make_take(m.clip).features
            for m in make_database(seconds_per_clip=4.0, people=4, styles=("normal",))]


@pytest.fixture(scope="module")
def walk():
    return make_take(make_clip("walk", seed=77).clip)


def changed(walk, **by):
    """A walk with some of its quantities moved."""
    features = walk.features.copy()
    for name, (columns, value) in by.items():
        features[:, columns] = features[:, columns] * value if name == "scaled" else (
            features[:, columns] + value)
    return features


def test_walks_are_known_and_what_nobody_did_is_told_by_name(learnt, walk):
    leg = walk.leg
    seen_before = known(learnt, leg)
    for content in ("walk", "jog", "turn-right"):
        take = make_take(make_clip(content, seed=5).clip)
        assert seen_before.outside(take.features, leg)[0] < STRANGE
        assert seen_before.trust(take.features, leg).mean() > 0.95
    heights = slice(1, 63, 3)
    for strange, name in (
            (changed(walk, arm=(3 * SLOT["LeftHand"] + 1, 90.0)), "hands above the hips"),
            (changed(walk, low=(heights, -60.0)), "height of the hips"),
            (changed(walk, scaled=(64, 6.0)), "speed forward"),
            (changed(walk, turn=(63, 0.2)), "turning")):
        share, words = seen_before.outside(strange, leg)
        assert share > STRANGE and words.startswith(name), (words, name)
        assert seen_before.trust(strange, leg).mean() < 0.5
    for nothing in (walk.features[:3], np.repeat(walk.features[30:31], 300, axis=0)):
        nothing = nothing.copy()
        nothing[:, 63:] = 0
        assert seen_before.outside(nothing, leg)[0] == 1.0


def test_what_is_told_of_a_frame(walk):
    """Each number is what its name says, on a clip whose truth is known."""
    found = dict(zip(QUANTITIES, quantities(walk.features, walk.leg)[30:-30].T))
    assert found["speed forward"].mean() * walk.leg == pytest.approx(110.0, rel=0.05)
    heights = walk.positions[30:-30, 0, 1] - walk.start.floor
    assert found["height of the hips"].mean() * walk.leg == pytest.approx(heights.mean(), abs=0.1)
    assert found["lean of the trunk"].mean() < 10 and found["turning"].max() < 30
    turning = make_take(make_clip("turn-left", seed=1).clip)
    assert quantities(turning.features, turning.leg)[120:-20, 2].mean() == pytest.approx(
        np.degrees(0.55), rel=0.15)


def test_a_style_fades_before_and_after_what_it_does_not_know(learnt, walk):
    features = walk.features.copy()
    features[100:130, 1:63:3] -= 60.0
    trust = known(learnt, walk.leg).trust(features, walk.leg)
    assert trust[115] == pytest.approx(0.0, abs=1e-3) and trust[:30].min() > 0.99
    assert np.abs(np.diff(trust)).max() < 0.05


def style_that_drifts(walk, learnt, step):
    """T(I) = I, but for a constant sideways velocity: the identity as three layers, and a bias."""
    manifold = Manifold(networks.init_loss_network(np.random.default_rng(0), hidden=8),
                        fit_normaliser(np.concatenate(learnt), "test"), walk.leg,
                        bone_lengths(walk.positions), rest=measured(walk.positions).rest)
    eye = np.eye(66, dtype=np.float32)[:, :, None]
    both = np.concatenate([eye, -eye])                           # relu(x) - relu(-x) = x
    params = {"W1": both, "b1": np.zeros(132, np.float32),
              "W2": np.eye(132, dtype=np.float32)[:, :, None], "b2": np.zeros(132, np.float32),
              "W3": both.transpose(1, 0, 2).copy(), "b3": np.zeros(66, np.float32)}
    params["b3"][SIDEWAYS] = step / manifold.normaliser.deviation[SIDEWAYS]
    return Style(params, manifold, "drifts", {"walk": "walk"}, known=known(learnt, walk.leg))


def test_the_path_is_the_contents_and_where_t_would_go_is_told(learnt, walk):
    style = style_that_drifts(walk, learnt, 1.5)
    result, raw = transfer(walk, style), transfer(walk, style, clean=False)
    assert result.way == pytest.approx(path_length(walk.features) / walk.leg, rel=1e-3)
    assert result.astray == pytest.approx(1.5 * (len(walk.features) - 1) / 2 / walk.leg, rel=0.02)
    content = seen(walk, style.manifold.body).features
    assert path_error(result.features, content)[0] < 1e-9
    assert path_error(raw.features, walk.features)[0] > 1 and result.warnings == ()


def test_strength_leads_from_the_content_to_the_style(learnt, walk):
    style = style_that_drifts(walk, learnt, 0.05)
    style.params["b3"][3 * 5 + 2] += 3.0                         # the pelvis forward
    none, half, whole = (transfer(walk, style, strength=s).positions for s in (0.0, 0.5, 1.0))
    np.testing.assert_allclose(none, walk.positions, atol=1e-9)
    apart = [np.linalg.norm(p - walk.positions, axis=-1).mean() for p in (half, whole)]
    assert 0.3 * apart[1] < apart[0] < 0.7 * apart[1]


def test_a_style_file_remembers_what_it_knows(learnt, walk, tmp_path):
    style = style_that_drifts(walk, learnt, 0.05)
    save_style(tmp_path / "style", style)
    again = load_style(tmp_path / "style")
    assert again.known.said == style.known.said and "height of the hips" in again.known.said
    np.testing.assert_array_equal(again.known.high, style.known.high)
    save_style(tmp_path / "style", replace(style, known=None))
    assert (load_style(tmp_path / "style").known is None
            and np.isnan(transfer(walk, load_style(tmp_path / "style")).strangeness))
    still = np.repeat(walk.clip.values[:1], 300, axis=0)
    result = transfer(make_take(replace(walk.clip, values=still)), style)
    assert (result.strangeness > STRANGE
            and "outside of what the style learnt" in " ".join(result.warnings))
