#!/usr/bin/env bash
# SPDX-FileCopyrightText: The latticed authors
# SPDX-License-Identifier: Apache-2.0
#
# usage: draco3d_test.sh WRITE_STREAMS FOLDER
# Our streams, decoded by the npm package draco3d. Skips (77) where node or the package is not to be
# had, and fails there if LATTICED_REQUIRE_NODE is set.
set -euo pipefail
readonly write_streams=$1 folder=$2 here=$(dirname "$(readlink -f "$0")")

missing() {
  echo "no $1: streams are not compared with npm's draco3d"
  [[ -z ${LATTICED_REQUIRE_NODE:-} ]] && exit 77
  exit 1
}
command -v node >/dev/null || missing node
if [[ ! -d $folder/node_modules/draco3d ]]; then
  npm install --silent --no-fund --no-audit --prefix "$folder" draco3d@1.5.9 >/dev/null 2>&1 || missing draco3d
fi
rm -rf "$folder/streams"
mkdir -p "$folder/streams"
"$write_streams" "$folder/streams"
node "$here/compare_streams.mjs" "$folder/streams" "$folder/node_modules"
