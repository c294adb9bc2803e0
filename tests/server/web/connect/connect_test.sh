#!/usr/bin/env bash
# SPDX-FileCopyrightText: The latticed authors
# SPDX-License-Identifier: Apache-2.0
#
# usage: connect_test.sh LATTICED PROTOSET FOLDER
# The daemon, called by the client library of browsers. Skips (77) where node or the packages are not
# to be had, and fails there if LATTICED_REQUIRE_NODE is set.
set -euo pipefail
readonly latticed=$1 protoset=$2 folder=$3 here=$(dirname "$(readlink -f "$0")")

missing() {
  echo "no $1: connect-web is not tried"
  [[ -z ${LATTICED_REQUIRE_NODE:-} ]] && exit 77
  exit 1
}
command -v node >/dev/null || missing node
if [[ ! -d $folder/node_modules/@connectrpc/connect-web ]]; then
  npm install --silent --no-fund --no-audit --prefix "$folder" @connectrpc/connect@2.1.2 \
    @connectrpc/connect-web@2.1.2 @bufbuild/protobuf@2.17.0 >/dev/null 2>&1 || missing connect-web
fi
cp "$here/connect_test.mjs" "$folder"  # packages are looked for beside the script
node "$folder/connect_test.mjs" "$latticed" "$protoset"
