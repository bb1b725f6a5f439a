"""What students write in notebook 11 and should not get away with: `exercise__what_is_wrong`."""

import numpy as np

from refimpl import nn
from refimpl.holden2017 import losses, networks, objective


def _transform(dY, X, W1, b1, W2, b2, W3, b3, *, mask=True, second=None, before=True):
    A1 = nn.conv1d(X, W1, b1)
    R1 = nn.relu(A1)
    A2 = nn.conv1d(R1, W2, b2)
    R2 = nn.relu(A2)
    relu = nn.relu_backward if mask else lambda d, a: d
    dR2, dW3, db3 = nn.conv1d_backward(dY, R2 if before else A2, W3, b3)
    dR1, dW2, db2 = nn.conv1d_backward(relu(dR2, A2), R1 if second is None else A1, W2, b2)
    dX, dW1, db1 = nn.conv1d_backward(relu(dR1, A1), X, W1, b1)
    return dX, dW1, db1, dW2, db2, dW3, db3


def my_transform_backward__relus_forgotten(dY, *arrays):
    return _transform(dY, *arrays, mask=False)


def my_transform_backward__output_before_the_relu_given_to_the_third_layer(dY, *arrays):
    return _transform(dY, *arrays, before=False)


def my_transform_backward__input_before_the_relu_given_to_the_second_layer(dY, *arrays):
    return _transform(dY, *arrays, second=True)


def my_transform_backward__masked_by_the_gradient(dY, X, W1, b1, W2, b2, W3, b3):
    A1 = nn.conv1d(X, W1, b1)
    R1 = nn.relu(A1)
    R2 = nn.relu(nn.conv1d(R1, W2, b2))
    dR2, dW3, db3 = nn.conv1d_backward(dY, R2, W3, b3)
    dR1, dW2, db2 = nn.conv1d_backward(nn.relu(dR2), R1, W2, b2)
    dX, dW1, db1 = nn.conv1d_backward(nn.relu(dR1), X, W1, b1)
    return dX, dW1, db1, dW2, db2, dW3, db3


def _losses(dE, O, target, L, mean, deviation, *, content=1, style=1, constraints=1, chain=True,
            first=1, shift=True):
    H = networks.encode(O, L)
    dH = (content * losses.content_loss_backward(dE, target.hidden, H)[first]
          + style * losses.style_loss_backward(dE, target.gram, H)[1])
    m = O * deviation[:, None] + (mean[:, None] if shift else 0)
    dm = objective.term_losses_backward(dE, m, target, objective.CONSTRAINTS, objective.Weights())
    scale = deviation[:, None] if chain else 1
    return networks.encode_backward_to_input(dH, O, L) + constraints * dm * scale


def my_motion_losses_backward__deviation_forgotten(dE, *rest):
    return _losses(dE, *rest, chain=False)


def my_motion_losses_backward__constraints_forgotten(dE, *rest):
    return _losses(dE, *rest, constraints=0)


def my_motion_losses_backward__gradient_of_the_inputs_units(dE, *rest):
    return _losses(dE, *rest, first=0)


def my_motion_losses_backward__style_forgotten(dE, *rest):
    return _losses(dE, *rest, style=0)


def my_motion_losses_backward__mean_forgotten(dE, *rest):
    return _losses(dE, *rest, shift=False)


def my_step__sum_instead_of_mean(I, arrays, forward, backward, through):
    return through(backward(np.ones(len(I)), forward(I, *arrays)), I, *arrays)[1:]


def my_step__first_clip_alone(I, arrays, forward, backward, through):
    dE = np.zeros(len(I))
    dE[0] = 1
    return through(backward(dE, forward(I, *arrays)), I, *arrays)[1:]


def my_step__losses_of_the_input(I, arrays, forward, backward, through):
    return through(backward(np.full(len(I), 1 / len(I)), I), I, *arrays)[1:]


def my_step__divided_by_the_frames(I, arrays, forward, backward, through):
    return through(backward(np.full(len(I), 1 / I.shape[2]), forward(I, *arrays)), I, *arrays)[1:]


def _steps(dY, X, W1, b1, W2, b2, W3, b3, *, masks=(True, True), by_gradient=False):
    A1 = nn.conv1d(X, W1, b1)
    A2 = nn.conv1d(nn.relu(A1), W2, b2)
    dR2 = nn.conv1d_backward(dY, nn.relu(A2), W3, b3)[0]
    dA2 = nn.relu(dR2) if by_gradient else nn.relu_backward(dR2, A2) if masks[1] else dR2.copy()
    dR1 = nn.conv1d_backward(dA2, nn.relu(A1), W2, b2)[0]
    dA1 = nn.relu_backward(dR1, A1) if masks[0] else dR1.copy()
    return {"dR2": dR2, "dA2": dA2, "dR1": dR1, "dA1": dA1}


def my_transform_steps__second_mask_missing(*arguments):
    return _steps(*arguments, masks=(True, False))


def my_transform_steps__first_mask_missing(*arguments):
    return _steps(*arguments, masks=(False, True))


def my_transform_steps__masked_by_the_gradient(*arguments):
    return _steps(*arguments, by_gradient=True)
