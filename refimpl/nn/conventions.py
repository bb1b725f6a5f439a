"""Where the mathematics leaves a choice: what holds here and what others do, as data.

The conformance kit's `rivals` holds these alternatives as functions, so that a report can say which
one a backend follows.
"""

from dataclasses import dataclass


@dataclass(frozen=True)
class Convention:
    """where : the situation;  here : the rule of this package;  why : in a few words;
    rivals : (rule, who follows it)"""

    where: str
    here: str
    why: str
    rivals: tuple


CONVENTIONS = (
    Convention("convolution", "cross-correlation: y[t] = sum_k w[k] x[t + k]",
               "what deep learning means by the word",
               (("filters flipped in time", "Theano, and with it the 2016 code"),)),
    Convention("zeros of 'same' padding when their number is odd", "the smaller half to the left",
               "as ONNX SAME_UPPER and PyTorch's conv1d",
               (("the larger half to the left", "ONNX SAME_LOWER"),)),
    Convention(
        "an infinite or NaN filter where it meets the padding",
        "the padding is zeros like any others: 0 times infinity is NaN",
        "y = sum w x with x = 0 outside its frames, as it stands; what cropping takes away "
        "is never multiplied", (("what lies outside is left out", "kernels that skip it"),)),
    Convention("equal largest elements in a max-pool window", "all the gradient to the first",
               "one definite subgradient, and what most kernels do",
               (("to every one of them", "Theano, and with it the 2016 code"),
                ("split equally", "jnp.max"), ("to any", "cuDNN"))),
    Convention("NaN in a max-pool window", "NaN is the largest",
               "an error should not vanish silently", (("NaN is ignored", "fmax-style kernels"),)),
    Convention("padding of a max-pool", "counts as -inf and passes no gradient",
               "padding must never win", ()),
    Convention("a max-unpool place that two values claim",
               "the later value stands and gets the gradient", "deterministic",
               (("undefined", "PyTorch"),)),
    Convention("derivative of relu at 0", "0", "a subgradient, and the sparser one",
               (("0.5", "jnp.maximum"),
                ("1", "x >= 0 kernels; Theano, and with it the 2016 code"))),
    Convention("relu of NaN", "NaN forward, 0 backward", "the forward shows the error",
               (("0 forward", "x > 0 ? x : 0 kernels"),)),
    Convention("derivative of |x| at 0", "0", "the subgradient of least size", (("1", "JAX"),)),
    Convention("derivative of a norm at 0", "0", "the subgradient of least size",
               (("NaN", "division by zero in automatic differentiation"),)),
    Convention("Adam",
               "Kingma and Ba, algorithm 1: both moments corrected, epsilon outside the root",
               "the published algorithm",
               (("epsilon-hat: epsilon added before the correction", "Keras, old PyTorch"),
                ("no bias correction", "ONNX at T = 0"),
                ("epsilon inside the root", "some hand-written ones"))),
    Convention("Gram matrix", "a sum over time", "equation 6 of Holden 2017",
               (("divided by the frames", "many image-style codes"),)),
    Convention(
        "the bars of the content and style loss",
        "norms, not squared, where nothing else is asked for; training asks for mean_squares",
        "equations 4 and 5 as printed; the paper's constants fit squares",
        (("means of squares", "the 2016 code"), ("sums of squares", "image-style codes"))),
    Convention(
        "depooling", "average-depooling, each value halved; while the loss network learns, "
        "one of the two frames, by chance for each unit, gets all of it",
        "equation 2; learning as the 2016 code does keeps the projection from jittering",
        (("halves in learning too", "the papers' text"),)),
    Convention(
        "a root's velocity in the 66 numbers", "seen from the frame that it leads to",
        "equation 7's omega x p[t] is then right to first order; the 2016 code",
        (("seen from the frame that it leaves", "this package before version 2 of its files"),)),
    Convention("turning error of the trajectory loss", "squared", "the accepted manuscript",
               (("not squared", "the journal text"),)),
    Convention("DTW step", "symmetric1, squared Euclidean distances",
               "Torresani 2006, equations 3 to 5", (("symmetric2", "dtw-python's default"),
                                                    ("the root of the summed squares", "tslearn"))),
    Convention("the sign of a principal component",
               "its largest element by size is positive, of those equal up to 1e-9 the first",
               "rounding decides nothing",
               (("the largest in the scores", "scikit-learn"), ("as it comes", "LAPACK"))),
    Convention("BVH position channels", "replace the joint's OFFSET", "what recorders write",
               (("added to the OFFSET", "some importers"),)),
)
