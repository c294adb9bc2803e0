#!/usr/bin/env bash
# SPDX-FileCopyrightText: The latticed authors
# SPDX-License-Identifier: Apache-2.0
#
# usage: finds_violations_test.sh ROOT
# Puts bad files into a copy of the sources. The layering test must name each of them.
set -euo pipefail
root=$1
copy=$(mktemp -d)
trap 'rm -rf "$copy"' EXIT
(cd "$root" && cp -r core cuda server client tests proto dev .ci "$copy")

readonly licence='// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0'

bad=()
expect_violation() {  # FILE TEXT
  mkdir -p "$copy/$(dirname "$1")"
  [[ ! -e $copy/$1 ]] || { echo "$1 is a source"; exit 1; }
  printf '%s\n' "$2" >"$copy/$1"
  bad+=("$1")
}

expect_violation core/base/bad.h "$licence
#include \"core/ffd/lattice.h\""
expect_violation core/ffd/bad.cc "$licence
#include <grpcpp/grpcpp.h>"
expect_violation cuda/bad.cc "$licence
#  include \"core/cpu/cpu_backend.h\""
expect_violation cuda/bad.cu "$licence
#include \"absl/status/status.h\""
expect_violation cuda/device/bad.cc "$licence
  static_cast<void>(cudaDeviceSynchronize());"
expect_violation cuda/gemm/bad.cu "$licence
  cudaFree(samples);"
expect_violation client/cpp/library/bad.cc "$licence
#include \"server/in_process.h\""
expect_violation client/cpp/latticectl/bad.cc "$licence
#include \"client/cpp/load/load_run.h\""
expect_violation client/cpp/latticectl/geometry/bad.cc "$licence
#include \"client/cpp/latticectl/session/session.h\""
expect_violation server/bad.cc "$licence
#ifdef LATTICED_CUDA"
expect_violation server/web_bad.cc "$licence
#include <boost/asio.hpp>"
expect_violation server/web/bad.cc "$licence
#include \"core/ffd/lattice.h\""
expect_violation server/unlicensed.h '#pragma once'
expect_violation core/mesh/long.cc "$licence
$(seq -f '// %g' 400)"
expect_violation client/web/src/long.ts "$licence
$(seq -f '// %g' 400)"

if bash "$root/tests/layering_test/layering_test.sh" "$copy" >"$copy/out.txt"; then
  echo "nothing is noticed"
  exit 1
fi
for file in "${bad[@]}"; do
  grep -q "^$file:" "$copy/out.txt" || { echo "$file is not named in:"; cat "$copy/out.txt"; exit 1; }
done
grep -q "^${#bad[@]} violations$" "$copy/out.txt" || { echo "a good file is named, too:"; cat "$copy/out.txt"; exit 1; }
echo "every kind of violation is noticed"
