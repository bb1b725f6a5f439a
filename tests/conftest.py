"""What all tests share: the real clips where REFIMPL_MOCAP names their folder, hypothesis without
deadlines, and one BLAS thread for each of the processes that the tests are shared out to.
"""

import os
from pathlib import Path

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")          # before NumPy is imported

import hypothesis
import pytest

hypothesis.settings.register_profile("refimpl", deadline=None, derandomize=True,
                                     max_examples=int(os.environ.get("REFIMPL_EXAMPLES", "40")),
                                     suppress_health_check=[hypothesis.HealthCheck.too_slow])
hypothesis.settings.load_profile("refimpl")


@pytest.fixture(scope="session")
def mocap():
    """The folder of real clips. Without it these tests are skipped, or fail when
    REFIMPL_REQUIRE_MOCAP is set (as CI does).
    """
    return _folder("REFIMPL_MOCAP", "of real clips")


@pytest.fixture(scope="session")
def witness():
    """The folder of numbers that the authors' own code produced; found, skipped or required like
    that of the clips.
    """
    return _folder("REFIMPL_WITNESS", "with numbers of the authors' code")


def _folder(variable, what):
    folder = os.environ.get(variable)
    if not folder or not Path(folder).is_dir():
        message = f"{variable}={folder!r} names no folder {what}"
        if os.environ.get("REFIMPL_REQUIRE_MOCAP"):
            pytest.fail(message)
        pytest.skip(message)
    return Path(folder)
