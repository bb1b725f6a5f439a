"""What people bring to the doors, as somebody would write it who knows the README and a stub."""

from collections import Counter
import functools

import numpy as np
import pytest

from refimpl.conformance import OPERATIONS, cases, judge_all


def grades(backend):
    """{(function, grade): number} in the small profile, without what is refused."""
    names = [name for name in OPERATIONS if name in backend]
    every = judge_all(backend, (case for case in cases(operations=names, profile="small")
                                if case.kind != "refused"))
    return Counter((outcome.case.function, outcome.grade) for outcome in every)


def messages(backend, *functions, kind=""):
    """What is said of the failures of some functions."""
    chosen = [case for case in cases(operations=list({f.removesuffix("_backward")
                                                      for f in functions}), profile="small")
              if case.function in functions and kind in case.kind and case.kind != "refused"]
    return [o.message for o in judge_all(backend, chosen) if o.status == "failed"]


@pytest.fixture
def torch():
    return pytest.importorskip("torch")


@pytest.fixture
def door(torch):
    from refimpl.adapters.torch import backend
    return backend


@pytest.fixture
def jax_door():
    pytest.importorskip("jax")
    from refimpl.adapters.jax import backend
    return backend


def adam(sqrt, p, g, m, v, *, t, rate=1e-3, beta1=0.9, beta2=0.999, epsilon=1e-8):
    m, v = beta1 * m + (1 - beta1) * g, beta2 * v + (1 - beta2) * g * g
    return p - rate * m / (1 - beta1 ** t) / (sqrt(v / (1 - beta2 ** t)) + epsilon), m, v


def test_functions_of_all_sorts_agree(torch, door):
    one = torch.ones((), requires_grad=True)                     # left on somewhere else

    class Holder:
        def __call__(self, h):
            return h @ h.mT

    def several(*arguments, **options):
        return list(adam(torch.sqrt, *arguments, **options))     # a list of outputs

    def depool(h, width=2):                                      # a view of one element for many
        return (h / width)[..., None].expand(*h.shape, width).flatten(2)

    def chosen_alone(h, chosen, width=2):                        # whole numbers have no gradient
        at = chosen.long()[..., None] == torch.arange(width)
        return torch.where(at, h[..., None], h.new_zeros(())).flatten(2)
    for made in (door(gram=Holder(), adam_step=several, avg_depool1d=depool, device="cpu",
                      random_depool1d=chosen_alone),
                 door(gram=lambda h: (h @ h.mT).mT * one.to(h.dtype), device=torch.device("cpu"),
                      sum_squares=torch.vmap(lambda r: r.square().sum()))):
        assert {grade for _, grade in grades(made)} == {"agrees"}


def test_modules_of_all_sorts_agree(torch, door):
    F = torch.nn.functional

    class Encoder(torch.nn.Module):
        def __init__(self):
            super().__init__()
            self.filters = torch.nn.Parameter(torch.zeros(5, 66, 3))
            self.shift = torch.nn.Parameter(torch.zeros(5))
            self.register_buffer("calls", torch.zeros(()))

        def forward(self, X):
            self.calls += 1
            width = self.filters.shape[2]
            X = F.pad(X, ((width - 1) // 2, width // 2))
            return torch.relu(F.max_pool1d(F.conv1d(X, self.filters, self.shift), 2))
    frozen = Encoder().double().eval()
    for parameter in frozen.parameters():
        parameter.requires_grad_(False)
    quiet = torch.nn.Sequential(torch.nn.Dropout(0.5), Encoder()).eval()
    for module in (Encoder(), frozen, quiet):
        assert {grade for _, grade in grades(door(encode=module))} == {"agrees"}
    assert not frozen.filters.any() and frozen.filters.dtype == torch.float64


def test_a_module_that_cannot_stand_for_the_arguments_is_told_at_the_door(torch, door):
    Conv1d = functools.partial(torch.nn.Conv1d, 66, 3, 3, padding="same")

    class BiasFirst(torch.nn.Module):
        def __init__(self):
            super().__init__()
            self.bias = torch.nn.Parameter(torch.zeros(3))
            self.filters = torch.nn.Parameter(torch.zeros(3, 66, 3))

        def forward(self, X):
            return X
    weighed = torch.nn.utils.parametrizations.weight_norm(Conv1d())
    for module in (BiasFirst(), Conv1d(bias=False), weighed):
        with pytest.raises(ValueError, match="encode: found a module of . parameters .*the last "
                                             "of X, W0, b0, in this order.*give a function"):
            door(encode=module)
    with pytest.raises(ValueError, match="transform: found a module of 2 parameters"):
        door(transform=Conv1d())
    noisy = torch.nn.Sequential(torch.nn.Dropout(0.5), Conv1d())
    with pytest.raises(ValueError, match=r"encode: found dropout in training mode \(0\).*eval"):
        door(encode=noisy)


@pytest.mark.filterwarnings("ignore:Converting a tensor with requires_grad")
def test_an_answer_without_a_graph_is_told(torch, door):
    without_graph = {
        "gram": [torch.no_grad()(lambda h: h @ h.mT), torch.inference_mode()(lambda h: h @ h.mT),
                 lambda h: (h @ h.mT).detach(),
                 lambda h: np.einsum("nct,ndt->ncd", *2 * [h.detach().numpy()])],
        "l1": [lambda a: float(a.abs().sum())]}
    for name, functions in without_graph.items():
        for function in functions:
            found = messages(door(**{name: function}), f"{name}_backward", kind="float64")
            assert found and all(f"{name}: found an answer that autograd cannot follow" in m
                                 and f"{name}_backward=" in m for m in found)


def test_layouts_reach_the_function(torch, door):
    def packed(x):                                               # as a kernel that asks no strides
        return torch.as_strided(x, x.shape, torch.empty(x.shape).stride())

    class OfPackedGradients(torch.autograd.Function):
        @staticmethod
        def forward(ctx, h):
            ctx.save_for_backward(h)
            return h @ h.mT

        @staticmethod
        def backward(ctx, dy):
            dy = packed(dy)
            return (dy + dy.mT) @ ctx.saved_tensors[0]
    found = grades(door(gram=lambda h: packed(h) @ packed(h).mT))
    assert found["gram", "wrong"] > 2 and found["gram_backward", "wrong"] > 2
    assert "Fortran order" in "".join(messages(door(gram=lambda h: packed(h) @ packed(h).mT),
                                               "gram_backward"))
    found = grades(door(gram=OfPackedGradients))
    assert found["gram_backward", "wrong"] and ("gram", "wrong") not in found


def test_a_function_that_wants_packed_tensors_is_stricter(door):
    def views(r):
        return r.view(len(r), r[:1].numel()).square().sum(1) if len(r) else r.flatten()
    found = grades(door(sum_squares=views))
    assert {grade for _, grade in found} == {"agrees", "stricter"}
    assert found["sum_squares", "stricter"] > 1 and found["sum_squares_backward", "stricter"] > 1


def test_words_for_precision_and_device(torch, door):
    assert door(dtype="bfloat16")["lacks"] == ["float64"]
    made = door(gram=lambda h: h @ h.mT, dtype="bfloat16")
    assert made["gram"](np.full((1, 1, 1), 1.01, "float32")) == 1.015625
    for device in ("gpu", "no such device"):
        with pytest.raises(ValueError, match=f"device: found '{device}', needed one that PyTorch"):
            door(gram=lambda h: h @ h.mT, device=device)


def test_functions_of_jax_of_all_sorts_agree(jax_door):
    import jax
    from jax import numpy as jnp
    squares = jax.custom_vjp(lambda r: jax.vmap(lambda one: jnp.square(one).sum())(r))
    squares.defvjp(lambda r: (squares(r), r),
                   lambda r, dy: (2 * r * jnp.expand_dims(dy, range(1, r.ndim)),))

    def depool(h, width=2):
        return jnp.repeat(h, width, axis=2) / width

    def chosen_alone(h, chosen, width=2):
        at = chosen[..., None] == jnp.arange(width)
        return jnp.where(at, h[..., None], 0).reshape(*h.shape[:2], -1)
    made = jax_door(gram=jax.jit(lambda h: h @ h.mT), sum_squares=jax.jit(squares),
                    adam_step=jax.jit(lambda *x, **k: adam(jnp.sqrt, *x, **k)), device="cpu",
                    avg_depool1d=jax.jit(depool, static_argnames="width"))
    for wide in (False, True):                     # whether the program switched float64 on or not
        with jax.enable_x64(wide):
            assert {grade for _, grade in grades(made)} == {"agrees"}
            h, chosen = np.ones((1, 1, 2), "float32"), np.array([[[1, 0]]])
            dh = jax_door(random_depool1d=chosen_alone)["random_depool1d_backward"](
                np.arange(4, dtype="float32").reshape(1, 1, 4), h, chosen)
            assert dh.dtype == np.float32 and dh.tolist() == [[[1, 2]]]


def test_what_jax_is_known_for_is_named(jax_door):
    from jax import lax, numpy as jnp
    found = grades(jax_door(relu=lambda x: jnp.maximum(x, 0),
                            gram=lambda h: h @ lax.stop_gradient(h).mT))
    assert found["relu_backward", "convention"] and found["gram_backward", "convention"]
    assert {grade for f, grade in found if not f.endswith("_backward")} == {"agrees"}
    found = messages(jax_door(gram=lambda h: np.asarray(h) @ np.asarray(h).swapaxes(1, 2)),
                     "gram_backward", kind="float64")
    assert found and all("TracerArrayConversionError" in m for m in found)
