"""The 2016 system against numbers that its authors' code produced (run unmodified; the folder of
REFIMPL_WITNESS).

Cite Holden, Saito and Komura 2016 where these numbers are shown. Bounds are those of the stored
arrays: 4e-8 where they are float32.
"""

import numpy as np
import pytest
from scipy.ndimage import median_filter

from refimpl import nn
from refimpl.conformance.rivals import tie_to_all
from refimpl.holden2016 import files, losses, network, rows, search, train
from refimpl.holden2017.train import State
from refimpl.motion import bvh, rotation, skeleton
from refimpl.motion.foot_ik import two_bone
from refimpl.motion.mapping import map_clip
from refimpl.motion.feet import foot_contacts

F32 = 8e-8


@pytest.fixture(scope="module")
def load(witness):
    return lambda name: dict(np.load(witness / f"{name}.npz"))


def close(found, wanted, bound):
    """Within `bound` of the largest number wanted."""
    wanted = np.asarray(wanted, float)
    found = np.asarray(found, float)
    assert found.shape == wanted.shape
    assert np.abs(found - wanted).max() <= bound * np.abs(wanted).max()


def params_of(arrays):
    """The authors' arrays as `files.read_network` gives them."""
    W = {name: arrays[array].astype(float) for name, array in files.ARRAYS.items()}
    return {"We": W["We"][:, :, ::-1], "be": W["be"][:, 0], "Wd": W["Wd"][:, :, ::-1],
            "bd": W["bd"][:, 0]}


@pytest.mark.parametrize("clip", ["curve", "hop", "tiny"])
def test_the_73_numbers_of_a_clip(load, tmp_path, clip):
    w = load("1_preprocessing")
    path = tmp_path / "clip.bvh"
    path.write_bytes(bytes(w[f"{clip}_bvh"]))
    positions = rows.read_points(path)
    close(positions, w[f"{clip}_world_points"], F32)
    assert abs(rows.floor_height(positions) - w[f"{clip}_floor"]) < 1e-9
    made = rows.encode(positions)
    close(made, w[f"{clip}_rows"], 2e-10)
    close(rows.decode(w[f"{clip}_rows"]), w[f"{clip}_back"], F32)
    windows = rows.windows(w[f"{clip}_rows"])
    assert len(windows) == w[f"{clip}_window_count"]
    for window, begin in zip(windows, w[f"{clip}_window_starts"]):
        assert any(np.array_equal(row, w[f"{clip}_rows"][begin]) for row in window)
    close(windows[-1], w[f"{clip}_last_window"], F32)


def test_the_normaliser(load):
    w = load("1_preprocessing")
    windows = np.concatenate([rows.windows(w[f"{clip}_rows"]) for clip in w["normaliser_clips"]])
    found = rows.fit_normaliser(windows)
    np.testing.assert_allclose(found.mean, w["Xmean"], atol=2e-9)
    np.testing.assert_allclose(found.deviation, w["Xstd"], rtol=5e-11)


def test_the_network_and_its_gradients(load):
    w = load("2_network")
    p, X = params_of(w), w["X"].astype(float)
    Z = nn.conv1d(X, p["We"])
    close(Z, w["conv"], 2e-15)
    close(Z + p["be"][:, None], w["biased"], 2e-15)
    H = network.encode(X, p)
    close(H, w["hidden"], 3e-15)
    dX, g = network.encode_backward(w["dH"].astype(float), X, p)
    close(dX, w["dX_in"], 3e-15)
    close(g["We"][:, :, ::-1], w["dW_enc"], 3e-15)
    close(g["be"][:, None], w["db_enc"], 3e-15)
    close(nn.avg_depool1d(H), w["depooled"], 3e-15)
    close(network.decode(H, p), w["decoded"], 3e-15)
    dH, g = network.decode_backward(w["d_decoded"].astype(float), H, p)
    close(dH, w["dH_in"], 3e-15)
    close(g["Wd"][:, :, ::-1], w["dW_dec"], 3e-15)
    close(g["bd"][:, None], w["db_dec"], 3e-15)
    assert (network.autoencoder_loss(X, p) == pytest.approx(float(w["mse"] + w["sparsity"]),
                                                            rel=3e-16))
    _, g = network.autoencoder_loss_backward(1.0, X, p)
    for name, of in (("We", "dW_enc"), ("Wd", "dW_dec")):
        close(g[name][:, :, ::-1], w[f"total_{of}"], 3e-15)
    for name, of in (("be", "db_enc"), ("bd", "db_dec")):
        close(g[name][:, None], w[f"total_{of}"], 3e-15)


def test_kinks_chances_and_first_filters(load):
    w = load("2_kinks_and_noise")
    np.testing.assert_array_equal(nn.relu(w["relu_in"]), w["relu_out"])
    theirs = np.where(w["relu_in"] >= 0, 1, 0)                   # a named rival: relu'(0) = 1
    np.testing.assert_array_equal(theirs, w["relu_gradient"])
    differs = nn.relu_backward(np.ones_like(w["relu_in"]), w["relu_in"]) != w["relu_gradient"]
    np.testing.assert_array_equal(differs, w["relu_in"] == 0)
    np.testing.assert_array_equal(nn.max_pool1d(w["pool_in"]), w["pool_out"])
    # the other rival
    np.testing.assert_array_equal(tie_to_all(w["pool_upstream"], w["pool_in"]), w["pool_gradient"])
    kept = np.ones((1, 2, 3), np.int8)
    np.testing.assert_allclose(sorted({0.0, float(network.drop(np.ones(1), kept[0, 0, :1])[0])}),
                               sorted(w["dropout_values"]))
    for draw in w["depool_draws"]:
        chosen = (draw[None, :, 1::2] != 0).astype(np.int8)
        np.testing.assert_array_equal(nn.random_depool1d(w["depool_in"], chosen)[0], draw)
    for name in (n for n in w if n.startswith("init_")):
        out, into, width = map(int, name.split("_")[1:])
        bound, largest, deviation = w[name]
        found = network.uniform_filters(np.random.default_rng(0), out, into, width, float)
        assert np.sqrt(6 / ((out + into) * width)) == pytest.approx(bound, rel=1e-12)
        assert np.abs(found).max() <= bound and largest <= bound
        assert found.std() == pytest.approx(deviation, rel=0.02)


def test_the_losses_and_their_gradients(load):
    w = load("3_losses")
    V, labels, wanted = (w[name].astype(float) for name in ("V", "labels", "traj"))
    half = np.full(2, 0.5)
    for name, loss, backward, more in (
            ("foot", losses.foot_loss, losses.foot_loss_backward, (labels,)),
            ("floor", losses.foot_loss, losses.foot_loss_backward, (0 * labels,)),
            ("bones", losses.bone_loss, losses.bone_loss_backward, ()),
            ("trajectory", losses.trajectory_loss, losses.trajectory_loss_backward, (wanted,)),
            ("all", losses.constraint_loss, losses.constraint_loss_backward, (labels, wanted))):
        close(loss(V, *more).mean(), w[name], 6e-16)
        close(backward(half, V, *more), w[f"d_{name}"], 6e-16)
    H = w["H"].astype(float)
    content = w["H_content"].astype(float)
    close(nn.gram(w["H_style"].astype(float)), w["gram_style"], 4e-16)
    close(nn.gram(H), w["gram_H"], 4e-16)
    for name, amount in (("search_01", 0.1), ("search_0003", 0.003)):
        close(losses.search_loss(H, content, w["gram_style"], amount=amount)[0], w[name], 6e-16)
        close(losses.search_loss_backward(np.ones(1), H, content, w["gram_style"], amount=amount),
              w[f"d_{name}"], 6e-16)
    s = losses.search_loss(H, content, w["gram_style"], amount=1e300)[0]
    close(s, w["style"], 6e-16)
    close(losses.search_loss(H, content, w["gram_style"], amount=0.0)[0], w["content"], 6e-16)


def test_both_forms_of_adam(load):
    w = load("4_adam")
    params, state = {"p": w["p0"].astype(float)}, nn.adam_start({"p": w["p0"].astype(float)})
    for gradient, after in zip(w["gradients"].astype(float), w["p_after"][1:]):
        params, state = nn.adam_step(params, {"p": gradient}, state, rate=float(w["rate"]),
                                     epsilon=float(w["eps_trainer"]))
        np.testing.assert_allclose(params["p"], after, rtol=0, atol=1e-16)
    assert (train.RATE == 1e-5 and float(w["eps_constrain"]) == search.EPSILON
            and float(w["rate_constrain"]) == search.RATE)
    A, B, H = (w[name].astype(float) for name in ("A", "B", "H_after"))
    # its cost is the sum of A (H - B)^2
    for steps in range(6):
        found = search.minimise(H[0], None, lambda h: 2 * A * (h - B), steps)
        close(found, H[steps], 1e-15)


def test_the_trainer(load):
    w = load("4_training")
    params, X = params_of(w), w["X"].astype(float)
    for name in ("before", "after"):
        costs = [float(network.autoencoder_loss(x[None], params)) for x in X]
        np.testing.assert_allclose(costs, w[f"cost_{name}"], rtol=2e-14)
        if name == "before":
            state = State(params, nn.adam_start(params), 0)
            for _, state in train.train(X, epochs=int(w["epochs"]), rate=float(w["rate"]),
                                        chance=False, shuffle=False, state=state):
                pass
            params = state.params
    for name, array in files.ARRAYS.items():
        found = params[name][:, :, ::-1] if name in ("We", "Wd") else params[name][:, None]
        close(found, w[f"after_{array}"], 5e-14)


def test_the_whole_style_transfer(load):
    """250 + 100 iterations: every printed cost, and the result to 2e-9."""
    w = load("5_style_transfer")
    normaliser = rows.Normaliser(w["Xmean"].astype(float).ravel(), w["Xstd"].astype(float).ravel())
    content = search.join(w["content_windows"].astype(float))
    close(content.T[None], w["content"], 0)
    bound = np.sqrt(6 / (73 + 480))
    assert (w["noise"].shape == search.noise(np.random.default_rng(0), 480).shape
            and 0.99 * bound < np.abs(w["noise"]).max() <= bound)
    costs = {"style": [], "constraints": []}
    p = params_of(w)
    close(network.encode(w["noise"].astype(float), p), w["hidden_noise"], F32)
    found = search.transfer(content, w["style_window"][0].astype(float), p, normaliser,
                            start=w["noise"].astype(float), amount=float(w["style_amount"]),
                            watch=lambda name, iteration, cost: costs[name].append(cost))
    for name, printed in costs.items():
        np.testing.assert_allclose(printed, w[f"cost_{name}"], rtol=0, atol=5.1e-7)
    close(found.after_style.T[None], w["after_style"], F32)
    close(found.before_tail.T[None], w["before_root"], F32)
    close(found.result.T[None], w["result"], 2e-9)


def named_points(w, clip, tmp_path):
    """All 31 joints of a clip in the world at 60 frames a second, and their names."""
    path = tmp_path / "clip.bvh"
    path.write_bytes(bytes(w[f"{clip}_bvh"]))
    read = bvh.read_bvh(path)
    rotations, translations = (part[::2] for part in skeleton.local_pose(read))
    return (read, rotations, translations,
            skeleton.forward_kinematics(read.parents, rotations, translations)[1])


def feet_of(names):
    return [list(names).index(name) for name in ("LeftFoot", "LeftToeBase", "RightFoot",
                                                 "RightToeBase")]


def test_forward_kinematics_of_the_later_code(load, tmp_path):
    first, w = load("1_preprocessing"), load("6_later_code")
    read, rotations, translations, points = named_points(first, str(w["clip"]), tmp_path)
    np.testing.assert_array_equal(read.parents, w["parents"])
    np.testing.assert_array_equal([joint.name for joint in read.joints], w["names"])
    close(points, w["global_positions"], 2e-7)
    close(points, load("7_deep_motion_editing")["global_positions"], 2e-6)
    # every eighth frame of the file's 120 a second
    eighth = w["quaternions"].astype(float)
    theirs = rotation.quaternion_to_matrix(eighth)
    np.testing.assert_allclose(theirs, skeleton.local_pose(read)[0][::8][:len(theirs)], atol=3e-7)
    close(skeleton.forward_kinematics(w["parents"], theirs, translations[::4][:len(theirs)])[1],
          w["global_positions"][::4][:len(theirs)], 2e-6)


def test_contact_rules_of_the_later_code(load, tmp_path):
    """Each rule gives the recorded labels; this package's own, on the same points, agrees with most
    of them.
    """
    first, w, other = load("1_preprocessing"), load("6_later_code"), load("7_deep_motion_editing")
    read, _, _, points = named_points(first, str(w["clip"]), tmp_path)
    feet = feet_of(w["names"])
    step2 = np.sum(np.diff(points[:, feet], axis=0) ** 2, axis=-1)
    pfnn = step2 < 0.02                                          # PFNN: no height
    np.testing.assert_array_equal(pfnn, w["contacts_pfnn"])
    toes = points[:, [feet[1], feet[3]]] * 0.055                 # metres
    velocity = np.empty_like(toes)
    velocity[1:-1] = 0.5 * (toes[2:] - toes[:-2]) * 60
    velocity[0], velocity[-1] = (velocity[1] - (velocity[3] - velocity[2]),
                                 velocity[-2] + (velocity[-2] - velocity[-3]))
    slow = np.linalg.norm(velocity, axis=-1) < 0.15
    matching = np.stack([median_filter(foot.astype(np.uint8), size=6, mode="nearest")
                         for foot in slow.T], axis=1).astype(bool)
    np.testing.assert_array_equal(matching[1:-1], w["contacts_motion_matching"][1:-1])
    # deep-motion-editing: the first row doubled, label t covers t - 1 to t
    labels = np.concatenate([step2[:1] < 0.05, step2 < 0.05])
    np.testing.assert_array_equal(labels, other["contacts"])
    mapped = map_clip(read).positions(
        *skeleton.forward_kinematics(read.parents, *(p[::2] for p in skeleton.local_pose(read))))
    ours = foot_contacts(mapped)
    assert (np.mean(ours[:-1] == pfnn) > 0.85
            and np.mean(ours[:, [1, 3]] == w["contacts_motion_matching"]) > 0.85)


def test_two_bone_ik_of_the_later_code(load):
    w = {name: array.astype(float) for name, array in load("6_two_bone").items()}
    hip, knee, ankle = w["hip"], w["knee"], w["ankle"]
    thigh, shin = np.linalg.norm(knee - hip, axis=1), np.linalg.norm(ankle - knee, axis=1)
    goal = w["target"] - hip
    # their legs stay shorter than their bones
    reach = thigh + shin - w["max_length_buffer"][:, 0]
    size = np.linalg.norm(goal, axis=1)
    goal = hip + goal * (np.minimum(size, reach) / size)[:, None]
    # the knee's side turns with the leg, as in `foot_ik.lock_feet`
    turned = rotation.shortest_rotation(ankle - hip, goal - hip) @ w["forward"][:, :, None]
    found = two_bone(hip, goal, thigh, shin, turned[..., 0])
    close(goal, w["ankle_after"], 3e-6)
    close(found, w["knee_after"], 3e-6)
