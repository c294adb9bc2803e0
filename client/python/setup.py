# SPDX-FileCopyrightText: The latticed authors
# SPDX-License-Identifier: Apache-2.0
#
# Builds the decoder of Draco chunks, where there are a C++20 compiler, Python's headers and Highway (Debian's g++, python3-dev and
# libhwy-dev); elsewhere the package works without it, and takes updates uncompressed.
#
# Adds modules that protoc generates to the package: latticed.v1 from ../../proto, and google.rpc for
# machines without googleapis-common-protos. Uses the protoc of grpcio-tools if that is installed, as in
# pip's own build environment, and otherwise protoc and grpc_python_plugin on PATH.
import importlib.metadata
import importlib.util
import os
import shutil
import subprocess
import sys
from pathlib import Path

from setuptools import Extension, setup
from setuptools.command.build_py import build_py

HERE = Path(__file__).resolve().parent
ROOT = HERE.parent.parent
PROTO = ROOT / "proto"
DEBIAN = Path("/usr/share/gocode/src/github.com/grpc-ecosystem/grpc-gateway/third_party/googleapis")


def has(module):
    try:
        return importlib.util.find_spec(module) is not None
    except ModuleNotFoundError:
        return False


def googleapis():
    """The folder that holds google/rpc/status.proto."""
    roots = [Path(os.environ["LATTICED_GOOGLEAPIS_DIR"])] if "LATTICED_GOOGLEAPIS_DIR" in os.environ else []
    if has("google.rpc"):
        roots += [
            Path(path).parent.parent
            for path in importlib.util.find_spec("google.rpc").submodule_search_locations
        ]
    for root in [*roots, DEBIAN]:
        if (root / "google/rpc/status.proto").is_file():
            return root
    sys.exit(
        "google/rpc/status.proto is missing: install googleapis-common-protos, or Debian's "
        "golang-github-grpc-ecosystem-grpc-gateway-dev, or set LATTICED_GOOGLEAPIS_DIR"
    )


def grpc_tools_version():
    return tuple(int(part) for part in importlib.metadata.version("grpcio-tools").split(".")[:2])


def compiler():
    """The command that compiles protos, with its own include folders."""
    if has("grpc_tools") and grpc_tools_version() >= (1, 51):  # Debian's version is from 2018
        import grpc_tools

        return [sys.executable, "-m", "grpc_tools.protoc", f"-I{Path(grpc_tools.__file__).parent}/_proto"]
    protoc, plugin = shutil.which("protoc"), shutil.which("grpc_python_plugin")
    if not (protoc and plugin):
        sys.exit(
            "no protoc with grpc_python_plugin: install grpcio-tools, or Debian's protobuf-compiler "
            "and protobuf-compiler-grpc"
        )
    return [protoc, f"--plugin=protoc-gen-grpc_python={plugin}"]


class BuildWithProtos(build_py):
    def run(self):
        # Otherwise files of an earlier build would be packed too.
        shutil.rmtree(Path(self.build_lib) / "latticed", ignore_errors=True)
        super().run()
        out, include = Path(self.build_lib).resolve(), googleapis()
        ours = sorted(str(path.relative_to(PROTO)) for path in PROTO.glob("latticed/v1/*.proto"))
        rpc = ["google/rpc/status.proto", "google/rpc/error_details.proto"]
        if "message ErrorInfo" not in (include / rpc[1]).read_text():
            rpc.append("google/rpc/error_info.proto")
        command = [*compiler(), f"-I{PROTO}", f"-I{include}"]
        (out / "latticed/googleapis").mkdir(parents=True, exist_ok=True)
        subprocess.check_call(
            [*command, f"--python_out={out}", f"--pyi_out={out}", f"--grpc_python_out={out}", *ours],
            cwd=PROTO,
        )
        subprocess.check_call([*command, f"--python_out={out}/latticed/googleapis", *rpc], cwd=PROTO)


DECODER = Extension(
    "latticed._decoder",
    ["decoder_module.cc", "../decoder/lanes/lane_kernel.cc"]
    + sorted(f"../decoder/{path.name}" for path in (ROOT / "client/decoder").glob("*.cc"))
    + sorted(f"../decoder/meshopt/{path.name}" for path in (ROOT / "client/decoder/meshopt").glob("*.cc")),
    include_dirs=[str(ROOT)],
    libraries=["hwy"],
    extra_compile_args=["-std=c++20", "-O3"],
    optional=True,
)

# Older versions of setuptools need the folder of setup.cfg's egg_base to exist.
(ROOT / "build" / "python").mkdir(parents=True, exist_ok=True)
os.chdir(HERE)
setup(
    packages=["latticed", "latticed.patches", "latticed.points"],
    package_data={"latticed": ["py.typed", "_decoder.pyi"]},
    ext_modules=[DECODER],
    cmdclass={"build_py": BuildWithProtos},
)
