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
    with _without_ctrl_c():                                      # which the workers inherit
        executor: Executor = ProcessPoolExecutor(count, initializer=_begin)
        executor.submit(int).result()
    try:
        yield executor
    except BaseException:
        executor.shutdown(wait=False, cancel_futures=True)
        for worker in multiprocessing.active_children():
            worker.terminate()
        raise
    executor.shutdown()


@contextlib.contextmanager
def _without_ctrl_c():
    """Ctrl-C is of no effect while the block runs."""
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    before = signal.signal(signal.SIGINT, signal.SIG_IGN)
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, before)


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
