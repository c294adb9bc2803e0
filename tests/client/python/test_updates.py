# SPDX-FileCopyrightText: The latticed authors
# SPDX-License-Identifier: Apache-2.0
import dataclasses
import logging
import os
import sys
import sysconfig
import types
from pathlib import Path

import latticed
import numpy as np
import pytest
from latticed import draco
from latticed.chunk import octahedral_normals

import definition

ROOT = Path(os.environ["LATTICED_ROOT"])
RAW = latticed.View(encoding="raw")
# The error of vertices, which are evaluated in single precision: coordinates are at most 5.
FLOAT32 = 5e-6


def test_the_identity_is_the_mesh(scene):
    update = scene.get_update(latticed.View(segments=3, encoding="raw"))

    assert update.final and update.revision == 0
    assert update.points.shape == (scene.patches, 10, 3)
    assert update.triangles.shape == (9 * scene.patches, 3)
    assert definition.area(update) == pytest.approx(definition.BOX_AREA, abs=1e-5)
    at_face = np.isclose(update.points, 0, atol=1e-6) | np.isclose(update.points, [2, 1, 3], atol=1e-6)
    assert at_face.any(axis=-1).all()
    np.testing.assert_allclose(update.points.reshape(-1, 3).max(axis=0), [2, 1, 3], atol=1e-6)


def test_every_point_is_where_the_definition_puts_its_source(scene, random):
    lattice = scene.lattice()
    lattice.control_points += random.normal(scale=0.2, size=lattice.control_points.shape)
    scene.replace(lattice.control_points)
    update = scene.get_update(min_revision=1)
    source = scene.provenance(update)

    rest = source.interpolate(definition.BOX_POSITIONS[definition.BOX_FACES.reshape(-1)])

    expected = definition.deform(lattice, np.clip(rest.reshape(-1, 3), 0, [2, 1, 3]))
    assert 0 < update.step < 1e-3
    np.testing.assert_allclose(update.points.reshape(-1, 3), expected, atol=update.step / 2 + FLOAT32)


def test_encodings_agree(scene, random):
    lattice = scene.lattice()
    scene.replace(lattice.control_points + random.normal(scale=0.2, size=lattice.control_points.shape))

    raw = scene.get_update(latticed.View(encoding="raw", normals="facet"))
    fine = scene.get_update(latticed.View(encoding="quantised", normals="facet"))
    coarse = scene.get_update(
        latticed.View(encoding="quantised", normals="facet", position_bits=8, normal_bits=6)
    )

    assert raw.step == 0
    for update, bits, normal_bits in ((fine, 16, 12), (coarse, 8, 6)):
        assert (update.view.encoding, update.view.position_bits) == ("quantised", bits)
        np.testing.assert_allclose(update.points, raw.points, atol=update.step / 2 + FLOAT32)
        np.testing.assert_allclose(update.relative_points + update.origin, update.points, atol=1e-5)
        # Rounding costs half a cell in y and z and at most one in x. The vector's length is at least 1 / sqrt(3).
        assert np.linalg.norm(update.normals - raw.normals, axis=-1).max() < 18**0.5 / (
            2**normal_bits - 2
        )
    assert coarse.bytes < raw.bytes


@pytest.mark.parametrize(
    "ask, text",
    [
        (lambda client, scene: scene.get_update(latticed.View(encoding="zip")), "'zip'"),
        (lambda client, scene: scene.get_update(latticed.View(normals="flat")), "'flat'"),
        (lambda client, scene: client.create_scene(scene.info.mesh, pipeline="fast"), "pipeline is one of"),
    ],
)
def test_an_unknown_word_is_a_value_error(client, scene, ask, text):
    with pytest.raises(ValueError, match=text):
        ask(client, scene)


@pytest.fixture
def without_decoder(monkeypatch):
    monkeypatch.setitem(sys.modules, "DracoPy", None)
    monkeypatch.setitem(sys.modules, "latticed._decoder", None)
    monkeypatch.delattr(latticed, "_decoder", raising=False)
    draco.draco_py.cache_clear()
    draco.say_that_it_is_missing.cache_clear()
    yield
    draco.draco_py.cache_clear()


def test_without_a_decoder_updates_are_quantised_and_that_is_logged_once(
    client, box, without_decoder, caplog
):
    caplog.set_level(logging.INFO, "latticed")
    with client.create_scene(box, delete_on_exit=True) as scene:
        assert scene.default_view.encoding == "draco"
        assert scene.encoding == "quantised"
        assert scene.get_update().view.encoding == "quantised"
        with pytest.raises(ValueError, match="build the package with g"):
            scene.get_update(latticed.View(encoding="draco"))
        with pytest.raises(ValueError, match="encoding 'meshopt' needs a decoder"):
            scene.get_update(latticed.View(encoding="meshopt"))
    assert [r.message[:39] for r in caplog.records if r.name == "latticed"] == [
        "this package was built without its deco"
    ]


@pytest.fixture
def own():
    """The package's decoder. run_tests.sh has built it if there are a compiler and Python's headers."""
    has_headers = (Path(sysconfig.get_path("include")) / "Python.h").exists()
    if draco.own_decoder() is None and not has_headers and "LATTICED_REQUIRE_PYTHON" not in os.environ:
        pytest.skip("no Python.h: the package has no decoder")
    assert draco.own_decoder() is not None
    return draco.own_decoder()


@pytest.mark.parametrize("encoding", ["draco", "draco_mesh", "meshopt"])
@pytest.mark.parametrize("normals", ["none", "facet", "smooth"])
@pytest.mark.parametrize("position_bits, normal_bits", [(12, 8), (16, 12)])
def test_the_packages_decoder_gives_the_same_integers(
    client, box, own, encoding, normals, position_bits, normal_bits
):
    view = latticed.View(normals=normals, position_bits=position_bits, normal_bits=normal_bits)
    with client.create_scene(box, delete_on_exit=True) as scene:
        quantised = scene.get_update(dataclasses.replace(view, encoding="quantised"))
        update = scene.get_update(dataclasses.replace(view, encoding=encoding))

    assert (scene.encoding, update.view.encoding) == ("draco", encoding)
    np.testing.assert_array_equal(update.points, quantised.points)
    if normals == "none":
        assert update.normals is None
    else:
        np.testing.assert_allclose(update.normals, quantised.normals, rtol=0, atol=4e-7)


def test_the_packages_decoder_leaves_other_streams_alone(own):
    positions, normals = np.zeros((3, 3)), np.zeros((3, 3), np.float32)

    assert own.decode((b"junk", b""), False, 12, 8, 1.0, (positions, positions), (normals, normals)) == [
        False,
        False,
    ]
    assert not positions.any() and not normals.any()
    assert own.decode((), True, 12, 0, 1.0, (), ()) == []


def test_streams_of_an_earlier_writer_decode_for_ever(own):
    """tests/client/decoder/golden_streams_test.cc describes the files."""
    folder = ROOT / "tests/client/golden"
    streams = [*folder.glob("*.drc"), *folder.glob("*.meshopt")]
    assert len(streams) == 18 + 10
    for stream in streams:
        count, position_bits, normal_bits = map(int, stream.stem.split("_")[1:4])
        expected = np.fromfile(stream.with_suffix(".points"), "<u2").reshape(count, 6)
        positions, normals = np.empty((count, 3)), np.empty((count, 3), np.float32)
        arrays = ((positions,), (normals,) if normal_bits else ())

        is_meshopt = stream.suffix == ".meshopt"
        bits = (position_bits, normal_bits)
        assert own.decode((stream.read_bytes(),), is_meshopt, *bits, 1.0, *arrays) == [True]

        np.testing.assert_array_equal(positions, expected[:, :3])
        if normal_bits:
            exact = octahedral_normals(expected[:, 4], expected[:, 5], normal_bits)
            np.testing.assert_allclose(normals, exact, rtol=0, atol=4e-7)


@pytest.mark.parametrize(
    "arguments, error",
    [
        (((b"",), False, 12, 0, 1.0, (), ()), "differ in number"),
        (((b"",), False, 12, 8, 1.0, (np.zeros((1, 3)),), ()), "differ in number"),
        (((b"",), False, 12, 0, 1.0, (np.zeros(2),), ()), "a wrong size"),
        (((b"",), False, 12, 8, 1.0, (np.zeros((2, 3)),), (np.zeros((1, 3), np.float32),)), "a wrong size"),
        (((b"",), False, 12, 0, 1.0, (np.zeros((65_536, 3)),), ()), "a wrong size"),
        ((("text",), False, 12, 0, 1.0, (np.zeros((1, 3)),), ()), "expected bytes"),
        (((b"",), False, 12, 0, 1.0, (b"read only",), ()), "read-only|not writable"),
        (([b""], False, 12, 0, 1.0, (), ()), "must be tuple"),
    ],
)
def test_arrays_that_do_not_fit_are_refused(own, arguments, error):
    with pytest.raises((ValueError, TypeError, BufferError), match=error):
        own.decode(*arguments)


class StandIn:
    """Stands in for DracoPy, which Debian does not package: returns what a decoder makes of the same integers."""

    def __init__(self, quantised):
        chunks = [quantised.topology.patches_of(chunk) for chunk in range(quantised.topology.chunks)]
        self._chunks = iter([(quantised.relative_points[c], quantised.normals[c]) for c in chunks])

    def decode(self, data):
        assert data[:5] == b"DRACO"
        positions, normals = (array.reshape(-1, 3) for array in next(self._chunks))
        return types.SimpleNamespace(points=positions, get_attribute_by_type={1: {"data": normals}}.get)

    class DracoPointCloud:
        get_attribute_by_type = None


def test_without_the_packages_decoder_dracopy_decodes(client, box, without_decoder, monkeypatch):
    with client.create_scene(box, delete_on_exit=True) as scene:
        quantised = scene.get_update(latticed.View(encoding="quantised"))
        monkeypatch.setitem(sys.modules, "DracoPy", StandIn(quantised))
        draco.draco_py.cache_clear()

        update = scene.get_update()

        assert (scene.encoding, update.view.encoding) == ("draco", "draco")
        np.testing.assert_array_equal(update.points, quantised.points)
        np.testing.assert_array_equal(update.normals, quantised.normals)
