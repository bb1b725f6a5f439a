"""PyTorch under the names of `refimpl.nn`: values by its own kernels, gradients by its autograd.

Needs torch (2.13.0 was used). `adam_step` takes one array and its moments, as the conformance kit
calls it.
"""

import torch
from torch.nn import functional as F

from refimpl.adapters.torch import backend


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


def max_pool1d(x, width=2, **attributes):
    return F.max_pool1d(x, width, **attributes)


def avg_pool1d(x, width=2, **attributes):
    return F.avg_pool1d(x, width, **attributes)


def adam_step(p, g, m, v, *, t, rate=1e-3, beta1=0.9, beta2=0.999, epsilon=1e-8):
    p, m, v = p.clone(), m.clone(), v.clone()
    p.grad = g
    adam = torch.optim.Adam([p], lr=rate, betas=(beta1, beta2), eps=epsilon)
    adam.state[p] = {"step": torch.tensor(float(t - 1)), "exp_avg": m, "exp_avg_sq": v}
    adam.step()
    return p, m, v


def clips(r):
    return r[:, None].flatten(1)


BACKEND = backend(
    conv1d=conv1d, conv_transpose1d=conv_transpose1d, max_pool1d=max_pool1d, avg_pool1d=avg_pool1d,
    max_pool1d_indices=lambda *x, **k: max_pool1d(*x, **k, return_indices=True)[1],
    max_unpool1d=lambda h, indices, length: F.max_unpool1d(
        h, indices.long(), length - h.shape[2] + 1, 1, 0, (length,)),
    avg_depool1d=lambda h, width=2: F.interpolate(h, scale_factor=width) / width,
    relu=torch.relu, gram=lambda h: h @ h.mT, l1=lambda a: a.abs().sum(),
    norm=lambda r: torch.linalg.vector_norm(clips(r), dim=1),
    sum_squares=lambda r: clips(r).square().sum(1),
    mean_squares=lambda r: clips(r).square().mean(1),
    squared_error=F.mse_loss, absolute_error=F.l1_loss, adam_step=adam_step)
