"""Principal components, ridge regression and the support vector machine: by definition, by the KKT
conditions, against scikit-learn.
"""

from hypothesis import given
from hypothesis import strategies as st
import numpy as np
import pytest
from scipy.optimize import minimize

from refimpl.torresani2006 import pca, regress, svr
from refimpl.torresani2006.align import AlignError


def problem(seed, n=40, d=4):
    rng = np.random.default_rng(seed)
    Z = rng.normal(size=(n, d))
    return Z, np.sin(2 * Z[:, 0]) + 0.5 * Z[:, 1] * Z[:, 2] + 0.1 * rng.normal(size=n)


def test_pca():
    rng = np.random.default_rng(0)
    sequences = [rng.normal(size=(n, 5)) * [3, 1, 1, 1, 1] for n in (20, 31, 44, 25, 60)]
    projection = pca.fit_pca(sequences, 3, 10)
    np.testing.assert_allclose(projection.basis @ projection.basis.T, np.eye(3), atol=1e-12)
    c = np.array([pca.pca_scores(projection, sequence) for sequence in sequences])
    np.testing.assert_allclose(c.mean(axis=0), 0, atol=1e-12)
    X = np.stack([pca.stretched(sequence, 10).ravel() for sequence in sequences])
    needed = np.linalg.eigvalsh(np.cov(X.T, bias=True))[::-1][:3]
    np.testing.assert_allclose(c.var(axis=0), needed, rtol=1e-9)
    with pytest.raises(regress.RegressError, match="components: found 6"):
        pca.fit_pca(sequences, 6, 10)
    with pytest.raises(regress.RegressError, match=r"angles a frame \[4, 5\]"):
        pca.fit_pca([sequences[0], sequences[1][:, :4]], 1, 10)
    with pytest.raises(regress.RegressError, match="sequences: found"):
        pca.fit_pca([], 1, 10)
    with pytest.raises(AlignError, match=r"sequences\[1\]: found shape \(0, 5\)"):
        pca.fit_pca([sequences[0], sequences[1][:0]], 1, 10)


def test_signs_of_principal_components():
    """The largest element by size is positive, whatever the sign of the data."""
    rng = np.random.default_rng(4)
    sequences = list(rng.normal(size=(9, 6, 2)))
    for sign in (1, -1):
        basis = pca.fit_pca([sign * sequence for sequence in sequences], 3, 6).basis
        assert (basis[np.arange(3), np.abs(basis).argmax(axis=1)] > 0).all()
        np.testing.assert_allclose(np.abs(basis), np.abs(pca.fit_pca(sequences, 3, 6).basis),
                                   atol=1e-12)


def test_stretched_keeps_both_ends_and_what_has_the_length():
    X = np.random.default_rng(0).normal(size=(17, 3))
    np.testing.assert_allclose(pca.stretched(X, 17), X, atol=1e-12)
    np.testing.assert_array_equal(pca.stretched(X, 5)[[0, -1]], X[[0, -1]])


def test_linear_interpolation():
    Z = regress.inputs(np.zeros((2, 3)), np.ones((2, 3)), np.array([[1., 2, 3], [0, 0, 0]]),
                       np.array([[3., 2, 1], [1, 1, 1]]), [0.25, -0.25])
    np.testing.assert_allclose(regress.linear_interpolation(Z),
                               [[1.5, 2, 2.5], [-0.25, -0.25, -0.25]])


def test_kernel_ridge_with_a_linear_kernel_is_linear_ridge():
    Z, y = problem(1)
    theta = regress.linear_ridge(Z, y, 0.7)
    np.testing.assert_allclose(Z @ theta, Z @ Z.T @ regress.kernel_ridge(Z @ Z.T, y, 0.7),
                               atol=1e-10)


def test_cross_validation_without_refitting_equals_refitting():
    Z, y = problem(2)
    K, folds = regress.gaussian_kernel(Z, Z, 0.3), regress.make_folds(40, np.random.default_rng(0))
    assert np.bincount(folds).tolist() == [4] * 10
    errors = regress.ridge_errors(K, y[:, None], (0.01, 1.0), folds)
    for ridge, error in zip((0.01, 1.0), errors[:, 0]):
        needed = 0
        for fold in range(10):
            a, b = folds != fold, folds == fold
            needed += ((K[np.ix_(b, a)] @ regress.kernel_ridge(K[np.ix_(a, a)], y[a], ridge)
                        - y[b]) ** 2).sum()
        assert error == pytest.approx(needed / 40, rel=1e-9)


def test_svr_cross_validation_equals_refitting():
    Z, y = problem(3, n=24)
    folds = regress.make_folds(24, np.random.default_rng(0), 4)
    Ks = np.stack([regress.gaussian_kernel(Z, Z, gamma) for gamma in (0.1, 0.5)])
    errors = regress.svr_errors(Ks, np.stack([y, -2 * y], axis=1), (1.0, 4.0), (0.05, 0.2), folds,
                                tolerance=1e-8)
    needed = 0
    for fold in range(4):
        a, b = folds != fold, folds == fold
        beta, offset = svr.fit_svr(Ks[1:, a][:, :, a], -2 * y[None, a], 4.0, 0.2, tolerance=1e-8)
        needed += (((svr.predict_svr(Ks[1][np.ix_(b, a)], beta[0], offset[0])
                     + 2 * y[b]) ** 2).sum() / 24)
    assert errors[1, 1, 1, 1] == pytest.approx(needed, rel=1e-5)


@given(st.integers(0, 10_000), st.sampled_from([0.1, 1.0, 30.0]), st.sampled_from([0.0, 0.05, 0.5]),
       st.sampled_from([0.05, 0.5]))
def test_svr_meets_the_kkt_conditions(seed, C, epsilon, gamma):
    Z, y = problem(seed, n=25)
    K = regress.gaussian_kernel(Z, Z, gamma)
    beta, b = (x[0] for x in svr.fit_svr(K[None], y[None], C, epsilon))
    assert svr.kkt_violation(K, y, beta, C, epsilon) < 2 * svr.KKT_TOLERANCE
    # the conditions as the textbooks have them
    residual = y - svr.predict_svr(K, beta, b)
    assert np.abs(residual[np.abs(beta) < C]).max(initial=0) <= epsilon + 1e-5
    inside = (np.abs(beta) > 1e-9) & (np.abs(beta) < C - 1e-9)
    np.testing.assert_allclose(np.abs(residual[inside]), epsilon, atol=1e-5)
    assert (beta[np.abs(residual) < epsilon - 1e-5] == 0).all()
    assert (residual[beta >= C - 1e-9] >= epsilon - 1e-5).all()


def test_svr_dual_is_minimal():
    """A general optimiser on the textbook's 2 n variables finds nothing lower."""
    Z, y = problem(5, n=12)
    K = regress.gaussian_kernel(Z, Z, 0.3)
    beta, _ = svr.fit_svr(K[None], y[None], 1.5, 0.1)
    found = minimize(lambda a: svr.dual_objective(K, y, a[:12] - a[12:], 0) + 0.1 * a.sum(),
                     np.full(24, 0.1), method="SLSQP", bounds=[(0, 1.5)] * 24,
                     constraints={"type": "eq", "fun": lambda a: a[:12].sum() - a[12:].sum()},
                     options={"maxiter": 500, "ftol": 1e-12})
    assert svr.dual_objective(K, y, beta[0], 0.1) == pytest.approx(found.fun, abs=1e-6)


def test_kkt_violation_sees_a_wrong_solution():
    Z, y = problem(6)
    K = regress.gaussian_kernel(Z, Z, 0.3)
    beta, _ = svr.fit_svr(K[None], y[None], 1.0, 0.1)
    assert svr.kkt_violation(K, y, 0.9 * beta[0], 1.0, 0.1) > 0.01
    assert svr.kkt_violation(K, y, np.r_[beta[0][:-1], beta[0][-1] + 0.3], 1.0, 0.1) > 0.1


def test_problems_side_by_side_do_not_disturb_each_other():
    Z, y = problem(7)
    Ks = np.stack([regress.gaussian_kernel(Z, Z, gamma) for gamma in (0.1, 1.0)])
    Y, C, epsilon, which = (np.stack([y, y[::-1], 3 * y]), np.array([[1.0], [5.0], [0.2]]),
                            np.array([0.1, 0.0, 0.3]), np.array([1, 0, 1]))
    beta, b = svr.fit_svr(Ks, Y, C, epsilon, kernel=which)
    for n in range(3):
        alone = svr.fit_svr(Ks[which[n]][None], Y[n:n + 1], C[n], epsilon[n])
        np.testing.assert_array_equal(beta[n], alone[0][0])
        assert b[n] == alone[1][0]


def test_svr_errors():
    with pytest.raises(svr.SVRError, match="shapes"):
        svr.fit_svr(np.eye(3)[None], np.zeros(3), 1.0, 0.1)
    for K, y in ((np.full((1, 3, 3), np.nan), np.zeros((1, 3))),
                 (np.eye(3)[None], np.full((1, 3), np.inf))):
        with pytest.raises(svr.SVRError, match="not finite"):
            svr.fit_svr(K, y, 1.0, 0.1)
    with pytest.raises(svr.SVRError, match="needed C > 0"):
        svr.fit_svr(np.eye(3)[None], np.zeros((1, 3)), 0.0, 0.1)
    Z, y = problem(0)
    with pytest.raises(svr.SVRError, match="after 3 steps"):
        svr.fit_svr(regress.gaussian_kernel(Z, Z, 0.3)[None], y[None], 1.0, 0.1, steps=3)


@pytest.mark.parametrize("kind", regress.MODELS[1:])
def test_models_learn(kind):
    rng = np.random.default_rng(0)
    Z = rng.normal(size=(150, 3))
    Y = (np.stack([Z[:, 0], Z[:, 1] - Z[:, 2] + 4, 0.3 * Z[:, 2]], axis=1)
         + 0.02 * rng.normal(size=(150, 3)))
    model = regress.fit_model(kind, Z[:110], Y[:110], rng)
    assert ((regress.predict(model, Z[110:]) - Y[110:]) ** 2).mean() < 0.03
    assert len(model.chosen) == 3


def test_model_errors():
    rng = np.random.default_rng(0)
    with pytest.raises(regress.RegressError, match="kind: found 'forest'"):
        regress.fit_model("forest", np.zeros((9, 3)), np.zeros((9, 3)), rng)
    with pytest.raises(regress.RegressError, match="9 and 8 examples"):
        regress.fit_model("kernel ridge", np.zeros((9, 3)), np.zeros((8, 3)), rng)
    with pytest.raises(regress.RegressError, match=r"shapes \(9,\) and \(9, 3\)"):
        regress.fit_model("linear ridge", np.zeros(9), np.zeros((9, 3)), rng)
    for ridge in (0.0, -1.0, np.nan):
        with pytest.raises(regress.RegressError, match="ridge: found"):
            regress.linear_ridge(np.eye(3), np.zeros(3), ridge)
        with pytest.raises(regress.RegressError, match="ridge: found"):
            regress.kernel_ridge(np.eye(3), np.zeros(3), ridge)
    Z, y = problem(0)
    model = regress.fit_model("linear ridge", Z, np.stack([y] * 3, axis=1), rng)
    with pytest.raises(regress.RegressError, match=r"Z: found shape \(2, 3\), needed \(M, 4\)"):
        regress.predict(model, np.zeros((2, 3)))


@pytest.mark.parametrize("kind", regress.MODELS)
def test_fit_model_is_fit_with_what_it_chose(kind):
    rng = np.random.default_rng(0)
    Z, Y = rng.normal(size=(30, 13)), rng.normal(size=(30, 3))
    model = regress.fit_model(kind, Z, Y, rng)
    again = regress.fit_with(kind, Z, Y, model.chosen or [{}] * 3)
    np.testing.assert_array_equal(regress.predict(again, Z[:5]), regress.predict(model, Z[:5]))


def test_a_constant_added_to_the_labels_comes_back():
    """No ridge pulls at the constant: every model's predictions move with the labels."""
    rng = np.random.default_rng(0)
    Z, Y = rng.normal(size=(20, 4)), rng.normal(size=(20, 3))
    for kind, chosen in (("linear ridge", {"lambda": 50.0}),
                         ("kernel ridge", {"gamma": 0.1, "lambda": 50.0}),
                         ("support vector", {"gamma": 0.1, "C": 1.0, "epsilon": 0.1})):
        first, second = (regress.predict(regress.fit_with(kind, Z, labels, [chosen] * 3,
                                                          tolerance=1e-9), Z)
                         for labels in (Y, Y + 40))
        np.testing.assert_allclose(second - first, 40, atol=1e-6)


def test_scikit_learn_agrees_on_kernel_ridge():
    witness = pytest.importorskip("sklearn.kernel_ridge")
    Z, y = problem(8)
    new = np.random.default_rng(0).normal(size=(10, 4))
    found = (regress.gaussian_kernel(new, Z,
                                     0.3) @ regress.kernel_ridge(regress.gaussian_kernel(Z, Z, 0.3),
                                                                 y, 0.05))
    np.testing.assert_allclose(found,
                               witness.KernelRidge(kernel="rbf", gamma=0.3,
                                                   alpha=0.05).fit(Z, y).predict(new), atol=1e-10)


def test_scikit_learn_agrees_on_svr():
    witness = pytest.importorskip("sklearn.svm")
    new = np.random.default_rng(0).normal(size=(10, 4))
    for seed, C, epsilon in ((0, 1.0, 0.1), (1, 20.0, 0.02), (2, 0.2, 0.4)):
        Z, y = problem(seed)
        K = regress.gaussian_kernel(Z, Z, 0.3)
        beta, b = (x[0] for x in svr.fit_svr(K[None], y[None], C, epsilon, tolerance=1e-9))
        machine = witness.SVR(gamma=0.3, C=C, epsilon=epsilon, tol=1e-9).fit(Z, y)
        theirs = np.zeros(len(y))
        theirs[machine.support_] = machine.dual_coef_[0]
        assert (svr.dual_objective(K, y, beta, epsilon)
                == pytest.approx(svr.dual_objective(K, y, theirs, epsilon), abs=1e-7))
        np.testing.assert_allclose(svr.predict_svr(regress.gaussian_kernel(new, Z, 0.3), beta, b),
                                   machine.predict(new), atol=1e-5)


def test_scikit_learn_agrees_on_pca():
    witness = pytest.importorskip("sklearn.decomposition")
    sequences = list(np.random.default_rng(0).normal(size=(12, 8, 3)))
    projection = pca.fit_pca(sequences, 3, 8)
    found = np.array([pca.pca_scores(projection, sequence) for sequence in sequences])
    needed = witness.PCA(3).fit_transform(np.stack([sequence.ravel() for sequence in sequences]))
    np.testing.assert_allclose(np.abs(found), np.abs(needed), atol=1e-9)
