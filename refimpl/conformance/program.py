"""A program in any language as a backend: it reads a case's folder and writes its answers there, as
`schema.PROTOCOL` says.

What concerns memory alone, how arrays lie in it and whose it is, is not asked of a program.
"""

from collections import Counter
from collections.abc import Collection, Iterable, Iterator
import contextlib
from dataclasses import replace
import functools
from itertools import groupby
import os
from pathlib import Path
import re
import select
import shlex
import shutil
import signal
import subprocess
import tempfile
import time
from typing import Any

from .apart import PATIENCE
from .backend import Backend, BackendError, reference
from .calls import Case
from .judge import Outcome, judge_together
from .vectors import case_files, described, read_npy

IN_MEMORY = "leaves its inputs alone", "memory of its own", "reads its arguments anew"
ABSENT = 3                                                # the status of what is not offered
LONGEST = 1 << 16                                         # bytes of a line that a program says


class Refused(ValueError):
    """A program does not take the input."""


class NotOffered(NotImplementedError):
    """A program has no such operation, or not with such an option."""


class Broken(SystemExit):
    """A program crashed, hung, or wrote what cannot be read: none of these is a refusal."""


def judge_program(words: str, chosen: Iterable[Case], expected_failures: Collection[str] = (), *,
                  time_limit: float = 60.0) -> Iterator[Any]:
    """Judge a program.

    words : how it is started, as for a shell;  chosen, expected_failures : as for `judge_all`
    time_limit : seconds for a call
    ->  yields first the Backend, then each Outcome.   Raises BackendError for what is no program.
    """
    with tempfile.TemporaryDirectory(prefix="refimpl-") as scratch, contextlib.closing(
            _Program(words, Path(scratch), time_limit)) as program:
        yield program.backend
        asked = (case for case in chosen if not case.layout
                 and case.kind.removesuffix(", float32") not in IN_MEMORY)
        for _, group in groupby(asked, key=lambda case: case.operation.name):
            yield from program.outcomes(list(group), expected_failures)


def write_call(folder: str | Path, case: Case) -> None:
    """Write the folder that a program is asked by, to look at a failure."""
    _write(Path(folder), case_files(*described(case)))


def _write(folder, files):
    folder.mkdir(parents=True, exist_ok=True)
    for name, data in files.items():
        (folder / name).write_bytes(data)


class _Program:
    """The program, the case that it is asked about, and what it has said already."""

    def __init__(self, words: str, scratch: Path, limit: float) -> None:
        try:
            self.words = shlex.split(words)
        except ValueError:
            self.words = []
        if not self.words or shutil.which(self.words[0]) is None:
            raise BackendError(f"--command: found {words!r}, needed a program that can be started, "
                               "and its arguments")
        self.scratch, self.limit, self.served = scratch, limit, self.words[-1] == "-"
        self.backend = Backend({name: functools.partial(self._call, name)
                                for name in reference().functions}, name=words)
        self.said: dict[Any, Any] = {}
        self.ends: Counter[str] = Counter()
        self.case: Case
        self.process: Any = None
        self.started = 0

    def outcomes(self, cases: list[Case], patterns: Collection[str]) -> list[Outcome]:
        """Outcomes of one operation's cases. Each is asked before any is judged: what is not
        offered is no failure that a convention would have to explain."""
        self.said.clear()
        said = {case.id: self._first_words(case) for case in cases}
        offered = {case.function for case in cases if case.kind != "refused"
                   and not isinstance(said[case.id], NotOffered)}
        found = {}
        for case in cases:
            if case.function not in offered or isinstance(said[case.id], NotOffered):
                found[case.id] = _absent(case, said[case.id], case.function in offered)
            elif said[case.id] is None:
                found[case.id] = Outcome(case, "skipped", "not asked any more", grade="undecidable",
                                         found="not asked any more", expected="an answer")
        for o in judge_together([case for case in cases if case.id not in found], self.backend,
                                patterns, asking=self._about):
            found[o.case.id] = (_absent(o.case, o.error, True) if isinstance(o.error, NotOffered)
                                else self._reproduced(o) if o.status == "failed" else o)
        return [found[case.id] for case in cases]

    def _first_words(self, case):
        """What the program says to a case, None where its function has ended it too often."""
        if self.ends[case.function] == PATIENCE:
            return None
        files = case_files(*described(case))
        answer = self.said[_key(files)] = self._ask(files, case)
        self.ends[case.function] += isinstance(answer, Broken)
        return answer

    def _reproduced(self, outcome):
        lines = outcome.message.splitlines()[:-1]                # the last one is for a mapping
        return replace(outcome, message="\n".join([
            *lines, "    from refimpl.conformance.program import write_call",
            "    write_call('call', c)                         # then: "
            + "echo call | " * self.served + self.backend.name + " call" * (not self.served)]))

    def _about(self, case):
        self.case = case

    def _call(self, function, *arguments, **attributes):
        call = replace(self.case, arguments=arguments, attributes=attributes)
        files = case_files(*described(call))
        answer = self.said.pop(_key(files), None) or self._ask(files, call)
        if isinstance(answer, BaseException):
            raise answer
        return answer

    def _ask(self, files, case):
        """What the program says to a folder with these files.   ->  outputs, or an error"""
        self.started += 1
        folder = self.scratch / str(self.started)
        _write(folder, files)
        try:
            status, words = (self._line_of if self.served else self._status_of)(folder)
            if status == ABSENT:
                return NotOffered(words or "some of it")
            if status:
                return Refused(f"exit status {status}: {words}")
            if case.kind == "refused":                           # it was taken, whatever came of it
                return (None,)
            return _outputs(folder, described(case)[0]["outputs"])
        except Broken as error:
            self.close()
            return error
        finally:
            shutil.rmtree(folder, ignore_errors=True)

    def _start(self, arguments, **pipes):
        with open(self.scratch / "errors", "wb") as errors:
            try:
                self.process = subprocess.Popen(arguments, stderr=errors, start_new_session=True,
                                                **pipes)
            except OSError as error:
                raise BackendError(f"--command: found {self.backend.name!r} ({error.strerror}), "
                                   "needed a program that can be started") from None
        return self.process

    def _status_of(self, folder):
        """Exit status and last words of the program, started for one folder."""
        process = self._start([*self.words, folder], stdin=subprocess.DEVNULL,
                              stdout=subprocess.DEVNULL)
        try:
            status = process.wait(self.limit)
        except subprocess.TimeoutExpired:
            raise Broken(f"gives no answer within {self.limit:g} s (it hangs)") from None
        if status < 0:
            raise Broken(self._farewell())
        return status, self._last_words()

    def _line_of(self, folder):
        """Status and reason on the line by which the program, which stays, answers a folder."""
        process = self.process
        if process is None:
            process = self._start(self.words, stdin=subprocess.PIPE, stdout=subprocess.PIPE)
        with contextlib.suppress(BrokenPipeError):               # it has ended, which is seen below
            process.stdin.write(f"{folder}\n".encode())
            process.stdin.flush()
        line, end = b"", time.monotonic() + self.limit
        while not line.endswith(b"\n"):
            if len(line) > LONGEST:
                raise Broken(f"answers a line that begins {line[:60]!r} and goes on beyond "
                             f"{LONGEST} bytes, needed a line: 0, 3, or 1 and the reason")
            if not select.select([process.stdout], [], [], max(end - time.monotonic(), 0.0))[0]:
                raise Broken(f"gives no answer within {self.limit:g} s (it hangs)")
            piece = os.read(process.stdout.fileno(), 1 << 16)
            if not piece:
                with contextlib.suppress(subprocess.TimeoutExpired):
                    process.wait(self.limit)
                raise Broken(self._farewell())
            line += piece
        status, _, words = line.decode(errors="replace").strip().partition(" ")
        if "\n" in words or not re.fullmatch("[0-9]{1,3}", status):
            raise Broken(f"answers {line[:60]!r}, needed a line: 0, 3, or 1 and the reason")
        return int(status), words

    def _farewell(self):
        code = self.process.returncode
        if code is None:
            return "closes its standard output"
        name = next((known.name for known in signal.Signals if known == -code), f"signal {-code}")
        how = f"crashes ({name})" if code < 0 else f"ends without an answer (exit status {code})"
        return f"{how} {self._last_words()}".rstrip()

    def _last_words(self):
        lines = (self.scratch / "errors").read_text(errors="replace").strip().splitlines()
        return lines[-1].strip()[:200] if lines else ""

    def close(self) -> None:
        """End the program and what it has started."""
        if self.process is not None and self.process.poll() is None:
            os.killpg(self.process.pid, signal.SIGKILL)
            self.process.wait()
        for pipe in (self.process.stdin, self.process.stdout) if self.process else ():
            if pipe:
                with contextlib.suppress(BrokenPipeError):
                    pipe.close()
        self.process = None


def _absent(case, words, partly):
    """The outcome of what is not offered, of a function that is offered in part or not at all."""
    return Outcome(case, "skipped", f"not offered: {words}", grade="not offered",
                   expected=f"{case.function} ({words})" if partly else case.function)


def _key(files):
    return tuple(files.items())


def _outputs(folder, outputs):
    """What a program has written, None for what it has not.   Raises Broken."""
    wanted = {f"out{number}.npy" for number, output in enumerate(outputs) if output}
    more = {path.name for path in folder.glob("out*")} - wanted
    if more:
        raise Broken(f"writes {', '.join(sorted(more))}, needed {', '.join(sorted(wanted))} alone")
    found = []
    for number in range(len(outputs)):
        path = folder / f"out{number}.npy"
        try:
            found.append(read_npy(path.read_bytes()) if path.is_file() else None)
        except ValueError as error:
            raise Broken(f"writes {path.name}: {error}") from None
    return tuple(found)
