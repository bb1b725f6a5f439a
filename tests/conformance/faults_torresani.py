"""Faults of the system of 2006: (what is wrong, function, what stands in its place)."""

import numpy as np

from refimpl.conformance import functions_torresani as ours
from refimpl.conformance import rivals_torresani as rivals
from refimpl.motion import rotation
from refimpl.torresani2006 import align, observe


def first_frames_forgotten(X, Y):
    return ours.dtw_cost(X, Y) - np.sum((X[0] - Y[0]) ** 2)


def not_a_number_accepted(X, Y):
    return ours.dtw_cost(np.nan_to_num(X), np.nan_to_num(Y))


def root_averaged(X, Y, root_X, root_Y, path, *, alpha, smooth=6.0, up="y"):
    """The root blended in world axes, not step by step as the body sees them."""
    p, q = align.synchronised(path, alpha, smooth)
    angles, root = ours.space_time_interpolation(X, Y, root_X, root_Y, path, alpha=alpha,
                                                 smooth=smooth, up=up)
    return angles, (1 - alpha) * align.read_at(root_X, p) + alpha * align.read_at(root_Y, q)


def path_not_smoothed(X, Y, root_X, root_Y, path, *, alpha, smooth=6.0, up="y"):
    return ours.space_time_interpolation(X, Y, root_X, root_Y, path, alpha=alpha, smooth=0.0, up=up)


def wrong_up(X, Y, root_X, root_Y, path, *, alpha, smooth=6.0, up="y"):
    return ours.space_time_interpolation(X, Y, root_X, root_Y, path, alpha=alpha, smooth=smooth)


def changed(function, number, change):
    def wrong(*arguments, **attributes):
        results = list(getattr(ours, function)(*arguments, **attributes))
        results[number] = change(results[number])
        return tuple(results)
    return wrong


def not_centred(frames, *, lengths, components, length):
    mean, basis, coefficients = ours.principal_components(frames, lengths=lengths,
                                                          components=components, length=length)
    return mean, basis, coefficients + basis @ mean


def no_tube(K, y, K_new, *, C, epsilon):
    return ours.support_vector_regression(K, y, K_new, C=C, epsilon=0.0)


def no_box(K, y, K_new, *, C, epsilon):
    return ours.support_vector_regression(K, y, K_new, C=1e3 * C, epsilon=epsilon)


def not_standardised(Z, Y, new, *, kind, **options):
    if kind == "linear ridge":
        Z, new = Z * 3.0, new * 3.0
        options["ridge"] *= 9.0
        return ours.predicted_style(Z[:, :5], Y, new[:, :5], kind=kind, **options)
    return ours.predicted_style(Z, Y, new, kind=kind, **options)


def jumping(R, reference):
    """The shortest rotation vector of each frame: a jump beyond half a turn."""
    return rotation.log_map(reference.swapaxes(-1, -2) @ R).reshape(len(R), -1)


def samples_alone(coefficients, *, samples=13, tolerance=1e-6):
    grid = np.linspace(-0.25, 1.25, samples)
    errors = np.array([ours.polynomials(coefficients)(np.full(len(coefficients), a)) for a in grid])
    return grid[errors.argmin(axis=0)]


def search_alone(coefficients, *, samples=13, tolerance=1e-6):
    ones = np.ones(len(coefficients))
    return ours.golden_section(coefficients, -0.25 * ones, 1.25 * ones, tolerance=tolerance)


FAULTS = (
    ("2006: the first frames' distance forgotten", "dtw_cost", first_frames_forgotten),
    ("2006: NaN accepted in a sequence", "dtw_cost", not_a_number_accepted),
    ("2006: of equal ways the step in the first sequence", "dtw_path", rivals.along_p_first),
    ("2006: a path of the exchanged sequences", "dtw_path", lambda X,
     Y: ours.dtw_path(Y, X)[:, ::-1]),
    ("2006: a distance of the threshold matches", "content_clusters", lambda ssd, *,
     threshold: align.clusters(ssd, np.nextafter(threshold, 9))),
    ("2006: alpha exchanged", "space_time_interpolation", rivals.exchanged),
    ("2006: the root averaged in world axes", "space_time_interpolation", root_averaged),
    ("2006: the path not smoothed", "space_time_interpolation", path_not_smoothed),
    ("2006: the floor's turn of the other up axis", "space_time_interpolation", wrong_up),
    ("2006: principal directions of the other sign", "principal_components",
     changed("principal_components", 1, np.negative)),
    ("2006: coefficients not centred", "principal_components", not_centred),
    ("2006: the kernel's distance not squared", "gaussian_kernel", rivals.not_squared),
    ("2006: gamma for the kernel's width", "gaussian_kernel", rivals.width_for_gamma),
    ("2006: no ridge", "linear_ridge", lambda Z, Y, *, ridge: np.linalg.lstsq(Z, Y, rcond=None)[0]),
    ("2006: the ridge times the examples", "kernel_ridge",
     rivals.ridge_of_the_mean(ours.kernel_ridge)),
    ("2006: no tube", "support_vector_regression", no_tube),
    ("2006: a box a thousand times as large", "support_vector_regression", no_box),
    ("2006: no offset", "support_vector_regression", rivals.without_offset),
    ("2006: linear interpolation as section 8 prints it", "predicted_style",
     rivals.printed_interpolation),
    ("2006: inputs left out of a linear model", "predicted_style", not_standardised),
    ("2006: cuts one frame late", "one_stage_segmentation",
     changed("one_stage_segmentation", 2, lambda ends: np.append(ends[:-1] + 1, ends[-1]))),
    ("2006: the last piece's cost in the first", "one_stage_segmentation",
     changed("one_stage_segmentation", 3, lambda costs: costs[::-1])),
    ("2006: alpha from the samples alone", "best_alpha", samples_alone),
    ("2006: alpha from the search alone", "best_alpha", search_alone),
    ("2006: the search's left end", "golden_section", lambda c, low, high, *,
     tolerance=1e-6: ours.golden_section(c, low, high, tolerance=tolerance) - 1e-3),
    ("2006: rotations of the other hand", "exponential_map",
     lambda v: np.ascontiguousarray(rotation.exp_map(v).swapaxes(-1, -2))),
    ("2006: rotation vectors in degrees", "rotation_vector",
     lambda R: np.degrees(rotation.log_map(R))),
    ("2006: rotation vectors that jump", "continuous_exponential_maps", jumping),
    ("2006: jerk by the wrong power of the frame rate", "effort_measures", lambda p, *,
     fps: observe.measures(p, fps) * [1, 1, 1, 1 / fps]),
    ("2006: mean energy for the largest", "effort_measures", lambda p, *,
     fps: observe.measures(p, fps) * [0.9, 1, 1, 1]),
    ("2006: central differences", "effort_measures", rivals.central_differences),
)
