"""Formats of our own: what is written is what is read, whatever it holds."""

from hypothesis import given, settings, strategies as st
from hypothesis.extra.numpy import array_shapes, arrays
from hypothesis.stateful import RuleBasedStateMachine, invariant, rule
import numpy as np
import pytest

from refimpl.holden2017.trained import Manifold, Style
from refimpl.styles.files import load_manifold, load_style, save_manifold, save_style
from refimpl.motion.dataset import Dataset, Labelled, load_dataset, save_dataset
from refimpl.motion.features import FEATURES
from refimpl.motion.joints import BONES
from refimpl.motion.windows import Normaliser
from refimpl.storage import FormatError, atomic_write, load_npz, save_npz

numbers = arrays(st.sampled_from([np.float32, np.float64, np.int64, bool]),
                 array_shapes(max_dims=3, max_side=4, min_side=0))
words = st.text(min_size=1, max_size=8)


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp("formats")


@given(arrays_=st.dictionaries(st.text("abcXYZ019 _", min_size=1, max_size=6), numbers, max_size=4),
       facts=st.dictionaries(words,
                             st.one_of(st.integers(), st.floats(allow_nan=False), words,
                                       st.lists(words))))
def test_any_arrays_and_facts(folder, arrays_, facts):
    arrays_.pop("header", None)
    save_npz(folder / "any", "kind", 3, arrays_, facts)
    found, told = load_npz(folder / "any", "kind", 3, tuple(arrays_))
    assert told == facts and set(found) == set(arrays_)
    for name, array in arrays_.items():
        assert (found[name].dtype == array.dtype and found[name].tobytes() == array.tobytes()
                and found[name].flags.writeable)
    first = (folder / "any").read_bytes()
    save_npz(folder / "any", "kind", 3, arrays_, facts)
    assert (folder / "any").read_bytes() == first                # the same content, the same bytes


@settings(max_examples=15)
@given(st.integers(0, 10 ** 6), st.integers(1, 4), st.sampled_from([np.float32, np.float64]), words)
def test_models_and_datasets(folder, seed, count, dtype, name):
    rng = np.random.default_rng(seed)
    normaliser = Normaliser(rng.normal(size=FEATURES), rng.uniform(0.1, 2, FEATURES), name)
    manifold = Manifold({"W0": rng.normal(size=(count, FEATURES, 3)).astype(dtype),
                         "b0": rng.normal(size=count).astype(dtype)}, normaliser,
                        float(rng.uniform(1, 90)), rng.uniform(1, 9, len(BONES)))
    channels = [FEATURES, count, count, FEATURES]
    params = {f"W{i}": rng.normal(size=(channels[i], channels[i - 1], 5)).astype(dtype)
              for i in (1, 2, 3)}
    params.update({f"b{i}": rng.normal(size=channels[i]).astype(dtype) for i in (1, 2, 3)})
    save_manifold(folder / "m", manifold)
    save_style(folder / "s",
               Style(params, manifold, name, {"run": "walk", name: name}, ("a", "b"), ("c",)))
    again = load_style(folder / "s")
    assert (again.name == name and again.pairs == {"run": "walk", name: name}
            and (again.learned, again.exemplars) == (("a", "b"), ("c",))
            and again.manifold.leg == load_manifold(folder / "m").leg == manifold.leg)
    for key, value in {**params, **manifold.params}.items():
        assert np.array_equal({**again.params, **again.manifold.params}[key], value)
    clips = tuple(Labelled(f"{name}{i}", name, "old", bool(i % 2),
                           rng.normal(size=(i + 1, FEATURES)), rng.random((i + 1, 4)) < 0.5)
                  for i in range(count))
    save_dataset(folder / "d", Dataset(clips, manifold.leg, manifold.bones, name))
    found = load_dataset(folder / "d")
    assert found.source == name and len(found.clips) == count
    for a, b in zip(found.clips, clips):
        assert (a.name, a.content, a.style, a.held_out) == (b.name, b.content, b.style, b.held_out)
        assert np.array_equal(a.features, b.features) and np.array_equal(a.contacts, b.contacts)


def test_a_model_whose_parts_do_not_fit_is_refused(tmp_path):
    good = Manifold({"W0": np.zeros((2, FEATURES, 3)), "b0": np.zeros(2)},
                    Normaliser(np.zeros(FEATURES), np.ones(FEATURES), "x"), 80.0,
                    np.ones(len(BONES)))
    for change, message in (({"b0": np.zeros(3)}, "found W0"),
                            ({"W0": np.zeros((2, 5, 3))}, "found W0"),
                            ({"W0": np.full((2, FEATURES, 3), np.nan)}, "not finite"),
                            ({"W0": np.zeros((2, FEATURES, 3), np.float32)}, "found W0")):
        save_manifold(tmp_path / "m",
                      Manifold({**good.params, **change}, good.normaliser, good.leg, good.bones))
        with pytest.raises(FormatError, match=message):
            load_manifold(tmp_path / "m")
    save_manifold(tmp_path / "m",
                  Manifold(good.params, Normaliser(np.zeros(FEATURES), np.zeros(FEATURES), "x"),
                           80.0, good.bones))
    with pytest.raises(FormatError, match="not above 0"):
        load_manifold(tmp_path / "m")
    save_manifold(tmp_path / "m", Manifold(good.params, good.normaliser, -1.0, good.bones))
    with pytest.raises(FormatError, match="found no leg"):
        load_manifold(tmp_path / "m")


class Files(RuleBasedStateMachine):
    """A folder in which writes succeed or fail half-way: every file is always one that was once
    written whole.
    """

    def __init__(self):
        super().__init__()
        import tempfile
        from pathlib import Path
        self.folder = tempfile.TemporaryDirectory()
        self.path, self.whole = Path(self.folder.name), {}

    @rule(name=st.sampled_from("abc"), text=st.text(max_size=20))
    def write(self, name, text):
        with atomic_write(self.path / name) as file:
            file.write(text)
        self.whole[name] = text

    @rule(name=st.sampled_from("abc"), text=st.text(max_size=20))
    def fail(self, name, text):
        try:
            with atomic_write(self.path / name) as file:
                file.write(text)
                raise KeyboardInterrupt
        except KeyboardInterrupt:
            pass

    @invariant()
    def only_whole_files(self):
        assert {p.name: p.read_bytes().decode() for p in self.path.iterdir()} == self.whole

    def teardown(self):
        self.folder.cleanup()


TestFiles = Files.TestCase
TestFiles.settings = settings(max_examples=20, stateful_step_count=10, deadline=None)
