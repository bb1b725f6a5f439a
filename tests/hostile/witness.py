"""World positions by pybvh, an independent BVH library, against those of this package. `python -m
tests.hostile.witness FOLDER`

pybvh 0.9 does not take position channels on any joint but the root. Each clip is therefore
rewritten first: the joint that travels becomes the root with six channels, every other joint keeps
its rotation channels and gets its first frame's position as OFFSET. Both libraries then read the
same file.
"""

from pathlib import Path
import sys
import tempfile
import warnings

import numpy as np

from refimpl.motion import bvh, rotation
from refimpl.motion.skeleton import forward_kinematics, local_pose


def one_root(clip):
    """The clip from its first moving joint on, with position channels there alone.   Clip  ->  Clip
    """
    rotations, translations = local_pose(clip)
    world_rotations, world = forward_kinematics(clip.parents, rotations, translations)
    first = (1 if len(clip.joints) > 1 and clip.joints[1].channels[:3] == bvh.POSITION_CHANNELS
             else 0)
    rotations[:, first], translations[:, first] = world_rotations[:, first], world[:, first]
    joints, columns = [], []
    for j, joint in enumerate(clip.joints[first:]):
        order = joint.rotation_order or "ZXY"
        offset = (0.0, 0.0, 0.0) if j == 0 else tuple(map(float, translations[0, j + first]))
        channels = ((bvh.POSITION_CHANNELS if j == 0 else ())
                    + tuple(f"{axis}rotation" for axis in order))
        end = (joint.end_site if joint.end_site is not None or j + first + 1 < len(clip.joints)
               and clip.joints[j + first + 1].parent == j + first else (0.0, 0.0, 0.0))
        joints.append(bvh.Joint(joint.name, joint.parent - first if j else -1, offset, channels,
                                end))
        columns += (([translations[:, first]] if j == 0 else [])
                    + [np.degrees(rotation.matrix_to_euler(rotations[:, j + first], order))])
    return bvh.Clip(tuple(joints), clip.frame_time, np.concatenate(columns, axis=1))


def largest_difference(path):
    """Largest difference of any joint's world position in any frame, relative to the largest
    coordinate.   path  ->  float
    """
    from pybvh import read_bvh_file
    clip = one_root(bvh.read_bvh(path))
    with tempfile.TemporaryDirectory() as folder:
        same = Path(folder) / "clip.bvh"
        bvh.write_bvh(same, clip)
        with warnings.catch_warnings():
            # its guess of the up axis; positions do not depend on it
            warnings.simplefilter("ignore")
            theirs = read_bvh_file(str(same))
            positions, names = np.asarray(theirs.node_positions()), list(theirs.joint_names)
        ours_clip = bvh.read_bvh(same)
    _, ours = forward_kinematics(ours_clip.parents, *local_pose(ours_clip))
    nodes = [i for i, node in enumerate(theirs.nodes) if node.name in names]
    order = [names.index(joint.name) for joint in ours_clip.joints]
    found = positions[:, [nodes[i] for i in order]]
    return float(np.abs(found - ours).max() / np.abs(ours).max())


if __name__ == "__main__":
    paths = sorted(Path(sys.argv[1]).rglob("*.bvh"))
    differences = [largest_difference(path) for path in paths]
    print(
        f"{len(paths)} clips, largest relative difference {max(differences):.2e} "
        f"({paths[int(np.argmax(differences))].name})")
