"""A clip that the style cannot know is told, and one that it knows is not; a path that T leaves is
kept.
"""

from dataclasses import replace

import numpy as np
import pytest

from refimpl.holden2017 import networks
from refimpl.motion.known import LEAST, STRANGE, known
from refimpl.holden2017.trained import Manifold, Style
from refimpl.styles.files import load_style, save_style
from refimpl.holden2017.transfer import transfer
from refimpl.motion.features import SIDEWAYS, bone_lengths, path_error, path_length
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


def test_walks_are_known_and_gestures_are_not(learnt, walk):
    seen = known(learnt)
    for content in ("walk", "jog", "turn-right"):
        assert seen.strangeness(make_take(make_clip(content, seed=5).clip).features) < STRANGE
    standing = np.repeat(walk.features[30:31], 300, axis=0)
    standing[:, -3:] = 0
    raised = walk.features.copy()
    raised[:, 3 * 13 + 1:3 * 17:3] += [30, 50, 70, 80]           # the left arm above the head
    for strange in (standing, raised, make_take(make_clip("walk", "zombie", seed=5).clip).features):
        assert seen.strangeness(strange) > STRANGE


def test_what_was_learnt_is_told_from_its_neighbours(learnt):
    """The unit: of the clips learnt on, held against all the others, hardly any lies farther than
    1.
    """
    far = [known(learnt[:k] + learnt[k + 1:]).strangeness(learnt[k]) for k in range(len(learnt))]
    assert np.median(far) < 1 and max(far) < 2 * STRANGE
    assert known(learnt[:LEAST - 1]) is None and known(learnt[:LEAST]) is not None


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
    return Style(params, manifold, "drifts", {"walk": "walk"}, known=known(learnt))


@pytest.mark.parametrize("step, kept", [(0.05, False), (1.5, True)])
def test_a_path_that_is_left_is_kept_and_told(learnt, walk, step, kept):
    style = style_that_drifts(walk, learnt, step)
    result, raw = transfer(walk, style), transfer(walk, style, clean=False)
    assert result.kept is kept and not raw.kept
    assert result.way == pytest.approx(path_length(walk.features) / walk.leg, rel=1e-3)
    assert result.astray == pytest.approx(step * (len(walk.features) - 1) / 2 / walk.leg, rel=0.02)
    content = seen(walk, style.manifold.body).features
    error = path_error(result.features, content)[0]
    assert (error < 1e-9) is kept and path_error(raw.features, walk.features)[0] > 1
    assert (len(result.warnings) == kept
            and (not kept or "the content's own path is kept" in result.warnings[0]))


def test_a_style_file_remembers_what_it_knows(learnt, walk, tmp_path):
    style = style_that_drifts(walk, learnt, 0.05)
    save_style(tmp_path / "style", style)
    again = load_style(tmp_path / "style")
    assert again.known.strangeness(walk.features) == style.known.strangeness(walk.features)
    save_style(tmp_path / "style", replace(style, known=None))
    assert (load_style(tmp_path / "style").known is None
            and np.isnan(transfer(walk, load_style(tmp_path / "style")).strangeness))
    still = np.repeat(walk.clip.values[:1], 300, axis=0)
    result = transfer(make_take(replace(walk.clip, values=still)), style)
    assert (result.strangeness > STRANGE and "nothing like what the style learnt on"
            in result.warnings[0])
