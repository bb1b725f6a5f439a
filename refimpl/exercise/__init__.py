"""What the check cell of a notebook calls: your function is judged element by element, told where
it is wrong and what kind of mistake that looks like, or, as long as it is not written, replaced.

| module | question |
| --- | --- |
| `trial` | is the answer right, and which function does the notebook go on with? |
| `mistakes` | which mistake would give just these numbers? |
"""

from .trial import attempt, slopes

__all__ = ["attempt", "slopes"]
