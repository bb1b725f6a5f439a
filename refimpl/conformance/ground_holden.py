"""Where real kernels break: samples for the networks and losses of 2016 and 2017."""

import numpy as np

from ..holden2017 import losses
from ..motion.features import FEATURES, TURN, VELOCITIES
from ..motion.joints import BONES, JOINTS
from .ground_nn import along, at_sizes
from .specification import Sample, called

# Beside the borders at which blocks end: networks have more axes than their convolutions.
SIZES = (1, 2, 8, 9, 16, 17, 31, 32, 33, 64, 65)
LONG = (127, 128, 129, 257, 511, 513, 1025)


def _along(axes, make):
    """Each axis; frames and clips up to long ones."""
    found = along(axes, make, SIZES)
    for axis in ("clips", "frames", "units"):
        if axis in axes:
            found += along({axis: axes[axis]}, lambda **size: make(**{**axes, **size}), LONG)
    return found


def encoders(rng: np.random.Generator) -> list[Sample]:
    """Each axis, and the papers' own network."""
    n = rng.standard_normal

    def _sized(clips, channels, units, frames, width):
        return None if frames < 2 else called("", n((clips, channels, frames)),
                                              n((units, channels, width)), n(units))
    thin = {"clips": 1, "channels": 2, "units": 3, "frames": 5, "width": 3}
    found = _along(thin, _sized) + at_sizes(_sized, {
        "the papers' own": (1, FEATURES, 256, 240, 25),
        "ten clips, odd frames": (10, FEATURES, 12, 61, 25), "a batch of 33": (33, 5, 8, 12, 25)})
    X, W0, b0 = _sized(3, 3, 3, 3, 4).inputs
    for label, values in (("ties and near ties", (1.0, 1.0, 2.0, 2.0 + 2.0 ** -30, 3.0 + 2.0 ** -50,
                                                  3.0, -1.0, -1.0)),
                          ("zeros", (0.0, 0.0, -0.0, 1.0, 0.0, -1.0, 2.0, 0.0)),
                          ("NaN among others", (1.0, 2.0, 3.0, np.nan, 5.0, 4.0, np.nan, 1.0))):
        x = np.array([[values, values[::-1]]])                   # each channel by itself, unchanged
        found.append(called(f"{label} in the pool",
                            x, np.eye(2)[:, :, None], np.zeros(2), exact=True))
    return found + [called("as many clips as channels, units and frames", X, W0, b0),
                    called("no biases", X, W0, 0 * b0),
                    called("hidden units that are all off", X, W0, b0 - 100)]


def decoders(rng: np.random.Generator) -> list[Sample]:
    """Each axis, the papers' own network, and depooling by chance at other sizes."""
    n = rng.standard_normal

    def _sized(clips, channels, units, frames, width):
        return called("", n((clips, units, frames)), n((units, channels, width)), n(units))
    thin = {"clips": 1, "channels": 2, "units": 3, "frames": 3, "width": 3}
    found = _along(thin, _sized) + at_sizes(_sized, {
        "the papers' own": (1, FEATURES, 256, 120, 25),
        "a batch of 33, odd frames": (33, 5, 8, 7, 25)})
    H, W0, b0 = _sized(3, 3, 3, 5, 3).inputs
    return found + [called(label, H, W0, b0, chosen=chosen)
                    for label, chosen in (("odd frames by chance", rng.integers(2, size=H.shape)),
                                          ("the first frame by chance", np.zeros(H.shape, int)),
                                          ("the second frame by chance", np.ones(H.shape, int)))]


def decoders_2016(rng: np.random.Generator) -> list[Sample]:
    """The same, with filters of its own."""
    return [called(s.label, s.inputs[0], np.ascontiguousarray(s.inputs[1].swapaxes(0, 1)),
                   rng.standard_normal(s.inputs[1].shape[1]), large=s.large)
            for s in decoders(rng) if not s.attributes]


def transformers(rng: np.random.Generator) -> list[Sample]:
    """Each axis of T."""
    n = rng.standard_normal

    def _sized(clips, channels, first, second, frames, width):
        shapes = ((clips, channels, frames), (first, channels, width), (first,),
                  (second, first, width), (second,), (channels, second, width), (channels,))
        return called("", *tuple(n(shape) / np.sqrt(shape[1] * width if len(shape) == 3 and i
                                                    else 1) for i, shape in enumerate(shapes)))
    thin = {"clips": 1, "channels": 2, "first": 3, "second": 2, "frames": 5, "width": 3}
    return _along(thin, _sized) + at_sizes(_sized, {
        "the papers' own": (1, FEATURES, 128, 128, 61, 25), "a batch of 33": (33, 4, 3, 5, 9, 15)})


def autoencoders(rng: np.random.Generator) -> list[Sample]:
    """Each axis; biases and filters of zero among others."""
    n = rng.standard_normal

    def _sized(clips, channels, units, frames, width):
        return called("", n((clips, channels, 2 * frames)),
                      n((units, channels, width)) / width, n(units))
    found = _along({"clips": 1, "channels": 2, "units": 3, "frames": 2, "width": 3}, _sized)
    X, W0, b0 = _sized(2, 3, 4, 3, 3).inputs
    b0[1], W0[2, 1] = 0.0, 0.0
    chosen = rng.integers(2, size=(2, 4, 3))
    return found + [called("weights of zero among others", X, W0, b0, alpha=2.0),
                    called("no sparsity", X, W0, b0, alpha=0.0),
                    called("sums by chance", X, W0, b0, mean=False, chosen=chosen),
                    called("sums by chance, alpha",
                           X, W0, b0 + 1, mean=False, chosen=chosen, alpha=0.7),
                    called("means by chance, alpha", X, W0, b0 + 1, chosen=chosen, alpha=0.7)]


def contents(rng: np.random.Generator) -> list[Sample]:
    """Each axis, each reading; clips that are equal among others, and nearly equal ones."""
    n, found = rng.standard_normal, []
    for reading in losses.READINGS:
        found += [called(f"{s.label}, {reading}", *s.inputs, reading=reading, large=s.large)
                  for s in _along({"clips": 1, "units": 2, "frames": 3},
                                  lambda clips, units, frames: called("", n((clips, units, frames)),
                                                                      n((clips, units, frames))))]
        A = n((4, 3, 5))
        B = A + n(A.shape) * np.array([1.0, 0.0, 1e-6, 1e3])[:, None, None]
        found.append(called(f"equal clips among others, {reading}", A, B, reading=reading))
        found.append(called(f"c and {reading}", A + n(A.shape), B, reading=reading, c=2.5))
    return found + [called("c unsaid", A, B), called("no weight", A, B, c=0.0)]


def styles(rng: np.random.Generator) -> list[Sample]:
    """Each axis, each reading; the style reached in one clip among others."""
    n, found = rng.standard_normal, []

    def _sized(clips, units, frames):
        root, H = n((clips, units, 4)), n((clips, units, frames))
        return called("", root @ root.swapaxes(1, 2), H)
    for reading in losses.READINGS:
        found += [called(f"{s.label}, {reading}", *s.inputs, reading=reading, large=s.large)
                  for s in _along({"clips": 1, "units": 2, "frames": 3}, _sized)
                  if s.inputs[1].shape[1] < LONG[-1]]
        G, H = _sized(3, 3, 5).inputs
        G[1], H[1] = 0.0, 0.0
        found.append(called(f"nothing to do in one clip, {reading}", G, H, reading=reading))
        G, H = _sized(3, 4, 5).inputs
        H[:, 1], H[0, :, 2] = 0.0, 0.0
        found += [called(f"units that never fire, {reading}", G, H, reading=reading),
                  called(f"s and {reading}", *_sized(2, 3, 4).inputs, reading=reading, s=3.0)]
    lopsided = n((2, 4, 4))
    return found + [called("s unsaid", G, H), called("no weight", G, H, s=0.0),
                    called("a Gram matrix that is not symmetric", lopsided, n((2, 4, 6)))]


def moving(rng: np.random.Generator, clips: int = 2, frames: int = 4,
           numbers: int = FEATURES) -> np.ndarray:
    """Random numbers of frames, with small turns.   ->  (clips, numbers, frames)"""
    motion = rng.standard_normal((clips, numbers, frames)) * 5
    motion[:, TURN] *= 0.1
    return motion


def feet(rng: np.random.Generator) -> list[Sample]:
    """Clips and frames; each foot alone; large turns; targets in their forms."""
    def _contacts(clips, frames):
        return rng.random((clips, 4, frames)) < 0.6
    found = _along({"clips": 1, "frames": 3}, lambda clips, frames:
                   called("", moving(rng, clips, frames), _contacts(clips, frames)))
    for foot in range(4):
        contacts = np.zeros((2, 4, 5), bool)
        contacts[0, foot], contacts[1, foot, 2] = True, True
        found.append(called(f"row {foot} of the contacts alone", moving(rng, 2, 5), contacts))
    motion, contacts = moving(rng, 2, 5), _contacts(2, 5)
    turning = motion.copy()
    turning[:, TURN] = np.linspace(-4, 4, 10).reshape(2, 5)
    return found + [called("large turns", turning, contacts),
                    called("no turn", motion * (np.arange(FEATURES) != TURN)[:, None], contacts),
                    called("contacts as numbers", motion, contacts.astype(float))]


def feet_2016(rng: np.random.Generator) -> list[Sample]:
    """The 73 numbers: clips and frames."""
    return _along({"clips": 1, "frames": 3}, lambda clips, frames:
                  called("", moving(rng, clips, frames, 73), rng.random((clips, 4, frames)) < 0.6))


def feet_with_targets(rng: np.random.Generator) -> list[Sample]:
    """The targets of equation 7 in all their forms."""
    found = []
    for clips, frames in ((3, 5), (4, 4), (4, 5), (3, 4)):
        motion, contacts = moving(rng, clips, frames), rng.random((clips, 4, frames)) < 0.6
        found += [called(f"{clips} clips, {frames} frames, a target of shape {shape}",
                         motion, contacts, target=rng.standard_normal(shape))
                  for shape in ((), (3, 1), (4, 1, 1), (4, 3, 1), (clips, 4, 3, frames - 1),
                                (clips, 1, 1, 1), (1, 1, 3, frames - 1), (frames - 1,))]
    return found


def bones(rng: np.random.Generator, given: bool = True, numbers: int = FEATURES) -> list[Sample]:
    """Clips and frames; bones of length 0, and nearly so, among others."""
    def _lengths():
        return {"lengths": rng.uniform(1, 9, len(BONES))} if given else {}
    found = _along({"clips": 1, "frames": 2}, lambda clips, frames:
                   called("", moving(rng, clips, frames, numbers), **_lengths()))
    motion = moving(rng, 3, 4, numbers)
    first = 0 if numbers == FEATURES else 3
    place = motion[:, first:first + 3 * JOINTS].reshape(3, JOINTS, 3, 4)
    for (a, b), apart in zip(BONES[::4], (0.0, 1e-3, 1e-9, 0.0, 1e-9)):
        place[1, b, :, 2] = place[1, a, :, 2] + [apart, 0.0, -apart]
    place[2, BONES[3][1]] = place[2, BONES[3][0]]
    motion[:, first:first + 3 * JOINTS] = place.reshape(3, 3 * JOINTS, 4)
    far = np.round(moving(rng, 2, 3, numbers)) + 2.0 ** 18
    found += [called("bones of length 0 among others", motion, **_lengths()),
              called("far from the origin", far, **_lengths(), firm=True)]
    hair = moving(rng, 2, 3, numbers)
    hair[0, first:first + 3 * JOINTS] = rng.standard_normal((3 * JOINTS, 3)) * 1e-170
    found.append(called("lengths whose squares vanish", hair, **_lengths()))
    own = (((0, 1), (0, 5), (0, 9)), ((12, 3),), ((0, 1), (3, 4), (1, 2), (0, 1)),
           ((2, 1), (1, 2), (2, 6)), BONES[::-1])
    for number, pairs in enumerate(own if given else ()):
        p = moving(rng, 2, 3)
        places = p[:, :63].reshape(2, JOINTS, 3, 3)
        a, b = np.array(pairs).T
        lengths = np.linalg.norm(places[:, a] - places[:, b], axis=2).mean(axis=(0, 2))
        found.append(called(f"other bones {number}", p, lengths=lengths, bones=pairs))
    return found + ([called("lengths wanted of 0", moving(rng, 2, 3),
                            lengths=np.arange(len(BONES)) % 2 * 3.0)] if given else [])


def paths(rng: np.random.Generator, form: str = "weighed") -> list[Sample]:
    """Clips and frames, turns beyond half and whole turns, the turn's weight."""
    def _sized(clips, frames):
        return called("", moving(rng, clips, frames, FEATURES if form == "weighed" else 73),
                      wanted=rng.standard_normal((clips, 3, frames)))
    found = _along({"clips": 1, "frames": 3}, _sized)
    sample = _sized(2, 4)
    sample.inputs[0][1, 5, 2] = np.nan                           # not of the path
    found.append(called("NaN in a joint", *sample.inputs, **sample.attributes))
    if form != "weighed":
        return found
    motion, wanted = moving(rng, 2, 6), rng.standard_normal((2, 3, 6))
    motion[:, TURN] = np.linspace(-7, 7, 12).reshape(2, 6)
    wanted[:, 0] = -motion[:, TURN] * 1.1
    found.append(called("turns beyond half a turn", motion, wanted=wanted))
    for weight in (0.0, 1e-4, 2.0, 1e4):
        found.append(called(f"turn weight {weight:g}", motion, wanted=wanted, turn_weight=weight))
    equal = wanted.copy()
    equal[0] = motion[0, VELOCITIES]
    return found + [called("one clip on its path", motion, wanted=equal)]


def autoencoders_2016(rng: np.random.Generator) -> list[Sample]:
    """Filters of two widths, whose numbers are no mean of one another's."""
    n = rng.standard_normal
    return [called(f"widths {a} and {b}", n((2, 3, 8)), n((4, 3, a)), n(4), n((3, 4, b)), n(3))
            for a, b in ((3, 5), (7, 1))]


def searches(rng: np.random.Generator) -> list[Sample]:
    """Each axis; the beginning and the end of a search."""
    n, found = rng.standard_normal, []

    def _sized(clips, units, frames, near=1.0):
        H = n((clips, units, frames))
        away = near * n((clips, units, units))
        return called("", H, content=H + near * n(H.shape),
                      gram=H @ H.swapaxes(1, 2) + away + away.swapaxes(1, 2))
    found = _along({"clips": 1, "units": 2, "frames": 3}, _sized)
    found.append(called("a Gram matrix that is not symmetric",
                        n((2, 3, 4)), content=n((2, 3, 4)), gram=n((2, 3, 3))))
    sample = _sized(2, 3, 4)
    found += [called(f"amount {amount:g}", *sample.inputs, **sample.attributes | {"amount": amount})
              for amount in (0.0, 1.0)]
    for near in (1e-3, 1e-6):
        sample = _sized(2, 4, 6, near)
        found.append(called(f"{near:g} from the end", *sample.inputs, **sample.attributes))
    return found
