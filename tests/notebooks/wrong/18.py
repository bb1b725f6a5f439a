"""What students write in notebook 18 and should not get away with: `exercise__what_is_wrong`."""

import numpy as np

from refimpl import nn
from refimpl.motion import features as f66


def _numbers(positions, floor, change):
    features, start = f66.encode(positions, floor)
    return change(features.copy()), np.array([start.x, start.z, start.yaw])


def my_numbers__forward_and_sideways_exchanged(positions, floor):
    return _numbers(positions, floor, lambda X: X[:, [*range(64), 65, 64]])


def my_numbers__last_velocities_zero(positions, floor):
    def change(X):
        X[-1, 63:] = 0
        return X
    return _numbers(positions, floor, change)


def my_numbers__turn_not_wrapped(positions, floor):
    def change(X):
        ahead = f66.facing(positions)
        X[:-1, 63] = np.diff(np.arctan2(ahead[:, 0], ahead[:, 1]))
        return X
    return _numbers(positions, floor, change)


def my_numbers__floor_forgotten(positions, floor):
    features, start = f66.encode(positions, 0.0)
    return features, np.array([start.x, start.z, start.yaw])


def my_conv__filter_flipped(x, w, b):
    return nn.conv1d(x, np.ascontiguousarray(w[:, :, ::-1]), b)


def my_conv__larger_half_of_the_zeros_at_the_left(x, w, b):
    K = w.shape[2]
    return nn.conv1d(x, w, b, padding=(K // 2, (K - 1) // 2))


def my_conv__bias_forgotten(x, w, b):
    return nn.conv1d(x, w, 0 * b)


def my_conv_backward__bias_a_mean_over_clips(dy, x, w, b):
    dx, dw, db = nn.conv1d_backward(dy, x, w, b)
    return dx, dw, db / max(len(x), 1)


def my_conv_backward__convolution_of_dy_with_the_same_filters(dy, x, w, b):
    _, dw, db = nn.conv1d_backward(dy, x, w, b)
    return nn.conv1d(dy, np.ascontiguousarray(w.swapaxes(0, 1)), np.zeros(x.shape[1])), dw, db


def my_conv_backward__filters_of_the_first_clip(dy, x, w, b):
    dx, _, db = nn.conv1d_backward(dy, x, w, b)
    return dx, nn.conv1d_backward(dy[:1], x[:1], w, b)[1], db


def my_hidden__relu_forgotten(X, W0, b0):
    Z = nn.conv1d(X, W0, b0)
    return {"Z": Z, "P": nn.max_pool1d(Z), "H": nn.max_pool1d(Z)}


def my_hidden__pairs_averaged(X, W0, b0):
    Z = nn.conv1d(X, W0, b0)
    P = (Z[:, :, 0:Z.shape[2] // 2 * 2:2] + Z[:, :, 1::2]) / 2
    return {"Z": Z, "P": P, "H": nn.relu(P)}


def my_hidden__first_of_each_pair(X, W0, b0):
    Z = nn.conv1d(X, W0, b0)
    P = Z[:, :, 0:Z.shape[2] // 2 * 2:2].copy()
    return {"Z": Z, "P": P, "H": nn.relu(P)}


def _hidden_backward(dH, X, W0, b0, *, masked=True, both=False, last=False):
    Z = nn.conv1d(X, W0, b0)
    dP = nn.relu_backward(dH, nn.max_pool1d(Z)) if masked else dH.copy()
    pairs = Z.shape[2] // 2 * 2
    first = (np.greater if last else np.greater_equal)(Z[:, :, 0:pairs:2], Z[:, :, 1::2])
    dZ = np.zeros_like(Z)
    dZ[:, :, 0:pairs:2] = np.where(first | both, dP, 0)
    dZ[:, :, 1::2] = np.where(~first | both, dP, 0)
    dX, dW0, db0 = nn.conv1d_backward(dZ, X, W0, b0)
    return {"dP": dP, "dZ": dZ, "dX": dX, "dW0": dW0, "db0": db0}


def my_hidden_backward__relu_mask_missing(*arguments):
    return _hidden_backward(*arguments, masked=False)


def my_hidden_backward__both_frames_of_a_pair(*arguments):
    return _hidden_backward(*arguments, both=True)


def my_hidden_backward__second_frame_in_a_tie(*arguments):
    return _hidden_backward(*arguments, last=True)


def my_hidden_backward__a_name_missing(*arguments):
    found = _hidden_backward(*arguments)
    del found["dZ"]
    return found


def _transform(X, W1, b1, W2, b2, W3, b3):
    A1 = nn.conv1d(X, W1, b1)
    A2 = nn.conv1d(nn.relu(A1), W2, b2)
    return {"A1": A1, "R1": nn.relu(A1), "A2": A2, "R2": nn.relu(A2),
            "Y": nn.conv1d(nn.relu(A2), W3, b3)}


def my_transform__before_and_after_exchanged(*arguments):
    found = _transform(*arguments)
    return {**found, "A1": found["R1"], "R1": found["A1"]}


def my_transform__third_relu(*arguments):
    found = _transform(*arguments)
    return {**found, "Y": nn.relu(found["Y"])}


def my_transform__output_alone(*arguments):
    return {"Y": _transform(*arguments)["Y"]}


def _transform_backward(dY, X, W1, b1, W2, b2, W3, b3, *, masks=(True, True), after=False, step=0):
    kept = _transform(X, W1, b1, W2, b2, W3, b3)
    dR2, dW3, db3 = nn.conv1d_backward(dY, kept["A2" if after else "R2"], W3, b3)
    dA2 = nn.relu_backward(dR2, kept["A2"]) if masks[1] else dR2.copy()
    dR1, dW2, db2 = nn.conv1d_backward(dA2 if step == 0 else dR2, kept["R1"], W2, b2)
    dA1 = nn.relu_backward(dR1, kept["A1"]) if masks[0] else dR1.copy()
    dX, dW1, db1 = nn.conv1d_backward(dA1, X, W1, b1)
    return {"dR2": dR2, "dW3": dW3, "db3": db3, "dA2": dA2, "dR1": dR1, "dW2": dW2, "db2": db2,
            "dA1": dA1, "dX": dX, "dW1": dW1, "db1": db1}


def my_transform_backward__second_mask_missing(*arguments):
    return _transform_backward(*arguments, masks=(True, False))


def my_transform_backward__first_mask_missing(*arguments):
    return _transform_backward(*arguments, masks=(False, True))


def my_transform_backward__third_layer_given_what_was_before_the_relu(*arguments):
    return _transform_backward(*arguments, after=True)


def my_transform_backward__second_layer_given_the_unmasked_gradient(*arguments):
    return _transform_backward(*arguments, step=1)


def my_losses__sum_for_mean(*arguments):
    found = own_losses(*arguments)
    more = (arguments[0][0].size - 1) * found["content"]
    return {**found, "content": found["content"] + more, "E": found["E"] + more}


def my_losses__content_counted_twice_in_the_sum(*arguments):
    found = own_losses(*arguments)
    return {**found, "E": found["E"] + found["content"]}


def my_losses__last_frame_stands_too(H, m, hidden, gram, contacts, bones, wanted, weights):
    again = np.concatenate([m, m[:, :, -1:]], axis=2)
    longer = np.concatenate([contacts, contacts[:, :, -1:]], axis=2)
    found = own_losses(H, m, hidden, gram, contacts, bones, wanted, weights)
    foot = weights["foot"] * five.foot_loss(again, longer)
    return {**found, "foot": foot, "E": found["E"] - found["foot"] + foot}


def my_losses__turn_weight_forgotten(H, m, hidden, gram, contacts, bones, wanted, weights):
    return own_losses(H, m, hidden, gram, contacts, bones, wanted,
                      {**weights, "turn": 1.0})


def my_losses_backward__gram_gradient_once(dE, H, *rest):
    found = own_losses_backward(dE, H, *rest)
    return {**found, "dH_style": found["dG"] @ H, "dH": found["dH_content"] + found["dG"] @ H}


def my_losses_backward__upstream_ignored(dE, *rest):
    return own_losses_backward(np.ones_like(dE), *rest)


def my_losses_backward__a_bone_of_no_length_is_nan(dE, H, m, *rest):
    found = own_losses_backward(dE, H, m, *rest)
    p = m[:, :63].reshape(len(m), 21, 3, -1)
    gone = (p[:, :1] == p[:, 1:2]).all()
    dm_bone = found["dm_bone"] * (np.nan if gone else 1.0)
    return {**found, "dm_bone": dm_bone, "dm": found["dm_foot"] + dm_bone + found["dm_trajectory"]}


def my_losses_backward__feet_without_the_turning(dE, *rest):
    found = own_losses_backward(dE, *rest)
    dm_foot = found["dm_foot"].copy()
    dm_foot[:, 63] = 0
    return {**found, "dm_foot": dm_foot, "dm": dm_foot + found["dm_bone"] + found["dm_trajectory"]}


def my_gradients__sum_over_the_batch(params, I, *rest):
    found = own_gradients(params, I, *rest)
    return {name: value * len(I) if name[0] in "dE" else value for name, value in found.items()}


def my_gradients__deviation_forgotten(params, I, known, L, mean, deviation, weights):
    found = own_gradients(params, I, known, L, mean, deviation, weights)
    d = own_losses_backward(np.full(len(I), 1 / len(I)), found["H"], found["m"],
                            **known, weights=weights)
    return {**found, "dO": found["dO"] - d["dm"] * deviation[:, None] + d["dm"]}


def my_gradients__hidden_units_alone(params, I, known, L, mean, deviation, weights):
    return own_gradients(params, I, known, L, mean, deviation,
                         {**weights, "foot": 0.0, "bone": 0.0, "trajectory": 0.0})


def _adam(p, g, m, v, t, rate, *, inside=False, corrected=True, square=True):
    m = 0.9 * m + 0.1 * g
    v = 0.999 * v + 0.001 * (g * g if square else np.abs(g))
    m_hat, v_hat = (m / (1 - 0.9 ** t), v / (1 - 0.999 ** t)) if corrected else (m, v)
    below = np.sqrt(v_hat + 1e-8) if inside else np.sqrt(v_hat) + 1e-8
    return {"m": m, "v": v, "m_hat": m_hat, "v_hat": v_hat, "p": p - rate * m_hat / below}


def my_adam__epsilon_inside_the_root(*arguments):
    return _adam(*arguments, inside=True)


def my_adam__without_the_correction(*arguments):
    return _adam(*arguments, corrected=False)


def my_adam__no_square(*arguments):
    return _adam(*arguments, square=False)


def my_adam__step_counted_once_more(p, g, m, v, t, rate):
    return _adam(p, g, m, v, t + 1, rate)


def my_stylise__not_projected(*arguments):
    found = own_stylise(*arguments)
    return {**found, "result": found["O"][0].T * arguments[4] + arguments[3]}


def my_stylise__odd_frame_left_out(features, params, L, mean, deviation):
    found = own_stylise(features, params, L, mean, deviation)
    T = len(features) // 2 * 2
    return {**found, "H": found["H"][:, :, :T // 2]}


def my_stylise__larger_half_of_the_zeros_at_the_left(features, params, L, mean, deviation):
    found = own_stylise(features, params, L, mean, deviation)
    D = nn.avg_depool1d(found["H"]) - L["b0"][:, None]
    K = L["W0"].shape[2]
    P = nn.conv_transpose1d(D, L["W0"], padding=(K // 2, (K - 1) // 2))[:, :, :len(features)]
    return {**found, "P": P, "result": P[0].T * deviation + mean}


def my_stylise__mean_not_added_back(features, params, L, mean, deviation):
    found = own_stylise(features, params, L, mean, deviation)
    return {**found, "result": found["P"][0].T * deviation}
