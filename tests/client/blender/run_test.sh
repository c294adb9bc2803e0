#!/usr/bin/env bash
# SPDX-FileCopyrightText: The latticed authors
# SPDX-License-Identifier: Apache-2.0
#
# usage: run_test.sh BUILD
# Runs the add-on in Debian's Blender, without a window, against a real server, and takes files there and back. Without Blender or a Python
# module it exits with 77 (skipped), or fails if LATTICED_REQUIRE_BLENDER is set.
set -euo pipefail
here=$(dirname "$(readlink -f "$0")")
root=$(readlink -f "$here/../../..")
build=$(readlink -f "$1")
work=$build/blender
if ! command -v blender >/dev/null || ! /usr/bin/python3 -c 'import google.protobuf, grpc, numpy, setuptools' 2>/dev/null; then
  echo "skipped, missing: blender, or python3-grpcio, python3-protobuf, python3-numpy, python3-setuptools"
  [[ -n ${LATTICED_REQUIRE_BLENDER:-} ]] && exit 1
  exit 77
fi
rm -rf "$work"
mkdir -p "$work"
PATH=/usr/bin:$PATH "$root/client/blender/make_addon.py" "$work/latticed_blender.zip"
for test in drive_addon drive_result; do
  BLENDER_USER_CONFIG=$work/config BLENDER_USER_SCRIPTS=$work/scripts "$here/../with_server.sh" "$build" \
    blender --background --factory-startup --python-exit-code 1 --python "$here/$test.py" -- "$work/latticed_blender.zip"
done
mkdir "$work/files"
"$here/../with_server.sh" "$build" blender --background --factory-startup --python-exit-code 1 \
  --python "$here/round_trip.py" -- "$build/client/cpp/latticectl" "$work/files"
