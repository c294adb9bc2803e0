# SPDX-FileCopyrightText: The latticed authors
# SPDX-License-Identifier: Apache-2.0
"""Names of the files that a scene can be exported as."""
import os
from typing import Any, Union

from latticed.v1 import surface_pb2

_FORMATS = {
    "ply": surface_pb2.EXPORT_FORMAT_PLY,
    "obj": surface_pb2.EXPORT_FORMAT_OBJ,
    "stl": surface_pb2.EXPORT_FORMAT_STL,
    "glb": surface_pb2.EXPORT_FORMAT_GLB,
    "drc": surface_pb2.EXPORT_FORMAT_DRC,
    "nets": surface_pb2.EXPORT_FORMAT_CONTROL_NETS,
}


def export_format(name: str, path: Union[str, "os.PathLike[str]"]) -> Any:
    """ExportFormat of a name, or where that is empty of the path's suffix; ValueError where it is neither."""
    wanted = name or os.path.splitext(path)[1][1:].lower()
    if wanted not in _FORMATS:
        raise ValueError(f"a format is one of {', '.join(_FORMATS)}, not {wanted!r}")
    return _FORMATS[wanted]
