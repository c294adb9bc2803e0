# SPDX-FileCopyrightText: The latticed authors
# SPDX-License-Identifier: Apache-2.0
#
# usage: torch_session.py ADDRESS
# Differentiates weighted sums of deformed points and normals by latticed.torch, and compares with difference quotients.
import sys

import latticed
import numpy as np
import torch

import definition
from latticed.torch import deform


def main(address):
    random = np.random.default_rng(26)
    with latticed.connect(address) as client:
        box = client.upload_arrays(definition.BOX_POSITIONS, definition.BOX_FACES, name="box", progress=False)
        with client.create_scene(box, size=(4, 3, 5), degree=(3, 1, 2), delete_on_exit=True) as scene:
            lattice = scene.lattice()
            world = lattice.origin + random.uniform(0, 1, (200, 3)) @ lattice.edges
            points = scene.points(world, random.normal(size=world.shape))
            start = lattice.control_points + random.uniform(-0.05, 0.05, lattice.control_points.shape)
            direction = random.normal(size=start.shape)
            weights = [torch.tensor(random.normal(size=world.shape)) for _ in range(2)]

            def value(at, normals):
                leaf = torch.tensor(at, requires_grad=True)
                results = deform(scene, points, leaf, normals)
                if normals:
                    return leaf, (results[0] * weights[0]).sum() + (results[1] * weights[1]).sum()
                return leaf, (results * weights[0]).sum()

            for normals in (False, True):
                leaf, total = value(start, normals)
                total.backward()
                gradient = leaf.grad.numpy()
                assert gradient.shape == start.shape and gradient.dtype == np.float64
                step = 1e-5
                ends = [value(start + s * step * direction, normals)[1].item() for s in (1, -1)]
                difference, exact = (ends[0] - ends[1]) / (2 * step), (gradient * direction).sum()
                assert abs(difference - exact) < 1e-5 * max(1, abs(exact)), (normals, difference, exact)

            leaf, total = value(start, False)
            scene.replace(start + direction)  # positions are linear in control points: their derivative stays
            total.backward()
            leaf, total = value(start, True)
            scene.replace(start)
            try:
                total.backward()
                raise AssertionError("the derivative of normals is of another revision")
            except latticed.LatticedError as error:
                assert error.reason == "REVISION_CHANGED"
            leaf, total = value(start, False)
            scene.insert_knot("u", 0.5)
            try:
                total.backward()
                raise AssertionError("the gradient has another shape")
            except RuntimeError as error:
                assert "knots" in str(error)
        check_one_of_two_lattices(client, box, lattice, world, random)
        check_constraints(client, box, world, random)
    print("gradients agree")


def check_one_of_two_lattices(client, box, lattice, world, random):
    lattice.control_points = lattice.rest()
    with client.create_scene(box, size=(4, 4, 4), delete_on_exit=True) as scene:
        scene.add_lattice(lattice)
        start = torch.tensor(lattice.control_points, requires_grad=True)
        with scene.points(world) as points:
            ones = torch.tensor(np.ones(world.shape))
            (deform(scene, points, start, lattice=1) * ones).sum().backward()
        gradient = start.grad.numpy().reshape(-1, 3).sum(axis=0)
        np.testing.assert_allclose(gradient, len(world))  # all points move as all control points


def check_constraints(client, box, world, random):
    """The loss is a function of the tensor, of which the constraints make control points."""
    kept = latticed.Constraints(held=(1,), held_layers={"w-": 1}, mirror="u")
    with client.create_scene(box, size=(4, 3, 5), degree=(3, 1, 2), delete_on_exit=True) as scene:
        scene.set_constraints(kept)
        start = scene.lattice().control_points
        start = start + random.uniform(-0.05, 0.05, start.shape)
        direction = random.normal(size=start.shape)
        target = torch.tensor(random.normal(size=world.shape))
        with scene.points(world) as points:

            def value(at):
                leaf = torch.tensor(at, requires_grad=True)
                return leaf, ((deform(scene, points, leaf) - target) ** 2).sum()

            leaf, total = value(start)
            total.backward()
            gradient = leaf.grad.numpy()
            ends = [value(start + s * 1e-4 * direction)[1].item() for s in (1, -1)]
            difference, exact = (ends[0] - ends[1]) / 2e-4, (gradient * direction).sum()
            assert abs(difference - exact) < 1e-7 * max(1, abs(exact)), (difference, exact)
            assert not gradient[0].any() and not gradient.reshape(-1, 3)[1].any()
            scene.set_constraints(latticed.Constraints(keep_volume=True))
            try:
                value(start)
                raise AssertionError("a kept volume has no known derivative")
            except ValueError as error:
                assert "keeps the volume" in str(error)


main(sys.argv[1])
