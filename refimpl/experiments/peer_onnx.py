"""The other peer of `refimpl bench`: P(T(X)) in ONNX Runtime, float32, for inference alone.
Imported by that command alone, if `onnx` and `onnxruntime` are there.
"""

from collections.abc import Callable
from typing import Any

import numpy as np
import onnx
from onnx import helper, numpy_helper
import onnxruntime

VERSION = f"ONNX Runtime {onnxruntime.__version__}"
_threads = [0]                                                   # 0: its own number


def use_threads(threads: int | None) -> None:
    """As many threads for sessions from now on; None for its own number."""
    _threads[0] = threads or 0


def inference(problem: Any, X: np.ndarray) -> dict[str, Callable[[], Any]]:
    """P(T(X)).   ->  {name: f}, nothing for float64, which its convolutions have not"""
    if problem.dtype != np.float32:
        return {}
    model, sessions = _model(problem, X.shape), {}

    def _run():
        if _threads[0] not in sessions:
            options = onnxruntime.SessionOptions()
            options.intra_op_num_threads = _threads[0]
            sessions[_threads[0]] = onnxruntime.InferenceSession(
                model, options, providers=["CPUExecutionProvider"])
        return sessions[_threads[0]].run(None, {"X": X})[0]

    return {"onnxruntime": _run}


def _model(problem, shape):
    """The graph as bytes; repetition in time is a transposed convolution with filters of ones."""
    W = {name: np.ascontiguousarray(a) for name, a in {**problem.T, **problem.L}.items()}
    m = len(W["b0"])
    W |= {"half": np.full((m, 1, 2), 0.5, np.float32), "column": W["b0"][:, None]}

    def _conv(x, number, y):
        return helper.make_node("Conv", [x, f"W{number}", f"b{number}"], [y], pads=[12, 12])

    node = helper.make_node
    nodes = [_conv("X", 1, "a1"), node("Relu", ["a1"], ["A1"]), _conv("A1", 2, "a2"),
             node("Relu", ["a2"], ["A2"]), _conv("A2", 3, "O"), _conv("O", 0, "Z"),
             node("MaxPool", ["Z"], ["pooled"], kernel_shape=[2], strides=[2]),
             node("Relu", ["pooled"], ["H"]),
             node("ConvTranspose", ["H", "half"], ["D"], strides=[2], group=m),
             node("Sub", ["D", "column"], ["E"]),
             node("ConvTranspose", ["E", "W0"], ["Y"], pads=[12, 12])]
    names = {name for n in nodes for name in n.input}
    graph = helper.make_graph(
        nodes, "refimpl", [helper.make_tensor_value_info("X", onnx.TensorProto.FLOAT, shape)],
        [helper.make_tensor_value_info("Y", onnx.TensorProto.FLOAT, None)],
        [numpy_helper.from_array(a, name) for name, a in W.items() if name in names])
    return helper.make_model(graph, opset_imports=[helper.make_opsetid("", 17)],
                             ir_version=9).SerializeToString()
