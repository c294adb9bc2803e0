# SPDX-FileCopyrightText: The latticed authors
# SPDX-License-Identifier: Apache-2.0
"""What the server says about a file that it has exported."""
from dataclasses import dataclass


@dataclass(frozen=True)
class Exported:
    """The surface in an exported file."""

    revision: int  # the revision of the surface
    # With a tolerance: the largest distance, both ways, between the exact surface and the triangles, in world units.
    # It does not count how the file rounds numbers. 0 without a tolerance.
    certified_error: float
