# SPDX-FileCopyrightText: The latticed authors
# SPDX-License-Identifier: Apache-2.0
"""The honest clients: a process that calls GetScene and drags a control point, and one that comes anew each second."""
import multiprocessing
import queue
import threading
import time
import uuid
from dataclasses import dataclass, field

from server import ALICE

SCENE = "the-scene-of-alice"
CALLS_PER_S = DRAGS_PER_S = 20
PATIENCE_S = 5
READY_S = 30


@dataclass
class Window:
    """What happened in a span of time. Latencies are in ms, and count from when a call was due."""

    latencies: dict = field(default_factory=dict)  # by kind: "call", "update", "newcomer"
    failures: list = field(default_factory=list)
    gap_ms: float = 0  # longest time without an answer to a call

    def p95(self, kind):
        sorted_ms = sorted(self.latencies.get(kind, [])) or [0.0]
        return sorted_ms[min(len(sorted_ms) - 1, int(0.95 * len(sorted_ms)))]

    def slowest(self, kind):
        return max(self.latencies.get(kind, []), default=0.0)


class HonestClients:
    """Runs the clients in processes of their own. take() gives what happened since the last take()."""

    def __init__(self, address, ca=None):
        context = multiprocessing.get_context("spawn")
        self._pipes, self._processes = [], []
        for work in (drag_and_call, come_each_second):
            ours, theirs = context.Pipe()
            process = context.Process(target=run, args=(theirs, work, address, ca), daemon=True)
            process.start()
            self._pipes.append(ours)
            self._processes.append(process)
            if not ours.poll(READY_S) or ours.recv() != "ready":
                raise RuntimeError("the honest clients do not get started")

    def take(self):
        for pipe in self._pipes:
            pipe.send("take")
        taken, newcomer = [pipe.recv() for pipe in self._pipes]
        taken.latencies.update(newcomer.latencies)
        taken.failures += newcomer.failures
        return taken

    def stop(self):
        for process in self._processes:
            process.terminate()
            process.join()


class Record:
    """Calls that are due, and when they were answered. Unanswered calls count with their age."""

    def __init__(self):
        self._mutex = threading.Lock()
        self._window, self._due = Window(), {}
        self._last_answer = time.monotonic()

    def due(self, kind, key, when):
        with self._mutex:
            self._due[kind, key] = when

    def answered(self, kind, key, failure=None):
        with self._mutex:
            now = time.monotonic()
            when = self._due.pop((kind, key), None)
            if when is not None:
                self._window.latencies.setdefault(kind, []).append((now - when) * 1000)
            if failure:
                self._window.failures.append(f"{kind} {failure}")
            elif kind == "call":
                self._window.gap_ms = max(self._window.gap_ms, (now - self._last_answer) * 1000)
                self._last_answer = now

    def answered_up_to(self, kind, key):
        with self._mutex:
            keys = [k for (of, k) in self._due if of == kind and k <= key]
        for each in keys:
            self.answered(kind, each)

    def take(self):
        with self._mutex:
            taken, self._window = self._window, Window()
            now = time.monotonic()
            taken.gap_ms = max(taken.gap_ms, (now - self._last_answer) * 1000)
            for (kind, _), when in self._due.items():
                if now - when > 0.05:
                    taken.latencies.setdefault(kind, []).append((now - when) * 1000)
            return taken


def channel_to(address, ca):
    import grpc

    options = [("grpc.use_local_subchannel_pool", 1)]
    if ca is None:
        return grpc.insecure_channel(address, options)
    options.append(("grpc.ssl_target_name_override", "localhost"))
    with open(ca, "rb") as file:
        return grpc.secure_channel(address, grpc.ssl_channel_credentials(file.read()), options)


def on_schedule(per_second, act):
    """Acts at fixed times, and as soon as possible where it is late. `act` gets the number and when it was due."""
    start, number = time.monotonic(), 0
    while True:
        due = start + number / per_second
        time.sleep(max(0.0, due - time.monotonic()))
        act(number, due)
        number += 1


def words_of(error):
    return f"{error.code().name}: {error.details()[:60]}"


class Client:
    def __init__(self, address, ca, record):
        from latticed.v1 import mesh_pb2_grpc, scene_pb2_grpc

        self.address, self.ca, self.record = address, ca, record
        self.metadata = [("authorization", "Bearer " + ALICE)]
        channel = channel_to(address, ca)
        self.scenes = scene_pb2_grpc.SceneServiceStub(channel)
        self.meshes = mesh_pb2_grpc.MeshServiceStub(channel)
        self.edits = queue.SimpleQueue()

    def create_scene(self, meshes, scenes, obj, scene, timeout):
        from latticed.v1 import mesh_pb2, scene_pb2

        more = {"metadata": self.metadata, "timeout": timeout}
        header = mesh_pb2.MeshHeader(format=mesh_pb2.MESH_FORMAT_OBJ, total_bytes=len(obj))
        parts = [mesh_pb2.UploadMeshRequest(header=header), mesh_pb2.UploadMeshRequest(data=obj)]
        mesh = meshes.UploadMesh(iter(parts), **more).id
        scenes.CreateScene(scene_pb2.CreateSceneRequest(scene_id=scene, mesh=mesh), **more)
        return mesh

    def call(self, number, due):
        import grpc
        from latticed.v1 import scene_pb2

        self.record.due("call", number, due)
        failure = None
        try:
            request = scene_pb2.GetSceneRequest(scene=SCENE)
            self.scenes.GetScene(request, metadata=self.metadata, timeout=PATIENCE_S)
        except grpc.RpcError as error:
            failure = words_of(error)
        self.record.answered("call", number, failure)

    def drag(self, number, due):
        self.record.due("update", number + 1, due)
        self.edits.put(number + 1)

    def follow(self):
        """Streams the drags, and notes in which update each is seen. A stream that ends is a failure."""
        import grpc

        while True:
            try:
                for event in self.scenes.Deform(self.requests(), metadata=self.metadata):
                    if event.HasField("update_end"):
                        self.record.answered_up_to("update", event.update_end.applied_sequence)
                failure = "stream ended"
            except grpc.RpcError as error:
                failure = words_of(error)
            self.record.answered("stream", 0, failure)
            time.sleep(0.2)

    def requests(self):
        from latticed.v1 import edit_pb2, scene_pb2, view_pb2

        editor = str(uuid.uuid4())
        watch = scene_pb2.WatchRequest(
            scene=SCENE, editor_id=editor, max_unacked_updates=0, view=view_pb2.ViewOptions(segments=4)
        )
        yield scene_pb2.DeformRequest(watch=watch)
        while True:
            sequence = self.edits.get()
            batch = edit_pb2.EditBatch(scene=SCENE, editor_id=editor, sequence=sequence, structure_id=1)
            batch.gesture_id, batch.gesture_phase = "drag", edit_pb2.GESTURE_PHASE_UPDATE
            move = batch.edits.add().move_control_points
            move.indices.append(0)
            move.offset.x = 0.01 * (1 + sequence % 20)
            yield scene_pb2.DeformRequest(edit=batch)

    def come_anew(self, number, due):
        """Does on a new connection what a new user does: uploads, creates a scene, and watches one."""
        import grpc
        from latticed.v1 import mesh_pb2, mesh_pb2_grpc, scene_pb2, scene_pb2_grpc

        due = time.monotonic()
        self.record.due("newcomer", number, due)
        failure = None
        more = {"metadata": self.metadata, "timeout": PATIENCE_S}
        name, step = f"newcomer-{number:06}", "upload or scene"
        try:
            with channel_to(self.address, self.ca) as channel:
                meshes, scenes = mesh_pb2_grpc.MeshServiceStub(channel), scene_pb2_grpc.SceneServiceStub(
                    channel
                )
                mesh = self.create_scene(meshes, scenes, torus(6, 4, number), name, PATIENCE_S)
                step = "watch"
                events = scenes.Watch(scene_pb2.WatchRequest(scene=SCENE), **more)
                next(events)
                events.cancel()
                step = "delete"
                scenes.DeleteScene(scene_pb2.DeleteSceneRequest(scene=name), **more)
                meshes.DeleteMesh(mesh_pb2.DeleteMeshRequest(mesh=mesh), **more)
        except grpc.RpcError as error:
            failure = f"{step} {words_of(error)}"
        self.record.answered("newcomer", number, failure)


def torus(rings, sides, number=0):
    """An OBJ file of a torus. `number` makes its bytes others."""
    from math import cos, pi, sin

    lines = [f"# {number}"]
    for i in range(rings):
        for j in range(sides):
            a, b = 2 * pi * i / rings, 2 * pi * j / sides
            lines.append(f"v {(2 + cos(b)) * cos(a):.5f} {(2 + cos(b)) * sin(a):.5f} {sin(b):.5f}")
    for i in range(rings):
        for j in range(sides):
            corners = [(i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1)]
            lines.append("f " + " ".join(str(1 + (p % rings) * sides + q % sides) for p, q in corners))
    return ("\n".join(lines) + "\n").encode()


def drag_and_call(client):
    client.create_scene(client.meshes, client.scenes, torus(16, 8), SCENE, READY_S)
    return [
        client.follow,
        lambda: on_schedule(CALLS_PER_S, client.call),
        lambda: on_schedule(DRAGS_PER_S, client.drag),
    ]


def come_each_second(client):
    return [lambda: on_schedule(1, client.come_anew)]


def run(pipe, work, address, ca):
    record = Record()
    for act in work(Client(address, ca, record)):
        threading.Thread(target=act, daemon=True).start()
    pipe.send("ready")
    while pipe.recv() == "take":
        pipe.send(record.take())
