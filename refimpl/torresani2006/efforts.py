r"""Two computed observers of flow, weight and time that measure movement, and not the noise of its
capture. One looks at how bones swing, the other at the paths of joints; one chooses, the other
judges.

Both are blind to place, heading, size of the body, unit and frame rate: directions have no unit,
paths are seen beside the longest chain of bones, L. In neither does a single frame count: maxima
are 95th percentiles. Each part of the body counts by what it is: a bone's swing by the bones that
it carries, a joint's path by its own bone. Speeds are smoothed by a Gaussian that halves the power
at a stated frequency (`smoothed`). A clip's own noise is read off above 9 Hz, where no body moves,
and subtracted (`fits`); of what is left less than `SEEN` is not seen.

The poles, and where they come from:

- Weight, light -3 .. strong 3: the size of the movement. "Powerful, forceful, firm" against
  "gentle, delicate" (Torresani 2006, section 2); EMOTE (Chi et al. 2000) lets strong movement reach
  further.
- Time, sustained -3 .. sudden 3. "Not how long it takes to perform the movement" (section 2): how
  fast for its size, which leaves out that large movement is faster by nature (isochrony, Viviani
  and McCollum 1983); or how suddenly the energy changes.
- Flow, bound -3 .. free 3: how little of the movement goes by fits, at twice its own frequency or
  more. "Controlled, contained" against "fluid, released" (section 2). The published measure is jerk
  (Larboulette and Gibet 2015), which the noise of a capture makes.

None of this is an analyst: what a person calls strong also lies in the tension of muscles, which no
pose shows. What they are worth is measured in `experiments`: weight and time on performers by four
formulas, flow on two of the four only.
"""

from dataclasses import replace

import numpy as np
from scipy.fft import dct
from scipy.ndimage import gaussian_filter1d

from ..motion.skeleton import ancestors
from .observe import ObserveError, Observer, Sight, observe
from .poses import Body, Fragment, fragment_positions, rotation_matrices

CUT_OFF = 1.5, 2.0                      # Hz, half the power: of swings; of paths
MAIN = 4.0                              # Hz: below it lies the movement whose frequency counts
FITS = 2.0, 2.5, 6.0, 8.0               # times that frequency; from, to and up to how many Hz
NOISE_FROM = 9.0                        # Hz: above it nothing but noise
SEEN = 0.003                            # of a fit: radians; parts of L
ISOCHRONY = 0.95                        # speed goes with this power of a movement's size
REST = 0.1                              # of the energy's 95th percentile: below it, rest


def smoothed(x: np.ndarray, fps: float, cut_off: float) -> np.ndarray:
    r"""The Gaussian that halves the power at `cut_off` Hz: sigma = sqrt(ln 2) / (2 pi cut_off)
    seconds.   x : (T, ...), fps : frames a second  ->  the same

    >>> tone = np.cos(2 * np.pi * 3.0 * np.arange(600) / 60.0)
    >>> float(np.mean(smoothed(tone, 60.0, 3.0) ** 2) / np.mean(tone ** 2)).__round__(2)
    0.5
    """
    sigma = np.sqrt(np.log(2.0)) / (2 * np.pi * cut_off) * fps
    return gaussian_filter1d(x, sigma, axis=0, mode="reflect")


def fits(v: np.ndarray, weight: np.ndarray, fps: float) -> float:
    r"""How much of the speed goes by fits: log sqrt( F / M ). With b_k the cosine coefficients of v
    and P_k = sum_j weight_j |b_jk|^2 / 2 the power at frequency f_k; with N the power of white
    noise of the pose, which differences raise to N (2 fps sin(pi f_k / fps))^2, read off above 9
    Hz:

        S(a, b) = sum over f_k in a..b of the power without noise, and with that of noise of `SEEN`,
        F = S(lo, 8 Hz),   M = S(0, lo),   lo = twice the root of the mean of f^2 below 4 Hz.

    v : (T, J, 3) a second, weight : (J,) sums to 1, fps : frames a second
    """
    T = len(v)
    P = ((dct(v, type=2, axis=0) / T) ** 2).sum(axis=-1) @ weight / 2
    P[0] /= 2
    f = np.arange(T) * fps / (2 * T)
    raised = (2 * fps * np.sin(np.pi * f / fps)) ** 2
    high = f > NOISE_FROM
    clean = P - raised * (P[high].sum() / raised[high].sum() if high.any() else 0.0)
    main = f < MAIN
    own = np.sqrt(max((f ** 2 * clean)[main].sum(), 0.0) / max(clean[main].sum(), 1e-12))
    low = np.clip(FITS[0] * own, *FITS[1:3])
    least = raised * 3 * SEEN ** 2 * fps / (30 * T)
    F, M = (max(clean[some].sum(), 0.0) + least[some].sum() + 1e-12
            for some in ((f >= low) & (f < FITS[3]), f < low))
    return 0.5 * float(np.log(F / M))


def by_swings(fragment: Fragment, body: Body) -> np.ndarray:
    """Flow, weight and time of the bones' directions, each seen from the bone that it hangs from:
    minus `fits`; the log of the size, how far they are from their mean; and the log of the speed
    beside size ** `ISOCHRONY`.   ->  (3,).   Raises ObserveError for fewer than four frames.
    """
    _check(fragment)
    lengths, below, parents = _lengths(body), _below(body), body.parents
    carried = lengths.copy()
    for j in range(len(lengths) - 1, 0, -1):                 # parents come first
        carried[parents[j]] += carried[j]
    some = np.flatnonzero(below & (lengths > 0))
    turned = rotation_matrices(fragment.angles, body.reference)[:, parents[some]]
    x = (turned @ (body.bones[some] / lengths[some, None])[..., None])[..., 0]
    weight = carried[some] / carried[some].sum()
    size, v = _size(x, weight), np.diff(x, axis=0) * fragment.fps
    energy = (smoothed(v, fragment.fps, CUT_OFF[0]) ** 2).sum(axis=-1) @ weight
    return np.array([-fits(v, weight, fragment.fps), np.log(size),
                     0.5 * np.log(_high(energy)) - ISOCHRONY * np.log(size)])


def by_paths(fragment: Fragment, body: Body) -> np.ndarray:
    r"""The same of the joints' paths, seen from the carrier and beside the longest chain of bones:
    minus `fits`; the log of the size; and how suddenly the energy E changes, the log of the root
    mean square of d/dt log(E + rest), each moment weighing by its E.   ->  (3,)
    """
    _check(fragment)
    lengths = _lengths(body)
    longest = max(lengths[ancestors(body.joints, j)].sum() for j in range(len(lengths)))
    weight = lengths / lengths.sum()
    still = replace(fragment, root=np.zeros_like(fragment.root))
    x, fps = fragment_positions(still, body) / longest, fragment.fps
    v = np.diff(x, axis=0) * fps
    E = (smoothed(v, fps, CUT_OFF[1]) ** 2).sum(axis=-1) @ weight
    change = smoothed(np.diff(np.log(E + REST * _high(E))) * fps, fps, CUT_OFF[1])
    between = 0.5 * (E[1:] + E[:-1]) + 1e-12
    sudden = 0.5 * np.log(between @ change ** 2 / between.sum() + 1e-12)
    return np.array([-fits(v, weight, fps), np.log(_size(x, weight)), sudden])


# The best linear guess of the efforts that embedded performers have by three formulas, within
# actions and across them (a test fits it again).
BY_SWINGS = Sight("swings", by_swings, np.array([1.01, -1.52, 1.28]), np.array([3.9, 9.1, 6.8]),
                  np.array([2.7, 2.6, 6.4]))
BY_PATHS = Sight("paths", by_paths, np.array([0.81, -1.89, 1.62]), np.array([3.7, 9.7, 6.4]),
                 np.array([2.6, 2.7, 5.3]))


def seen_alone(fragment: Fragment, body: Body, sight: Sight = BY_SWINGS) -> np.ndarray:
    """The style of a fragment of which no content is known, beside what is usual for the embedded
    performers: compare it with others of its action.   ->  (3,) flow, weight, time
    """
    return observe(fragment, Observer({None: sight.usual}, np.asarray(sight.alone), body, sight))


def _check(fragment):
    if fragment.frames < 4:
        raise ObserveError(f"{fragment.name}: found {fragment.frames} frames, needed at least 4 to "
                           "see a movement")


def _size(x, weight):
    """How far (T, J, 3) lies from its mean, at the 95th percentile."""
    return np.sqrt(_high(((x - x.mean(axis=0)) ** 2).sum(axis=-1) @ weight))


def _high(x):
    """The 95th percentile, no less than 1e-12: a body that stands still has a style too."""
    return max(float(np.percentile(x, 95)), 1e-12)


def _below(body):
    """Which joints hang from the carrier.   ->  (J,) bool"""
    return np.array([body.carrier in ancestors(body.joints, j)[1:]
                     for j in range(len(body.joints))])


def _lengths(body):
    """Of the bones below the carrier, 0 for the others.   ->  (J,)"""
    lengths = np.linalg.norm(body.bones, axis=1) * _below(body)
    if not lengths.sum() > 0:
        raise ObserveError("body: found no bone below the joint that carries it, needed one")
    return lengths
