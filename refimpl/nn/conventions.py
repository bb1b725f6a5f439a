"""Where two right implementations may differ: what is meant here, why, and who does otherwise.

Plain data, for readers and for programs that compare: when another implementation disagrees, try its rivals before looking for a fault.

    for convention in conventions.ALL:
        print(convention.where, "|", convention.here)
"""

from typing import NamedTuple


class Rival(NamedTuple):
    """Another rule, and who follows it."""

    rule: str
    who: str


class Convention(NamedTuple):
    """where : the operation or the point;  here : the rule of this project;  because : reason or equation;  rivals : tuple of Rival"""

    where: str
    here: str
    because: str
    rivals: tuple


OPERATIONS = (
    Convention("convolution", "cross-correlation: y[t] = sum_k w[k] x[t + k - pad_left]",
               "what PyTorch, JAX and ONNX mean; w[:, :, ::-1] maps one onto the other",
               (Rival("flipped filters: y[t] = sum_k w[k] x[t - k + pad_right]", "Theano, and with it the 2016 code; numpy.convolve"),)),
    Convention("'same' padding of an even filter", "of the dilation (K - 1) zeros the smaller half to the left",
               "SAME_UPPER of ONNX, 'SAME' of TensorFlow, padding='same' of PyTorch",
               (Rival("the smaller half to the right", "SAME_LOWER of ONNX; numpy.convolve(mode='same')"),)),
    Convention("filters of a transposed convolution", "those of the convolution it is the adjoint of: (channels of h, channels of x / groups, K)",
               "<conv1d(x, w), h> = <x, conv_transpose1d(h, w)> needs no rearranging, and tied weights are one array",
               (Rival("the two channel axes exchanged", "Keras: (K, channels of x, channels of h)"),)),
    Convention("max-pool tie", "all of the gradient to the first largest",
               "one element, as in the forward pass, and the same on every run",
               (Rival("all of it to every largest", "Theano"), Rival("split equally among the largest", "jnp.max"), Rival("any one", "cuDNN"))),
    Convention("NaN in a pool", "NaN wins, the first one", "an error that shows; PyTorch does the same",
               (Rival("ignored", "implementations that compare with > only"),)),
    Convention("last window of a pool with ceil_mode", "counts if it begins inside the input or the left padding",
               "PyTorch and ONNX", (Rival("every started window counts", "Caffe without padding"),)),
    Convention("mean over a window with ceil_mode", "the padding counts (count_include_pad), what hangs over beyond it does not",
               "PyTorch", (Rival("always divided by the width", "ONNX before its version 1.16"),)),
    Convention("average-depooling", "each value repeated and divided by the width",
               "what the 2016 code does at run time; the adjoint of average pooling",
               (Rival("repeated without dividing", "nearest-neighbour upsampling"),
                Rival("put at a random position of the window", "Holden 2015, in training"))),
    Convention("relu'(0)", "0", "dy where x > 0",
               (Rival("0.5", "jnp.maximum(x, 0); Theano's abs form (x + |x|) / 2"), Rival("1", "implementations that test x >= 0"))),
    Convention("d|x| at 0", "0", "sign(0) = 0, the middle of the subgradients", (Rival("1", "JAX"), Rival("-1", "implementations that test x > 0"))),
    Convention("gradient of the norm at 0", "0", "the subgradient of least size; a loss of 0 asks for no change",
               (Rival("NaN, from 0 / 0", "sqrt of a sum of squares in most tapes"),)),
    Convention("Gram matrix", "a sum over frames: G[c, d] = sum_t h[c, t] h[d, t]", "Holden 2017, eq. 6",
               (Rival("divided by the number of frames, or of elements", "the 2016 code; Johnson 2016"),)),
    Convention("Adam", "Kingma and Ba, algorithm 1: both moments corrected, epsilon added to the corrected root",
               "p - rate m_hat / (sqrt(v_hat) + epsilon); `variant` of `adam_step` has the rivals",
               (Rival("epsilon-hat: epsilon added before the correction", "Keras, old PyTorch"),
                Rival("no-bias-correction: m and v as they are", "ONNX with T = 0"))),
)

OTHERS = (
    Convention("dynamic time warping step", "symmetric1 on squared Euclidean distances", "Torresani 2006, eqs. 3 to 5",
               (Rival("symmetric2: the diagonal step counts twice", "dtw-python's default"), Rival("root of the summed squares", "tslearn"))),
    Convention("BVH root", "the OFFSET is ignored where the root has position channels; position channels replace a joint's OFFSET",
               "the channels are where the joint is", (Rival("refused", "readers that know rotation channels only"),)),
)

ALL = OPERATIONS + OTHERS
