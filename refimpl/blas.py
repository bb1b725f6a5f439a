"""What BLAS should know before NumPy loads it: one thread, and the processor's wide registers. Nothing that is set already is overruled."""

from pathlib import Path

WIDE = {"avx512f", "avx512bw", "avx512cd", "avx512dq", "avx512vl"}


def prefer(environment, processor="/proc/cpuinfo"):
    """Set what is not set. Many small matrix products on several BLAS threads spend their time waiting for each other; and OpenBLAS takes a processor that
    is younger than itself for an old one with narrow registers, which halves its speed.   environment : os.environ, changed"""
    environment.setdefault("OPENBLAS_NUM_THREADS", "1")
    environment.setdefault("MKL_NUM_THREADS", "1")
    try:
        words = set(Path(processor).read_text(errors="replace").split())
    except OSError:
        return
    if WIDE <= words:
        environment.setdefault("OPENBLAS_CORETYPE", "SkylakeX")
