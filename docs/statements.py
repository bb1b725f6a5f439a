"""What the two papers state, in their own order and in our words: read by `annotate.py`."""

from typing import NamedTuple


class Statement(NamedTuple):
    """title : with its equation, table or figure;  says : in our words;  formulas : LaTeX;
    functions : dotted names below refimpl;  departures : first cells of departures.md;
    operations : of the kit;  notebooks : numbers;  here, witness : sentences"""

    title: str
    says: str
    formulas: tuple = ()
    functions: tuple = ()
    departures: tuple = ()
    operations: tuple = ()
    notebooks: tuple = ()
    here: str = ""
    witness: str = ""


class Paper(NamedTuple):
    title: str
    lead: str
    statements: tuple


CODE_OF_2016 = ("numbers that the 2016 authors' own code produced, run unmodified "
                "([tests/holden2016/test_witness.py](../tests/holden2016/test_witness.py); "
                "[what it does](code_of_2016.md)).")

HOLDEN = Paper(
    "Holden, Habibie, Kusajima and Komura 2017, annotated",
    "*Fast Neural Style Transfer for Motion Data*, IEEE Computer Graphics and Applications 37(4), "
    "[doi:10.1109/MCG.2017.3271464](https://doi.org/10.1109/MCG.2017.3271464), in its own order. "
    "Where the accepted manuscript and the journal text differ, the page says so.",
    (
        Statement(
            "Data representation",
            "A pose is 21 joint positions in the frame of the root on the floor, and three "
            "velocities: turning, forward, sideways. That is 66 numbers a frame, at 60 frames a "
            "second.",
            functions=("motion.features.encode",),
            departures=("one body", "the root's velocity", "frame rates", "floor, contacts"),
            operations=("motion_to_numbers", "numbers_to_motion"), notebooks=("01", "02"),
            witness=CODE_OF_2016),
        Statement(
            "Windows",
            "For training, motion is cut into overlapping windows of 240 frames; what is shorter "
            "is padded with its first and last frames.",
            functions=("motion.windows.windows",), departures=("windows", "windows, padding"),
            operations=("motion_windows", "normaliser"), notebooks=("02",), witness=CODE_OF_2016),
        Statement(
            "Equation 1: the encoder",
            "A convolution over time with 256 filters of 25 frames; then the larger of each two "
            "frames is kept, and whatever is below 0 becomes 0.",
            (r"\mathcal{L}(\mathbf{X}) = \mathrm{ReLU}(\Psi(\mathbf{X} * \mathbf{W}_0 + "
             r"\mathbf{b}_0))",),
            ("holden2017.networks.encode", "nn.conv.conv1d", "nn.pool.max_pool1d",
             "nn.activation.relu"), ("normaliser",),
            ("conv1d", "max_pool1d", "relu", "encode"), ("03", "04"),
            witness="PyTorch and JAX on every sample of the three operations, values and "
                    "gradients; for the encoder as a whole " + CODE_OF_2016),
        Statement(
            "\"Half a second\"",
            "A filter of 25 frames is said to cover about half a second after pooling. Twenty-five "
            "frames at 60 a second are 0.42 s; one hidden unit sees 26 frames, since it takes the "
            "larger of two neighbours, and 25 hidden units side by side would be 0.83 s.",
            notebooks=("03",)),
        Statement(
            "A sparse basis",
            "256 hidden units for 66 numbers are said to be a sparse basis and more natural than "
            "principal components.",
            here="It is sparse: 28 % of the units are active. But as many components of the same "
                 "width reconstruct motion with a sixth of the error "
                 "([measured](paper_problem.md)).",
            notebooks=("09",)),
        Statement(
            "Equation 2: the decoder",
            "Back to motion with the same filters: depooling gives each of two frames one half, "
            "the bias is subtracted, and the filters are applied in the other direction.",
            (r"\mathcal{L}^{\dagger}(\mathbf{H}) = (\Psi^{\dagger}(\mathbf{H}) - \mathbf{b}_0) * "
             r"\widetilde{\mathbf{W}}_0",),
            ("holden2017.networks.decode", "nn.pool.avg_depool1d", "nn.pool.random_depool1d",
             "nn.conv.conv_transpose1d"), ("equations 2 and 3",),
            ("decode", "avg_depool1d", "random_depool1d", "conv_transpose1d"), ("03", "04"),
            witness="the decoder of 2016, whose filters are its own: " + CODE_OF_2016),
        Statement(
            "Equation 3: learning the manifold",
            "The squared error of the reconstruction, plus the sum of the absolute values of all "
            "parameters, weighted by alpha.",
            (r"\mathrm{Loss}(\mathbf{X}, \theta) = \| \mathbf{X} - "
             r"\mathcal{L}^{\dagger}(\mathcal{L}(\mathbf{X})) \|_2^2 + \alpha \| \theta \|_1",),
            ("holden2017.networks.autoencoder_loss",),
            ("equation 3", "equations 2 and 3", "the loss network's data"),
            ("autoencoder_loss", "train_loss_network"), ("09",), witness=CODE_OF_2016),
        Statement(
            "The transformation network",
            "T is a feed-forward convolutional network like the loss network; the paper gives no "
            "sizes.",
            functions=("holden2017.networks.transformation",),
            departures=("transformation network",), operations=("transform",), notebooks=("11",)),
        Statement(
            "Equation 4: content",
            "How far the hidden units of the result lie from those of the input, weighted by "
            "c = 1.0.",
            (r"\mathrm{Loss}_{content} = c\, \| \mathcal{L}(\mathbf{I}) - \mathcal{L}(\mathcal{T}"
             r"(\mathbf{I})) \|",),
            ("holden2017.losses.content_loss",), ("equations 4 and 5, the bars",),
            ("content_loss",), ("06",)),
        Statement(
            "Equation 5: style",
            "How far the Gram matrix of the result's hidden units lies from that of the style "
            "clip, weighted by s = 0.01. In the introduction the style is said to be an average "
            "over all frames; equation 6 is a sum, which grows with the clip.",
            (r"\mathrm{Loss}_{style} = s\, \| \mathrm{Gram}(\mathcal{L}(\mathbf{S})) - "
             r"\mathrm{Gram}(\mathcal{L}(\mathcal{T}(\mathbf{I}))) \|",),
            ("holden2017.losses.style_loss",),
            ("equation 5", "equations 4 and 5, the bars"), ("style_loss", "style_target"), ("06",)),
        Statement(
            "Equation 6: the Gram matrix",
            "The sum over time of the products of all pairs of hidden units.",
            (r"\mathrm{Gram}(\mathbf{H}) = \sum_i \mathbf{H}_i \mathbf{H}_i^{\mathrm{T}}",),
            ("nn.gram.gram",), (), ("gram",), ("06",)),
        Statement(
            "Pairing contents and exemplars",
            "For an angry style, windows of running are paired with the angry run and windows of "
            "walking with the angry walk: one network for each style, and many contents.",
            functions=("holden2017.pairing.pair_contents",), departures=("exemplars",),
            notebooks=("11",)),
        Statement(
            "Equation 7: feet",
            "Where a foot is labelled as standing, its own velocity, that of the root and what the "
            "turning of the body adds must cancel. The manuscript's words leave out the foot's own "
            "velocity; its formula has it.",
            (r"\mathrm{Loss}_{foot} = \sum_j \| \mathbf{v}_r + \omega \times \mathbf{p}_j + "
             r"\mathbf{v}_j - \mathbf{r}' \|^2",),
            ("holden2017.losses.foot_loss",), ("equation 7", "contacts"),
            ("foot_loss", "foot_contacts", "planted_feet"), ("07",)),
        Statement(
            "Equation 8: bones",
            "The squared difference between the length of each bone and the length that it should "
            "have. The words say a mean; the formula is a sum.",
            (r"\mathrm{Loss}_{bone} = \sum_b \big\| \| \mathbf{p}_{b_{j_1}} - \mathbf{p}_{b_{j_2}} "
             r"\| - l_b \big\|^2",),
            ("holden2017.losses.bone_loss",), ("weights of the constraints",), ("bone_loss",),
            ("07",)),
        Statement(
            "Equation 9: the trajectory",
            "The squared difference between the turning and velocity of the root and those that "
            "are wanted. The accepted manuscript squares both terms, the journal text only the "
            "second.",
            (r"\mathrm{Loss}_{traj} = \| \omega - \omega' \|^2 + \| \mathbf{v}_r - \mathbf{v}'_r "
             r"\|^2",),
            ("holden2017.losses.trajectory_loss",), ("equation 9", "weights of the constraints"),
            ("trajectory_loss",), ("07",)),
        Statement(
            "Equation 10: the objective",
            "The sum of the five losses.",
            (r"\mathrm{Loss} = \mathrm{Loss}_{content} + \mathrm{Loss}_{style} + "
             r"\mathrm{Loss}_{foot} + \mathrm{Loss}_{bone} + \mathrm{Loss}_{traj}",),
            ("holden2017.objective.total_loss",), ("weights of the constraints",),
            ("total_loss", "fitted_weights"), ("11",)),
        Statement(
            "Training",
            "Adam for 100 epochs on about 20 minutes of locomotion, which takes about 20 minutes "
            "on a GeForce GTX 970 for each style.",
            functions=("nn.adam.adam_step",), departures=("Adam's rate",),
            operations=("adam_step", "train_transformation_network", "learning_rate"),
            notebooks=("08", "11"), here="Times stand in [speed](speed.md)."),
        Statement(
            "Manifold projection",
            "The output of T is encoded and decoded once more, which removes its noise.",
            functions=("holden2017.networks.project",), departures=("projection", "range"),
            operations=("project", "projected_numbers"), notebooks=("09", "11")),
        Statement(
            "Figure 1: the two networks",
            "T on the left, L on the right with its two tasks: to measure the loss, and to "
            "project.",
            here="`refimpl experiment holden --tables figures` draws it from the networks "
                 "themselves."),
        Statement(
            "Figure 2: manifold projection",
            "T(I) in grey, with its noise, under P(T(I)) in blue.",
            here="Drawn by `refimpl experiment holden --tables figures`; "
                 "[measured](paper_problem.md).",
            notebooks=("09",)),
        Statement(
            "Figure 3: results",
            "Style, content and result for zombie, old man, injured and depressed. The experiments "
            "used ten styles of walking, jogging and running, which are not public.",
            departures=("styles and figures",), here="Ten other styles, and what falls short: "
            "[measured](paper_problem.md)."),
        Statement(
            "Figure 4: beside the system of 2016",
            "Content, the result of 2016 and that of 2017, \"in most cases visually similar\".",
            departures=("the system of 2016",), here="[Measured](results.md).", notebooks=("10",)),
        Statement(
            "Table 1: runtimes",
            "12, 14 and 17 ms for 240, 480 and 960 frames on a GeForce GTX 660, against 15.2, 20.3 "
            "and 33.4 s of the optimisation: 1,270 to 1,960 times. The frames a second that it "
            "prints for the first do not follow from its seconds (240 / 0.012 is 20,000, not "
            "21,818).",
            functions=("experiments.evaluate.timings",), here="[Speed](speed.md)."),
        Statement(
            "Limitations: data like the input, the whole motion up front",
            "Training needs data like what will be given to the network, and the whole motion has "
            "to be known before it begins.",
            departures=("range",), here="`transfer` tells where a clip is nothing like what the "
            "style learnt on, and the style fades there; how far ahead a result looks is "
            "[measured](paper_problem.md)."),
        Statement(
            "Limitations: punching and kicking",
            "The accepted manuscript says that the method \"does produce as good results\" on "
            "motion that is not locomotion (a *not* seems to be missing), the journal text that it "
            "\"produces good results\". Which was meant is not known.",
            here="Tried on gestures: the style loss loses them ([measured](paper_problem.md))."),
        Statement(
            "Limitations: feet",
            "Projection may make feet slide, which a fast post process such as inverse kinematics "
            "has to mend. The paper shows raw output.",
            functions=("motion.foot_ik.lock_feet",), departures=("feet",), notebooks=("12",)),
        Statement(
            "Future work: other transformations",
            "Other sizes, weights or structures of a character might be learnt from one exemplar "
            "as well.",
            here="Tried with another body: the Gram matrix brings 9 % of a longer arm, equation 8 "
                 "with the new lengths 109 % ([measured](paper_problem.md))."),
    ))

EQUATION_3, EQUATION_6, EQUATION_8 = (
    "[equation 3](#equation-3-how-alike-two-contents-are)",
    "[equation 6](#equation-6-what-regression-minimises)",
    "[equation 8](#equation-8-cutting-a-phrase)")

TORRESANI = Paper(
    "Torresani, Hackney and Bregler 2006, annotated",
    "*Learning Motion Style Synthesis from Perceptual Observations*, Advances in Neural "
    "Information Processing Systems 19, "
    "[the paper](https://papers.nips.cc/paper/2006/hash/"
    "d4a897919a124958e699170b2b1dc8f2-Abstract.html), in its own order.",
    (
        Statement(
            "Efforts of Laban Movement Analysis",
            "Style is a point in three dimensions from -3 to 3: flow (free or bound), weight "
            "(strong or light) and time (sudden or sustained). The effort of space is left out, "
            "since motion capture does not hold the gaze.",
            departures=("2006, labels",), operations=("effort_measures", "observed_styles"),
            notebooks=("15",)),
        Statement(
            "Equation 1: what is to be learnt",
            "A function that predicts the efforts of a blend from its two parents, their efforts "
            "and the share alpha.",
            (r"\mathbf{e}^{\alpha}_{i,j} = f(\mathbf{X}_i, \mathbf{X}_j, \mathbf{e}_i, "
             r"\mathbf{e}_j, \alpha)",),
            ("torresani2006.regress.inputs",), (), ("predicted_style", "fitted_style"), ("15",)),
        Statement(
            "Equation 2: what is asked of it",
            "For each piece of the input, the pair and the share whose predicted efforts come "
            "nearest to the ones asked for.",
            (r"\alpha^*, k^*, l^* = \arg\min_{\alpha, k, l} \| \mathbf{e} - f(\mathbf{X}_{i_k}, "
             r"\mathbf{X}_{i_l}, \mathbf{e}_{i_k}, \mathbf{e}_{i_l}, \alpha) \|",),
            ("torresani2006.synthesise.restyle",), (), ("styled_phrase",), ("16",)),
        Statement(
            "Equation 3: how alike two contents are",
            "The least sum of squared differences of joint angles over all ways to warp one time "
            "into the other.",
            (r"SSD(\mathbf{X}_i, \mathbf{X}_j) = \min_{w} \sum_n d(w(n))",),
            ("torresani2006.align.dtw_definition", "torresani2006.align.distances"),
            ("2006, contents",), ("dtw_cost", "all_dtw_costs"), ("14",),
            witness="all paths by brute force, dtw-python and dtaidistance "
                    "([tests/torresani2006/test_align.py](../tests/torresani2006/test_align.py))."),
        Statement(
            "Equation 4: where a path begins and ends",
            "At the first frames of both and at the last of both.",
            (r"p(1) = 1,\quad q(1) = 1,\quad p(L) = T_i,\quad q(L) = T_j",), (), (),
            ("dtw_path",), ("14",), here=f"The same function as {EQUATION_3}."),
        Statement(
            "Equation 5: its steps",
            "One frame on in one of the two, or in both.",
            (r"w(n) = (p, q) \;\Rightarrow\; w(n-1) \in \{(p-1, q), (p-1, q-1), (p, q-1)\}",), (),
            (), ("dtw_path",), ("14",), here=f"The same function as {EQUATION_3}."),
        Statement(
            "Contents found automatically",
            "Two motions are alike if SSD is below a certain value; all 60 fragments are said to "
            "have been clustered into the five actions by it.",
            functions=("torresani2006.align.clusters",), departures=("2006, contents",),
            operations=("content_clusters", "cluster_threshold"), notebooks=("14",)),
        Statement(
            "Section 5: space-time interpolation",
            "The path of equation 3 is a curve in time; parents are read along it at parameters "
            "between those of their own timings, and their angles are mixed.",
            (r"\mathbf{X}^{\alpha}_{i,j}(k) = (1-\alpha)\, \mathbf{X}_i(p^*(n^{\alpha}_k)) + "
             r"\alpha\, \mathbf{X}_j(q^*(n^{\alpha}_k)),\qquad T = (1-\alpha) T_i + \alpha T_j",),
            ("torresani2006.align.interpolate",), ("2006, time curve",),
            ("space_time_interpolation",), ("14",)),
        Statement(
            "Section 6: principal components",
            "Fragments are stretched to one length and brought to two or three principal "
            "components.",
            functions=("torresani2006.pca.fit_pca",), operations=("principal_components",),
            notebooks=("15",), witness="scikit-learn "
            "([tests/torresani2006/test_regress.py](../tests/torresani2006/test_regress.py))."),
        Statement(
            "Equation 6: what regression minimises",
            "A constant U times the sum of the losses, and the squared size of the parameters. "
            "The scanned text of the paper has lost the sum's index.",
            (r"E(\theta) = U \sum L(f(\mathbf{z}^{\alpha}_{i,j}, \theta) - "
             r"\mathbf{e}^{\alpha}_{i,j}) + \| \theta \|^2",),
            ("torresani2006.regress.linear_ridge",), ("2006, regression",),
            ("linear_ridge", "ridge_errors"), ("15",),
            witness="scikit-learn, and gradients that vanish at the solution."),
        Statement(
            "Equation 7: a linear model",
            "The simplest f is linear in its inputs.",
            (r"f(\mathbf{z}, \theta) = \mathbf{z}^{\mathrm{T}} \theta",), (), (), ("linear_ridge",),
            ("15",), here=f"The same function as {EQUATION_6}."),
        Statement(
            "Section 6: kernels and support vectors",
            "Kernel ridge regression with a Gaussian kernel, and support vector regression, whose "
            "prediction needs the support vectors alone.",
            functions=("torresani2006.regress.kernel_ridge", "torresani2006.svr.dual_objective"),
            operations=("gaussian_kernel", "kernel_ridge", "support_vector_regression",
                        "machine_errors", "machine_violation"), notebooks=("15",),
            witness="scikit-learn to 1e-10 (kernel ridge) and to the solver's tolerance (support "
                    "vectors)."),
        Statement(
            "Equation 8: cutting a phrase",
            "The least cost over all concatenations of database fragments and all ways to warp "
            "them onto the phrase.",
            (r"\min_w \sum_n d(w(n)),\qquad w(n) = (p(n), q(n), i(n))",),
            ("torresani2006.segment.segment",), (), ("one_stage_segmentation",), ("16",),
            witness="brute force over all concatenations."),
        Statement(
            "Equation 9: from fragment to fragment",
            "A fragment's first frame is reached from itself, or from the last frame of any "
            "fragment.",
            (r"w(n) = (p, 1, i) \;\Rightarrow\; w(n-1) \in \{(p-1, 1, i), (p-1, T_j, j)\}",), (),
            (), ("one_stage_segmentation",), ("16",), here=f"The same function as {EQUATION_8}."),
        Statement(
            "Equation 10: within a fragment",
            "The steps of equation 5.",
            (r"w(n) = (p, q, i),\, q > 1 \;\Rightarrow\; w(n-1) \in \{(p-1, q, i), (p-1, q-1, i), "
             r"(p, q-1, i)\}",), (), (), ("one_stage_segmentation",), ("16",),
            here=f"The same function as {EQUATION_8}."),
        Statement(
            "Equation 11: first and last frames",
            "A path begins in first frames and ends in last frames.",
            (r"p(1) = 1,\quad q(1) = 1,\quad p(L) = T,\quad q(L) = T_{i(L)}",), (), (),
            ("one_stage_segmentation",), ("16",), here=f"The same function as {EQUATION_8}."),
        Statement(
            "Equation 12: choosing a blend",
            "For each pair of the K neighbours of the matched fragment, f is evaluated at M shares "
            "between -0.25 and 1.25, the best refined by golden section; then the best pair is "
            "taken.",
            (r"\alpha^*, k^*, l^* = \arg\min_{\alpha, k, l} \| \mathbf{e} - f(\mathbf{z}^{\alpha}_"
             r"{i_k, i_l}) \|",),
            ("torresani2006.synthesise.rank_pairs", "torresani2006.synthesise.golden_section"),
            ("2006, equation 12",), ("best_alpha", "golden_section", "best_pair"), ("16",)),
        Statement(
            "Joining the pieces",
            "The blends are concatenated.",
            functions=("torresani2006.join.join",), departures=("2006, joining",),
            operations=("joined_motions",), notebooks=("16",)),
        Statement(
            "Section 8: data",
            "Twelve dancers perform one phrase, cut by an expert into five fragments each; a chain "
            "of 17 joints, exponential maps; 105 blends with alpha between -0.25 and 1.25; 85 to "
            "learn on, 20 to test, 500 splits; ten-fold search.",
            operations=("exponential_map", "rotation_vector"),
            here="The recordings and the expert's labels are not public. "
                 "[What was measured](torresani.md) in their place.",
            notebooks=("14", "15")),
        Statement(
            "Table 1: which model predicts best",
            "Mean squared errors of flow, weight and time: linear interpolation 0.65, 0.97, 1.01; "
            "linear ridge 1.03, 1.04, 1.01; kernel ridge 0.50, 0.39, 0.60; support vectors 0.48, "
            "0.48, 0.61. Linear interpolation is printed as alpha e_i + (1 - alpha) e_j, which "
            "contradicts section 5.",
            functions=("experiments.learning.table_1",), departures=("2006, section 8",),
            notebooks=("15",), here="[Measured](torresani.md)."),
        Statement(
            "Figure 1: efforts along alpha",
            "Kernel ridge's efforts for three pairs and alpha between -0.25 and 1.25: flow nearly "
            "straight, weight and time curved.",
            functions=("experiments.torresani.figure_1",), notebooks=("15",)),
        Statement(
            "Section 8: the whole pipeline",
            "Phrases of dancers who are not in the database were always cut into the right five "
            "actions, and the styles asked for, considerably different from those of training, "
            "were seen by experts in most results.",
            here="[Measured](torresani.md)."),
    ))

EXAMPLES = {
    "convolution": """
        >>> from refimpl import nn
        >>> x, w = np.array([[[0.0, 1, 0]]]), np.array([[[1.0, 2, 3]]])
        >>> nn.conv1d(x, w)                       # flipped: [[[1., 2., 3.]]]
        array([[[3., 2., 1.]]])
        """,
    "zeros of 'same' padding when their number is odd": """
        >>> from refimpl import nn
        >>> x, w = np.array([[[1.0, 2, 3]]]), np.array([[[1.0, 10]]])
        >>> nn.conv1d(x, w)                       # the larger half left: [[[10., 21., 32.]]]
        array([[[21., 32.,  3.]]])
        """,
    "an infinite or NaN filter where it meets the padding": """
        >>> from refimpl import nn
        >>> x, w = np.array([[[1.0, 2, 3]]]), np.array([[[np.inf, 1, 1]]])
        >>> with np.errstate(invalid="ignore"):
        ...     nn.conv1d(x, w)                   # left out: [[[3., inf, inf]]]
        array([[[nan, inf, inf]]])
        """,
    "equal largest elements in a max-pool window": """
        >>> from refimpl import nn
        >>> x, dy = np.array([[[5.0, 5.0]]]), np.array([[[1.0]]])
        >>> nn.max_pool1d_backward(dy, x)         # all: [[[1., 1.]]]; equally: [[[0.5, 0.5]]]
        array([[[1., 0.]]])
        """,
    "NaN in a max-pool window": """
        >>> from refimpl import nn
        >>> nn.max_pool1d(np.array([[[1.0, np.nan]]]))        # ignored: [[[1.]]]
        array([[[nan]]])
        """,
    "derivative of relu at 0": """
        >>> from refimpl import nn
        >>> nn.relu_backward(np.ones(1), np.zeros(1))         # others: 0.5, 1
        array([0.])
        """,
    "relu of NaN": """
        >>> from refimpl import nn
        >>> nn.relu(np.array([np.nan])), nn.relu_backward(np.ones(1), np.array([np.nan]))
        (array([nan]), array([0.]))
        """,
    "derivative of |x| at 0": """
        >>> from refimpl import nn
        >>> nn.l1_backward(1.0, np.zeros(1))                  # JAX: 1
        array([0.])
        """,
    "derivative of a norm at 0": """
        >>> from refimpl import nn
        >>> nn.norm_backward(np.ones(1), np.zeros((1, 2)))    # by dividing: nan
        array([[0., 0.]])
        """,
    "Gram matrix": """
        >>> from refimpl import nn
        >>> nn.gram(np.array([[[1.0, 2, 2]]]))                # divided by the frames: 3
        array([[[9.]]])
        """,
    "the bars of the content and style loss": """
        >>> from refimpl.holden2017 import losses
        >>> a, b = np.array([[[3.0, 4.0]]]), np.zeros((1, 1, 2))
        >>> losses.content_loss(a, b), losses.content_loss(a, b, reading="mean_squares")
        (array([5.]), array([12.5]))
        """,
    "depooling": """
        >>> from refimpl import nn
        >>> h = np.array([[[4.0]]])
        >>> nn.avg_depool1d(h), nn.random_depool1d(h, np.array([[[1]]]))
        (array([[[2., 2.]]]), array([[[0., 4.]]]))
        """,
    "DTW step": """
        >>> from refimpl.torresani2006 import align
        >>> cost, path = align.dtw(np.array([[0.0], [2], [1]]), np.array([[0.0], [1]]))
        >>> float(cost)                                       # symmetric2 counts a diagonal twice
        1.0
        """,
    "padding of a max-pool": """
        >>> from refimpl import nn
        >>> x = np.array([[[-1.0, -2]]])
        >>> nn.max_pool1d(x, padding=1)           # if zeros counted: [[[0., 0.]]]
        array([[[-1., -2.]]])
        """,
    "a max-unpool place that two values claim": """
        >>> from refimpl import nn
        >>> h, indices = np.array([[[5.0, 7]]]), np.array([[[1, 1]]])
        >>> nn.max_unpool1d(h, indices, 3)        # if the first stood: [[[0., 5., 0.]]]
        array([[[0., 7., 0.]]])
        """,
    "Adam": """
        >>> from refimpl import nn
        >>> w, g = {"w": np.ones(1)}, {"w": np.full(1, 1e-8)}
        >>> for variant in ("kingma-ba", "epsilon-hat", "no-bias-correction"):
        ...     print(variant, nn.adam_step(w, g, nn.adam_start(w), rate=0.1,
        ...                                 variant=variant)[0]["w"].round(4))
        kingma-ba [0.95]
        epsilon-hat [0.9969]
        no-bias-correction [0.9903]
        """,
    "a root's velocity in the 66 numbers": """
        >>> from refimpl.motion import features
        >>> numbers = np.zeros((2, 66))
        >>> numbers[:, [features.TURN, features.FORWARD]] = np.pi / 2, 1.0
        >>> root, _ = features.root_motion(numbers)
        >>> (root[1] - root[0]).round(6)          # from the frame that it leaves: [0., 0., 1.]
        array([1., 0., 0.])
        """,
    "turning error of the trajectory loss": """
        >>> from refimpl.holden2017 import losses
        >>> still, wanted = np.zeros((1, 66, 1)), np.array([[[3.0], [0], [0]]])
        >>> losses.trajectory_loss(still, wanted)             # not squared: 3
        array([9.])
        """,
    "the sign of a principal component": """
        >>> from refimpl.torresani2006 import pca
        >>> angles = [np.array([[angle]]) for angle in (0.0, 5.0, 6.0)]
        >>> pca.fit_pca(angles, 1, length=1).basis            # largest in the scores: [[-1.]]
        array([[1.]])
        """,
    "BVH position channels": """
        >>> from refimpl.motion.clip import Clip, Joint
        >>> from refimpl.motion.skeleton import local_pose
        >>> hips = Joint("Hips", -1, (0.0, 90.0, 0.0), ("Yposition",))
        >>> _, places = local_pose(Clip((hips,), 0.1, np.array([[95.0]])))
        >>> places[0, 0]                                      # added: [0., 185., 0.]
        array([ 0., 95.,  0.])
        """,
}
