"""Small matrices for compiled code: results go into arrays that exist, because making one costs more.

Errors of a pose are in its own body frame: true = pose (+) error.
"""

import math

from vehicle.compiled import Array, compiled


@compiled
def product(out: Array, one: Array, other: Array) -> None:
    """Write one times other."""
    for row in range(out.shape[0]):
        for column in range(out.shape[1]):
            total = 0.0
            for inner in range(one.shape[1]):
                total += one[row, inner] * other[inner, column]
            out[row, column] = total


@compiled
def product_of_transposed(out: Array, one: Array, other: Array) -> None:
    """Write the transposed of one times other."""
    for row in range(out.shape[0]):
        for column in range(out.shape[1]):
            total = 0.0
            for inner in range(one.shape[0]):
                total += one[inner, row] * other[inner, column]
            out[row, column] = total


@compiled
def sandwich(out: Array, one: Array, inside: Array) -> None:
    """Add one times a symmetric matrix times the transposed of one, all `(3, 3)`."""
    for row in range(3):
        for column in range(row, 3):
            total = 0.0
            for left in range(3):
                for right in range(3):
                    total += one[row, left] * inside[left, right] * one[column, right]
            out[row, column] += total
            if column > row:
                out[column, row] += total


@compiled
def sandwich_of_transposed(out: Array, one: Array, inside: Array) -> None:
    """Add the transposed of one times a symmetric matrix times one, all `(3, 3)`."""
    for row in range(3):
        for column in range(row, 3):
            total = 0.0
            for left in range(3):
                for right in range(3):
                    total += one[left, row] * inside[left, right] * one[right, column]
            out[row, column] += total
            if column > row:
                out[column, row] += total


@compiled
def transport(out: Array, increment: Array) -> None:
    """Write how an error before an increment `(3,)` becomes one after it, `(3, 3)`: Ad of its inverse."""
    cos, sin = math.cos(increment[2]), math.sin(increment[2])
    out[0, 0], out[0, 1] = cos, sin
    out[1, 0], out[1, 1] = -sin, cos
    out[0, 2] = sin * increment[0] - cos * increment[1]
    out[1, 2] = cos * increment[0] + sin * increment[1]
    out[2, 0], out[2, 1], out[2, 2] = 0.0, 0.0, 1.0


@compiled
def rotation(out: Array, angle: float) -> None:
    """Write the matrix `(3, 3)` that turns x, y, theta of the world into a frame at an angle [rad]."""
    cos, sin = math.cos(angle), math.sin(angle)
    out[:] = 0.0
    out[0, 0], out[0, 1] = cos, sin
    out[1, 0], out[1, 1] = -sin, cos
    out[2, 2] = 1.0


@compiled
def join(out: Array, first: Array, second: Array) -> None:
    """Write first (+) second of two poses `(3,)`; `out` may be one of them."""
    cos, sin = math.cos(first[2]), math.sin(first[2])
    x = first[0] + cos * second[0] - sin * second[1]
    y = first[1] + sin * second[0] + cos * second[1]
    out[2] = first[2] + second[2]
    out[0], out[1] = x, y


@compiled
def inverse(out: Array, matrix: Array) -> None:
    """Write the inverse of a symmetric positive matrix `(3, 3)`."""
    a, b, c = matrix[0, 0], matrix[0, 1], matrix[0, 2]
    d, e, f = matrix[1, 1], matrix[1, 2], matrix[2, 2]
    out[0, 0], out[1, 1], out[2, 2] = d * f - e * e, a * f - c * c, a * d - b * b
    out[0, 1] = c * e - b * f
    out[0, 2] = b * e - c * d
    out[1, 2] = b * c - a * e
    determinant = a * out[0, 0] + b * out[0, 1] + c * out[0, 2]
    for row in range(3):
        for column in range(row, 3):
            out[row, column] /= determinant
            out[column, row] = out[row, column]
