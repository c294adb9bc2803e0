# SPDX-FileCopyrightText: The latticed authors
# SPDX-License-Identifier: Apache-2.0
"""Client of latticed, the server for accurate free-form deformation.

    import latticed

    with latticed.connect("127.0.0.1:50151") as client:
        mesh = client.upload("my.obj")
        with client.create_scene(mesh, size=(4, 4, 4), delete_on_exit=True) as scene:
            with scene.deform(latticed.View(segments=8)) as stream:
                edit = stream.move(stream.lattice.indices[-1], (0.5, 0, 0))
                update = stream.wait(edit)
            print(update.points.shape, update.triangles.shape)
            scene.export("deformed.ply")

Points, offsets and matrices are in world units. Arrays are numpy arrays. Errors of the server raise
LatticedError. latticed.v1 holds the messages of the protocol.
"""
from latticed import google_rpc  # first: latticed.v1 needs google.rpc
from latticed import edits
from latticed.backup import BackedUp, Restored
from latticed.camera import Camera
from latticed.client import Client, connect
from latticed.deform_stream import DeformStream
from latticed.edit_calls import Gesture
from latticed.edit_result import EditResult
from latticed.errors import LatticedError
from latticed.evaluation import Evaluation
from latticed.exported import Exported
from latticed.folds import FoldedBox, FoldReport
from latticed.lattice import Lattice
from latticed.measures import Constraints, Measured
from latticed.mesh import Mesh
from latticed.outside import Outside
from latticed.patches.evaluator import PatchEvaluator
from latticed.patches.plan import PatchPlan
from latticed.patches.surface import PatchSurface
from latticed.pattern import PatchPattern
from latticed.points.point_set import PointSet
from latticed.points.values import PointGradients, PointValues
from latticed.presence import Presence
from latticed.progress_bar import ProgressBar
from latticed.provenance import Provenance
from latticed.scene import Scene
from latticed.share import Share
from latticed.surface_point import SurfacePoint
from latticed.topology import Topology
from latticed.update import Update
from latticed.view import View
from latticed.watch_stream import WatchStream

__all__ = [
    "BackedUp",
    "Camera",
    "Client",
    "Constraints",
    "DeformStream",
    "EditResult",
    "Evaluation",
    "Exported",
    "FoldReport",
    "FoldedBox",
    "Gesture",
    "Lattice",
    "LatticedError",
    "Measured",
    "Mesh",
    "Outside",
    "PatchEvaluator",
    "PatchPattern",
    "PatchPlan",
    "PatchSurface",
    "PointGradients",
    "PointSet",
    "PointValues",
    "Presence",
    "ProgressBar",
    "Provenance",
    "Restored",
    "Scene",
    "Share",
    "SurfacePoint",
    "Topology",
    "Update",
    "View",
    "WatchStream",
    "connect",
    "edits",
    "google_rpc",
]
