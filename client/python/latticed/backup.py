# SPDX-FileCopyrightText: The latticed authors
# SPDX-License-Identifier: Apache-2.0
"""Copies meshes and scenes of a server to a file, and back. latticectl backup and restore use the same file:

    "latticed backup 1\\n" | size of a part, 32 bits, little-endian | the part, a BackupPart | size | part | …

The last part is the end, with the number of parts before it and the SHA-256 of all bytes before its size."""
from __future__ import annotations

import hashlib
import os
import struct
from dataclasses import dataclass, field
from typing import BinaryIO, Iterator, List, Sequence, Union

from google.protobuf.message import DecodeError

from latticed.connection import Connection
from latticed.errors import LatticedError
from latticed.retries import once, with_retries
from latticed.transfers import whole_file
from latticed.v1 import backup_pb2, server_pb2

_MAGIC = b"latticed backup 1\n"
_ANY_MAGIC = b"latticed backup "
_MOST_PART_BYTES = 1 << 20
_SIZE = struct.Struct("<I")
_CHANGED = "was changed since it was written"

PathLike = Union[str, "os.PathLike[str]"]


@dataclass
class BackedUp:
    """What a backup has."""

    meshes: int = 0
    scenes: int = 0
    bytes: int = 0  # of the file
    damaged: List[str] = field(default_factory=list)  # on the server, and left out: a sentence each


@dataclass(frozen=True)
class Restored:
    """What a restore has done."""

    meshes: int  # that are new
    scenes: int
    present_meshes: int  # that were there
    skipped_scenes: int
    damaged: int  # items that were damaged when the backup was made


def write_backup(connection: Connection, path: PathLike, scenes: Sequence[str]) -> BackedUp:
    """Writes the file anew in each attempt."""
    request = backup_pb2.BackupRequest(scenes=scenes)

    def attempt() -> BackedUp:
        with open(part_path, "wb") as file:
            done = _write(file, connection.backups.Backup(request, metadata=connection.metadata()))
            file.flush()
            os.fsync(file.fileno())
        return done

    with whole_file(path) as part_path:
        return with_retries(connection.reachability, attempt)


def read_backup(connection: Connection, path: PathLike, skip_existing: bool) -> Restored:
    """Checks all of the file, and sends it once, when the server answers: after an error, items are there that came before."""
    with open(path, "rb") as file:
        for _ in _parts(file, str(path)):
            pass
        connection.call(connection.server.GetServerInfo, server_pb2.GetServerInfoRequest())
        done = once(
            connection.address,
            lambda: connection.backups.Restore(
                _requests(file, str(path), skip_existing), metadata=connection.metadata()
            ),
        )
    return Restored(done.meshes, done.scenes, done.present_meshes, done.skipped_scenes, done.damaged)


def _write(file: BinaryIO, parts: Iterator[backup_pb2.BackupPart]) -> BackedUp:
    done, digest, has_end = BackedUp(), hashlib.sha256(_MAGIC), False
    done.bytes = file.write(_MAGIC)
    for part in parts:
        has_end = part.HasField("end")
        if has_end:
            part.end.sha256 = digest.hexdigest()
        elif part.HasField("item"):
            _count(part.item, done)
        message = part.SerializeToString()
        framed = _SIZE.pack(len(message)) + message
        digest.update(framed)
        done.bytes += file.write(framed)
    if not has_end:
        raise LatticedError.data_loss("the server sent less than all")
    return done


def _count(item: backup_pb2.BackupItem, done: BackedUp) -> None:
    kind = item.WhichOneof("id")
    if item.damage:
        done.damaged.append(f"{kind} {item.mesh or item.scene}: {item.damage}")
    elif kind == "mesh":
        done.meshes += 1
    else:
        done.scenes += 1


def _requests(file: BinaryIO, name: str, skip_existing: bool) -> Iterator[backup_pb2.RestoreRequest]:
    options = backup_pb2.RestoreOptions(skip_existing=skip_existing)
    yield backup_pb2.RestoreRequest(options=options)
    for part in _parts(file, name):
        yield backup_pb2.RestoreRequest(part=part)


def _parts(file: BinaryIO, name: str) -> Iterator[backup_pb2.BackupPart]:
    """All parts of the file, from its begin. DATA_LOSS if it is no backup, or not whole."""
    file.seek(0)
    magic = file.read(len(_MAGIC))
    if magic != _MAGIC:
        is_other = magic.startswith(_ANY_MAGIC)
        raise _damaged(name, "is a backup of another version" if is_other else "is no backup of latticed")
    digest, count = hashlib.sha256(magic), 0
    while True:
        size = file.read(_SIZE.size)
        if len(size) < _SIZE.size:
            raise _damaged(name, "is cut off")
        (length,) = _SIZE.unpack(size)
        if length > _MOST_PART_BYTES:
            raise _damaged(name, _CHANGED)
        message = file.read(length)
        if len(message) < length:
            raise _damaged(name, "is cut off")
        try:
            part = backup_pb2.BackupPart.FromString(message)
        except DecodeError as error:
            raise _damaged(name, _CHANGED) from error
        if part.HasField("end"):
            if part.end.sha256 != digest.hexdigest() or part.end.parts != count:
                raise _damaged(name, _CHANGED)
            if file.read(1):
                raise _damaged(name, "has bytes after its end")
            yield part
            return
        digest.update(size + message)
        count += 1
        yield part


def _damaged(name: str, what: str) -> LatticedError:
    return LatticedError.data_loss(f"{name} {what}; nothing was sent")
