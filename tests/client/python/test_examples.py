# SPDX-FileCopyrightText: The latticed authors
# SPDX-License-Identifier: Apache-2.0
import os
import re
import struct
import subprocess
import sys
import zipfile

from server_process import BUILD, LATTICECTL, ROOT

EXAMPLES = ROOT / "client/python/examples"


def run(*command, **options):
    return subprocess.run(command, check=True, capture_output=True, text=True, **options).stdout


def test_what_the_readme_shows_runs(server, tmp_path):
    shown = re.search(r"```python\n(.*?)```", (ROOT / "client/README.md").read_text(), re.S)[1]
    example = (EXAMPLES / "quickstart.py").read_text()
    assert re.search(r"# \[README\]\n(.*?)# \[/README\]", example, re.S)[1] == shown
    run(LATTICECTL, "sample", "vase", "-o", tmp_path / "my.obj")

    environment = {**os.environ, "LATTICED_SERVER": server.address}
    printed = run(sys.executable, "-W", "error", EXAMPLES / "quickstart.py", cwd=tmp_path, env=environment)

    patches, x, y, z = re.fullmatch(
        r"(\d+) patches, up to \[(\S+) (\S+) (\S+) ?\]\n", re.sub(" +", " ", printed)
    ).groups()
    assert int(patches) > 10000
    assert float(x) > 1.05 and 0.65 < float(y) < 0.7  # at rest the vase is round about the z axis
    assert (tmp_path / "deformed.glb").read_bytes()[:4] == b"glTF"


def test_the_twist_makes_a_picture(server, tmp_path):
    flags = ["--server", server.address, "--height", "60"]
    run(sys.executable, EXAMPLES / "twist.py", tmp_path / "twist.png", *flags)

    data = (tmp_path / "twist.png").read_bytes()
    width, height = struct.unpack(">II", data[16:24])
    assert data.startswith(b"\x89PNG") and height == 60 and width > 2 * height
    assert len(data) > 2000  # a blank picture is smaller


def test_a_wheel_is_built_without_a_network_and_leaves_nothing_in_the_sources(tmp_path):
    before = sorted((ROOT / "client/python").rglob("*"))

    offline = "--no-index --no-build-isolation --no-deps --no-cache-dir -q".split()
    environment = {key: value for key, value in os.environ.items() if not key.startswith("PIP_")}
    wheel = [sys.executable, "-m", "pip", "wheel", *offline, "-w", tmp_path, ROOT / "client/python"]
    run(*wheel, env=environment)

    (wheel,) = tmp_path.glob("latticed-*.whl")
    names = zipfile.ZipFile(wheel).namelist()
    built = [
        str(path.relative_to(BUILD / "python/package"))
        for path in (BUILD / "python/package/latticed").rglob("*.py*")
    ]
    assert set(built) <= set(names)
    assert sorted((ROOT / "client/python").rglob("*")) == before
