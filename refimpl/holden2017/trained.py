"""What training leaves: a manifold (the loss network) and a style (a transformation network with
its manifold). `refimpl.styles.files` writes and reads them."""

from collections.abc import Mapping
from dataclasses import dataclass, field
import functools

import numpy as np

from ..motion.features import AT_A_TIME, in_pieces
from ..motion.canonical import Physique, body_of_mean, mean_body
from ..motion.known import Known
from ..motion.windows import Normaliser
from .networks import Params
from .objective import Weights


@dataclass(frozen=True)
class Manifold:
    """A trained loss network and what its numbers mean.

    params : W0, b0, and V0, c0 where the decoder is not tied;  normaliser : of the data it was
    trained on;  leg, bones : that data's skeleton, in its length unit
    depooling : while it learnt, of `networks.DEPOOLING`
    rest : (21, 3) of its body (`motion.canonical.Physique`), told from the mean pose unless given
    """

    params: Params = field(repr=False)
    normaliser: Normaliser
    leg: float
    bones: np.ndarray
    depooling: str = "random"
    rest: np.ndarray | None = field(default=None, repr=False)

    @functools.cached_property
    def body(self) -> Physique:
        """The body that this network knows, on its scale."""
        known = (body_of_mean(self.normaliser.mean, self.bones) if self.rest is None
                 else Physique(self.rest))
        return mean_body([known], self.leg)

    def network_input(self, features: np.ndarray) -> np.ndarray:
        """Features (T, 66) on this model's scale to what the networks take, (1, 66, T) in their
        precision."""
        taken = np.empty((1, *features.shape[::-1]), self.params["W0"].dtype)
        for n in range(0, len(features), AT_A_TIME):
            taken[0, :, n:n + AT_A_TIME] = self.normaliser.apply(features[n:n + AT_A_TIME]).T
        return taken

    def motion(self, output: np.ndarray) -> np.ndarray:
        """The inverse of `network_input`.   (1, 66, T)  ->  (T, 66) float64"""
        return in_pieces(lambda some: self.normaliser.undo(output[0, :, some].T.astype(float)),
                         output.shape[2])


@dataclass(frozen=True)
class Style:
    """A trained transformation network.

    params : W1, b1 ... b3;  name : of the style;  pairs : {content it was trained for: content of
    its exemplars};  learned, exemplars : names of the clips that it learnt on
    weights : of the objective in its training, for the manifold's unit;  known : what it learnt on,
    to tell when a clip is something else
    """

    params: Params = field(repr=False)
    manifold: Manifold
    name: str
    pairs: Mapping[str, str]
    learned: tuple[str, ...] = ()
    exemplars: tuple[str, ...] = ()
    weights: Weights = Weights()
    known: Known | None = None
