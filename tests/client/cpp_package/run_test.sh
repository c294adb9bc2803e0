#!/usr/bin/env bash
# SPDX-FileCopyrightText: The latticed authors
# SPDX-License-Identifier: Apache-2.0
#
# usage: run_test.sh BUILD
# Installs the C++ client from BUILD, builds the example outside of the tree against the installed
# package, and runs it against a real server.
set -euo pipefail
here=$(dirname "$(readlink -f "$0")")
root=$(readlink -f "$here/../../..")
build=$(readlink -f "$1")
work=$build/cpp_package
installed=$work/installed/include/latticed
rm -rf "$work"
mkdir -p "$work"
fail() { echo "$*"; exit 1; }

cmake --install "$build" --component client --prefix "$work/installed" >"$work/install.txt"
[[ ! -e $work/installed/bin ]] || fail "the component holds programs"

# The tree's headers name each other from its root, the generated ones from theirs.
missing=$(grep -rhoP '^#include "\K[^"]+' "$installed" | sort -u | while read -r header; do
  case $header in
    core/* | client/* | google/rpc/*) [[ -f $installed/$header ]] || echo "$header" ;;
    latticed/*) [[ -f $work/installed/include/$header ]] || echo "$header" ;;
  esac
done)
[[ -z $missing ]] || fail "headers that installed ones include: $missing"

cp -r "$root/client/cpp/example" "$work/example"
cmake -S "$work/example" -B "$work/build" -G Ninja -DCMAKE_PREFIX_PATH="$work/installed" -DCMAKE_BUILD_TYPE=Debug \
  $(command -v ccache >/dev/null && echo -DCMAKE_CXX_COMPILER_LAUNCHER=ccache) >"$work/configure.txt" 2>&1 ||
  { cat "$work/configure.txt"; exit 1; }
cmake --build "$work/build"

"$build/client/cpp/latticectl" sample vase -o "$work/vase.obj"
"$here/../with_server.sh" "$build" "$work/build/drag" "$work/vase.obj" "$work/out.ply" | tee "$work/output.txt"
# The top of a fit is 0.05 of the longest edge above the mesh, which therefore rises by less than 1.
awk '/^at rest/ { rest = $NF } /^revision/ { steps += $2 + 0 == steps + 1; lifted = $NF - rest }
     END { exit !(steps == 10 && lifted > 0.5 && lifted < 1) }' "$work/output.txt" || fail "the drag went wrong"
head -c 3 "$work/out.ply" | grep -q ply || fail "no PLY was written"
