"""Small matrices for compiled code: results are written into existing arrays, because allocation is slow.

A transposed factor is passed as `left.T`: `product(out, left.T, right)`.
"""

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
def complement(out: Array, left: Array, right: Array) -> None:
    """Write the unit matrix less left times right: what a gain times an observation leaves of an error."""
    product(out, left, right)
    for row in range(out.shape[0]):
        for column in range(out.shape[1]):
            out[row, column] = -out[row, column]
        out[row, row] += 1.0


@compiled
def invert_into(out: Array, matrix: Array) -> None:
    """Write the inverse of a symmetric positive matrix, both `(3, 3)`, by cofactors, which is faster."""
    a, b, c = matrix[0, 0], matrix[0, 1], matrix[0, 2]
    d, e, f = matrix[1, 1], matrix[1, 2], matrix[2, 2]
    out[0, 0], out[0, 1], out[0, 2] = d * f - e * e, c * e - b * f, b * e - c * d
    out[1, 1], out[1, 2], out[2, 2] = a * f - c * c, b * c - a * e, a * d - b * b
    determinant = a * out[0, 0] + b * out[0, 1] + c * out[0, 2]
    for row in range(3):
        for column in range(row, 3):
            out[row, column] /= determinant
            out[column, row] = out[row, column]


@compiled
def invert(matrix: Array) -> None:
    """Invert a symmetric positive matrix `(n, n)` in place, by Gauss and Jordan without pivoting."""
    size = len(matrix)
    for pivot in range(size):
        factor = 1.0 / matrix[pivot, pivot]
        matrix[pivot, pivot] = 1.0
        for column in range(size):
            matrix[pivot, column] *= factor
        for row in range(size):
            if row == pivot:
                continue
            factor = matrix[row, pivot]
            matrix[row, pivot] = 0.0
            if factor != 0.0:
                for column in range(size):
                    matrix[row, column] -= factor * matrix[pivot, column]
    for row in range(size):
        for column in range(row):
            mean = 0.5 * (matrix[row, column] + matrix[column, row])
            matrix[row, column] = matrix[column, row] = mean


@compiled
def add_outer(out: Array, factor: float, vector: Array) -> None:
    """Add a factor times the product of a vector with itself, a symmetric matrix."""
    for row in range(len(vector)):
        scaled = factor * vector[row]
        for column in range(len(vector)):
            out[row, column] += scaled * vector[column]


@compiled
def add_scaled(out: Array, factor: float, vector: Array) -> None:
    """Add a factor times a vector; numba compiles such a loop ten times faster than an array expression."""
    for row in range(len(vector)):
        out[row] += factor * vector[row]


@compiled
def multiply(out: Array, matrix: Array, vector: Array) -> None:
    """Write the product of a symmetric matrix `(n, n)` and a vector `(n,)`, most of which may be zero."""
    out[:] = 0.0
    for row in range(len(vector)):
        factor = vector[row]
        if factor != 0.0:
            for column in range(len(vector)):
                out[column] += factor * matrix[row, column]
