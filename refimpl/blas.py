"""What BLAS should know before NumPy loads it. Nothing that is set already is overruled."""


def prefer(environment):
    """One thread: many small matrix products on several BLAS threads spend their time waiting for
    each other.   environment : os.environ, changed
    """
    environment.setdefault("OPENBLAS_NUM_THREADS", "1")
    environment.setdefault("MKL_NUM_THREADS", "1")
