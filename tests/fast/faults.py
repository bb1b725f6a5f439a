"""Sixteen plausible faults for refimpl/fast: (name, file, old, new, why). `old` occurs once in its
file. `why` says which BACKEND functions differ and, where it matters, for which inputs."""

FAULTS = [
    # ---------------------------------------------------------------------------- spectral.py
    ("spectral-dx-two-tiles", "spectral.py",
     "        for offset in range(0, self.n, self.L):\n",
     "        for offset in (0, self.L):\n",
     "SUBTLE. Adds only two pieces of overlap; with n > 2 L (wide filters: K 25, n 32..44) third "
     "pieces are lost, K 7..16 stays right. conv1d_backward and conv_transpose1d_backward (dx, "
     "dh), encode_backward (dX), autoencoder_loss_backward (K 25)"),
    ("spectral-frequencies-float32", "spectral.py",
     "    w = np.pi * (2 * np.arange(n // 2)[:, None] + 1) / n\n",
     "    w = np.pi * (2 * np.arange(n // 2, dtype=np.float32)[:, None] + 1) / n\n",
     "SUBTLE. Frequencies rounded to single precision: float64 results off by 1e-7..1e-6 relative, "
     "float32 the same. All BACKEND functions: conv1d, conv1d_backward, conv_transpose1d, "
     "conv_transpose1d_backward, encode, encode_backward, decode, transform, "
     "autoencoder_loss(_backward), total_loss(_backward)"),
    ("spectral-dy-spectrum-over-x", "spectral.py",
     """        dY = self._spectrum("Y", O)\n""",
     """        dY = self._spectrum("X", O)\n""",
     "SUBTLE. The spectrum of dy is written over the kept one of x when input and output channels "
     "are equally many (C = O), so dw is wrong then. conv1d_backward, conv_transpose1d_backward "
     "(dw only, C = O only)"),
    # -------------------------------------------------------------------------------- conv.py
    ("conv-transpose-right-padding", "conv.py",
     "    return length, pad[0]\n",
     "    return length, pad[1]\n",
     "SUBTLE. Padding of the right instead of the left: same for odd K with 'same' or one number. "
     "conv_transpose1d, conv_transpose1d_backward for even K with 'same', or padding=(1, 4)"),
    ("conv-dilation-unchecked", "conv.py",
     """for name in ("stride", "dilation", "groups")]""",
     """for name in ("stride", "groups")]""",
     "Dilation is ignored; with 'same' padding the shapes still fit. conv1d, conv1d_backward, "
     "conv_transpose1d, conv_transpose1d_backward with dilation=2"),
    ("conv-backward-assumes-same", "conv.py",
     "    dx, dw = _backward(dy, x, w, pad[0], T_out)\n",
     "    dx, dw = _backward(dy, x, w, (w.shape[2] - 1) // 2, T_out)\n",
     "SUBTLE. The gradient's offset is right for padding 'same' only. conv1d_backward (dx, dw) "
     "with padding=0, 2 or (1, 4)"),
    # ----------------------------------------------------------------------------- decoder.py
    ("decoder-tie-to-second", "decoder.py",
     "    np.greater_equal(even, odd, out=first)\n",
     "    np.greater(even, odd, out=first)\n",
     "Tie rule reversed. Needs exact ties: total_loss_backward (dW3, db3) with W3 = b3 = 0, where "
     "T(I) is zero and every hidden pair is a tie; autoencoder_loss_backward (dW0) where some "
     "filters read only channels that are 0 all the time (X[:, :2] = 0, W0[:3, 2:] = 0, b0[:3] > "
     "0)"),
    ("decoder-even-width-offset", "decoder.py",
     "    reach = K - 1 - (K - 1) // 2\n",
     "    reach = (K - 1) // 2\n",
     "SUBTLE. Same for odd K; for even K the decoder is a frame off. decode, autoencoder_loss, "
     "autoencoder_loss_backward with even K"),
    ("decoder-active-by-even-frame", "decoder.py",
     "    np.maximum(H, 0, out=H)\n    np.greater(H, 0, out=active)\n",
     "    np.maximum(H, 0, out=H)\n    np.greater(even, 0, out=active)\n",
     "SUBTLE. A unit counts as active by its even frame alone: gradient lost where the odd frame "
     "wins and the even one is <= 0. autoencoder_loss_backward, total_loss_backward; losses stay "
     "right"),
    # --------------------------------------------------------------------------- gradients.py
    ("gradients-mean-squares-over-batch", "gradients.py",
     "        count = r[0].size if reading",
     "        count = r.size if reading",
     "SUBTLE. Mean over the whole batch, not each clip: content and style too small by B. "
     "total_loss, total_loss_backward with reading='mean_squares' and B > 1 only"),
    ("gradients-b2-before-mask", "gradients.py",
     """        dA *= np.greater(three.input, 0, out=self.masks[1])
        gradients["b2"] = wide_sum(dA, (0, 1))
""",
     """        gradients["b2"] = wide_sum(dA, (0, 1))
        dA *= np.greater(three.input, 0, out=self.masks[1])
""",
     "db2 summed before the ReLU's mask. total_loss_backward (db2 only)"),
    ("gradients-one-plan-for-input-and-output", "gradients.py",
     "        self.encoder = _plan(features, m, self.W0.shape[2])\n",
     "        self.encoder = self.of_input    # the same filters on as many frames\n",
     "SUBTLE. The encoder of T(I) shares the plan of I, so dW1 meets the stale spectrum of T(I). "
     "total_loss_backward (dW1 only, when W1 and W0 are equally wide)"),
    # ------------------------------------------------------------------------- autoencoder.py
    ("autoencoder-db0-after-unpooling", "autoencoder.py",
     """        db0 = -wide_sum(dD, (0, 1))
        unpool_into(self._gathered(dD, later), self.first, self.active, self.dZ)
""",
     """        unpool_into(self._gathered(dD, later), self.first, self.active, self.dZ)
        db0 = -wide_sum(dD, (0, 1))
""",
     "SUBTLE. dD has been halved and masked in place when db0 sums it. autoencoder_loss_backward "
     "(db0), without `chosen`"),
    ("autoencoder-gathers-by-pooling-mask", "autoencoder.py",
     "        return np.where(later, pairs[:, :, 1], pairs[:, :, 0])\n",
     "        return np.where(self.first, pairs[:, :, 0], pairs[:, :, 1])\n",
     "SUBTLE. Gathers by the pooling's mask, not by the depooling's choice. "
     "autoencoder_loss_backward (dW0, db0) with `chosen` only"),
    # ----------------------------------------------------------------------------- stylist.py
    ("stylist-first-width-for-all", "stylist.py",
     "            left = (K - 1) // 2\n",
     "            left = (self.filters[0].shape[2] - 1) // 2\n",
     "SUBTLE. Zeros on the left by the first layer's width for all layers. transform when W1, W2, "
     "W3 are not equally wide"),
    ("stylist-bias-folded-into-next-layer", "stylist.py",
     """            y += self.biases[layer]
            if layer + 1 not in layers:
                return y
            after = even if layer + 1 == encoder else T
            following = self._plan(plans, layer + 1, N, after).input
            if layer + 1 < encoder:
                np.maximum(y, 0, out=following)
""",
     """            bias = self.biases[layer]
            if layer:                        # and what the layer before left out
                bias = bias + self.filters[layer].sum(2) @ before
            before = bias
            if layer + 1 not in layers:
                y += bias
                return y
            after = even if layer + 1 == encoder else T
            following = self._plan(plans, layer + 1, N, after).input
            if layer + 1 < encoder:          # relu(y + b) = max(y, -b) + b, one pass less
                np.maximum(y, -bias, out=following)
""",
     "SUBTLE. The bias is folded through the next layer, exact inside but not at the clip's edges, "
     "where zeros are padded. transform (first and last frames only, nonzero b1 or b2)"),
]
