#!/usr/bin/env bash
# SPDX-FileCopyrightText: The latticed authors
# SPDX-License-Identifier: Apache-2.0
#
# usage: gpu_test.sh [FOLDER]
# All tests that need a GPU, by the test programs in FOLDER (that of this script: an unpacked bundle's
# bin): the conformance suite with CUDA required, what only CUDA has, and parts of both under
# compute-sanitizer where it is installed. Needs no network and installs nothing.
set -euo pipefail
folder=${1:-$(dirname "$(readlink -f "$0")")}
export LATTICED_REQUIRE_BACKENDS=${LATTICED_REQUIRE_BACKENDS:-cpu,cuda}

failures=0
run() {  # NAME COMMAND…
  local name=$1 log start=$SECONDS
  shift
  log=$(mktemp)
  if "$@" >"$log" 2>&1 && ! grep -q '^\[==========\] 0 tests' "$log"; then
    printf '%-52s %4d s  %s\n' "$name" $((SECONDS - start)) "$(grep -E '^\[  PASSED' "$log" | tail -n 1)"
  else
    printf '%-52s FAILED\n' "$name"
    tail -n 60 "$log"
    failures=$((failures + 1))
  fi
  grep -E '^\[  SKIPPED \] [0-9]+ test' "$log" || true
  rm -f "$log"
}

nvidia-smi -L 2>/dev/null || echo "nvidia-smi says nothing of a GPU"
run "statuses, pinned memory" "$folder/cuda_backend_test" --gtest_filter='CudaStatusTest.*:PinnedMemoryTest.*'
run "memory, failed allocations, repeated bits" "$folder/cuda_backend_test" --gtest_filter='CudaMemory.*'
run "what views share, made at once" "$folder/cuda_backend_test" --gtest_filter='CudaSharing.*'
run "a device that is lost" "$folder/cuda_backend_test" --gtest_filter='CudaLost.*'
run "soak, 2,000 scenes that come and go" "$folder/cuda_backend_test" --gtest_filter='CudaSoak.*'
run "one scene on several devices" "$folder/cuda_backend_test" --gtest_filter='CudaSpanned.*'
run "Draco streams, byte for byte the host's" "$folder/cuda_backend_test" --gtest_filter='DeviceDracoWriterTest.*:RansEntry*'
for suite in view watertight accuracy spanned encoders; do
  run "conformance, $suite" "$folder/backend_${suite}_test" --gtest_filter='*cuda*:Backends.*'
done
# A benchmark's comparator, built where libepoxy was; skips where there is no OpenGL.
[[ -x $folder/bench_shaders_test ]] && run "tessellation shaders" "$folder/bench_shaders_test"

run "the server, by its command line" "$folder/gpu_server_test.sh" "$folder"

# Small sizes; and without the allocation that is meant to fail, which memcheck would report.
readonly sanitized=(
  cuda_backend_test '*-*MoreThanTheDevice*:*Cycles*:*Repeated*:*ManyScenes*:*AllSizes*:*AllPairs*:*LargestChunk*:CudaSoak.*:CudaLost.*'
  backend_view_test '*cuda*'
  backend_watertight_test '*QuantisedAfterRandomEdits/cuda*:*Attached*/cuda*'
  backend_accuracy_test '*AllDegreeMixes*/cuda*:*AllSegments*/cuda_*fused:*FillNoLanes*/cuda*:*PartlyAndWholly*/cuda*:*Collapsed*/cuda*'
  backend_encoders_test '*cuda*')
# The same kernels again, which racecheck takes minutes for.
readonly not_raced=(
  backend_watertight_test '*SmoothFloats*/cuda*'
  backend_spanned_test '*cuda*-*RealMeshes*')
if command -v compute-sanitizer >/dev/null; then
  for tool in memcheck racecheck initcheck synccheck; do
    only=() skipped='' programs=("${sanitized[@]}" "${not_raced[@]}")
    # Races are in kernels, which the tests of memory run by the hundred: racecheck takes minutes for
    # these, and for the products of cuBLAS, which are not ours.
    if [[ $tool == racecheck ]]; then
      only=(--kernel-name kns=latticed) skipped=':CudaMemory.*:CudaSpanned.EveryFailed*' programs=("${sanitized[@]}")
    fi
    for ((i = 0; i < ${#programs[@]}; i += 2)); do
      run "$tool, ${programs[i]}" compute-sanitizer --tool "$tool" "${only[@]}" --error-exitcode 1 \
        "$folder/${programs[i]}" --gtest_filter="${programs[i + 1]}$skipped"
    done
  done
else
  unchecked=', but nothing was checked with compute-sanitizer: it is not installed'
fi
((failures == 0)) || { echo "$failures failed"; exit 1; }
echo "all passed${unchecked:-}"
