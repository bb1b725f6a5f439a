r"""Motions that move: a page of HTML with a player, in which the figures walk side by side at their
true speed.

The page holds its pictures itself and needs no network. The camera follows each figure's root; a
floor grid that stays in the world and the way on the floor show how far it goes.
"""

import hashlib
import html
import re
import warnings

from matplotlib import rc_context
from matplotlib.animation import FuncAnimation
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure
import numpy as np
from scipy.ndimage import gaussian_filter1d

from ..motion.joints import SLOT
from .plot import (checked, colours, draw_pose, facing_forward, leg_length, move_pose, project,
                   round_length)
from ..storage import atomic_write

# azimuth and elevation of the camera, degrees; see plot.project
VIEW = (-52.0, 16.0)
_DPI = 100
_SIGNS = {
    "minus": "&minus;", "fast-backward": "|&#9664;&#9664;", "step-backward": "|&#9664;",
    "play fa-flip-horizontal": "&#9664;", "pause": "&#10074;&#10074;", "play": "&#9654;",
    "step-forward": "&#9654;|", "fast-forward": "&#9654;&#9654;|", "plus": "+"}


def animation_html(motions, fps, path, frames=90, *, title="", unit="cm", view=VIEW):
    """Write a page with a looping player that starts by itself.

    motions : {label: (T, 21, 3)}, a shorter one stays in its last pose;  fps : their frames a
    second;
    frames : most pictures to draw, taken at equal steps; they are shown for as long as their step
    lasts   ->  number of pictures
    """
    fragment, count = player(motions, fps, frames, title=title, unit=unit, view=view)
    page = (
        '<!DOCTYPE html>\n<html lang="en">\n<head>\n<meta charset="utf-8">\n'
        f"<title>{html.escape(title or ', '.join(motions))}</title>\n</head>\n"
        f'<body style="margin: 8px; font-family: sans-serif; text-align: center">\n{fragment}\n</body>\n</html>\n'
    )
    with atomic_write(path) as file:
        file.write(page)
    return count


def player(motions, fps, frames=90, *, title="", unit="cm", view=VIEW):
    """The player alone, for a notebook or a page of one's own.   ->  HTML (str), number of pictures
    """
    motions = {label: facing_forward(positions) for label, positions in checked(motions).items()}
    if not fps > 0 or frames < 1:
        raise ValueError(
            f"fps, frames: found {fps}, {frames}, needed a rate above 0 and at least one picture")
    longest = max(len(positions) for positions in motions.values())
    step = int(np.ceil(longest / frames))
    times = np.arange(0, longest, step)
    figure, draw = _stage(motions, fps, title, unit, view)
    with rc_context({"animation.embed_limit": 1e6, "savefig.dpi": "figure", "savefig.bbox": None, "savefig.facecolor": "auto"}), \
            warnings.catch_warnings():
        warnings.filterwarnings("ignore", message="Animation was deleted")
        animation = FuncAnimation(figure, draw, frames=times, cache_frame_data=False, repeat=True)
        text = animation.to_jshtml(fps=fps / step, embed_frames=True, default_mode="loop")
    return _offline(text, 1000.0 * step / fps), len(times)


class Shown(str):
    """A piece of HTML that a notebook shows when it is the last line of a cell."""

    def _repr_html_(self):
        return str(self)

    def __repr__(self):
        return f"<{len(self)} characters of HTML>"


def show(motions, fps=60.0, frames=90, *, caption="", title="", unit="cm", view=VIEW):
    """`player` for a notebook, with a caption below, such as whose motion it is.   ->  Shown"""
    fragment, _ = player(motions, fps, frames, title=title, unit=unit, view=view)
    note = f'<div style="font-size: 85%; color: #555555">{html.escape(caption)}</div>' if caption else ""
    return Shown(f'<div style="max-width: 100%">{fragment}{note}</div>')


def _stage(motions, fps, title, unit, view):
    """A figure with one panel a motion.   ->  Figure, draw(t) that shows frame t in all of them"""
    leg = max(leg_length(positions[0]) for positions in motions.values())
    square = round_length(0.7 * leg)
    panel, head = 4.2 if len(motions) < 4 else 3.3, 0.9 if title else 0.55
    figure = Figure(figsize=(panel * len(motions), panel + head), dpi=_DPI)
    FigureCanvasAgg(figure)
    if title:
        figure.text(0.5, 1.0 - 0.12 / (panel + head), title, fontsize=14, ha="center", va="top")
    clock = figure.text(0.5, 0.01, "", fontsize=11, ha="center", va="bottom", family="monospace")
    figure.text(0.995, 0.01, f"floor squares: {square:g} {unit}", fontsize=9, ha="right",
                va="bottom", color="#555555")
    panels = []
    for number, ((label, positions),
                 colour) in enumerate(zip(motions.items(),
                                          colours(motions).values())):
        ax = figure.add_axes(
            (number / len(motions) + 0.004, 0.06, 1 / len(motions) - 0.008, (panel + 0.2) /
             (panel + head) - 0.06))
        ax.set(xlim=(-1.35 * leg, 1.35 * leg), ylim=(-0.65 * leg, 2.15 * leg), aspect="equal",
               xticks=[], yticks=[])
        for spine in ax.spines.values():
            spine.set_color("#dddddd")
        ax.text(0.02, 0.98, label, color=colour, fontsize=13, fontweight="bold",
                transform=ax.transAxes, va="top")
        grid = ax.add_collection(
            LineCollection([], colors="#dedede", linewidths=0.5, zorder=0, antialiaseds=False))
        way = ax.plot([], [], color=colour, linewidth=1.2, alpha=0.5, zorder=1,
                      antialiased=False)[0]
        root = positions[:, SLOT["Hips"]] * [1.0, 0.0, 1.0]
        camera = gaussian_filter1d(root, 0.2 * fps, axis=0, mode="nearest")
        panels.append((positions, root, camera, grid, way,
                       draw_pose(ax, positions[0] - camera[0], view, colour=colour,
                                 width=3.4), colour))

    def draw(t):
        for positions, root, camera, grid, way, artists, colour in panels:
            now = min(int(t), len(positions) - 1)
            move_pose(artists, positions[now] - camera[now], view, colour=colour, width=3.4)
            grid.set_segments(_floor(camera[now], square, 2.4 * leg, view))
            way.set_data(*project(root - camera[now], view)[0].T)
        clock.set_text(f"{t / fps:5.2f} s")
        return ()

    return figure, draw


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
    return project(np.concatenate(lines), view)[0]


def _offline(text, interval):
    """Matplotlib's player, changed: it starts by itself, keeps its exact interval (milliseconds),
    needs no icon font from elsewhere, and is the same text each time it is made."""
    text = re.sub(r'<link rel="stylesheet"\s+href="https?://[^"]*font-awesome[^"]*">\s*', "", text)
    text = re.sub(r'<i class="fa fa-([^"]*)"></i>',
                  lambda match: _SIGNS.get(match.group(1), match.group(1)), text)
    name = re.search(r'id="_anim_img([0-9a-f]{32})"', text).group(1)
    text = text.replace(name, hashlib.sha256(text.replace(name, "").encode()).hexdigest()[:32])
    text = re.sub(
        r"(anim[0-9a-f]{32}) = (new Animation\(frames, img_id, slider_id, "
        r")[^,]*(,\s*loop_select_id\);)",
        rf"\1 = \g<2>{interval:.6g}\3 \1.play_animation();", text)
    return text.replace("width: 374px;",
                        "width: 60%;").replace("    width: 36px;",
                                               "    min-width: 40px; height: 28px;")
