"""The contract of a backward: each clause broken on purpose is named word for word, and what only
looks broken passes.
"""

import numpy as np
import pytest

from refimpl import nn

A, B = (np.array([[1.0, -2.0, 3.0], [0.5, 4.0, -1.0]]),
        np.array([[2.0, 1.0, -1.0], [3.0, 0.25, 5.0]]))


def product(a, b):
    return a * b


def right(dy, a, b):
    return dy * b, dy * a


def message(f, backward, *inputs, **options):
    with pytest.raises(nn.GradientError) as broken:
        nn.check_contract(f, backward, *inputs, **options)
    return str(broken.value)


def once_more(first, later):
    """A backward that is `first` on its first calls and `later` from a given call on: {call:
    backward}.
    """
    calls = []

    def backward(dy, *inputs):
        calls.append(None)
        return max((n, b) for n, b in [(0, first), *later.items()]
                   if n < len(calls))[1](dy, *inputs)
    return backward


def test_what_keeps_the_contract_passes():
    nn.check_contract(product, right, A, B)
    nn.check_contract(product, lambda dy, a, b: list(right(dy, a, b)), A, B, single=True,
                      batched=(0, 1))
    nn.check_contract(np.negative, lambda dy, x: -dy, A, single=True, batched=(0,))
    nn.check_contract(lambda x: x.sum(), lambda dy, x: np.full_like(x, dy), A, single=True)
    nn.check_contract(lambda x, power: x ** power, lambda dy, x,
                      power: (dy * power * x ** (power - 1), None), A, 2, single=True)
    nn.check_contract(lambda x, power: x ** power, lambda dy, x,
                      power: dy * power * x ** (power - 1), A, 2, single=True)
    nn.check_contract(np.negative, lambda dy, x: -dy, np.array(2.0))
    nn.check_contract(np.negative, lambda dy, x: -dy, np.zeros((0, 3)))


# what an argument must not suffer


def writes(place, value):
    def f(a, b):
        y = product(a, b)
        b[place] = value
        return y
    return f


def test_an_argument_that_changes_is_named_with_the_place():
    assert (message(writes((1, 2), 7.0), right, A, B)
            == "f: changed input 1 at [1, 2]; inputs are only to be read")
    assert (message(writes((1, 2), 7.0), right, A, B, names=("a", "b"))
            == "f: changed b at [1, 2]; inputs are only to be read")
    assert (message(writes((0, 0), np.nan), right, A, B)
            == "f: changed input 1 at [0, 0]; inputs are only to be read")
    # what was NaN and is NaN has not changed
    with_nan = np.where(B == 1, np.nan, B)
    assert (message(writes((1, 2), 7.0), right, A, with_nan)
            == "f: changed input 1 at [1, 2]; inputs are only to be read")
    with_zero = np.where(B == 1, 0.0, B)
    assert (message(writes((0, 1), -0.0), right, A, with_zero)
            == "f: changed input 1 at a sign bit; inputs are only to be read")


def test_the_backward_must_not_change_the_upstream_gradient_nor_an_input():
    def upstream(dy, a, b):
        gradients = right(dy, a, b)
        dy[0, 1] += 1
        return gradients

    def an_input(dy, a, b):
        gradients = right(dy, a, b)
        b[1, 0] += 1
        return gradients
    assert (message(product, upstream, A, B)
            == "f_backward: changed the upstream gradient at [0, 1]; inputs are only to be read")
    assert (message(product, an_input, A, B, names=("a", "b"))
            == "f_backward: changed b at [1, 0]; inputs are only to be read")


def test_a_write_that_changes_nothing_is_a_write():
    def f(a, b):
        a[0, 0] = a[0, 0]
        return product(a, b)
    assert (message(f, right, A, B)
            == ("f: tried to write to a read-only argument (assignment destination is read-only); "
                                       "inputs are only to be read"))


def test_an_error_of_the_function_itself_is_passed_on():
    def f(a, b):
        if not a.flags.writeable:
            raise ValueError("a: found what I do not like")
        return product(a, b)
    with pytest.raises(ValueError, match="^a: found what I do not like$"):
        nn.check_contract(f, right, A, B)


def test_arguments_that_are_no_arrays_are_left_alone():
    def f(x, places):
        return x[places]

    def backward(dy, x, places):
        dx = np.zeros_like(x)
        dx[places] = dy
        return dx
    nn.check_contract(f, backward, A, [1, 0])
    assert message(writes(0, 1), lambda dy, x, places: dy * places, A[0], np.array([3, 4, 5])) == \
        "f: changed input 1 at [0]; inputs are only to be read"


# what a gradient must be


def test_a_gradient_has_memory_of_its_own():
    def upstream(dy, a, b):
        return dy * b, dy[:]

    def the_second_input(dy, a, b):
        return b.T.T, dy * a

    def each_other(dy, a, b):
        return (dy * b,) * 2

    def read_only(dy, a, b):
        return dy * b, np.broadcast_to(dy * a, a.shape)
    assert (message(product, upstream, A, B)
            == "input 1: its gradient shares memory with the upstream gradient, needed memory of "
               "its own")
    assert (message(product, the_second_input, A, B)
            == "input 0: its gradient shares memory with input 1, needed memory of its own")
    assert (message(product, each_other, A, B, names=("a", "b"))
            == "b: its gradient shares memory with the gradient of a, needed memory of its own")
    assert (message(product, read_only, A, B)
            == "input 1: found a read-only gradient (np.broadcast_to?), needed memory of its own")
    # a NumPy number has its own
    nn.check_contract(lambda x, y: x * y, lambda dy, x, y: (np.sum(dy * y), dy * x), np.array(2.0),
                      A)
    assert message(lambda x, y: x * y, lambda dy, x, y: (np.sum(dy * y), dy), np.array(2.0), A) == \
        "input 1: its gradient shares memory with the upstream gradient, needed memory of its own"


def test_a_gradient_has_the_shape_and_type_of_its_input():
    assert message(product, lambda dy, a, b: (dy * b, (dy * a)[:1]), A, B) == \
        "input 1: found a gradient float64 (1, 3), needed float64 (2, 3), as its input"
    assert message(product, lambda dy, a, b: ((dy * b).astype(np.float32), dy * a), A, B) == \
        "input 0: found a gradient float32 (2, 3), needed float64 (2, 3), as its input"


def test_float32_is_tried_where_it_is_asked_for():
    def in_double(dy, a, b):
        return dy * np.asarray(b, float), dy * a
    nn.check_contract(product, in_double, A, B)
    assert (message(product, in_double, A, B, single=True)
            == "input 0: found a gradient float64 (2, 3), needed float32 (2, 3), as its input")

    def f(x, places):
        # only floating-point inputs become float32
        assert places.dtype == int
        return np.take(x, places)
    nn.check_contract(f, lambda dy, x, places: np.bincount(places, dy, len(x)).astype(x.dtype),
                      A[0], np.array([2, 2, 0]), single=True)


def test_all_of_it_in_float32():
    """Whatever is passed to the two functions has the precision of the inputs."""
    def alike(x):
        assert x.dtype == np.float32
        return 2 * x

    def backward(dy, x):
        assert dy.dtype == x.dtype == np.float32
        return 2 * dy
    nn.check_contract(alike, backward, A.astype(np.float32), batched=(0,))


# the same bits on every call


def test_a_gradient_is_the_same_on_every_call():
    def off(dy, a, b):
        return dy * b, dy * a * (1 + 1e-15)
    calls = {"on a second call with the same arguments": 4,
             "after a call with another upstream gradient": 6, "after calls with other inputs": 8}
    # two calls for what is left alone, one for memory and types, one for the first
    for when, call in calls.items():
        assert (message(product, once_more(right, {call: off}), A, B)
                == f"input 1: found another gradient {when}; needed the same bits")


def test_other_types_and_shapes_are_other_bits():
    def narrow(dy, a, b):
        return dy * b, (dy * a).astype(np.float32)

    def flat(dy, a, b):
        return dy * b, (dy * a).ravel()
    # the same bytes in every shape and type
    whole = np.zeros_like(A)
    for other in (narrow, flat):
        assert (message(product, once_more(right, {4: other}), whole, B) == \
            "input 1: found another gradient on a second call with the same arguments; needed the "
            "same bits")


def test_one_buffer_for_all_calls_is_seen_in_the_array_of_the_first():
    buffer = np.zeros_like(A)

    def backward(dy, a, b):
        buffer[...] = dy * a
        return dy * b, buffer
    assert (message(product, backward, A, B) == \
        "input 1: found another gradient later in the array of the first call (a buffer used "
        "twice?); needed the same bits")


def test_functions_that_take_special_inputs_only_are_let_off_other_inputs():
    def increasing(x):
        if (np.diff(x) < 0).any():
            raise ValueError("x: found a step down, needed increasing numbers")
        return x * 2
    nn.check_contract(increasing, lambda dy, x: dy * 2, np.array([1.0, 2.0, 5.0]))


def test_a_cache_keyed_by_nothing_is_found():
    seen = {}

    def backward(dy, a, b):
        return dy * b, dy * seen.setdefault(b"a", a.copy())
    # remembers the first forever: on these inputs right
    nn.check_contract(product, backward, A, B)
    remembered = []

    def latest(dy, a, b):
        remembered.append(a.copy())
        return dy * b, dy * remembered[max(0, len(remembered) - 2)]
    assert (message(product, latest, A, B)
            == "input 1: found another gradient after calls with other inputs; needed the same "
               "bits")


# linear, and blind to memory


def test_a_gradient_is_linear_in_the_upstream_gradient():
    def quadratic(dy, a, b):
        return dy * b, dy * a + 1e-9 * dy ** 2
    found = message(product, quadratic, A, B)
    assert found.startswith("input 1: its gradient is not linear in the upstream gradient (off by ")
    assert (found == message(product, quadratic, A, B, seed=0)
            != message(product, quadratic, A, B, seed=1))


@pytest.mark.parametrize("scale", [1e-6, 1.0, 1e6])
@pytest.mark.parametrize("off", [1.1e-12, 1e-9, 1e-6])
def test_linear_to_twelve_digits_of_the_largest_element(off, scale):
    """A constant c in the gradient is c (1 - 1.7 + 0.6) = -0.1 c off when two upstream gradients
    are mixed, 1.7 dy - 0.6 dy'.
    """
    rng = np.random.default_rng([0, 3])
    largest = 1.7 * np.abs(scale * rng.standard_normal(5)).max()

    def backward(dy, x, constant=10 * off * largest):
        dx = scale * dy
        dx[0] += constant
        return dx
    assert message(lambda x: scale * x, backward, np.arange(5.0), names=["x"]) == \
        ("x: its gradient is not linear in the upstream gradient "
         f"(off by {off * largest:.3g} at a size of {largest:.3g})")
    nn.check_contract(lambda x: scale * x, lambda dy, x: backward(dy, x, 1e-16 * largest),
                      np.arange(5.0))


@pytest.mark.parametrize("change, factor", [
    (np.abs, "-1"), (lambda dy: np.clip(dy, -5, 5), "1000"),
    (lambda dy: np.where(np.abs(dy) < 1e-2, 0, dy), "0.001")])
def test_multiples_of_the_upstream_gradient_of_a_single_number(change, factor):
    """A loss is one number: two of its upstream gradients often have one sign."""
    said = message(lambda x: np.sum(x ** 2), lambda dy, x: 2 * change(dy) * x, np.arange(1.0, 4.0),
                   names=["x"], seed=5)
    assert f"for {factor} times it, found another" in said or "(off by" in said


def test_an_upstream_gradient_of_stride_0_is_as_good_as_any():
    def strided(dy, a, b):
        return dy * b, dy * a if all(dy.strides) else 2 * dy * a
    assert (message(product, strided, A, B)
            == "input 1: found another gradient for an upstream gradient of stride 0 "
               "(np.broadcast_to)")


@pytest.mark.parametrize("layout, is_so", [
    ("Fortran order", lambda x: x.flags.f_contiguous and x.ndim > 1 and not x.flags.c_contiguous),
    ("every second element of a larger array",
     lambda x: x.strides == (12 * x.itemsize, 2 * x.itemsize)),
    ("negative strides", lambda x: x.strides[-1] < 0)])
def test_every_layout_is_tried(layout, is_so):
    def f(a, b):
        return product(a, b) * (1 + 1e-11 * bool(is_so(a)))

    def backward(dy, a, b):
        return dy * b, dy * a * (1 + 1e-11 * bool(is_so(a)))

    def of_the_upstream_gradient(dy, a, b):
        return dy * b, dy * a * (1 + 1e-11 * bool(is_so(dy)))
    for scale in (1e-6, 1.0):
        assert message(f, right, scale * A, B) == f"f: found another value for inputs in {layout}"
        for wrong in (backward, of_the_upstream_gradient):
            assert (message(product, wrong, scale * A, B)
                    == "input 1: found another gradient for inputs and upstream gradient in "
                       f"{layout}")


def test_the_order_of_a_sum_may_follow_the_layout():
    def backward(dy, a, b):
        return dy * b, dy * a * (1 + 1e-13 * (dy.strides[-1] < 0))
    nn.check_contract(product, backward, A, B)


# no clips at all


def test_a_batch_of_no_clips_gives_gradients_of_no_clips():
    weights = np.array([2.0, 1.0, -1.0])

    def weighted(x, w):
        return x * w

    def backward(dy, x, w):
        return dy * w, (dy * x).sum(axis=0)
    nn.check_contract(weighted, backward, A, weights, batched=(0,))

    def one_clip(dy, x, w):
        return (dy * w if len(dy) else np.zeros((1, 3))), (dy * x).sum(axis=0)

    def not_zero(dy, x, w):
        return dy * w, (dy * x).sum(axis=0) + (len(dy) == 0)
    nn.check_contract(weighted, one_clip, A, weights)
    assert message(weighted, one_clip, A, weights, batched=(0,)) == \
        "input 0: for a batch of 0 clips found a gradient of shape (1, 3), needed zeros of (0, 3)"
    assert message(weighted, not_zero, A, weights, batched=(0,)) == \
        "input 1: for a batch of 0 clips found a gradient of shape (3,), needed zeros of (3,)"
