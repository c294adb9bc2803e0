# SPDX-FileCopyrightText: The latticed authors
# SPDX-License-Identifier: Apache-2.0
#
# usage: blender --background --factory-startup --python-exit-code 1 --python round_trip.py -- LATTICECTL FOLDER
# A mesh goes from Blender to LATTICED_SERVER in a file, is deformed, and comes back in a file, by each of the formats
# that Blender 3.4 reads: its vertices must be where the definition has them, and its faces, texture coordinates,
# materials and picture must be as before.
import json
import subprocess
import sys
from collections import Counter
from pathlib import Path
from types import SimpleNamespace

import bmesh
import bpy
import numpy as np

sys.path[:0] = [str(Path(__file__).parent), str(Path(__file__).parent.parent / "python")]
from addon_scene import check, coordinates  # noqa: E402
from definition import deform  # noqa: E402

if "bool" not in vars(np):
    np.bool = bool  # Debian's glTF add-on is older than its numpy

QUADS = 96
PICTURE = np.linspace(0, 1, 8 * 8 * 4, dtype=np.float32)
POSITION_TOLERANCE = 2e-6  # float32 of a mesh of 3 units
UV_DIGITS = 5


def material(name, picture):
    made = bpy.data.materials.new(name)
    made.use_nodes = True
    if picture is not None:
        image = bpy.data.images.new("bricks", 8, 8, alpha=True)
        image.pixels.foreach_set(PICTURE)
        image.filepath_raw, image.file_format = str(picture), "PNG"
        image.save()
        texture = made.node_tree.nodes.new("ShaderNodeTexImage")
        texture.image = image
        shader = made.node_tree.nodes["Principled BSDF"]
        made.node_tree.links.new(texture.outputs["Color"], shader.inputs["Base Color"])
    return made


def make_torus(picture):
    bpy.ops.wm.read_factory_settings(use_empty=True)
    bpy.ops.mesh.primitive_torus_add(major_segments=12, minor_segments=8, generate_uvs=True)
    torus = bpy.context.active_object.data
    for name in ("painted", "plain"):
        torus.materials.append(material(name, picture if name == "painted" else None))
    for polygon in torus.polygons:
        polygon.use_smooth = True
        polygon.material_index = polygon.index % 2
    return torus


def numbered_uvs(mesh, number):
    """How often a corner has this vertex and this texture coordinate."""
    uvs = mesh.uv_layers.active.data
    return Counter(
        (number[loop.vertex_index], *(round(x, UV_DIGITS) + 0.0 for x in uvs[i].uv))
        for i, loop in enumerate(mesh.loops)
    )


def faces_by_material(mesh):
    return Counter(mesh.materials[polygon.material_index].name.split(".")[0] for polygon in mesh.polygons)


def picture_of(mesh):
    painted = next(m for m in mesh.materials if m.name.startswith("painted"))
    images = [node.image for node in painted.node_tree.nodes if node.type == "TEX_IMAGE"]
    check(len(images) == 1, f"the painted material has {len(images)} pictures")
    pixels = np.empty(len(images[0].pixels), np.float32)
    images[0].pixels.foreach_get(pixels)
    return pixels


def to_file(points):
    """Blender's coordinates as the files have them, with y up."""
    return points[:, [0, 2, 1]] * [1, 1, -1]


def from_file(points):
    return points[:, [0, 2, 1]] * [1, -1, 1]


def read_lattice(path):
    message = json.loads(path.read_text())
    frame, size = message["frame"], [message["size"][axis] for axis in "uvw"]
    vector = lambda v: np.array([v[axis] for axis in "xyz"])
    return SimpleNamespace(
        origin=vector(frame["origin"]),
        edges=np.array([vector(frame[axis]) for axis in "uvw"]),
        knots=[np.array(message[f"knots{axis}"]) for axis in "UVW"],
        degree=[message["degree"][axis] for axis in "uvw"],
        control_points=np.array(message["controlPoints"]).reshape(*size[::-1], 3),
    )


def import_mesh(path):
    before = set(bpy.data.objects)
    if path.suffix == ".glb":
        bpy.ops.import_scene.gltf(filepath=str(path), merge_vertices=True)
    elif path.suffix == ".obj":
        bpy.ops.wm.obj_import(filepath=str(path))
    else:
        bpy.ops.import_mesh.ply(filepath=str(path))
    made = [o for o in bpy.data.objects if o not in before and o.type == "MESH"]
    check(len(made) == 1, f"{path.name} has {len(made)} meshes")
    made[0].data.transform(made[0].matrix_world)
    return made[0].data


def numbers_of(points, wanted):
    """Which of the points `wanted` each point is."""
    distances = np.linalg.norm(points[:, None] - wanted[None], axis=2)
    check(
        distances.min(axis=1).max() <= POSITION_TOLERANCE,
        f"a vertex is {distances.min(axis=1).max()} from its place",
    )
    check(set(distances.argmin(axis=1)) == set(range(len(wanted))), "a vertex is missing")
    return distances.argmin(axis=1)


def is_closed(mesh):
    form = bmesh.new()
    form.from_mesh(mesh)
    return all(edge.is_manifold for edge in form.edges)


class RoundTrip:
    def __init__(self, latticectl, folder):
        self.latticectl = latticectl
        self.folder = folder

    def call(self, *words):
        subprocess.run([self.latticectl, *map(str, words)], check=True, stdout=subprocess.DEVNULL)

    def make_scene(self, file):
        """A scene under a lattice that twists and bends. Returns the lattice."""
        lattice = self.folder / f"{file.stem}-lattice.json"
        scene = file.suffix[1:]
        self.call("lattice", file, "--size", "5,4,4", "--twist", 60, "--bend", 40, "-o", lattice)
        self.call("scene", "create", file, "--lattice", lattice, "--up", "y", "--id", scene)
        return read_lattice(lattice)

    def brings_back(self, suffix, returned, keeps_quads, keeps_materials):
        torus = make_torus(self.folder / "bricks.png")
        rest, uvs, faces = coordinates(torus), numbered_uvs(torus, range(QUADS)), faces_by_material(torus)
        file = self.folder / f"torus{suffix}"
        if suffix == ".glb":
            bpy.ops.export_scene.gltf(filepath=str(file))
        else:
            bpy.ops.wm.obj_export(filepath=str(file), path_mode="STRIP")
        lattice = self.make_scene(file)
        wanted = from_file(deform(lattice, to_file(rest)))
        check(np.abs(wanted - rest).max() > 0.2, "the lattice does not move the mesh")
        out = self.folder / f"back{returned}"
        self.call("export", suffix[1:], "-o", out, "--original", "--normals", "smooth")

        mesh = import_mesh(out)
        if returned == ".ply":  # Blender reads PLY as it is
            mesh.vertices.foreach_set("co", from_file(coordinates(mesh)).astype(np.float32).ravel())
        check(len(mesh.polygons) == (QUADS if keeps_quads else 2 * QUADS), f"{len(mesh.polygons)} faces")
        number = numbers_of(coordinates(mesh), wanted)
        if returned != ".ply":
            check(len(mesh.vertices) == QUADS, f"{len(mesh.vertices)} vertices")
        back = numbered_uvs(mesh, number)
        check(set(back) == set(uvs), f"{len(set(back) ^ set(uvs))} texture coordinates differ")
        if keeps_quads:
            check(back == uvs, "texture coordinates are at other corners")
        if keeps_materials:
            times = 1 if keeps_quads else 2
            check(
                faces_by_material(mesh) == Counter({name: times * n for name, n in faces.items()}),
                "materials differ",
            )
            difference = np.abs(picture_of(mesh) - PICTURE).max()
            check(difference <= 1 / 255, f"the picture differs by {difference}")
        print(
            f"round_trip: {suffix} to {returned}: {len(mesh.vertices)} vertices, {len(mesh.polygons)} faces"
        )

    def brings_the_exact_surface(self):
        """Of the scene that came from the GLB: welded, so that nothing is open."""
        out = self.folder / "exact.glb"
        self.call("export", "glb", "-o", out, "--segments", 3, "--normals", "smooth")
        mesh = import_mesh(out)
        check(is_closed(mesh), "the exact surface has open edges")
        check(set(faces_by_material(mesh)) == {"painted", "plain"}, "materials are missing")
        check(np.abs(picture_of(mesh) - PICTURE).max() <= 1 / 255, "the picture differs")
        print(f"round_trip: exact surface: {len(mesh.vertices)} vertices, {len(mesh.polygons)} faces")


def main(latticectl, folder):
    trip = RoundTrip(latticectl, Path(folder))
    trip.brings_back(".glb", ".glb", keeps_quads=False, keeps_materials=True)
    trip.brings_the_exact_surface()
    trip.brings_back(".obj", ".obj", keeps_quads=True, keeps_materials=True)
    trip.call("scene", "delete", "obj")
    trip.brings_back(".obj", ".ply", keeps_quads=True, keeps_materials=False)


main(*sys.argv[sys.argv.index("--") + 1 :])
