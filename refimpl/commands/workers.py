"""Processes that work for a command and end with it."""

from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import Executor, ProcessPoolExecutor
import contextlib
import multiprocessing
import os
import signal
import threading
from typing import Any

from ..storage import protected

_constants: tuple = ()                                           # in a worker: those of its command


def each(count: int, work: Callable, tasks: Iterable, *constants: Any) -> Iterator[Any]:
    """`work(task, *constants)` of each task, in their order, by `count` processes.

    work : a function of a module;  constants : given to each process once
    """
    with contextlib.ExitStack() as stack:
        executor = stack.enter_context(workers(count, *constants))
        if executor is None:
            yield from (work(task, *constants) for task in tasks)
            return
        for found in [executor.submit(_work, work, task) for task in tasks]:
            yield found.result()


def _work(work, task):
    return work(task, *_constants)


@contextlib.contextmanager
def workers(count: int, *constants: Any) -> Iterator[Executor | None]:
    """Yields an executor of `count` processes, or None for one.

    When the command is stopped, what was not begun is dropped; a worker whose parent has gone,
    however it went, ends by itself.
    """
    if count == 1:
        yield None
        return
    with _signals_blocked(), protected([]) as inputs:            # the workers inherit it
        executor: Executor = ProcessPoolExecutor(
            count, initializer=_begin, initargs=(inputs, constants))
        executor.submit(int).result()
    try:
        yield executor
    except BaseException:
        for worker in multiprocessing.active_children():
            worker.terminate()
        executor.shutdown(wait=False)
        raise
    executor.shutdown()


@contextlib.contextmanager
def _signals_blocked():
    """Ctrl-C and SIGTERM wait until the block ends; then they come."""
    if not hasattr(signal, "pthread_sigmask"):
        yield
        return
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT, signal.SIGTERM})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


def _begin(inputs, constants):
    """In a worker: what its parent reads stays protected, Ctrl-C is the parent's affair, and
    without a parent there is no work.
    """
    global _constants
    _constants = constants
    protected(inputs).__enter__()
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    signal.signal(signal.SIGTERM, signal.SIG_DFL)
    if hasattr(signal, "pthread_sigmask"):
        signal.pthread_sigmask(signal.SIG_UNBLOCK, {signal.SIGINT, signal.SIGTERM})
    parent = multiprocessing.parent_process()
    if parent is not None:
        threading.Thread(target=_end_with, args=(parent,), daemon=True).start()


def _end_with(parent):
    parent.join()
    os._exit(1)
