# SPDX-FileCopyrightText: The latticed authors
# SPDX-License-Identifier: Apache-2.0
from typing import Any, List, Tuple

def decode(
    streams: Tuple[bytes, ...],
    is_meshopt: bool,
    position_bits: int,
    normal_bits: int,
    step: float,
    positions: Tuple[Any, ...],
    normals: Tuple[Any, ...],
) -> List[bool]: ...
