"""Where real code breaks: samples for the system of 2006. Angles near none, half and whole turns;
data on which approximate searches fail; ties, empty and full solutions; sizes and their relations.
"""

import numpy as np

from . import definitions_learning as learning, definitions_torresani as plain
from .ground_nn import along
from .specification import Sample, called

SIZES = (1, 2, 8, 9, 16, 17, 31, 32, 33, 64, 65, 129)
AWAY = 10.0 ** -np.arange(1.0, 16.0)                         # radians from a singular angle


def walk(rng: np.random.Generator, frames: int, angles: int = 3) -> np.ndarray:
    """A smooth sequence: steps of a random walk."""
    return rng.standard_normal((frames, angles)).cumsum(axis=0) * 0.2


def time_warps(rng: np.random.Generator) -> list[Sample]:
    """Sizes, and pairs on which a search in a band or in coarse steps fails: whole numbers, long
    waits, a sequence against its shifted self."""
    found = along({"frames": 4, "angles": 2}, lambda frames, angles:
                  called("", walk(rng, frames, angles), walk(rng, frames + 3, angles)), SIZES)
    for number in range(8):
        size = (1.0, 10.0, 1e3)[number % 3]                      # an absolute margin fails at one
        found.append(called(f"whole numbers {number}",
                            rng.integers(0, 4, (24 + number % 2, 1)) * size,
                            rng.integers(0, 4, (25, 1)) * size))
    for number in range(6):
        X, Y = (rng.integers(0, 3, (9, 1)).astype(float) for _ in range(2))
        found.append(called(f"ways nearly as short {number}",
                            X, Y + 1e-8 * rng.integers(-2, 3, Y.shape)))
    long = walk(rng, 270)
    found += [called(f"{m} frames against {n} like them", long[:m], long[:n] + 1e-3, large=True)
              for m, n in ((129, 140), (257, 270))]
    exact = 2.0 ** 30 + rng.integers(0, 40, (12, 2)) / 8
    found.append(called("near each other, far from zero", exact, exact[::2] + 0.25, firm=True))
    X = walk(rng, 30)
    waits = np.concatenate([X[:1].repeat(20, axis=0), X, X[-1:].repeat(3, axis=0)])
    spikes = np.zeros((40, 1))
    spikes[[3, 30]] = 5.0
    far = rng.standard_normal((131, 2)), rng.standard_normal((127, 2))
    far[0][0] += 3e4                                     # its cost is in every sum
    found.append(called("long, one frame far away", *far, large=True))
    return found + [
        called("large numbers", X * 1e6, X[::-2] * 1e6),
        called("nearly equal ways", np.round(X, 1) + 1e-8 * rng.standard_normal(X.shape),
               np.round(X[::2], 1)), called("a long wait at the beginning", X, waits),
        called("against itself, shifted", X, np.roll(X, 11, axis=0)),
        called("spikes far apart", spikes, np.roll(spikes, 9, axis=0)),
        called("three against many", walk(rng, 3), walk(rng, 50)),
        called("backwards", X, X[::-1].copy()), called("far from zero", X + 1e4, X[::2] + 1e4)]


def clusters(rng: np.random.Generator) -> list[Sample]:
    """Counts; chains that join late; none and all alike; one element."""
    def _distances(count):
        d = rng.uniform(0, 1, (count, count))
        d = d + d.T
        np.fill_diagonal(d, 0)
        return d
    found = along({"count": 4},
                  lambda count: called("", _distances(count), threshold=1.2 / count), SIZES)
    order = rng.permutation(20)
    chain = np.abs(np.subtract.outer(order, order)).astype(float)
    unknown = chain.copy()
    unknown[[2, 9], [9, 2]], unknown[[4, 7], [7, 4]] = np.nan, np.inf
    for count in (3, 5, 7, 9, 15, 17, 31, 33, 64):            # links to be followed one by one
        order = rng.permutation(count)
        links = np.where(np.abs(np.subtract.outer(order, order)) <= 1, 0.2, 5.0)
        found.append(called(f"a chain of {count}", links * (1 - np.eye(count)), threshold=1.0))
    far = 5.0 * (1 - np.eye(5))
    far[[0, 1], [1, 0]] = np.nan
    return found + [
        called("unknown beside far", far, threshold=1.0),
        called("unknown and infinite distances", unknown, threshold=1.5),
        called("a long chain", chain, threshold=1.5), called("every second", chain, threshold=1.0),
        called("one alone", np.zeros((1, 1)), threshold=1.0),
        called("all the same", np.zeros((6, 6)), threshold=0.5),
        called("two groups in turns", np.where(np.add.outer(np.arange(9), np.arange(9)) % 2,
                                               5.0, 1.0) * (1 - np.eye(9)), threshold=2.0)]


def interpolations(rng: np.random.Generator) -> list[Sample]:
    """Lengths, paths with waits, headings that turn beyond a whole turn, each axis up."""
    found = []
    for frames, others in ((5, 33), (33, 5), (64, 65), (1, 1), (2, 9), (17, 17)):
        X, Y = walk(rng, frames), walk(rng, others)
        roots = [walk(rng, len(x), 4) for x in (X, Y)]
        path = plain.dtw_path(X, Y)
        for alpha in (0.25, 0.75):
            found.append(called(f"{frames} against {others} frames, alpha {alpha:g}",
                                X, Y, *roots, path, alpha=alpha))
        roots[0][:, 3] = np.linspace(0, 7, frames)
        roots[1][:, 3] = np.linspace(3.1, -3.3, others) + 2 * np.pi
        found.append(called(f"{frames} against {others} frames, turning", X,
                            Y, *roots, path, alpha=0.4, up="z", smooth=2.0, factors=(30.0, 30.0)))
    return found


def segmentations(rng: np.random.Generator) -> list[Sample]:
    """Fragments of many lengths, of which one is like the beginning of another; whole numbers."""
    found = []
    for lengths in ((2,) * 9, (8, 9, 16), (17, 3, 1, 1, 33), (1, 1, 1), (31, 32)):
        frames = walk(rng, sum(lengths))
        pieces = plain.sequences(frames, lengths)
        order = rng.integers(0, len(lengths), 4)
        Y = np.concatenate([np.repeat(pieces[k], 1 + number % 2, axis=0)
                            for number, k in enumerate(order)])
        found.append(called(f"lengths {lengths}",
                            Y + 0.02 * rng.standard_normal(Y.shape), frames, lengths=lengths))
    like = np.concatenate([np.arange(6.0), np.arange(3.0), [9.0, 9, 9]])[:, None]
    Y = np.array([0.0, 1, 2, 0, 1, 2, 3, 4, 5, 9, 9, 0, 1, 2])[:, None]
    found.append(called("one is the beginning of another", Y, like, lengths=(6, 3, 3)))
    for number in range(9):
        size = (1.0, 10.0, 1e3)[number % 3]                      # an absolute margin fails at one
        found.append(called(f"whole numbers {number}", rng.integers(0, 3, (20, 1)) * size,
                            rng.integers(0, 3, (12, 1)) * size, lengths=(5, 3, 4)))
    trap = np.array([0.0, 0, 0, 9, 9, 9, 9]), np.array([0.0, 0, 0, 3, 3, 3, 9, 9, 9, 9])
    found += [called(f"a good beginning with a bad end, {size:g}", size * trap[0][:, None],
                     size * trap[1][:, None], lengths=(3, 7)) for size in (0.1, 1.0, 30.0)]
    A, Y = np.arange(3.0)[:, None], np.array([0.3, 1.2, 2.4, 0.2, 1.3, 2.3])[:, None]
    found += [called(f"two fragments {step:g} apart", Y,
                     np.concatenate([A, A + step]), lengths=(3, 3)) for step in (2e-7, -2e-7, 1e-4)]
    for count in (140, 270):                                     # numbers of fragments, in a byte
        poses = np.arange(0, 2.0 * count, 2)[:, None]
        few = poses[[3, count // 2, 126, 129, count - 1]] + 0.1
        found.append(called(f"{count} fragments of one frame", few, poses, lengths=(1,) * count,
                            large=True))
    many = np.concatenate([0.3 * rng.standard_normal((60, 2)), 10 + rng.standard_normal((4, 2)),
                           rng.standard_normal((4, 2)) - 10])
    found.append(called("many fragments, two far ones", many[-8:] + 0.01, many, lengths=(4,) * 17))
    return found


def components(rng: np.random.Generator) -> list[Sample]:
    """Many and few sequences and components, lengths that are stretched and shrunk."""
    found = []
    for lengths, count, length in (((5,) * 17, 3, 8), ((33, 2, 16, 9), 3, 9), ((64, 65, 31), 2, 32),
                                   ((4, 4, 4, 4), 1, 4), ((7, 12), 1, 50), ((6,) * 33, 5, 6)):
        found.append(
            called(f"{len(lengths)} sequences, {count} components, length {length}",
                   walk(rng, sum(lengths)), lengths=lengths, components=count, length=length))
    strong, weak = rng.standard_normal((2, 12))
    sizes = rng.standard_normal((5, 2)) * [1.0, 1e-3]
    found.append(called("a weak direction beside a strong one",
                        (sizes @ np.stack([strong, weak])).reshape(20, 3),
                        lengths=(4,) * 5, components=2, length=4, factors=(1.0, 10.0, 1.0)))
    for gap in (1e-11, -1e-11, 1e-7):
        axis = np.array([[0.5, -0.5 - gap], [0.1, 0.3]])
        moved = np.concatenate([size * axis for size in (-1.0, 0.25, 1.5)])
        found.append(called(f"two numbers of one size, but for {gap:g}",
                            moved, lengths=(2, 2, 2), components=1, length=2))
    alike = rng.standard_normal((24, 2)) * [1.0, 0.999]
    alike -= alike.mean(axis=0)
    alike, _ = np.linalg.qr(alike)
    found.append(called("variances that are nearly equal",
                        alike * [1.0, 0.995], lengths=(1,) * 24, components=2, length=1))
    return found


def vectors(rng: np.random.Generator) -> list[Sample]:
    """Turns near 0, pi and 2 pi, on both sides, about axes of both signs and the coordinates'."""
    axes = np.concatenate([np.eye(3), -np.eye(3), rng.standard_normal((4, 3))])
    axes /= np.linalg.norm(axes, axis=1)[:, None]
    found = [
        called("near none", np.concatenate([axes * a for a in AWAY])),
        called("as good as none", np.concatenate([axes * a for a in (1e-20, 1e-100, 1e-160, 1e-170,
                                                                     1e-200, 1e-300, 1e-310)])),
        called("many turns", np.concatenate([axes * a for a in (50.0, 1e3, 1e5)]), factors=(1e5,))]
    for label, angle in (("half a turn", np.pi), ("a whole turn", 2 * np.pi)):
        for side in (-1, 1):
            found.append(called(f"near {label}, {'below' if side < 0 else 'above'}",
                                np.concatenate([axes * (angle + side * a) for a in AWAY])))
    found += [
        called("exactly half a turn and a whole one",
               np.concatenate([axes * np.pi, axes * 2 * np.pi])),
        called("one among many that turn",
               np.concatenate([rng.standard_normal((4, 3)), np.zeros((1, 3)), 1e-9 * axes[:2]]))]
    return found + along({"turns": 2},
                         lambda turns: called("", rng.standard_normal((turns, 3))), SIZES)


def matrices(rng: np.random.Generator) -> list[Sample]:
    """The same turns as matrices; products of many turns, which are rotations up to rounding."""
    found = []
    for sample in vectors(rng):
        v = sample.inputs[0]
        angle = np.linalg.norm(v, axis=1)
        below = v[angle <= np.pi - 1e-6]
        if len(below) and angle.max() > 1e-16:           # of less nothing is left in a matrix
            found.append(called(sample.label, learning.exponential_map(below),
                                large=sample.large, factors=(_steep(below),)))
    half = np.array([2 * np.outer(a, a) - np.eye(3) for a in (
        (1.0, 0, 0), (0, 1.0, 0), (0, 0, 1.0), (0.6, 0.8, 0), (0.8, 0, 0.6), (0, 0.6, 0.8),
        (0.6, -0.8, 0), (0.8, 0, -0.6), (0, 0.6, -0.8), (0.48, -0.6, 0.64), (0.48, 0.6, -0.64),
        (-0.48, 0.6, 0.64))])
    products = [np.eye(3)]
    for _ in range(50):
        turn = learning.exponential_map(0.3 * rng.standard_normal((1, 3)))[0]
        products.append(products[-1] @ turn)
    many = np.array(products)
    angles = np.arccos(np.clip((np.trace(many, axis1=1, axis2=2) - 1) / 2, -1, 1))
    return found + [called("half turns about many axes", half),
                    called("products of many", many[angles < 3.0])]


def _steep(vectors):
    """Near half a turn the vector is sure only to eps / (pi - angle)."""
    nearest = (np.pi - np.linalg.norm(vectors, axis=1)).min()
    return float(max(1.0, 0.1 / max(nearest, 1e-6)))


def continuous(rng: np.random.Generator) -> list[Sample]:
    """Sequences through half and whole turns, back and forth, of several joints."""
    found = []
    for label, angles in (("through half a turn", np.linspace(2.8, 3.5, 33)),
                          ("back and forth", 3.1 + 0.3 * np.sin(np.linspace(0, 9, 64))),
                          ("the other way", np.linspace(0.2, -7.0, 65)),
                          ("standing", np.full(9, 1.0)),
                          ("through none, on and on", np.linspace(-2, 14, 33)),
                          ("ending at none", np.linspace(-6, 0, 13))):
        axes = rng.standard_normal((3, 3))
        axes /= np.linalg.norm(axes, axis=1)[:, None]
        turning = np.stack([learning.exponential_map(np.outer(angles, a)) for a in axes], axis=1)
        found.append(called(label,
                            turning, learning.exponential_map(0.3 * rng.standard_normal((3, 3)))))
    many, axis = np.linspace(0, 40, 129), np.array([0.6, 0.0, 0.8])
    turning = learning.exponential_map(np.outer(many, axis))
    return found + [called("six turns",
                           turning[:, None], learning.exponential_map(0.1 * axis[None]))]


def efforts(rng: np.random.Generator) -> list[Sample]:
    """Frames and joints, and other frame rates."""
    found = along({"frames": 6, "joints": 2}, lambda frames, joints:
                  called("", walk(rng, frames, 3 * joints).reshape(frames, joints, 3), fps=30.0),
                  (*SIZES[2:], 511, 513, 1025))
    return found + [called(f"{fps:g} frames a second", walk(rng, 9, 6).reshape(9, 2, 3), fps=fps)
                    for fps in (1.0, 24.0, 119.88, 2000.0, 1e5)]
