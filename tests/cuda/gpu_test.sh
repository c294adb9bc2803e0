#!/usr/bin/env bash
# SPDX-FileCopyrightText: The latticed authors
# SPDX-License-Identifier: Apache-2.0
#
# usage: gpu_test.sh [FOLDER]
#
# Runs all tests that need a GPU, with the test programs in FOLDER (default: the folder of this script, an
# unpacked bundle's bin): the conformance suite with CUDA required, the tests of CUDA only, and parts of both
# under compute-sanitizer if it is installed. Needs no network and installs nothing. With
# LATTICED_REQUIRE_SANITIZER=1 it fails at once if compute-sanitizer is not installed.
#
# $LATTICED_GPU_TESTS_AT_ONCE programs share the device, because they wait for the host more than for the
# device. Tests that look at the device's free memory, or lose the device, run alone.
set -euo pipefail
folder=${1:-$(dirname "$(readlink -f "$0")")}
export LATTICED_REQUIRE_BACKENDS=${LATTICED_REQUIRE_BACKENDS:-cpu,cuda}
readonly at_once=${LATTICED_GPU_TESTS_AT_ONCE:-$((1 + $(nproc) / 4))}

command -v compute-sanitizer >/dev/null || [[ ${LATTICED_REQUIRE_SANITIZER:-0} != 1 ]] ||
  { echo "LATTICED_REQUIRE_SANITIZER is 1, but compute-sanitizer is not installed" >&2; exit 1; }

work=$(mktemp -d)
trap 'jobs -rp | xargs -r kill 2>/dev/null || true; rm -rf "$work"' EXIT
run_alone() {  # NAME COMMAND…
  local name=$1 log start=$SECONDS passed=true
  shift
  log=$(mktemp -p "$work")
  { "$@" >"$log" 2>&1 && ! grep -q '^\[==========\] 0 tests' "$log"; } || passed=false
  # The lock keeps each program's results together.
  flock "$work/lock" bash -s "$name" "$passed" $((SECONDS - start)) "$log" "$work/failed" <<'END'
    if $2; then
      printf '%-52s %4d s  %s\n' "$1" "$3" "$(grep -E '^\[  PASSED' "$4" | tail -n 1)"
    else
      printf '%-52s FAILED\n' "$1"
      tail -n 60 "$4"
      echo "$1" >>"$5"
    fi
    grep -E '^\[  SKIPPED \] [0-9]+ test' "$4" || true
END
  rm -f "$log"
}
run() {  # NAME COMMAND…: waits until fewer than at_once programs run
  while (($(jobs -rp | wc -l) >= at_once)); do wait -n || true; done
  run_alone "$@" &
}

nvidia-smi -L 2>/dev/null || echo "nvidia-smi lists no GPU"
run_alone "a device that is lost" "$folder/cuda_backend_test" --gtest_filter='CudaLost.*'
run_alone "what is left of the device's memory, 2,000 scenes" "$folder/cuda_backend_test" --gtest_filter='CudaSoak.*'

readonly slowest='Watertight|Accuracy|View'  # they start first
suites=$("$folder/backend_test" --gtest_list_tests | sed -n 's/^Backends\/\([A-Za-z]*\)\.$/\1/p')
for suite in ${slowest//|/ } $(grep -vxE "$slowest" <<<"$suites"); do
  run "conformance, $suite" "$folder/backend_test" --gtest_filter="*/$suite.*cuda*:Backends.*"
done
run "memory, failed allocations, repeated bits" "$folder/cuda_backend_test" \
  --gtest_filter='CudaMemory.*:CudaRefusals.*:CudaPurposes.*:CudaPointsTest.*'
run "what views share, made at once" "$folder/cuda_backend_test" --gtest_filter='CudaSharing.*'
run "one scene on several devices" "$folder/cuda_backend_test" --gtest_filter='CudaSpanned.*'
run "Draco streams, byte for byte the host's" "$folder/cuda_backend_test" --gtest_filter='DracoCoderTest.*:RansEntry*:CodedBounds*'
run "meshopt streams, byte for byte the host's" "$folder/cuda_backend_test" --gtest_filter='MeshoptCoderTest.*:MeshoptDifferences.*'
run "statuses, pinned memory, bytes of edges" "$folder/cuda_backend_test" --gtest_filter='CudaStatusTest.*:PinnedMemoryTest.*:EdgeBytes.*'
# A benchmark's comparator, which is built where libepoxy is present. It skips without OpenGL.
[[ -x $folder/bench_shaders_test ]] && run "tessellation shaders" "$folder/bench_shaders_test"
run "the server, by its command line" "$folder/gpu_server_test.sh" "$folder"

# Small sizes, without the allocation that is meant to fail, because memcheck would report it.
readonly sanitized=(  # NAME PROGRAM FILTER …
  memory cuda_backend_test '*-*MoreThanTheDevice*:*Repeated*:*ManyScenes*:*AllSizes*:*AllPairs*:*LargestChunk*:CudaSoak.*:CudaLost.*'
  view backend_test '*/View.*cuda*'
  tolerance backend_test '*/Tolerance.*cuda*:*/ToleranceEncoding.*cuda*:*/EdgeBounds.*cuda*'
  points backend_test '*/Points.*cuda*-*EveryTime*'
  'turned lattices' backend_test '*/TurnedLattices.Three*/cuda_*:*/TurnedLattices.*Outside*/cuda_gemm:*/TurnedTolerance.*cuda*'
  watertight backend_test '*QuantisedAfterRandomEdits/cuda*:*Attached*/cuda*'
  accuracy backend_test '*AllDegreeMixes*/cuda*:*AllSegments*/cuda_*fused:*FillNoLanes*/cuda*:*PartlyAndWholly*/cuda*:*Collapsed*/cuda*')
# Runs the same kernels again, for which racecheck takes minutes.
readonly not_raced=(
  'large lattices' backend_test '*SmoothFloats*/cuda*:*AnyChunks*/cuda_fused'
  spanned backend_test '*/Spanned.*cuda*'
  'outside and sums' backend_test '*/OutsideLattices.*/cuda_fused:*/ParallelSums.*/cuda_fused:*/SumsOfGroups.*/cuda_gemm'
  'tolerances of several devices' backend_test '*/ToleranceBits.*cuda*:*/SpannedEdgeBounds.*cuda*')
sanitize() {  # RUN TOOL
  local only=() skipped='' programs=("${sanitized[@]}" "${not_raced[@]}") i
  # Races occur in kernels. The memory tests run hundreds of them, and racecheck would take minutes. The same
  # holds for the products of cuBLAS, which are not ours.
  if [[ $2 == racecheck ]]; then
    only=(--kernel-name kns=latticed) skipped=':CudaMemory.*:CudaRefusals.*:CudaSpanned.EveryFailed*' programs=("${sanitized[@]}")
  fi
  for ((i = 0; i < ${#programs[@]}; i += 3)); do
    "$1" "$2, ${programs[i]}" compute-sanitizer --tool "$2" "${only[@]}" --error-exitcode 1 \
      "$folder/${programs[i + 1]}" --gtest_filter="${programs[i + 2]}$skipped"
  done
}
if command -v compute-sanitizer >/dev/null; then
  for tool in racecheck memcheck synccheck; do sanitize run "$tool"; done
  wait
  # Beside other programs, initcheck can report that a kernel launched early has uninitialised control points,
  # although the kernel waits for them. It never does so when it runs alone.
  sanitize run_alone initcheck
else
  unchecked=', but nothing was checked with compute-sanitizer: it is not installed'
fi
wait
[[ ! -e $work/failed ]] || { echo "$(wc -l <"$work/failed") failed"; exit 1; }
echo "all passed in $SECONDS s${unchecked:-}"
