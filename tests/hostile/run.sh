#!/usr/bin/env bash
# SPDX-FileCopyrightText: The latticed authors
# SPDX-License-Identifier: Apache-2.0
#
# usage: run.sh BUILD [OPTION OF hostile.py…]
# Attacks the server in BUILD. Without Debian's Python modules or HAProxy it exits with 77 (skipped), or fails if
# LATTICED_REQUIRE_PYTHON or LATTICED_REQUIRE_HAPROXY is set.
set -euo pipefail
root=$(cd "$(dirname "$(readlink -f "$0")")/../.." && pwd)
build=$(readlink -f "$1")
shift
export PATH=$PATH:/usr/sbin  # Debian installs HAProxy there

missing=()
/usr/bin/python3 -c 'import grpc, google.protobuf, setuptools' 2>/dev/null ||
  missing+=("python3-grpcio, python3-protobuf or python3-setuptools")
for program in haproxy openssl; do command -v "$program" >/dev/null || missing+=("$program"); done
if ((${#missing[@]})); then
  echo "skipped, missing: ${missing[*]}"
  [[ -n ${LATTICED_REQUIRE_PYTHON:-}${LATTICED_REQUIRE_HAPROXY:-} ]] && exit 1
  exit 77
fi

work=$build/hostile
mkdir -p "$work"
(cd "$root/client/python" && /usr/bin/python3 setup.py -q build_py --build-lib "$work/package" >"$work/package.txt" 2>&1) ||
  { cat "$work/package.txt"; exit 1; }
export PYTHONPATH=$work/package:$root/tests/support PYTHONDONTWRITEBYTECODE=1 LATTICED_BUILD=$build GRPC_VERBOSITY=NONE
exec /usr/bin/python3 "$root/tests/hostile/hostile.py" "$@"
