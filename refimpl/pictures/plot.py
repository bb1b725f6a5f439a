r"""Pictures of motions: poses, strips as in Holden 2017's figure 3, root paths, loss curves.

Motions are world positions (T, 21, 3) in the order of joints.SLOTS, y up, in any length unit, which
the pictures name. Figures belong to no window and to no global state: they are
`matplotlib.figure.Figure` with the Agg canvas, the same in a script, a test and a notebook.
"""

import io

from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.colors import to_rgb
from matplotlib.figure import Figure
import numpy as np

from ..motion.joints import PARENTS, SLOT
from ..storage import atomic_write

# Okabe and Ito: told apart by the colour-blind
COLOURS = {"style": "#D55E00", "content": "#009E73", "result": "#0072B2"}
_OTHERS = ("#CC79A7", "#E69F00", "#56B4E9", "#444444", "#0072B2", "#009E73", "#D55E00")
_LINES = ("-", "--", "-.", ":", (0, (5, 1, 1, 1, 1, 1)), (0, (1, 1)))
# degrees, see `project`
VIEWS = {
    "three-quarter": (-62.0, 10.0), "side": (-90.0, 0.0), "front": (0.0, 0.0),
    "above": (-90.0, 90.0)}
DPI = 120

CHAINS = {"trunk": ("Hips", "Spine", "Chest", "Neck", "Head")}
for _side in ("Left", "Right"):
    CHAINS[f"{_side} leg"] = ("Hips",) + tuple(_side + part
                                                for part in ("UpLeg", "Leg", "Foot", "Toe"))
    CHAINS[f"{_side} arm"] = ("Chest",) + tuple(_side + part
                                                 for part in ("Arm", "ForeArm", "Hand", "Finger"))
_INDICES = {name: [SLOT[joint] for joint in chain] for name, chain in CHAINS.items()}


def project(points, view="three-quarter"):
    r"""Orthographic projection. The camera has azimuth a (0: in front of a figure that faces +z,
    -90: at its right hand) and elevation e:

        to camera  c = (sin a cos e, sin e, cos a cos e),   to the right  r = (cos a, 0, -sin a),   upwards  u = c x r

    points : (..., 3), view : a name in VIEWS or (a, e) in degrees  ->  (..., 2) right and up, (...)
    nearness, both in the points' unit
    """
    if isinstance(view, str) and view not in VIEWS:
        raise ValueError(
            f"view: found {view!r}, needed one of {', '.join(VIEWS)} or two angles (azimuth, "
            "elevation) in degrees")
    a, e = np.radians(VIEWS[view] if isinstance(view, str) else view)
    camera = np.array([np.sin(a) * np.cos(e), np.sin(e), np.cos(a) * np.cos(e)])
    right = np.array([np.cos(a), 0.0, -np.sin(a)])
    return np.stack([points @ right, points @ np.cross(camera, right)], axis=-1), points @ camera


def checked(motions):
    """The same dict with float arrays, or a ValueError that says which motion has a wrong shape.
    {label: (T, 21, 3)}
    """
    if not motions:
        raise ValueError("motions: found none, needed at least one label: positions (T, 21, 3)")
    out = {label: np.asarray(positions, dtype=float) for label, positions in motions.items()}
    for label, positions in out.items():
        if positions.ndim != 3 or positions.shape[1:] != (len(PARENTS), 3) or not len(positions):
            raise ValueError(
                f"motions[{label!r}]: found shape {positions.shape}, needed (T, {len(PARENTS)}, 3)")
        if not np.isfinite(positions).all():
            raise ValueError(
                f"motions[{label!r}]: found {positions[~np.isfinite(positions)][0]}, needed finite "
                "positions")
    return out


def colours(labels):
    """A colour for each label: style, content and result have their own, others take what is left.
    ->  {label: colour}
    """
    rest = iter(
        [c for c in _OTHERS if c not in {COLOURS[label] for label in labels if label in COLOURS}] *
        (1 + len(labels)))
    return {label: COLOURS[label] if label in COLOURS else next(rest) for label in labels}


def leg_length(pose):
    """Thigh and shin of the left leg: the yardstick of a figure.   (21, 3)  ->  float"""
    leg = pose[[SLOT["LeftUpLeg"], SLOT["LeftLeg"], SLOT["LeftFoot"]]]
    return float(np.linalg.norm(np.diff(leg, axis=0), axis=1).sum())


def round_length(length):
    """The largest of 1, 2, 5 times a power of ten that is not above."""
    power = 10.0 ** np.floor(np.log10(length))
    return power * max(step for step in (1, 2, 5) if step * power <= length * (1 + 1e-9))


def draw_pose(ax, pose, view="three-quarter", *, colour="#0072B2", width=2.4, shift=(0.0, 0.0)):
    """Draw a pose; limbs on the far side are paler, thinner and behind.

    pose : (21, 3);  width : points;  shift : (right, up) added in the plane
    ->  artists, for `move_pose`
    """
    artists = {
        name: ax.plot([], [], solid_capstyle="round", solid_joinstyle="round")[0]
        for name in CHAINS}
    artists["head"] = ax.fill([], [])[0]
    move_pose(artists, pose, view, colour=colour, width=width, shift=shift)
    return artists


def move_pose(artists, pose, view="three-quarter", *, colour="#0072B2", width=2.4,
              shift=(0.0, 0.0)):
    """Draw another pose with the artists that `draw_pose` returned."""
    flat = project(pose, view)[0] + np.asarray(shift)
    across = pose[SLOT["LeftUpLeg"]] + pose[SLOT["LeftArm"]] - pose[SLOT["RightUpLeg"]] - pose[
        SLOT["RightArm"]]
    # from the front or from behind: Right
    far = "Left" if project(across, view)[1] < -0.3 * np.linalg.norm(across) else "Right"
    pale = tuple(0.45 * np.array(to_rgb(colour)) + 0.55)
    for name, indices in _INDICES.items():
        behind = name.startswith(far)
        artists[name].set_data(*flat[indices].T)
        artists[name].set(color=pale if behind else colour, linewidth=width *
                          (0.8 if behind else 1.0), zorder=2.0 if behind else
                          (3.0 if name == "trunk" else 4.0))
    radius = 0.125 * leg_length(pose)
    neck, head = flat[SLOT["Neck"]], pose[SLOT["Head"]]
    up = head - pose[SLOT["Neck"]]
    centre = project(head + 0.9 * radius * up / max(np.linalg.norm(up), 1e-9),
                     view)[0] + np.asarray(shift)
    angle = np.linspace(0.0, 2 * np.pi, 33)
    artists["head"].set_xy(centre + radius * np.stack([np.cos(angle), np.sin(angle)], axis=-1))
    artists["head"].set(facecolor=colour, edgecolor="none", zorder=3.5)
    return artists


def facing_forward(positions):
    """The motion turned and moved over the floor: its first pose faces +z above the origin.
    (T, 21, 3)  ->  (T, 21, 3)
    """
    first = positions[0]
    across = first[SLOT["LeftArm"]] - first[SLOT["RightArm"]] + first[SLOT["LeftUpLeg"]] - first[
        SLOT["RightUpLeg"]]
    yaw = np.arctan2(-across[2], across[0])
    c, s = np.cos(yaw), np.sin(yaw)
    return (positions - first[SLOT["Hips"]] * [1, 0, 1]) @ np.array([[c, 0, s], [0, 1, 0], [
        -s, 0, c]])


def strip(motions, path=None, *, every=None, title="", view="three-quarter", fps=60.0, unit="cm"):
    """One row a motion, one pose every `every` frames along an axis of seconds, as in Holden 2017's
    figure 3.

    Each pose is drawn at its own place whatever way it has gone, so that none covers another; all
    rows have one scale.

    motions : {label: (T, 21, 3)};  every : frames between poses, about 14 poses unless given;
    path : also save a PNG there   ->  Figure
    """
    motions = {label: facing_forward(positions) for label, positions in checked(motions).items()}
    longest = max(len(positions) for positions in motions.values())
    every = max(1, round(longest / 14)) if every is None else every
    if every < 1 or every != int(every):
        raise ValueError(f"every: found {every}, needed a whole number of frames from 1 on")
    centred = {
        label: positions[::int(every)] - positions[::int(every), :1] * [1, 0, 1]
        for label, positions in motions.items()}
    flat = np.concatenate([project(poses, view)[0] for poses in centred.values()])
    leg = max(leg_length(poses[0]) for poses in centred.values())
    step = 1.04 * (flat[..., 0].max() - flat[..., 0].min())
    count = max(len(poses) for poses in centred.values())
    low, high = min(0.0, flat[..., 1].min()) - 0.08 * leg, flat[..., 1].max() + 0.36 * leg
    wide, right = 13.0, (count - 1) * step + flat[..., 0].max() + 0.1 * leg
    # the part of the width that the longest label takes
    name = min(0.3, 0.135 * max(map(len, motions)) / wide)
    left = flat[..., 0].min() - max(0.5 * leg, (right - flat[..., 0].min()) * name / (1.0 - name))
    row = min(2.6, wide * 0.98 * (high - low) / (right - left))
    figure = _figure(wide, row * len(motions) + 0.62 + (0.35 if title else 0.0))
    axes = figure.subplots(len(motions), 1, squeeze=False)[:, 0]
    bar, thick = round_length(1.3 * leg), min(2.8, 42.0 * wide * leg / (right - left) / 12.0)
    for ax, (label, poses), colour in zip(axes, centred.items(), colours(motions).values()):
        ax.set(xlim=(left, right), ylim=(low, high), aspect="equal", yticks=[])
        ax.plot([left, right], [0, 0], color="#bbbbbb", linewidth=1.0, zorder=1)
        for number, pose in enumerate(poses):
            draw_pose(ax, pose, view, colour=colour, shift=(number * step, 0.0), width=thick)
        ax.text(left, high - 0.04 * leg, label, color=colour, fontsize=13, fontweight="bold",
                va="top")
        top = project(np.array([0.0, bar, 0.0]), view)[0][1]
        ax.plot([left + 0.08 * leg] * 2, [0, top], color="#555555", linewidth=1.6, marker="_",
                markersize=6)
        ax.text(left + 0.16 * leg, 0.5 * top, f"{bar:g} {unit}", color="#555555", fontsize=9,
                va="center", rotation=90)
        seconds = np.arange(count) * every / fps
        ax.set_xticks(
            np.arange(count) * step,
            [f"{s:.2f}" for s in seconds] if ax is axes[-1] else [""] * count, fontsize=10)
        for spine in ("left", "right", "top", "bottom"):
            ax.spines[spine].set_visible(False)
        ax.tick_params(length=3 if ax is axes[-1] else 0)
    axes[-1].set_xlabel("time [s]", fontsize=11)
    return _finish(figure, path, title)


def paths(motions, path=None, *, title="", unit="cm"):
    """The roots' ways over the floor, seen from above: a dot where each begins, an arrow head where
    it ends.

    Forward, z, points to the right and x upwards, so that a turn to the left is seen as one.

    motions : {label: (T, 21, 3)};  path : also save a PNG there   ->  Figure
    """
    motions = checked(motions)
    figure = _figure(7.5, 6.0)
    ax = figure.subplots()
    for (label, positions), colour, line in zip(motions.items(),
                                                colours(motions).values(), _LINES * len(motions)):
        x, z = positions[:, 0, 0], positions[:, 0, 2]
        ax.plot(z, x, color=colour, linestyle=line, linewidth=2.0, label=label)
        ax.plot(z[0], x[0], "o", color=colour, markersize=7)
        if len(x) > 1:
            ax.annotate("", (z[-1], x[-1]), (z[-2], x[-2]),
                        arrowprops={"arrowstyle": "-|>", "color": colour, "mutation_scale": 22})
    ax.set_aspect("equal", adjustable="datalim")
    ax.set_xlabel(f"z, forward [{unit}]", fontsize=11)
    ax.set_ylabel(f"x, left [{unit}]", fontsize=11)
    ax.grid(color="#e4e4e4", linewidth=0.8)
    ax.legend(fontsize=10)
    return _finish(figure, path, title)


def curves(records, keys, path=None, *, title="", ylabel="loss"):
    """Numbers over epochs, one line each, told apart by colour and by dashes.

    records : a sequence of dicts, one an epoch, with the `keys` and perhaps "epoch" (otherwise
    counted from 1);  the scale is logarithmic when every value is positive and they span more than
    a factor of 5   ->  Figure
    """
    records, keys = list(records), [keys] if isinstance(keys, str) else list(keys)
    missing = [key for key in keys if any(key not in record for record in records)]
    if not records or not keys or missing:
        raise ValueError(
            f"records, keys: found {len(records)} records, keys {keys}, missing {missing}; needed "
            "records that have every key")
    epochs = [record.get("epoch", number) for number, record in enumerate(records, start=1)]
    values = np.array([[float(record[key]) for key in keys] for record in records])
    figure = _figure(8.0, 5.0)
    ax = figure.subplots()
    for key, column, colour, line in zip(keys, values.T,
                                         list(_OTHERS[4:] + _OTHERS[:4]) * len(keys),
                                         _LINES * len(keys)):
        ax.plot(epochs, column, color=colour, linestyle=line, linewidth=1.8, label=key,
                marker="o" if len(records) == 1 else None)
    good = values[np.isfinite(values)]
    if good.size and good.min() > 0 and good.max() > 5 * good.min():
        ax.set_yscale("log")
    ax.set_xlabel("epoch", fontsize=11)
    ax.set_ylabel(ylabel, fontsize=11)
    ax.grid(color="#e4e4e4", linewidth=0.8, which="both")
    ax.legend(fontsize=10)
    return _finish(figure, path, title)


def save(figure, path):
    """Write a figure as PNG, whole or not at all; the same figure makes the same bytes."""
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


def _figure(width, height):
    """An empty figure of so many inches, with no tie to a window."""
    figure = Picture(figsize=(width, height), dpi=DPI, layout="constrained")
    FigureCanvasAgg(figure)
    return figure


def _finish(figure, path, title):
    if title:
        figure.suptitle(title, fontsize=14)
    if path is not None:
        save(figure, path)
    return figure
