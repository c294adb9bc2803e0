# SPDX-FileCopyrightText: The latticed authors
# SPDX-License-Identifier: Apache-2.0
"""The notebook of the examples, run cell by cell without Jupyter."""
import json
import sys
import types

from server_process import ROOT

EXAMPLES = ROOT / "client/python/examples"
CELLS = json.loads((EXAMPLES / "first_steps.ipynb").read_text())["cells"]


def test_the_notebook_runs_and_draws_a_picture(server, client, monkeypatch):
    shown = []
    display = types.SimpleNamespace(Image=lambda data: data, display=shown.append)
    monkeypatch.setitem(sys.modules, "IPython", types.SimpleNamespace(display=display))
    monkeypatch.setitem(sys.modules, "IPython.display", display)
    monkeypatch.setenv("LATTICED_SERVER", server.address)
    monkeypatch.syspath_prepend(EXAMPLES)
    scenes, meshes = len(client.scenes()), len(client.meshes())
    names = {}

    for cell in CELLS:
        if cell["cell_type"] == "code":
            exec(compile("".join(cell["source"]), cell["id"], "exec"), names)

    assert len(shown) == 1 and shown[0].startswith(b"\x89PNG")
    assert names["update"].revision >= 10  # the drag's moves
    surface = names["update"].points.reshape(-1, 3)
    gaps = abs(surface[:, None] - names["vertices_only"]).max(axis=2).min(axis=0)
    assert gaps.max() <= names["update"].step  # the exact surface passes through the moved vertices
    assert (len(client.scenes()), len(client.meshes())) == (scenes, meshes)


def test_the_notebook_is_stored_without_outputs():
    assert len({cell["id"] for cell in CELLS}) == len(CELLS)
    for cell in CELLS:
        if cell["cell_type"] == "code":
            assert cell["outputs"] == [] and cell["execution_count"] is None
