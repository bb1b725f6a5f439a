"""Dynamic time warping against the enumeration of all paths and against other libraries;
interpolation exact at both ends.
"""

from dataclasses import replace
from functools import lru_cache

from hypothesis import given
from hypothesis import strategies as st
import numpy as np
import pytest

from refimpl.torresani2006 import align, poses
from refimpl.embedded import performers


def random_pair(seed, longest=6):
    rng = np.random.default_rng(seed)
    P, Q, D = rng.integers(1, longest, 3)
    return rng.integers(-3, 4, (P, D)).astype(float), rng.normal(size=(Q, D))


@lru_cache(maxsize=None)
def all_paths(P, Q):
    """Every path of equations 4 and 5, spelled out."""
    if (P, Q) == (1, 1):
        return (((0, 0),),)
    before = [(P - 1, Q), (P - 1, Q - 1), (P, Q - 1)]
    return tuple(path + ((P - 1, Q - 1),) for p, q in before if p and q for path in all_paths(p, q))


@given(st.integers(0, 10_000))
def test_all_paths(seed):
    X, Y = random_pair(seed)
    d = align.distances(X, Y)
    least = min(sum(d[cell] for cell in path) for path in all_paths(len(X), len(Y)))
    cost, path = align.dtw(X, Y)
    assert cost == pytest.approx(least, abs=1e-12)
    assert sum(d[p, q] for p, q in path) == pytest.approx(cost, abs=1e-12)
    assert tuple(map(tuple, path)) in all_paths(len(X), len(Y))


@given(st.integers(0, 10_000))
def test_fast_form_gives_the_same_bits(seed):
    X, Y = random_pair(seed, longest=30)
    C = align.dtw_definition(align.distances(X, Y))
    fast = align.accumulate(align.distances(X, Y)[None])
    assert all(fast[p + q, 0, p] == C[p, q] for p in range(len(X)) for q in range(len(Y)))
    assert align.dtw(X, Y)[0] == align.pair_costs([(X, Y)])[0] == C[-1, -1]


def test_many_pairs_of_all_lengths_at_once(monkeypatch):
    rng = np.random.default_rng(1)
    sequences = [rng.normal(size=(n, 4)) for n in (3, 40, 17, 1, 25, 40)]
    needed = [[align.dtw_definition(align.distances(X, Y))[-1, -1] for Y in sequences]
              for X in sequences]
    np.testing.assert_array_equal(align.all_pairs(sequences), needed)
    monkeypatch.setattr(align, "CELLS", 500)                             # many small chunks
    np.testing.assert_array_equal(align.all_pairs(sequences), needed)


@given(st.integers(0, 10_000))
def test_properties(seed):
    X, Y = random_pair(seed, longest=15)
    assert align.dtw(X, X)[0] == 0
    assert align.dtw(X, Y)[0] == align.dtw(Y, X)[0]
    assert align.dtw(X, Y)[0] == pytest.approx(align.dtw(X[::-1], Y[::-1])[0])
    assert align.dtw(X, np.repeat(X, 3, axis=0))[0] == 0                 # slower costs nothing


def test_dtaidistance_agrees():
    witness = pytest.importorskip("dtaidistance.dtw_ndim")
    for seed in range(10):
        X, Y = random_pair(seed, longest=40)
        assert align.dtw(X, Y)[0] == pytest.approx(witness.distance(X, Y) ** 2, abs=1e-9)


def test_dtw_python_agrees():
    witness = pytest.importorskip("dtw")
    for seed in range(10):
        X, Y = random_pair(seed, longest=40)
        if len(X) == 1 or len(Y) == 1:
            # it takes a single row for a cost matrix
            continue
        found = witness.dtw(align.distances(X, Y), step_pattern=witness.symmetric1)
        assert align.dtw(X, Y)[0] == pytest.approx(found.distance, abs=1e-9)


def test_clusters():
    ssd = np.array([[0, 1, 9, 9], [1, 0, 2, 9], [9, 2, 0, 9], [9, 9, 9, 0]], dtype=float)
    np.testing.assert_array_equal(align.clusters(ssd, 1.5), [0, 0, 1, 2])
    np.testing.assert_array_equal(align.clusters(ssd, 2.5), [0, 0, 0, 1])
    for count in range(1, 5):
        assert align.clusters(ssd, align.threshold_for(ssd, count)).max() + 1 == count
    with pytest.raises(align.AlignError, match="count: found 5"):
        align.threshold_for(ssd, 5)


@pytest.fixture(scope="module")
def pair():
    made = [performers.perform("step", number) for number in (0, 4)]
    body = poses.fit_body([performance.clip for performance in made])
    return tuple(poses.fragment_of(performance.clip, body, performance.name, "step")
                 for performance in made)


@pytest.mark.parametrize("smooth", [0.0, 2.0, align.SMOOTH])
def test_exact_at_both_ends(pair, smooth):
    for alpha, needed in zip((0, 1), pair):
        found = align.interpolate(*pair, alpha, smooth=smooth)
        np.testing.assert_allclose(found.angles, needed.angles, atol=1e-12)
        np.testing.assert_allclose(found.root, needed.root, atol=1e-10)


@given(st.integers(0, 10_000), st.floats(align.LOWEST, align.HIGHEST))
def test_timing(seed, alpha):
    rng = np.random.default_rng(seed)
    X, Y = (np.cumsum(rng.normal(size=(n, 2)), axis=0) for n in rng.integers(2, 40, 2))
    p, q = align.synchronised(align.dtw(X, Y)[1], alpha)
    if 0 <= alpha <= 1:
        assert len(p) == max(2, round((1 - alpha) * len(X) + alpha * len(Y)))
    for times, sequence in ((p, X), (q, Y)):
        assert times[0] == 0 and times[-1] == len(sequence) - 1
        assert (np.diff(times) > -1e-12).all()
    for end, times in ((0, align.synchronised(align.dtw(X, Y)[1], 0)[0]),
                       (1, align.synchronised(align.dtw(X, Y)[1], 1)[1])):
        np.testing.assert_allclose(times, np.arange(len((X, Y)[end])), atol=1e-12)


def test_half_way_by_hand():
    """One plays the same at half the speed: half-way the timing is between, the poses are the same,
    and so is the way.
    """
    slow = np.linspace(0, 1, 41)[:, None] * np.ones((1, 6))
    a = poses.Fragment("slow", "x", None, slow, np.zeros((41, 4)), 30.0)
    root = np.zeros((21, 4))
    root[:, 2] = np.linspace(0, 10, 21)
    b = poses.Fragment("fast", "x", None, slow[::2], root, 30.0)
    found = align.interpolate(a, b, 0.5)
    assert found.frames == 31
    np.testing.assert_allclose(found.angles[:, 0], np.linspace(0, 1, 31), atol=0.02)
    assert found.root[-1, 2] == pytest.approx(5.0)


def test_two_walkers_facing_apart_walk_between():
    """One walks along +z, one along +x: at one half the way is the diagonal and as long."""
    roots = np.zeros((2, 21, 4))
    roots[0, :, 2] = roots[1, :, 0] = np.arange(21)
    roots[1, :, 3] = np.pi / 2
    angles = np.linspace(0, 1, 21)[:, None] * np.ones((1, 3))
    found = align.interpolate(*(poses.Fragment("w", "w", None, angles, root, 30.0)
                                for root in roots), 0.5)
    np.testing.assert_allclose(found.root[-1], [20 * np.sqrt(0.5), 0, 20 * np.sqrt(0.5), np.pi / 4],
                               atol=1e-9)


def test_errors(pair):
    with pytest.raises(align.AlignError, match="alpha: found 1.3"):
        align.interpolate(*pair, 1.3)
    with pytest.raises(align.AlignError, match="2 and 3 angles"):
        align.dtw(np.zeros((4, 2)), np.zeros((4, 3)))
    with pytest.raises(align.AlignError, match="Y: found nan"):
        align.dtw(np.zeros((1, 1)), np.full((1, 1), np.nan))
    with pytest.raises(align.AlignError, match=r"X: found shape \(0, 2\)"):
        align.dtw(np.zeros((0, 2)), np.zeros((4, 2)))
    with pytest.raises(align.AlignError, match="Y: found dtype complex128"):
        align.dtw(np.zeros((4, 2)), np.zeros((4, 2), complex))
    with pytest.raises(align.AlignError, match=r"ssd: found shape \(2, 3\)"):
        align.clusters(np.zeros((2, 3)), 1.0)


def test_wrong_paths(pair):
    a, b = pair
    w = align.dtw(a.angles, b.angles)[1]
    for path, message in ((w[:-1], "needed .* the last of"), (w[:, ::-1], "another pair's"),
                          (w[1:], "from .0, 0. on"), (w[::2], "0 or 1 a step"),
                          (np.repeat(w, 2, axis=0), "0 or 1 a step"), (w[:, 0], r"shape \(\d+,\)"),
                          (w[:0], "needed")):
        with pytest.raises(align.AlignError, match=f"path: .*{message}"):
            align.interpolate(a, b, 0.5, path)
    narrow = replace(b, angles=b.angles[:, 3:])
    with pytest.raises(align.AlignError, match="one skeleton"):
        align.interpolate(a, narrow, 0.5, w)
