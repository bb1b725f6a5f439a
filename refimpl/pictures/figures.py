"""The papers' figures: the two networks (1), what projection mends (2), and sheets of exemplar,
content and results (3, 4).
"""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from matplotlib.figure import Figure
import numpy as np

from .plot import (View, checked_motions, colours, draw_pose, facing_forward, finished,
                   ground_height, left_leg_length, new_figure)


GREY = "#9a9a9a"


def _poses(positions, count, begin=0.0, end=1.0):
    """Some poses of a motion at equal times, each at its own place and facing as the first does, on
    a floor at 0, its leg 1.
    """
    whole = facing_forward(positions)
    forward = (whole - [0.0, ground_height(whole), 0.0]) / left_leg_length(whole[0])
    last = len(forward) - 1
    chosen = forward[np.linspace(begin * last, end * last, count).round().astype(int)]
    return chosen - chosen[:, :1] * [1.0, 0.0, 1.0]


def sheet(rows: Sequence[tuple[Mapping[str, np.ndarray], str]], path: str | Path | None = None, *,
          poses: int = 8, most: int = 12, views: Sequence[View] = ("three-quarter",),
          title: str = "") -> Figure:
    """A contact sheet: a line a row, its motions side by side in their colours, some poses of each
    at equal times.

    rows : ({label: positions (T, 21, 3)}, what to write) each;  most : of more rows some, spread
    views : the poses of each row are seen from each of them, one below the other
    path : also save a PNG there
    """
    chosen = [rows[n] for n in sorted({round(n) for n in np.linspace(0, len(rows) - 1, most)})]
    lines = [(checked_motions(motions), text if view == views[0] else "", view)
             for motions, text in chosen for view in views]
    labels = list(dict.fromkeys(label for motions, _, _ in lines for label in motions))
    chosen_colours = colours(labels)
    figure = new_figure(1.2 + 4.2 * len(labels), 1.15 * len(lines) + 0.7)
    axes = figure.subplots(len(lines), 1, squeeze=False)[:, 0]
    step, gap = 1.25, 1.2
    for ax, (motions, text, view) in zip(axes, lines):
        for n, label in enumerate(labels):
            if label not in motions:
                continue
            begin = n * (poses * step + gap)
            for place, pose in enumerate(_poses(motions[label], poses)):
                draw_pose(ax, pose, view, colour=chosen_colours[label],
                          shift=(begin + place * step, 0.0), width=1.7)
            if ax is axes[0]:
                ax.text(begin + (poses - 1) * step / 2, 2.55, label, ha="center", fontsize=12,
                        fontweight="bold", color=chosen_colours[label])
        wide = len(labels) * (poses * step + gap) - gap
        ax.plot([-0.6, wide - step / 2], [0, 0], color="#cccccc", linewidth=0.8, zorder=1)
        ax.text(-0.7, 2.15, text, fontsize=8, color="#333333", va="bottom")
        ax.set(xlim=(-0.8, wide), ylim=(-0.15, 2.5), aspect="equal")
        ax.axis("off")
    return finished(figure, path, title)


def draw_projection(transformed: np.ndarray, projected: np.ndarray,
                    path: str | Path | None = None, *, poses: int = 10,
                    views: Sequence[View] = ("side", "front"), title: str = "") -> Figure:
    """Figure 2: what a network puts out in grey, what projection makes of it in blue over it, from
    one third of the motion to two.   transformed, projected : (T, 21, 3) of one path
    """
    checked_motions({"transformed": transformed, "projected": projected})
    figure = new_figure(1.35 * poses, 2.6 * len(views) + 0.4)
    axes = figure.subplots(len(views), 1, squeeze=False)[:, 0]
    for ax, view in zip(axes, views):
        for motion, colour, wide in ((transformed, GREY, 3.4), (projected, "#0072B2", 1.5)):
            for place, pose in enumerate(_poses(motion, poses, 1 / 3, 2 / 3)):
                draw_pose(ax, pose, view, colour=colour, shift=(1.25 * place, 0.0), width=wide)
        ax.set(xlim=(-0.7, 1.25 * poses - 0.5), ylim=(-0.1, 2.3), aspect="equal")
        ax.axis("off")
        ax.text(-0.65, 2.15, view, fontsize=9, color="#555555")
    return finished(figure, path, title)


def draw_networks(signals: Sequence[tuple[str, np.ndarray, str]],
                  filters: Sequence[tuple[str, np.ndarray]], path: str | Path | None = None, *,
                  title: str = "") -> Figure:
    """Figure 1: what flows through networks, left to right, each signal an image whose height is
    its number of channels, and between two signals the filters that make one of the other: how
    strong each is for each pair of channels.

    signals : (name, (channels, frames), colour of the frame);  filters : (name, (out, in, width)),
    one fewer
    """
    figure = new_figure(2.35 * len(signals), 5.6)
    figure.set_layout_engine("none")
    most = max(signal.shape[0] for _, signal, _ in signals)
    cell = 1.0 / len(signals)
    for n, (name, signal, colour) in enumerate(signals):
        tall = 0.1 + 0.46 * signal.shape[0] / most
        ax: Any = figure.add_axes((n * cell + 0.12 * cell, 0.58 - tall / 2, 0.5 * cell, tall))
        size = np.quantile(np.abs(signal), 0.98) or 1.0
        ax.imshow(signal, aspect="auto", cmap="RdBu_r", vmin=-size, vmax=size,
                  interpolation="nearest")
        ax.set(xticks=[], yticks=[])
        ax.spines[:].set(color=colour, linewidth=3)
        ax.set_title(f"{name}\n{signal.shape[0]} x {signal.shape[1]}", fontsize=11, color=colour)
        if n < len(filters):
            label, weights = filters[n]
            ax = figure.add_axes(((n + 0.64) * cell, 0.06, 0.44 * cell, 0.16))
            ax.imshow(np.linalg.norm(weights, axis=-1), aspect="auto", cmap="Greys")
            ax.set(xticks=[], yticks=[])
            ax.set_title(f"{label}\n{' x '.join(map(str, weights.shape))}", fontsize=9)
            figure.text((n + 0.86) * cell, 0.57, "$\\rightarrow$", fontsize=26, ha="center",
                        color="#444444")
    return finished(figure, path, title)
