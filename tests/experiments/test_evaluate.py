"""Judges tell apart what is apart; the Fréchet distance of known Gaussians; the evaluation on
doctored motion.
"""

from dataclasses import replace

import numpy as np
import pytest

from refimpl.experiments import evaluate
from refimpl.holden2016 import bridge, network, rows
from refimpl.experiments import classifiers
from refimpl.holden2017 import networks
from refimpl.holden2017.trained import Manifold, Style
from refimpl.motion.dataset import assemble
from refimpl.motion.features import POSITIONS
from refimpl.motion.joints import FEET
from refimpl.motion.windows import fit_normaliser
from refimpl.embedded.walkers import make_database
from refimpl.motion.body import make_take


@pytest.fixture(scope="module")
def world():
    """Embedded clips of two styles and contents by four people, and an untrained loss network,
    which tells motions apart all the same.
    """
    motions = make_database(seconds_per_clip=3.0, people=4, contents=("walk", "jog"),
                            styles=("normal", "zombie"))
    takes = {m.name: make_take(m.clip) for m in motions}
    dataset = assemble(takes.items(), {m.name: (m.content, m.style) for m in motions},
                       "embedded motion", 0.25)
    normaliser = fit_normaliser(np.concatenate([c.features for c in dataset.clips]), "test")
    manifold = Manifold(networks.init_loss_network(np.random.default_rng(0), hidden=24,
                                                   dtype=float), normaliser, dataset.leg,
                        dataset.bones, rest=dataset.rest)
    params = networks.init_transformation_network(np.random.default_rng(1), channels=4, width=5,
                                                  dtype=float)
    return (takes, dataset, manifold,
            Style(params, manifold, "zombie", {"walk": "walk", "jog": "jog"}))


@pytest.fixture(scope="module")
def both(world):
    _, dataset, manifold, _ = world
    return evaluate.fit_classifiers(dataset.select(held_out=False), manifold, dataset.leg)


@pytest.mark.parametrize("name", ["gram", "joints"])
def test_a_judge_recognises_people_that_it_never_saw(world, both, name):
    _, dataset, _, _ = world
    held = dataset.select(held_out=True)
    assert (len(held) == 4 and [both[name].classify(c.features) for c in held]
            == [(c.style, c.content) for c in held])
    assert all(np.argmax(both[name].scores(c.features))
               == both[name].labels.index((c.style, c.content)) for c in held)


def test_the_judge_of_joints_sees_jitter(world, both):
    _, dataset, _, _ = world
    clean = dataset.select(held_out=True)[0].features
    shaken = clean + np.random.default_rng(2).normal(0, 1.0, clean.shape) * (np.arange(66) < 63)
    distance = [classifiers.frechet_distance(both["joints"].embed(f), both["joints"].embed(clean))
                for f in (clean, shaken)]
    assert distance[0] < 1e-9 < 100 < distance[1]


def test_scores_are_the_equation(world, both):
    _, dataset, _, _ = world
    judge, clips = both["joints"], dataset.select(held_out=False)
    Z = [((judge.vectors(c.features) - judge.centre) / judge.scale) @ judge.basis for c in clips]
    mu = {k: np.concatenate([z for z, c in zip(Z, clips) if (c.style, c.content) == k]).mean(axis=0)
          for k in judge.labels}
    within = np.concatenate([z - mu[c.style, c.content] for z, c in zip(Z, clips)])
    S = within.T @ within / len(within)
    S = 0.8 * S + 0.2 * np.trace(S) / len(S) * np.eye(len(S))
    x = Z[0]
    wanted = [-0.5 * np.mean([(v - mu[k]) @ np.linalg.solve(S, v - mu[k]) for v in x])
              for k in judge.labels]
    np.testing.assert_allclose(judge.scores(clips[0].features), wanted, rtol=1e-8)


def test_pieces_cover_a_clip_and_a_short_one_is_one():
    found = classifiers.sliding_windows(np.arange(200), span=120, hop=30)
    assert [(p[0], p[-1]) for p in found] == [(0, 119), (30, 149), (60, 179), (80, 199)]
    assert ([len(p) for p in classifiers.sliding_windows(np.arange(7))] == [7]
            and len(classifiers.sliding_windows(np.arange(120))) == 1)


def test_frechet_distance_of_gaussians_that_commute():
    rng = np.random.default_rng(3)
    x = rng.standard_normal((100000, 2)) * [2.0, 1.0]
    y = rng.standard_normal((100000, 2)) * [1.0, 3.0] + [4.0, 0.0]
    # sum of (deviation - deviation)^2
    assert classifiers.frechet_distance(x, y, shrinkage=0.0) == pytest.approx(16 + 1 + 4, rel=0.02)
    assert classifiers.frechet_distance(x, y) == pytest.approx(classifiers.frechet_distance(y, x))
    assert classifiers.frechet_distance(x, x) == pytest.approx(0, abs=1e-9)


def test_one_class_is_refused(world):
    _, dataset, _, _ = world
    with pytest.raises(ValueError, match="found 1 classes"):
        classifiers.fit_classifier([(dataset.clips[0].features, "a", "b")],
                                   classifiers.joint_vectors)
    with pytest.raises(ValueError, match="found 2 windows, no class with two that differ"):
        classifiers.fit_classifier([(dataset.clips[i].features[:120], "a", str(i)) for i in (0, 1)],
                                   classifiers.joint_vectors)


def test_doctored_motion_measures_what_was_done_to_it(world, both):
    takes, dataset, manifold, _ = world
    clip = dataset.select(style="normal", content="walk", held_out=True)[0]
    take = takes[clip.name]
    own = evaluate.measure(take, take, [clip.features], manifold, both)
    assert (own["bone error"] == own["path error"] == own["content distance"] == 0
            and own["style distance"] < 1e-6 * np.abs(clip.features).sum())
    moved = take.positions.copy()
    slide = 10 / 60 * np.arange(len(moved))
    moved[..., 0] += slide[:, None]
    still = np.ones_like(take.contacts)
    standing = replace(take,
                       positions=np.repeat(take.positions[:1], len(moved), axis=0)
                       + slide[:, None, None] * [1, 0, 0], contacts=still)
    content = replace(take, contacts=still)
    found = evaluate.measure(standing, content, [clip.features], manifold, both)
    # a clip with a skate of 10 cm/s measures 10 cm/s
    assert found["skate"] == pytest.approx(10.0)
    found = evaluate.measure(replace(take, positions=moved), take, [clip.features], manifold, both)
    assert found["path error"] == pytest.approx(slide.mean())
    longer = replace(take.clip, joints=tuple(
        replace(joint, offset=tuple(1.03 * x for x in joint.offset)) for joint in take.clip.joints))
    found = evaluate.measure(replace(take, clip=longer), take,
                             [clip.features], manifold, both)
    assert found["bone error"] == pytest.approx(0.03)
    sunk = take.positions.copy()
    sunk[5:, FEET[1], 1] -= 100.0
    found = evaluate.measure(replace(take, positions=sunk), take, [clip.features], manifold, both)
    assert 80 < found["sinks"] <= found["sinks at most"] < 100.1


def of_2016(dataset):
    """A network of the 2016 system, untrained, on the scale of its code."""
    normaliser = rows.fit_normaliser(bridge.training_windows(dataset.clips[:2]))
    return bridge.Network(network.init_network(np.random.default_rng(0), hidden=4, width=5),
                          normaliser)


def test_every_system_is_carried_out_and_summed_up(world, both, tmp_path):
    takes, dataset, manifold, style = world
    clip = dataset.select(style="normal", content="walk", held_out=True)[0]
    take, exemplars = (takes[clip.name],
                       [c.features for c in dataset.select(style="zombie", content="walk",
                                                           held_out=False)])
    rows = [{"style": "zombie", "content": "walk", "system": "content",
             **evaluate.measure(take, take, exemplars, manifold, both)}]
    settings = evaluate.Settings(iterations=3, constraint_iterations=2)
    for system, result, seconds in evaluate.carry_out(take, exemplars, style, settings,
                                                      network=of_2016(dataset)):
        again = evaluate.read_back(result.clip, tmp_path / "a.bvh")
        rows.append({"style": "zombie", "content": "walk", "system": system,
                     **evaluate.measure(again, take, exemplars, manifold, both),
                     "seconds": seconds})
    real = dataset.select(style="zombie", content="walk", held_out=True)[0]
    rows.append({"style": "zombie", "content": "walk", "system": "real",
                 **evaluate.measure_real(real, dataset.leg, exemplars, manifold, both)})
    lines = evaluate.summarise_systems(rows, {("zombie", s): 1.0 for s in evaluate.SYSTEMS})
    assert [line["system"] for line in lines] == list(evaluate.SYSTEMS)
    by_system = {line["system"]: line for line in lines}
    assert (by_system["content"]["style by joints"] == 0 and by_system["real"]["style by joints"]
            == by_system["real"]["style by gram"] == 1)
    assert (by_system["content"]["style distance left"] == by_system["real"]["jerk / real"] == 1
            and by_system["real"]["style distance left"] < 0.5)
    assert all(row["bone error"] < 1e-6 for row in rows if "bone error" in row)
    slides = {row["system"]: row["skate"] for row in rows if "skate" in row}
    # Of an untrained network, which shakes feet out of reach for moments.
    assert all(slides[system] < 0.65 * slides["content"]
               for system in (evaluate.OWN, "2017", "2017, own pace"))
    assert by_system["2017 T(I), raw"]["skate"] > 1 and by_system["2017"]["frames/s"] > 0


def test_judges_are_kept_apart_from_what_transfers_used(world):
    _, dataset, manifold, style = world
    names = [c.name for c in dataset.select(held_out=False)]
    used = replace(style, learned=tuple(names[:2]), exemplars=tuple(names[-2:]))
    found = [c.name for c in evaluate.classifier_clips(dataset, [used])]
    assert set(found) == set(names[2:-2])
    names = tuple(clip.name for clip in dataset.select(style="zombie"))
    with pytest.raises(evaluate.EvaluationError, match="found no clip of style zombie"):
        evaluate.classifier_clips(dataset, [replace(style, exemplars=names)])
    with pytest.raises(evaluate.EvaluationError, match="found none of its exemplars"):
        evaluate.exemplars_of(dataset, style, "walk")


def test_both_systems_are_timed_at_each_length(world):
    _, dataset, _, style = world
    clip = dataset.clips[0]
    lines = evaluate.timings(clip.features, clip.contacts, [clip.features], style, frames=(20, 200),
                             repeats=1, settings=evaluate.Settings(iterations=2),
                             network=of_2016(dataset))
    assert [line["frames"] for line in lines] == [20, 200]
    assert all(line[system] > 0 for line in lines
               for system in (evaluate.CODED, evaluate.OWN, "2017"))
    assert all(line["ratio"] == line[evaluate.OWN] / line["2017"] for line in lines)


def test_projection_is_measured_with_and_without_noise(world):
    _, dataset, _, style = world
    lines = evaluate.projection_effect(dataset.select(held_out=True)[:2], style, dataset.leg)
    assert (len(lines) == 4 and lines[2]["jerk / clean"] > 5 and lines[2]["error"] > 0
            and np.isnan(lines[0]["error"]))
    deviation = style.manifold.normaliser.deviation[POSITIONS]
    assert (lines[2]["error"] == pytest.approx(0.3 * np.sqrt(3) * np.sqrt(np.mean(deviation ** 2)),
                                               rel=0.05))
