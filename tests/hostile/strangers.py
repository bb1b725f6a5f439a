"""A second reader, writer and forward kinematics of BVH, and walkers by formulas.

Nothing here is the package's, so that what a command says can be compared with it.
"""

from dataclasses import dataclass
import numpy as np
from scipy.spatial.transform import Rotation

FULL = ("Xposition", "Yposition", "Zposition")


@dataclass(frozen=True)
class Clip:
    """Joints in the file's order, local rotations (F, n, 3, 3), local places (F, n, 3)."""

    names: tuple[str, ...]
    parents: tuple[int, ...]
    offsets: np.ndarray
    channels: tuple[tuple[str, ...], ...]
    ends: tuple[np.ndarray | None, ...]
    turns: np.ndarray
    places: np.ndarray
    step: float


def read(text: str) -> Clip:
    """The clip in `text`; position channels replace the joint's OFFSET."""
    words = iter(text[:text.index("MOTION")].split())
    names, parents, offsets, channels, ends, path = [], [], [], [], [], []
    ending = False
    for word in words:
        if word in ("ROOT", "JOINT"):
            parents.append(path[-1] if path else -1)
            names.append(next(words))
            ends.append(None)
            channels.append(())
            offsets.append(None)
        elif word == "End":
            ending = True
        elif word == "{":
            path.append(len(names) - 1)
        elif word == "}":
            path.pop()
            ending = False
        elif word == "OFFSET":
            place = np.array([float(next(words)) for _ in range(3)])
            if ending:
                ends[path[-1]] = place
            else:
                offsets[path[-1]] = place
        elif word == "CHANNELS":
            channels[path[-1]] = tuple(next(words) for _ in range(int(next(words))))
    lines = text[text.index("MOTION"):].split("\n")
    lines = [line for line in lines if line.strip()]
    frames, step = int(lines[1].split()[1]), float(lines[2].split()[2])
    rows = np.array([[float(x) for x in line.split()] for line in lines[3:]])
    if len(rows) != frames or rows.shape[1] != sum(map(len, channels)):
        raise ValueError(f"{len(rows)} rows of {rows.shape}, where {frames} frames are announced")
    turns = np.tile(np.eye(3), (frames, len(names), 1, 1))
    places = np.tile(np.array(offsets), (frames, 1, 1))
    column = 0
    for joint, listed in enumerate(channels):
        for channel in listed:
            axis = "XYZ".index(channel[0])
            if channel.endswith("position"):
                places[:, joint, axis] = rows[:, column]
            else:
                angles = rows[:, column:column + 1]
                turn = Rotation.from_euler(channel[0].lower(), angles, degrees=True).as_matrix()
                turns[:, joint] = turns[:, joint] @ turn
            column += 1
    if abs(1 / step - round(1 / step)) < 1e-3 / step:
        step = 1 / round(1 / step)
    return Clip(tuple(names), tuple(parents), np.array(offsets), tuple(channels), tuple(ends),
                turns, places, step)


def write(clip: Clip, digits: str = ".12g", tab: str = "\t") -> str:
    """The file of `clip`; rotations of three channels, or of none."""
    lines, depth = ["HIERARCHY"], 0

    def put(line: str) -> None:
        lines.append(tab * depth + line)

    children: dict[int, list[int]] = {}
    for joint, parent in enumerate(clip.parents):
        children.setdefault(parent, []).append(joint)

    def joint_lines(joint: int) -> None:
        nonlocal depth
        put(("ROOT " if clip.parents[joint] < 0 else "JOINT ") + clip.names[joint])
        put("{")
        depth += 1
        put("OFFSET " + " ".join(format(x, digits) for x in clip.offsets[joint]))
        put(" ".join(("CHANNELS", str(len(clip.channels[joint])), *clip.channels[joint])))
        for child in children.get(joint, []):
            joint_lines(child)
        end = clip.ends[joint]
        if end is not None and joint not in children:
            put("End Site")
            put("{")
            lines.append(tab * (depth + 1) + "OFFSET " + " ".join(format(x, digits) for x in end))
            put("}")
        depth -= 1
        put("}")

    joint_lines(0)
    columns = []
    for joint, listed in enumerate(clip.channels):
        order = "".join(c[0] for c in listed if c.endswith("rotation"))
        angles = Rotation.from_matrix(clip.turns[:, joint]).as_euler(
            order, degrees=True, suppress_warnings=True) if order else None
        for channel in listed:
            if channel.endswith("position"):
                columns.append(clip.places[:, joint, "XYZ".index(channel[0])])
            else:
                columns.append(angles[:, order.index(channel[0])])
    lines += ["MOTION", f"Frames: {len(clip.turns)}", f"Frame Time: {clip.step:.9g}"]
    lines += [" ".join(format(x, digits) for x in row) for row in np.array(columns).T]
    return "\n".join(lines) + "\n"


def world(clip: Clip) -> tuple[np.ndarray, np.ndarray]:
    """Turns (F, n, 3, 3) and points (F, n, 3) of all joints in the world."""
    turns, points = clip.turns.copy(), clip.places.copy()
    for joint, parent in enumerate(clip.parents):
        if parent >= 0:
            turns[:, joint] = turns[:, parent] @ clip.turns[:, joint]
            points[:, joint] = points[:, parent] + np.einsum(
                "fij,fj->fi", turns[:, parent], clip.places[:, joint])
    return turns, points


def height(clip: Clip) -> float:
    """From the lowest joint to the highest in the middle frame."""
    points = world(clip)[1][len(clip.turns) // 2]
    return float(max(np.ptp(points, axis=0)))


# ----- walkers by formulas ---------------------------------------------------------------------

BODY = (("Hips", "", 0, 0, 0), ("Spine", "Hips", 0, 11, 0), ("Spine1", "Spine", 0, 14, 0),
        ("Neck1", "Spine1", 0, 22, 0), ("Head", "Neck1", 0, 9, 1),
        ("LeftArm", "Spine1", 18, 17, 0), ("LeftForeArm", "LeftArm", 28, 0, 0),
        ("LeftHand", "LeftForeArm", 25, 0, 0), ("LeftHandIndex1", "LeftHand", 8, 0, 0),
        ("RightArm", "Spine1", -18, 17, 0), ("RightForeArm", "RightArm", -28, 0, 0),
        ("RightHand", "RightForeArm", -25, 0, 0), ("RightHandIndex1", "RightHand", -8, 0, 0),
        ("LeftUpLeg", "Hips", 9, -4, 0), ("LeftLeg", "LeftUpLeg", 0, -42, 0),
        ("LeftFoot", "LeftLeg", 0, -41, 0), ("LeftToeBase", "LeftFoot", 0, -7, 14),
        ("RightUpLeg", "Hips", -9, -4, 0), ("RightLeg", "RightUpLeg", 0, -42, 0),
        ("RightFoot", "RightLeg", 0, -41, 0), ("RightToeBase", "RightFoot", 0, -7, 14))


def walker(rng: np.random.Generator, seconds: float = 3.0, rate: float = 60.0) -> Clip:
    """A walk along +z by formulas: planted feet on half of a cycle and two, legs by two bones."""
    names = tuple(row[0] for row in BODY)
    parents = tuple(names.index(row[1]) if row[1] else -1 for row in BODY)
    offsets = np.array([row[2:] for row in BODY], dtype=float)
    frames = int(seconds * rate)
    time = np.arange(frames) / rate
    period, stride = rng.uniform(1.0, 1.2), rng.uniform(110, 150)
    lean, swing, bounce = rng.uniform(0, 8), rng.uniform(15, 35), rng.uniform(1, 2.5)
    phase = time / period + rng.uniform(0, 1)
    wave = np.sin(2 * np.pi * phase)
    euler = np.zeros((frames, len(names), 3))
    places = np.tile(offsets, (frames, 1, 1))
    hip = 85 + bounce * np.cos(4 * np.pi * phase)
    way = stride * time / period
    places[:, 0] = np.stack([1.5 * np.cos(2 * np.pi * phase), hip + 7, way], axis=1)
    euler[:, names.index("Spine"), 0] = lean
    euler[:, names.index("Spine1"), 1] = 5 * wave
    for side, sign in (("Left", 1), ("Right", -1)):
        own = phase + (0 if sign > 0 else 0.5)
        cycle, share = np.floor(own), own % 1
        rise = np.clip((share - 0.6) / 0.4, 0, 1)
        glide = rise - np.sin(2 * np.pi * rise) / (2 * np.pi)
        foot = stride * (cycle + glide - own + 0.3)
        lift = 12 * np.sin(np.pi * rise) ** 2
        ahead, down = foot, hip + 7 - 4 - 7 - lift
        reach = np.minimum(np.hypot(ahead, down), 82.9)
        knee = np.arccos(np.clip((reach**2 - 42**2 - 41**2) / (2 * 42 * 41), -1, 1))
        first = np.arctan2(ahead, down) + np.arcsin(np.clip(41 * np.sin(knee) / reach, -1, 1))
        thigh, leg, ankle = (names.index(side + part) for part in ("UpLeg", "Leg", "Foot"))
        euler[:, thigh, 0] = -np.degrees(first)
        euler[:, leg, 0] = np.degrees(knee)
        euler[:, ankle, 0] = np.degrees(first - knee) + 18 * np.sin(np.pi * rise) ** 2
        arm, fore = names.index(side + "Arm"), names.index(side + "ForeArm")
        euler[:, arm, 2] = -75 * sign
        euler[:, arm, 0] = sign * swing * wave
        euler[:, fore, 1] = -sign * (25 + 10 * wave * sign)
    turns = Rotation.from_euler("XYZ", euler.reshape(-1, 3), degrees=True).as_matrix()
    turns = turns.reshape(frames, len(names), 3, 3)
    for side in ("Left", "Right"):
        arm = names.index(side + "Arm")
        turns[:, arm] = Rotation.from_euler(
            "XZ", euler[:, arm][:, [0, 2]], degrees=True).as_matrix()
    rotations = ("Zrotation", "Xrotation", "Yrotation")
    listed = tuple((FULL if p < 0 else ()) + rotations for p in parents)
    return Clip(names, parents, offsets, listed,
                tuple(None if j in parents else np.array([0.0, 3, 0]) for j in range(len(names))),
                turns, places, 1 / rate)
