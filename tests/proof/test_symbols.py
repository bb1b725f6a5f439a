"""Gradient = derivative and text = definition, as formulas: for all numbers, not for samples."""

import inspect
import types

import numpy as np
import pytest

from refimpl import nn
from refimpl.conformance.backend import OPERATIONS
from refimpl.conformance.functions_holden import spelled_out
from refimpl.holden2017 import losses, networks
from refimpl.nn import conv, norms, pool

pytest.importorskip("sympy", reason="the proofs need the package sympy")

from tests.proof.claims import CLAIMS, PIECEWISE, drawn, evaluated
from tests.proof.symbolic import difference, expression, germs, symbols

# What a gradient may be off by: each must be seen in each gradient that it changes.
FAULTS = {"a factor": lambda g: 2 * g,
          "a sign": lambda g: -g,
          "one frame late": lambda g: np.roll(g, 1, -1),
          "one channel late": lambda g: np.roll(g, 1, g.ndim > 1),
          "no last element": lambda g: np.append(g.ravel()[:-1], 0).reshape(g.shape)}
# Of the kit's operations with a gradient, those that nothing is claimed of.
NOT_PROVED = {
    "total_loss": "the sum of what is proved here, with weights that are floating-point numbers",
    "autoencoder_loss_2016": "weights that are floating-point numbers",
    "foot_loss_2016": "the same", "bone_loss_2016": "the same", "trajectory_loss_2016": "the same",
    "constraint_loss_2016": "the same", "decode_untied": "it is `decode` with filters of its own"}


@pytest.mark.parametrize("claim", CLAIMS, ids=str)
def test_the_text_is_its_definition_and_its_gradient_the_derivative(claim):
    y, again, gradients, derivatives = evaluated(claim)
    assert difference(y, again) is None
    for found, needed in zip(gradients, derivatives, strict=True):
        assert difference(found, needed) is None
        for name, fault in FAULTS.items():
            wrong = fault(found)
            if any(expression(a) != expression(b) for a, b in zip(wrong.flat, found.flat)):
                assert difference(wrong, needed) is not None, name


def test_every_operation_with_a_gradient_is_proved_at_several_shapes_or_said_not_to_be():
    times = {name: len({claim.inputs[0] for claim in CLAIMS if claim.operation == name})
             for name, operation in OPERATIONS.items() if operation.backward}
    assert {name for name, n in times.items() if n < 2} == set(NOT_PROVED)
    assert not any(times[name] for name in NOT_PROVED)
    assert len({str(claim).partition(" near")[0] for claim in CLAIMS}) >= 70


def planted(module, right, wrong):
    """The module with one place of its text changed."""
    text = inspect.getsource(module)
    assert text.count(right) == 1, right
    changed = types.ModuleType(module.__name__)
    changed.__package__ = module.__package__
    exec(compile(text.replace(right, wrong), module.__file__, "exec"), vars(changed))
    return changed


def claimed(operation, number=0):
    """One of the claims about an operation."""
    return [claim for claim in CLAIMS if claim.operation == operation][number]


@pytest.mark.parametrize("claim, module, right, wrong", [
    (claimed("conv1d", 3), conv, "padded[:, :, pad[0]:pad[0] + length]",
     "padded[:, :, pad[1]:pad[1] + length]"),
    (claimed("conv1d"), conv, "in taps.transpose(0, 2, 3, 1, 4)",
     "in taps[::-1].transpose(0, 2, 3, 1, 4)"),
    (claimed("conv_transpose1d"), conv, "dw = _filter_gradient(h, padded, w, *steps)",
     "dw = _filter_gradient(h, padded[:, :, ::-1], w, *steps)"),
    (claimed("avg_pool1d", 3), pool, "share = dy / in_precision(counted.sum(axis=1), x)",
     "share = dy / in_precision(width, x)"),
    (claimed("gram", 1), nn.gram, "(dG + dG.swapaxes(1, 2)) @ h", "(dG + dG) @ h"),
    (claimed("mean_squares"), norms, "2 * _share(r, _spread(dM, r), math.prod(r.shape[1:]))",
     "2 * _share(r, _spread(dM, r), math.prod(r.shape))"),
    (claimed("norm"), norms, "_spread(dy, r) * (part / ", "_spread(dy, r) * (r * r / "),
    (claimed("style_loss"), losses, "nn.gram_backward(-dG, H_output)",
     "nn.gram_backward(dG, H_output)"),
    (claimed("foot_loss"), losses, "dp[..., :-1] -= dv", "dp[..., :-1] += dv"),
    (claimed("bone_loss"), losses, "dp[:, j2] -= d_bones[:, b]", "dp[:, j2] += d_bones[:, b]"),
    (claimed("trajectory_loss"), losses, "= weights * nn.sum_squares_backward(dloss, error)",
     "= nn.sum_squares_backward(dloss, error)"),
    (claimed("decode"), networks, '"b0": -wide_sum(dD, (0, 2))', '"b0": wide_sum(dD, (0, 2))'),
    (claimed("autoencoder_loss", 1), networks, "from_encoder[name] + from_decoder[name] + ",
     "from_encoder[name] + ")], ids=lambda value: getattr(value, "operation", ""))
def test_a_fault_in_the_text_of_a_gradient_fails_the_proof(claim, module, right, wrong):
    if module is nn.gram:
        module = inspect.getmodule(nn.gram)
    changed = vars(planted(module, right, wrong))
    backward = changed[f"{claim.operation}_backward"]
    if module is networks:
        backward = spelled_out(backward, "W0 b0", "")
    _, _, gradients, derivatives = evaluated(claim, backward)
    assert any(difference(*pair) is not None for pair in zip(gradients, derivatives))


def test_a_fault_in_the_text_of_an_operation_is_not_its_definition():
    flipped = planted(conv, "map(np.matmul, W, taps))", "map(np.matmul, W, taps[::-1]))").conv1d
    x, w = symbols("x", (1, 1, 4)), symbols("w", (1, 1, 3))
    assert difference(flipped(x, w), nn.conv1d(x, w)) == (0, 0, 0)


@pytest.mark.parametrize("operation", ["encode", "encode_2016", "transform", "autoencoder_loss"])
def test_the_points_have_units_that_are_at_work_and_units_that_are_not(operation, monkeypatch):
    at_work = []

    def noted(x, relu=nn.relu):
        at_work.extend(v.value > 0 for v in x.flat)
        return relu(x)
    monkeypatch.setattr(nn, "relu", noted)
    for claim in PIECEWISE:
        if claim.operation == operation:
            OPERATIONS[operation].f(*drawn(claim), **claim.options)
    assert set(at_work) == {True, False}


def test_a_point_on_the_edge_of_two_polynomials_is_refused():
    a, b = germs("x", (2,), np.random.default_rng(0))
    b.value = a.value
    with pytest.raises(ValueError, match="are equal at the point"):
        nn.max_pool1d(np.array([[[a, b]]]))
