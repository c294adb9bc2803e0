# SPDX-FileCopyrightText: The latticed authors
# SPDX-License-Identifier: Apache-2.0
"""What latticed.torch and its test use of PyTorch, on numpy, for machines without it: tensors, one function that is
differentiated, and weighted sums of its results. Debian's python3-torch takes 353 MB with what it depends on."""
import types

import numpy as np

float32, float64 = np.float32, np.float64


class Tensor:
    def __init__(self, array, requires_grad=False, origin=None):
        self.array = np.asarray(array)
        self.requires_grad, self.grad, self.origin = requires_grad, None, origin

    shape = property(lambda self: self.array.shape)
    dtype = property(lambda self: self.array.dtype)
    device = "cpu"

    def detach(self):
        return Tensor(self.array)

    def cpu(self):
        return self

    def double(self):
        return Tensor(self.array.astype(np.float64))

    def numpy(self):
        return self.array

    def reshape(self, shape):
        return Tensor(self.array.reshape(shape))

    def __mul__(self, other):
        return Product(self, other.array)

    def __add__(self, other):
        return Sum([self, other])


class Product:
    """A result of the function times constants; backward of its sum."""

    def __init__(self, tensor, weights):
        self.tensor, self.weights = tensor, weights

    def sum(self):
        return Sum([self])


class Sum:
    def __init__(self, products):
        self.products = [p for part in products for p in (part.products if isinstance(part, Sum) else [part])]

    def __add__(self, other):
        return Sum([self, other])

    def item(self):
        return float(sum((p.tensor.array * p.weights).sum() for p in self.products))

    def backward(self):
        context, function, source, count = self.products[0].tensor.origin[:4]
        cotangents = [None] * count
        for product in self.products:
            cotangents[product.tensor.origin[4]] = Tensor(product.weights.astype(product.tensor.dtype))
        source.grad = function.backward(context, *cotangents)[0]


class Function:
    @classmethod
    def apply(cls, source, *arguments):
        context = types.SimpleNamespace()
        results = cls.forward(context, source, *arguments)
        several = isinstance(results, tuple)
        tensors = results if several else (results,)
        for number, tensor in enumerate(tensors):
            tensor.origin = (context, cls, source, len(tensors), number)
        return results


def tensor(array, dtype=None, requires_grad=False):
    return Tensor(np.array(array, dtype=dtype), requires_grad)


def as_tensor(array, dtype=None, device=None):
    return Tensor(np.asarray(array, dtype=dtype))


def zeros_like(other):
    return Tensor(np.zeros_like(other.array))


autograd = types.SimpleNamespace(Function=Function)
