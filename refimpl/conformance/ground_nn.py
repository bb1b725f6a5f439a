"""Where real kernels break: sizes at and beside blocks, all pairs of options, near ties, and the
one odd element among ordinary ones. More samples for the operations of `nn` and for the networks.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from itertools import combinations, product
import math
from typing import Any

import numpy as np

from .specification import Sample, called

# Blocks of vectors, tiles and grids, and one below and above.
SIZES = (1, 2, 7, 8, 9, 15, 16, 17, 31, 32, 33, 63, 64, 65, 127, 128, 129, 511, 512, 513)
LONG = (1023, 1025, 2049, 32769, 65537)          # of frames and elements: counters end there too
LARGE = 60                                       # beyond it the second derivation's loops take long


def along(axes: Mapping[str, int], make: Callable[..., Sample | None],
          sizes: Sequence[int] = SIZES) -> list[Sample]:
    """Samples in which one axis after the other takes each size, the others being thin, and pairs
    of axes that fill blocks together, or just do not.

    axes : {name: thin size};  make : of the sizes by name -> Sample, or None where they do not fit
    """
    found = [(f"{size} {axis}", {axis: size}) for axis, size in product(axes, sizes)]
    found += [(f"{m} {a}, {n} {b}", {a: m, b: n}) for a, b in combinations(axes, 2)
              for m, n in ((8, 8), (16, 32), (9, 17)) if {m, n} <= set(sizes)]
    samples = []
    for label, chosen in found:
        sample = make(**{**axes, **chosen})
        if sample is not None:
            samples.append(replace(sample, label=label, large=max(chosen.values()) > LARGE))
    return samples


def at_sizes(make: Callable[..., Any], sizes: Mapping[str, tuple]) -> list[Sample]:
    """Large samples.   make : of the sizes in their order -> Sample;  sizes : by label"""
    return [replace(make(*of), label=label, large=True) for label, of in sizes.items()]


def pairs(levels: Mapping[str, Sequence[Any]], fits: Callable[[dict[str, Any]], bool],
          rng: np.random.Generator) -> Iterator[dict[str, Any]]:
    """Few choices of options among which each pair of levels that fits together occurs.

    >>> rng = np.random.default_rng(0)
    >>> found = list(pairs({"a": [1, 2], "b": [1, 2], "c": [1, 2]}, lambda c: True, rng))
    >>> len({(c["a"], c["b"]) for c in found}), len(found) < 8
    (4, True)
    """
    names = list(levels)
    drawn = ({name: of[int(rng.integers(len(of)))] for name, of in levels.items()}
             for _ in range(4000))
    every = [choice for choice in drawn if fits(choice)]

    def _met(choice):
        return {(a, b, repr(choice[a]), repr(choice[b])) for a, b in combinations(names, 2)}
    met = [_met(choice) for choice in every]
    missing: set = set().union(*met)
    while missing:
        some = rng.permutation(len(every))[:150]
        best = max(some, key=lambda i: len(met[i] & missing))
        if not met[best] & missing:              # few are left: the first that has one of them
            best = next(i for i in range(len(every)) if met[i] & missing)
        missing -= met[best]
        yield every[best]


def _label(choice):
    return ", ".join(f"{name} {value}" for name, value in choice.items())


def convolutions(rng: np.random.Generator, transposed: bool = False) -> list[Sample]:
    """Sizes, options and the papers' own convolutions."""
    n = rng.standard_normal

    def _sized(clips, inputs, outputs, groups, frames, width, **attributes):
        C, O = inputs * groups, outputs * groups
        into, out = (O, C) if transposed else (C, O)
        return called("", n((clips, into, frames)), n((O, inputs, width)),
                      n(out), **attributes, **({"groups": groups} if groups > 1 else {}))
    thin = {"clips": 1, "inputs": 2, "outputs": 2, "groups": 1, "frames": 6, "width": 3}
    found = along(thin, _sized) + along({"frames": 6}, lambda frames: _sized(
        1, 1, 1, 1, frames, 3), LONG)
    found += [called(f"{width} width, {frames} frames", *_sized(2, 2, 3, 1, frames, width).inputs,
                     large=width > LARGE) for width in (*SIZES[2:14], 129)
              for frames in sorted({width - 1, width, width + 1, 2 * width + 1, 16, 64})]
    x, w, b = _sized(2, 2, 3, 1, 9, 3).inputs
    x[0, 0, 4], w[1, 0, 1], w[:, :, 2] = np.inf, 0.0, np.where(w[:, :, 2] > 0, w[:, :, 2], 0.0)
    found.append(Sample("filters with zeros, frames of infinity", (x, w, b), smooth=False))
    same = _sized(2, 1, 1, 1, 60000, 1).inputs[1:]
    found.append(called("a long sum of equal numbers", np.full((2, 1, 60000), 0.1),
                        *same, large=True, upstream=0.1, factors=(1.0, 3e3, 100.0)))
    found += [called(f"{s.label}, stride 2", *s.inputs, **s.attributes, stride=2, padding=1,
                     large=s.large)
              for s in found if s.inputs[1].shape[2] == 3 and s.inputs[0].shape[2] > 2][::4]
    found += at_sizes(_sized, {
        "the papers' encoder": (1, 66, 256, 1, 240, 25),
        "ten clips, odd frames": (10, 66, 16, 1, 61, 25), "a batch of 33": (33, 16, 66, 1, 31, 15),
        "many of each": (3, 128, 65, 1, 33, 5),
        "filters longer than long clips": (2, 3, 17, 1, 64, 129),
        "wide groups": (2, 33, 17, 4, 35, 7)})
    levels = {"width": (1, 2, 3, 6, 13),
              "stride": (1, 2, 3, 5), "dilation": (1, 2, 3), "groups": (1, 2, 3),
              "padding": ("same", "valid", 0, 2, (0, 3), (4, 1)), "bias": (True, False),
              "frames": (1, 8, 11), "clips": (1, 3), "inputs": (1, 2), "outputs": (1, 3)}
    if transposed:
        levels["output_padding"] = (0, 1, 2)

    def _fits(c):
        span, pad = c["dilation"] * (c["width"] - 1), c["padding"]
        if pad == "same" and c["stride"] > 1:
            return False
        zeros = span if pad == "same" else 0 if pad == "valid" else np.sum(pad) * (
            1 if isinstance(pad, tuple) else 2)
        if transposed:
            more = c["output_padding"]
            return (more < max(c["stride"], c["dilation"])
                    and (c["frames"] - 1) * c["stride"] + span + 1 - zeros + more >= 1)
        return c["frames"] + zeros > span
    for choice in pairs(levels, _fits, rng):
        given = {k: choice[k] for k in ("stride", "dilation", "padding", "output_padding")
                 if k in choice and choice[k] != {"stride": 1, "dilation": 1, "padding": "same",
                                                  "output_padding": 0}[k]}
        sample = _sized(choice["clips"], choice["inputs"], choice["outputs"], choice["groups"],
                        choice["frames"], choice["width"], **given)
        x, w, b = sample.inputs
        found.append(called(_label(choice),
                            x, w, b if choice["bias"] else None, **sample.attributes))
    return found


def _spread(rng, *shape):
    """Numbers of which no two are near."""
    count = int(np.prod(shape))
    return ((rng.permutation(count) - count // 2 + 0.25) / 4).reshape(shape)


def pools(rng: np.random.Generator, average: bool = False) -> list[Sample]:
    """Sizes, pairs of options; near ties, NaN and infinities among ordinary numbers."""
    found = along({"clips": 1, "channels": 2, "frames": 9, "width": 2},
                  lambda clips, channels, frames, width:
                  called("", _spread(rng, clips, channels, max(frames, width + 3)), width))
    found += along({"frames": 9}, lambda frames: called("", _spread(rng, 1, 1, frames),
                                                        2, stride=1), (255, 257, *LONG))
    low = -(1e38 if average else 3.402e38) * (1 - 1e-6 * np.arange(36.0).reshape(2, 2, 9))
    found += [called("far below zero, with padding",
                     low, 3, padding=1, stride=2, exact=not average),
              called("below float32, with padding", low * 1e100, 3, padding=1, exact=not average)]
    found += [called(f"windows of {width} half over each other", _spread(rng, 1, 2, 5 * width),
                     width, stride=width // 2) for width in (16, 33, 65, 300)]
    for frames, width, given in ((3, 2, {"padding": 1, "dilation": 4}),
                                 (1, 2, {"padding": 1, "dilation": 2, "stride": 1})):
        if not average:
            found.append(called(f"a window of padding alone, {frames} frames",
                                _spread(rng, 2, 2, frames), width, **given, exact=True))
    levels: dict[str, Sequence[Any]] = {"width": (1, 2, 3, 4, 7), "stride": (None, 1, 2, 3, 5),
                                        "padding": (0, 1, 2, 3), "ceil_mode": (False, True),
                                        "frames": (7, 8, 12), "clips": (1, 2)}
    levels.update({"count_include_pad": (True, False)} if average else {"dilation": (1, 2, 3)})

    def _fits(c):
        span = c.get("dilation", 1) * (c["width"] - 1) + 1
        return 2 * c["padding"] <= c["width"] and c["frames"] + 2 * c["padding"] >= span
    for c in pairs(levels, _fits, rng):
        given = {k: v for k, v in c.items() if k not in ("width", "frames", "clips")
                 and v not in (None, 0, False) and (k, v) not in (("dilation", 1),
                                                                  ("count_include_pad", True))}
        if c.get("count_include_pad") is False:
            given["count_include_pad"] = False
        found.append(called(_label(c),
                            _spread(rng, c["clips"], 3, c["frames"]), c["width"], **given))
    return found + ([] if average else _near_ties(rng))


def _near_ties(rng):
    """Values apart by a last digit, 1e-7 and 1e-3, in both orders; ties among other windows."""
    found = []
    for label, step in (("a last digit", 2.0 ** -52), ("1e-9", 2.0 ** -30),
                        ("a last digit in float32", 2.0 ** -23), ("1e-6", 2.0 ** -20),
                        ("1e-3", 2.0 ** -10)):
        x = np.ones((2, 2, 8))
        x[:, :, 1::4] += step
        x[:, :, 2::4] += step
        x[1] *= -4
        found.append(called(f"near ties, {label}", x, 2, exact=True))
        found.append(called(f"near ties in windows of three, {label}", x, 3, stride=1, exact=True))
    small = _spread(rng, 2, 2, 8) * 1e-12
    found.append(called("small numbers, none near another", small, 3, stride=2, exact=True))
    signs = np.sign(_spread(rng, 2, 2, 12)) * np.abs(_spread(rng, 2, 2, 12)).round()
    found.append(called("whole numbers, zeros and ties", signs, 3, stride=2, exact=True))
    zeros = np.array([[[-0.0, 0.0, 0.0, -0.0], [0.0, -0.0, -1.0, -0.0]]])
    found += [called(f"zeros of both signs in windows of {width}", zeros, width, exact=True)
              for width in (2, 4)]
    for width in (8, 16, 33):                                    # lanes of a vector, and beyond
        few = rng.integers(-2, 1, (1, 3, 2 * width)).astype(float)
        found.append(called(f"many ties in windows of {width}", few, width, exact=True))
    x = _spread(rng, 2, 3, 12)
    x[0, 1, 5] = x[0, 1, 4]
    x[1, 2, :3] = 0.0, -0.0, 0.0
    found += [called("ties among others", x, 3, exact=True),
              called("ties among others, one by one", x, 3, stride=1, padding=1, exact=True)]
    for label, values in (("NaN among others", (np.nan,)), ("infinities among others",
                                                            (np.inf, -np.inf)),
                          ("windows of NaN", (np.nan,) * 3), ("windows of minus infinity",
                                                              (-np.inf,) * 3),
                          ("NaN after infinity", (np.inf, np.nan)),
                          ("NaN before infinity", (np.nan, np.inf))):
        for at in (0, 4, 9):
            y = _spread(rng, 2, 2, 12)
            y[1, 0, at:at + len(values)] = values
            found.append(called(f"{label}, frame {at}", y, 3, stride=2, exact=True))
    return found


def unpools(rng: np.random.Generator) -> list[Sample]:
    """Sizes; several values for one place among others."""
    def _sized(clips, channels, frames):
        places = [[rng.permutation(2 * frames)[:frames] for _ in range(channels)]
                  for _ in range(clips)]
        return called("",
                      rng.standard_normal((clips, channels, frames)), np.array(places), 2 * frames)
    found = along({"clips": 1, "channels": 2, "frames": 3}, _sized)
    found += along({"frames": 3}, lambda frames: _sized(1, 1, frames), LONG)
    for kind in (np.int32, np.int16, np.uint8):
        x, places, frames = _sized(2, 2, 100).inputs
        found.append(called(f"places in {kind.__name__}",
                            x, places.astype(kind), frames, large=True))
    equal = np.array([[[1.5, 1.5, 2.0, 1.5]]]), np.array([[[2, 2, 0, 2]]]), 4
    found.append(called("equal values for one place", *equal, exact=True))
    places = np.array([[[0, 5, 5, 2], [1, 1, 1, 0]]])
    return found + [called("places met twice among others",
                           rng.standard_normal((1, 2, 4)), places, 7, exact=True)]


def depools(rng: np.random.Generator, chosen: bool = False) -> list[Sample]:
    """Sizes of each axis and of the width."""
    def _sized(clips, channels, frames, width):
        h = rng.standard_normal((clips, channels, frames))
        return called("",
                      *((h, rng.integers(width, size=h.shape), width) if chosen else (h, width)))
    small = []
    for kind in (np.int32, np.int16, np.int8, np.uint8) if chosen else ():
        h, which, width = _sized(2, 2, 150, 2).inputs
        small.append(called(f"choices in {kind.__name__}",
                            h, which.astype(kind), width, large=True))
    return (small + along({"clips": 1, "channels": 2, "frames": 3, "width": 2},
                          _sized) + along({"width": 2}, lambda width: _sized(1, 2, 3, width),
                                          [n for n in range(3, 60) if n not in SIZES]) +
            along({"frames": 3}, lambda frames: _sized(1, 1, frames, 2), LONG))


def elements(rng: np.random.Generator, inputs: int = 1, summed: bool = False) -> list[Sample]:
    """Arrays of each length, and with each axis long; zeros, tiny numbers and -0.0 among others."""
    def _some(*shape):
        return tuple(_spread(rng, *shape) + 0.01 * i for i in range(inputs))
    found = along({"elements": 5}, lambda elements: called("", *_some(elements)), (*SIZES, *LONG))
    found += along({"clips": 1, "channels": 2, "frames": 3},
                   lambda clips, channels, frames: called("", *_some(clips, channels, frames)))
    x = _spread(rng, 3, 4)
    x[0, 1], x[1, 2], x[2, 3], x[2, 0] = 0.0, -0.0, 1e-30, -1e-30
    others = [x + _spread(rng, 3, 4) * (x != 0) for _ in range(inputs - 1)]
    far = [2.0 ** 19 + rng.permutation(12).reshape(3, 4) + i / 4 for i in range(inputs)]
    if inputs == 2:
        found.append(called("near each other, far from zero", *tuple(far), firm=True))
    found.append(called("zeros and tiny numbers among others",
                        x, *others, exact=inputs == 1 and not summed))
    return found


def measures(rng: np.random.Generator) -> list[Sample]:
    """One number for each clip: sizes of clips and of what a clip holds, constant ones too; clips
    of zeros among others."""
    n = rng.standard_normal
    found = along({"clips": 1, "channels": 2, "frames": 3},
                  lambda clips, channels, frames: called("", n((clips, channels, frames))))
    found += [called(f"{frames} frames", n((1, 1, frames)), large=True, factors=(
        max(1.0, math.sqrt(frames) / 60),)) for frames in LONG]        # added one after the other
    found += [called("as many clips as channels and frames", n((3, 3, 3))),
              called("as many clips as frames", n((4, 2, 4))),
              called("as many clips as numbers", n((5, 5))),
              called("many equal numbers",
                     np.full((1, 4, 250000), 0.1), large=True, factors=(1000.0,)),
              called("one number a clip", n((5, 1))), called("vectors of 240", n((3, 240)))]
    mixed = n((4, 3, 5)) * np.array([1.0, 1e-9, 0.0, 1e9])[:, None, None]
    mixed[0, 1] = 0.0
    return found + [called("small, large and no clips side by side", mixed),
                    called("one axis", n(6))]


def adam(rng: np.random.Generator) -> list[Sample]:
    """Lengths, late and early steps, defaults unsaid, moments without gradients, mixed sizes."""
    n = rng.standard_normal

    def _moments(*shape):
        return n(shape), n(shape), n(shape), n(shape) ** 2
    found = along({"elements": 5},
                  lambda elements: called("", *_moments(elements), t=3), (*SIZES, *LONG))
    found += [called(f"step {t}", *_moments(7), t=t)
              for t in (1, 2, 100, 1000, 1001, 3000, 12345, 10 ** 6, 10 ** 9)]
    p, g, m, v = _moments(6)
    found += [called("large gradients", p, np.sign(g) * 1e19, 0 * m, 0 * v, t=1),
              called("no gradient, but moments", p, 0 * g, m, v, t=4),
              called("no second moment yet", p, g, 0 * m, 0 * v, t=7),
              called("some gradients are zero", p,
                     g * (np.arange(6) % 2), m * (np.arange(6) < 4), v * (np.arange(6) > 1), t=5),
              called("a parameter of zero", 0 * p, g, m, v, t=2),
              called("tiny second moments", p, g * 1e-12, m * 1e-12, v * 1e-24, t=9),
              called("epsilon weighs", p, g * 1e-7, m * 1e-7, v * 1e-14, t=2, epsilon=1e-6)]
    for name, value in (("rate", 0.3), ("beta1", 0.0), ("beta1", 0.99), ("beta2", 0.5),
                        ("epsilon", 1e-2)):
        found.append(called(f"{name} {value:g}", *_moments(5), **{"t": 3, name: value}))
    return found
