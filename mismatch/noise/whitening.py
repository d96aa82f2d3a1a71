"""A Kalman filter that whitens the residuals of a linear model, and its adjoint, the disturbance smoother.

State and measurement are errors about a trajectory:

    x[m + 1] = F[m] x[m] + u[m] + w[m],  w ~ (0, Q[m]);   z[m] = H[m] x[m] + v[m],  v ~ (0, diag R[m])

Many columns go through one filter at once: the data, and what each effect adds to u and z. The
innovations, divided by their standard deviations, are a regression with white noise of size one
(Harvey, Forecasting, Structural Time Series Models and the Kalman Filter, 1989, section 3.4.2). The
adjoint is the disturbance smoother of de Jong (Biometrika 1988; de Jong & Penzer, JASA 1998).
"""

import numpy as np

from omnimate.vehicle.compiled import Array, IntArray, compiled, compiled_without_lock


@compiled_without_lock
def gains_of(
    transition: Array, links: IntArray, process: Array, observe: Array, variance: Array, start: Array
) -> tuple[Array, Array]:
    """Return the filter's gains `(M + 1, R, n)` and its innovations' variances `(M + 1, R)`.

    Args:
        transition: F, (M, n, n).
        links: (K, 2) rows and columns off F's diagonal that are not zero; no column is the row of an earlier
            link, and F's diagonal is 1 in these rows.
        process: Q, (M, n, n).
        observe: H, (M + 1, R, n).
        variance: R, (M + 1, R); nan where nothing was measured, as the variance of the innovation is then.
        start: (n, n) covariance of the first state, whose mean is zero.
    """
    moments, rows, states = observe.shape
    gains, spread = np.zeros((moments, rows, states)), np.full((moments, rows), np.nan)
    covariance = start.copy()
    carried = np.zeros(states)
    for moment in range(moments):
        if moment > 0:
            carry(transition[moment - 1], links, covariance)
            carry(transition[moment - 1], links, covariance.T)
            covariance += process[moment - 1]
        for row in range(rows):
            if np.isnan(variance[moment, row]):
                continue
            carried[:] = 0.0
            add_rows(carried.reshape(1, -1), 1.0, observe[moment, row], covariance)
            size = variance[moment, row] + np.dot(observe[moment, row], carried)
            gains[moment, row] = carried / size
            for state in range(states):  # without the array that `np.outer` would allocate each time
                for other in range(states):
                    covariance[state, other] -= gains[moment, row, state] * carried[other]
            spread[moment, row] = size
    return gains, spread


@compiled
def add_rows(total: Array, factor: float, weights: Array, rows: Array) -> None:
    """Add weighted rows `(n, C)` by a factor to a total `(1, C)` in place; most weights `(n,)` are zero."""
    for number in range(len(weights)):
        weight = factor * weights[number]
        if weight != 0.0:
            for column in range(rows.shape[1]):
                total[0, column] += weight * rows[number, column]


@compiled
def add_outer(rows: Array, weights: Array, row: Array) -> None:
    """Add a row `(1, C)` to rows `(n, C)` in place, times a weight `(n,)` each."""
    for number in range(len(weights)):
        weight = weights[number]
        for column in range(rows.shape[1]):
            rows[number, column] += weight * row[0, column]


@compiled
def carry(transition: Array, links: IntArray, state: Array) -> None:
    """Carry a state `(n, C)` over one step in place: F state."""
    for number in range(len(links)):
        row, source = links[number, 0], links[number, 1]
        factor = transition[row, source]
        if factor != 0.0:
            for column in range(state.shape[1]):
                state[row, column] += factor * state[source, column]
    for row in range(state.shape[0]):
        factor = transition[row, row]
        if factor != 1.0:
            for column in range(state.shape[1]):
                state[row, column] *= factor


@compiled_without_lock
def whiten(
    transition: Array,
    links: IntArray,
    inputs: Array,
    observe: Array,
    measured: Array,
    gains: Array,
    spread: Array,
) -> Array:
    """Return whitened innovations `(V, C)` of C columns, in the V rows that were measured, moment by moment.

    F, links, H, gains and spread are as in `gains_of`. Inputs u (M, k, C) are of the first k states, and z is
    (M + 1, R, C).
    """
    moments, rows, states = observe.shape
    columns = measured.shape[2]
    white = np.zeros((np.sum(np.isfinite(spread)), columns))
    state, innovation, count = np.zeros((states, columns)), np.zeros((1, columns)), 0
    begun = False  # before the first input or measurement that is not zero, state and innovations are zero
    for moment in range(moments):
        begun = begun or bool(np.any(measured[moment] != 0.0))
        begun = begun or (moment > 0 and bool(np.any(inputs[moment - 1] != 0.0)))
        if begun and moment > 0:
            carry(transition[moment - 1], links, state)
            state[: inputs.shape[1]] += inputs[moment - 1]
        for row in range(rows):
            size = spread[moment, row]
            if np.isnan(size):
                continue
            if begun:
                innovation[0] = measured[moment, row]
                add_rows(innovation, -1.0, observe[moment, row], state)
                white[count] = innovation[0] / np.sqrt(size)
                add_outer(state, gains[moment, row], innovation)
            count += 1
    return white


@compiled_without_lock
def adjoint(
    transition: Array, links: IntArray, observe: Array, gains: Array, spread: Array, white: Array
) -> tuple[Array, Array, Array]:
    """Return scores and informations of an input in each step, and the likelihood's slope by each variance.

    An input u = theta b in step m alone is estimated by theta = b' score / (b' information b), with variance
    1 / (b' information b). The derivative of the log likelihood by a process covariance Q[m] is (score score'
    - information) / 2 (Koopman & Shephard, Biometrika 1992, equation 3.2), score score' being summed over all
    columns. F, links, H, gains and spread are as in `gains_of`, and `white` (V, C) as `whiten` returns it.

    Returns:
        Scores (M, n, C) and information (M, n, n) of an input in each step, and the derivative (M + 1, R) of
        the log likelihood by each variance of a reading.
    """
    moments, rows, states = observe.shape
    columns, count = white.shape[1], len(white)
    scores = np.zeros((moments - 1, states, columns))
    informations = np.zeros((moments - 1, states, states))
    by_variance = np.zeros((moments, rows))
    score = np.zeros((states, columns))
    information = np.zeros((states, states))
    product, error = np.zeros(states), np.zeros((1, columns))
    for moment in range(moments - 1, -1, -1):
        for row in range(rows - 1, -1, -1):
            size = spread[moment, row]
            if np.isnan(size):
                continue
            observed, gain = observe[moment, row], gains[moment, row]
            # with h = observed, L = I - gain h': score = h v / s + L' score,
            # information = h h' / s + L' information L
            count -= 1
            error[0] = white[count] / np.sqrt(size)
            add_rows(error, -1.0, gain, score)
            quadratic = _times_gain(information, gain, product)
            by_variance[moment, row] = 0.5 * (np.sum(error**2) - 1.0 / size - quadratic)
            for number in range(states):
                factor = observed[number]
                if factor != 0.0:
                    for column in range(columns):
                        score[number, column] += factor * error[0, column]
                    for other in range(states):
                        information[number, other] -= factor * product[other]
                        information[other, number] -= factor * product[other]
                        information[number, other] += factor * observed[other] * (1.0 / size + quadratic)
        if moment == 0:
            break
        scores[moment - 1] = score
        informations[moment - 1] = information
        step = transition[moment - 1]
        carry_back(step, links, score)
        carry_back(step, links, information)
        carry_back(step, links, information.T)
    return scores, informations, by_variance


@compiled
def _times_gain(information: Array, gain: Array, product: Array) -> float:
    """Write an information (n, n) times a gain (n,) into `product` (n,); return the gain's quadratic form."""
    quadratic = 0.0
    for number in range(len(gain)):
        product[number] = 0.0
        for other in range(len(gain)):  # faster than a call of BLAS for a vector as short as this
            product[number] += information[number, other] * gain[other]
        quadratic += gain[number] * product[number]
    return quadratic


@compiled
def carry_back(transition: Array, links: IntArray, state: Array) -> None:
    """Carry rows `(n, C)` over one step backwards in place: F' state."""
    for row in range(state.shape[0]):
        factor = transition[row, row]
        if factor != 1.0:
            for column in range(state.shape[1]):
                state[row, column] *= factor
    for number in range(len(links) - 1, -1, -1):
        row, source = links[number, 0], links[number, 1]
        factor = transition[row, source]
        if factor != 0.0:
            for column in range(state.shape[1]):
                state[source, column] += factor * state[row, column]
