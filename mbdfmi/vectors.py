"""Products and lengths whose digits do not depend on the processor, as those of BLAS do: a model is the same everywhere."""

import math

import numpy as np


def dot(*factors):
    """The matrix product of arrays (a vector comes last), each sum from the left."""
    *others, product = [np.asarray(factor, float) for factor in factors]

    for factor in reversed(others):
        terms = factor * product if product.ndim == 1 else factor[..., None] * product
        product = terms.sum(-1) if product.ndim == 1 else terms.sum(-2)

    return product


def norm(vector):
    """Length of a vector."""
    return math.sqrt(sum(float(x) * float(x) for x in vector))
