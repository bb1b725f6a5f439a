"""Functions of PyTorch and JAX come to the kit in a few lines, and are judged as what they are."""

from collections import Counter
import doctest
import importlib

import numpy as np
import pytest

from refimpl.conformance import OPERATIONS, as_backend, case, cases, judge, judge_all
from refimpl.conformance.adapted import adapted, differentiated

IN_FIVE_LINES = {
    "torch, a function": """\
from refimpl.adapters.torch import backend
BACKEND = backend(gram=lambda h: h @ h.mT, avg_depool1d=lambda h, width=2:
                  h.repeat_interleave(width, -1) / width)
""",
    "torch, a torch.autograd.Function": """\
from refimpl.adapters.torch import backend
from tests.adapters.torch_functions import SquaredError, SumSquares
BACKEND = backend(squared_error=SquaredError, sum_squares=SumSquares)
""",
    "torch, a module": """\
from torch import nn
from refimpl.adapters.torch import backend
BACKEND = backend(encode=nn.Sequential(
    nn.Conv1d(66, 256, 25, padding="same"), nn.MaxPool1d(2), nn.ReLU()))
""",
    "jax, a function": """\
from refimpl.adapters.jax import backend
BACKEND = backend(gram=lambda h: h @ h.mT)
"""}


def made_by(text):
    """The BACKEND of a user's file; skipped where its library is missing."""
    pytest.importorskip("torch" if "adapters.torch" in text else "jax")
    found = {}
    exec(text, found)
    return found["BACKEND"]


def grades(backend, profile="small", most=200):
    """{(function, grade): number}"""
    names = [name for name in OPERATIONS if name in backend]
    every = judge_all(backend, cases(operations=names, profile=profile)[:most])
    return Counter((outcome.case.function, outcome.grade) for outcome in every)


@pytest.fixture
def torch():
    return pytest.importorskip("torch")


@pytest.fixture
def torch_backend(torch):
    from refimpl.adapters.torch import backend
    return backend


@pytest.fixture
def jax_backend():
    pytest.importorskip("jax")
    from refimpl.adapters.jax import backend
    return backend


@pytest.mark.filterwarnings("ignore:Using padding='same'", "ignore:Using a target size")
@pytest.mark.parametrize("which", IN_FIVE_LINES)
def test_five_lines_are_judged_right(which):
    text = IN_FIVE_LINES[which]
    backend = made_by(text)
    assert len(text.splitlines()) <= 5
    found = grades(backend)
    functions = set(as_backend(backend).functions)
    assert {f for f in functions if f.endswith("_backward")}
    assert {f for f, grade in found if grade == "agrees"} == functions
    assert {grade for _, grade in found} <= {"agrees", "laxer"}
    for f in functions:                                          # in both precisions
        name = f.removesuffix("_backward")
        way = "backward" if f != name else "forward"
        label = OPERATIONS[name].samples(np.random.default_rng(0))[0].label
        for precision in ("float64", "float32"):
            assert judge(case(f"{name}/{label}/{way}/{precision}"), backend).grade == "agrees"


@pytest.mark.filterwarnings("ignore:Using padding='same'")
def test_wrong_gradients_are_convicted(torch, torch_backend):
    from tests.adapters.torch_functions import HalfOfGram
    F = torch.nn.functional

    class Frozen(torch.nn.Conv1d):                               # its bias learns nothing
        def forward(self, X):
            return F.relu(F.max_pool1d(F.conv1d(X, self.weight, self.bias.detach(),
                                                padding="same"), 2))
    found = grades(torch_backend(gram=HalfOfGram, encode=Frozen(66, 4, 5)))
    for name, grade in ("gram", "convention"), ("encode", "wrong"):
        assert found[f"{name}_backward", grade] >= 10 and found[name, "agrees"] >= 10
        assert found[name, grade] == 0


def test_a_wrong_gradient_of_jax_is_convicted(jax_backend):
    import jax
    half_of_gram = jax.custom_vjp(lambda h: h @ h.mT)
    half_of_gram.defvjp(lambda h: (h @ h.mT, h), lambda h, dy: (dy @ h,))
    found = grades(jax_backend(gram=half_of_gram))
    assert found["gram_backward", "convention"] >= 10 and found["gram", "agrees"] >= 10


def strange_layouts(x):
    frozen = x.copy()
    frozen.flags.writeable = False
    return {"read-only": frozen, "negative strides": np.flip(np.flip(x).copy()),
            "Fortran order": np.asfortranarray(x), "stride 0": np.broadcast_to(x[:1], x.shape)}


@pytest.mark.parametrize("library", ["torch", "jax"])
@pytest.mark.parametrize("layout", ["read-only", "negative strides", "Fortran order", "stride 0"])
def test_any_array_goes_in_and_memory_of_its_own_comes_out(library, layout, request):
    made = request.getfixturevalue(f"{library}_backend")(relu=lambda x: x)      # hands back its own
    for dtype in (np.float64, np.float32):
        x = strange_layouts(np.arange(1, 7, dtype=dtype).reshape(2, 3))[layout]
        before = x.copy()
        for y in (made["relu"](x), made["relu_backward"](x, np.ones_like(x))):
            assert y.dtype == dtype and np.array_equal(y, before) and y.flags.c_contiguous
            assert y.flags.writeable and not np.shares_memory(x, y)
            y += 1
        assert np.array_equal(x, before)


@pytest.mark.parametrize("library", ["torch", "jax"])
def test_what_is_refused_stays_an_exception(library, request):
    class Refused(Exception):
        pass

    def refusing(h):
        raise Refused("not for me")
    made = request.getfixturevalue(f"{library}_backend")(gram=refusing)
    with pytest.raises(Refused, match="not for me"):
        made["gram"](np.ones((1, 2, 3)))
    with pytest.raises(Refused, match="not for me"):
        made["gram_backward"](np.ones((1, 2, 2)), np.ones((1, 2, 3)))


@pytest.mark.parametrize("library", ["torch", "jax"])
def test_constants_and_what_is_left_out_have_no_gradient(library, request):
    make = request.getfixturevalue(f"{library}_backend")

    def conv1d(x, w, b=None, *, scale):
        return (x * w).sum() * scale + (0 if b is None else b.sum())
    made = make(conv1d=conv1d,
                foot_loss=lambda motion, contacts: (motion * contacts).sum(),
                squared_error=lambda x, y: (x * x).sum())
    x, w = np.array([1.0, 2]), np.array([3.0, 5])
    for left_out in ((None,), ()):
        dx, dw, db = made["conv1d_backward"](np.array(1.0), x, w, *left_out, scale=2.0)
        assert np.array_equal(dx, 2 * w) and np.array_equal(dw, 2 * x) and db is None
    dx, dy = made["squared_error_backward"](np.array(1.0), x, w)         # of what is not used
    assert np.array_equal(dx, 2 * x) and np.array_equal(dy, [0.0, 0])
    for contacts in (np.array([True, False]), np.array([1.0, 0])):
        assert np.array_equal(made["foot_loss_backward"](np.array(3.0), x, contacts), [3.0, 0])


def test_what_is_written_into_an_argument_is_told(torch_backend):
    made = torch_backend(relu=lambda x: x.relu_())
    for way in ("forward", "backward"):
        message = judge(case(f"relu/plain/{way}/float64"), made).message
        assert f"relu/plain/{way}/float64: changed its argument x" in message
    frozen = np.full(2, -1.0)
    frozen.flags.writeable = False
    with pytest.raises(ValueError, match="read-only"):
        made["relu"](frozen)


def test_gradients_are_made_where_the_program_switched_them_off(torch, torch_backend):
    made = torch_backend(sum_squares=lambda r: r.sum(1))
    with torch.no_grad():
        dr = made["sum_squares_backward"](np.array([3.0, 5]), np.ones((2, 3)))
    assert np.array_equal(dr, [[3.0] * 3, [5.0] * 3])
    assert dr.flags.writeable and 0 not in dr.strides            # no element stands for others


def test_a_gradient_written_by_hand_is_judged_instead(torch_backend):
    made = torch_backend(gram=lambda h: h.detach() @ h.mT, tolerances={"float32": 1e-4},
                         gram_backward=lambda dy, h: (dy + dy.mT) @ h)
    assert as_backend(made).tolerances["float32"] == 1e-4
    assert {grade for _, grade in grades(made)} <= {"agrees", "laxer"}


def test_half_precision_is_judged_by_its_own_profile(torch, torch_backend):
    whole = torch_backend(max_unpool1d=lambda h, at, length: at, dtype=torch.bfloat16)
    assert whole["max_unpool1d"](np.ones(1, "float32"), np.array([301]), 1) == 301
    made = torch_backend(gram=lambda h: h @ h.mT, dtype=torch.bfloat16)
    assert made["lacks"] == ["float64"]
    assert made["gram"](np.ones((1, 2, 3), "float32")).dtype == np.float32
    found = grades(made, "bfloat16")
    assert found["gram", "agrees"] >= 10 and found["gram_backward", "agrees"] >= 10
    assert {grade for _, grade in found} == {"agrees"}
    assert grades(made)["gram", "wrong"] >= 2                    # too coarse for float32


def test_half_precision_of_jax(jax_backend):
    whole = jax_backend(max_unpool1d=lambda h, at, length: at, dtype="bfloat16")
    assert whole["max_unpool1d"](np.ones(1, "float32"), np.array([301]), 1) == 301
    made = jax_backend(gram=lambda h: h @ h.mT, dtype="bfloat16", device="cpu")
    assert made["lacks"] == ["float64"]
    assert {grade for _, grade in grades(made, "bfloat16", 8)} == {"agrees"}


def test_a_device_without_float64_lacks_it(torch, torch_backend, monkeypatch):
    zeros = torch.zeros

    def of_single_alone(*shape, dtype=None, **k):
        if dtype == torch.float64:
            raise TypeError("Cannot convert a MPS Tensor to float64 dtype")
        return zeros(*shape, dtype=dtype, **k)
    monkeypatch.setattr(torch, "zeros", of_single_alone)
    made = torch_backend(gram=lambda h: h @ h.mT, lacks=["gram_backward"])
    assert made["lacks"] == ["float64", "gram_backward"]
    assert {grade for _, grade in grades(made)} == {"agrees", "not offered", "laxer"}


def test_single_precision_of_jax_runs_as_without_the_kit(jax_backend):
    from jax import numpy as jnp
    seen = []
    made = jax_backend(relu=lambda x: seen.append(jnp.zeros(3).dtype.name) or x)
    for dtype in (np.float32, np.float64, np.float32):
        assert made["relu"](np.ones(2, dtype)).dtype == dtype
    assert seen == ["float32", "float64", "float32"] and jnp.zeros(3).dtype == np.float32


@pytest.mark.parametrize("library", ["torch", "jax"])
def test_names_that_are_no_operation_are_refused(library, request):
    make = request.getfixturevalue(f"{library}_backend")
    for name in ("gramm", "gramm_backward"):
        with pytest.raises(ValueError, match="found 'gramm', needed .*do you mean gram?"):
            make(**{name: lambda h: h})


def test_what_is_no_function_is_refused(torch, torch_backend):
    with pytest.raises(ValueError, match="gram: found .*Linear.*needed a function"):
        torch_backend(gram=torch.nn.Linear)
    with pytest.raises(ValueError, match="encode: found a module of 4 parameters .*X, W0, b0"):
        torch_backend(encode=torch.nn.Sequential(torch.nn.Linear(1, 1), torch.nn.Linear(1, 1)))


def test_a_module_keeps_its_own_parameters_and_its_buffers_follow(torch, torch_backend):
    class Shifted(torch.nn.Conv1d):
        def __init__(self):
            super().__init__(3, 4, 5, padding="same")
            self.register_buffer("shift", torch.ones(4, 1))

        def forward(self, X):
            assert self.shift.dtype == X.dtype
            return super().forward(X) + self.shift
    module = Shifted()
    kept = {key: value.clone() for key, value in module.state_dict().items()}
    made = torch_backend(encode=module)
    X, W, b = np.ones((1, 3, 6)), np.ones((4, 3, 5)), np.arange(4.0)
    assert made["encode"](X, W, b)[0, 2, 3] == 15 + 2 + 1
    dX, dW, db = made["encode_backward"](np.ones((1, 4, 6)), X, W, b)
    assert (dX.shape, dW.shape, db.tolist()) == (X.shape, W.shape, [6.0] * 4)
    assert all(torch.equal(value, kept[key]) for key, value in module.state_dict().items())
    assert all(p.grad is None for p in module.parameters())


def test_the_arguments_with_a_gradient_are_those_of_the_reference():
    for name, operation in OPERATIONS.items():
        if operation.backward:
            found = next(c for c in cases(operations=[name], profile="small")
                         if c.function.endswith("_backward") and c.kind == "float64")
            assert differentiated(operation) == len(found.expected), name
            assert all(np.shape(x) == np.shape(d)
                       for x, d in zip(found.arguments[1:], found.expected)), name


def test_gradients_are_made_where_there_are_some():
    made = adapted({"adam_step": len, "gram": len, "l1_backward": max, "l1": len, "lacks": ["l1"]},
                   lambda name, f: (name, f), lambda name, f, count: (name, f, count), ["float64"])
    assert made == {"lacks": ["float64", "l1"], "adam_step": ("adam_step", len),
                    "gram": ("gram", len), "gram_backward": ("gram", len, 1), "l1": ("l1", len),
                    "l1_backward": ("l1_backward", max)}


@pytest.mark.parametrize("library", ["torch", "jax"])
def test_examples(library):
    pytest.importorskip(library)
    module = importlib.import_module(f"refimpl.adapters.{library}")
    found = doctest.testmod(module)
    assert found.attempted and not found.failed
