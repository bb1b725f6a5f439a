"""Windows of equal length and the normaliser."""

import numpy as np
import pytest

from .test_features import random_motion
from refimpl.motion import features as F, windows


def test_the_2016_normaliser_is_the_authors(witness):
    data = np.load(witness / "1_preprocessing.npz")
    cut = []
    for name in data["normaliser_clips"]:
        for begin in data[f"{name}_window_starts"]:
            rows = data[f"{name}_rows"][begin:begin + 240]
            before = -(-(240 - len(rows)) // 2)                  # the odd row on the left
            padded = np.pad(rows, ((before, 240 - len(rows) - before), (0, 0)), mode="edge")
            padded[:before, 66:69] = padded[before + len(rows):, 66:69] = 0
            cut.append(padded)
    rows = np.concatenate(cut)
    # turning (its sign is no matter), forward, sideways
    features = np.concatenate([rows[:, 3:66], rows[:, [68, 67, 66]]], axis=1)
    found = windows.fit_normaliser(features, "witness", contacts=rows[:, 69:], form="2016")
    needed = np.concatenate([data["Xstd"][3:66], data["Xstd"][[68, 67, 66]]])
    np.testing.assert_allclose(found.deviation, needed, rtol=1e-9)
    np.testing.assert_allclose(found.mean[:63], data["Xmean"][3:66], rtol=1e-9, atol=1e-9)


def test_forms_of_a_normaliser():
    rng = np.random.default_rng(0)
    x = random_motion(rng, 40)
    features = F.encode(x)[0]
    with pytest.raises(ValueError, match="form: found 'z', needed one of groups, 2016"):
        windows.fit_normaliser(features, "x", form="z")
    with pytest.raises(ValueError, match=r"contacts: found shape \(\), needed \(40, 4\)"):
        windows.fit_normaliser(features, "x", form="2016")
    found = windows.fit_normaliser(features, "x", contacts=np.zeros((40, 4)), form="2016")
    assert (found.form == "2016" and len(set(found.deviation[F.POSITIONS])) == 2
            and (found.mean[F.VELOCITIES] == 0).all())


def test_windows_of_a_long_clip_cover_it():
    x, contacts = np.arange(500 * 66.0).reshape(500, 66), np.zeros((500, 4), bool)
    cut, planted = windows.windows(x, contacts)
    assert cut.shape == (4, 240, 66) and planted.shape == (4, 240, 4)
    np.testing.assert_array_equal(cut[1], x[120:360])
    np.testing.assert_array_equal(cut[-1], x[260:])
    assert len(windows.windows(x[:480], contacts[:480])[0]) == 3


def test_a_short_clip_is_padded_standing_still():
    x, contacts = random_motion(np.random.default_rng(4), 100), np.ones((100, 4), bool)
    x = F.encode(x)[0]
    cut, planted = windows.windows(x, contacts)
    assert cut.shape == (1, 240, 66) and planted.all()
    np.testing.assert_array_equal(cut[0, 70:169], x[:99])
    assert not cut[0, :70, F.VELOCITIES].any() and not cut[0, 169:, F.VELOCITIES].any()
    positions = F.decode(cut[0])
    np.testing.assert_allclose(np.diff(positions[:71], axis=0), 0, atol=1e-12)
    np.testing.assert_allclose(np.diff(positions[169:], axis=0), 0, atol=1e-12)


def test_normaliser():
    rng = np.random.default_rng(5)
    x = rng.normal(3, 7, (1000, 66))
    n = windows.fit_normaliser(x, "made up")
    assert n.source == "made up" and len(np.unique(n.deviation)) == 3
    assert not n.mean[F.VELOCITIES].any()
    np.testing.assert_allclose(n.undo(n.apply(x)), x, atol=1e-12)
    assert n.apply(x.astype(np.float32)).dtype == np.float32
    still = np.zeros((10, 66))
    assert (windows.fit_normaliser(still, "still").deviation > 0).all()
