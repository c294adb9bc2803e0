#!/usr/bin/env python3
# SPDX-FileCopyrightText: The latticed authors
# SPDX-License-Identifier: Apache-2.0
#
# usage: fit_shape.py OUT.png [--server ADDRESS] [--iterations N]
# Fits a lattice to a target: moves 5 x 5 x 5 control points until a sphere's points lie on a twisted, bent egg, by
# L-BFGS with exact gradients, and draws the convergence.
import argparse

import bodies
import latticed
import numpy as np
from latticed.scipy import Shape
from scipy.optimize import minimize


def egg(x):
    """The target of each point of the sphere."""
    turn = 0.6 * x[:, 0]
    c, s = np.cos(turn), np.sin(turn)
    wide = 1 - 0.25 * x[:, 0]
    y, z = 0.7 * wide * x[:, 1], 1.1 * wide * x[:, 2]
    return np.stack([1.3 * x[:, 0], c * y - s * z + 0.2 * x[:, 0] ** 2, s * y + c * z], axis=-1)


def main(arguments):
    vertices, triangles = bodies.sphere()
    target = egg(vertices)
    with latticed.connect(arguments.server) as client:
        mesh = client.upload_arrays(vertices, triangles, name="sphere", progress=False)
        with client.create_scene(mesh, size=(5, 5, 5), degree=(3, 3, 3), delete_on_exit=True) as scene:
            with scene.points(vertices) as points:
                shape = Shape(scene, points)
                distances = []

                def misfit(x):
                    return 0.5 * ((x - target) ** 2).sum(), x - target

                def note(x):
                    distances.append(np.sqrt(((shape.move(x) - target) ** 2).sum(axis=1).mean()))

                note(shape.start)
                best = minimize(
                    shape.objective(misfit),
                    shape.start,
                    jac=True,
                    method="L-BFGS-B",
                    callback=note,
                    options={"maxiter": arguments.iterations, "ftol": 1e-15, "gtol": 1e-10},
                )
                note(best.x)
    print(f"{len(points)} points, {len(best.x)} unknowns, {best.nit} iterations, {best.nfev} evaluations")
    print(f"root mean square distance: {distances[0]:.3g} at first, {distances[-1]:.3g} at last")
    bodies.plot_convergence(arguments.out, {"distance": distances}, "A sphere fitted to a twisted egg")


if __name__ == "__main__":
    parser = argparse.ArgumentParser()
    parser.add_argument("out")
    parser.add_argument("--server", default=None)
    parser.add_argument("--iterations", type=int, default=200)
    main(parser.parse_args())
