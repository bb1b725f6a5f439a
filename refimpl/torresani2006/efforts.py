r"""Two computed observers of flow, weight and time that measure movement, and not the noise of its
capture. One chooses, the other judges; they share no signal and no formula but for the spectrum.

Both are blind to place, heading, size of the body, unit and frame rate: angles are measured in
radians, paths beside the longest chain of bones, L. In neither does a single frame count: maxima
are 95th percentiles. Each part of the body counts by what it carries: a joint's angle by the
bones beyond it, a joint's path by its own bone. Derivatives are those of a Gaussian that halves the
power at a stated frequency (`derivative`). A clip's own noise is read off where no body moves, above
9 Hz, and subtracted (`halting`); of what is left, less than `SEEN` is not seen.

The poles, and where they come from:

- Weight, light -3 .. strong 3: the size of the movement. "Powerful, forceful, firm" against "gentle,
  delicate" (Torresani 2006, section 2); EMOTE (Chi et al. 2000) lets strong movement reach further.
- Time, sustained -3 .. sudden 3: how fast for its size. "Not how long it takes to perform the
  movement" (section 2): a movement twice as large is by nature nearly twice as fast (isochrony,
  Viviani and McCollum 1983), and only what is faster than that is sudden.
- Flow, bound -3 .. free 3: how little of the movement goes by fits, above 3.5 Hz. "Controlled,
  contained" against "fluid, released"; its continuity (section 2). The published measure is jerk
  (Larboulette and Gibet 2015), which at the frequencies of the noise measures that.

None of this is an analyst: what a person calls strong also lies in the tension of the muscles,
which no joint angle shows.
"""

from dataclasses import replace

import numpy as np
from scipy.fft import dst
from scipy.ndimage import gaussian_filter1d

from ..motion.skeleton import ancestors
from .observe import Observer, Sight, observe
from .poses import Body, Fragment, fragment_positions

CUT_OFF = 1.5, 2.0                      # Hz, half the power: of angles; of paths
FITS = 3.5, 8.0                         # Hz: between them lie the fits of bound flow
NOISE = 9.0                             # Hz: above it nothing but noise
SEEN = 0.003, 0.0025                    # what is seen of a fit: radians; parts of L
ISOCHRONY = 0.85                        # speed goes with this power of a movement's size
REST = 0.1                              # of the 95th percentile of energy: what changes below is rest


def derivative(x: np.ndarray, fps: float, cut_off: float) -> np.ndarray:
    r"""d x / dt of the Gaussian that halves the power at `cut_off` Hz: sigma = sqrt(ln 2) / (2 pi
    cut_off) seconds. Both ends go on as they came, turned about their last frame.

    x : (T, ...), fps : frames a second   ->  (T, ...) per second

    >>> derivative(np.arange(9.0)[:, None], 30.0, 2.0)[:, 0].round(6)
    array([30., 30., 30., 30., 30., 30., 30., 30., 30.])
    """
    sigma = np.sqrt(np.log(2.0)) / (2 * np.pi * cut_off) * fps
    pad = int(np.ceil(4 * sigma)) + 1
    padded = np.pad(x, ((pad, pad),) + ((0, 0),) * (x.ndim - 1), "reflect", reflect_type="odd")
    slope = gaussian_filter1d(padded, sigma, axis=0, order=1)[pad:-pad]
    line = gaussian_filter1d(np.arange(2.0 * pad + 1), sigma, order=1)[pad]  # of the sampled kernel
    return slope * fps / line


def halting(x: np.ndarray, weight: np.ndarray, fps: float, seen: float) -> float:
    r"""How much of the speed goes by fits: log sqrt( (F + f) / (M + m) ).

    With b_k the sine coefficients of x between its ends, P_k = sum_j weight_j |b_jk|^2 / 2 the power
    at frequency f_k, and N its mean above 9 Hz, the speed's power in fits is

        F = sum over f_k in 3.5 .. 8 Hz of (2 pi f_k)^2 (P_k - N),

    that of the main movement, M, the same below 3.5 Hz and the way from end to end, f and m what
    white noise of the size `seen`, 30 times a second, would have.

    x : (T, J, 3), weight : (J,) sums to 1, fps : frames a second, seen : in x's unit
    """
    T, way = len(x), x[-1] - x[0]
    inner = (x - x[0] - np.linspace(0, 1, T)[:, None, None] * way)[1:-1]
    P = ((dst(inner, type=1, axis=0) / (T - 1)) ** 2).sum(axis=-1) @ weight / 2
    f = np.arange(1, T - 1) * fps / (2 * (T - 1))
    noise = P[f > NOISE].mean() if (f > NOISE).any() else 0.0
    speed2, floor = (2 * np.pi * f) ** 2, 3 * seen ** 2 * fps / (30 * T)
    fits, main = (f >= FITS[0]) & (f < FITS[1]), f < FITS[0]
    F, M = (max(0.0, float((speed2 * (P - noise))[some].sum())) for some in (fits, main))
    M += float((way ** 2).sum(axis=-1) @ weight) * (fps / (T - 1)) ** 2
    least = [floor * float(speed2[some].sum()) for some in (fits, main)]
    return 0.5 * float(np.log((F + least[0] + 1e-12) / (M + least[1] + 1e-12)))


def by_angles(fragment: Fragment, body: Body, part: int | None = None) -> np.ndarray:
    """Flow, weight and time of the joint angles, before they are scaled: minus `halting`; the log
    of the size, that is the 95th percentile of how far the pose is from its mean; and the log of
    the speed's 95th percentile beside size ** `ISOCHRONY`.

    part : the joint that all others looked at hang from, the carrier unless given   ->  (3,)
    """
    carried = _carried(body, body.carrier if part is None else part)
    x = fragment.angles.reshape(fragment.frames, -1, 3)
    x = x - x.mean(axis=0)
    size = _high(np.sqrt((x ** 2).sum(axis=-1) @ carried))
    speed = _high(np.linalg.norm(derivative(x, fragment.fps, CUT_OFF[0]), axis=-1) ** 2 @ carried)
    return np.array([-halting(x, carried, fragment.fps, SEEN[0]), np.log(size),
                     0.5 * np.log(speed) - ISOCHRONY * np.log(size)])


def by_paths(fragment: Fragment, body: Body, part: int | None = None) -> np.ndarray:
    r"""The same of the joints' paths, seen from the carrier and beside the longest chain of bones:
    minus `halting`; the log of the 95th percentile of how far the joints are from their mean places;
    and how suddenly their energy E changes, log of the root mean square of d/dt log(E + rest), each
    moment weighing by its E.   ->  (3,)
    """
    start = body.carrier if part is None else part
    lengths = np.linalg.norm(body.bones, axis=1) * _below(body, start)
    chain = [lengths[ancestors(body.joints, j)].sum() for j in range(len(lengths))]
    own = lengths / max(lengths.sum(), 1e-12)
    still = replace(fragment, root=np.zeros_like(fragment.root))
    x = fragment_positions(still, body) / max(*chain, 1e-12)
    x = x - x.mean(axis=0)
    size = _high(np.sqrt((x ** 2).sum(axis=-1) @ own))
    E = np.linalg.norm(derivative(x, fragment.fps, CUT_OFF[1]), axis=-1) ** 2 @ own
    change = derivative(np.log(E + REST * _high(E)), fragment.fps, CUT_OFF[1])
    sudden = 0.5 * np.log((E @ change ** 2 + 1e-12) / (E.sum() + 1e-12) + 1e-12)
    return np.array([-halting(x, own, fragment.fps, SEEN[1]), np.log(size), sudden])


BY_ANGLES = Sight("angles", by_angles, np.array([1.213, -1.274, 1.126]),
                  np.array([2.864, 7.866, 6.579]))
BY_PATHS = Sight("paths", by_paths, np.array([0.937, -1.895, 1.623]),
                 np.array([2.956, 9.707, 6.380]))


def seen_alone(fragment: Fragment, body: Body, sight: Sight = BY_ANGLES) -> np.ndarray:
    """The style of a fragment that nothing is compared with but what is usual for the embedded
    performers: of motions of one action the differences count.   ->  (3,) flow, weight, time
    """
    return observe(fragment, Observer({None: sight.usual}, np.asarray(sight.gain), body, sight))


def _high(x):
    """The 95th percentile, no less than 1e-9: a body that stands still has a style too."""
    return max(float(np.percentile(x, 95)), 1e-9)


def _below(body, start):
    """Which joints hang from one.   ->  (J,) bool"""
    return np.array([start in ancestors(body.joints, j)[1:] for j in range(len(body.joints))])


def _carried(body, start):
    """What each joint below `start` carries, its own bone and those beyond.   ->  (J,), sum 1"""
    lengths = np.linalg.norm(body.bones, axis=1) * _below(body, start)
    carried = lengths.copy()
    for j in range(len(lengths) - 1, 0, -1):                 # parents come first
        carried[body.joints[j].parent] += carried[j]
    carried *= _below(body, start)
    return carried / max(carried.sum(), 1e-12)
