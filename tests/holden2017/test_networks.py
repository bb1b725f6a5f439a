"""Equations 1 to 3 and the transformation network: shapes, identities, and gradients of every
parameter.
"""

import numpy as np
import pytest

from refimpl import nn
from refimpl.holden2017 import networks


@pytest.fixture
def rng():
    return np.random.default_rng(11)


def small_loss_network(rng, hidden=5, features=4, width=5):
    params = networks.init_loss_network(rng, hidden=hidden, width=width, features=features,
                                        dtype=float)
    params["b0"] = rng.normal(size=hidden) * 0.1
    return params


def test_initial_weights_lie_in_their_bounds(rng):
    W = networks.uniform_filters(rng, 256, 66, 25)
    bound = np.sqrt(6 / (66 * 25 + 256 * 25))
    assert W.shape == (256, 66, 25) and W.dtype == np.float32
    assert 0.99 * bound < np.abs(W).max() <= bound * (1 + 1e-6)


def test_shapes_of_the_paper(rng):
    params = networks.init_loss_network(rng)
    X = rng.normal(size=(1, 66, 24)).astype(np.float32)
    H = networks.encode(X, params)
    assert H.shape == (1, 256, 12) and H.dtype == np.float32 and (H >= 0).all()
    assert networks.decode(H, params).shape == X.shape
    T = networks.init_transformation_network(rng)
    assert ({k: v.shape for k, v in T.items() if k[0] == "W"}
            == {"W1": (128, 66, 25), "W2": (128, 128, 25), "W3": (66, 128, 25)})
    assert networks.transformation(X, T).shape == X.shape


@pytest.mark.parametrize("frames", [1, 2, 7, 10])
def test_projection_keeps_any_length(rng, frames):
    params = small_loss_network(rng)
    assert networks.project(rng.normal(size=(2, 4, frames)), params).shape == (2, 4, frames)


def test_decode_is_the_adjoint_of_the_convolution_in_encode(rng):
    params = small_loss_network(rng)
    params["b0"][:] = 0
    X, H = rng.normal(size=(1, 4, 8)), rng.normal(size=(1, 5, 4))
    left = np.sum(nn.conv1d(X, params["W0"]) * nn.avg_depool1d(H))
    np.testing.assert_allclose(left, np.sum(X * networks.decode(H, params)))


def over_arrays(f, backward, names):
    """A function of dicts as a function of arrays, for the gradient checker."""
    def forward(x, *arrays):
        return f(x, dict(zip(names, arrays)))

    def back(d, x, *arrays):
        dx, gradients = backward(d, x, dict(zip(names, arrays)))
        return (dx, *(gradients[name] for name in names))
    return forward, back


@pytest.mark.parametrize("f, backward, shape", [
    (networks.encode, networks.encode_backward, (2, 4, 8)),
    (networks.encode, networks.encode_backward, (2, 4, 7)),
    (networks.decode, networks.decode_backward, (2, 5, 3))])
def test_loss_network_gradients(rng, f, backward, shape):
    params = small_loss_network(rng)
    nn.check_gradient(*over_arrays(f, backward, ("W0", "b0")), rng.normal(size=shape),
                      *params.values(), names=("input", "W0", "b0"))


def test_gradients_to_the_input_alone_are_the_same(rng):
    params = small_loss_network(rng)
    X, dH = rng.normal(size=(2, 4, 8)), rng.normal(size=(2, 5, 4))
    np.testing.assert_allclose(networks.encode_backward_to_input(dH, X, params),
                               networks.encode_backward(dH, X, params)[0], atol=1e-13)
    H, dX = rng.normal(size=(2, 5, 4)), rng.normal(size=(2, 4, 8))
    np.testing.assert_allclose(networks.decode_backward_to_input(dX, H, params),
                               networks.decode_backward(dX, H, params)[0], atol=1e-13)


@pytest.mark.parametrize("mean", [True, False])
@pytest.mark.parametrize("noisy", [True, False])
def test_autoencoder_loss_gradients(rng, mean, noisy):
    params = small_loss_network(rng)
    settings = dict(alpha=0.3, mean=mean, noisy=rng.normal(size=(2, 4, 8)) if noisy else None)
    f, back = over_arrays(lambda x, p: networks.autoencoder_loss(x, p, **settings), lambda d, x,
                          p: networks.autoencoder_loss_backward(d, x, p, **settings), ("W0", "b0"))
    nn.check_gradient(f, back, rng.normal(size=(2, 4, 8)), *params.values(),
                      names=("X", "W0", "b0"))


def test_autoencoder_loss_is_equation_3(rng):
    params = small_loss_network(rng)
    X = rng.normal(size=(2, 4, 8))
    error = X - networks.decode(networks.encode(X, params), params)
    absolute = np.abs(params["W0"]).sum() + np.abs(params["b0"]).sum()
    np.testing.assert_allclose(networks.autoencoder_loss(X, params, alpha=0.5, mean=False),
                               (error ** 2).sum() + 0.5 * absolute)
    np.testing.assert_allclose(networks.autoencoder_loss(X, params, alpha=0.5),
                               (error ** 2).mean() + 0.5 * absolute / 105)


def test_transformation_network_gradients(rng):
    params = networks.init_transformation_network(rng, channels=3, width=3, features=4, dtype=float)
    params = {name: p + 0.1 * rng.normal(size=p.shape) for name, p in params.items()}
    names = tuple(params)
    both = over_arrays(networks.transformation, networks.transformation_backward, names)
    nn.check_gradient(*both, rng.normal(size=(2, 4, 6)), *params.values(), names=("X", *names))
