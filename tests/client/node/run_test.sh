#!/usr/bin/env bash
# SPDX-FileCopyrightText: The latticed authors
# SPDX-License-Identifier: Apache-2.0
#
# usage: run_test.sh BUILD
# The Node example, its types checked, against a real server. Skips (77) where there is no node, or no
# packages are to be had, and fails there under LATTICED_REQUIRE_NODE.
set -euo pipefail
here=$(dirname "$(readlink -f "$0")")
root=$(readlink -f "$here/../../..")
build=$(readlink -f "$1")
work=$build/node/client/node
fail() { echo "$*"; exit 1; }
missing() {
  echo "no $1: the Node example is not run"
  [[ -z ${LATTICED_REQUIRE_NODE:-} ]] && exit 77
  exit 1
}

# A copy, so that nothing is made in the sources; the packages of an earlier run are kept.
command -v npm >/dev/null || missing npm
mkdir -p "$work"
ln -sfn "$root/proto" "$build/node/proto"
cp -r "$root/client/node/." "$work"
cd "$work"
if ! cmp -s package-lock.json node_modules/.lock; then
  npm ci --silent --no-fund --no-audit >npm.txt 2>&1 || { cat npm.txt; missing "packages"; }
  cp package-lock.json node_modules/.lock
fi
npm run --silent build

"$build/client/cpp/latticectl" sample vase -o "$build/node/vase.obj"
"$here/../with_server.sh" "$build" npm run --silent start -- "$build/node/vase.obj" | tee output.txt
# The lattice is fitted, with a margin: its top layer rises by 1, the surface by less. Revision 0 is at rest.
awk '/^revision/ { revisions += $2 + 0 == NR - 2; if (NR == 2) rest = $NF; points = $7; lifted = $NF - rest }
     END { exit !(revisions == 11 && points > 1000000 && lifted > 0.5 && lifted < 1) }' output.txt ||
  fail "the drag went wrong"

status=0
LATTICED_SERVER=127.0.0.1:1 node dist/drag.js "$build/node/vase.obj" >error.txt 2>&1 || status=$?
[[ $status == 1 ]] && grep -q '^drag: 14 UNAVAILABLE' error.txt || { cat error.txt; fail "no server: ended with $status"; }
