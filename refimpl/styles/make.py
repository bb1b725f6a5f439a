"""How the styles in the box were made, and how one is made of somebody's clips: everything is
learnt on the embedded walkers (`embedded.crowd`), the same scenes in each style.
"""

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from ..embedded.crowd import KINDS, Scene, crowd
from ..fast import networks
from ..fast.autoencoder import autoencoder_gradients
from ..fast.gradients import style_gradients
from ..holden2017.objective import Weights
from ..holden2017.pairing import make_training_set
from ..holden2017.train import train_autoencoder, train_style
from ..holden2017.trained import Manifold, Style
from ..motion.body import Take, features_on, make_take
from ..motion.canonical import Physique, mean_body, measured
from ..motion.dataset import Dataset, Labelled
from ..motion.windows import clean_windows
from .box import LOSS_NETWORK, STYLES_SAID, boxed_manifold
from .files import load_manifold, save_manifold, save_style

SCENES, LOSS_EPOCHS, EPOCHS = 240, 60, 50
SMALL = {"channels": 64, "width": 15}    # of T
SOURCE = "embedded walkers"
_Report = Callable[[str], Any]


def _silent(text: str) -> None:
    pass


def played(scenes: Iterable[Scene], style: str, report: _Report = _silent) -> list[Take]:
    """These scenes in a style, made ready."""
    takes = []
    for scene in scenes:
        takes.append(make_take(scene.played(style).clip))
        report(style)
    return takes


def labelled(takes: Sequence[Take], body: Physique, contents: Sequence[str],
             style: str) -> list[Labelled]:
    """Takes as clips to learn on, on one body.   contents : what is done in each"""
    return [Labelled(f"{content} {style} {n}", content, style, False,
                     features_on(take.positions, body, take.contacts), take.contacts, take.clip.fps)
            for n, (take, content) in enumerate(zip(takes, contents))]


def reports(names: Sequence[str] = ()) -> int:
    """How often `make_box` reports: once a scene that is played, once an epoch."""
    styles = [name for name in names or STYLES_SAID if name != LOSS_NETWORK]
    count = len(styles) * (2 * SCENES + EPOCHS)
    if not names or LOSS_NETWORK in names:
        count += SCENES + len(STYLES_SAID) * SCENES // (2 * len(STYLES_SAID)) + LOSS_EPOCHS
    return count


def made_manifold(*, scenes: int = SCENES, epochs: int = LOSS_EPOCHS, report: _Report = _silent,
                  **how: Any) -> Manifold:
    """A loss network of all scenes played plainly and a part of them in each style.

    how : other settings of `train_autoencoder`
    """
    cast = crowd(scenes)
    takes = {"normal": played(cast, "normal", report)}
    takes |= {style: played(cast[n::2 * len(STYLES_SAID)], style, report)
              for n, style in enumerate(STYLES_SAID)}
    body = mean_body([measured(t.positions, t.contacts) for t in takes["normal"]])
    clips = [clip for style, own in takes.items()
             for clip in labelled(own, body, [""] * len(own), style)]
    X, normaliser = clean_windows(clips, SOURCE)
    for record, state in train_autoencoder(X, epochs=epochs, gradients=autoencoder_gradients,
                                           **how):
        report(f"{LOSS_NETWORK} {record.epoch}")
    return Manifold(state.params, normaliser, body.leg, body.bones, rest=body.rest)


def made_style(name: str, manifold: Manifold, *, scenes: int = SCENES, epochs: int = EPOCHS,
               report: _Report = _silent, **how: Any) -> Style:
    """A style of `embedded.manner.STYLES`: each scene learns from itself, played in that style.

    how : other settings of `train_style`
    """
    cast = crowd(scenes)
    contents = [f"{n:03d}" for n in range(len(cast))]
    clips = [clip for style in ("normal", name)
             for clip in labelled(played(cast, style, report), manifold.body, contents, style)]
    return _learnt(clips, manifold, name, epochs, report, how)


def fitted(shown: Sequence[Take] | Mapping[str, Sequence[Take]], name: str, *,
           manifold: Manifold | None = None, scenes: int = SCENES // 2, epochs: int = EPOCHS,
           report: _Report = _silent, **how: Any) -> Style:
    """A style of somebody's clips, learnt by the plain scenes.

    shown : clips in the style, or {kind: clips} with some of `KINDS`
    manifold : the loss network, that of the box unless given;  the others as in `made_style`
    Raises ValueError where nothing is shown or a kind is unknown.
    """
    manifold = manifold or boxed_manifold()
    by_kind = dict(shown) if isinstance(shown, Mapping) else dict.fromkeys(KINDS, list(shown))
    unknown = [kind for kind in by_kind if kind not in KINDS]
    if unknown or not all(by_kind.values()) or not by_kind:
        raise ValueError(f"shown: found {unknown or 'no clip'}, needed at least one clip, or a "
                         f"mapping of some of {', '.join(KINDS)} to clips")
    cast = [scene for scene in crowd(scenes) if scene.kind in by_kind]
    clips = labelled(played(cast, "normal", report), manifold.body, [s.kind for s in cast],
                     "normal")
    for kind, takes in by_kind.items():
        clips += labelled(takes, manifold.body, [kind] * len(takes), name)
    return _learnt(clips, manifold, name, epochs, report, how)


def _learnt(clips, manifold, name, epochs, report, how):
    body = manifold.body
    dataset = Dataset(tuple(clips), body.leg, body.bones, SOURCE, body.rest)
    lesson = make_training_set(dataset, manifold, name, networks=networks)[0]
    weights = Weights().fitted(manifold.leg, len(manifold.params["b0"]))
    for record, state in train_style(lesson, manifold, weights=weights, epochs=epochs, **{
            **SMALL, "gradients": style_gradients, **how}):
        report(f"{name} {record.epoch}")
    return replace(lesson.style(state.params, manifold, name, weights), learned=(), exemplars=(),
                   pairs={kind: kind for kind in KINDS})


def make_box(folder: str | Path, names: Sequence[str] = (), report: _Report = _silent,
             **how: Any) -> list[Path]:
    """Make the loss network, or styles on the one in the box, again.

    names : of styles, or `LOSS_NETWORK`; the loss network and all styles on it unless given
    ->  the files that were written
    """
    folder, written = Path(folder), []
    manifold = boxed_manifold() if names and LOSS_NETWORK not in names else None
    if manifold is None:
        written.append(folder / f"{LOSS_NETWORK}.npz")
        save_manifold(written[0], made_manifold(report=report), half=True)
        manifold = load_manifold(written[0])
    for name in names or STYLES_SAID:
        if name != LOSS_NETWORK:
            written.append(folder / f"{name}.npz")
            save_style(written[-1], made_style(name, manifold, report=report, **how), boxed=True)
    return written
