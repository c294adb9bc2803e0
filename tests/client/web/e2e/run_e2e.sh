#!/usr/bin/env bash
# SPDX-FileCopyrightText: The latticed authors
# SPDX-License-Identifier: Apache-2.0
#
# usage: run_e2e.sh LATTICED LATTICECTL WEB VIEWER NAME…: the programs, the viewer's build folder, the viewer, which tests
# Runs each NAME_e2e_test.ts, which tests the viewer in Chromium against the server. Chromium's headless shell is taken
# where it is installed: it needs a third less of the processor to start and to open a page. Without Chromium it exits
# with 77 (skipped), or fails if LATTICED_REQUIRE_CHROMIUM is set. Screenshots for people go to the folder
# LATTICED_SHOTS, if it is set: each waits for smooth edges, for which software draws many frames.
set -euo pipefail
export LATTICED=$1 LATTICECTL=$2 LATTICED_PAGE=$3/tests/page LATTICED_VIEWER=$4
export CHROMIUM=${CHROMIUM:-$(command -v chromium-headless-shell || command -v chromium || true)}

if [[ -z $CHROMIUM ]]; then
  echo "no chromium: the viewer is not tested"
  [[ -n ${LATTICED_REQUIRE_CHROMIUM:-} ]] && exit 1
  exit 77
fi
[[ -z ${LATTICED_SHOTS:-} ]] || mkdir -p "$LATTICED_SHOTS"
cd "$3"
node --test-reporter=spec tests/e2e/run_files.mjs "${@:5}"
