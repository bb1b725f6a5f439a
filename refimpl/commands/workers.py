"""Processes that work for a command and end with it."""

from collections.abc import Iterator
from concurrent.futures import Executor, ProcessPoolExecutor
import contextlib
import multiprocessing
import os
import signal
import threading


@contextlib.contextmanager
def workers(count: int) -> Iterator[Executor | None]:
    """Yields an executor of `count` processes, or None for one.

    When the command is stopped, what was not begun is dropped; a worker whose parent has gone,
    however it went, ends by itself.
    """
    if count == 1:
        yield None
        return
    with _signals_blocked():                                     # the workers inherit it
        executor: Executor = ProcessPoolExecutor(count, initializer=_begin)
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


def _begin():
    """In a worker: Ctrl-C is the parent's affair, and without a parent there is no work."""
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
