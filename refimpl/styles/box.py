"""The styles in the box: small ones that come with the package, all on one loss network, in half
precision. `make` makes each again.
"""

import functools
from pathlib import Path

from ..holden2017.trained import Manifold, Style
from ..storage import FormatError
from .files import load_manifold, load_style

FOLDER = Path(__file__).parent
LOSS_NETWORK = "loss_network"
# What a look at each shows.
STYLES_SAID = {"old": "bent, low and stiff, short arms", "proud": "upright, chest out, arms wide",
               "depressed": "slumped, head down, hanging arms",
               "childlike": "lively arms, springy, head up", "zombie": "both arms held out, stiff"}


def find_style(name: str | Path) -> Style:
    """A style: one in the box, by its name, or that of a file.

    >>> find_style("old").name
    'old'

    Raises FormatError for a name that is neither, and for a file that holds no style, OSError.
    """
    if name in STYLES_SAID:
        return load_style(FOLDER / f"{name}.npz", boxed_manifold())
    if not Path(name).exists():
        raise FormatError(f"{name}: found no such file and no style of that name in the box, "
                          f"needed one of {', '.join(STYLES_SAID)}, or what `refimpl train-style` "
                          "wrote")
    return load_style(name)


@functools.cache
def boxed_manifold() -> Manifold:
    """The loss network of all styles in the box."""
    return load_manifold(FOLDER / f"{LOSS_NETWORK}.npz")
