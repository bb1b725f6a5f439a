"""What BLAS should know before NumPy loads it. Nothing that is set already is overruled."""

from collections.abc import MutableMapping


def prefer(environment: MutableMapping[str, str]) -> None:
    """Ask for one thread: many small matrix products on several BLAS threads spend their time
    waiting for each other.

    environment : os.environ, changed

    >>> told = {"MKL_NUM_THREADS": "3"}
    >>> prefer(told)
    >>> told
    {'MKL_NUM_THREADS': '3', 'OPENBLAS_NUM_THREADS': '1'}
    """
    environment.setdefault("OPENBLAS_NUM_THREADS", "1")
    environment.setdefault("MKL_NUM_THREADS", "1")
