# SPDX-FileCopyrightText: The latticed authors
# SPDX-License-Identifier: Apache-2.0
"""Presence between a stream that edits and one that watches."""
import time

import pytest

import latticed


def wait_for(condition):
    end = time.monotonic() + 60
    while not condition():
        assert time.monotonic() < end, "not in time"
        time.sleep(0.01)


def test_streams_see_each_other_until_they_end(scene):
    with scene.watch(editor_id="bob") as bob:
        with scene.deform(editor_id="alice") as alice:
            alice.show("Alice", 0x3366FF, selected=[4, 5], lattice=1)
            wait_for(lambda: bob.others)
            assert bob.others == {"alice": latticed.Presence("Alice", 0x3366FF, (4, 5), lattice=1)}
            bob.show("Bob")
            wait_for(lambda: alice.others)
            assert alice.others == {"bob": latticed.Presence("Bob")}
            with scene.watch() as late:
                wait_for(lambda: len(late.others) == 2)
        wait_for(lambda: not bob.others)


def test_streams_see_each_others_camera(scene):
    place = {"position": (0, -5, 1), "target": (0, 0, 1), "up": (0, 0, 1)}
    with scene.watch(editor_id="bob") as bob, scene.deform(editor_id="alice") as alice:
        for camera in (latticed.Camera(**place, fov_y=40), latticed.Camera(**place, height=2.5)):
            alice.show("Alice", camera=camera)
            wait_for(lambda: bob.others == {"alice": latticed.Presence("Alice", camera=camera)})
        bob.show("Bob", camera=camera)
        wait_for(lambda: alice.others == {"bob": latticed.Presence("Bob", camera=camera)})
        bob.show("Bob")
        wait_for(lambda: alice.others == {"bob": latticed.Presence("Bob")})
        for projection in ({}, {"fov_y": 40, "height": 1}):
            with pytest.raises(ValueError, match="either fov_y or height"):
                alice.show("Alice", camera=latticed.Camera(**place, **projection))


def test_streams_see_whom_others_follow(scene):
    with scene.watch(editor_id="bob") as bob, scene.deform(editor_id="alice") as alice:
        alice.show("Alice", following="bob")
        wait_for(lambda: bob.others == {"alice": latticed.Presence("Alice", following="bob")})
        bob.show("Bob", following="carol")
        wait_for(lambda: alice.others == {"bob": latticed.Presence("Bob", following="carol")})
        alice.show("Alice")
        wait_for(lambda: bob.others == {"alice": latticed.Presence("Alice")})
        with pytest.raises(latticed.LatticedError, match=r"presence\.following.*itself"):
            bob.show("Bob", following="bob")


def test_a_camera_that_shows_nothing_is_refused(scene):
    with scene.watch(editor_id="bob") as bob:
        camera = latticed.Camera((0, 0, float("nan")), (0, 0, 0), (0, 0, 1), fov_y=40)
        with pytest.raises(latticed.LatticedError, match=r"presence\.camera\.position.*NaN"):
            bob.show("Bob", camera=camera)


def test_a_stream_that_opens_again_shows_itself_again(scene):
    with scene.watch() as bob, scene.deform(editor_id="alice") as alice:
        alice.show("Alice")
        wait_for(lambda: bob.others)
        alice._call.cancel()  # like a broken connection
        wait_for(lambda: alice.reconnections == 1)
        alice.wait(alice.move([0], (1, 0, 0)))
        wait_for(lambda: bob.others == {"alice": latticed.Presence("Alice")})
