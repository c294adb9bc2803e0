# SPDX-FileCopyrightText: The latticed authors
# SPDX-License-Identifier: Apache-2.0
"""A surface whose triangles are patches already, since none crosses a knot plane.

The nodes (i, j, k) of a grid with i + j + k = const make a sheet of triangles. The triangles at the cell (i, j, k) have
three of its corners. Knot planes are planes of the grid, so each triangle lies in one knot box, and the sheet passes
through boxes in all directions. Nodes that no knot plane holds are moved at random. The grid goes on outside the frame.
"""
import numpy as np

CELLS = 3  # of the grid in each span
MARGIN = 2  # cells outside the frame


class Sheet:
    """corners   (patches, 3): vertices, in the order of first use; patches inside the frame come first
    inside    the number of patches inside the frame
    shares    (vertices, 3): places in the frame, 0 to 1
    world     (vertices, 3): at rest
    """

    def __init__(self, lattice, random):
        self.lattice = lattice
        self.breaks, self._axes, self._begins = [], [], []
        for knots, degree in zip(lattice.knots, lattice.degree):
            domain = knots[degree : len(knots) - degree]
            breaks = np.unique((domain - domain[0]) / (domain[-1] - domain[0]))
            parts = [np.linspace(low, high, CELLS + 1)[:-1] for low, high in zip(breaks, breaks[1:])]
            outside = 0.1 * np.arange(1, MARGIN + 1)
            self.breaks.append(breaks)
            self._axes.append(np.concatenate([-outside[::-1], *parts, [1.0], 1 + outside]))
        patches = list(self._patches())
        inside = [self._is_inside(cell) for cell, _ in patches]
        self.inside = sum(inside)
        ordered = [nodes for flag in (True, False) for (_, nodes), own in zip(patches, inside) if own == flag]
        numbers = {}
        for nodes in ordered:
            for node in nodes:
                numbers.setdefault(node, len(numbers))
        self.corners = np.array([[numbers[node] for node in nodes] for nodes in ordered])
        self.shares = np.array([self._share(node, random) for node in numbers])
        self.world = lattice.origin + self.shares @ lattice.edges

    def _patches(self):
        sizes = [len(axis) for axis in self._axes]
        level = sum(sizes) // 2 - 1
        for i, j, k in np.ndindex(*(size - 1 for size in sizes)):
            if i + j + k == level - 1:
                yield (i, j, k), ((i + 1, j, k), (i, j + 1, k), (i, j, k + 1))
            elif i + j + k == level - 2:
                yield (i, j, k), ((i + 1, j + 1, k), (i, j + 1, k + 1), (i + 1, j, k + 1))

    def _is_inside(self, cell):
        return all(MARGIN <= cell[a] < len(self._axes[a]) - 1 - MARGIN for a in range(3))

    def _share(self, node, random):
        share = []
        for axis, breaks, number in zip(self._axes, self.breaks, node):
            move = random.uniform(-0.3, 0.3) * np.diff(axis).min()
            share.append(axis[number] + (0 if np.isin(axis[number], breaks) else move))
        return share

    @property
    def at_rest(self):
        """(patches, 3 corners, 3): world units."""
        return self.world[self.corners]

    def facet_normals(self):
        """(patches, 3): unit, by the winding of corners."""
        a, b, c = self.at_rest.transpose(1, 0, 2)
        normals = np.cross(b - a, c - a)
        return normals / np.linalg.norm(normals, axis=1, keepdims=True)

    def vertex_normals(self):
        """(vertices, 3): unit, the mean of those of the patches around."""
        sums = np.zeros_like(self.world)
        np.add.at(sums, self.corners, self.facet_normals()[:, None])
        return sums / np.linalg.norm(sums, axis=1, keepdims=True)
