"""A backend judged in a process of its own: one that crashes, hangs, leaves the program or eats the
memory ends that process, and the judge says so.

The child makes the cases of one operation after the other and tells which one it is about to ask.
When no answer comes, that case has its verdict and another child goes on without it.
"""

from collections.abc import Iterator, Mapping
import contextlib
from dataclasses import dataclass, field, replace
import multiprocessing
import os
import signal
import sys
import time
from typing import Any

from .backend import BackendError, load_backend, words_of
from .cases import cases
from .golden import read_folder
from .judge import Outcome, judge_together

PATIENCE = 3                    # calls of one function that may end a process before it is let be
LOADING = 300.0                                # seconds for a module and its libraries to be loaded
GIGABYTE = 2 ** 30
# Packages whose functions a verdict is computed with.
TOOLS = "builtins", "math", "numpy", "refimpl"
# seconds between two looks at a child's memory
LOOK = 0.1


@dataclass(frozen=True)
class Request:
    """What a child is to judge, and by what.

    words : "module:object";  operations : in their order;  seed, profile : of `cases`
    golden : a folder that the cases come from instead;  expected : patterns of known failures
    time_limit : seconds for a call;  memory_limit : gigabytes that it may take beyond what it had
    settled, given_up : of `judge_together`, known from children before
    """

    words: str
    operations: tuple[str, ...]
    seed: int = 0
    profile: str = "core"
    golden: str | None = None
    expected: tuple[str, ...] = ()
    time_limit: float = 60.0
    memory_limit: float = 8.0
    settled: Mapping[str, str] = field(default_factory=dict)
    given_up: tuple[str, ...] = ()


def judge_apart(request: Request) -> Iterator[Any]:
    """Judge a backend in another process.

    ->  yields first the Backend, without its functions, then each Outcome, whose case has no arrays
    Raises BackendError for what cannot be loaded.
    """
    left, told = list(request.operations), False
    settled: dict[str, str] = {}
    given_up: list[str] = []
    ends: dict[str, int] = {}
    while left:
        child = _Child(replace(request, operations=tuple(left), settled=settled,
                               given_up=tuple(given_up)))
        for what, value in child.messages():
            if what == "refused":
                raise BackendError(value)
            if what == "backend":
                if not told:
                    yield value
                told = True
            elif what == "outcomes":
                left.pop(0)
                yield from value
            elif what == "ended":
                if not told:
                    raise BackendError(f"{request.words}: found a module that {value} while it was "
                                       "loaded, needed module:object")
                if child.asked is None:
                    raise BackendError(f"{request.words}: {value} before anything is asked")
                identity, function = child.asked
                settled[identity] = value
                ends[function] = ends.get(function, 0) + 1
                if ends[function] == PATIENCE:
                    given_up.append(identity)


class _Child:
    """The process, what it was asked last, and what it says."""

    def __init__(self, request):
        self.request, self.asked = request, None
        context = multiprocessing.get_context("spawn")
        self.pipe, other = context.Pipe()
        self.process = context.Process(target=_work_apart, args=(other, request), daemon=True)
        self.process.start()
        other.close()

    def messages(self) -> Iterator[tuple[str, Any]]:
        """(what, value) until it is done; "ended" with the reason as the last where it was not."""
        limit: float | None = LOADING
        try:
            while True:
                why = self._wait(limit)
                if why:
                    yield "ended", why
                    return
                try:
                    what, value = self.pipe.recv()
                except (EOFError, OSError):
                    self.process.join()
                    yield "ended", _farewell(self.process.exitcode)
                    return
                if what == "done":
                    return
                limit = self.request.time_limit if what == "asking" else None
                if what == "asking":
                    self.asked = value
                elif what != "weighing":
                    yield what, value
        finally:
            if self.process.pid and hasattr(os, "killpg"):
                with contextlib.suppress(ProcessLookupError):    # it has no group of its own yet
                    os.killpg(self.process.pid, signal.SIGKILL)
            self.process.kill()
            self.process.join()
            self.pipe.close()

    def _wait(self, limit):
        """Why no answer is to be waited for any longer, "" when there is one."""
        began, had = time.monotonic(), _memory(self.process.pid)
        while not self.pipe.poll(LOOK):
            if limit is not None and time.monotonic() - began > limit:
                return f"gives no answer within {limit:g} s (it hangs)"
            taken = _memory(self.process.pid) - had
            if self.asked and taken > self.request.memory_limit * GIGABYTE:
                return f"takes more than {self.request.memory_limit:g} GB of memory"
        return ""


def _memory(pid):
    """Bytes that a process holds; 0 where the system does not tell."""
    try:
        with open(f"/proc/{pid}/statm", encoding="ascii") as file:
            return int(file.read().split()[1]) * os.sysconf("SC_PAGE_SIZE")
    except (OSError, ValueError, IndexError):
        return 0


def _farewell(code):
    """How a process ended that did not say that it was done."""
    if code is not None and code < 0:
        name = signal.Signals(-code).name if -code in set(signal.Signals) else f"signal {-code}"
        return f"crashes ({name})"
    return f"leaves the program (exit status {code})"


def _work_apart(pipe, request):
    """What the child does; whatever a backend starts is of its group, and ends with it."""
    if hasattr(os, "setsid"):
        os.setsid()
    try:
        _work(pipe, request)
    except KeyboardInterrupt:
        os._exit(130)
    except Exception as error:
        if os.environ.get("REFIMPL_TRACEBACK"):
            raise
        with contextlib.suppress(OSError):                       # nobody listens any more
            pipe.send(("refused", str(error) if isinstance(error, BackendError) else
                       f"{request.words}: found a module beside which nothing can be judged "
                       f"({type(error).__name__}: {words_of(error)}), needed one that leaves "
                       "Python, NumPy and refimpl alone; REFIMPL_TRACEBACK=1 shows where"))


def _tools():
    """The functions and types of TOOLS.   ->  {(module, name): what it is}"""
    return {(name, key): value for name, module in list(sys.modules.items())
            if name.partition(".")[0] in TOOLS
            for key, value in list(vars(module).items()) if callable(value)}


def _leaves_alone(words, tools):
    """Raise BackendError where a tool is not what it was before the backend was there."""
    for (module, name), value in tools.items():
        if getattr(sys.modules.get(module), "__dict__", {}).get(name) is not value:
            raise BackendError(f"{words}: found {module}.{name} replaced, with which its answers "
                               "are judged, needed that to be left alone; put it back, or let "
                               "--command judge a program")


def _work(pipe, request):
    tools, leaves_alone = _tools(), _leaves_alone                # before a backend may replace it
    backend = load_backend(request.words)
    leaves_alone(request.words, tools)
    pipe.send(("backend", replace(backend, functions=dict.fromkeys(backend.functions, len))))
    for chosen in _chosen(request):
        found = judge_together(chosen, backend, request.expected, settled=request.settled,
                               given_up=request.given_up,
                               asking=lambda case: pipe.send(("asking", (case.id, case.function))),
                               weighing=lambda: pipe.send(("weighing", None)))
        leaves_alone(request.words, tools)
        pipe.send(("outcomes", [_light(outcome) for outcome in found]))
    pipe.send(("done", None))
    with contextlib.suppress(Exception):                         # a backend may have changed it
        sys.stdout.flush()


def _chosen(request):
    """The cases of one operation after the other."""
    if request.golden is not None:
        every, _ = read_folder(request.golden)
        for name in request.operations:
            yield [case for case in every if case.operation.name == name]
        return
    for name in request.operations:
        yield cases(operations=[name], seed=request.seed, profile=request.profile)


def _light(outcome: Outcome) -> Outcome:
    """An outcome that can travel: without arrays and errors."""
    case = replace(outcome.case, expected=None, yardstick=None, others=(), arguments=tuple(
        _plain(x) for x in outcome.case.arguments), attributes={
            name: _plain(value) for name, value in outcome.case.attributes.items()})
    return replace(outcome, case=case, error=None, answer=None)


def _plain(value):
    return value if value is None or isinstance(value, (str, bool, int, float, tuple)) else ...
