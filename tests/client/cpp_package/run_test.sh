#!/usr/bin/env bash
# SPDX-FileCopyrightText: The latticed authors
# SPDX-License-Identifier: Apache-2.0
#
# usage: run_test.sh BUILD
# Installs the C++ client's package from BUILD. Checks that it holds no programs, and every header that its
# headers include. readme_test builds README's example against an installed package.
set -euo pipefail
build=$(readlink -f "$1")
work=$build/cpp_package
installed=$work/installed/include/latticed
rm -rf "$work"
mkdir -p "$work"
fail() { echo "$*"; exit 1; }

cmake --install "$build" --component client --prefix "$work/installed" >"$work/install.txt"
[[ ! -e $work/installed/bin ]] || fail "the component holds programs"

# Paths of core/, client/ and google/rpc/ start in include/latticed; those of latticed/ (generated) in include.
missing=$(grep -rhoP '^#include "\K[^"]+' "$installed" | sort -u | while read -r header; do
  case $header in
    core/* | client/* | google/rpc/*) [[ -f $installed/$header ]] || echo "$header" ;;
    latticed/*) [[ -f $work/installed/include/$header ]] || echo "$header" ;;
  esac
done)
[[ -z $missing ]] || fail "headers that installed ones include: $missing"
