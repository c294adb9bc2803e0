#!/usr/bin/env python3
# SPDX-FileCopyrightText: The latticed authors
# SPDX-License-Identifier: Apache-2.0
#
# usage: pygeo_like.py [POINTS]; prints times of the CPU, the least of several runs
# What `latticed_bench --benchmark_filter=^points` measures, as others do it, on one core: 10^6 points in an 8 x 8 x 8 lattice
# of degree 2. pyGeo multiplies by a sparse matrix of basis values (scipy.sparse, made once per structure); a program of one's
# own evaluates the volume with PyTorch and lets autograd differentiate it, both ways: without PyTorch, a line says so. Each is
# first compared with the other.
import ctypes
import importlib.util
import os
import sys
import time

os.environ["OMP_NUM_THREADS"] = os.environ["OPENBLAS_NUM_THREADS"] = "1"
import numpy as np  # noqa: E402
import scipy.sparse  # noqa: E402

SIZE, DEGREE = 8, 2


def basis(u):
    """The span and the values of the quadratic basis functions of clamped uniform knots at u in [0, 1]."""
    knots = np.concatenate([[0] * DEGREE, np.arange(SIZE - DEGREE + 1), [SIZE - DEGREE] * DEGREE]).astype(
        float
    )
    t = u * (SIZE - DEGREE)
    span = np.clip(np.ceil(t).astype(int) - 1, 0, SIZE - DEGREE - 1) + DEGREE
    values = [np.ones_like(t)]
    for j in range(1, DEGREE + 1):
        saved, row = 0.0, []
        for r in range(j):
            right, left = knots[span + r + 1] - t, t - knots[span + 1 - j + r]
            term = values[r] / (right + left)
            row.append(saved + right * term)
            saved = left * term
        values = [*row, saved]
    return span - DEGREE, np.stack(values, axis=-1)


def best(call, runs=5):
    times = []
    for _ in range(runs):
        begin = time.process_time()
        call()
        times.append(time.process_time() - begin)
    return f"{min(times) * 1e3:.0f} ms"


def main(count):
    random = np.random.default_rng(26)
    points, coefficients = random.uniform(0, 1, (count, 3)), random.normal(size=(SIZE**3, 3))
    cotangents = random.normal(size=(count, 3))
    begin = time.process_time()
    axes = [basis(points[:, a]) for a in range(3)]
    places = [first[:, None] + np.arange(DEGREE + 1) for first, _ in axes]
    columns = (
        places[0][:, None, None, :]
        + SIZE * (places[1][:, None, :, None] + SIZE * places[2][:, :, None, None])
    ).reshape(count, -1)
    weights = np.einsum("ni,nj,nk->nkji", *(values for _, values in axes)).reshape(count, -1)
    rows = np.arange(0, columns.size + 1, columns.shape[1])
    matrix = scipy.sparse.csr_matrix((weights.ravel(), columns.ravel(), rows), shape=(count, SIZE**3))
    transposed = matrix.T.tocsr()
    print(
        f"sparse matrix: made in {time.process_time() - begin:.1f} s, {matrix.data.nbytes * 1.5 / count:.0f} bytes a point"
    )
    # Points are linear in the control points: a direction costs what the points cost.
    print("sparse matrix, forward:", best(lambda: matrix @ coefficients))
    print(
        "sparse matrix, reverse:",
        best(lambda: matrix.T @ cotangents),
        "or",
        best(lambda: transposed @ cotangents),
    )
    if importlib.util.find_spec("torch") is None:
        print("PyTorch: not measured, since it is not installed (python3-torch)")
        return
    import torch
    from torch.autograd import forward_ad

    # Without it, most of PyTorch's time is that of fresh pages: the allocator keeps freed memory (M_MMAP_MAX, M_TRIM_THRESHOLD).
    libc = ctypes.CDLL(None)
    assert libc.mallopt(-4, 0) and libc.mallopt(-1, -1)
    torch.set_num_threads(1)
    leaf = torch.tensor(coefficients, requires_grad=True)
    index, by_axis = torch.tensor(columns), [torch.tensor(values) for _, values in axes]
    given = torch.tensor(cotangents)
    at, tangents = leaf.detach(), torch.tensor(random.normal(size=coefficients.shape))

    def forward(control_points=leaf):
        corners = control_points[index].reshape(count, DEGREE + 1, DEGREE + 1, DEGREE + 1, 3)
        along = torch.einsum("ni,nkjic->nkjc", by_axis[0], corners)
        return torch.einsum("nk,nkc->nc", by_axis[2], torch.einsum("nj,nkjc->nkc", by_axis[1], along))

    def both():
        leaf.grad = None
        forward().backward(given)

    def direction():
        with forward_ad.dual_level():
            return forward_ad.unpack_dual(forward(forward_ad.make_dual(at, tangents))).tangent

    both()
    assert np.abs(forward().detach().numpy() - matrix @ coefficients).max() < 1e-12
    assert np.abs(leaf.grad.numpy() - matrix.T @ cotangents).max() < 1e-8
    assert np.abs(direction().numpy() - matrix @ tangents.numpy()).max() < 1e-12
    print("PyTorch, forward:", best(forward, 3))
    print("PyTorch, forward and one direction by autograd:", best(direction, 3))
    print("PyTorch, forward and reverse by autograd:", best(both, 3))


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 1_000_000)
