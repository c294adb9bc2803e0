#!/usr/bin/env python3
# SPDX-FileCopyrightText: The latticed authors
# SPDX-License-Identifier: Apache-2.0
#
# usage: example_get_update.py ADDRESS MESH.obj L.json
# From a file to the deformed surface as a numpy array, with nothing but gRPC. run_example.sh makes the
# generated modules, a server, a mesh and a lattice whose top was dragged by half along x for it.
import sys
import uuid

import grpc
import numpy
from google.protobuf import json_format
from latticed.v1 import lattice_pb2, mesh_pb2, mesh_pb2_grpc, scene_pb2, scene_pb2_grpc, view_pb2


def main(address, mesh_path, lattice_path):
    # [README]
    channel = grpc.insecure_channel(address)
    meshes, scenes = mesh_pb2_grpc.MeshServiceStub(channel), scene_pb2_grpc.SceneServiceStub(channel)
    data, part = open(mesh_path, "rb").read(), mesh_pb2.UploadMeshRequest
    header = part(header=mesh_pb2.MeshHeader(format=mesh_pb2.MESH_FORMAT_OBJ, total_bytes=len(data)))
    mesh = meshes.UploadMesh(iter([header] + [part(data=data[i:i + 2**19]) for i in range(0, len(data), 2**19)]))
    lattice = lattice_pb2.LatticeSource(lattice=json_format.Parse(open(lattice_path).read(), lattice_pb2.Lattice()))
    scene = scenes.CreateScene(scene_pb2.CreateSceneRequest(scene_id=uuid.uuid4().hex, mesh=mesh.id, lattices=[lattice]))
    view = view_pb2.ViewOptions(encoding=view_pb2.ENCODING_QUANTISED, normals=view_pb2.NORMAL_MODE_NONE)
    events = list(scenes.GetUpdate(scene_pb2.GetUpdateRequest(scene=scene.id, view=view)))
    grid = next(e.quantisation for e in events if e.HasField("quantisation"))
    chunks = sorted((c for e in events for c in e.chunks.chunks), key=lambda c: c.index)
    integers = numpy.concatenate([numpy.frombuffer(c.data, "<u2").reshape(3, -1) for c in chunks], axis=1).T
    points = numpy.array([grid.origin.x, grid.origin.y, grid.origin.z]) + grid.step * integers
    # [/README]
    end = next(e.update_end for e in events if e.HasField("update_end"))
    topology = next(e.topology for e in events if e.HasField("topology"))
    assert end.full_detail and end.revision == 0, end
    assert points.shape == (topology.point_count, 3), (points.shape, topology.point_count)
    print(f"{scene.patches} patches, {len(points)} points, from {points.min(axis=0)} to {points.max(axis=0)}, "
          f"rest box to x = {mesh.bounds.max.x:.4f}")
    # At rest the vase is round about the origin; its top followed the control points along x.
    top = points[points[:, 2] > points[:, 2].max() - 1e-2]
    assert top[:, 0].mean() > 0.2, top[:, 0].mean()
    assert abs(points[:, 1].max() - mesh.bounds.max.y) < 1e-3 + 2 * grid.step, points[:, 1].max()


if __name__ == "__main__":
    main(*sys.argv[1:])
