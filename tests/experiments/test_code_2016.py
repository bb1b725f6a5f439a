"""The searched rows with one statement changed: unchanged they are the code's, and each change does
what it says.
"""

import json

import numpy as np
import pytest

from refimpl.cli import main
from refimpl.experiments import code_2016 as experiment
from refimpl.holden2016 import bridge, files, losses, network, rows, search
from refimpl.motion.dataset import assemble, save_dataset
from refimpl.motion.features import scale
from refimpl.embedded.walkers import make_database
from refimpl.motion.body import make_take


@pytest.fixture(scope="module")
def world():
    motions = make_database(seconds_per_clip=3.0, people=2, contents=("walk",),
                            styles=("normal", "old"))
    dataset = assemble([(m.name, make_take(m.clip)) for m in motions],
                       {m.name: (m.content, m.style) for m in motions}, "made", 0.5)
    windows = bridge.training_windows(dataset.clips)
    net = bridge.Network(network.init_network(np.random.default_rng(3), hidden=6, width=5),
                         rows.fit_normaliser(windows))
    size = bridge.unit_of(make_take(motions[0].clip).positions)
    made = {c.name: bridge.to_rows(scale(c.features, size), c.contacts) for c in dataset.clips}
    return dataset, net, made


@pytest.fixture
def short(monkeypatch):
    monkeypatch.setattr(search, "ITERATIONS", 5)
    monkeypatch.setattr(search, "CONSTRAINT_ITERATIONS", 4)


def test_unchanged_it_is_the_codes_search(world, short):
    _, net, made = world
    content, style = made["walk_normal_000"][:60], made["walk_old_000"][:80]
    start = search.noise(np.random.default_rng([0, 4]), len(content))
    wanted = search.transfer(content, style, net.params, net.normaliser, start=start, iterations=5,
                             constraint_iterations=4)
    result, styled = experiment.search_changed(content, style, net, experiment.CODE)
    np.testing.assert_allclose(result, wanted.result, atol=1e-10)
    np.testing.assert_allclose(styled, wanted.after_style, atol=1e-10)


def test_every_way_changes_something(world, short):
    _, net, made = world
    content, style = made["walk_normal_000"][:60], made["walk_old_000"][:80]
    code = experiment.search_changed(content, style, net, experiment.CODE)[0]
    for way in experiment.WAYS[1:]:
        if way.name == "no floor term":                          # needs feet under the floor
            mean = net.normaliser.mean.copy()
            mean[[rows.POSITIONS.start + 3 * foot + 1 for foot in losses.FEET]] -= 3
            low = bridge.Network(net.params, rows.Normaliser(mean, net.normaliser.deviation))
            a, b = (experiment.search_changed(content, style, low, w)[0]
                    for w in (experiment.CODE, way))
            assert np.abs(a - b).max() > 1e-6
        else:
            assert np.abs(experiment.search_changed(content, style, net, way)[0]
                          - code).max() > 1e-6, way.name


def test_measures_of_what_was_done(world):
    _, net, made = world
    content, style = made["walk_normal_000"][:60], made["walk_old_000"][:80]
    own = experiment.measure_rows(content, content, content, style, net, 60.0)
    assert (all(own[name] == pytest.approx(1)
                for name in ("first", "left", "excursion", "speed", "jerk")) and own["moved"] == 0
            and own["bones"] < 1e-2)
    doubled = content.copy()
    doubled[:, rows.VELOCITY] *= 2
    doubled[:, rows.POSITIONS.start + 1:rows.POSITIONS.stop:3] -= 3
    found = experiment.measure_rows(doubled, style, content, style, net, 60.0)
    assert (found["speed"] == pytest.approx(2) and found["moved"] == pytest.approx(3)
            and found["sunk"] > 2 and found["first"] < 1e-9 < found["left"])


def test_the_command(world, short, tmp_path, capsys):
    dataset, net, _ = world
    paths = [str(tmp_path / name) for name in ("motions.npz", "network.npz", "preprocess.npz",
                                               "rows.json")]
    save_dataset(paths[0], dataset)
    files.save_network(paths[1], net.params)
    files.save_preprocess(paths[2], net.normaliser)
    run = ["experiment", "code-2016", paths[0], "--network", paths[1], "--preprocess", paths[2],
           "--json", paths[3]]
    assert main([*run, "--styles", "old", "--most", "1"]) == 0
    told = json.loads((tmp_path / "rows.json").read_text())
    assert (len(told["rows"]) == len(experiment.WAYS) + 3
            and told["rows"][0]["way"] == "the content itself" and told["rows"][0]["left"] == 1)
    assert "as the code is" in capsys.readouterr().out
    assert (main([*run, "--styles", "sad"]) == 2 and "no clip of sad for learning"
            in capsys.readouterr().err)
