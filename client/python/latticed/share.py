# SPDX-FileCopyrightText: The latticed authors
# SPDX-License-Identifier: Apache-2.0
"""Shares of a scene: tokens for people who have none of the server."""
from __future__ import annotations

from dataclasses import dataclass, field
from datetime import datetime, timezone
from typing import Any

from latticed.v1 import share_pb2

ROLES = {"read": share_pb2.SHARE_ROLE_READ, "edit": share_pb2.SHARE_ROLE_EDIT}


@dataclass(frozen=True)
class Share:
    """One share. Whoever has its token may use the scene until `expires`, or until it is revoked."""

    id: str
    role: str  # "read" or "edit"
    creator: str  # as the server knows callers; empty: it has no tokens
    created: datetime
    expires: datetime
    token: str = field(default="", repr=False, compare=False)  # of Scene.share alone: the server keeps none

    @classmethod
    def from_proto(cls, share: Any, token: str = "") -> Share:
        role = "edit" if share.role == share_pb2.SHARE_ROLE_EDIT else "read"
        created, expires = (
            time.ToDatetime().replace(tzinfo=timezone.utc) for time in (share.create_time, share.expire_time)
        )
        return cls(share.share_id, role, share.creator, created, expires, token)
