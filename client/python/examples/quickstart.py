#!/usr/bin/env python3
# SPDX-FileCopyrightText: The latticed authors
# SPDX-License-Identifier: Apache-2.0
#
# usage: [LATTICED_SERVER=ADDRESS] quickstart.py
# Drags the top of the lattice around my.obj by 1 along x, and writes deformed.glb. client/README.md shows it.
# [README]
import latticed

with latticed.connect() as client:  # LATTICED_SERVER, or 127.0.0.1:50151
    mesh = client.upload("my.obj")  # or upload_arrays(positions, faces)
    with client.create_scene(mesh, size=(4, 4, 4), delete_on_exit=True) as scene, scene.deform() as stream:
        top = stream.lattice.indices[-1]  # of control points [w, v, u]
        with stream.gesture() as drag:
            for step in range(1, 11):
                edit = drag.move(top, (0.1 * step, 0, 0))
        update = stream.wait(edit)  # update.points: (patches, points of each, 3)
        print(len(update.points), "patches, up to", update.points.max(axis=(0, 1)))
        scene.export("deformed.glb")
# [/README]
