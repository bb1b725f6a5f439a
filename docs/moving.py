"""Draws `styles.gif`, the moving picture of the README: an embedded walk, and what three styles in
the box make of it.

    python docs/moving.py
"""

from pathlib import Path

from matplotlib.animation import FuncAnimation, PillowWriter
import matplotlib.pyplot as plt
import numpy as np

import refimpl
from refimpl.embedded.walkers import make_clip
from refimpl.motion.body import make_take
from refimpl.motion.features import root_path
from refimpl.pictures import plot

STEP, VIEW = 3, (-62.0, 8.0)                 # of 60 frames a second; where the camera stands
COLOURS = {"content": "#009E73", "old": "#0072B2", "depressed": "#CC79A7", "zombie": "#D55E00"}


def main():
    """Write it."""
    made = make_clip("walk", seconds=5.0, seed=3)
    lands = np.flatnonzero(np.diff(made.phase) < -0.5)           # whole cycles make a loop
    frames = np.arange(lands[0], lands[2], STEP)
    take = make_take(made.clip)
    motions = {"content": take.positions} | {
        name: refimpl.style(name).transform(take).stylised.positions for name in list(COLOURS)[1:]}
    figure, axes = plt.subplots(1, len(motions), figsize=(6.4, 2.2), dpi=100)
    figure.subplots_adjust(0, 0, 1, 1, 0, 0)

    def draw(frame):
        for ax, (name, positions) in zip(axes, motions.items()):
            ax.clear()
            x, z = root_path(take.positions)[frame]
            plot.draw_pose(ax, positions[frame] - [x, 0, z], VIEW, colour=COLOURS[name])
            ax.set(xlim=(-75, 75), ylim=(-22, 158), aspect="equal")
            ax.axis("off")
            ax.text(0, -18, name, ha="center", color=COLOURS[name])

    writer = PillowWriter(fps=60 // STEP, metadata={"comment": "refimpl"})
    FuncAnimation(figure, draw, frames=frames, init_func=lambda: None).save(
        Path(__file__).with_name("styles.gif"), writer=writer)


if __name__ == "__main__":
    main()
