#!/usr/bin/env bash
# SPDX-FileCopyrightText: The latticed authors
# SPDX-License-Identifier: Apache-2.0
#
# usage: run_example.sh BUILD
# Runs example_get_update.py against the programs in BUILD, with Debian's python3-grpcio. Generated
# modules, mesh and log go to BUILD/python.
set -euo pipefail
root=$(cd "$(dirname "$(readlink -f "$0")")/../.." && pwd)
build=$(readlink -f "$1")
googleapis=/usr/share/gocode/src/github.com/grpc-ecosystem/grpc-gateway/third_party/googleapis
port=${2:-50251}

# What the README shows is what runs here.
diff <(sed -n '/^```python$/,/^```$/{//!p}' "$root/README.md") \
  <(sed -n '/# \[README\]/,/# \[\/README\]/{//!s/^    //p}' "$root/client/python/example_get_update.py")

mkdir -p "$build/python"
(cd "$root/proto" && protoc -I . -I "$googleapis" --python_out="$build/python" --grpc_python_out="$build/python" \
  --plugin=protoc-gen-grpc_python="$(command -v grpc_python_plugin)" \
  latticed/v1/*.proto google/rpc/status.proto google/rpc/error_details.proto)

"$build/client/cpp/latticectl" sample vase -o "$build/python/vase.obj"
"$build/client/cpp/latticectl" lattice "$build/python/vase.obj" --size 4,4,4 --degree 2,2,2 -o "$build/python/L.json"
/usr/bin/python3 - "$build/python/L.json" <<'DRAG'
import json, sys
lattice = json.load(open(sys.argv[1]))
for top in range(48, 64):
    lattice["controlPoints"][3 * top] += 0.5
json.dump(lattice, open(sys.argv[1], "w"))
DRAG
"$build/server/latticed" --listen "127.0.0.1:$port" --backend cpu >"$build/python/latticed.txt" 2>&1 &
server=$!
trap 'kill "$server" && wait "$server" || true' EXIT
for _ in {1..100}; do
  "$build/client/cpp/latticectl" info --server "127.0.0.1:$port" >/dev/null 2>&1 && break
  sleep 0.1
done
# Debian's own interpreter: another python3 on PATH has no Debian modules.
PYTHONPATH="$build/python" /usr/bin/python3 "$root/client/python/example_get_update.py" "127.0.0.1:$port" \
  "$build/python/vase.obj" "$build/python/L.json"
