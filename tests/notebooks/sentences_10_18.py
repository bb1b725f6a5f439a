"""What notebooks 10 to 18 say of their results, and what must then hold.

NOTEBOOK: [(a sentence, or a part of one, that stands in its text, an expression of Python that is
true at the end of Run All, on embedded and on recorded motion)]
"""

SENTENCES = {
    "10": [
        ("so $\\mathrm{d}H = \\frac{2}{4} (5, 10)^{\\mathsf T} + "
         "\\frac{1}{2} (1, 2)^{\\mathsf T} = (3, 6)^{\\mathsf T}$",
         "np.allclose(own.hidden_loss_backward(np.ones(1), np.array([[[1.0], [2.0]]]),"
         " np.zeros((1, 2, 1)), np.zeros((1, 2, 2)), style=0.5)[0, :, 0], [3, 6])"),
        ("A larger $s$ ends nearer to the style and farther from the content",
         "(np.diff([curve[-1, 0] for curve in curves.values()]) < 0).all()"
         " and (np.diff([curve[-1, 1] for curve in curves.values()]) > 0).all()"),
        ("from 0.001 to 0.01 hardly anything is left to gain",
         "curves[1e-2][-1, 0] > 0.95 * curves[1e-3][-1, 0]"),
        ("average-depooling gave both frames of a pair $\\frac12 H$",
         "np.allclose(nn.avg_depool1d(H2), np.repeat(H2, 2, axis=2) / 2)"),
        ("then 150 steps bring feet, bones and path in order",
         "facts(moved)[1] < facts(free)[1] / 3 and facts(moved)[2] < facts(free)[2] / 10"),
        ("So the velocities of the root are multiplied by one number",
         "np.isclose(np.linalg.norm(moved[:, 64:], axis=1).mean(),"
         " np.linalg.norm(free[:, 64:], axis=1).mean())"),
        ("It turns as before", "np.array_equal(moved[:, 63], I[:240, 63])"),
        ("with a rate ten times as large in the first", "own.Settings().rate == 0.1"),
        ("its content loss is the largest of the three",
         "arrived['noise', 0.01][1] == max(loss for _, loss in arrived.values())"),
        ("At 0.1 it arrives, and nearer to the style than the search that began at the content",
         "arrived['noise', 0.1][0] < arrived['content', 0.1][0]"),
    ],
    "11": [
        ("Each ReLU lets about half of the numbers through",
         "0.35 < np.mean(stations['dA2'] != 0) < 0.65"),
        ("neither blows a gradient up nor starves it",
         "0.1 < np.std(stations['dA1']) / np.std(stations['dR2']) < 10"),
        ("the bars as means of squares, as the authors' code does",
         "fitted.reading == 'mean_squares'"),
        ("its curve falls by more than a factor of ten",
         "10 * trained['means of squares'][1][-1]['style']"
         " < trained['means of squares'][1][0]['style']"),
        ("at $s = 0.01$ more of the content is kept",
         "np.linalg.norm(networks.encode(networks.transformation(I,"
         " trained['norms, as printed'][0]), manifold.params) - lesson.hidden)"
         " < np.linalg.norm(networks.encode(networks.transformation(I,"
         " trained['means of squares'][0]), manifold.params) - lesson.hidden)"),
        ("Bones and trajectory fall in both",
         "all(curve[-1][name] < curve[0][name] for _, curve in trained.values()"
         " for name in ('bone', 'trajectory'))"),
        ("The second training reads the bars as means of squares",
         "style_distance(compared['means of squares'], [clips['old'].features], manifold)"
         " < style_distance(compared['norms, as printed'], [clips['old'].features], manifold)"),
    ],
    "12": [
        ("The orange curve leans", "np.ptp(along(skating[first:last, toe])) > 2"),
        ("The black line is level", "np.ptp(along(held[first:last])) < 1e-9"),
        ("in between it may stay a little beside it",
         "np.abs(along(planted[first + 4:last - 4, toe] - held[first + 4:last - 4])).max() < 8"),
        ("and, as a gift,}\\quad w(x) + w(1 - x) = 1",
         "np.allclose(fade(np.linspace(0, 1, 9)) + fade(1 - np.linspace(0, 1, 9)), 1)"),
        ("$c = 4$, $e = 3$, a triangle of 3, 4 and 5",
         "np.allclose(two_bone(hip, ankle, np.array([5.0]), np.array([5.0]), forward), [0, 4, 3])"),
        ("Bones of the leg keep their length, to the last digits",
         "np.abs(lengths(planted) / lengths(skating) - 1).max() < 1e-12"),
        ("by 20 cm a second more than it steps", "15 < foot_skate(skating, contacts)"
         " - foot_skate(walk, contacts) < 21"),
        ("Your clean-up takes off most of the skate",
         "foot_skate(by_you, contacts) < 0.5 * foot_skate(skating, contacts)"),
        ("and about doubles the jerk", "1.6 < jerk(by_you) / jerk(skating) < 2.8"),
        ("the smooth one takes off more, for much less of it",
         "foot_skate(planted, contacts) < foot_skate(by_you, contacts)"
         " and jerk(planted) - jerk(skating) < 0.7 * (jerk(by_you) - jerk(skating))"),
        ("whole body sinks* a little", "0 <= down.min() and down.max() < 3"),
    ],
    "13": [
        ("e^{-i \\omega_j n} = e^{-i \\pi (2 j + 1)} = -1",
         "np.allclose(np.exp(-1j * np.pi * (2 * np.arange(8) + 1)), -1)"),
        ("comes back at its beginning *negated*", "np.allclose(y, again)"),
        ("the columns of $F$ are orthogonal", "np.allclose(F.T @ F, 8 * np.eye(16))"),
        ("Hence $x = \\frac{2}{n} F^{\\mathsf T} F x$",
         "np.allclose(2 / 16 * F.T @ F, np.eye(16))"),
        ("$3 \\cdot 32 = 96$", "3 * 64 // 2 == 96 and (64 - 25 + 1) * 25 == 1000"),
        ("two gradients, two adjoints",
         "np.isclose(np.vdot(dy, nn.conv1d(np.ones(dx.shape), u)),"
         " np.vdot(nn.conv1d_backward(dy, np.ones(dx.shape), u, None)[1], u))"),
        ("The strides get much shorter",
         "np.ptp(smooth[:, ankle]) < 0.75 * np.ptp(X[:, ankle])"),
        ("faster on the sizes of the paper and equal to the last digits",
         "np.allclose(tiled.conv1d(x, w), nn.conv1d(x, w), atol=1e-4)"),
    ],
    "14": [
        ("The same action, but one takes longer", "b.frames > a.frames"),
        ("the diagonal one costs it once, though it takes a frame of both",
         "np.isclose(align.dtw(np.zeros((2, 1)), np.ones((2, 1)))[0], 2)"),
        ("Differences of timing cost little",
         "dtw(a.angles, uneven)[0] / len(a.angles) < ssd / len(path)"),
        ("$\\alpha = 0$ gives back $i$", "np.abs(blend(a.angles, b.angles, path, 0.0)"
         " - a.angles).max() < 1e-6"),
        ("Aligned, the blend is the bow;\nstretched to one length and averaged",
         "np.abs(made - align.read_at(a.angles, np.linspace(0, len(a.angles) - 1, len(made))))"
         ".mean() < 10 and len(stretched) == 100"),
        ("the mean of their places moves north-east, at $1/\\sqrt 2$ of the speed",
         "np.isclose(np.hypot(0.5, 0.5), 1 / np.sqrt(2))"),
        ("Average what a body feels, not where it is",
         "np.linalg.norm(np.diff(mean[:, [0, 2]], axis=0), axis=1).sum()"
         " < np.linalg.norm(np.diff(halfway[:, [0, 2]], axis=0), axis=1).sum()"),
        ("It bows in a time of its own",
         "a.frames <= len(blend(a.angles, b.angles, path, 0.5)) <= b.frames"),
    ],
    "15": [
        ("with 1.5 the scale ends at two of them", "np.isclose(1.5 * 2, 3)"),
        ("So $\\theta$ **is a sum of training examples**",
         "np.abs(theta - x.T @ a_linear).max() < 1e-9"),
        ("It works, and it crawls", "E[-1] < E[0] and E[-1] > bottom"),
        ("$f_{-n}(z_n) - y_n = -\\frac{a_n}{A_{nn}}", "np.allclose(anew, short[7])"),
        ("With $\\lambda \\to 0$ every training example is met exactly", "known[0].max() < 1e-3"),
        ("the error that counts does not", "left_out[0].mean() > 100 * known[0].mean()"),
        ("C\\, L_\\varepsilon(r) = \\max_{\\lvert \\beta \\rvert \\le C}",
         "all(np.isclose(2 * insensitive(r, 0.25), max(t * r - 0.25 * abs(t)"
         " for t in np.linspace(-2, 2, 401))) for r in (-1.0, -0.1, 0.0, 0.2, 3.0))"),
        ("\\min P = -\\min D", "abs(min(P) - floor) < 0.05 * floor"),
        ("Each value of $-D$ is a floor that $P$ cannot go below", "min(P) > floor - 1e-9"),
        ("examples inside the tube have $\\beta_n = 0$",
         "np.all(np.abs(beta[np.abs(v - svr.predict_svr(K, beta, b[0])) < epsilon - 0.02])"
         " < 1e-6)"),
    ],
    "16": [
        ("the same one too, at its beginning",
         "list(segmented(np.tile([[0.0, 0.0], [3.0, 1.0]], (2, 1)), [np.array([[0.0, 0.0],"
         " [3.0, 1.0]]), np.ones((2, 2))])[1]) == [0, 0]"),
        ("Every step costs one evaluation and shrinks the interval by $r$",
         "np.isclose(1 - (np.sqrt(5) - 1) / 2, ((np.sqrt(5) - 1) / 2) ** 2)"),
        ("the cost is $\\min_i C(T-1, T_i - 1, i)$",
         "np.isclose(one_stage(coarse, coarse_known), segment.segment(coarse, coarse_known)[0])"),
        ("equation 12 for the first piece", "min(left_over) <= choice.error + 1e-6"),
        ("In a tie the left end moves",
         "golden_section(lambda u: 0.0, 0.0, 1.0, 0.2) > 0.5"),
    ],
    "17": [
        ("a factor goes with it",
         "abs(trained['bias: a mean over clips'][1][-1] / trained['right'][1][-1] - 1) < 0.1"),
        ("Lost overlaps look like a slow training",
         "trained['overlaps lost'][1][-1] > 1.2 * trained['right'][1][-1]"),
        ("and then the loss climbs",
         "trained['zeros on the wrong side'][1][-1] > min(trained['zeros on the wrong side'][1])"),
        ("float32 is compared with the float64 answer", "case is not None"),
    ],
    "18": [
        ("*Wrong* must be 0", "all(o.grade != 'wrong' for o in outcomes)"),
        ("while the package's objective runs beside it on the same batches",
         "np.abs(curve[:40] / beside - 1).max() < 1e-6"),
        ("How near is it to the style",
         "style_distance(steps['result'], [X_style], manifold)"
         " < 0.5 * style_distance(X, [X_style], manifold)"),
        ("what the projection alone gives",
         "style_distance(manifold.motion(alone), [X_style], manifold)"
         " > 0.8 * style_distance(X, [X_style], manifold)"),
    ],
}
