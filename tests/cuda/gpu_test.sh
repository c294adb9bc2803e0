#!/usr/bin/env bash
# SPDX-FileCopyrightText: The latticed authors
# SPDX-License-Identifier: Apache-2.0
#
# usage: gpu_test.sh [FOLDER]
# All tests that need a GPU, by the test programs in FOLDER (that of this script: an unpacked bundle's
# bin): the conformance suite with CUDA required, what only CUDA has, and parts of both under
# compute-sanitizer where it is installed. Needs no network and installs nothing. With
# LATTICED_REQUIRE_SANITIZER=1 nothing runs and it fails where compute-sanitizer is not installed.
#
# Programs run beside each other on the one device, $LATTICED_GPU_TESTS_AT_ONCE of them, for they wait
# for the host more than for it; but those alone that look at how much memory the device has left, or
# lose it.
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
  # Whole results, one after the other.
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
run() {  # NAME COMMAND…, as soon as there is room beside the others
  while (($(jobs -rp | wc -l) >= at_once)); do wait -n || true; done
  run_alone "$@" &
}

nvidia-smi -L 2>/dev/null || echo "nvidia-smi says nothing of a GPU"
run_alone "a device that is lost" "$folder/cuda_backend_test" --gtest_filter='CudaLost.*'
run_alone "what is left of the device's memory, 2,000 scenes" "$folder/cuda_backend_test" --gtest_filter='CudaSoak.*'

# What takes longest comes first.
for suite in Watertight Accuracy View Spanned; do
  run "conformance, $suite" "$folder/backend_test" --gtest_filter="*/$suite.*cuda*:Backends.*"
done
run "memory, failed allocations, repeated bits" "$folder/cuda_backend_test" \
  --gtest_filter='CudaMemory.*:CudaRefusals.*:CudaPurposes.*'
run "what views share, made at once" "$folder/cuda_backend_test" --gtest_filter='CudaSharing.*'
run "one scene on several devices" "$folder/cuda_backend_test" --gtest_filter='CudaSpanned.*'
run "Draco streams, byte for byte the host's" "$folder/cuda_backend_test" --gtest_filter='DeviceDracoWriterTest.*:RansEntry*'
run "statuses, pinned memory" "$folder/cuda_backend_test" --gtest_filter='CudaStatusTest.*:PinnedMemoryTest.*'
# A benchmark's comparator, built where libepoxy was; skips where there is no OpenGL.
[[ -x $folder/bench_shaders_test ]] && run "tessellation shaders" "$folder/bench_shaders_test"
run "the server, by its command line" "$folder/gpu_server_test.sh" "$folder"

# Small sizes; and without the allocation that is meant to fail, which memcheck would report.
readonly sanitized=(  # NAME PROGRAM FILTER …
  memory cuda_backend_test '*-*MoreThanTheDevice*:*Repeated*:*ManyScenes*:*AllSizes*:*AllPairs*:*LargestChunk*:CudaSoak.*:CudaLost.*'
  view backend_test '*/View.*cuda*'
  watertight backend_test '*QuantisedAfterRandomEdits/cuda*:*Attached*/cuda*'
  accuracy backend_test '*AllDegreeMixes*/cuda*:*AllSegments*/cuda_*fused:*FillNoLanes*/cuda*:*PartlyAndWholly*/cuda*:*Collapsed*/cuda*')
# The same kernels again, which racecheck takes minutes for.
readonly not_raced=(
  'large lattices' backend_test '*SmoothFloats*/cuda*:*AnyChunks*/cuda_fused'
  spanned backend_test '*/Spanned.*cuda*')
sanitize() {  # RUN TOOL
  local only=() skipped='' programs=("${sanitized[@]}" "${not_raced[@]}") i
  # Races are in kernels, which the tests of memory run by the hundred: racecheck takes minutes for
  # these, and for the products of cuBLAS, which are not ours.
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
  # Beside other programs, and never without them, initcheck says of a kernel that was launched early
  # that the control points it waited for are not there.
  sanitize run_alone initcheck
else
  unchecked=', but nothing was checked with compute-sanitizer: it is not installed'
fi
wait
[[ ! -e $work/failed ]] || { echo "$(wc -l <"$work/failed") failed"; exit 1; }
echo "all passed in $SECONDS s${unchecked:-}"
