#!/usr/bin/env bash
# SPDX-FileCopyrightText: The latticed authors
# SPDX-License-Identifier: Apache-2.0
# against_blender.sh BUILD: compares Blender's lattice modifier (Debian's package blender) with latticed's CPU
# backend on about the same number of vertices, in turn, on two threads. Blender moves 1,129,969 vertices
# without normals and copies its mesh. latticed evaluates 1,134,672 exact points with normals.
set -euo pipefail
build=$1
here=$(dirname "$(readlink -f "$0")")
name=evaluate/torus-17k/fused/degree2/lane-order/facet/10segments/2t

printf '%12s %18s %14s %8s %16s\n' 'blender ms' 'without lattice' 'latticed ms' 'ratio' 'modifier alone'
for _ in 1 2 3; do
  read -r _ whole without < <(
    blender --background --factory-startup --threads 2 --python-exit-code 1 --python "$here/blender_lattice.py" 2>&1 |
      grep '^blender_lattice ' || echo "blender failed 0")
  [[ $whole != failed ]] || { echo "against_blender.sh: is the package blender installed?" >&2; exit 1; }
  ours=$("$build/tests/bench/latticed_bench" --benchmark_filter="$name" 2>/dev/null | awk -v name="$name" '$1 == name { print $2 }')
  awk -v a="$whole" -v b="$without" -v c="$ours" \
    'BEGIN { printf "%12.1f %18.1f %14.3f %8.0f %16.0f\n", a, b, c, a / c, (a - b) / c }'
done
