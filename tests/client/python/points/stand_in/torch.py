# SPDX-FileCopyrightText: The latticed authors
# SPDX-License-Identifier: Apache-2.0
"""What latticed.torch, its test and its example use of PyTorch, on numpy, for machines without it: tensors, one function
that is differentiated, sums of weighted results and of squared differences, and Adam. Debian's python3-torch takes 353 MB
with what it depends on."""
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
        return Term(self, self.array * other.array, other.array)

    def __add__(self, other):
        return Sum([self, other])

    def __sub__(self, other):
        return Difference(self, other.array)


class Difference:
    """A result of the function less constants."""

    def __init__(self, tensor, others):
        self.tensor, self.array = tensor, tensor.array - others

    def __pow__(self, exponent):
        return Term(self.tensor, self.array**exponent, exponent * self.array ** (exponent - 1))


class Term:
    """Values that depend on a result of the function, each on one number of it, and their derivatives by these."""

    def __init__(self, tensor, values, slopes):
        self.tensor, self.values, self.slopes = tensor, values, slopes

    def sum(self):
        return Sum([self])


class Sum:
    def __init__(self, terms):
        self.terms = [t for part in terms for t in (part.terms if isinstance(part, Sum) else [part])]

    def __add__(self, other):
        return Sum([self, other])

    def item(self):
        return float(sum(term.values.sum() for term in self.terms))

    def backward(self):
        context, function, source, count = self.terms[0].tensor.origin[:4]
        cotangents = [None] * count
        for term in self.terms:
            cotangents[term.tensor.origin[4]] = Tensor(term.slopes.astype(term.tensor.dtype))
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


class Adam:
    """Kingma and Ba 2015, with PyTorch's defaults."""

    def __init__(self, tensors, lr=1e-3):
        self.tensors, self.rate, self.steps = list(tensors), lr, 0
        self.means = [[np.zeros(t.shape), np.zeros(t.shape)] for t in self.tensors]

    def zero_grad(self):
        for each in self.tensors:
            each.grad = None

    def step(self):
        self.steps += 1
        for each, means in zip(self.tensors, self.means):
            means[0] = 0.9 * means[0] + 0.1 * each.grad.array
            means[1] = 0.999 * means[1] + 0.001 * each.grad.array**2
            mean, square = means[0] / (1 - 0.9**self.steps), means[1] / (1 - 0.999**self.steps)
            each.array = each.array - self.rate * mean / (np.sqrt(square) + 1e-8)


optim = types.SimpleNamespace(Adam=Adam)
autograd = types.SimpleNamespace(Function=Function)
