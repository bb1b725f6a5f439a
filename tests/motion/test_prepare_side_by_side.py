"""A folder read by several processes, or by Dask's, is the folder read by one."""

from concurrent.futures import ProcessPoolExecutor
import multiprocessing

import numpy as np
import pytest

from refimpl.motion import bvh, dataset
from refimpl.embedded import walkers as synthetic


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    out = tmp_path_factory.mktemp("clips")
    for made in synthetic.make_database(seconds_per_clip=1.0, people=2, styles=("normal", "old"),
                                        contents=("walk",)):
        bvh.write_bvh(out / f"{made.name}.bvh", made.clip)
    return out


def prepared(folder, executor=None):
    paths, seen = dataset.find_clips(folder), []
    found = dataset.prepare(folder, dataset.labels_by_pattern(paths), fraction=0.5,
                            report=seen.append, executor=executor)
    assert seen == paths
    return found


def same(a, b):
    assert ((a.leg, a.source, len(a.clips)) == (b.leg, b.source, len(b.clips))
            and np.array_equal(a.bones, b.bones))
    for x, y in zip(a.clips, b.clips):
        assert (x.name, x.content, x.style, x.held_out) == (y.name, y.content, y.style, y.held_out)
        assert np.array_equal(x.features, y.features) and np.array_equal(x.contacts, y.contacts)


def test_processes(folder):
    with ProcessPoolExecutor(2, mp_context=multiprocessing.get_context("spawn")) as executor:
        same(prepared(folder, executor), prepared(folder))


def test_dask(folder):
    distributed = pytest.importorskip("distributed", reason="needs dask's distributed")
    with distributed.Client(n_workers=1, threads_per_worker=2, processes=False,
                            dashboard_address=None) as client:
        same(prepared(folder, client.get_executor()), prepared(folder))
