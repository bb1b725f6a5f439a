"""Answers to 18_your_own_system.ipynb."""

import numpy as np

from refimpl.motion import features as f66
from refimpl.motion.joints import BONES, FEET


def my_numbers(positions, floor):
    x, z = f66.root_path(positions).T
    ahead = f66.facing(positions)
    yaw = np.arctan2(ahead[:, 0], ahead[:, 1])

    def turned(v, angle):                                # v : (..., 3), about y
        c, s = np.cos(angle), np.sin(angle)
        x, y, z = np.moveaxis(v, -1, 0)
        return np.stack([c * x + s * z, y, c * z - s * x], axis=-1)

    root = np.stack([x, np.full(len(x), floor), z], axis=1)
    local = turned(positions - root[:, None], -yaw[:, None])
    step = turned(np.diff(root, axis=0), -yaw[1:])       # seen from the frame that it reaches
    features = np.zeros((len(positions), 66))
    features[:, :63] = local.reshape(len(positions), 63)
    features[:-1, 63] = (np.diff(yaw) + np.pi) % (2 * np.pi) - np.pi
    features[:-1, 64], features[:-1, 65] = step[:, 2], step[:, 0]
    if len(features) > 1:
        features[-1, 63:] = features[-2, 63:]
    return features, np.array([x[0], z[0], yaw[0]])


def my_conv(x, w, b):
    T, K = x.shape[2], w.shape[2]
    padded = np.pad(x, ((0, 0), (0, 0), ((K - 1) // 2, K // 2)))
    return sum(w[:, :, k] @ padded[:, :, k:k + T] for k in range(K)) + b[:, None]


def my_conv_backward(dy, x, w, b):
    T, K = x.shape[2], w.shape[2]
    left = (K - 1) // 2
    padded = np.pad(x, ((0, 0), (0, 0), (left, K // 2)))
    dw, d_padded = np.zeros_like(w), np.zeros_like(padded)
    for k in range(K):
        dw[:, :, k] = (dy @ padded[:, :, k:k + T].swapaxes(1, 2)).sum(axis=0)
        d_padded[:, :, k:k + T] += w[:, :, k].T @ dy
    return d_padded[:, :, left:left + T].copy(), dw, dy.sum(axis=(0, 2))


def my_hidden(X, W0, b0):
    Z = conv(X, W0, b0)
    P = np.maximum(Z[:, :, 0:Z.shape[2] // 2 * 2:2], Z[:, :, 1::2])
    return {"Z": Z, "P": P, "H": np.maximum(P, 0)}


def my_hidden_backward(dH, X, W0, b0):
    kept = hidden(X, W0, b0)
    Z, P = kept["Z"], kept["P"]
    dP = np.where(P > 0, dH, 0)
    first = Z[:, :, 0:2 * P.shape[2]:2] >= Z[:, :, 1::2]     # in a tie, the first
    dZ = np.zeros_like(Z)
    dZ[:, :, 0:2 * P.shape[2]:2] = np.where(first, dP, 0)
    dZ[:, :, 1::2] = np.where(first, 0, dP)
    dX, dW0, db0 = conv_backward(dZ, X, W0, b0)
    return {"dP": dP, "dZ": dZ, "dX": dX, "dW0": dW0, "db0": db0}


def my_transform(X, W1, b1, W2, b2, W3, b3):
    A1 = conv(X, W1, b1)
    R1 = np.maximum(A1, 0)
    A2 = conv(R1, W2, b2)
    R2 = np.maximum(A2, 0)
    return {"A1": A1, "R1": R1, "A2": A2, "R2": R2, "Y": conv(R2, W3, b3)}


def my_transform_backward(dY, X, W1, b1, W2, b2, W3, b3):
    kept = transform(X, W1, b1, W2, b2, W3, b3)
    dR2, dW3, db3 = conv_backward(dY, kept["R2"], W3, b3)
    dA2 = np.where(kept["A2"] > 0, dR2, 0)
    dR1, dW2, db2 = conv_backward(dA2, kept["R1"], W2, b2)
    dA1 = np.where(kept["A1"] > 0, dR1, 0)
    dX, dW1, db1 = conv_backward(dA1, X, W1, b1)
    return {"dR2": dR2, "dW3": dW3, "db3": db3, "dA2": dA2, "dR1": dR1, "dW2": dW2, "db2": db2,
            "dA1": dA1, "dX": dX, "dW1": dW1, "db1": db1}


def my_losses(H, m, hidden, gram, contacts, bones, wanted, weights):
    N, _, T = m.shape
    p = m[:, :63].reshape(N, 21, 3, T)
    foot, turn = p[:, list(FEET)], m[:, None, 63, :-1]
    slide = np.diff(foot, axis=3)
    slide[:, :, 0] += m[:, None, 65, :-1] + turn * foot[:, :, 2, :-1]
    slide[:, :, 2] += m[:, None, 64, :-1] - turn * foot[:, :, 0, :-1]
    slide *= contacts[:, :, None, :-1]
    one, other = np.array(BONES).T
    stretch = np.linalg.norm(p[:, one] - p[:, other], axis=2) - bones[:, None]
    off = m[:, 63:] - wanted
    found = {"content": ((H - hidden) ** 2).mean(axis=(1, 2)),
             "style": ((H @ H.swapaxes(1, 2) - gram) ** 2).mean(axis=(1, 2)),
             "foot": (slide ** 2).sum(axis=(1, 2, 3)), "bone": (stretch ** 2).sum(axis=(1, 2)),
             "trajectory": weights["turn"] * (off[:, 0] ** 2).sum(axis=1)
             + (off[:, 1:] ** 2).sum(axis=(1, 2))}
    found = {name: weights[name] * value for name, value in found.items()}
    return {**found, "E": sum(found.values())}


def my_losses_backward(dE, H, m, hidden, gram, contacts, bones, wanted, weights):
    N, _, T = m.shape
    dE = dE[:, None, None]
    dH_content = weights["content"] * dE * 2 / hidden[0].size * (H - hidden)
    dG = weights["style"] * dE * 2 / gram[0].size * (H @ H.swapaxes(1, 2) - gram)
    dH_style = (dG + dG.swapaxes(1, 2)) @ H

    p = m[:, :63].reshape(N, 21, 3, T)
    foot, turn = p[:, list(FEET)], m[:, None, 63, :-1]
    slide = np.diff(foot, axis=3)
    slide[:, :, 0] += m[:, None, 65, :-1] + turn * foot[:, :, 2, :-1]
    slide[:, :, 2] += m[:, None, 64, :-1] - turn * foot[:, :, 0, :-1]
    dslide = weights["foot"] * dE[..., None] * 2 * contacts[:, :, None, :-1] ** 2 * slide
    dfoot = np.zeros_like(foot)
    dfoot[..., 1:] += dslide
    dfoot[..., :-1] -= dslide
    dfoot[:, :, 2, :-1] += turn * dslide[:, :, 0]
    dfoot[:, :, 0, :-1] -= turn * dslide[:, :, 2]
    dm_foot = np.zeros_like(m)
    dm_foot[:, :63].reshape(N, 21, 3, T)[:, list(FEET)] = dfoot
    dm_foot[:, 63, :-1] = (foot[:, :, 2, :-1] * dslide[:, :, 0]
                           - foot[:, :, 0, :-1] * dslide[:, :, 2]).sum(axis=1)
    dm_foot[:, 64, :-1] = dslide[:, :, 2].sum(axis=1)
    dm_foot[:, 65, :-1] = dslide[:, :, 0].sum(axis=1)

    one, other = np.array(BONES).T
    between = p[:, one] - p[:, other]
    length = np.linalg.norm(between, axis=2)
    dstretch = weights["bone"] * dE * 2 * (length - bones[:, None])
    # a bone of length 0 has no direction, and gets no gradient
    dbetween = dstretch[:, :, None] * between / np.where(length > 0, length, 1)[:, :, None]
    dm_bone = np.zeros_like(m)
    dp = dm_bone[:, :63].reshape(N, 21, 3, T)
    for i, (a, b) in enumerate(BONES):
        dp[:, a] += dbetween[:, i]
        dp[:, b] -= dbetween[:, i]

    dm_trajectory = np.zeros_like(m)
    dm_trajectory[:, 63:] = weights["trajectory"] * dE * 2 * (m[:, 63:] - wanted)
    dm_trajectory[:, 63] *= weights["turn"]
    return {"dH_content": dH_content, "dG": dG, "dH_style": dH_style, "dH": dH_content + dH_style,
            "dslide": dslide, "dm_foot": dm_foot, "dstretch": dstretch, "dm_bone": dm_bone,
            "dm_trajectory": dm_trajectory, "dm": dm_foot + dm_bone + dm_trajectory}


def my_gradients(params, I, known, L, mean, deviation, weights):
    O = transform(I, **params)["Y"]
    m = O * deviation[:, None] + mean[:, None]
    H = hidden(O, **L)["H"]
    E = losses(H, m, **known, weights=weights)["E"].mean()
    dE = np.full(len(I), 1 / len(I), I.dtype)
    d = losses_backward(dE, H, m, **known, weights=weights)
    dO = hidden_backward(d["dH"], O, **L)["dX"] + d["dm"] * deviation[:, None]
    d_T = transform_backward(dO, I, **params)
    return {"O": O, "m": m, "H": H, "E": E, "dO": dO,
            **{f"d{name}": d_T[f"d{name}"] for name in params}}


def my_adam(p, g, m, v, t, rate):
    m = 0.9 * m + 0.1 * g
    v = 0.999 * v + 0.001 * g * g
    m_hat, v_hat = m / (1 - 0.9 ** t), v / (1 - 0.999 ** t)
    return {"m": m, "v": v, "m_hat": m_hat, "v_hat": v_hat,
            "p": p - rate * m_hat / (np.sqrt(v_hat) + 1e-8)}


def my_stylise(features, params, L, mean, deviation):
    X = ((features - mean) / deviation).T[None]
    O = transform(X, **params)["Y"]
    H = hidden(np.concatenate([O, O[:, :, -1:]], axis=2) if O.shape[2] % 2 else O, **L)["H"]
    D = np.repeat(H, 2, axis=2) / 2 - L["b0"][:, None]
    W0 = L["W0"]
    K, T = W0.shape[2], D.shape[2]
    padded = np.zeros((1, W0.shape[1], T + K - 1), D.dtype)
    for k in range(K):                                   # the adjoint of my_conv, as in its dx
        padded[:, :, k:k + T] += W0[:, :, k].T @ D
    P = padded[:, :, (K - 1) // 2:][:, :, :O.shape[2]]
    return {"X": X, "O": O, "H": H, "P": P, "result": P[0].T * deviation + mean}
