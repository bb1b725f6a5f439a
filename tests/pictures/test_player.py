"""The player: joints go into the page as numbers and come out where they were, the page needs
nothing from elsewhere, stays small and lets no name become a program.
"""

import base64
import json
import re
import subprocess
import sys
import zlib

import numpy as np
import pytest

from refimpl.embedded.walkers import make_clip
from refimpl.motion.body import make_take
from refimpl.motion.feet import foot_contacts
from refimpl.pictures.player import Figure, page, show, write_player


def walker(style="normal", seconds=8.0, content="walk"):
    return make_take(make_clip(content, style, seconds=seconds).clip).positions


def data(text):
    """What the program in a page is started with."""
    return json.loads(re.search(r'\{"title": .*\}(?=\)\.catch)', text)[0])


def decoded(figure):
    """The numbers of a page undone.   ->  (T, J + 1, 3) the middle last, absent (T, J), planted"""
    T, J, K = figure["frames"], len(figure["parents"]), len(figure["feet"])
    stream = np.frombuffer(zlib.decompress(base64.b64decode(figure["data"])), np.uint8)
    count, bits = T * (J + 1) * 3, -(-T * J // 8)
    z = sum(stream[k * count:(k + 1) * count].astype(np.int64) << 8 * k for k in range(4))
    d = np.where(z % 2, -(z + 1) // 2, z // 2).reshape(-1, T)
    places = d.cumsum(axis=1).cumsum(axis=1).T.reshape(T, J + 1, 3)
    for joint, parent in enumerate(figure["parents"]):
        if 0 <= parent < joint:
            places[:, joint] += places[:, parent]
    absent = np.unpackbits(stream[4 * count:4 * count + bits])[:T * J].reshape(T, J)
    planted = np.unpackbits(stream[4 * count + bits:])[:T * K].reshape(T, K)
    return places * figure["step"], absent.astype(bool), planted.astype(bool)


def test_joints_come_out_where_they_were():
    motion, c, s = walker("old"), np.cos(1.0), np.sin(1.0)
    for away in (0.0, 1e6):                                      # far from the origin, too
        figure, = data(show([Figure("a", motion + away, planted=foot_contacts(motion))]))["figures"]
        points, absent, planted = decoded(figure)
        assert not absent.any() and (planted == foot_contacts(motion)).all()
        # The stage moves and turns the whole: distances within it and over time are kept.
        before = np.linalg.norm(motion - motion[100, 12], axis=-1)
        after = np.linalg.norm(points[:, :-1] - points[100, 12], axis=-1)
        assert np.abs(after - before).max() < 0.02               # cm; asked for is 0.1
        assert -6.0 < points[:, :-1, 1].min() < 6.0 and np.abs(points[0, -1, [0, 2]]).max() < 0.02
    turned = motion @ np.array([[c, 0, -s], [0, 1, 0], [s, 0, c]])
    one, two = (decoded(data(show({"a": m}))["figures"][0])[0] for m in (motion, turned))
    np.testing.assert_allclose(one, two, atol=0.05)              # the first figure faces forward
    apart, = (decoded(f)[0] - one for f in data(show({"a": motion, "b": turned}))["figures"][1:])
    assert np.abs(apart).max() > 100.0                           # the second is where it is to it
    both = data(show({"a": motion, "b": turned}, align=True))["figures"]
    np.testing.assert_allclose(decoded(both[0])[0], decoded(both[1])[0], atol=0.05)


def test_what_is_absent_is_told_and_the_rest_stays():
    motion = walker(seconds=1.0)
    motion[10:20, 3], motion[30], motion[0, 5, 1] = np.nan, np.inf, np.nan
    points, absent, _ = decoded(data(show([Figure("a", motion)]))["figures"][0])
    assert (absent == ~np.isfinite(motion).all(axis=-1)).all() and absent.sum() == 10 + 21 + 1
    seen = np.isfinite(motion).all(axis=-1)
    kept = (points[:, :-1] - motion)[seen]
    assert np.ptp(kept, axis=0).max() < 0.02                     # moved as a whole
    middle = points[:, -1]
    assert np.abs(np.diff(middle, axis=0)).max() < 3.0           # the camera does not jump


@pytest.mark.parametrize("figures, seconds, limit", [(1, 60.0, 1e6), (3, 60.0, 2e6), (2, 8.0, 2e5)])
def test_pages_stay_small(tmp_path, figures, seconds, limit):
    """Thirty joints that tremble by a millimetre: worse than any capture."""
    rng, walk = np.random.default_rng(0), walker(seconds=seconds)
    parents = [*range(-1, 20), *range(9)]
    cast = []
    for n in range(figures):
        motion = np.concatenate([walk, walk[:, :9] + 5.0], axis=1)
        motion = motion + rng.normal(scale=0.1, size=motion.shape)
        cast.append(Figure(f"f{n}", motion, parents, planted=foot_contacts(walk), feet=range(4)))
    size = write_player(tmp_path / "a.html", cast)
    assert size == (tmp_path / "a.html").stat().st_size < limit


def test_a_page_needs_nothing_from_elsewhere(tmp_path):
    text = page({"content": walker(seconds=1.0)}, title="A <title>", caption="whose & why")
    assert not re.search(r"https?:|src=|href=|import\(|fetch\(", text)
    assert "default-src 'none'" in text and "<title>A &lt;title&gt;</title>" in text
    assert text == page({"content": walker(seconds=1.0)}, title="A <title>", caption="whose & why")
    assert text.count("<script>") == text.count("</script>") == 1
    shown = show({"a": walker(seconds=0.5)}, caption="whose <motion>")
    assert shown._repr_html_() == str(shown) and len(repr(shown)) < 80 and "<html" not in shown


def test_no_name_becomes_a_program():
    bad = "</script><img src=x onerror=alert(1)><!-- \u2028 {0} %s \" ' \\"
    text = page([Figure(bad, walker(seconds=0.2))], title=bad, caption=bad, unit=bad)
    assert text.count("</script>") == 1 and "<img" not in text and "<!--" not in text
    assert data(text)["figures"][0]["name"] == bad == data(text)["caption"]


def test_own_colours_and_twins():
    one = walker(seconds=0.2)
    made = data(show([Figure("content", one), Figure("mine", one), Figure("mine", one),
                      Figure("red", one, colour="#ff0000")]))["figures"]
    colours = [figure["colour"] for figure in made]
    assert colours[0] == "#009E73" and colours[3] == "#ff0000" and len(set(colours)) == 4


def test_z_may_be_up():
    motion = walker(seconds=1.0)
    lying = motion[..., [0, 2, 1]] * [1, -1, 1]                  # x, -z, y: the world with z up
    one, two = (decoded(data(show([figure]))["figures"][0])[0]
                for figure in (Figure("a", motion), Figure("a", lying, up="z")))
    np.testing.assert_allclose(one, two, atol=1e-6)


STILL = np.zeros((2, 3, 3))


@pytest.mark.parametrize("figures, says", [
    ([], "found none"), ({}, "found none"),
    ({"a": np.zeros((4, 20, 3))}, r"'a'.*\(4, 20, 3\)"),
    ({"a": np.full((2, 21, 3), np.nan)}, "finite"),
    ([Figure("a", np.full((2, 21, 3), np.nan))], "'a', positions.*no finite joint"),
    ([Figure("a", np.zeros((0, 21, 3)))], "shape"), ([Figure("a", np.zeros((2, 21, 2)))], "shape"),
    ([Figure("a", STILL)], "parents"), ([Figure("a", STILL, [-1, 0, 3])], "parents"),
    ([Figure("a", STILL, [-1, 0])], "parents"), ([Figure("a", STILL, [-1, 0, 1], fps=0)], "fps"),
    ([Figure("a", STILL, [-1, 0, 1], fps=np.nan)], "fps"),
    ([Figure("a", STILL, [-1, 0, 1], planted=np.ones((2, 2)))], "planted, feet"),
    ([Figure("a", STILL, [-1, 0, 1], planted=np.ones((2, 1)), feet=[3])], "planted, feet"),
    ([Figure("a", STILL, [-1, 0, 1], head=3)], "head"),
    ([Figure("a", STILL, [-1, 0, 1], up="x")], "up"),
    ([Figure("a", STILL, [-1, 0, 1], colour="red;}")], "colour")])
def test_refuses_what_is_no_figure(figures, says):
    with pytest.raises(ValueError, match=says):
        show(figures)


def test_no_matplotlib_for_a_player():
    code = ("import sys, refimpl.pictures.player; "
            "assert not any(name.startswith('matplotlib') for name in sys.modules)")
    subprocess.run([sys.executable, "-c", code], check=True)


def test_a_page_is_written_whole_or_not_at_all(tmp_path):
    (tmp_path / "a.html").write_text("before")
    with pytest.raises(ValueError):
        write_player(tmp_path / "a.html", {})
    assert (tmp_path / "a.html").read_text() == "before" and len(list(tmp_path.iterdir())) == 1
