#!/usr/bin/env bash
# SPDX-FileCopyrightText: The latticed authors
# SPDX-License-Identifier: Apache-2.0
#
# usage: run_tests.sh BUILD [PYTEST-ARGUMENT…]
# Tests the Python client against the programs in BUILD, with Debian's interpreter: no other python3 has Debian's
# modules. Without a module it exits with 77 (skipped), or fails if LATTICED_REQUIRE_PYTHON is set.
set -euo pipefail
root=$(cd "$(dirname "$(readlink -f "$0")")/../../.." && pwd)
build=$(readlink -f "$1")
shift

missing=$(/usr/bin/python3 - <<'MODULES' || echo "no /usr/bin/python3"
import importlib.util
names = {"grpc": "python3-grpcio", "google.protobuf": "python3-protobuf", "numpy": "python3-numpy",
         "pytest": "python3-pytest", "setuptools": "python3-setuptools", "wheel": "python3-wheel", "pip": "python3-pip"}
def has(name):
    try:
        return importlib.util.find_spec(name) is not None
    except ModuleNotFoundError:
        return False
print(*[package for name, package in names.items() if not has(name)])
MODULES
)
if [[ -n $missing ]]; then
  echo "skipped, missing: $missing"
  [[ -n ${LATTICED_REQUIRE_PYTHON:-} ]] && exit 1
  exit 77
fi

# The decoder is compiled for the package, and again for the wheel of a test.
if command -v ccache >/dev/null; then export CC="ccache ${CC:-cc}" CCACHE_BASEDIR=$root CCACHE_NOHASHDIR=1; fi
mkdir -p "$build/python"
(cd "$root/client/python" && /usr/bin/python3 setup.py -q build --build-lib "$build/python/package" >"$build/python/build.txt" 2>&1) ||
  { cat "$build/python/build.txt"; exit 1; }
export PYTHONPATH=$build/python/package:$root/client/blender PYTHONDONTWRITEBYTECODE=1 LATTICED_BUILD=$build LATTICED_ROOT=$root
export OPENBLAS_NUM_THREADS=1  # matrices are small: threads would mostly wait for each other
/usr/bin/python3 -m pytest -q -p no:cacheprovider --durations=5 "$@" "$root/tests/client/python"
