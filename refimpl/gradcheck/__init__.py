"""Is a gradient right? The instruments that check a hand-written backward, and what each must keep.

- `gradient`: `check_gradient` of all elements, `check_direction` along one line, `check_kink`.
- `derivative`: three ways to measure a derivative without knowing how it was derived.
- `slope`: the slopes to both sides of a point, with the function's own noise measured.
- `elements`: each element of a gradient, by the instrument that suits it.
- `contract`: what every backward keeps besides being right.
- `structure`: dicts and tuples of arrays.
- `difference`: how far two arrays are apart.
- `report`, `errors`: what a check says.

Nothing here knows an operation or a motion; any function of arrays can be checked.
"""

from ..lazy import opened
from .contract import check_contract
from .errors import GradientError, UndecidedError
from .gradient import check_direction, check_gradient, check_kink

__all__ = ["GradientError", "UndecidedError", "check_contract", "check_direction", "check_gradient",
           "check_kink"]

__getattr__, __dir__ = opened(__name__)
