"""Small matrices for compiled code: results are written into existing arrays, because new ones cost more."""

from omnimate.vehicle.compiled import Array, compiled


@compiled
def product(out: Array, left: Array, right: Array) -> None:
    """Write left times right."""
    for row in range(out.shape[0]):
        for column in range(out.shape[1]):
            total = 0.0
            for inner in range(left.shape[1]):
                total += left[row, inner] * right[inner, column]
            out[row, column] = total


@compiled
def product_of_transposed(out: Array, left: Array, right: Array) -> None:
    """Write the transposed of left times right."""
    for row in range(out.shape[0]):
        for column in range(out.shape[1]):
            total = 0.0
            for inner in range(left.shape[0]):
                total += left[inner, row] * right[inner, column]
            out[row, column] = total


@compiled
def sandwich(out: Array, outer: Array, inside: Array) -> None:
    """Add outer times a symmetric matrix times the transposed of outer, all `(3, 3)`."""
    for row in range(3):
        for column in range(row, 3):
            total = 0.0
            for left in range(3):
                for right in range(3):
                    total += outer[row, left] * inside[left, right] * outer[column, right]
            out[row, column] += total
            if column > row:
                out[column, row] += total


@compiled
def sandwich_of_transposed(out: Array, outer: Array, inside: Array) -> None:
    """Add the transposed of outer times a symmetric matrix times outer, all `(3, 3)`."""
    for row in range(3):
        for column in range(row, 3):
            total = 0.0
            for left in range(3):
                for right in range(3):
                    total += outer[left, row] * inside[left, right] * outer[right, column]
            out[row, column] += total
            if column > row:
                out[column, row] += total


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
