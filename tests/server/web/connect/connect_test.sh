#!/usr/bin/env bash
# SPDX-FileCopyrightText: The latticed authors
# SPDX-License-Identifier: Apache-2.0
#
# usage: connect_test.sh LATTICED PROTOSET FOLDER NODE_MODULES
# The daemon, called by the client library of browsers, which the viewer's build has installed. Skips (77)
# where there is no node or no viewer, and fails there if LATTICED_REQUIRE_NODE is set.
set -euo pipefail
readonly latticed=$1 protoset=$2 folder=$3 modules=$4 here=$(dirname "$(readlink -f "$0")")

missing() {
  echo "no $1: connect-web is not tried"
  [[ -z ${LATTICED_REQUIRE_NODE:-} ]] && exit 77
  exit 1
}
command -v node >/dev/null || missing node
[[ -d $modules/@connectrpc/connect-web ]] || missing connect-web
mkdir -p "$folder"
ln -sfn "$modules" "$folder/node_modules"
cp "$here/connect_test.mjs" "$folder"  # packages are looked for beside the script
node "$folder/connect_test.mjs" "$latticed" "$protoset"
