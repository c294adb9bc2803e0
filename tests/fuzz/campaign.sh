#!/usr/bin/env bash
# SPDX-FileCopyrightText: The latticed authors
# SPDX-License-Identifier: Apache-2.0
#
# Runs fuzzers for some time and prints a table: campaign.sh FUZZERS SEEDS WORK SECONDS CORES
#
#   FUZZERS   folder of the programs, x_fuzz        SEEDS   folder of the corpora, x; x.dict beside it
#   WORK      gets what is found: corpus/x, logs/x.n, and the inputs that failed, crashes/x.*
#
# Every target runs in at least one process for SECONDS, CORES processes at a time. Cores that are left go to the
# targets of the whole server. A process that fails is started again. Status 1 if any failed.
set -euo pipefail
fuzzers=$1 seeds=$2 work=$3 seconds=$4 cores=$5

run_one() {  # TARGET NUMBER: until the time is over
  local name=$1 log=$work/logs/$1.$2 end=$((SECONDS + seconds)) options=()
  [[ -f $seeds/../$name.dict ]] && options=(-dict="$seeds/../$name.dict")
  mkdir -p "$work/corpus/$name"
  : >"$log"
  while ((SECONDS < end)); do
    "$fuzzers/${name}_fuzz" -max_total_time=$((end - SECONDS)) -print_final_stats=1 -timeout=25 -rss_limit_mb=4096 \
      -reload=1 -artifact_prefix="$work/crashes/$name." "${options[@]}" "$work/corpus/$name" "$seeds/$name" \
      >>"$log" 2>&1 || echo "FAILED with status $?" >>"$log"
  done
}
export -f run_one
export fuzzers seeds work seconds

targets=()
for program in "$fuzzers"/*_fuzz; do targets+=("$(basename "$program" _fuzz)"); done
tasks=("${targets[@]}")
while ((${#tasks[@]} + 2 <= cores)); do tasks+=(request http); done
mkdir -p "$work/logs" "$work/crashes"
rm -f "$work"/logs/*
for i in "${!tasks[@]}"; do printf '%s %s\n' "${tasks[i]}" "$i"; done |
  xargs -P "$cores" -L 1 bash -c 'run_one "$1" "$2"' run_one

# The ends of the logs of those that failed.
grep -l '^FAILED' "$work"/logs/* | xargs -r -n 1 tail -n 40 || true

# Sums the processes of each target; coverage is the highest.
printf '%-14s %12s %9s %9s %8s\n' target runs 'runs/s' coverage failures
for name in "${targets[@]}"; do
  cat "$work/logs/$name".* | awk -v name="$name" '
    /^#[0-9]/ { for (i = 1; i < NF; ++i) if ($i == "cov:" && $(i + 1) > cov) cov = $(i + 1) }
    /^stat::number_of_executed_units/ { runs += $2 }
    /^stat::average_exec_per_sec/ { rate += $2; ++processes }
    /^FAILED with status/ { ++failures }
    END { printf "%-14s %12d %9d %9d %8d\n", name, runs, processes ? rate / processes : 0, cov, failures }'
done | tee "$work/table.txt"
awk '{ runs += $2; failures += $5 } END { printf "%-14s %12d %28d\n", "all", runs, failures; exit failures > 0 }' \
  "$work/table.txt"
