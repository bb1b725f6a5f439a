"""The door for the authors' files, on made pairs of the same shape: read, refused, used for
encoding, projection, search, and as a loss network of 2017.
"""

from dataclasses import replace
import io
import zipfile

import numpy as np
import pytest

from refimpl import nn
from refimpl.holden2016 import bridge, files, losses, network, rows, search
from refimpl.fast import networks as fast
from refimpl.holden2017 import networks
from refimpl.holden2017.trained import Manifold, Style
from refimpl.styles.files import load_style, save_style
from refimpl.fast.stylist import Stylist
from refimpl.holden2017.objective import Batch, motion_losses, motion_losses_backward
from refimpl.motion import features as F
from refimpl.embedded.walkers import make_clip
from refimpl.motion.body import make_take
from refimpl.storage import FormatError


@pytest.fixture(scope="module")
def takes():
    return [make_take(make_clip("walk", name, seconds=3.0).clip) for name in ("normal", "zombie")]


@pytest.fixture(scope="module")
def made(takes):
    """A network of 2016 of no training on the code's scale."""
    windows = np.concatenate(
        [rows.windows(rows.encode(t.positions * (17.0 / bridge.standing_hips(t.positions))))
         for t in takes])
    return bridge.Network(network.init_network(np.random.default_rng(0), hidden=6, width=5),
                          rows.fit_normaliser(windows))


@pytest.fixture
def pair(made, tmp_path):
    paths = tmp_path / "network_core.npz", tmp_path / "preprocess_core.npz"
    files.save_network(paths[0], made.params)
    files.save_preprocess(paths[1], made.normaliser)
    return paths


def test_a_pair_of_files_comes_back_to_the_last_bit(made, pair):
    found = bridge.read(*pair)
    for name, array in made.params.items():
        np.testing.assert_array_equal(found.params[name], array)
    np.testing.assert_array_equal(found.normaliser.mean, made.normaliser.mean)
    np.testing.assert_array_equal(found.normaliser.deviation, made.normaliser.deviation)
    # as the authors' code has them: reversed, biases as columns
    with np.load(pair[0]) as stored:
        assert ({name: stored[name].shape for name in stored}
                == {"L000_L001_W": (6, 73, 5), "L000_L002_b": (6, 1), "L001_L002_W": (73, 6, 5),
                    "L001_L003_b": (73, 1)})
        np.testing.assert_array_equal(stored["L000_L001_W"][:, :, ::-1], made.params["We"])


def test_other_arrays_are_left_unread_and_nothing_is_unpickled(made, pair, tmp_path):
    with np.load(pair[0]) as stored:
        arrays = dict(stored)
    more = tmp_path / "more.npz"
    np.savez(more, note=np.array([{"a": 1}], dtype=object), **arrays)
    np.testing.assert_array_equal(files.read_network(more)["We"], made.params["We"])
    spoilt = tmp_path / "spoilt.npz"
    np.savez(spoilt, **{**arrays, "L000_L001_W": np.array([print], dtype=object)})
    with pytest.raises(FormatError, match="spoilt.npz"):
        files.read_network(spoilt)


def test_a_member_that_grows_is_refused(pair, tmp_path):
    """A zip of a kilobyte that would be gigabytes, and one whose size in the directory lies."""
    bomb = tmp_path / "bomb.npz"
    header = io.BytesIO()
    np.lib.format.write_array_header_1_0(header,
                                         {"descr": "<f4", "fortran_order": False,
                                          "shape": (1 << 28,)})
    with zipfile.ZipFile(bomb, "w", zipfile.ZIP_DEFLATED) as archive:
        with archive.open("Xmean.npy", "w") as member:
            member.write(header.getvalue())
            for _ in range(160):
                member.write(bytes(1 << 20))
        archive.writestr("Xstd.npy", b"")
    with pytest.raises(FormatError, match="no plain .npy array"):
        files.read_preprocess(bomb)


@pytest.mark.parametrize("change, words", [
    ({"L000_L001_W": lambda W: W[:, :66]}, r"found L000_L001_W of shape \(6, 66, 5\)"),
    ({"L000_L001_W": lambda W: W[:, :, :4], "L001_L002_W": lambda W: W[:, :, :4]}, "an odd width"),
    ({"L001_L002_W": lambda W: W.swapaxes(0, 1)}, "the other way round"),
    ({"L000_L002_b": lambda b: b[:3]}, r"found L000_L002_b of shape \(3, 1\)"),
    ({"L001_L003_b": lambda b: np.tile(b, 2)}, r"found L001_L003_b of shape \(73, 2\)"),
    ({"L001_L003_b": lambda b: b * np.nan}, "not finite"),
    ({"L000_L001_W": lambda W: W.astype(complex)}, "needed a network like"),
    ({"L000_L001_W": lambda W: (W * 100).astype(int)}, "found L000_L001_W of int64"),
    ({"L001_L003_b": None}, "found no L001_L003_b")])
def test_what_is_wrong_with_a_network_is_named(pair, tmp_path, change, words):
    with np.load(pair[0]) as stored:
        arrays = {name: change.get(name, lambda a: a)
                  and change.get(name, lambda a: a)(stored[name]) for name in stored}
    path = tmp_path / "wrong.npz"
    np.savez_compressed(path,
                        **{name: array for name, array in arrays.items() if array is not None})
    with pytest.raises(FormatError, match=words) as error:
        files.read_network(path)
    assert "wrong.npz" in str(error.value)


@pytest.mark.parametrize("change, words", [
    ({"Xmean": lambda a: a[:, :66]}, "needed 73 numbers"), ({"Xstd": lambda a: -a}, "not above 0"),
    ({"Xstd": lambda a: 0 * a}, "not above 0"),
    ({"Xmean": lambda a: 0 * a}, "needed some 17"), ({"Xmean": lambda a: 5 * a}, "in its own unit"),
    ({"Xmean": lambda a: a + 5}, "reference joint")])
def test_a_normaliser_without_a_body_is_refused(pair, tmp_path, change, words):
    with np.load(pair[1]) as stored:
        arrays = {name: change.get(name, lambda a: a)(stored[name]) for name in stored}
    path = tmp_path / "wrong.npz"
    np.savez(path, **arrays)
    with pytest.raises(FormatError, match=words):
        bridge.read(pair[0], path)


def test_the_66_numbers_meet_the_73(takes):
    """The same clip by both roads, where they are the same: all but facing, floor and contacts."""
    take = takes[0]
    theirs = rows.encode(take.positions)
    ours = bridge.to_rows(F.encode(take.positions, take.start.floor)[0], take.contacts)[:-1]
    lift = rows.floor_height(take.positions) - take.start.floor
    heights = range(rows.POSITIONS.start + 1, rows.POSITIONS.stop, 3)
    ours[:, heights] -= lift
    assert np.abs(ours - theirs)[:, :rows.CONTACTS.start].max() < 2e-3 * take.leg
    assert (ours[:, rows.REFERENCE] == 0).all()
    np.testing.assert_array_equal(bridge.to_features(bridge.to_rows(take.features)), take.features)
    np.testing.assert_array_equal(bridge.to_rows(take.features)[:, rows.CONTACTS], 0.5)
    np.testing.assert_array_equal(losses.as_66(bridge.to_rows(take.features).T[None])[0].T,
                                  take.features)


def test_bodies_come_to_the_networks_size(takes, made):
    take = takes[0]
    size = bridge.unit_of(take.positions)
    assert bridge.standing_hips(take.positions * size) == pytest.approx(17.0)
    # by the hips or by the leg, the same size
    assert size * take.leg == pytest.approx(made.leg, rel=0.03)
    np.testing.assert_allclose(made.features_of(take)[:, F.FORWARD],
                               take.features[:, F.FORWARD] * size)
    assert made.rows_of(take).shape == (len(take.features) - 1, 73)
    for factor in (0.01, 1.0, 39.0):                             # whatever the unit
        assert (bridge.standing_hips(take.positions * factor)
                == pytest.approx(factor * bridge.standing_hips(take.positions)))
    crouched = take.positions.copy()
    crouched[:, :, 1] *= 0.8
    assert bridge.standing_hips(crouched) < bridge.standing_hips(take.positions)
    assert (made.bones.shape == (20,) and (made.bones > 0).all()
            and made.bones[[1, 2, 5, 6]].sum() / 2 == pytest.approx(made.leg))


def test_as_a_loss_network_of_2017_it_says_the_same(made, takes):
    """Encoded, decoded and projected on the 66 numbers as on the 73 with contacts at their mean;
    fast and plain.
    """
    manifold = made.manifold()
    features = F.scale(takes[0].features, made.leg / takes[0].leg)[:60]
    X = manifold.network_input(features)
    np.testing.assert_allclose(networks.encode(X, manifold.params), made.encode(features),
                               atol=1e-12)
    H = made.encode(features)
    np.testing.assert_allclose(manifold.motion(networks.decode(H, manifold.params)), made.decode(H),
                               atol=1e-10)
    for odd in (60, 59):
        for P in (networks.project, fast.project):
            np.testing.assert_allclose(manifold.motion(P(X[:, :, :odd], manifold.params)),
                                       made.project(features[:odd]), atol=1e-10)
    planted = made.encode(features, takes[0].contacts[:60])
    assert np.abs(planted - H).max() > 1e-3                      # contacts that are given are heard


def test_the_untied_decoder_has_its_gradient(made):
    manifold, rng = made.manifold(), np.random.default_rng(1)
    p = manifold.params
    H, dX = rng.random((2, 6, 4)), rng.standard_normal((2, 66, 8))

    def backward(d, H, V0, c0):
        dH, g = networks.decode_backward(d, H, {**p, "V0": V0, "c0": c0})
        return dH, g["V0"], g["c0"]
    nn.check_gradient(lambda H, V0, c0: networks.decode(H, {**p, "V0": V0, "c0": c0}), backward, H,
                      p["V0"], p["c0"], names=["H", "V0", "c0"])
    np.testing.assert_allclose(networks.decode_backward_to_input(dX, H, p),
                               networks.decode_backward(dX, H, p)[0], atol=1e-12)


def test_a_style_trained_on_it_goes_to_disk_and_back(made, takes, tmp_path):
    manifold = made.manifold()
    style = Style(networks.init_transformation_network(np.random.default_rng(0), channels=4,
                                                       width=5, dtype=float), manifold, "zombie",
                  {"walk": "walk"})
    path = tmp_path / "style.npz"
    save_style(path, style)
    again = load_style(path)
    X = manifold.network_input(F.scale(takes[0].features, made.leg / takes[0].leg))
    results = [fast.project(fast.transformation(X, s.params), s.manifold.params)
               for s in (again, style)]
    np.testing.assert_array_equal(*results)
    np.testing.assert_allclose(fast.project(fast.transformation(X, style.params), manifold.params),
                               networks.project(networks.transformation(X, style.params),
                                                manifold.params), atol=1e-10)
    with pytest.raises(FormatError, match="a decoder that does not fit"):
        save_style(path, replace(style,
                                 manifold=replace(manifold,
                                                  params={**manifold.params, "c0": np.zeros(3)})))
        load_style(path)
    O = X[:, :, :40]
    H = networks.encode(O, manifold.params)
    target = Batch(O, nn.gram(H) * 0.5, takes[0].contacts[:40].T[None].astype(float),
                   manifold.bones, np.zeros((1, 3, 40)), H * 0.5)
    nn.check_gradient(lambda O: sum(motion_losses(O, target, manifold.params,
                                                  manifold.normaliser.mean,
                                                  manifold.normaliser.deviation).values()),
                      lambda d, O: motion_losses_backward(d, O, target, manifold.params,
                                                          manifold.normaliser.mean,
                                                          manifold.normaliser.deviation), O,
                      names=["O"])


def test_a_tied_manifold_has_no_decoder_of_its_own(made):
    tied = {name: made.manifold().params[name] for name in ("W0", "b0")}
    X = np.random.default_rng(2).standard_normal((1, 66, 12))
    np.testing.assert_allclose(Stylist(None, tied).project(X), networks.project(X, tied),
                               atol=1e-12)
    assert isinstance(Manifold(tied, made.manifold().normaliser, 1.0, made.bones), Manifold)


def test_the_codes_search_brings_a_take_back_on_its_own_skeleton(takes, made):
    content, style = takes
    seen = []
    result = bridge.transfer(content, style.positions, made, clean=False, iterations=4,
                             constraint_iterations=2, watch=lambda *a: seen.append(a[:2]))
    assert seen == [("style", i) for i in range(4)] + [("constraints", i) for i in range(2)]
    assert (result.positions.shape == content.positions.shape
            and [j.name for j in result.clip.joints] == [j.name for j in content.clip.joints])
    other = bridge.transfer(content, style.positions * 0.01, made, clean=False, iterations=4,
                            constraint_iterations=2)
    # the style's unit does not matter
    np.testing.assert_allclose(other.positions, result.positions, atol=1e-6)
    with pytest.raises(ValueError, match="style: found 20 rows, needed more than 30"):
        bridge.transfer(content, style.positions[:21], made)
    with pytest.raises(ValueError, match="content: found shape"):
        search.transfer(np.zeros((7, 73)), np.zeros((8, 73)), made.params, made.normaliser,
                        start=np.zeros((1, 73, 7)))


def test_a_network_that_passes_motion_through_gives_the_content_back(takes, made):
    """Two filters of one tap for each number, one up and one down: with no iterations and noise
    that is the content, the result is the content.
    """
    content = takes[0]
    We = np.zeros((146, 73, 3))
    We[np.arange(73), np.arange(73), 1], We[np.arange(73) + 73, np.arange(73), 1] = 1.0, -1.0
    Wd = np.swapaxes(We, 0, 1) * 2                               # the depooling halves
    through = bridge.Network({"We": We, "be": np.zeros(146), "Wd": Wd, "bd": np.zeros(73)},
                             made.normaliser)
    size = bridge.unit_of(content.positions)
    made_rows = rows.encode(content.positions * size)[:120]
    # pairs of equal frames: pooling loses nothing
    slow = np.repeat(made_rows[::2], 2, axis=0)
    start = through.normaliser.apply(slow)[None]
    found = search.transfer(slow, slow, through.params, through.normaliser, start=start,
                            iterations=0, constraint_iterations=0)
    np.testing.assert_allclose(found.result, slow, atol=1e-9)
