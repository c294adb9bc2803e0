#!/usr/bin/env bash
# SPDX-FileCopyrightText: The latticed authors
# SPDX-License-Identifier: Apache-2.0
#
# usage: run_test.sh BUILD
# The commands of README that no other test runs, as they stand there: "Your own mesh" and "From a
# browser", the latter on free ports. Skips (77) where there is no curl, and fails there under
# LATTICED_REQUIRE_CURL.
set -euo pipefail
root=$(cd "$(dirname "$(readlink -f "$0")")/../../.." && pwd)
build=$(readlink -f "$1")
if ! command -v curl >/dev/null; then
  echo "skipped, for want of curl"
  [[ -n ${LATTICED_REQUIRE_CURL:-} ]] && exit 1
  exit 77
fi
work=$build/readme
rm -rf "$work"
mkdir -p "$work"
ln -s "$build" "$work/build"
cd "$work"
fail() { echo "$*"; exit 1; }

# The first shell block under a heading.
commands() {  # HEADING
  awk -v heading="## $1" '/^## / { here = $0 == heading } /^```$/ { inside = 0 } inside { print }
    here && /^```sh$/ { inside = 1; here = 0 }' "$root/README.md"
}
free_port() {  # FIRST
  local port=$1
  while (exec 3<>"/dev/tcp/127.0.0.1/$port") 2>/dev/null; do ((++port)); done
  echo "$port"
}

commands "Your own mesh" >mesh.sh
grep -q '^latticectl apply ' mesh.sh || fail "README has no commands for a mesh"
bash -euo pipefail mesh.sh
[[ $(head -c 3 deformed.ply) == ply ]] || fail "they left no deformed.ply"

commands "From a browser" | sed "s/8081/$(free_port 8181)/; s/9090/$(free_port 9190)/" >browser.sh
grep -q '^curl .*/readyz' browser.sh || fail "README has no commands for a browser"
echo 'kill %1; wait' >>browser.sh
bash browser.sh >browser.txt 2>server.txt || true
grep -q '^ready' browser.txt && grep -q 'grpc-status: 0' browser.txt || { cat browser.txt server.txt; fail "no answer"; }
echo "README's commands do what it says"
