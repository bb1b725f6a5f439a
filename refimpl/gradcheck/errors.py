"""What a failed check says."""


class GradientError(AssertionError):
    """A gradient, or the function that claims it, is wrong; the message says where, what was found
    and what was needed.
    """


def describe(found, needed, tolerance):
    """ "found 1.25, needed 1.5 (difference 0.25, allowed 1e-12)" """
    return f"found {float(found):.17g}, needed {float(needed):.17g} (difference {abs(float(found) - float(needed)):.3g}, allowed {tolerance:.3g})"
