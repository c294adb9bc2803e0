#!/usr/bin/env bash
# SPDX-FileCopyrightText: The latticed authors
# SPDX-License-Identifier: Apache-2.0
#
# usage: run_test.sh BUILD
# Runs every fenced block of the READMEs beside a real server and checks the results, in a folder outside the tree that
# looks like the tree after ./dev run. A block that is neither run nor in `exempt` is a failure. If a tool is missing,
# its blocks are left out and the script exits with 77 (skipped), or fails under LATTICED_REQUIRE_PYTHON, _NODE, _CURL.
set -euo pipefail
here=$(dirname "$(readlink -f "$0")")
root=$(readlink -f "$here/../../..")
build=$(readlink -f "$1")
[[ ${2:-} == beside-a-server ]] || exec "$here/../with_server.sh" "$build" "$0" "$build" beside-a-server
fail() { echo "readme_test: $*"; exit 1; }
source "$root/tests/support/readme_blocks.sh"

declare -A exempt=(
  ["README.md, Quick start, 1"]="./dev ci runs ./dev run in a fresh copy of the tree, asks the address that it prints, and runs all tests"
  ["client/README.md, Rules for a client, 1"]="a diagram"
  ["client/decoder/README.md, client/decoder: Draco and meshopt chunks at memory speed, 1"]="a diagram"
  ["docker/README.md, Containers, 1"]="Docker's engine and a GPU; compose_test reads the file, container_test.sh brings it up"
  ["docker/README.md, The GPU image, without a registry, 1"]="a GPU and root; tests/docker/container_test.sh builds the image"
  ["docker/README.md, Several servers, 1"]="Docker's engine; compose_test reads the file"
  ["docker/README.md, Behind a proxy, and several servers, 1"]="tests/docker/shared_test.sh runs it, with other addresses"
  ["docker/README.md, Kubernetes, 1"]="a cluster; tests/docker/kubernetes checks the manifests"
  ["docker/README.md, Without Docker, without a registry, 1"]="tests/docker/container_test.sh runs it, where the image is"
  ["docker/README.md, Without Docker, without a registry, 2"]="tests/docker/container_test.sh runs it, where the image is"
)

python_modules=$(/usr/bin/python3 -c 'import ensurepip, google.protobuf, grpc, numpy, setuptools, wheel' 2>/dev/null && echo found || true)
has_python() { [[ -n $python_modules ]]; }
has_node() { type node npm >/dev/null 2>&1; }
has_curl() { type curl strings >/dev/null 2>&1; }
skipped=()
can_run() {  # TOOL NAME…: false without the tool, and notes the named blocks as skipped
  local require=LATTICED_REQUIRE_${1^^} name
  "has_$1" && return
  [[ -z ${!require:-} ]] || fail "this machine lacks what the blocks for $1 need"
  for name in "${@:2}"; do take "$name"; done
  skipped+=("${@:2}")
  return 1
}
shell() { bash -euo pipefail "$@"; }
free_port() {  # FIRST
  local port=$1
  while (exec 3<>"/dev/tcp/127.0.0.1/$port") 2>/dev/null; do ((++port)); done
  echo "$port"
}
# Expects ten updates of a drag that lifts the top of the fitted lattice by 1. Below its margin the surface rises less.
expect_lift() {
  awk '/^at rest|^revision 0:/ { rest = $NF } /^revision [1-9]/ { steps += $2 + 0 == steps + 1; lifted = $NF - rest }
       END { exit !(steps == 10 && lifted > 0.5 && lifted < 1) }' output.txt || fail "the drag went wrong"
}

own_mesh() {
  run "client/README.md, latticectl, 1" env -u LATTICED_SERVER bash -euo pipefail
  [[ $(head -c 3 deformed.ply) == ply ]] || fail "no deformed.ply"
}

picture() {
  run "README.md, Quick start, 2" shell
  [[ $(head -c 4 beam.png) == *PNG && $(stat -c %s beam.png) -gt 10000 ]] || fail "no picture in beam.png"
  grep -q '^exact.ply: 100 patches' output.txt || fail "another beam"
  PATH=$work/build/client/cpp:$PATH run "README.md, A tolerance, 1" shell  # in the shell of the block before
  [[ $(head -c 4 wireframes.png) == *PNG ]] || fail "no picture in wireframes.png"
  grep -q '^uniform.ply: 100 patches, 6,600 points' output.txt || fail "other points than README's by segments"
  grep -q '^tolerance.ply: 100 patches, 1,8[0-9][0-9] points.*within 0.0021 of' output.txt || fail "not README's points by tolerance"
  PATH=$work/build/client/cpp:$PATH run "README.md, Several lattices, 1" shell
  grep -q '^it is lattice 1:' output.txt && [[ $(head -c 3 turned.ply) == ply ]] || fail "no turned lattice"
}

python_client() {
  PIP_NO_INDEX=1 run "client/README.md, Python, 1" shell
  run "README.md, Quick start, 3" build/env/bin/python
  grep -q '^([0-9]*, 66, 3)' output.txt || fail "no update of the beam"
  run "client/README.md, Python, 2" build/env/bin/python
  grep -q '[0-9] patches, up to' output.txt && [[ $(head -c 4 deformed.glb) == glTF ]] || fail "no deformed.glb"
  run "client/README.md, Python, 3" build/env/bin/python
  grep -qE '^[0-9]{4,} points from [0-9]{3,} bytes$' output.txt || fail "no points from patches"
  run "client/python/README.md, Nested lattices, 1" build/env/bin/python
  grep -qF 'moved by up to 0.600' output.txt || fail "a parent carried its child elsewhere"
  run "client/python/README.md, Point sets, 1" build/env/bin/python
  grep -qF '(100000, 3) (100000, 3) (64, 3)' output.txt || fail "other points or gradients than README's"
}

cpp_client() {
  # These variables only save build time.
  CMAKE_BUILD_TYPE=Debug CMAKE_CXX_COMPILER_LAUNCHER=$(command -v ccache || true) CCACHE_BASEDIR=$work CCACHE_NOHASHDIR=1 \
    run "client/README.md, C++, 1" shell
  expect_lift
  [[ $(head -c 3 lifted.ply) == ply ]] || fail "no lifted.ply"
}

node_client() {
  npm_config_prefer_offline=true run "client/node/README.md, Drag, 1" shell
  expect_lift
  grep -qE '[0-9]{7} points' output.txt || fail "not all points were decoded"
  [[ ! -e build/client/decoder/wasm/decoder.wasm ]] ||  # where a compiler for WebAssembly was found
    node "$root/tests/client/node/draco_points_test.mjs" "$PWD/client/node" "$root/tests/client/golden" >decoded.txt ||
    fail "the example decodes something else: $(<decoded.txt)"
  node "$root/tests/client/node/effective_points_test.mjs" "$PWD/client/node" >effective.txt || fail "at a strength: $(<effective.txt)"
  node "$root/tests/client/node/evaluate_patches_test.mjs" "$PWD/client/node" >evaluated.txt ||
    fail "the example evaluates something else: $(<evaluated.txt)"
  local dragged
  dragged=$(awk '/^revision 10:/ { print $NF }' output.txt)

  run "client/node/README.md, Patches and backups, 1" shell
  [[ $(head -c 3 patches.ply) == ply ]] || fail "no patches.ply"
  # Curved patches have several triangles. The drag's points are on a grid of 12 bits.
  awk -v dragged="$dragged" '/^revision 1:/ { found = $7 > 5 * $3; off = $NF - dragged } END { exit !(found && off * off < 0.003 ^ 2) }' \
    output.txt || fail "the patches are not the surface of the drag"

  grep -q '^restored 0 meshes and 0 scenes; [1-9]' output.txt || fail "the backup of this server is not what it has"
  head -c 100 today.backup >cut.backup

  local status=0
  (cd client/node && node dist/backup.js restore ../../cut.backup) >output.txt 2>&1 || status=$?
  [[ $status == 1 ]] && grep -q 'is cut off; nothing was sent$' output.txt || fail "a cut backup: ended with $status: $(<output.txt)"
  status=0
  (cd client/node && LATTICED_SERVER=127.0.0.1:1 node dist/drag.js ../../my.obj) >output.txt 2>&1 || status=$?
  [[ $status == 1 ]] && grep -q '^drag: 14 UNAVAILABLE' output.txt || fail "no server: ended with $status: $(<output.txt)"
}

browser() {
  take "client/web/README.md, The viewer, 1"
  sed -i "s/8081/$(free_port 8181)/; s/9090/$(free_port 9190)/" block
  echo 'kill %1; wait' >>block
  bash block >output.txt 2>server.txt || true
  grep -q '^ready' output.txt && grep -q 'grpc-status: 0' output.txt || fail "no answer: $(cat output.txt server.txt)"
}

blender_addon() {
  run "client/blender/README.md, latticed for Blender, 1" shell
  [[ -s build/latticed_blender.zip ]] || fail "no add-on"
}

work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
mkdir -p "$work/build" "$work/client"
cp -r "$root"/client/{blender,cpp,decoder,node,python} "$work/client"
cp -r "$root"/{core,proto} "$work"
ln -s "$build"/{client,server,cmake_install.cmake} "$work/build"
printf '#!/bin/sh\n[ "$*" = "build latticed_client" ]  # which is built\n' >"$work/dev"
chmod +x "$work/dev"
export PATH=/usr/bin:$PATH  # only Debian's Python finds Debian's modules

cd "$root"
for readme in README.md client/README.md client/*/README.md docker/README.md; do read_blocks "$readme"; done
cd "$work"
for name in "${!exempt[@]}"; do
  take "$name"
  echo "== $name: exempt, ${exempt[$name]}"
done
own_mesh
if can_run python "README.md, Quick start, 2" "README.md, "{"A tolerance","Several lattices"}", 1"; then picture; fi
if can_run python "README.md, Quick start, 3" "client/README.md, Python, "{1,2,3} "client/python/README.md, "{"Nested lattices","Point sets"}", 1"; then python_client; fi
cpp_client
if can_run node "client/node/README.md, "{Drag,"Patches and backups"}", 1"; then node_client; fi
if can_run curl "client/web/README.md, The viewer, 1"; then browser; fi
if can_run python "client/blender/README.md, latticed for Blender, 1"; then blender_addon; fi
((${#blocks[@]} == 0)) || fail "neither run nor exempt: $(printf '\n  %s' "${!blocks[@]}")"
((${#skipped[@]} == 0)) || { printf 'not run here: %s\n' "${skipped[@]}"; exit 77; }
