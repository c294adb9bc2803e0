# SPDX-FileCopyrightText: The latticed authors
# SPDX-License-Identifier: Apache-2.0
"""Deformed points as a differentiable function of control points, for PyTorch. Needs the package torch.

    from latticed.torch import deform

    control_points = torch.tensor(scene.lattice().control_points, requires_grad=True)
    with scene.points(nodes) as points:
        loss = ((deform(scene, points, control_points) - target) ** 2).sum()
        loss.backward()  # control_points.grad is exact, in double
"""
from __future__ import annotations

from typing import Any, Optional, Tuple, Union

import numpy as np
import torch

from latticed.freedom import lattice_and_freedom
from latticed.points.point_set import PointSet
from latticed.scene import Scene


class _Deform(torch.autograd.Function):
    """Forward: an edit and DeformPointSet. Backward: ApplyJacobianTranspose."""

    @staticmethod
    def forward(
        ctx: Any, control_points: Any, scene: Scene, points: PointSet, normals: bool, number: int
    ) -> Any:
        lattice, ctx.freedom = lattice_and_freedom(scene, number)
        array = control_points.detach().cpu().double().numpy()
        result = scene.edits_of(number).replace(array.reshape(lattice.control_points.shape))
        values = points.deform(normals, result.revision)
        ctx.points, ctx.number, ctx.shape = points, number, control_points.shape
        ctx.structure_id = values.structure_id
        # Positions depend on control points linearly, so their derivative is the same at all revisions.
        ctx.revision = values.revision if normals else 0
        like = {"dtype": control_points.dtype, "device": control_points.device}
        positions = torch.as_tensor(values.positions, **like)
        if not normals:
            return positions
        return positions, torch.as_tensor(values.normals, **like)

    @staticmethod
    def backward(ctx: Any, *cotangents: Optional[Any]) -> Any:
        given = next(c for c in cotangents if c is not None)

        def array(cotangent: Optional[Any]) -> Any:
            tensor = torch.zeros_like(given) if cotangent is None else cotangent
            return tensor.detach().cpu().double().numpy()

        by_normals = array(cotangents[1]) if len(cotangents) > 1 else None
        gradients = ctx.points.vjp(array(cotangents[0]), by_normals, ctx.revision, ctx.number)
        if gradients.structure_id != ctx.structure_id:
            raise RuntimeError("the lattice's knots or frame have changed since the points were deformed")
        by_points = ctx.freedom.pull_back(gradients.gradients, np.arange(len(gradients.gradients)))
        tensor = torch.as_tensor(by_points, dtype=given.dtype, device=given.device)
        return tensor.reshape(ctx.shape), None, None, None, None


def deform(
    scene: Scene,
    points: PointSet,
    control_points: torch.Tensor,
    normals: bool = False,
    lattice: int = 0,
) -> Union[torch.Tensor, Tuple[torch.Tensor, torch.Tensor]]:
    """Puts all control points of the scene at a tensor, and returns the deformed points: (n, 3), and with `normals` a
    pair of positions and normals. Gradients flow back to the tensor.

    control_points  shaped like Lattice.control_points, or (control points, 3); any float type and device. The server
                    computes in double
    lattice         which one has these control points, from 0, where the scene has several
    Held points of the lattice stay and have the gradient 0; under a mirror both the points and the gradient are symmetrised.
    A lattice that keeps its volume is refused: ValueError.
    The gradient of normals needs the scene as it was: if it was edited meanwhile, backward fails with REVISION_CHANGED.
    """
    return _Deform.apply(control_points, scene, points, normals, lattice)
