"""What somebody's own `torch.autograd.Function` looks like, in both forms that PyTorch has."""

import torch


class SquaredError(torch.autograd.Function):
    """With options, and the context in its forward."""

    @staticmethod
    def forward(ctx, x, y, factor=1, reduction="mean"):
        if x.shape != y.shape or reduction not in ("mean", "sum", "none"):
            raise ValueError("x, y: needed one shape, and mean, sum or none")
        ctx.save_for_backward(x, y)
        ctx.factor = 2 * factor / (x.numel() if reduction == "mean" else 1)
        squares = factor * (x - y) ** 2
        return {"mean": squares.mean, "sum": squares.sum, "none": squares.clone}[reduction]()

    @staticmethod
    def backward(ctx, dy):
        x, y = ctx.saved_tensors
        assert len(ctx.needs_input_grad) == 4                    # options come in their places
        dx = ctx.factor * dy * (x - y)
        return dx, -dx, None, None


class SumSquares(torch.autograd.Function):
    """With a context of its own."""

    @staticmethod
    def forward(r):
        return r[:, None].flatten(1).square().sum(1)

    @staticmethod
    def setup_context(ctx, inputs, output):
        ctx.save_for_backward(*inputs)

    @staticmethod
    def backward(ctx, dy):
        r, = ctx.saved_tensors
        return 2 * dy.reshape(-1, *(1,) * (r.ndim - 1)) * r


class HalfOfGram(torch.autograd.Function):
    """Its gradient is that of one factor alone."""

    @staticmethod
    def forward(ctx, h):
        ctx.save_for_backward(h)
        return h @ h.mT

    @staticmethod
    def backward(ctx, dy):
        h, = ctx.saved_tensors
        return dy @ h
