r"""The authors' network and normaliser as files: a user's own copy of what they published.

`network_core.npz` and `preprocess_core.npz` are theirs and not part of this package; whoever has
them may use them here under their licence (academic and other non-commercial use). The same two
kinds of file are written by `save_network` and `save_preprocess` for a network that was trained
here.

| array         | shape      | what                                                              |
| ------------- | ---------- | ----------------------------------------------------------------- |
| `L000_L001_W` | (m, 73, K) | filters of the encoder, reversed in time since Theano flips them  |
| `L000_L002_b` | (m, 1)     | its biases                                                        |
| `L001_L002_W` | (73, m, K) | filters of the decoder, reversed too                              |
| `L001_L003_b` | (73, 1)    | its biases                                                        |
| `Xmean`       | 73 numbers | what is subtracted                                                |
| `Xstd`        | 73 numbers | what it is divided by                                             |

In theirs m = 256 and K = 25.
"""

import io
from pathlib import Path
from typing import Any

import numpy as np

from ..storage import FormatError, atomic_write, is_special, plausible, read_arrays, read_bytes
from .network import Params
from .rows import HIPS_HEIGHT, NUMBERS, POINTS, POSITIONS, Normaliser

ARRAYS = {"We": "L000_L001_W", "be": "L000_L002_b", "Wd": "L001_L002_W", "bd": "L001_L003_b"}
MEAN, DEVIATION = "Xmean", "Xstd"
HIPS_RANGE = 10.0, 30.0                                          # units that mean hips may have
LARGEST_ARRAY = 1 << 27                                          # bytes; theirs has 3.7 million


def read_network(path: str | Path) -> Params:
    """The network of a `network_core.npz`, compressed or not.

    ->  We (m, 73, K), be (m,), Wd (73, m, K), bd (73,), as cross-correlations, in the file's
    precision
    Raises FormatError for anything else, OSError.
    """
    found = _arrays(path, ARRAYS.values(), "a network like the authors' network_core.npz")
    W, V = found[ARRAYS["We"]], found[ARRAYS["Wd"]]
    if W.ndim != 3 or W.shape[1] != NUMBERS or not W.size or not W.shape[2] % 2:
        raise FormatError(f"{path}: found {ARRAYS['We']} of shape {W.shape}, needed (hidden units, "
                          f"{NUMBERS}, an odd width)")
    hidden, _, width = W.shape
    if V.shape != (NUMBERS, hidden, width):
        raise FormatError(f"{path}: found {ARRAYS['Wd']} of shape {V.shape}, needed "
                          f"{(NUMBERS, hidden, width)}, the other way round than {ARRAYS['We']}")
    for name, size in (("be", hidden), ("bd", NUMBERS)):
        b = found[ARRAYS[name]]
        if b.shape not in ((size, 1), (size,)):
            raise FormatError(f"{path}: found {ARRAYS[name]} of shape {b.shape}, "
                              f"needed ({size}, 1)")
    dtype = np.result_type(*found.values())
    found = {name: found[array].astype(dtype) for name, array in ARRAYS.items()}
    return {"We": np.ascontiguousarray(found["We"][:, :, ::-1]), "be": found["be"].ravel(),
            "Wd": np.ascontiguousarray(found["Wd"][:, :, ::-1]), "bd": found["bd"].ravel()}


def read_preprocess(path: str | Path) -> Normaliser:
    """The normaliser of a `preprocess_core.npz`, compressed or not.

    Raises FormatError for anything else, OSError.
    """
    found = _arrays(path, (MEAN, DEVIATION), "a normaliser like the authors' preprocess_core.npz")
    for name, array in found.items():
        if array.size != NUMBERS:
            raise FormatError(f"{path}: found {name} of shape {array.shape}, needed {NUMBERS} "
                              "numbers")
    mean, deviation = (found[name].astype(float).ravel() for name in (MEAN, DEVIATION))
    if not (deviation > 0).all():
        raise FormatError(f"{path}: found {DEVIATION} with a number that is not above 0, needed "
                          "positive ones")
    return Normaliser(mean, deviation)


def save_network(path: str | Path, params: Params) -> None:
    """Write a network as the authors' code does; `read_network` gives it back to the last bit."""
    _save(path, {ARRAYS["We"]: params["We"][:, :, ::-1], ARRAYS["be"]: params["be"][:, None],
                 ARRAYS["Wd"]: params["Wd"][:, :, ::-1], ARRAYS["bd"]: params["bd"][:, None]})


def save_preprocess(path: str | Path, normaliser: Normaliser) -> None:
    """Write a normaliser as the authors' code does."""
    _save(path, {MEAN: normaliser.mean[None, :, None],
                 DEVIATION: normaliser.deviation[None, :, None]})


def check_unit(normaliser: Normaliser, path: str | Path) -> None:
    """Refuse a normaliser of another unit: contacts, floor and losses of the 2016 code know only
    its own.

    Raises FormatError that names the file.
    """
    hips = float(normaliser.mean[POSITIONS.start + 1])
    if not HIPS_RANGE[0] <= hips <= HIPS_RANGE[1]:
        raise FormatError(f"{path}: found hips {hips:g} above the floor on average (number "
                          f"{POSITIONS.start + 1} of {MEAN}), needed some {HIPS_HEIGHT:g}: the "
                          "2016 code's losses are in its own unit, of which a leg has 14.8")
    if np.abs(normaliser.mean[:POSITIONS.start]).max() > 1e-3 * normaliser.deviation[POINTS].max():
        raise FormatError(f"{path}: found a reference joint that is not at 0 on average (numbers "
                          f"0 to 2 of {MEAN}), needed one, or the numbers have another order")


def _arrays(path, names, kind):
    """These arrays of an `.npz` file, real and plausible, others left aside.   ->  {name: array}"""
    if is_special(path) and not Path(path).is_dir():
        raise FormatError(f"{path}: found a pipe or a device, needed {kind}, a file")
    data = read_bytes(path, LARGEST_ARRAY)
    try:
        found = read_arrays(data, names=tuple(names), most=LARGEST_ARRAY)
    except ValueError as error:
        raise FormatError(f"{path}: found something else or a damaged file ({error}), needed "
                          f"{kind}, an .npz file with {', '.join(names)}") from None
    missing = [name for name in names if name not in found]
    if missing:
        raise FormatError(f"{path}: found no {', '.join(missing)}, needed {kind} with "
                          f"{', '.join(names)}; is it the other one of the two files?")
    for name in names:
        array = found[name]
        if array.dtype not in (np.float32, np.float64):
            raise FormatError(f"{path}: found {name} of {array.dtype}, needed float32 or float64")
        if not plausible(array):
            raise FormatError(f"{path}: found values in {name} that are not finite or beyond 1e9, "
                              "needed those of a trained network")
    return {name: found[name] for name in names}


def _save(path, arrays):
    archive = io.BytesIO()
    members: Any = {name: np.ascontiguousarray(array) for name, array in arrays.items()}
    np.savez_compressed(archive, **members)
    with atomic_write(path, "wb") as file:
        file.write(archive.getbuffer())
