"""The computed observer against the truth of the embedded performers; label files with everything
that can be wrong in them.
"""

from dataclasses import replace

import numpy as np
import pytest

from refimpl.torresani2006 import labels, observe, poses
from refimpl.embedded import performers
from refimpl.torresani2006.labels import read_labels

HEADER = "clip,start,end,flow,weight,time\n"


@pytest.fixture(scope="module")
def seen():
    """Sixty fragments by twelve performers: observed styles and true efforts."""
    made = performers.make_performers()
    body = poses.fit_body([performance.clip for performance in made])
    fragments = [poses.fragment_of(p.clip, body, p.name, p.contents[0]) for p in made]
    observer = observe.fit_observer(fragments, body, observe.PUBLISHED)
    return (fragments, observer, np.array([observe.observe(f, observer) for f in fragments]),
            np.array([p.effort for p in made]))


def test_agrees_with_the_true_effort(seen):
    _, _, styles, efforts = seen
    r = np.corrcoef(styles.T, efforts.T)[:3, 3:]
    assert (np.diag(r) > 0.65).all(), r


def test_range_and_scale(seen):
    fragments, observer, styles, _ = seen
    assert np.abs(styles).max() <= 3 and np.abs(styles).max() > 2
    contents = np.array([fragment.content for fragment in fragments])
    for content in set(contents):
        assert np.abs(styles[contents == content].mean(axis=0)).max() < 0.2


def test_playing_faster_is_stronger_more_sudden_and_more_bound(seen):
    fragments, observer, *_ = seen
    faster = (observe.descriptors(replace(fragments[0], fps=60.0), observer.body)
              - observe.descriptors(fragments[0], observer.body))
    np.testing.assert_allclose(faster, np.log(2) * np.array([-1, 2, 1]), atol=1e-9)
    raw = (observe.descriptors(replace(fragments[0], fps=60.0), observer.body, relative=False)
           - observe.descriptors(fragments[0], observer.body, relative=False))
    np.testing.assert_allclose(raw, np.log(2) * np.array([-3, 2, 2]), atol=1e-9)


def test_by_hand():
    """A single joint that falls: v = g t, a = g, no jerk."""
    from refimpl.motion.clip import Joint
    body = poses.Body((Joint("ball", -1, (0, 0, 0), ()),), 0, np.zeros((1, 3)), np.eye(3)[None],
                      "y")
    t = np.arange(11) / 10
    root = np.stack([0 * t, -0.5 * 9.81 * t ** 2, 0 * t, 0 * t], axis=1)
    energy, speed, acceleration, jerk = observe.kinematics(
        poses.Fragment("ball", None, None, np.zeros((11, 3)), root, 10.0), body)
    assert energy == pytest.approx(0.5 * (9.81 * 0.95) ** 2) and speed == pytest.approx(0.5 * 9.81)
    assert acceleration == pytest.approx(9.81) and jerk == pytest.approx(0, abs=1e-9)


def test_the_published_descriptors_up_to_their_differences(seen):
    """Larboulette and Gibet 2015, equations 22 to 30, with their central differences: on a smooth
    motion ours are within a few per cent.
    """
    t = np.arange(121) / 60
    p = np.stack([np.sin(2 * np.pi * f * t + k) * a for k,
                  (f, a) in enumerate([(0.7, 30), (1.1, 10), (0.4, 55), (0.9, 20), (0.5, 8),
                                       (1.3, 5)])], axis=1)
    p = p.reshape(121, 2, 3)
    v, a = (p[2:] - p[:-2]) * 60 / 2, (p[2:] - 2 * p[1:-1] + p[:-2]) * 60 ** 2
    jerk = (p[4:] - 2 * p[3:-1] + 2 * p[1:-3] - p[:-4]) * 60 ** 3 / 2
    published = [max(0.5 * (frame ** 2).sum() for frame in v),
                 *(np.mean([np.linalg.norm(x, axis=2).sum(axis=1) / 2]) for x in (v, a, jerk))]
    np.testing.assert_allclose(observe.measures(p, 60.0), published, rtol=0.02)


def test_too_little(seen):
    fragments, observer, *_ = seen
    with pytest.raises(observe.ObserveError, match=r"positions: found shape \(3, 2, 3\)"):
        observe.measures(np.zeros((3, 2, 3)), 30.0)
    with pytest.raises(observe.ObserveError, match="fps: found 0"):
        observe.measures(np.zeros((4, 2, 3)), 0)
    with pytest.raises(observe.ObserveError, match="found 3 frames"):
        observe.observe(replace(fragments[0], angles=fragments[0].angles[:3],
                                root=fragments[0].root[:3]), observer)
    with pytest.raises(observe.ObserveError, match="nothing to compare"):
        observe.fit_observer(fragments[:1], observer.body, observe.PUBLISHED)


def write(tmp_path, text):
    path = tmp_path / "labels.csv"
    path.write_text(text)
    return path


def test_labels(tmp_path):
    path = write(tmp_path, HEADER
                 + "walk.bvh,0,40,1.5,-3,3\n# a note\n\nwalk,40,90,0,0,0\nbow,,,-1,2,0.5\n")
    found = read_labels(path, {"walk": 90, "bow": 50})
    assert ([(label.clip, label.start, label.end, label.line) for label in found]
            == [("walk", 0, 40, 2), ("walk", 40, 90, 5), ("bow", 0, 50, 6)])
    np.testing.assert_array_equal(found[0].style, [1.5, -3, 3])


@pytest.mark.parametrize("text, message", [
    ("", ":1: found 'an empty file'"),
    ("clip,flow\n", ":1: found 'clip,flow', needed the header clip,start,end,flow,weight,time"),
    (HEADER, "no line below the header"),
    (HEADER + "walk,0,40,1,2\n", ":2: found 5 values"),
    (HEADER + "walk,0,40,0,0,0\nrun,0,40,0,0,0\n", ":3: found no clip 'run'"),
    (HEADER + "walk,0,40,0,3.1,0\n", ":2: found weight '3.1', needed a number from -3 to 3"),
    (HEADER + "walk,0,40,0,0,nan\n", ":2: found time 'nan'"),
    (HEADER + "walk,0,40,much,0,0\n", ":2: found flow 'much'"),
    (HEADER + "walk,0,91,0,0,0\n", ":2: found start '0' and end '91'"),
    (HEADER + "walk,40,40,0,0,0\n", ":2: found start '40' and end '40'"),
    (HEADER + "walk,-1,40,0,0,0\n", ":2: found start '-1'"),
    (HEADER + "walk,,40,0,0,0\n", ":2: found start ''"),
    (HEADER + "walk,0,40,0,0,0\nbow,,,0,0,0\nwalk.bvh,0,40,1,1,1\n",
     ":4: found frames 0 to 40 of 'walk' a second time (the first is in line 2)"),
])
def test_wrong_labels_name_the_line(tmp_path, text, message):
    with pytest.raises(labels.LabelError) as error:
        read_labels(write(tmp_path, text), {"walk": 90, "bow": 50})
    assert message in str(error.value) and "labels.csv" in str(error.value)


def test_labels_that_are_no_text(tmp_path):
    path = tmp_path / "labels.csv"
    path.write_bytes(b"\xff\xfe\x00")
    with pytest.raises(labels.LabelError, match="UTF-8"):
        read_labels(path, {})
