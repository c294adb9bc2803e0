#!/usr/bin/env python3
# SPDX-FileCopyrightText: The latticed authors
# SPDX-License-Identifier: Apache-2.0
#
# usage: fit_torch.py [--server ADDRESS] [--steps N]
# Fits a lattice with a mirror to a target by PyTorch: a loss of the deformed points, its exact gradient by control points
# from latticed.torch, and Adam. Whatever gives the loss may be a network; here it is a sum of squares.
import argparse

import bodies
import latticed
import numpy as np

try:
    import torch
except ModuleNotFoundError:
    raise SystemExit("fit_torch.py needs PyTorch: pip install torch, or Debian's python3-torch") from None
from latticed.torch import deform  # noqa: E402


def bean(x):
    """The target of each point of the sphere, symmetric in y."""
    return np.stack([1.3 * x[:, 0], (1 - 0.3 * x[:, 0]) * x[:, 1], x[:, 2] + 0.3 * x[:, 0] ** 2], axis=-1)


def main(arguments):
    vertices, triangles = bodies.sphere()
    target = torch.tensor(bean(vertices))
    with latticed.connect(arguments.server) as client:
        mesh = client.upload_arrays(vertices, triangles, name="sphere", progress=False)
        with client.create_scene(mesh, size=(4, 4, 4), delete_on_exit=True) as scene:
            scene.set_constraints(latticed.Constraints(mirror="v"))
            control_points = torch.tensor(scene.lattice().control_points, requires_grad=True)
            adam = torch.optim.Adam([control_points], lr=0.02)
            distances = []
            with scene.points(vertices) as points:
                for _ in range(arguments.steps):
                    adam.zero_grad()
                    loss = ((deform(scene, points, control_points) - target) ** 2).sum()
                    loss.backward()
                    adam.step()
                    distances.append((loss.item() / len(vertices)) ** 0.5)
            placed = scene.lattice().control_points
    print(f"root mean square distance: {distances[0]:.3g} at first, {distances[-1]:.3g} at last")
    print(f"mirror: {abs(placed - placed[:, ::-1] * [1, -1, 1]).max():.1g} from symmetric")


if __name__ == "__main__":
    parser = argparse.ArgumentParser()
    parser.add_argument("--server", default=None)
    parser.add_argument("--steps", type=int, default=200)
    main(parser.parse_args())
