"""The player in a browser: what it draws, when, and what fingers and keys do to it.

The page's clock is the test's: it says when a picture is drawn and which time it is then.
"""

import html
import json

import numpy as np
import pytest

from refimpl.embedded.walkers import make_clip
from refimpl.motion.body import make_take
from refimpl.motion.feet import foot_contacts
from refimpl.pictures.player import Figure, page, show, write_player

from . import browser
from .test_player import data, decoded

pytestmark = pytest.mark.skipif(browser.find() is None, reason="no Chromium is installed here "
                                "(Debian: apt-get install chromium-headless-shell; or name one in "
                                "REFIMPL_CHROMIUM)")


@pytest.fixture(scope="module")
def chromium(tmp_path_factory):
    with browser.Browser(tmp_path_factory.mktemp("profile")) as one:
        yield one


def walker(style="normal", seconds=2.0):
    return make_take(make_clip("walk", style, seconds=seconds).clip).positions


@pytest.fixture(scope="module")
def pair(tmp_path_factory):
    """A page with a content and a result that both walk for two seconds."""
    path = tmp_path_factory.mktemp("pages") / "pair.html"
    write_player(path, [Figure(name, walker(style), planted=foot_contacts(walker(style)))
                        for name, style in (("content", "normal"), ("result", "old"))])
    return path


def opening(seconds, count=20):
    """Two hands that part at a steady speed beside a pole that stands, 10 frames a second."""
    t = np.linspace(0.0, seconds, count)
    motion = np.zeros((count, 4, 3))
    motion[:, 1, 1] = 100.0
    motion[:, 2:, 1] = 50.0
    motion[:, 2, 0], motion[:, 3, 0] = 50.0 * t, -50.0 * t
    return motion


@pytest.mark.parametrize("width", [400, 1280])
@pytest.mark.parametrize("dark", [False, True])
def test_every_picture_shows_its_time(chromium, pair, width, dark):
    chromium.open(pair, width=width, dark=dark)
    seen = set()
    for k in range(31):
        chromium.evaluate(f"picture({1000 + 1000 * k / 60})")
        assert chromium.evaluate("said()") == f"{k / 60:.2f} of 1.98 s, frame {k} of 119"
        found = chromium.evaluate("coloured()")
        seen.add(found["all"])
        assert min(found["in_left"], found["in_right"]) > 0.004 * found["width"] * found["height"]
    assert len(seen) == 31                                       # a new picture each sixtieth
    paper = chromium.evaluate("getComputedStyle(part('.player')).backgroundColor")
    assert (paper == "rgb(23, 25, 29)") == dark
    for name in ("button", "input", "select", "canvas"):         # all of it is within the page
        places = chromium.evaluate(f"[...player().querySelectorAll('{name}')].map(element => "
                                   "element.getBoundingClientRect()).map(r => [r.left, r.right])")
        assert all(0 <= left <= right <= width for left, right in places), name
    assert chromium.evaluate("document.documentElement.scrollWidth <= innerWidth")
    assert chromium.requests == [pair.as_uri()] and not chromium.errors


def test_joints_way_and_floor_are_drawn_where_they_are(chromium, tmp_path):
    """By the projection written out a second time: six reaches away, from -0.9 and 0.25 radians."""
    text = show([Figure("content", walker("zombie"))])
    (tmp_path / "a.html").write_text(f"<!DOCTYPE html><body>{text}</body>", encoding="utf-8")
    shown = data(text)
    figure, reach = shown["figures"][0], shown["figures"][0]["reach"]
    points, _, _ = decoded(figure)
    chromium.open(tmp_path / "a.html", still=True)
    for frame in (0, 37, 119):
        seen = chromium.evaluate(f"scrub({frame})")
        w, h = seen["width"], seen["height"]

        def places(world):
            d = world - points[frame, -1]
            ahead = d[:, 0] * np.sin(-0.9) + d[:, 2] * np.cos(-0.9)
            near = ahead * np.cos(0.25) + d[:, 1] * np.sin(0.25)
            scale = min(w / 1.5, h / 2.5) / reach * 6 * reach / (6 * reach - near)
            x = w / 2 + scale * (d[:, 0] * np.cos(-0.9) - d[:, 2] * np.sin(-0.9))
            y = 0.53 * h - scale * (d[:, 1] * np.cos(0.25) - ahead * np.sin(0.25))
            return np.rint(np.stack([x, y], axis=-1)).astype(int)

        joints = places(points[frame, :-1])
        assert all(chromium.evaluate(f"has_colour('.scene', {joints.tolist()})"))
        assert not any(chromium.evaluate(f"has_colour('.scene', {(joints + [220, 0]).tolist()})"))
        around = [max(2, frame - 25), min(frame + 2, 100), min(frame + 25, 115)]
        way = places(points[around, -1] * [1, 0, 1])
        corners = np.round(points[frame, -1] / shown["square"]) + [[1, 0, 1], [2, 0, 1]]
        floor = places(corners * shown["square"] * [1, 0, 1])
        for told, thin in (("has_colour('.scene', {})", way), ("drawn({})", floor)):
            near = (thin[:, None] + [[0, -1], [0, 0], [0, 1]]).reshape(-1, 2).tolist()
            found = np.reshape(chromium.evaluate(told.format(near)), (-1, 3))
            assert found.any(axis=1).all(), (frame, told)
        assert not all(chromium.evaluate(f"drawn({(floor + [0, 6]).tolist()})"))


def test_between_two_frames_it_interpolates(chromium, tmp_path):
    write_player(tmp_path / "a.html", [Figure("hands", opening(1.9), [-1, 0, 0, 0], 10.0)])
    chromium.open(tmp_path / "a.html", width=800, still=True)
    widths = {}
    for frames in (10, 15):                                      # at 1 s and at 1.5 s
        found = chromium.evaluate(f"scrub({frames})")
        widths[frames] = found["right"] - found["left"]
    chromium.evaluate("scrub(10), part('.play').click(), picture(0)")
    for k in range(1, 6):                                        # a quarter second, none is a frame
        chromium.evaluate(f"picture({50 * k})")
    found = chromium.evaluate("coloured()")
    assert chromium.evaluate("said()").startswith("1.25 of 1.90 s, frame 12 of 19")
    thick = widths[10] - (widths[15] - widths[10]) * 2
    wanted = thick + (widths[15] - thick) * 1.25 / 1.5
    assert abs(found["right"] - found["left"] - wanted) < 4 < widths[15] - wanted


def test_speed_loop_and_pause(chromium, pair):
    chromium.open(pair)
    chromium.evaluate("part('select').value = '0.5×', picture(0), picture(200)")
    assert chromium.evaluate("said()").startswith("0.10 of")
    chromium.evaluate("part('select').value = '2×'; for (let k = 2; k < 12; k++) picture(200 * k)")
    assert chromium.evaluate("said()").startswith("0.13 of")     # 4.1 s is 2.12 s past the end
    chromium.evaluate("part('.play').click(), picture(9000), picture(9500)")
    assert chromium.evaluate("said()").startswith("0.13 of")
    assert chromium.evaluate("part('.play').textContent") == "Play"


def test_it_stands_still_for_who_wants_no_motion(chromium, pair):
    chromium.open(pair, still=True)
    chromium.evaluate("picture(0), picture(500)")
    assert chromium.evaluate("said()").startswith("0.00 of")
    assert chromium.evaluate("part('.play').textContent") == "Play"


def test_keys(chromium, pair):
    chromium.open(pair, still=True)
    chromium.evaluate("part('.scene').focus()")
    for key, said in [("ArrowRight", "frame 1 "), ("ArrowRight", "frame 2 "),
                      ("ArrowLeft", "frame 1 "), ("PageUp", "frame 61 "), ("End", "frame 119 "),
                      ("PageDown", "frame 59 "), ("Home", "frame 0 "), ("ArrowLeft", "frame 0 ")]:
        chromium.key(key)
        chromium.evaluate("picture(0)")
        assert said in chromium.evaluate("said()") + " ", key
        assert said in chromium.evaluate("part('input').getAttribute('aria-valuetext')") + " "
    first = chromium.evaluate("coloured()")
    for key, shift in [("ArrowLeft", True), ("ArrowUp", True), ("+", False), ("-", False)]:
        before = chromium.evaluate("coloured()")
        chromium.key(key, shift)
        chromium.evaluate("picture(0)")
        after = chromium.evaluate("coloured()")
        assert after["all"] != before["all"], key
        assert key not in "+-" or (after["sum"] > before["sum"]) == (key == "+")
    chromium.key("0")
    chromium.evaluate("picture(0)")
    assert chromium.evaluate("coloured()") == first
    chromium.key(" ")
    assert chromium.evaluate("picture(0), picture(100), said()").startswith("0.10 of")
    chromium.key(" ")
    assert chromium.evaluate("picture(200), picture(300), said()").startswith("0.10 of")


def test_everything_can_be_reached_and_has_a_name(chromium, pair):
    chromium.open(pair, still=True)
    names = []
    for _ in range(8):
        chromium.key("Tab")
        names.append(chromium.evaluate(
            "(e => e && (e.ariaLabel || e.labels?.[0]?.textContent || e.textContent).trim())"
            "(player().activeElement)"))
    assert [name.split("0.1×")[0].strip() for name in names] == [
        "content, result: moving figures, 1.98 seconds", "Play", "Frame", "Speed", "Side by side",
        "Onion skin", "Reset view", "How to use it"]
    assert chromium.evaluate("part('.stands').ariaLabel") == "When each foot stands"


def test_touch_turns_pinches_and_scrubs(chromium, pair):
    chromium.open(pair, width=400, still=True, touch=True)
    chromium.evaluate("picture(0)")
    before = chromium.evaluate("coloured()")
    chromium.touch([(200, 200)], [(230, 200)], [(260, 200)])
    chromium.evaluate("picture(0)")
    turned = chromium.evaluate("coloured()")
    assert turned["all"] != before["all"] and abs(turned["sum"] / before["sum"] - 1) < 0.4
    chromium.touch([(150, 200), (250, 200)], [(100, 200), (300, 200)])
    chromium.evaluate("picture(0)")
    assert chromium.evaluate("coloured()")["sum"] > 1.3 * turned["sum"]
    at = json.loads(chromium.evaluate("JSON.stringify(part('input').getBoundingClientRect())"))
    chromium.touch([(at["x"] + at["width"] / 2, at["y"] + at["height"] / 2)])
    chromium.evaluate("picture(0)")
    assert 55 <= int(chromium.evaluate("said()").split("frame ")[1].split()[0]) <= 64


def test_overlay_onion_skin_and_standing_feet(chromium, pair, tmp_path):
    chromium.open(pair, still=True)
    beside = chromium.evaluate("scrub(60)")
    assert chromium.evaluate("pressed('.beside')") and not chromium.evaluate("pressed('.onion')")
    chromium.evaluate("part('.onion').click(), picture(0)")
    onion = chromium.evaluate("coloured()")
    assert chromium.evaluate("pressed('.onion')") and onion["sum"] > 1.5 * beside["sum"]
    chromium.evaluate("part('.onion').click(), part('.beside').click(), picture(0)")
    overlay = chromium.evaluate("coloured()")
    assert overlay["in_middle"] > 3 * beside["in_middle"]
    write_player(tmp_path / "bare.html", [Figure("content", walker()),
                                          Figure("result", walker("old"))])
    chromium.open(tmp_path / "bare.html", still=True)
    assert chromium.evaluate("scrub(60)")["sum"] < beside["sum"]                # no discs
    assert chromium.evaluate("part('.stands').hidden")


def test_the_bars_above_the_slider_tell_when_feet_stand(chromium, tmp_path):
    planted = np.zeros((120, 4), bool)
    planted[30:90, 2] = True
    write_player(tmp_path / "a.html", [Figure("content", walker(), planted=planted)])
    chromium.open(tmp_path / "a.html", still=True)
    wide = chromium.evaluate("part('.stands').width")
    places = [[int(wide * share), 4 * row + 1] for row in range(4) for share in (0.2, 0.5, 0.8)]
    found = chromium.evaluate(f"has_colour('.stands', {places})")
    assert found == [False] * 7 + [True] + [False] * 4


def test_figures_that_are_apart_are_both_seen_in_one_view(chromium, tmp_path):
    write_player(tmp_path / "a.html", [Figure("content", walker()),
                                       Figure("result", walker() + [250.0, 0.0, 0.0])])
    chromium.open(tmp_path / "a.html", width=400, still=True)
    found = chromium.evaluate("part('.beside').click(), scrub(60)")
    assert min(found["in_left"], found["in_right"]) > 300
    assert found["left"] > 5 and found["right"] < found["width"] - 5


def test_what_is_missing_and_who_has_ended_is_told(chromium, tmp_path):
    motion = walker()
    motion[30:60] = np.nan
    write_player(tmp_path / "a.html", [Figure("content", motion)])
    chromium.open(tmp_path / "a.html", still=True)
    whole, missing = (chromium.evaluate(f"scrub({frame})") for frame in (20, 40))
    assert missing["sum"] < 0.4 * whole["sum"] and missing["written"] > 2 * whole["written"]
    write_player(tmp_path / "b.html", [Figure("content", motion), Figure("result", motion[:30])])
    chromium.open(tmp_path / "b.html", still=True)
    before, after = (chromium.evaluate(f"scrub({frame})") for frame in (20, 100))
    assert after["written"] > 1.2 * before["written"]


def test_words_stay_words(chromium, tmp_path):
    words = "<b>bold</b> & <img src=x onerror='throw 1'>"
    write_player(tmp_path / "a.html", [Figure(words, walker())], title=words, caption=words,
                 unit=words)
    chromium.open(tmp_path / "a.html", still=True)
    assert chromium.evaluate("[part('h1').textContent, part('.caption').textContent, "
                             "document.title]") == [words] * 3
    assert chromium.evaluate("player().querySelectorAll('b, img').length") == 0
    assert not chromium.errors and len(chromium.requests) == 1


def test_several_in_one_page_and_in_frames_leave_each_other_alone(chromium, tmp_path):
    one, two = show({"a": walker()}), show({"b": walker("old", 1.0)}, title="second")
    frame = f'<iframe srcdoc="{html.escape(page({"c": walker("zombie", 1.0)}))}"></iframe>'
    text = ("<!DOCTYPE html><meta charset=utf-8><style>button, canvas { display: none !important; }"
            f"</style><body>{one}{two}{one}{frame}</body>")          # the first one twice
    (tmp_path / "many.html").write_text(text, encoding="utf-8")
    chromium.open(tmp_path / "many.html", height=3000)
    assert chromium.evaluate("document.querySelectorAll('.refimpl-player').length") == 3
    chromium.evaluate("picture(0), picture(200), part('.play', 0).click(), picture(300)")
    assert [chromium.evaluate(f"said({n})")[:4] for n in range(3)] == ["0.20", "0.30", "0.30"]
    assert all(chromium.evaluate(f"coloured({n}).sum") > 500 for n in range(3))
    assert not chromium.errors


def test_what_was_hidden_is_drawn_when_it_is_shown(chromium, tmp_path):
    (tmp_path / "tab.html").write_text("<!DOCTYPE html><body><div id=tab style='display: none'>"
                                       f"{show({'a': walker()})}</div></body>", "utf-8")
    chromium.open(tmp_path / "tab.html", clock=False)
    chromium.evaluate("tab.style.display = 'block', new Promise(done => requestAnimationFrame("
                      "() => requestAnimationFrame(() => setTimeout(done))))")
    assert chromium.evaluate("coloured().sum") > 500
    assert not chromium.errors


def test_the_page_scrolls_over_a_player_of_a_notebook(chromium, pair, tmp_path):
    """Alone in its page the wheel comes nearer at once; among other things only after a click."""
    (tmp_path / "book.html").write_text(f"<!DOCTYPE html><body>{show({'a': walker()})}"
                                        "<div style='height: 3000px'></div></body>", "utf-8")
    for path, scrolls in ((tmp_path / "book.html", True), (pair, False)):
        chromium.open(path, still=True)
        assert chromium.evaluate("""(event => { part(".scene").dispatchEvent(event);
            return event.defaultPrevented; })(new WheelEvent("wheel",
            {deltaY: 50, cancelable: true, bubbles: true, composed: true}))""") == (not scrolls)


ODD = {
    "one frame": [Figure("a", walker()[:1])],
    "one joint": [Figure("a", np.linspace(0, 100, 30)[:, None, None] * [1.0, 0.0, 1.0], [-1])],
    "points without bones": [Figure("a", walker(), [-1] * 21)],
    "gaps": [Figure("a", np.where(np.arange(120)[:, None, None] % 40 < 20, walker(), np.nan))],
    "a thousand joints": [Figure("a", np.random.default_rng(0).normal(
        scale=40, size=(20, 1000, 3)), np.arange(-1, 999))],
    "three lengths and rates": [Figure(f"f{n}", walker(seconds=n)[::n], fps=60.0 / n)
                                for n in (1, 2, 3)],
    "a name of HTML": [Figure("<b>bold</b></script><script>throw 1</script>", walker())],
    "a long name": [Figure("a name that goes on and on, " * 9, walker()),
                    Figure("🕺" * 90, walker())],
    "far away": [Figure("a", walker() + 1e7)],
    "a root left behind": [Figure("a", np.concatenate(
        [0 * walker()[:, :1], walker() + [9e3, 0, 0]], axis=1), [-1, *range(21)])],
    "lying": [Figure("a", walker()[..., [0, 2, 1]] * [1, -1, 1])],
    "a slow rate": [Figure("a", walker()[::60], fps=0.5)],
    "a swift rate": [Figure("a", walker(), fps=1000.0)],
    "in metres": [Figure("a", walker() / 100.0)],
    "ten figures": [Figure(f"f{n}", walker() + [100.0 * n, 0, 0]) for n in range(10)],
    "parents after children": [Figure("a", walker()[:, ::-1],
                                      [20 - p if p >= 0 else -1 for p in
                                       [-1, 0, 1, 2, 3, 0, 5, 6, 7, 0, 9, 10, 11, 10, 13, 14, 15,
                                        10, 17, 18, 19][::-1]])]}


@pytest.mark.parametrize("name", ODD)
def test_odd_figures_are_drawn(chromium, tmp_path, name):
    write_player(tmp_path / "odd.html", ODD[name])
    for width in (400, 1280):
        chromium.open(tmp_path / "odd.html", width=width)
        chromium.evaluate("picture(0), picture(100)")
        sums = [chromium.evaluate("coloured().sum")]
        chromium.evaluate("part('.onion').click(), part('.beside').click(), picture(200)")
        sums.append(chromium.evaluate("coloured().sum"))
        assert min(sums) > 60 and not chromium.errors, sums
        assert chromium.evaluate("document.documentElement.scrollWidth <= innerWidth")
