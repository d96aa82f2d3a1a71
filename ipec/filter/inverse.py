"""Inverses of small symmetric positive matrices, in place; compiled."""

from omnimate.vehicle.compiled import Array, compiled


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
def multiply(out: Array, matrix: Array, vector: Array) -> None:
    """Write the product of a symmetric matrix `(n, n)` and a vector `(n,)`."""
    out[:] = 0.0
    for row in range(len(vector)):
        factor = vector[row]
        if factor != 0.0:
            for column in range(len(vector)):
                out[column] += factor * matrix[row, column]


@compiled
def along(matrix: Array, vector: Array) -> float:
    """Return the quadratic form of a symmetric matrix `(n, n)` and a vector `(n,)`."""
    total = 0.0
    for row in range(len(vector)):
        if vector[row] != 0.0:
            drawn = 0.0
            for column in range(len(vector)):
                drawn += matrix[row, column] * vector[column]
            total += vector[row] * drawn
    return total
