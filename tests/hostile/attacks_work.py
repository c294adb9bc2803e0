# SPDX-FileCopyrightText: The latticed authors
# SPDX-License-Identifier: Apache-2.0
"""Row 5: dear calls beside cheap ones."""
import meshes
from attack import CLOSED, TIDY_SOURCE, attack
from attacks_shares import SCENE, grid_scene
from calls import Refused, beside, create_scene, delete, export_request, unary, upload
from latticed.v1 import edit_pb2, mesh_pb2

MOST_DRAG_POINTS = 1_024


@attack("5", quick={"direct": 1.5})
def exports(target, seen):
    tidy = grid_scene(target, 60)

    def work(_):
        connection = target.connect()
        connection.keeps_data = False
        for _ in target.until_end():
            try:
                stream = connection.begin("SceneService/Export")
                connection.send_data(stream, export_request(SCENE, 8))
                seen.count_status(connection.ending(stream, 60))
            except CLOSED:
                connection = target.connect_again(seen)

    beside(8, work)
    tidy()


@attack("5", quick={"direct": 1.5})
def drags_of_1024_points(target, seen):
    side = 32
    tidy = grid_scene(target, side, size=16)
    drag = edit_pb2.DragPoints()
    for face in range(MOST_DRAG_POINTS):
        point = drag.points.add(face=face)
        point.corners.extend([4 * face, 4 * face + 1, 4 * face + 2])
        point.barycentrics.extend([0.25, 0.25, 0.5])
        drag.targets.extend([face % side + 0.3, face // side + 0.4, 0.5])

    def work(number):
        connection = target.connect()
        sequence = 0
        for _ in target.until_end():
            sequence += 1
            batch = edit_pb2.EditBatch(scene=SCENE, editor_id=f"mallory-{number}", sequence=sequence)
            batch.structure_id = 1
            batch.edits.add().drag_points.CopyFrom(drag)
            try:
                unary(connection, "SceneService/ApplyEdits", batch)
                seen.count("drags")
            except Refused as error:
                seen.count_status(error.status)
                seen.expect(error.status == 8, f"a drag ends with {error}")

    beside(4, work)
    tidy()


@attack("5", seconds=8)
def large_polygons(target, seen):
    """Uploads 11 MB of polygons with 65,536 corners, and 2 MB of them, and makes scenes of them."""

    def work(number):
        connection = target.connect()
        data = meshes.large_polygons(2 if number else 11) + b"# %d\n" % number
        mesh, scene = None, f"polygons-{number}"
        for _ in target.until_end():
            try:
                mesh = upload(connection, mesh_pb2.MESH_FORMAT_OBJ, data).id
                seen.count("meshes")
                create_scene(connection, scene, mesh)
                seen.count("scenes")
                delete(connection, [scene])
            except Refused as error:
                seen.count_status(error.status)
            except CLOSED:
                connection = target.connect_again(seen)
        delete(target.connect(TIDY_SOURCE), [scene], [mesh] if mesh else [])

    beside(3, work)
