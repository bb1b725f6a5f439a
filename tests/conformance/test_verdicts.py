"""What is said of failures: by cause, with conventions and capabilities, and of a backend that ends
the process that judges it."""

import collections.abc
import itertools
import os
import select
import sys
import textwrap

import numpy as np
import pytest

from refimpl import nn
from refimpl.cli import main
from refimpl.conformance import BackendError, as_backend, cases, judge_all, reference
from refimpl.conformance.apart import Request, judge_apart
from refimpl.conformance.causes import causes, first_wrong
from refimpl.conformance.rivals import RIVALS

GOOD = reference().functions


def outcomes_of(operations, profile="small", **wrong):
    return list(judge_all({**GOOD, **wrong}, cases(operations=operations, profile=profile)))


def test_one_option_is_one_line():
    def no_stride(x, w, b=None, *, stride=1, **k):
        if stride == 2:
            raise NotImplementedError("stride 2")
        return nn.conv1d(x, w, b, stride=stride, **k)
    found = causes(outcomes_of(["conv1d"], conv1d=no_stride))
    assert [str(c) for c in found if "stride=2" in c.condition]
    assert len(found) <= 2 and {c.outcomes[0].grade for c in found} == {"stricter"}


def test_what_a_mask_covers_is_no_answer():
    def masked(h):
        return np.ma.masked_array(nn.gram(h), mask=True)
    found = outcomes_of(["gram"], gram=masked)
    graded = {o.grade for o in found if o.case.id.startswith("gram/plain/forward/float")}
    assert graded == {"wrong"}


def test_the_part_that_is_wrong_first_is_named():
    """Both are wrong; the encoder is made of the convolution."""
    wrong = {"conv1d": lambda *a, **k: 1.01 * nn.conv1d(*a, **k),
             "encode": lambda *a: 1.01 * GOOD["encode"](*a)}
    found = causes(outcomes_of(["conv1d", "encode"], **wrong))
    assert [(c.function, c.first) for c in found] == [("conv1d", ""), ("encode", "conv1d")]
    assert first_wrong("total_loss_backward", {"gram_backward"}) == "gram_backward"


@np.errstate(all="ignore")
def mean_of(loss):
    """NaN for no clip, without a warning."""
    return np.asarray(loss.sum() / loss.dtype.type(len(loss)))


@pytest.mark.parametrize("name, wrong, label", [
    ("style_loss", lambda *a, **k: np.asarray(GOOD["style_loss"](*a, **k).sum()), "summed"),
    ("bone_loss", lambda *a, **k: mean_of(GOOD["bone_loss"](*a, **k)), "averaged"),
    ("encode", lambda X, W, b: GOOD["encode"](X, W[:, :, ::-1].copy(), b), "as Theano has them"),
    ("sum_squares", nn.mean_squares, "the mean of the squares")])
def test_forms_of_others_are_named(name, wrong, label):
    found = [o for o in outcomes_of([name], **{name: wrong}) if o.case.function == name
             and o.case.kind in ("float64", "float32") and o.status == "failed"]
    assert found and all(label in o.rival for o in found)


def test_every_rival_differs_from_the_reference():
    for function, rivals in RIVALS.items():
        labels = [label for label, _ in rivals]
        assert function in GOOD and len(labels) == len(set(labels))


def test_what_a_backend_says_that_it_lacks_is_not_held_against_it():
    def single(h):
        return nn.gram(h.astype(np.float32))
    plain = list(judge_all({"gram": single}, cases(operations=["gram"], profile="small")))
    lacking = list(judge_all({"gram": single, "lacks": ["float64"]},
                             cases(operations=["gram"], profile="small")))
    assert any(o.grade == "wrong" for o in plain)
    assert {o.grade for o in lacking if o.case.kind != "refused"} == {"agrees", "not offered"}
    ceil = as_backend({"avg_pool1d": nn.avg_pool1d, "lacks": ["avg_pool1d ceil_mode"]})
    skipped = [o for o in judge_all(ceil, cases(operations=["avg_pool1d"], profile="small"))
               if o.expected == "avg_pool1d ceil_mode"]
    assert skipped and all("ceil_mode" in o.case.attributes for o in skipped)


@pytest.mark.parametrize("lacks, says", [
    ("float64", "a list of words"), (["float16"], "needed float64"),
    (["conv1d ceil_mode"], "needed an argument or option of conv1d: x, w, b, stride"),
    (["float64 x"], "float64")])
def test_lacks_that_mean_nothing_are_refused(lacks, says):
    with pytest.raises(BackendError, match=says):
        as_backend({"gram": nn.gram, "lacks": lacks})


UNRULY = """
    import os
    import time
    import numpy as np
    from refimpl import nn

    def crashes(h):
        if h.shape[2] == 33:
            os.kill(os.getpid(), 11)
        return nn.gram(h)

    def hangs(x):
        while x.shape[0] == 9:
            time.sleep(1)
        return nn.relu(x)

    def leaves(a):
        if a.size == 17:
            os._exit(0)
        return nn.l1(a)

    def eats(r):
        kept = [np.ones(2 ** 24) for _ in range(64 if len(r) == 17 else 0)]
        while kept:
            time.sleep(1)
        return nn.mean_squares(r)

    BACKEND = {"gram": crashes, "relu": hangs, "l1": leaves, "mean_squares": eats}
"""


@pytest.fixture
def unruly(tmp_path, monkeypatch):
    (tmp_path / "unruly.py").write_text(textwrap.dedent(UNRULY))
    monkeypatch.chdir(tmp_path)
    monkeypatch.syspath_prepend(str(tmp_path))
    monkeypatch.setattr("refimpl.conformance.apart.PATIENCE", 1)
    return "unruly:BACKEND"


@pytest.mark.parametrize("operation, says", [
    ("gram", "crashes (SIGSEGV)"), ("relu", "gives no answer within 5 s (it hangs)"),
    ("l1", "leaves the program (exit status 0)"),
    pytest.param("mean_squares", "takes more than 0.25 GB of memory", marks=pytest.mark.skipif(
        sys.platform != "linux", reason="memory is watched on Linux alone"))])
def test_a_backend_that_ends_its_process_is_judged(unruly, operation, says):
    backend, *found = judge_apart(Request(unruly, (operation,), time_limit=5, memory_limit=0.25))
    failed = [o for o in found if o.status == "failed" and o.grade == "wrong"]
    assert [o.found for o in failed] == [says] and backend.name == unruly
    assert any(o.grade == "agrees" for o in found)
    assert {o.grade for o in found} <= {
        "agrees", "wrong", "undecidable", "laxer", "not offered"}
    assert len(found) == len(cases(operations=[operation]))


def test_the_command_says_which_and_goes_on(unruly, capsys):
    assert main(["check", unruly, "--operations", "l1,avg_depool1d"]) == 1
    said = capsys.readouterr().out
    assert "leaves the program" in said and "verdict: disagrees" in said
    assert main(["check", unruly, "--operations", "avg_depool1d"]) == 1       # nothing is checked


def test_a_module_that_ends_its_process_is_refused_in_one_line(tmp_path, monkeypatch, capsys):
    (tmp_path / "gone.py").write_text("import os\nos._exit(7)\n")
    monkeypatch.chdir(tmp_path)
    assert main(["check", "gone:BACKEND"]) == 2
    assert "leaves the program (exit status 7) while it was loaded" in capsys.readouterr().err


@pytest.mark.parametrize("where", ["", "def gram(h):\n    "])
def test_what_ctrl_c_raises_leaves_no_traceback(tmp_path, monkeypatch, capfd, where):
    (tmp_path / "stopped.py").write_text(f"{where}raise KeyboardInterrupt\n")
    monkeypatch.chdir(tmp_path)
    status = main(["check", "stopped", "--operations", "gram", "--profile", "small"])
    said = capfd.readouterr()
    assert status == (1 if where else 2) and "Traceback" not in said.err
    assert "leaves the program (exit status 130)" in said.out + said.err


@pytest.mark.skipif(not hasattr(os, "killpg"), reason="needs groups of processes")
def test_what_a_backend_starts_ends_with_it(tmp_path, monkeypatch):
    """Its child holds a pipe open, whose end is read when the child has ended."""
    (tmp_path / "starts.py").write_text(
        "import subprocess\nfrom refimpl import nn\ndef gram(h):\n    with open('pipe', 'w') as p:"
        "\n        subprocess.Popen(['sleep', '1000'], stdout=p)\n    return nn.gram(h)\n")
    monkeypatch.chdir(tmp_path)
    os.mkfifo("pipe")
    reading = os.open("pipe", os.O_RDONLY | os.O_NONBLOCK)
    assert main(["check", "starts", "--operations", "gram", "--profile", "small"]) == 0
    os.set_blocking(reading, True)
    assert select.select([reading], [], [], 60)[0] and os.read(reading, 1) == b""
    os.close(reading)


@pytest.mark.parametrize("code, named", [
    ("np.abs = np.absolute = lambda x: 0 * x", "numpy.abs"),
    ("np.isnan = lambda x: np.full(np.shape(x), True)", "numpy.isnan"),
    ("import builtins; builtins.any = lambda x: False", "builtins.any"),
    ("from refimpl.conformance import judge\nimport refimpl\n"
     "sys.modules['refimpl.conformance.judge'].compare = lambda *a: 0.0", "judge.compare"),
    ("for k in [k for k in sys.modules if k[:7] == 'refimpl']: del sys.modules[k]", "refimpl")])
@pytest.mark.parametrize("where", ["", "    "])
def test_a_backend_leaves_alone_what_it_is_judged_with(tmp_path, monkeypatch, capfd, code, named,
                                                       where):
    """Whether it is loaded or asked: there is no verdict, and no trace of Python's."""
    body = "".join(f"{where}{line}\n" for line in code.splitlines())
    (tmp_path / "patches.py").write_text(
        "import sys\nimport numpy as np\n" + ("" if where else body) + "def gram(h):\n"
        + (body if where else "") + "    return 0 * (h @ h.swapaxes(1, 2))\n")
    monkeypatch.chdir(tmp_path)
    assert main(["check", "patches", "--operations", "gram", "--profile", "small"]) == 2
    said = capfd.readouterr()
    assert said.out == "" and named in said.err and "Traceback" not in said.err


def test_refusals_alone_are_no_verdict(tmp_path, monkeypatch, capsys):
    (tmp_path / "none.py").write_text(
        "from refimpl import nn\nMINE = {'gram': nn.gram, 'lacks': ['float64', 'float32']}\n")
    monkeypatch.chdir(tmp_path)
    assert main(["check", "none:MINE", "--operations", "gram", "--profile", "small"]) == 1
    assert "verdict: nothing checked" in capsys.readouterr().out


def test_names_without_end_are_refused():
    class Endless(collections.abc.Mapping):
        def __getitem__(self, key):
            return nn.gram

        def __iter__(self):
            return map("gram{}".format, itertools.count())

        def __len__(self):
            return 1
    with pytest.raises(BackendError, match="found more than 1000 names"):
        as_backend(Endless())


def test_a_module_that_is_never_loaded_is_refused_in_one_line(tmp_path, monkeypatch, capsys):
    (tmp_path / "waits.py").write_text("import time\ntime.sleep(1000)\n")
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("refimpl.conformance.apart.LOADING", 5.0)
    assert main(["check", "waits:BACKEND"]) == 2
    assert "within 5 s (it hangs) while it was loaded" in capsys.readouterr().err


def test_a_tolerance_that_no_float_holds_is_refused():
    with pytest.raises(BackendError, match="found tolerances"):
        as_backend({"gram": nn.gram, "tolerances": {"float32": 10 ** 400}})
