r"""Motions that move: a page of HTML with a player, in which the figures walk side by side at their
true speed.

The page holds its pictures itself and needs no network. The camera follows each figure's root; a
floor grid that stays in the world and the way on the floor show how far it goes.
"""

from collections.abc import Callable, Mapping
import hashlib
import html
from pathlib import Path
import re
from typing import Any
import warnings

from matplotlib import rc_context
from matplotlib.animation import FuncAnimation
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure
import numpy as np
from scipy.ndimage import gaussian_filter1d

from .plot import (View, checked_motions, colours, draw_pose, facing_forward, left_leg_length,
                   move_pose, round_length, seen_from)
from ..motion.joints import SLOT
from ..storage import atomic_write

VIEW = (-52.0, 16.0)                                             # see `plot.seen_from`
_DPI = 100
_SETTINGS: dict[Any, Any] = {"animation.embed_limit": 1e6, "savefig.dpi": "figure",
                             "savefig.bbox": None, "savefig.facecolor": "auto"}
_SIGNS = {"minus": "&minus;", "fast-backward": "|&#9664;&#9664;", "step-backward": "|&#9664;",
          "play fa-flip-horizontal": "&#9664;", "pause": "&#10074;&#10074;", "play": "&#9654;",
          "step-forward": "&#9654;|", "fast-forward": "&#9654;&#9654;|", "plus": "+"}
_PAGE = """<!DOCTYPE html>
<html lang="en">
<head>
<meta charset="utf-8">
<title>{}</title>
</head>
<body style="margin: 8px; font-family: sans-serif; text-align: center">
{}
</body>
</html>
"""


def animation_html(motions: Mapping[str, np.ndarray], fps: float, path: str | Path,
                   frames: int = 90, *, title: str = "", unit: str = "cm",
                   view: View = VIEW) -> int:
    """Write a page with a looping player that starts by itself.

    motions : {label: (T, 21, 3)}; a shorter one stays in its last pose
    fps : their frames a second
    frames : most pictures to draw, taken at equal steps; each is shown for as long as its step
    lasts
    ->  number of pictures
    """
    fragment, count = player(motions, fps, frames, title=title, unit=unit, view=view)
    with atomic_write(path) as file:
        file.write(_PAGE.format(html.escape(title or ", ".join(motions)), fragment))
    return count


def player(motions: Mapping[str, np.ndarray], fps: float, frames: int = 90, *, title: str = "",
           unit: str = "cm", view: View = VIEW) -> tuple[str, int]:
    """The player alone, for a notebook or a page of one's own; for its arguments see
    `animation_html`.

    ->  HTML, number of pictures
    Raises ValueError.
    """
    motions = {label: facing_forward(p) for label, p in checked_motions(motions).items()}
    if not fps > 0 or frames < 1:
        raise ValueError(f"fps, frames: found {fps}, {frames}, needed a rate above 0 and at least "
                         "one picture")
    longest = max(len(positions) for positions in motions.values())
    step = int(np.ceil(longest / frames))
    times = np.arange(0, longest, step)
    rate: Any = fps / step                                       # Matplotlib's types want an int
    figure, draw = _stage(motions, fps, title, unit, view)
    with rc_context(_SETTINGS), warnings.catch_warnings():
        warnings.filterwarnings("ignore", message="Animation was deleted")
        animation = FuncAnimation(figure, draw, frames=times, cache_frame_data=False, repeat=True)
        text = animation.to_jshtml(fps=rate, embed_frames=True, default_mode="loop")
    return _offline(text, 1000.0 * step / fps), len(times)


class Shown(str):
    """A piece of HTML that a notebook shows when it is the last line of a cell."""

    def _repr_html_(self):
        return str(self)

    def __repr__(self):
        return f"<{len(self)} characters of HTML>"


def show(motions: Mapping[str, np.ndarray], fps: float = 60.0, frames: int = 90, *,
         caption: str = "", title: str = "", unit: str = "cm", view: View = VIEW) -> Shown:
    """`player` for a notebook, with a caption below, such as whose motion it is."""
    fragment, _ = player(motions, fps, frames, title=title, unit=unit, view=view)
    note = caption and f'<div style="font-size: 85%; color: #555555">{html.escape(caption)}</div>'
    return Shown(f'<div style="max-width: 100%">{fragment}{note}</div>')


def _stage(motions: dict[str, np.ndarray], fps: float, title: str, unit: str,
           view: View) -> tuple[Figure, Callable]:
    """A figure with one panel a motion.   ->  Figure, draw(t) that shows frame t in all of them"""
    leg = max(left_leg_length(positions[0]) for positions in motions.values())
    square = round_length(0.7 * leg)
    panel, head = 4.2 if len(motions) < 4 else 3.3, 0.9 if title else 0.55             # inches
    figure = Figure(figsize=(panel * len(motions), panel + head), dpi=_DPI)
    FigureCanvasAgg(figure)
    if title:
        figure.text(0.5, 1.0 - 0.12 / (panel + head), title, fontsize=14, ha="center", va="top")
    clock = figure.text(0.5, 0.01, "", fontsize=11, ha="center", va="bottom", family="monospace")
    figure.text(0.995, 0.01, f"floor squares: {square:g} {unit}", fontsize=9, ha="right",
                va="bottom", color="#555555")
    share, panels = 1 / len(motions), []
    for number, (label, colour) in enumerate(colours(motions).items()):
        ax = figure.add_axes((number * share + 0.004, 0.06, share - 0.008,
                              (panel + 0.2) / (panel + head) - 0.06))
        ax.set(xlim=(-1.35 * leg, 1.35 * leg), ylim=(-0.65 * leg, 2.15 * leg), aspect="equal",
               xticks=[], yticks=[])
        ax.spines[:].set_color("#dddddd")
        ax.text(0.02, 0.98, label, color=colour, fontsize=13, fontweight="bold",
                transform=ax.transAxes, va="top")
        grid = LineCollection([], colors="#dedede", linewidths=0.5, zorder=0, antialiaseds=False)
        ax.add_collection(grid)
        way, = ax.plot([], [], color=colour, linewidth=1.2, alpha=0.5, zorder=1, antialiased=False)
        positions = motions[label]
        root = positions[:, SLOT["Hips"]] * [1.0, 0.0, 1.0]
        camera = gaussian_filter1d(root, 0.2 * fps, axis=0, mode="nearest")
        pose = draw_pose(ax, positions[0] - camera[0], view, colour=colour, width=3.4)
        panels.append((positions, root, camera, grid, way, pose, colour))

    def _draw(t):
        for positions, root, camera, grid, way, pose, colour in panels:
            now = min(int(t), len(positions) - 1)
            move_pose(pose, positions[now] - camera[now], view, colour=colour, width=3.4)
            grid.set_segments(_floor(camera[now], square, 2.4 * leg, view))
            way.set_data(*seen_from(root - camera[now], view)[0].T)
        clock.set_text(f"{t / fps:5.2f} s")
        return ()

    return figure, _draw


def _floor(centre, square, radius, view):
    """The lines of the world's floor grid around a place, projected relative to it.
    (3,)  ->  (lines, 2, 2)
    """
    lines = []
    for axis, other in ((0, 2), (2, 0)):
        places = square * np.arange(np.ceil((centre[axis] - radius) / square),
                                    (centre[axis] + radius) / square)
        ends = np.zeros((len(places), 2, 3))
        ends[:, :, axis] = places[:, None] - centre[axis]
        ends[:, :, other] = [-radius, radius]
        lines.append(ends)
    return seen_from(np.concatenate(lines), view)[0]


def _offline(text: str, interval: float) -> str:
    """Matplotlib's player, changed: it starts by itself, keeps its exact interval (milliseconds),
    needs no icon font from elsewhere, and is the same text each time it is made.
    """
    text = re.sub(r'<link rel="stylesheet"\s+href="https?://[^"]*font-awesome[^"]*">\s*', "", text)
    text = re.sub(r'<i class="fa fa-([^"]*)"></i>', lambda found: _SIGNS.get(found[1], found[1]),
                  text)
    name = re.findall(r'id="_anim_img([0-9a-f]{32})"', text)[0]
    text = text.replace(name, hashlib.sha256(text.replace(name, "").encode()).hexdigest()[:32])
    text = re.sub(r"(anim[0-9a-f]{32}) = "
                  r"(new Animation\(frames, img_id, slider_id, )[^,]*(,\s*loop_select_id\);)",
                  rf"\1 = \g<2>{interval:.6g}\3 \1.play_animation();", text)
    text = text.replace("    width: 36px;", "    min-width: 40px; height: 28px;")
    return text.replace("width: 374px;", "width: 60%;")
