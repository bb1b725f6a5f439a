"""What does agreement mean? A kit that checks another implementation against this one, and this one
against itself.

- `specification`: what the kit knows of an operation.   `operations_*`: the specifications, with
  inputs to try and inputs to refuse.
- `functions_*`: the reference as functions of arrays alone, where it takes dicts or objects.
- `definitions_*`: everything a second time, in loops.   `rivals*`: conventions that others follow.
- `cases`: what is tried.   `backend`: who is tried.   `judge`: the verdict.
  `report`: for people and for machines.
- `stub`: a backend to fill in.   `adapted`: another library's functions as one.
- `verify`: the reference against its second derivation and the instruments of `gradcheck`.
- `golden`: inputs and outputs as files for readers without Python.
"""

from ..lazy import opened
from .backend import OPERATIONS, Backend, BackendError, as_backend, load_backend, reference
from .cases import Case, case, cases, parametrize
from .judge import Outcome, judge, judge_all

__all__ = ["OPERATIONS", "Backend", "BackendError", "Case", "Outcome", "as_backend",
           "case", "cases", "judge", "judge_all", "load_backend", "parametrize", "reference"]

__getattr__, __dir__ = opened(__name__)
