"""What a backend says that it lacks, so that one fact is one line and not a failure for each case.

A key (or attribute) "lacks" of a backend holds words, each of one of these forms:

- "float64" or "float32", a precision;
- "avg_pool1d", an operation with its gradient, or "gram_backward", the gradient alone;
- "avg_pool1d ceil_mode", an option or argument of it, wherever it is given;
- "conv1d padding=valid" or "conv1d b=None", one of its values.

The cases that a word covers are graded *not offered*.
"""

from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from .calls import Case

PRECISIONS = "float64", "float32"


def covering(case: "Case", lacks: Iterable[str]) -> str:
    """The first of the words that covers a case, "" where none does.

    >>> from refimpl.conformance import case
    >>> covering(case("gram/plain/forward/float32"), ["float64", "gram"])
    'gram'
    """
    for word in lacks:
        what, _, option = word.partition(" ")
        if what in PRECISIONS:
            if case.kind != "refused" and case.precision == what:
                return word
        elif what in (case.operation.name, case.function) and (not option or _given(case, option)):
            return word
    return ""


def _given(case, option):
    name, equals, value = option.partition("=")
    values = {**dict(zip(case.names, case.arguments)), **case.attributes}
    if name not in values:
        return False
    return str(values[name]) == value if equals else values[name] is not None


def mistake(words: Any, functions: Iterable[str], arguments: Mapping[str, Iterable[str]]) -> str:
    """What is wrong with words that a backend declares, "" where nothing is.

    functions : that may be named;  arguments : {function: names of its arguments and options}
    """
    if isinstance(words, str) or not isinstance(words, (list, tuple, set)):
        return f"found lacks of type {type(words).__name__}, needed a list of words"
    for word in words:
        what, _, option = str(word).partition(" ")
        if what not in PRECISIONS and what not in functions:
            return (f"found {word!r} among its lacks, needed float64, float32 or an operation, "
                    "with an option behind it where it is an option that is lacking")
        name = option.partition("=")[0]
        if name and (what in PRECISIONS or name not in arguments[what]):
            return (f"found {word!r} among its lacks, needed an argument or option of {what}"
                    + (f": {', '.join(arguments[what])}" if what in arguments else ""))
    return ""
