"""A picture with a slider: what is in the page, and what is refused."""

import json
import re

import numpy as np
import pytest

from refimpl.pictures.slider import pose_lines, slide

LINES = [{"a": np.array([[0.0, 0.0], [1.0, s]]), "b": np.array([[0.0, 1.0], [np.nan, np.nan],
                                                                [0.5, 1.0], [1.0, s]])}
         for s in (1.0, 2.0, 4.0)]


def test_all_pictures_are_in_the_page_and_the_middle_one_is_drawn():
    page = slide("slope", [1, 2, 4], LINES, x="x [cm]", y="y [cm]", caption='a "line" & <b>')
    paths = json.loads(re.search(r"paths = (\[\[.*?\]\]), shown", page).group(1))
    assert len(paths) == 3 and all(len(picture) == 2 for picture in paths)
    drawn = re.findall(r'<path data-line d="([^"]*)"', page)
    assert drawn == paths[1]
    assert [path.count("M") for path in paths[0]] == [1, 2], "NaN lifts the pen"
    assert 'aria-label="a &quot;line&quot; &amp; &lt;b&gt;"' in page and "<b>" not in page
    assert "x [cm]" in page and "http" not in page and page.count("<script>") == 1
    ends = [float(path.split()[-1]) for path, _ in paths]
    assert ends[0] > ends[1] > ends[2], "up is up"


def test_axes_are_alike_if_asked():
    square = [{"s": np.array([[0.0, 0.0], [10.0, 0.0], [10.0, 10.0]])}]
    path = json.loads(re.search(r"paths = (\[\[.*?\]\]),", slide("", [0], square, equal=True,
                                                                 caption="")).group(1))[0][0]
    numbers = np.array([[float(n) for n in pair.split()] for pair in re.split("[ML]", path)[1:]])
    across, up = np.abs(np.diff(numbers, axis=0)).sum(axis=0)
    assert across == pytest.approx(up, abs=0.2)


@pytest.mark.parametrize("values, pictures", [([1], LINES), ([], []),
                                              ([1, 2], [LINES[0], {"a": LINES[0]["a"]}])])
def test_what_does_not_fit_is_refused(values, pictures):
    with pytest.raises(ValueError, match="needed one for each, with the same labels"):
        slide("slope", values, pictures)


def test_a_pose_is_twenty_bones():
    lines = pose_lines(np.arange(63.0).reshape(21, 3), "front")
    assert lines.shape == (60, 2) and np.isnan(lines[2::3]).all()
    assert np.isfinite(np.delete(lines, np.s_[2::3], axis=0)).all()
