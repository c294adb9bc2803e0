#!/usr/bin/env python3
# SPDX-FileCopyrightText: The latticed authors
# SPDX-License-Identifier: Apache-2.0
#
# usage: least_drag.py OUT.png [--server ADDRESS] [--iterations N]
# Shapes a sphere for least drag in a flow along x, at constant volume, by SLSQP. The drag is Newton's impact drag of the
# deformed triangles, as a stand-in for a solver with an adjoint: whatever gives derivatives by the nodes does. Control
# points move by at most 0.35, and the length along the flow may not grow.
import argparse

import bodies
import latticed
import numpy as np
from latticed.scipy import Shape
from scipy.optimize import minimize

MOST_MOVE = 0.35


def main(arguments):
    vertices, triangles = bodies.sphere(16, 32)
    drag, volume = bodies.impact_drag(triangles, [1, 0, 0]), bodies.volume(triangles)
    rest_volume = volume(vertices)[0]

    def volume_error(x):
        value, by_points = volume(x)
        return value / rest_volume - 1, by_points / rest_volume

    with latticed.connect(arguments.server) as client:
        mesh = client.upload_arrays(vertices, triangles, name="sphere", progress=False)
        with client.create_scene(mesh, size=(4, 4, 4), degree=(2, 2, 2), delete_on_exit=True) as scene:
            with scene.points(vertices) as points:
                shape = Shape(scene, points)
                drags, errors = [], []

                def note(x):
                    positions = shape.move(x)
                    drags.append(drag(positions)[0])
                    errors.append(abs(volume_error(positions)[0]))

                note(shape.start)
                start = shape.start.reshape(-1, 3)
                room = np.array([1e-9, MOST_MOVE, MOST_MOVE])  # none along the flow at the two ends
                ends = np.isin(start[:, 0], [start[:, 0].min(), start[:, 0].max()])
                bounds = np.stack(
                    [
                        start - np.where(ends[:, None], room, MOST_MOVE),
                        start + np.where(ends[:, None], room, MOST_MOVE),
                    ],
                    axis=-1,
                ).reshape(-1, 2)
                best = minimize(
                    shape.objective(drag),
                    shape.start,
                    jac=True,
                    method="SLSQP",
                    bounds=bounds,
                    constraints=[shape.constraint(volume_error)],
                    callback=note,
                    options={"maxiter": arguments.iterations, "ftol": 1e-7},
                )
                note(best.x)
    print(f"{len(best.x)} unknowns, {best.nit} iterations, {best.nfev} evaluations")
    print(f"drag: {drags[0]:.6g} at first, {drags[-1]:.6g} at last")
    print(f"volume: {rest_volume:.6g}, changed by {errors[-1]:.2g} of it")
    curves = {"drag": drags, "volume error": errors}
    bodies.plot_convergence(arguments.out, curves, "Least impact drag at constant volume")


if __name__ == "__main__":
    parser = argparse.ArgumentParser()
    parser.add_argument("out")
    parser.add_argument("--server", default=None)
    parser.add_argument("--iterations", type=int, default=100)
    main(parser.parse_args())
