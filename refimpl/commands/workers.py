"""Processes that work for a command and end with it."""

from concurrent.futures import Executor, ProcessPoolExecutor
import contextlib
import multiprocessing
import os
import signal
import threading


@contextlib.contextmanager
def workers(count: int):
    """An executor of `count` processes, None for one.   yields Executor or None

    When the command is stopped what was not begun is dropped; a worker whose parent has gone, however
    it went, ends by itself.
    """
    if count == 1:
        yield None
        return
    executor: Executor = ProcessPoolExecutor(count, initializer=_begin)
    try:
        yield executor
    except BaseException:
        executor.shutdown(wait=False, cancel_futures=True)
        raise
    executor.shutdown()


def _begin():
    """In a worker: Ctrl-C is the parent's affair, and without a parent there is no work."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    signal.signal(signal.SIGTERM, signal.SIG_DFL)
    parent = multiprocessing.parent_process()
    if parent is not None:
        threading.Thread(target=_end_with, args=(parent,), daemon=True).start()


def _end_with(parent):
    parent.join()
    os._exit(1)
