# SPDX-FileCopyrightText: The latticed authors
# SPDX-License-Identifier: Apache-2.0
"""Rows 3 and 8: meshes that grow while they are read, and the largest meshes that fit."""
import meshes
from attack import CLOSED, attack
from calls import Refused, beside, delete, upload
from latticed.v1 import mesh_pb2

AT_ONCE = 4


def upload_at_once(target, seen, kind, data):
    """Uploads the file again and again from several connections. Meshes that are taken are deleted."""

    def work(_):
        connection = target.connect()
        for _ in target.until_end():
            try:
                mesh = upload(connection, kind, data)
                seen.count("meshes")
                delete(connection, meshes=[mesh.id])
            except Refused as error:
                seen.count_status(error.status)
                seen.expect(error.status in (3, 8), f"an upload ends with {error}")
            except CLOSED:
                connection = target.connect_again(seen)

    beside(AT_ONCE, work)


@attack("3", quick={"direct": 1})
def ply_strips(target, seen):
    upload_at_once(target, seen, mesh_pb2.MESH_FORMAT_PLY, meshes.ply_strip(8_000_000))


@attack("3")
def dense_obj(target, seen):
    upload_at_once(target, seen, mesh_pb2.MESH_FORMAT_OBJ, meshes.dense_obj(30))


@attack("3", quick={"direct": 1})
def draco_of_zeros(target, seen):
    """117 kB that become 460 MB: attributes that the mesh does not need take memory too."""
    upload_at_once(target, seen, mesh_pb2.MESH_FORMAT_DRACO, meshes.draco(38_000, 2))


@attack("3", quick={"direct": 1})
def draco_tables(target, seen):
    """A megabyte whose tables take 768, which nothing announces."""
    upload_at_once(target, seen, mesh_pb2.MESH_FORMAT_DRACO, meshes.draco_tables(1))


@attack("8")
def largest_meshes(target, seen):
    """Uploads meshes until none fits any more, deletes them, and begins again."""
    connection = target.connect()
    number = 0
    for _ in target.until_end():
        ids, side = [], 900
        while side > 100:
            layout, data = meshes.raw_grid(side, number)
            number += 1
            try:
                ids.append(upload(connection, mesh_pb2.MESH_FORMAT_RAW, data, layout).id)
                seen.count("meshes")
            except Refused as error:
                seen.count_status(error.status)
                side //= 2
        delete(connection, meshes=ids)
