# SPDX-FileCopyrightText: The latticed authors
# SPDX-License-Identifier: Apache-2.0
"""usage: served_viewer.py URL

Fails unless a server has the viewer at the address: the page and the files that it loads, with the media types that
browsers require and the policy that confines the page. If the address names a scene (?scene=ID), it must exist.
"""

import re
import sys
import urllib.parse
import urllib.request

POLICY = {
    "default-src 'self'",
    "script-src 'self' 'wasm-unsafe-eval'",
    "worker-src 'self' blob:",
    "connect-src 'self' blob:",
}


def get(address, media_type, begins=b""):
    with urllib.request.urlopen(address, timeout=10) as answer:
        body = answer.read()
        assert answer.headers["content-type"] == media_type, (address, answer.headers["content-type"])
        assert answer.headers["x-content-type-options"] == "nosniff", address
        policy = set(answer.headers["content-security-policy"].split("; "))
        assert POLICY <= policy, (address, policy)
    assert body.startswith(begins) and len(body) > 100, (address, body[:100])
    return body.decode(errors="replace")


def get_scene(origin, scene):
    message = b"\x0a" + bytes([len(scene)]) + scene.encode()  # its first field
    framed = b"\0" + len(message).to_bytes(4, "big") + message
    request = urllib.request.Request(
        f"{origin}/latticed.v1.SceneService/GetScene", framed, {"content-type": "application/grpc-web+proto"}
    )
    with urllib.request.urlopen(request, timeout=10) as answer:
        body = answer.read()
    assert b"grpc-status: 0" in body and scene.encode() in body, (scene, body)


def main(address):
    page = get(address, "text/html; charset=utf-8", b"<!doctype html>")
    (style,) = re.findall(r'<link rel="stylesheet" href="([^"]+)"', page)
    (script,) = re.findall(r'<script type="module" src="([^"]+)"', page)
    get(urllib.parse.urljoin(address, style), "text/css; charset=utf-8")
    script = urllib.parse.urljoin(address, script)
    program = get(script, "text/javascript; charset=utf-8")
    for pattern, media_type, begins in (
        (r"decode_worker-\w+\.js", "text/javascript; charset=utf-8", b""),
        (r"\bdecoder-\w+\.wasm", "application/wasm", b"\0asm"),
        (r"draco_decoder-\w+\.wasm", "application/wasm", b"\0asm"),
    ):
        names = set(re.findall(pattern, program))
        assert len(names) == 1, f"{script} does not load one {pattern}: {names}"
        get(urllib.parse.urljoin(script, *names), media_type, begins)

    parts = urllib.parse.urlsplit(address)
    for scene in urllib.parse.parse_qs(parts.query).get("scene", []):
        get_scene(f"{parts.scheme}://{parts.netloc}", scene)
    print(f"{address}: the viewer, and its scene where one is named")


main(*sys.argv[1:])
