#!/usr/bin/env bash
# SPDX-FileCopyrightText: The latticed authors
# SPDX-License-Identifier: Apache-2.0
#
# usage: draco3d_test.sh WRITE_STREAMS FOLDER NODE_MODULES
# Decodes our streams with the npm package draco3d, which the viewer's build has installed. Without node or the
# package it skips (77), or fails if LATTICED_REQUIRE_NODE is set.
set -euo pipefail
readonly write_streams=$1 folder=$2 modules=$3 here=$(dirname "$(readlink -f "$0")")

missing() {
  echo "no $1: streams are not compared with npm's draco3d"
  [[ -z ${LATTICED_REQUIRE_NODE:-} ]] && exit 77
  exit 1
}
command -v node >/dev/null || missing node
[[ -d $modules/draco3d ]] || missing draco3d
rm -rf "$folder/streams"
mkdir -p "$folder/streams"
"$write_streams" "$folder/streams"
node "$here/compare_streams.mjs" "$folder/streams" "$modules"
