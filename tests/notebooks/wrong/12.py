"""What students write in notebook 12 and should not get away with: `exercise__what_is_wrong`."""

import numpy as np

from refimpl.motion import foot_ik


def _locks(points, labels, more=1, point=lambda p: p.mean(axis=0)):
    out = np.full_like(points, np.nan)
    for begin, end in foot_ik.stretches(labels):
        out[begin:end + more] = point(points[begin:end + more])
    return out


def my_locks__one_frame_short(points, labels):
    return _locks(points, labels, more=0)


def my_locks__where_it_came_down(points, labels):
    return _locks(points, labels, point=lambda p: p[0])


def my_locks__mean_of_all_stances(points, labels):
    out = np.full_like(points, np.nan)
    if labels.any():
        out[labels] = points[labels].mean(axis=0)
    return out


def my_locks__mean_of_the_coordinates(points, labels):
    return _locks(points, labels, point=lambda p: p.mean())


def my_fade__a_straight_line(x):
    return 1 - np.clip(x, 0, 1)


def my_fade__not_held_at_the_ends(x):
    return 1 - 3 * x**2 + 2 * x**3


def my_fade__the_other_way(x):
    x = np.clip(x, 0, 1)
    return 3 * x**2 - 2 * x**3


def my_fade__a_cosine(x):
    return 0.5 + 0.5 * np.cos(np.pi * np.clip(x, 0, 1))


def _knee(hip, ankle, thigh, shin, bend, *, c=None, remove=True, unit=True, side=1):
    along = ankle - hip
    d = np.linalg.norm(along, axis=1)
    u = along / d[:, None]
    c = (thigh**2 - shin**2 + d**2) / (2 * d) if c is None else c(thigh, shin, d)
    n = bend - remove * np.sum(bend * u, axis=1, keepdims=True) * u
    n = n / np.linalg.norm(n, axis=1, keepdims=True) if unit else n
    return hip + c[:, None] * u + side * np.sqrt(np.maximum(thigh**2 - c**2, 0))[:, None] * n


def my_two_bone__thigh_and_shin_exchanged(hip, ankle, thigh, shin, bend):
    return _knee(hip, ankle, thigh, shin, bend, c=lambda thigh, shin,
                 d: (shin**2 - thigh**2 + d**2) / (2 * d))


def my_two_bone__bend_not_made_normal(hip, ankle, thigh, shin, bend):
    return _knee(hip, ankle, thigh, shin, bend, remove=False)


def my_two_bone__bend_not_of_length_one(hip, ankle, thigh, shin, bend):
    return _knee(hip, ankle, thigh, shin, bend, unit=False)


def my_two_bone__knee_behind(hip, ankle, thigh, shin, bend):
    return _knee(hip, ankle, thigh, shin, bend, side=-1)


def my_two_bone__half_way(hip, ankle, thigh, shin, bend):
    return _knee(hip, ankle, thigh, shin, bend, c=lambda thigh, shin, d: d / 2)
