# SPDX-FileCopyrightText: The latticed authors
# SPDX-License-Identifier: Apache-2.0
#
# The steps of ./dev ci. ./dev sources this file and defines the functions that the steps call.
readonly ci_build=build/ci/tree/build
readonly tsan_targets=(scene_engine_test engine_rooms_test model_based_test store_test)
# Tests that the Release build alone runs. They check accuracy or memory on large inputs, or take minutes with sanitizers.
# All pipelines of the CPU run the suite View. The GEMM ones share code, so one of them runs the accuracy tests. Spans
# are evaluated by the fused one, which runs them too. It also runs Watertight, without its three longest tests. Of the
# tests of Spanned the two shorter ones run. Of the bits, bounds and streams of tolerances, tests that make edits run.
# Half of the mixed sessions run.
readonly unsanitized="*RealMesh*:*ThousandEdits*:*LargeLattice*:*HundredThousand*:*Keeps64MiB*:*BitsAndShapesTogether*\
:*ExportMemoryTest.*:*OutsideLattices*/cpu_gemm12:*OutsideLattices*/cpu_control_net:*ParallelSums*/cpu_gemm12\
:*ParallelSums*/cpu_control_net:*Watertight*/cpu_gemm*:*Watertight*/cpu_control_net:*Accuracy*/cpu_gemm12\
:*Accuracy*/cpu_spanned_fused:*Watertight*/cpu_spanned_fused:*QuantisedAfterRandomEdits/cpu_fused:*SmoothFloatsAfterRandomEdits/cpu_fused\
:*StoreKill.*:*StorePowerLoss.*\
:*Watertight.FewChunksOfManyHaveTheSameBits*:*Spanned.WholeEvaluationsHaveTheBitsOfOneDevice*\
:*DevicesDoNotChangeABitOfAWholeEvaluation*:*EdgeBounds.AfterAnyEdits*/cpu_spanned_fused:*ToleranceEncoding.StreamsAreThose*\
:*MixedSessions*/1:*MixedSessions*/3:*MixedSessions*/5:*MixedSessions*/7\
:*TablesOfManyBoxesWouldTakeTooMuchMemory:*CertificatesEndWhereFoldsBegin:*TurnedFolds.ReportsAgreeWithSamplesOfTheDefinition\
:TurnedVolume.NoCertificateIsWrong*:MeasuresByPatches.HaveTheSameBitsOnAnyNumberOfThreads"

source .ci/node_18.sh

ci_step=
step() {  # NAME COMMAND…: runs the command and records its time; a failure ends the run
  local log start=$SECONDS
  ci_step=$1
  shift
  log=build/ci/${ci_step//[^A-Za-z0-9]/-}.txt
  printf '%-44s' "$ci_step"
  ("$@") >"$log" 2>&1 || { echo "FAILED"; tail -n 150 "$log"; die "$ci_step failed; full log: $log"; }
  printf '%7d  %s\n' $((SECONDS - start)) "$ci_step" >>build/ci/seconds.txt
  echo "$((SECONDS - start)) s$(grep -qsF "$ci_step: " build/ci/skipped.txt && echo ', NOT RUN')"
}
# Starts a step that runs in parallel with the next ones. `joined` waits for all such steps and prints their output.
ci_beside=()
beside() {  # NAME COMMAND…
  (step "$@") >"build/ci/beside-${#ci_beside[@]}.txt" 2>&1 &
  ci_beside+=($!)
}
joined() {
  local i status
  for i in "${!ci_beside[@]}"; do
    status=0
    wait "${ci_beside[i]}" || status=$?
    cat "build/ci/beside-$i.txt"
    ((status == 0)) || exit "$status"
  done
  ci_beside=()
}
at_leisure() {  # COMMAND…: runs it at the lowest priority
  renice -n 19 "$BASHPID" >/dev/null
  "$@"
}
not_run() {  # WHY: this machine cannot run the step; printed after the step, and at the end of the run
  printf '%s: %s\n' "$ci_step" "$*" | tee -a build/ci/skipped.txt
}

# Runs ./dev run in a copy of the working tree without build outputs, as a new user does. Checks that the printed
# address shows the sample, also in Chromium. A second run then stops that server and its own.
ci_fresh_run() {
  mkdir -p build/ci/tree
  [[ -d ../shared ]] && ln -sfn "$(readlink -f ../shared)" build/ci/shared
  sources | tar -cf - -T - | tar -xf - -C build/ci/tree
  build/ci/tree/dev run | tee build/ci/run.txt
  local status=0 address
  address=$(sed -n 's/^ *in a browser *//p' build/ci/run.txt)
  /usr/bin/python3 tests/support/served_viewer.py "$address" || status=$?
  CHROMIUM=${CHROMIUM:-$(command -v chromium-headless-shell || command -v chromium)} LATTICED_REQUIRE_CHROMIUM=1 \
    node tests/support/opened_viewer.mjs "$ci_build/client/web" "$address" || status=$?
  build/ci/tree/dev run --once && return $status
}
# Prints how many tests of a build were skipped, by reason: CTest does not see the cases that an entry skips.
skipped_tests() {  # FOLDER
  awk '/: Skipped$/ { getline reason; ++count[reason] } END { for (r in count) printf "%7d  skipped: %s\n", count[r], r }' \
    "$1/Testing/Temporary/LastTest.log" | sort -rn
}
# ci_ctest FOLDER ARGUMENTS…: runs ctest, and prints what was skipped, or failed tests once more.
ci_ctest() {
  local folder=$1 failed=$1/Testing/Temporary/LastTestsFailed.log
  ctest --test-dir "$folder" --output-on-failure -j "$jobs" "${@:2}" && skipped_tests "$folder" && return
  awk 'NR == FNR { sub(/^[0-9]+:/, ""); failed[$0]; next }
    / Testing: / { name = $0; sub(/^[^:]*: /, "", name); isShown = name in failed }
    isShown' "$failed" "$folder/Testing/Temporary/LastTest.log"
  printf 'failed: %s\n' "$(paste -sd ' ' "$failed")"
  return 1
}
ci_tests() {
  LATTICED_REQUIRE_OPENGL=1 LATTICED_REQUIRE_PYTHON=1 LATTICED_REQUIRE_NODE=1 LATTICED_REQUIRE_GO=1 \
    LATTICED_REQUIRE_BLENDER=1 LATTICED_REQUIRE_CHROMIUM=1 LATTICED_REQUIRE_CURL=1 LATTICED_REQUIRE_HAPROXY=1 \
    LATTICED_REQUIRE_POSTGRES=1 \
    ci_ctest "$ci_build" -j $((2 * jobs))  # tests wait half of their time
}
configure_sanitized() {  # KIND OPTIONS…
  configure "build/ci/$1" -DCMAKE_BUILD_TYPE=None -DCMAKE_CXX_FLAGS="-O1 -fno-omit-frame-pointer" \
    -DLATTICED_SANITIZE="$1" -DLATTICED_CUDA=OFF "${@:2}"
}
build_sanitized() {
  # By clang, whose build serves the fuzzers too.
  (export CC=clang-14 CXX=clang++-14 && configure_sanitized address -DLATTICED_FUZZ=ON) &&
    build build/ci/address latticed_tests latticed_fuzz &&
    configure_sanitized thread &&
    build build/ci/thread "${tsan_targets[@]}"
}
test_sanitized() {  # KIND TESTS: those that match the regular expression
  ASAN_OPTIONS=detect_leaks=1 UBSAN_OPTIONS=print_stacktrace=1 \
    TSAN_OPTIONS="suppressions=$PWD/tests/support/tsan.supp" \
    GTEST_FILTER="-$unsanitized" \
    ci_ctest "build/ci/$1" -j $((2 * jobs)) -R "$2" -E 'layering|bench_'
}
ci_asan() { test_sanitized address .; }
ci_tsan() { test_sanitized thread "^($(IFS='|'; echo "${tsan_targets[*]}"))[.]"; }
ci_fuzz() { tests/fuzz/campaign.sh build/ci/address/tests/fuzz tests/fuzz/corpus build/ci/fuzz 5 "$jobs"; }
# Keeps what it finds in build/fuzz/work, and goes on from there the next time.
verb_fuzz() {  # [SECONDS]
  need "compilers, libraries, fuzzers" "${build_packages[@]}" "${check_packages[@]}"
  CC=clang-14 CXX=clang++-14 configure build/fuzz -DCMAKE_BUILD_TYPE=None -DCMAKE_CXX_FLAGS=-O1 \
    -DLATTICED_FUZZ=ON -DLATTICED_SANITIZE=address -DLATTICED_CUDA=OFF -DBUILD_TESTING=OFF
  build build/fuzz latticed_fuzz
  say "each target runs for ${1:-60} s, $jobs processes at a time; logs and failures in build/fuzz/work"
  tests/fuzz/campaign.sh build/fuzz/tests/fuzz tests/fuzz/corpus build/fuzz/work "${1:-60}" "$jobs"
}
# Some sandboxes forbid mounts and namespaces. The step is not run there, and CI says so at its end, unless
# LATTICED_REQUIRE_CONTAINER is set: then it fails. Where containers are allowed, every error fails the step.
ci_container() {
  local why
  if ! why=$(unshare --mount --pid --fork --mount-proc true 2>&1) && [[ -z ${LATTICED_REQUIRE_CONTAINER:-} ]]; then
    not_run "this machine allows no containers: $why"
    return
  fi
  local toolkit
  toolkit=$(cuda_toolkit)
  tests/docker/container_test.sh build/ci/container $toolkit || return
  [[ -n $toolkit ]] || not_run "the GPU image is not built: this machine has no nvcc"
  [[ ! -f build/ci/container/not_run.txt ]] || not_run "$(<build/ci/container/not_run.txt)"
}
# Prints the folder of nvcc's toolkit, where there is one. nvcc itself may be a link or a script.
cuda_toolkit() {
  local nvcc
  nvcc=$(command -v nvcc || compgen -G /usr/local/cuda/bin/nvcc) || return 0
  : >build/ci/empty.cu
  readlink -f "$("$nvcc" --dryrun build/ci/empty.cu 2>&1 | sed -n 's/^#\$ TOP=//p')"
}
verb_ci() {
  need "compilers, libraries, linters, containers" "${build_packages[@]}" "${check_packages[@]}" "${image_packages[@]}"
  rm -rf build/ci
  mkdir -p build/ci
  step "formatting" check_format
  step "layers" check_layers
  step "Python" check_python
  step "protos" check_protos
  step "fresh tree, ./dev run" ci_fresh_run
  # With CUDA if nvcc is installed, for one device architecture.
  step "the rest of the Release build" env CUDAARCHS=90-real build/ci/tree/dev build
  # Tests wait half of their time, images and npm for disk and network, so another step can run in parallel.
  trap 'kill $(jobs -p) 2>/dev/null || true' EXIT
  beside "clang-tidy" at_leisure check_tidy build/ci/tidy
  beside "builds with sanitizers" at_leisure build_sanitized
  step "tests" ci_tests
  joined
  beside "container" ci_container
  step "tests under ASan and UBSan" ci_asan
  joined
  beside "viewer and example with Node 18" ci_node_18  # after the container: both use apt
  step "scene engine under TSan" ci_tsan
  joined
  step "fuzzing" ci_fuzz
  printf '\n%7s  %s\n' seconds step
  cat build/ci/seconds.txt
  printf '%7d  in all\n\n' "$SECONDS"
  grep 'tests passed' build/ci/tests.txt
  skipped_tests "$ci_build"
  sed -n 's/^-- \(CUDA backend\)/\1/p' "$ci_build/configure.txt"
  [[ ! -f build/ci/skipped.txt ]] || sed 's/^/NOT RUN, /' build/ci/skipped.txt
}
