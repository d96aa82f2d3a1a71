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
    """Write the product of a matrix `(n, m)` and a vector `(m,)`."""
    for row in range(len(matrix)):
        total = 0.0
        for column in range(len(vector)):
            total += matrix[row, column] * vector[column]
        out[row] = total


@compiled
def along(matrix: Array, vector: Array) -> float:
    """Return the quadratic form of a symmetric matrix `(n, n)` and a vector `(n,)`."""
    total = 0.0
    for row in range(len(vector)):
        if vector[row] != 0.0:
            for column in range(len(vector)):
                total += vector[row] * matrix[row, column] * vector[column]
    return total
