"""The papers' figures: the two networks, strips of exemplar, content and results, what projection
mends, and a sheet of many results.
"""

from collections.abc import Mapping, Sequence
from pathlib import Path

from matplotlib.figure import Figure
import numpy as np

from .plot import (View, checked_motions, colours, draw_pose, facing_forward, ground_height,
                   left_leg_length, new_figure, save)


def _poses(positions, count):
    """Some poses of a motion at equal times, each at its own place, on a floor at 0, its leg 1."""
    forward = facing_forward(positions)
    forward = (forward - [0.0, ground_height(forward), 0.0]) / left_leg_length(forward[0])
    chosen = forward[np.linspace(0, len(forward) - 1, count).round().astype(int)]
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
    if title:
        figure.suptitle(title, fontsize=13)
    if path is not None:
        save(figure, path)
    return figure
