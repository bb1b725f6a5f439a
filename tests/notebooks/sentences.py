"""What the notebooks say of their results, and what must then hold.

NOTEBOOK: [(a sentence, or a part of one, that stands in its text, an expression of Python that is
true at the end of Run All, on embedded and on recorded motion)]. `made_up` is True where motion is
embedded.
"""

from . import sentences_10_18

SENTENCES = {
    "00": [
        ("the residual shrinks by the factor $1 - 2\\eta = 0.8$ in every step",
         "np.allclose(places[5] - q[0], 0.8 ** 5 * (places[0] - q[0]))"),
        ("in the style of the middle one",
         "walk['projected'] < 0.2 * walk['content']"),
        ("on very nearly its own path",
         "np.linalg.norm((result.positions[:180, 0] - takes[unseen].positions[:180, 0])[:, [0, 2]],"
         " axis=1).mean() < 30"),
        ("says little about style",
         "np.abs(normal.positions[0] - old.positions[0]).max() > 10"),
        ("and the same walk comes out in the manner of an old man", "walk['projected'] > 0"),
    ],
    "01": [
        ("a joint is then only some 4 cm off on average",
         "not made_up or 2 < np.linalg.norm(right - wrong, axis=2).mean() < 6"),
        ("it shrinks a bone across the axis to $\\cos 45° = 71\\,\\%$",
         "np.isclose(np.linalg.norm(shrunk[30][:, 0]), np.cos(np.pi / 4))"),
        ("one along the axis keeps its length",
         "np.allclose(np.linalg.norm(shrunk[:, :, 1], axis=1), 1)"),
        ("I + \\sin\\theta\\, K + (1 - \\cos\\theta)\\, K^2$, which is $R_z(\\theta)$",
         "np.allclose(rotation.axis_rotation('Z', 0.7), np.eye(3) + np.sin(0.7) * (K := np.array("
         "[[0, -1, 0], [1, 0, 0], [0, 0, 0.0]])) + (1 - np.cos(0.7)) * K @ K)"),
        ("$\\operatorname{tr} R = 1 + 2 \\cos\\theta$",
         "np.isclose(np.trace(rotation.axis_rotation('X', 0.7)), 1 + 2 * np.cos(0.7))"),
        ("Slerp goes *straight* from frame to frame and turns a corner at each",
         "jerk(by_turns, range(21)) > 2 * jerk(by_curve, range(21))"),
        ("What is read again is equal to the last bit", "same"),
        ("all bones keep their lengths",
         "not made_up or np.allclose(bone_lengths(right), bone_lengths(wrong), atol=1e-6)"),
        ("Your forward kinematics against it", "np.abs(made_by_package - P).max() < 1e-9"),
    ],
    "02": [
        ("The 66 numbers do not notice", "np.abs(Y - X).max() < 1e-8"),
        ("Most of the sway of the hips, which has the rhythm of the strides, stays in the path",
         "0.7 < np.std(root - (s := lambda a: np.apply_along_axis(lambda c: np.convolve(np.pad(c,"
         " 30, 'edge'), np.ones(61) / 61, 'valid'), 0, a))(root)) / np.std(hips[:, [0, 2]]"
         " - s(hips[:, [0, 2]])) < 1.1"),
        ("In the round trip nothing is lost but rounding",
         "np.abs(decode_walk(encode_walk(P), start) - P).max() < 1e-8"),
        ("seen from frame $t + 1$: first the turn, then the step",
         "np.allclose(X[100, FORWARD], f66.facing(P)[101] @ (f66.root_path(P)[101]"
         " - f66.root_path(P)[100]))"),
        ("The strong ones are strides, feet and hands forward and back",
         "{SLOTS[i // 3][-4:] for i in np.argsort(X[:, POSITIONS].std(axis=0))[-6:]}"
         " <= {'Foot', 'tToe', 'Hand', 'nger', 'tLeg'}"),
        ("hands and feet dominate, as they do to the eye",
         "{SLOTS[i // 3][-4:] for i in np.argsort(size)[-4:]} <= {'Foot', 'tToe', 'Hand', 'nger'}"),
        ("each single frame looks perfect; after four seconds the figure is somewhere else",
         "np.linalg.norm((decode_walk(X, start) - decode_walk(turned, start))[-1, 0]) > 10"),
        ("a padded figure stands still", "not padded[:75, VELOCITIES].any()"),
    ],
    "03": [
        ("The taps come out **reversed**",
         "conv1d(impulse, np.array([[[1.0, 2, 3, 4, 5]]]), np.zeros(1))[0, 0, 2:7].tolist()"
         " == [5, 4, 3, 2, 1]"),
        ("smoothing has flattened the steps",
         "np.ptp(smooth[0, foot]) < 0.95 * np.ptp(X[0, foot])"),
        ("the velocity of the root, which is nearly constant, came through",
         "np.isclose(smooth[0, FORWARD].mean(), X[0, FORWARD].mean(), rtol=0.02)"),
        ("ask a single 25-tap filter", "losses[-1] < 0.5 * np.mean((noisy - clean) ** 2)"),
        ("Nobody tells it what smoothing is", "8 <= np.argmax(filters[0, 0]) <= 16"),
        ("The other two answers can undo a filter", "off[-1] < 0.5 * still_blurred"),
        ("So $\\mathrm{d}x = A^{\\mathsf T} \\mathrm{d}y$", "np.allclose(transposed, A.T)"),
    ],
    "04": [
        ("Relu makes zeros, zeros make ties: about half of all windows",
         "0.35 < ties(nn.relu(z_first)) < 0.7"),
        ("gives the same numbers as the other one", "np.array_equal(inner, outer)"),
        ("At 0 the chord says ½ for every $h$",
         "all((nn.relu(np.array(s)) - nn.relu(np.array(-s))) / (2 * s) == 0.5 for s in steps)"),
        ("It learns on the first four seconds and is judged on the next four",
         "np.mean((guess > 0.5) == truth) > always + 0.2"),
        ("$\\langle \\text{average}(x), h \\rangle = \\langle x, \\Psi^\\dagger(h) \\rangle$",
         "np.isclose(np.sum(nn.avg_pool1d(ones := np.ones((1, 1, 4))) * 3), np.sum(ones *"
         " avg_depool(3 * np.ones((1, 1, 2)))))"),
    ],
    "05": [
        ("All four pass with ones",
         "all(np.abs(back(np.ones(fn(at).shape), at) - differences(fn, at, np.ones(fn(at).shape),"
         " 1e-6)).max() < 1e-6 for fn, back, at in wrong.values())"),
        ("their best is 8 and 11 digits",
         "1e-11 < best['forward'] < 1e-7 and 1e-14 < best['central'] < 1e-9"),
        ("or $10^{-4}$ of its size", "5e-5 < 0.01 / np.sqrt(15840) < 2e-4"),
        ("First your verdict on what you mended, and on the suspects",
         "verdict(nn.gram, gram_backward, x) and not verdict(nn.gram, suspect_gram_backward, x)"),
        ("and yet the loss falls and the walk changes",
         "loss(motion['O']).item() < 0.5 * loss(I).item()"),
        ("measuring each would take 31,680 evaluations", "2 * I.size == 31680"),
    ],
    "06": [
        ("Nothing, beyond rounding: the sum over $t$ does not care for order",
         "np.abs(nn.gram(shuffled) - G).max() < 1e-12 * np.abs(G).max()"),
        ("Two stretches of one walk look alike",
         "np.linalg.norm((g := [nn.gram(x)[0] / x.shape[2] for x in grams.values()])[0] - g[1])"
         " < 0.5 * np.linalg.norm(g[0] - g[2])"),
        ("On the diagonal stands a row's energy",
         "np.allclose(np.diagonal(G[0]), np.sum(X_C[0] ** 2, axis=1))"),
        ("With the recorded clips it does: the head goes some nine tenths of the way",
         "made_up or 0.75 < ((h := lambda m: normaliser.undo(m[0].T)[:, row].mean())(moved)"
         " - h(X_C)) / (h(X_S) - h(X_C)) < 1.05"),
        ("With the embedded walkers it goes a tenth of the way",
         "not made_up or 0.05 < ((h := lambda m: normaliser.undo(m[0].T)[:, row].mean())(moved)"
         " - h(X_C)) / (h(X_S) - h(X_C)) < 0.2"),
        ("the walk nearly stops",
         "not made_up or normaliser.undo(moved[0].T)[:, FORWARD].mean()"
         " < 0.3 * normaliser.undo(X_C[0].T)[:, FORWARD].mean()"),
        ("the content alone decides, and nothing moves",
         "np.linalg.norm(ends[-1] - X_C) < 0.02 * np.linalg.norm(moved - X_C)"),
        ("For $\\mathrm{d}E = 1$ the gradient has length 1 however small the error is",
         "np.isclose(np.linalg.norm(norm_backward(one, 1e-9 * X_C)), 1)"),
    ],
    "07": [
        ("what is left is of second order in the turn of one frame",
         "np.abs(losses.foot_velocities(numbers.T[None])).mean()"
         " < 0.5 * np.abs(losses.foot_velocities(from_before.T[None])).mean()"),
        ("In the walk they are close to 0", "measure(X)[0] < 0.7 * measure(D)[0]"),
        ("Each term heals its own wound",
         "measure(healed['bones'])[1] < 0.05 * measure(D)[1] and measure(healed['feet'])[0]"
         " < 0.5 * measure(D)[0] and measure(healed['trajectory'])[2] < 0.3 * measure(D)[2]"),
        ("feet that hold also pull the root part of the way back",
         "0.2 * measure(D)[2] < measure(healed['feet'])[2] < 0.95 * measure(D)[2]"),
        ("Within a few of them the bones have their lengths again", "errors[10] < 0.2 * errors[0]"),
        ("is between three and four orders of magnitude below that of the translation",
         "1e3 < (r := lambda g: np.sqrt(np.mean((trajectory_backward(one, D, wanted, 1.0)"
         " * deviation)[:, g] ** 2)))(TRANSLATION) / r(slice(TURN, TURN + 1)) < 2e4"),
        ("The mean has no effect on the gradient itself",
         "np.allclose(constraints_backward(one, O), (foot_backward(one, O * deviation + mean,"
         " contacts, 0.0) + bone_backward(one, O * deviation + mean, lengths)"
         " + trajectory_backward(one, O * deviation + mean, wanted, 1e4)) * deviation)"),
    ],
    "08": [
        ("gradients of 1 move a number by $3.2\\,\\eta$ in the first step and by $6.6\\,\\eta$ in"
         " the twelfth",
         "np.allclose([(1 - 0.9 ** k) / np.sqrt(1 - 0.999 ** k) for k in (1, 12)], [3.16, 6.57],"
         " atol=0.01)"),
        ("$\\sqrt{1 - \\beta_2} = 0.03$", "np.isclose(np.sqrt(1 - 0.999), 0.0316, atol=1e-3)"),
        ("Its first steps overshoot", "max(runs['Adam, one rate'][1][:20]) > 1.2 * loss(D)"),
        ("The falling rate then brings it to rest",
         "runs['Adam, one rate'][1][-1] < 0.01 * loss(D)"),
        ("There, descent needed a rate of $10^{-1}$ for centimetres and $10^{-5}$ for radians",
         "runs['descent, the rate of a radian'][1][-1] > 0.9 * loss(D)"),
        ("gradients of $10^{-7}$ show which",
         "abs(epsilon_hat_step(zero, 1e-7 * one, zero, zero, 1, 1.0, 0.9, 0.999, 1e-8)[0][0])"
         " < 0.8 * abs(adam_step(zero, 1e-7 * one, zero, zero, 1, 1.0, 0.9, 0.999, 1e-8)[0][0])"),
    ],
    "09": [
        ("it is not idempotent",
         "np.linalg.norm(once - twice) > 0.1 * np.linalg.norm(motion - once)"),
        ("a search over $H$ finds answers that are nearer to $X$ than $P(X)$ is",
         "np.linalg.norm(motion - R_found) < 0.9 * np.linalg.norm(motion - once)"),
        ("First equation 3 as it stands, by your two gradients alone", "seen[-1] < 0.2 * seen[0]"),
        ("several times the walk's, and several times more again if learnt with halves",
         "not made_up or 2 < (j := lambda p: jerk(decode(projected(features, p)), range(JOINTS))"
         " / jerk(decode(features), range(JOINTS)))(params) < 0.5 * j(halves)"),
        ("Projection mends because the network cannot say what it has not seen",
         "np.mean((projected(spoilt, params) - features)[:, POSITIONS] ** 2)"
         " < 0.5 * np.mean((spoilt - features)[:, POSITIONS] ** 2)"),
        ("After so short a training they still look like the noise that they began as",
         "abs(np.corrcoef(params['W0'][strongest][:, :, 1:].ravel(), params['W0'][strongest][:, :,"
         " :-1].ravel())[0, 1]) < 0.5"),
        ("128 numbers a frame, and the motion has 66", "256 / 2 > 66"),
    ],
}

SENTENCES |= sentences_10_18.SENTENCES
