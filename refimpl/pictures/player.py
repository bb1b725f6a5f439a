r"""Motions that move: a page of HTML, without a network, in which figures walk at their true speed.

The page holds the joints as numbers and draws them on a canvas as often as the screen shows a
picture; between two frames it interpolates. `player.js` draws, `player.html` is what one presses.
With whole numbers q of steps of 1/8192 of a figure's reach (0.1 mm for a person, so that no joint
is farther than 0.1 mm from where it was), a joint j with the parent k is written as

    z[t] = d[t] - 2 d[t-1] + d[t-2],    d = q_j - q_k

which is small in a motion that is smooth, and packed by zlib.
"""

import base64
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
import hashlib
import html
import json
from pathlib import Path
import re
from typing import Any
import zlib

import numpy as np
from scipy.ndimage import gaussian_filter1d

from .staging import colours, round_length, turned_forward
from ..motion.features import FPS, checked_positions
from ..motion.feet import foot_contacts
from ..motion.joints import FEET, JOINTS, PARENTS, SLOT
from ..storage import atomic_write

_STEPS = 8192                                                    # in a figure's reach
_WIDEST = 2.0 ** 27                                              # steps from the origin
_HERE = Path(__file__)
_FRAGMENT = """<div class="refimpl-player" data-player="{name}"{alone}>
<p>A player of moving figures stands here; it needs JavaScript.</p></div>
<script>(() => {{ "use strict";
{code}
for (const host of document.querySelectorAll('[data-player="{name}"]:not([data-ready])'))
  start(host, {markup}, {data}).catch(error => {{
    host.shadowRoot.textContent = "The player could not start: " + error.message; }});
}})();</script>"""
_PAGE = """<!DOCTYPE html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<meta name="color-scheme" content="light dark">
<meta http-equiv="Content-Security-Policy"
  content="default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline'">
<title>{title}</title>
<style>body {{ margin: 0; }}
@media (prefers-color-scheme: dark) {{ body {{ background: #17191d; color: #e8eaed; }} }}</style>
</head>
<body>
{fragment}
</body>
</html>
"""


@dataclass(frozen=True)
class Figure:
    """Who moves in a player. Figures of one player may differ in skeleton, length and rate.

    name : what stands beside it;  positions : (T, J, 3) in the world, NaN where a joint is unknown
    parents : (J,) index of each joint's parent, -1 for none
    fps : frames a second
    planted : (T, K) which feet stand;  feet : (K,) their joints
    head : the joint that a head is drawn at
    colour : "#rrggbb", one of `staging.colours` unless given;  up : "y" or "z"

    parents, feet (for K = 4) and head may be left out for the papers' 21 joints.
    """

    name: str
    positions: np.ndarray
    parents: Sequence[int] | np.ndarray | None = None
    fps: float = 60.0
    planted: np.ndarray | None = None
    feet: Sequence[int] | None = None
    head: int | None = None
    colour: str = ""
    up: str = "y"


Figures = Sequence[Figure] | Mapping[str, np.ndarray]


class Shown(str):
    """A piece of HTML that a notebook shows when it is the last line of a cell."""

    def _repr_html_(self):
        return str(self)

    def __repr__(self):
        return f"<{len(self)} characters of HTML>"


def write_player(path: str | Path, figures: Figures, **options: Any) -> int:
    """Write a page with a player that starts by itself, whole or not at all.

    options : of `show`   ->  its length in bytes
    """
    text = page(figures, **options)
    with atomic_write(path) as file:
        file.write(text)
    return len(text.encode())


def page(figures: Figures, **options: Any) -> str:
    """The text of a page with a player alone in it.   options : of `show`"""
    data = _data(figures, **options)
    title = data["title"] or ", ".join(figure["name"] for figure in data["figures"])
    return _PAGE.format(title=html.escape(title), fragment=_fragment(data, ' data-alone="yes"'))


def show(figures: Figures, **options: Any) -> Shown:
    """A player for a notebook or a page of one's own; several in one page leave each other alone.

    figures : each a `Figure`; or {name: (T, 21, 3)}, whose standing feet are found at 60 frames a
        second
    options : fps, of all figures that came without one (60);  title, caption, above and below, such
        as whose motion it is;  unit, of the positions ("cm");  align, to begin each figure at the
        origin, facing +z, instead of where it is to the others (False)
    Raises ValueError.

    >>> show([Figure("still", np.zeros((2, 21, 3)))], caption="nobody").count("<script>")
    1
    """
    return Shown(_fragment(_data(figures, **options)))


def _fragment(data, alone=""):
    """A player's place and the program that fills it."""
    def _quoted(value):                                           # nothing in it ends the <script>
        return json.dumps(value).replace("<", "\\u003c")

    parts = {"code": _HERE.with_suffix(".js").read_text(encoding="utf-8"), "data": _quoted(data),
             "markup": _quoted(_HERE.with_suffix(".html").read_text(encoding="utf-8"))}
    name = hashlib.sha256("".join(parts.values()).encode()).hexdigest()[:16]
    return _FRAGMENT.format(name=name, alone=alone, **parts)


def _data(figures, *, fps=60.0, title="", caption="", unit="cm", align=False):
    """All that `player.js` draws."""
    if isinstance(figures, Mapping):
        figures = [_standing(name, positions, fps) for name, positions in figures.items()]
    if not figures:
        raise ValueError("figures: found none, needed at least one")
    placed: list[tuple[Figure, np.ndarray, float]] = []
    turn, origin = np.eye(3), [0.0, 0.0, 0.0]
    for figure in map(_checked, figures):
        first = align or not placed                              # who comes first sets the stage
        if first:
            turn = _turn(figure.positions[0])
        positions = figure.positions @ turn
        seen = np.isfinite(positions[..., 0])                    # (T, J)
        centre = _centre(positions, seen)
        reach = _reach(positions - centre, seen)
        centre = gaussian_filter1d(centre, 0.3 * figure.fps, axis=0, mode="nearest")
        if first:
            lows = np.where(seen, positions[..., 1], np.inf).min(axis=1)[seen.any(axis=1)]
            floor = np.percentile(lows, 2) - 0.03 * reach        # a sole is below its joints
            origin = [centre[0, 0, 0], floor, centre[0, 0, 2]]
        placed.append((figure, np.concatenate([positions, centre], axis=1) - origin, reach))
    names = [figure.name + " " * n * (figure.name in [f.name for f, _, _ in placed[:n]])
             for n, (figure, _, _) in enumerate(placed)]         # one colour each, twins too
    return {"title": title, "caption": caption, "unit": unit,
            "square": round_length(0.7 * max(reach for _, _, reach in placed)),
            "figures": [_numbers(*one, colour)
                        for one, colour in zip(placed, colours(names).values())]}


def _standing(name, positions, fps):
    """A figure of 21 joints with its standing feet, which are told by speed at 60 frames a second.
    """
    positions = checked_positions(positions, f"motions[{name!r}]")
    return Figure(name, positions, fps=fps,
                  planted=foot_contacts(positions) if fps == FPS and len(positions) > 1 else None)


def _checked(figure):
    """The same with all that may be left out, y up, and NaN wherever a joint is not finite."""
    def _need(good, what, found, needed):
        if not good:
            raise ValueError(f"figure {figure.name!r}, {what}: found {found}, needed {needed}")

    positions = np.asarray(figure.positions, dtype=float)
    _need(positions.ndim == 3 and positions.shape[2] == 3 and positions.size, "positions",
          f"shape {positions.shape}", "(frames, joints, 3), none of them 0")
    frames, joints = positions.shape[:2]
    whole = np.isfinite(positions).all(axis=-1, keepdims=True)
    _need(whole.any(), "positions", "no finite joint", "at least one in one frame")
    known = joints == JOINTS
    parents = np.asarray(PARENTS if figure.parents is None and known else figure.parents)
    _need(parents.shape == (joints,) and np.all((parents >= -1) & (parents < joints)), "parents",
          f"shape {parents.shape} for {joints} joints", "an index for each joint, -1 for none")
    _need(np.isfinite(figure.fps) and figure.fps > 0, "fps", figure.fps, "a rate above 0")
    _need(re.fullmatch("(#[0-9a-fA-F]{6})?", figure.colour), "colour", repr(figure.colour),
          "a # and six hexadecimal digits")
    _need(figure.up in ("y", "z"), "up", repr(figure.up), "'y' or 'z'")
    feet = list((FEET if known else ()) if figure.feet is None else map(int, figure.feet))
    planted = np.asarray(figure.planted)
    if figure.planted is None:
        planted, feet = np.zeros((frames, 0)), []
    _need(planted.shape == (frames, len(feet)) and set(feet) <= set(range(joints)),
          "planted, feet", f"shape {planted.shape}, joints {feet}",
          f"({frames}, feet) and a joint for each foot")
    head = SLOT["Head"] if figure.head is None and known else figure.head
    _need(head is None or 0 <= head < joints, "head", head, f"a joint below {joints}")
    if figure.up == "z":
        positions = positions[..., [0, 2, 1]] * [1, 1, -1]
    return replace(figure, positions=np.where(whole, positions, np.nan), parents=parents,
                   planted=planted, feet=feet, head=head, up="y")


def _centre(positions, seen):
    """The median of the joints that are seen, which a stray one does not move, between its
    neighbours where none is.   ->  (T, 1, 3)
    """
    known = np.flatnonzero(seen.any(axis=1))
    medians = (np.median if seen.all() else np.nanmedian)(positions[known], axis=1)
    return np.stack([np.interp(np.arange(len(seen)), known, one) for one in medians.T],
                    axis=-1)[:, None]


def _reach(from_centre, seen):
    """How far from the centre all but a tenth of the joints are, in nearly all frames."""
    far = np.linalg.norm(from_centre, axis=-1)[seen.any(axis=1)]
    return float(np.percentile((np.percentile if seen.all() else np.nanpercentile)(
        far, 90, axis=1), 99)) or 1.0


def _turn(pose):
    return turned_forward(pose) if len(pose) == JOINTS and np.isfinite(pose).all() else np.eye(3)


def _numbers(figure, points, reach, colour):
    """A figure as JSON has it.   points : (T, J + 1, 3), the middle last"""
    absent = np.isnan(points[..., 0])
    points = np.where(absent[..., None], 0.0, points)
    step = max(reach / _STEPS, float(np.abs(points).max()) / _WIDEST)
    whole = np.rint(points / step).astype(np.int64)
    d = whole.copy()
    for joint, parent in enumerate(figure.parents):
        if 0 <= parent < joint:
            d[:, joint] -= whole[:, parent]
    z = np.diff(d.reshape(len(d), -1), n=2, axis=0, prepend=np.zeros((2, d[0].size), np.int64))
    z = np.ascontiguousarray(((z << 1) ^ (z >> 63)).T.astype("<u4"))      # signs in the last bit
    parts = [z.view(np.uint8).reshape(-1, 4).T,                          # lowest bytes first
             np.packbits(absent[:, :-1]), np.packbits(figure.planted.astype(bool))]
    packed = zlib.compress(b"".join(part.tobytes() for part in parts), 9)
    return {"name": figure.name, "colour": figure.colour or colour, "fps": float(figure.fps),
            "frames": len(points), "parents": figure.parents.tolist(), "feet": figure.feet,
            "head": figure.head, "reach": reach, "step": step,
            "data": base64.b64encode(packed).decode()}
