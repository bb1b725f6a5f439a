r"""Pictures of motions: poses, strips of poses, root paths, loss curves.

Motions are world positions (T, 21, 3) in the order of `joints.SLOTS`, y up, in any length unit,
which the pictures name. Figures belong to no window and to no global state: they are
`matplotlib.figure.Figure` with the Agg canvas, the same in a script, a test and a notebook.
Lengths of a layout are multiples of a figure's leg; margins of a page are in inches.
"""

import base64
from collections.abc import Iterable, Mapping
import io
from pathlib import Path
from typing import Any

from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.colors import to_rgb
from matplotlib.figure import Figure
import numpy as np

from .staging import OTHERS, colours, facing_forward, round_length
from ..motion.features import checked_positions, leg_length
from ..motion.ground import resting_heights
from ..motion.joints import SLOT
from ..storage import atomic_write

_LINES = ("-", "--", "-.", ":", (0, (5, 1, 1, 1, 1, 1)), (0, (1, 1)))
# Azimuth and elevation of the camera in degrees, see `seen_from`.
VIEWS = {"three-quarter": (-62.0, 10.0), "side": (-90.0, 0.0), "front": (0.0, 0.0),
         "above": (-90.0, 90.0)}
DPI = 120
HEAD_RADIUS, SOLE = 0.125, 0.053                                 # in legs

_LIMBS = {"leg": ("Hips", "{}UpLeg", "{}Leg", "{}Foot", "{}Toe"),
          "arm": ("Chest", "{}Arm", "{}ForeArm", "{}Hand", "{}Finger")}
# The joints of each line that is drawn.
CHAINS = {"trunk": [SLOT[name] for name in ("Hips", "Spine", "Chest", "Neck", "Head")],
          **{f"{side} {limb}": [SLOT[name.format(side)] for name in names]
             for side in ("Left", "Right") for limb, names in _LIMBS.items()}}

View = str | tuple[float, float]


def seen_from(points: np.ndarray,
              view: View = "three-quarter") -> tuple[np.ndarray, np.ndarray]:
    r"""Project points orthographically onto the plane of a picture. The camera has the azimuth a
    (0: in front of a figure that faces +z, -90: at its right hand) and the elevation e:

        to the camera   c = (sin a cos e, sin e, cos a cos e)
        to the right    r = (cos a, 0, -sin a)
        upwards         u = c x r

    points : (..., 3)
    view : a name in VIEWS, or (a, e) in degrees
    ->  (..., 2) right and up, and (...) nearness, both in the unit of the points
    Raises ValueError for an unknown name.

    >>> plane, near = seen_from(np.array([10.0, 170.0, 3.0]), "front")
    >>> plane.tolist(), float(near)
    ([10.0, 170.0], 3.0)
    """
    if isinstance(view, str) and view not in VIEWS:
        raise ValueError(f"view: found {view!r}, needed one of {', '.join(VIEWS)} or two angles "
                         "(azimuth, elevation) in degrees")
    a, e = np.radians(VIEWS[view] if isinstance(view, str) else view)
    camera = np.array([np.sin(a) * np.cos(e), np.sin(e), np.cos(a) * np.cos(e)])
    right = np.array([np.cos(a), 0.0, -np.sin(a)])
    return np.stack([points @ right, points @ np.cross(camera, right)], axis=-1), points @ camera


def checked_motions(motions: Mapping[str, np.ndarray]) -> dict[str, np.ndarray]:
    """The same motions as float arrays.

    motions : {label: (T, 21, 3)}
    Raises ValueError that names the motion whose shape or values are wrong.
    """
    if not motions:
        raise ValueError("motions: found none, needed at least one label: positions (T, 21, 3)")
    return {label: checked_positions(positions, f"motions[{label!r}]")
            for label, positions in motions.items()}


def left_leg_length(pose: np.ndarray) -> float:
    """Thigh plus shin of the left leg in one pose: the yardstick of a picture.

    pose : (21, 3)
    """
    leg = pose[[SLOT["LeftUpLeg"], SLOT["LeftLeg"], SLOT["LeftFoot"]]]
    return float(np.linalg.norm(np.diff(leg, axis=0), axis=1).sum())


def draw_pose(ax: Axes, pose: np.ndarray, view: View = "three-quarter", *, colour: str = "#0072B2",
              width: float = 2.4, shift: tuple[float, float] = (0.0, 0.0)) -> dict[str, Any]:
    """Draw a pose; limbs on the far side are paler, thinner and behind.

    pose : (21, 3)
    width : of a line, in points
    shift : (right, up), added in the plane of the picture
    ->  the artists by name, for `move_pose`
    """
    artists: dict[str, Any] = {
        name: ax.plot([], [], solid_capstyle="round", solid_joinstyle="round")[0]
        for name in CHAINS}
    artists["head"] = ax.fill([], [])[0]
    return move_pose(artists, pose, view, colour=colour, width=width, shift=shift)


def move_pose(artists: dict[str, Any], pose: np.ndarray, view: View = "three-quarter", *,
              colour: str = "#0072B2", width: float = 2.4,
              shift: tuple[float, float] = (0.0, 0.0)) -> dict[str, Any]:
    """Draw another pose with the artists that `draw_pose` returned, and return them again."""
    offset = np.asarray(shift)
    flat = seen_from(pose, view)[0] + offset
    across = (pose[SLOT["LeftUpLeg"]] + pose[SLOT["LeftArm"]]
              - pose[SLOT["RightUpLeg"]] - pose[SLOT["RightArm"]])
    # Seen from the front or from behind neither side is far: the right one is taken.
    far = "Left" if seen_from(across, view)[1] < -0.3 * np.linalg.norm(across) else "Right"
    pale = tuple(0.45 * np.array(to_rgb(colour)) + 0.55)
    for name, joints in CHAINS.items():
        behind = name.startswith(far)
        artists[name].set_data(*flat[joints].T)
        artists[name].set(color=pale if behind else colour,
                          linewidth=width * (0.8 if behind else 1.0),
                          zorder=2.0 if behind else 3.0 if name == "trunk" else 4.0)
    head, radius = pose[SLOT["Head"]], HEAD_RADIUS * left_leg_length(pose)
    up = head - pose[SLOT["Neck"]]
    centre = seen_from(head + 0.9 * radius * up / max(np.linalg.norm(up), 1e-9), view)[0] + offset
    angle = np.linspace(0.0, 2 * np.pi, 33)
    artists["head"].set_xy(centre + radius * np.stack([np.cos(angle), np.sin(angle)], axis=-1))
    artists["head"].set(facecolor=colour, edgecolor="none", zorder=3.5)
    return artists


def ground_height(positions: np.ndarray) -> float:
    """Where the soles of a motion stand: below its resting toe joints by what a shoe takes, 0.053
    of a leg.   positions : (T, 21, 3)  ->  y"""
    return float(resting_heights(positions)[1::2].min() - SOLE * leg_length(positions))


def strip(motions: Mapping[str, np.ndarray], path: str | Path | None = None, *,
          every: int | None = None, title: str = "", view: View = "three-quarter",
          fps: float = 60.0, unit: str = "cm") -> Figure:
    """One row a motion, one pose every `every` frames along an axis of seconds, as in figure 3 of
    Holden et al. 2017.

    Each pose is drawn at its own place whatever way it has gone, so that none covers another; all
    rows have one scale, and the ground that the first motion stands on.

    motions : {label: (T, 21, 3)}
    path : also save a PNG there
    every : frames between poses, about 14 poses unless given
    fps : frames a second
    """
    motions = {label: facing_forward(p) for label, p in checked_motions(motions).items()}
    ground = ground_height(next(iter(motions.values())))
    motions = {label: p - [0.0, ground, 0.0] for label, p in motions.items()}
    longest = max(len(positions) for positions in motions.values())
    every = max(1, round(longest / 14)) if every is None else every
    if every < 1 or every != int(every):
        raise ValueError(f"every: found {every}, needed a whole number of frames from 1 on")
    centred = {label: positions[::int(every)] - positions[::int(every), :1] * [1, 0, 1]
               for label, positions in motions.items()}
    flat = np.concatenate([seen_from(poses, view)[0] for poses in centred.values()])
    leg = max(left_leg_length(poses[0]) for poses in centred.values())
    start, end = flat[..., 0].min(), flat[..., 0].max()          # of the widest pose
    step = 1.04 * (end - start)
    count = max(len(poses) for poses in centred.values())
    low, high = min(0.0, flat[..., 1].min()) - 0.08 * leg, flat[..., 1].max() + 0.36 * leg
    wide, right = 13.0, (count - 1) * step + end + 0.1 * leg
    name = min(0.3, 0.135 * max(map(len, motions)) / wide)       # share of the longest label
    left = start - max(0.5 * leg, (right - start) * name / (1.0 - name))
    row = min(2.6, wide * 0.98 * (high - low) / (right - left))
    figure = new_figure(wide, row * len(motions) + 0.62 + (0.35 if title else 0.0))
    axes = figure.subplots(len(motions), 1, squeeze=False)[:, 0]
    bar, thick = round_length(1.3 * leg), min(2.8, 42.0 * wide * leg / (right - left) / 12.0)
    for ax, (label, poses), colour in zip(axes, centred.items(), colours(motions).values()):
        ax.set(xlim=(left, right), ylim=(low, high), aspect="equal", yticks=[])
        ax.plot([left, right], [0, 0], color="#bbbbbb", linewidth=1.0, zorder=1)
        for number, pose in enumerate(poses):
            draw_pose(ax, pose, view, colour=colour, shift=(number * step, 0.0), width=thick)
        ax.text(left, high - 0.04 * leg, label, color=colour, fontsize=13, fontweight="bold",
                va="top")
        top = seen_from(np.array([0.0, bar, 0.0]), view)[0][1]
        ax.plot([left + 0.08 * leg] * 2, [0, top], color="#555555", linewidth=1.6, marker="_",
                markersize=6)
        ax.text(left + 0.16 * leg, 0.5 * top, f"{bar:g} {unit}", color="#555555", fontsize=9,
                va="center", rotation=90)
        seconds = [f"{s:.2f}" if ax is axes[-1] else "" for s in np.arange(count) * every / fps]
        ax.set_xticks(np.arange(count) * step, seconds, fontsize=10)
        ax.spines[:].set_visible(False)
        ax.tick_params(length=3 if ax is axes[-1] else 0)
    axes[-1].set_xlabel("time [s]", fontsize=11)
    return finished(figure, path, title)


def paths(motions: Mapping[str, np.ndarray], path: str | Path | None = None, *, title: str = "",
          unit: str = "cm") -> Figure:
    """The roots' ways over the floor, seen from above: a dot where each begins, an arrow head where
    it ends.

    Forward, z, points to the right and x upwards, so that a turn to the left is seen as one.

    motions : {label: (T, 21, 3)}
    path : also save a PNG there
    """
    motions = checked_motions(motions)
    figure = new_figure(7.5, 6.0)
    ax = figure.subplots()
    for positions, (label, colour), line in zip(motions.values(), colours(motions).items(),
                                                _LINES * len(motions)):
        x, _, z = positions[:, SLOT["Hips"]].T
        ax.plot(z, x, color=colour, linestyle=line, linewidth=2.0, label=label)
        ax.plot(z[0], x[0], "o", color=colour, markersize=7)
        if len(x) > 1:
            ax.annotate("", (z[-1], x[-1]), (z[-2], x[-2]),
                        arrowprops={"arrowstyle": "-|>", "color": colour, "mutation_scale": 22})
    ax.set_aspect("equal", adjustable="datalim")
    _label(ax, f"z, forward [{unit}]", f"x, left [{unit}]")
    return finished(figure, path, title)


def curves(records: Iterable[Mapping[str, Any]], keys: str | Iterable[str],
           path: str | Path | None = None, *, title: str = "", ylabel: str = "loss") -> Figure:
    """Numbers over epochs, one line each, told apart by colour and by dashes.

    The scale is logarithmic when every value is positive and they span more than a factor of 5.

    records : a dict an epoch, with the `keys` and perhaps "epoch" (otherwise counted from 1)
    path : also save a PNG there
    Raises ValueError where a record lacks a key.
    """
    records, keys = list(records), [keys] if isinstance(keys, str) else list(keys)
    missing = [key for key in keys if any(key not in record for record in records)]
    if not records or not keys or missing:
        raise ValueError(f"records, keys: found {len(records)} records, keys {keys}, missing "
                         f"{missing}; needed records that have every key")
    epochs = [record.get("epoch", number) for number, record in enumerate(records, start=1)]
    values = np.array([[float(record[key]) for key in keys] for record in records])
    figure = new_figure(8.0, 5.0)
    ax = figure.subplots()
    for key, column, colour, line in zip(keys, values.T, (OTHERS[4:] + OTHERS[:4]) * len(keys),
                                         _LINES * len(keys)):
        ax.plot(epochs, column, color=colour, linestyle=line, linewidth=1.8, label=key,
                marker="o" if len(records) == 1 else None)
    good = values[np.isfinite(values)]
    if good.size and good.min() > 0 and good.max() > 5 * good.min():
        ax.set_yscale("log")
    _label(ax, "epoch", ylabel)
    return finished(figure, path, title)


def save(figure: Figure, path: str | Path) -> None:
    """Write a PNG, whole or not at all; the same figure makes the same bytes."""
    with atomic_write(path, "wb") as file:
        figure.savefig(file, format="png", dpi=DPI, metadata={"Software": None})


class Picture(Figure):
    """A figure that a notebook shows when it is the last line of a cell, whatever backend is in use
    there.
    """

    def _repr_png_(self):
        file = io.BytesIO()
        self.savefig(file, format="png", metadata={"Software": None})
        return file.getvalue()


class Described:
    """A figure and what it shows, in words, for who cannot see it; a notebook shows both."""

    def __init__(self, figure: Figure, alt: str):
        self.figure, self.alt = figure, alt

    def __repr__(self):
        return self.alt

    def _repr_mimebundle_(self, include=None, exclude=None):
        file = io.BytesIO()
        self.figure.savefig(file, format="png", dpi=100, metadata={"Software": None})
        return ({"image/png": base64.b64encode(file.getvalue()).decode(), "text/plain": self.alt},
                {"image/png": {"alt": self.alt}})


def described(figure: Figure, alt: str) -> Described:
    """A figure with an alternative text, as the last line of a notebook's cell, in the place of
    `plt.show()`.

    alt : what the picture shows, in a sentence

    >>> described(Figure(), "an empty picture")
    an empty picture
    """
    from matplotlib import pyplot                # a notebook has it; what else draws here does not
    pyplot.close(figure)
    return Described(figure, alt)


def new_figure(width: float, height: float) -> Figure:
    """An empty figure of so many inches, with no tie to a window."""
    figure = Picture(figsize=(width, height), dpi=DPI, layout="constrained")
    FigureCanvasAgg(figure)
    return figure


def _label(ax, across, up):
    ax.set_xlabel(across, fontsize=11)
    ax.set_ylabel(up, fontsize=11)
    ax.grid(color="#e4e4e4", linewidth=0.8, which="both")
    ax.legend(fontsize=10)


def finished(figure: Figure, path: str | Path | None, title: str) -> Figure:
    """The figure with its title, saved where that is asked for."""
    if title:
        figure.suptitle(title, fontsize=14)
    if path is not None:
        save(figure, path)
    return figure
