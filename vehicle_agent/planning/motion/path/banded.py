"""Symmetric positive definite band matrices, lower band stored by diagonals."""

from numba import njit

from contract.geometry import Array


@njit(cache=True)
def factorize(band: Array) -> bool:
    """Cholesky factor in place; False when the matrix is not positive definite.

    band (w + 1, n): band[d, j] is the entry (j + d, j).
    """
    width, n = band.shape[0] - 1, band.shape[1]
    for j in range(n):
        pivot = band[0, j]
        for d in range(1, min(width, j) + 1):
            pivot -= band[d, j - d] * band[d, j - d]
        if not pivot > 0.0:
            return False
        root = pivot**0.5
        band[0, j] = root
        for i in range(1, min(width, n - 1 - j) + 1):
            value = band[i, j]
            for d in range(1, min(width - i, j) + 1):
                value -= band[i + d, j - d] * band[d, j - d]
            band[i, j] = value / root
    return True


@njit(cache=True)
def solve(factor: Array, b: Array) -> None:
    """L L' x = b in place, for one right-hand side b (n,)."""
    width, n = factor.shape[0] - 1, factor.shape[1]
    for j in range(n):
        value = b[j]
        for d in range(1, min(width, j) + 1):
            value -= factor[d, j - d] * b[j - d]
        b[j] = value / factor[0, j]
    for j in range(n - 1, -1, -1):
        value = b[j]
        for d in range(1, min(width, n - 1 - j) + 1):
            value -= factor[d, j] * b[j + d]
        b[j] = value / factor[0, j]
