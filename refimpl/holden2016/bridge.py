r"""Where the 66 numbers of 2017 meet the 73 of 2016, and the 2016 network as a loss network of
2017.

    rows 0..2     the reference joint, always 0
    rows 3..65    positions
    rows 66, 67   the root's velocity: sideways, forward
    row  68       minus the turning
    rows 69..72   contacts, given, else at their mean (0 when normalised)

A body is brought to the code's unit by its standing hips, which come to 17.00, their mean height in
the authors' normaliser. Where only a leg is known (`Network.manifold`), it comes to 17.00 / 1.12.
"""

from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from ..holden2017.trained import Manifold
from ..motion.stylised import Stylised, onto_skeleton
from ..motion import features as f66
from ..motion.dataset import Labelled
from ..motion.body import Take, seen
from ..motion.joints import BONES, HEELS, LEGS, SLOT, TOES
from ..motion.windows import Normaliser as Normaliser66
from ..nn.pool import even as even_frames
from . import losses, rows, search
from .files import check_unit, read_network, read_preprocess
from .network import Params, decode, encode
from .rows import ORDER, SIGN

SOURCE = "the network of 2016"
# Thighs and shins among BONES, where a bone is named by its lower joint and the hips have none.
_LEG_BONES = [joint - 1 for _, knee, heel, _ in LEGS for joint in (knee, heel)]


def to_rows(features: np.ndarray, contacts: np.ndarray | None = None,
            mean: np.ndarray | None = None) -> np.ndarray:
    """The 66 numbers as 73, in their own unit.

    features : (T, 66)
    contacts : (T, 4), or None for their mean
    mean : (73,) of the normaliser, 0.5 for contacts unless given
    ->  (T, 73)

    >>> made = to_rows(np.full((2, 66), 3.0))
    >>> made[0, 66:].tolist()
    [3.0, 3.0, -3.0, 0.5, 0.5, 0.5, 0.5]
    >>> bool((to_features(made) == 3.0).all())
    True
    """
    made = np.zeros((len(features), rows.NUMBERS))
    made[:, ORDER] = features * SIGN
    usual = 0.5 if mean is None else mean[rows.CONTACTS]
    made[:, rows.CONTACTS] = usual if contacts is None else contacts
    return made


def to_features(made: np.ndarray) -> np.ndarray:
    """The inverse of `to_rows`, without the contacts.   (T, 73)  ->  (T, 66)"""
    return made[:, ORDER] * SIGN


def standing_hips(positions: np.ndarray) -> float:
    """How high the hips are above the soles of the toes when a body stands straight: the lowest
    ankle over the lowest toe, the leg, and from the leg to the hips; of whatever the body does.

    positions : (T, 21, 3), y up  ->  height in their unit
    """
    heights = positions[..., 1]
    ankle = heights[:, HEELS].min() - heights[:, TOES].min()
    hips = np.median(heights[:, SLOT["Hips"]]
                     - heights[:, [upper_leg for upper_leg, *_ in LEGS]].mean(axis=1))
    return float(max(ankle, 0.0) + f66.leg_length(positions) + max(hips, 0.0))


def unit_of(positions: np.ndarray) -> float:
    """What lengths are multiplied by for the code's unit.   positions : (T, 21, 3)  ->  float"""
    return rows.HIPS_HEIGHT / standing_hips(positions)


@dataclass(frozen=True)
class Network:
    """A network of 2016 and its normaliser, the authors' or one trained here.

    params : of `network`;  normaliser : of `rows`
    """

    params: Params = field(repr=False)
    normaliser: rows.Normaliser = field(repr=False)

    leg = rows.HIPS_HEIGHT / rows.HIPS_PER_LEG                   # where hips stand at 17.00

    @property
    def bones(self) -> np.ndarray:
        """The lengths of `joints.BONES` on its scale.

        The code's own 20, grown to that leg; it has none from the chest to the arms, for which the
        mean pose stands in.   ->  (20,)
        """
        lengths = losses.LENGTHS.copy()
        mean = self.normaliser.mean[rows.POSITIONS].reshape(-1, 3)
        for number, (ours, theirs) in enumerate(zip(BONES, losses.BONES)):
            if ours != theirs:
                own, coded = (float(np.linalg.norm(mean[joint] - mean[parent]))
                              for parent, joint in (ours, theirs))
                lengths[number] *= own / max(coded, 1e-9)
        return lengths * (self.leg / (lengths[_LEG_BONES].sum() / 2))

    def rows_of(self, take: Take) -> np.ndarray:
        """A take as the code's own rows, on the code's scale.   ->  (T - 1, 73)"""
        return rows.encode(take.positions * unit_of(take.positions))

    def features_of(self, take: Take) -> np.ndarray:
        """A take's 66 numbers on the code's scale, for the methods here.   ->  (T, 66)"""
        return f66.scale(take.features, unit_of(take.positions))

    def network_input(self, features: np.ndarray, contacts: np.ndarray | None = None) -> np.ndarray:
        """Features on its scale as it takes them.   (T, 66), (T, 4)  ->  (1, 73, T)"""
        made = to_rows(features, contacts, self.normaliser.mean)
        return self.normaliser.apply(made)[None].astype(self.params["We"].dtype)

    def encode(self, features: np.ndarray, contacts: np.ndarray | None = None) -> np.ndarray:
        """Hidden units L(X) of features on its scale.   (T, 66), (T, 4)  ->  (1, m, T // 2)"""
        return encode(self.network_input(features, contacts), self.params)

    def decode(self, H: np.ndarray) -> np.ndarray:
        """(1, m, U)  ->  features (2 U, 66) on its scale"""
        return to_features(self.normaliser.undo(decode(H, self.params)[0]))

    def project(self, features: np.ndarray, contacts: np.ndarray | None = None) -> np.ndarray:
        """P(X) = L+(L(X)); an odd last frame is doubled and dropped again.
        (T, 66), (T, 4)  ->  (T, 66)
        """
        even = even_frames(features, axis=0)
        planted = None if contacts is None else even_frames(contacts, axis=0)
        return self.decode(self.encode(even, planted))[:len(features)]

    def manifold(self) -> Manifold:
        """This network as a loss network of 2017, on the 66 numbers.

        Contacts are at their mean there, so that their filters meet zeros. The decoder keeps its
        own filters V0 and biases c0 (`holden2017.networks.decode`).   ->  Manifold
        """
        p, normaliser = self.params, self.normaliser
        sign = SIGN.astype(p["We"].dtype)
        decoder = (p["Wd"][ORDER] * sign[:, None, None])[:, :, ::-1].swapaxes(0, 1)  # (m, 66, K)
        params = {"W0": np.ascontiguousarray(p["We"][:, ORDER] * sign[:, None]), "b0": p["be"],
                  "V0": np.ascontiguousarray(decoder), "c0": p["bd"][ORDER] * sign}
        normaliser66 = Normaliser66(normaliser.mean[ORDER] * SIGN, normaliser.deviation[ORDER],
                                    SOURCE, "2016")
        return Manifold(params, normaliser66, self.leg, self.bones)


def read(network: str, preprocess: str) -> Network:
    """The authors' network of a user's own two files.

    network : `network_core.npz`, preprocess : `preprocess_core.npz`   ->  Network
    Raises FormatError when a file is another one or the two describe no body, OSError.
    """
    normaliser = read_preprocess(preprocess)
    check_unit(normaliser, preprocess)
    return Network(read_network(network), normaliser)


def training_windows(clips: Iterable[Labelled]) -> np.ndarray:
    """Windows of rows to train a network on, in the code's unit: the clips' standing hips at 17.00.

    clips : of a Dataset, with its contacts   ->  (N, 240, 73), N = 0 without a long enough clip
    """
    clips = list(clips)
    if not clips:
        return np.zeros((0, rows.WINDOW, rows.NUMBERS))
    size = float(np.median([unit_of(f66.decode(c.features)) for c in clips]))
    return np.concatenate([rows.windows(to_rows(f66.scale(c.features, size), c.contacts))
                           for c in clips])


def transfer(take: Take, style: np.ndarray, network: Network, *, clean: bool = True,
             amount: float = search.AMOUNT, iterations: int = search.ITERATIONS,
             constraint_iterations: int = search.CONSTRAINT_ITERATIONS, seed: int = 0,
             watch: search.Watch | None = None, **back: Any) -> Stylised:
    """A take in a style by the 2016 code's own search, on the take's own skeleton.

    Both are brought to the code's unit and made rows of by `rows.encode`: the code's floor, facing
    and contacts. The content is the whole take, not four windows; the style the first window of 240
    rows, padded where it is shorter. The code's floor, under which it lets no foot go, comes to the
    take's; it lies up to 0.69 units above the content's lowest toe.

    style : (T_s, 21, 3), points of a clip in the style at 60 frames a second, y up, in any unit
    clean : lock the feet (`motion.stylised.onto_skeleton`), which the code does not;  back :
    strength, only, fps of the same
    amount, iterations, constraint_iterations, watch : of `search.transfer`
    seed : of the noise
    Raises ValueError.
    """
    both = take.positions, style
    sizes = [unit_of(positions) for positions in both]
    content, wanted = (rows.encode(positions * size) for positions, size in zip(both, sizes))
    windows = rows.windows(wanted)
    if not len(windows):
        raise ValueError(f"style: found {len(wanted)} rows, needed more than {rows.SHORTEST} at 60 "
                         "a second")
    content = even_frames(content, axis=0)
    start = search.noise(np.random.default_rng([seed, 4]), len(content))
    found = search.transfer(content, windows[0], network.params, network.normaliser, start=start,
                            amount=amount, iterations=iterations,
                            constraint_iterations=constraint_iterations, watch=watch)
    moved = to_features(found.result)
    if len(moved) < len(take.features):                          # the last frame has no row
        moved = np.concatenate([moved, moved[-1:]])
    moved = f66.scale(moved[:len(take.features)], 1 / sizes[0])
    return onto_skeleton(take, seen(take), moved, clean=clean, **back)
