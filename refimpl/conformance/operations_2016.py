"""The specifications of the 2016 code: its 73 rows, network, losses and training."""

import numpy as np

from ..holden2016 import losses
from ..holden2016.rows import CONTACTS, NUMBERS, TRAJECTORY, TURN
from . import definitions_2016 as definitions, functions_2016 as functions, ground_holden as ground
from .operations_whole import bad_positions, walker
from .specification import called, operation, refused, ruled


def _encode_samples(rng):
    n = rng.standard_normal
    return [called("plain", n((2, 4, 8)), n((5, 4, 3)), n(5)),
            called("a frame left over", n((1, 3, 7)), n((4, 3, 5)), n(4)),
            called("with dropout",
                   n((2, 4, 8)), n((5, 4, 3)), n(5), kept=rng.integers(2, size=(2, 4, 8))),
            called("with dropout by numbers",
                   n((2, 4, 8)), n((5, 4, 3)), n(5), kept=1.0 * rng.integers(2, size=(2, 4, 8))),
            ruled("all units at their kink",
                  (np.zeros((1, 3, 4)), n((4, 3, 5)), np.zeros(4)), np.zeros((1, 4, 2)),
                  n((1, 4, 2)), np.zeros((1, 3, 4)), np.zeros((4, 3, 5)), np.zeros(4))]


def _decode_samples(rng):
    n = rng.standard_normal
    arrays = n((2, 5, 4)), n((4, 5, 3))
    return [called("plain", *arrays, n(4)),
            called("one hidden frame", n((1, 4, 1)), n((3, 4, 5)), n(3)),
            called("by chance", *arrays, n(4),
                   chosen=rng.integers(2, size=(2, 5, 4)), kept=rng.integers(2, size=(2, 5, 8))),
            called("with dropout by numbers",
                   *arrays, n(4), kept=1.0 * rng.integers(2, size=(2, 5, 8)))]


def _autoencoder_samples(rng):
    n = rng.standard_normal
    arrays = (n((2, 4, 8)), n((5, 4, 3)), n(5), n((4, 5, 3)), n(4))
    return [called("plain", *arrays),
            called("by chance", *arrays,
                   kept=rng.integers(2, size=(2, 4, 8)), chosen=rng.integers(2, size=(2, 5, 4)),
                   kept_hidden=rng.integers(2, size=(2, 5, 8)))]


def _motion(rng, frames=4):
    motion = rng.standard_normal((2, NUMBERS, frames)) * 5
    motion[:, TURN] *= 0.1
    return motion


def _foot_samples(rng):
    return [called("plain", _motion(rng), rng.random((2, 4, 4)) < 0.6),
            called("no contact, the floor alone", _motion(rng), np.zeros((2, 4, 4), bool)),
            called("one frame", _motion(rng, frames=1), np.ones((2, 4, 1), bool))]


def _bone_samples(rng):
    still = np.zeros((1, NUMBERS, 2))
    return [called("plain", _motion(rng)),
            ruled("bones of length 0", (still,), [np.mean(losses.LENGTHS ** 2)], [3.0], still)]


def _trajectory_samples(rng):
    return [called("plain", _motion(rng), wanted=rng.standard_normal((2, 3, 4)))]


def _search_samples(rng):
    n = rng.standard_normal
    root = n((2, 3, 6))
    constants = {"content": n((2, 3, 4)), "gram": root @ root.swapaxes(1, 2)}
    return [called("as in the code", n((2, 3, 4)), **constants),
            called("more style", n((2, 3, 4)), **constants | {"amount": 3.0})]


def _constraint_samples(rng):
    constants = {"contacts": rng.random((2, 4, 4)) < 0.6, "wanted": rng.standard_normal((2, 3, 4))}
    return [called("plain", _motion(rng), **constants)]


def _position_samples(rng):
    sizes = {"plain": (40, 18.0, 1.0), "turning on and on": (300, 18.0, -14.0),
             "two frames": (2, 18.0, 0.0), "high toes": (60, 40.0, 3.0)}
    found = [called(label, walker(rng, frames, unit, turns), large=frames > 100)
             for label, (frames, unit, turns) in sizes.items()]
    rolling = walker(rng, 60, 18.0)
    rolling[:, :, 1] += 0.2 * rolling[:, :, 0] + np.sin(np.arange(60) / 5)[:, None]
    return [*found, called("shoulders not level, an uneven floor", rolling)]


def _rows(rng, frames):
    rows = rng.standard_normal((frames, NUMBERS)) * 3
    rows[:, TURN] *= 0.2
    rows[:, CONTACTS] = rng.integers(2, size=(frames, 4))
    return rows


def _row_samples(rng):
    return [called("plain", _rows(rng, 12)),
            called("one frame", _rows(rng, 1)), called("two frames", _rows(rng, 2))]


def _window_samples(rng):
    sizes = {"some rows left over": (75, 40, 20), "too few left for another": (70, 40, 20),
             "shorter": (36, 41, 7), "shorter by an odd number": (35, 40, 9),
             "nothing": (30, 40, 20), "31 rows": (31, 40, 20)}
    return [called("the code's", _rows(rng, 300)),
            *(called(label, _rows(rng, frames), length=length, step=step)
              for label, (frames, length, step) in sizes.items())]


def _normaliser_samples(rng):
    plain = np.stack([_rows(rng, 9) + rng.standard_normal(NUMBERS) * 4 for _ in range(3)])
    straight, standing = plain.copy(), plain.copy()
    straight[..., TURN] = 0.25
    standing[..., TRAJECTORY] = 0.0
    return [called("plain", plain), called("one row", plain[:1, :1]),
            called("never turning", straight), called("never moving", standing)]


def _training_samples(rng):
    n = rng.standard_normal
    arrays = (n((3, 4, 3)) / 3, n(3) / 3, n((4, 3, 3)) / 3, n(4) / 3)

    def _sample(label, windows, epochs, batch, chance=False):
        sizes = {"kept": (4, 6), "chosen": (3, 3), "kept_hidden": (3, 6)} if chance else {}
        return called(label, *arrays, X=n((windows, 4, 6)), batch=batch,
                      rate=0.01, order=np.array([rng.permutation(windows) for _ in range(epochs)]),
                      **{name: rng.integers(2, size=(epochs, windows, *size))
                         for name, size in sizes.items()})
    return [_sample("one step", 2, 1, 2), _sample("an epoch, its last batch small", 5, 1, 2),
            _sample("ten steps in five epochs", 4, 5, 2),
            _sample("by chance", 5, 2, 2, True), _sample("one window", 1, 2, 1)]


def _project_samples(rng):
    n = rng.standard_normal
    return [called("plain", n((2, 4, 6)), n((5, 4, 3)), n(5), n((4, 5, 3)), n(4))]


def _joined_samples(rng):
    return [called(label, rng.standard_normal((windows, 240, NUMBERS)))
            for label, windows in (("plain", 3), ("one window", 1))]


def _constrained_samples(rng):
    n = rng.standard_normal
    return [called("plain", n((2, 3, 2)),
                   n((NUMBERS, 3, 3)), n(NUMBERS), contacts=rng.random((2, 4, 4)) < 0.6,
                   wanted=n((2, 3, 4)), mean=n(NUMBERS), deviation=rng.uniform(0.5, 2, NUMBERS))]


def _bad_trainings():
    W, b, V = np.ones((2, 3, 3)), np.ones(2), np.ones((3, 2, 3))
    good = {"X": np.ones((2, 3, 4)), "order": np.arange(2)[None], "batch": 1, "rate": 0.01}
    changes: list[tuple[str, str, dict]] = [
        ("an odd number of frames", "X", {"X": np.ones((2, 3, 5))}),
        ("no windows", "X", {"X": np.ones((0, 3, 4))}),
        ("two axes", "X", {"X": np.ones((3, 4))}),
        ("not a number", "epoch 1, window 0", {"X": np.full((2, 3, 4), np.nan)}),
        ("no windows a step", "batch, width", {"batch": 0})]
    return [refused(label, argument, W, b, V, np.ones(3), **good | change)
            for label, argument, change in changes]


def _one(f, arguments, samples, part, bad=list, **rest):
    return operation(f, arguments,
                     definitions, samples, bad, f"the 2016 code, {part}", suffix="_2016", **rest)


ALONE = {"batched": (), "precisions": ("float64",)}


OPERATIONS = (
    _one(functions.encode, "X We be", _encode_samples, "encoder", ground=ground.encoders),
    _one(functions.decode, "H Wd bd", _decode_samples, "decoder", ground=ground.decoders_2016),
    _one(functions.autoencoder_loss, "X We be Wd bd", _autoencoder_samples, "training", batched=(),
         ground=ground.autoencoders_2016),
    _one(losses.foot_loss, "motion contacts", _foot_samples, "feet", batched=(0, 1),
         ground=ground.feet_2016),
    _one(losses.bone_loss, "motion", _bone_samples, "bones",
         ground=lambda rng: ground.bones(rng, given=False, numbers=NUMBERS)),
    _one(functions.trajectory_loss, "motion", _trajectory_samples, "path", batched=(),
         ground=lambda rng: ground.paths(rng, form="2016")),
    _one(functions.search_loss, "H", _search_samples, "search", batched=(),
         ground=ground.searches),
    _one(functions.constraint_loss, "motion", _constraint_samples, "search", batched=()),
    _one(functions.motion_to_rows, "positions", _position_samples, "export",
         lambda: bad_positions(fewest=2), **ALONE),
    _one(functions.rows_to_motion, "motion", _row_samples, "export", **ALONE),
    _one(functions.row_windows, "motion", _window_samples, "export", **ALONE),
    _one(functions.row_normaliser, "windows", _normaliser_samples, "training",
         lambda: [refused("another count of numbers", "windows", np.ones((1, 4, 66))),
                  refused("no windows", "windows", np.ones((0, 4, NUMBERS))),
                  refused("two axes", "windows", np.ones((4, NUMBERS)))], **ALONE),
    _one(functions.train_network, "We be Wd bd", _training_samples, "training", _bad_trainings,
         batched=(), grows=True),
    _one(functions.project, "X We be Wd bd", _project_samples, "encoder and decoder"),
    _one(functions.joined_windows, "windows", _joined_samples, "search", **ALONE),
    _one(functions.constrained_loss, "H Wd bd", _constrained_samples, "search", batched=()))
