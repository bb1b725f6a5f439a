"""The one-stage programme against the enumeration of all concatenations, and against the truth of
the embedded performers.
"""

from itertools import product

from hypothesis import given
from hypothesis import strategies as st
import numpy as np
import pytest

from refimpl.torresani2006 import align, content, database as databases, poses
from refimpl.experiments import phrases, torresani as experiment
from refimpl.embedded import performers
from refimpl.torresani2006.segment import SegmentError, segment


def compositions(n):
    """All ways to cut n frames into pieces of at least one."""
    for gaps in product([0, 1], repeat=n - 1):
        ends = [k + 1 for k, gap in enumerate(gaps) if gap] + [n]
        yield list(zip([0] + ends, ends))


def best_concatenation(Y, fragments):
    """Equation 8 by trying all concatenations and all cuts."""
    return min(sum(align.dtw_definition(align.distances(Y[a:b], fragments[i]))[-1, -1] for (a, b),
                   i in zip(cuts, chosen)) for cuts in compositions(len(Y))
               for chosen in product(range(len(fragments)), repeat=len(cuts)))


@given(st.integers(0, 10_000))
def test_all_concatenations(seed):
    rng = np.random.default_rng(seed)
    fragments = [rng.integers(-2, 3, (rng.integers(1, 4), 2)).astype(float)
                 for _ in range(rng.integers(1, 4))]
    Y = rng.integers(-2, 3, (rng.integers(1, 6), 2)) + 0.1 * rng.normal(size=2)
    cost, pieces = segment(Y, fragments)
    assert cost == pytest.approx(best_concatenation(Y, fragments), abs=1e-9)
    assert pieces[0].start == 0 and pieces[-1].end == len(Y)
    assert all(a.end == b.start for a, b in zip(pieces, pieces[1:]))
    assert sum(piece.cost for piece in pieces) == pytest.approx(cost, abs=1e-9)
    # each piece is aligned as well as it can be
    for piece in pieces:
        alone = align.dtw(Y[piece.start:piece.end], fragments[piece.fragment])[0]
        assert piece.cost == pytest.approx(alone, abs=1e-9)


@given(st.integers(0, 10_000))
def test_a_concatenation_is_found_again(seed):
    rng = np.random.default_rng(seed)
    fragments = [np.cumsum(rng.normal(size=(rng.integers(3, 12), 3)), axis=0) for _ in range(5)]
    chosen = rng.integers(0, 5, 4)
    cost, pieces = segment(np.concatenate([np.repeat(fragments[n], 2, axis=0) for n in chosen]),
                           fragments)
    assert cost == 0
    assert [piece.fragment for piece in pieces] == chosen.tolist()
    assert ([piece.end for piece in pieces]
            == np.cumsum([2 * len(fragments[n]) for n in chosen]).tolist())


def test_one_fragment_is_dynamic_time_warping():
    rng = np.random.default_rng(0)
    X = np.cumsum(rng.normal(size=(20, 3)), axis=0)
    cost, pieces = segment(X + 0.01, [X])
    assert cost == pytest.approx(align.dtw(X + 0.01, X)[0]) and len(pieces) == 1


def test_errors():
    with pytest.raises(SegmentError, match="found none"):
        segment(np.zeros((3, 2)), [])
    good = np.zeros((3, 2))
    for Y, fragments, message in ((good, [good, np.zeros((3, 3))],
                                   r"fragments\[1\]: found 3 angles a frame, needed 2"),
                                  (good, [good, good[:0]], r"fragments\[1\]: found shape \(0, 2\)"),
                                  (good[0], [good], r"Y: found shape \(2,\)"),
                                  (good, [good, np.full((1, 2), np.nan)],
                                   r"fragments\[1\]: found nan"),
                                  (good - np.inf, [good], "Y: found -inf")):
        with pytest.raises(align.AlignError, match=message):
            segment(Y, fragments)


@pytest.fixture(scope="module")
def cast():
    return experiment.embedded_cast()


def test_known_fragments_warped_and_noisy_are_cut_where_they_were_joined(cast):
    rates = phrases.cut_again(cast.database, trials=20)
    assert rates["sequences"] == rates["cuts"] == rates["fragments"] == 1.0


def test_phrases_of_performers_not_in_the_database(cast):
    sequences = [fragment.angles for fragment in cast.database.fragments]
    for number in range(30, 36):
        phrase = performers.perform(tuple(performers.ACTIONS), number)
        _, pieces = segment(poses.fragment_of(phrase.clip, cast.database.body, "phrase").angles,
                            sequences)
        assert tuple(cast.database.fragments[piece.fragment].content
                     for piece in pieces) == phrase.contents
        assert np.abs(np.array([piece.end for piece in pieces]) - np.array(phrase.cuts[1:])
                      / 2).max() <= phrases.CUT_TOLERANCE


def test_contents_cluster(cast):
    threshold = align.threshold_for(cast.database.ssd, 5)
    found = align.clusters(cast.database.ssd, threshold)
    contents = [fragment.content for fragment in cast.database.fragments]
    assert len(set(zip(found.tolist(), contents))) == 5


def test_ways_to_group_contents(cast):
    found = phrases.contents_found(cast)
    assert all(row == {"adjusted Rand index": 1.0, "largest": 12} for row in found.values()), found
    far = np.ones((6, 6)) - np.eye(6)
    far[5, :5] = far[:5, 5] = 9.0
    assert "5 of 6" in content.groups(far, 2)[1]
    with pytest.raises(align.AlignError, match="count: found 0"):
        content.groups(far, 0)


def test_a_piece_like_nothing_is_said_to_be(cast):
    known = databases.without(cast.database, np.array(
        [f.content != "kick" for f in cast.database.fragments]))
    view = known.contents()

    def far(name):
        made = performers.perform(name, 60).clip
        _, pieces = view.cut(poses.fragment_of(made, known.body, name).angles)
        return max(view.like(piece) for piece in pieces)
    assert far("kick") > 1 > far("wave")


@pytest.mark.mocap
def test_real_fragments_are_cut_where_they_were_joined(mocap):
    real = experiment.folder_cast(mocap / "bandai1")
    assert phrases.cut_again(real.database, trials=2, length=3)["sequences"] == 1.0


def test_one_action_alone_and_a_phrase_of_all():
    """The mean pose of one action is no habit: without it a raised arm looks like one at rest."""
    rng = np.random.default_rng(0)
    places = {"up": [2.0, 0, 0], "rest": [0.0, 0, 0], "down": [-2.0, 0, 0]}
    habits = 0.3 * rng.normal(size=(5, 3))

    def motion(name, who):
        return habits[who] + places[name] + 0.1 * np.cumsum(rng.normal(size=(20, 3)), axis=0)
    known = [(motion(name, who), name, str(who)) for name in places for who in range(4)]
    view = content.contents_of_names(*zip(*known))
    alone = [(motion(name, 4), [name]) for name in places]
    for angles, names in (*alone, (np.concatenate([x for x, _ in alone]), list(places))):
        assert [view.names[p.fragment] for p in view.cut(angles)[1]] == names
