#!/usr/bin/env python3
# SPDX-FileCopyrightText: The latticed authors
# SPDX-License-Identifier: Apache-2.0
#
# usage: make_addon.py OUT.zip
# Packs the add-on and the Python client into a file that Blender's preferences can install.
import subprocess
import sys
import tempfile
import zipfile
from pathlib import Path

HERE = Path(__file__).resolve().parent
CLIENT = HERE.parent / "python"


def pack(folder, place, archive):
    for path in sorted(folder.rglob("*")):
        if path.is_file() and "__pycache__" not in path.parts:
            archive.write(path, f"{place}/{path.relative_to(folder)}")


def main(out):
    with tempfile.TemporaryDirectory() as built, zipfile.ZipFile(out, "w", zipfile.ZIP_DEFLATED) as archive:
        build = [sys.executable, "setup.py", "-q", "build", "--build-lib", built]
        subprocess.run(build, cwd=CLIENT, check=True)
        pack(HERE / "latticed_blender", "latticed_blender", archive)
        pack(Path(built) / "latticed", "latticed_blender/modules/latticed", archive)


if __name__ == "__main__":
    if len(sys.argv) != 2:
        sys.exit("usage: make_addon.py OUT.zip")
    main(Path(sys.argv[1]).resolve())
