"""Faults of the ways from one end to the other: (what is wrong, function, what stands in its
place).
"""

import numpy as np

from refimpl.conformance import functions_transfer, functions_whole as ours


def of(function, number, change):
    """One output of several, changed by `change(output, *arguments, **attributes)`."""
    def wrong(*arguments, **attributes):
        results = list(function(*arguments, **attributes))
        results[number] = change(results[number], *arguments, **attributes)
        return tuple(results)
    return wrong


def given(function, **changes):
    """Attributes changed on the way in: {name: change of the value}."""
    def wrong(*arguments, **attributes):
        return function(*arguments, **{name: changes[name](value) if name in changes else value
                                       for name, value in attributes.items()})
    return wrong


def last_batch_dropped(function):
    def wrong(*arguments, order, batch, **attributes):
        kept = order.shape[1] // batch * batch or order.shape[1]
        return function(*arguments, order=order[:, :kept], batch=batch, **attributes)
    return wrong


def counted_anew(function):
    """Adam's moments and steps begin anew with each epoch."""
    def wrong(*arguments, order, rate, **attributes):
        params, met = arguments, []
        for epoch, row in enumerate(order):
            own = {name: value[epoch:epoch + 1] if name in ("kept", "chosen") and value is not None
                   else value for name, value in attributes.items()}
            here = float(ours.learning_rate(np.array([epoch + 1]), rate=rate, epochs=len(order))[0])
            # one epoch alone has the full rate
            *params, loss = function(*params, order=row[None], rate=here, **own)
            met.append(loss[0])
        return (*params, np.array(met, dtype=arguments[0].dtype))
    return wrong


def unchanged_padding(features, contacts, *, length, step):
    """The padding of a short clip keeps its velocities."""
    cut, labels = ours.motion_windows(features, contacts, length=length, step=step)
    if len(features) < length:
        before = (length - len(features)) // 2
        cut[0, :before, 63:] = features[0, 63:]
    return cut, labels


def shares_alike(hidden, *, lengths, frames):
    """The mean of the exemplars' Gram matrices, each by its own frames."""
    parts = np.split(hidden, np.cumsum(lengths)[:-1], axis=1)
    return frames * np.mean([h @ h.T / h.shape[1] for h in parts], axis=0)


FAULTS = (
    ("whole: facing backwards", "facing_direction", lambda p: -ours.facing_direction(p)),
    ("whole: the floor at the lowest frame", "floor_height",
     lambda p: float(p[:, [3, 4, 7, 8], 1].min())),
    ("whole: heels as near the floor as toes", "foot_contacts",
     lambda p, *, floor: ours.foot_contacts(p, floor=floor + 0.02 * np.abs(p).max())),
    ("whole: no hysteresis of stances", "planted_feet",
     of(ours.planted_feet, 1, lambda labels, p: labels & np.roll(labels, 1, axis=0))),
    ("whole: a clip frozen at its ends", "extended",
     lambda p, *, frames: np.pad(p, ((frames, frames), (0, 0), (0, 0)), mode="edge")),
    ("whole: what follows a clip a frame late", "extended",
     lambda p, *, frames: functions_transfer.extended(p, frames=frames)[
         [*range(len(p) + frames), *range(len(p) + frames - 1, len(p) + 2 * frames - 1)]]),
    ("whole: forward and sideways exchanged", "motion_to_numbers",
     of(ours.motion_to_numbers, 0, lambda f, *a, **k: f[:, [*range(64), 65, 64]])),
    ("whole: a step before the turn", "numbers_to_motion",
     lambda f, start: ours.numbers_to_motion(
         np.concatenate([f[:, :63], np.roll(f[:, 63:64], -1), f[:, 64:]], axis=1), start)),
    ("whole: padding that moves on", "motion_windows", unchanged_padding),
    ("whole: the deviation of a sample", "normaliser",
     of(ours.normaliser, 1, lambda d, f, c, **k: d * np.sqrt(len(f) / (len(f) - 1)))),
    ("whole: an odd frame dropped and repeated", "project",
     lambda X, W, b: ours.project(X[:, :, :-1], W, b)[:, :, [*range(X.shape[2] - 1), -1]]
     if X.shape[2] % 2 and X.shape[2] > 1 else ours.project(X, W, b)),
    ("whole: each exemplar alike, short or long", "style_target", shares_alike),
    ("whole: filters by their inputs alone", "initial_filters",
     lambda u: (2 * u - 1) * np.sqrt(u.dtype.type(6 / (u.shape[1] * u.shape[2])))),
    ("whole: the rate of the epoch after", "learning_rate",
     lambda epoch, **k: ours.learning_rate(epoch + 1, **k)),
    ("whole: the last batch dropped", "train_loss_network",
     last_batch_dropped(ours.train_loss_network)),
    ("whole: Adam anew each epoch", "train_loss_network", counted_anew(ours.train_loss_network)),
    ("whole: noise that is not made up for", "train_loss_network",
     given(ours.train_loss_network, dropout=lambda share: 0.0)),
    ("whole: one order for all epochs", "train_loss_network",
     given(ours.train_loss_network, order=lambda order: np.repeat(order[:1], len(order), axis=0))),
    ("whole: batches of all at once", "train_transformation_network",
     given(ours.train_transformation_network, batch=lambda size: 10 ** 6)),
    ("whole: half the rate", "train_transformation_network",
     given(ours.train_transformation_network, rate=lambda rate: rate / 2)),
    ("whole: constraints as often as style", "style_search_2016",
     given(ours.style_search, constraint_iterations=lambda n: n + 1)),
    ("whole: the threshold at the link that is needed", "cluster_threshold",
     lambda ssd, *, count: float(np.sort(ssd[np.triu_indices(len(ssd), 1)])[0]) * count),
    ("whole: the pair in the other order", "best_pair",
     of(ours.best_pair, 0, lambda pair, *a, **k: pair[::-1])),
)
