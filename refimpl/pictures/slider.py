"""A picture with a slider: lines that were computed before, one set for each value of a control.

    slide("alpha", [0.0, 0.5, 1.0], [{"blend": pose_lines(P)} for P in poses], equal=True)

as the last line of a notebook's cell. Plain HTML, SVG and a little JavaScript, with all numbers in
the page: it works in a rendered page as well, without a network, and without JavaScript it shows
the middle value.
"""

from collections.abc import Mapping, Sequence
import hashlib
import html
import json

import numpy as np

from .player import Shown
from .staging import colours, round_length
from ..motion.joints import BONES

WIDE, HIGH, EDGE = 640, 300, 52                                  # of the picture, in its own units
_SCRIPT = """(() => { const host = document.getElementById("NAME"), paths = PATHS, shown = VALUES;
const lines = [...host.querySelectorAll("path[data-line]")], said = host.querySelector("output");
host.querySelector("input").addEventListener("input", event => { const i = +event.target.value;
  said.textContent = shown[i]; lines.forEach((line, n) => line.setAttribute("d", paths[i][n])); });
})();"""


def pose_lines(pose: np.ndarray, view: str = "side") -> np.ndarray:
    """The bones of one pose as a single line with gaps, for `slide`.

    pose : (21, 3);  view : "side" looks along x, "front" along z  ->  (60, 2)

    >>> pose_lines(np.zeros((21, 3))).shape
    (60, 2)
    """
    across = {"side": 2, "front": 0}[view]
    ends = np.asarray(pose)[np.array(BONES)][..., [across, 1]]           # (20, 2, 2)
    return np.concatenate([ends, np.full((len(ends), 1, 2), np.nan)], axis=1).reshape(-1, 2)


def slide(control: str, values: Sequence[object],
          pictures: Sequence[Mapping[str, np.ndarray]], *, x: str = "", y: str = "",
          equal: bool = False, caption: str = "") -> Shown:
    """A slider below a picture of lines.

    control : what is moved, with its unit;  values : what is written beside it, one for each
    picture;  pictures : {label: (n, 2) points, NaN lifts the pen}, the same labels in each;
    x, y : names of the axes, with units;  equal : a unit is as long on both axes;
    caption : what the picture shows, also for who cannot see it
    ->  HTML that a notebook shows.   Raises ValueError where values and pictures do not fit.

    >>> lines = [{"a": np.array([[0.0, 0.0], [1.0, s]])} for s in (1.0, 2.0)]
    >>> "slope 2" in slide("slope", ["slope 1", "slope 2"], lines, caption="a line that turns")
    True
    """
    labels = list(pictures[0]) if len(pictures) else []
    if not labels or len(values) != len(pictures) or any(list(p) != labels for p in pictures):
        raise ValueError(f"pictures: found {len(pictures)} for {len(values)} values, needed one "
                         "for each, with the same labels in the same order")
    points = np.concatenate([np.asarray(line, float) for p in pictures for line in p.values()])
    low, high = np.nanmin(points, axis=0), np.nanmax(points, axis=0)
    span = np.where(high > low, high - low, 1.0)
    scale = np.array([WIDE - 2 * EDGE, HIGH - 2 * EDGE]) / span
    scale = np.full(2, scale.min()) if equal else scale
    origin = np.array([WIDE, HIGH]) / 2 - (low + span / 2) * scale * [1, -1]

    def _place(line):
        return np.asarray(line, float) * scale * [1, -1] + origin

    def _path(line):
        pen, text = "M", []
        for across, down in _place(line):
            if np.isfinite(across + down):
                text.append(f"{pen}{across:.1f} {down:.1f}")
            pen = "L" if np.isfinite(across + down) else "M"
        return "".join(text)
    paths = [[_path(line) for line in picture.values()] for picture in pictures]
    name = "slide-" + hashlib.sha256(json.dumps([control, caption, paths]).encode()).hexdigest()[:12]
    middle, colour = len(values) // 2, colours(labels)
    drawn = [f'<path data-line d="{d}" fill="none" stroke="{colour[label]}" stroke-width="2"/>'
             for label, d in zip(labels, paths[middle])]
    drawn += [f'<text x="{EDGE + 130 * i}" y="16" fill="{colour[label]}">{html.escape(label)}</text>'
              for i, label in enumerate(labels)]
    drawn += _ticks(low, high, _place, equal)
    drawn += [f'<text x="{WIDE / 2}" y="{HIGH - 6}" text-anchor="middle">{html.escape(x)}</text>',
              f'<text transform="translate(12 {HIGH / 2}) rotate(-90)" text-anchor="middle">'
              f"{html.escape(y)}</text>"]
    told = html.escape(caption, quote=True)
    script = (_SCRIPT.replace("NAME", name).replace("PATHS", json.dumps(paths))
              .replace("VALUES", json.dumps([str(v) for v in values])).replace("</", "<\\/"))
    return Shown(
        f'<figure id="{name}" style="margin:0;max-width:{WIDE}px;font:12px sans-serif">'
        f'<svg viewBox="0 0 {WIDE} {HIGH}" role="img" aria-label="{told}" fill="currentColor" '
        f'style="width:100%">{"".join(drawn)}</svg><label>{html.escape(control)} '
        f'<input type="range" min="0" max="{len(values) - 1}" value="{middle}" style="width:60%"> '
        f"<output>{html.escape(str(values[middle]))}</output></label><figcaption>{told}</figcaption>"
        f"</figure><script>{script}</script>")


def _ticks(low, high, place, equal):
    """Numbers and marks along both axes."""
    for axis in (0, 1):
        step = round_length(float(high[axis] - low[axis]) / 3 or 1.0)
        for value in np.arange(np.ceil(low[axis] / step), high[axis] / step + 1e-9) * step:
            at = np.where(np.arange(2) == axis, value, low)
            across, down = place(at)
            yield (f'<text x="{across:.0f}" y="{HIGH - 24}" text-anchor="middle">{value:g}</text>'
                   if axis == 0 else f'<text x="{EDGE - 6 if not equal else EDGE - 14}" '
                   f'y="{down + 4:.0f}" text-anchor="end">{value:g}</text>')
