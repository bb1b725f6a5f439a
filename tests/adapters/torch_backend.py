"""PyTorch under the names of `refimpl.nn`: values by its own kernels, gradients by its autograd;
NumPy arrays in and out, precision kept.

Needs torch (2.13.0 was used). `adam_step` takes one array and its moments, as the conformance kit
calls it.
"""

import numpy as np
import torch
from torch.nn import functional as F


def tensor(a):
    """A copy, so that read-only and negatively strided arrays will do; None, numbers and words
    stay.
    """
    return (torch.from_numpy(np.array(a, order="C")) if isinstance(a, (np.ndarray, np.generic))
            else a)


def array(t):
    return None if t is None else np.array(t.detach().numpy(), order="C")


def pair(f, arrays=1):
    """f on tensors  ->  f on arrays, and its backward: one gradient for each of the first `arrays`
    inputs.
    """
    def forward(*inputs, **attributes):
        return array(f(*map(tensor, inputs), **attributes))

    def backward(dy, *inputs, **attributes):
        inputs = [tensor(a) for a in inputs]
        wanted = [a.requires_grad_() for a in inputs[:arrays] if a is not None]
        y = f(*inputs, **attributes)
        found = ([array(d) for d in torch.autograd.grad(y, wanted,
                                                        torch.tensor(np.array(dy), dtype=y.dtype))]
                 + [None] * (arrays - len(wanted)))
        return found[0] if arrays == 1 else tuple(found)
    return forward, backward


def zeros(padding, w, stride, dilation):
    """"same" as a pair, the larger half to the right. What else there is torch understands, or
    refuses.
    """
    total = dilation * (w.shape[2] - 1)
    return (total // 2, total - total // 2) if padding == "same" and stride == 1 else padding


def conv1d(x, w, b=None, *, stride=1, padding="same", dilation=1, groups=1):
    padding = zeros(padding, w, stride, dilation)
    x, padding = (F.pad(x, padding), 0) if isinstance(padding, tuple) else (x, padding)
    return F.conv1d(x, w, b, stride, padding, dilation, groups)


def conv_transpose1d(h, w, b=None, *, stride=1, padding="same", output_padding=0, dilation=1,
                     groups=1):
    padding = (0, 0) if padding == "valid" else zeros(padding, w, stride, dilation)
    (left, right), padding = (padding, 0) if isinstance(padding, tuple) else ((0, 0), padding)
    full = F.conv_transpose1d(h, w, b, stride, padding, output_padding, groups, dilation)
    return full[..., left:full.shape[2] - right]


def max_pool1d(x, width=2, *, return_indices=False, **attributes):
    return F.max_pool1d(x, width, return_indices=return_indices, **attributes)


def avg_pool1d(x, width=2, **attributes):
    return F.avg_pool1d(x, width, **attributes)


def adam_step(p, g, m, v, *, t, rate=1e-3, beta1=0.9, beta2=0.999, epsilon=1e-8):
    parameter, m, v = tensor(p).requires_grad_(), tensor(m), tensor(v)
    parameter.grad = tensor(g)
    adam = torch.optim.Adam([parameter], lr=rate, betas=(beta1, beta2), eps=epsilon)
    adam.state[parameter] = {"step": torch.tensor(float(t - 1)), "exp_avg": m, "exp_avg_sq": v}
    adam.step()
    return array(parameter), array(m), array(v)


PAIRS = {"conv1d": pair(conv1d, 3), "conv_transpose1d": pair(conv_transpose1d, 3),
         "max_pool1d": pair(max_pool1d), "avg_pool1d": pair(avg_pool1d),
         "max_unpool1d": pair(lambda h, indices,
                              length: F.max_unpool1d(h, indices, length - h.shape[2] + 1, 1, 0,
                                                     (length,))),
         "avg_depool1d": pair(lambda h, width=2: F.interpolate(h, scale_factor=width) / width),
         "relu": pair(torch.relu), "gram": pair(lambda h: h @ h.mT),
         "l1": pair(lambda a: a.abs().sum()),
         "norm": pair(lambda r: torch.linalg.vector_norm(r[:, None].flatten(1), dim=1)),
         "sum_squares": pair(lambda r: r[:, None].flatten(1).square().sum(1)),
         "mean_squares": pair(lambda r: r[:, None].flatten(1).square().mean(1)),
         "squared_error": pair(F.mse_loss, 2), "absolute_error": pair(F.l1_loss, 2)}
BACKEND = ({name: f for name, (f, _) in PAIRS.items()} | {f"{name}_backward": f for name,
                                                          (_, f) in PAIRS.items()})
BACKEND |= {"max_pool1d_indices": lambda *a,
            **k: pair(lambda *b: max_pool1d(*b, return_indices=True, **k)[1])[0](*a),
            "adam_step": adam_step}
