#!/usr/bin/env bash
# SPDX-FileCopyrightText: The latticed authors
# SPDX-License-Identifier: Apache-2.0
#
# usage: layering_test.sh ROOT
# Reads every source under ROOT. Fails if an #include is not in the table of layers below, a C++ file
# selects a backend by #if, the CUDA backend waits for a whole device, or a file has more than 400 lines
# or no licence.
set -euo pipefail
cd "$1"

readonly below_backends="core/base/ core/mesh/ core/ffd/ core/adaptive/ core/patches/ core/codec/ core/backend.h core/view/"
readonly below_edits="core/ffd/box/ core/ffd/bspline_basis.h core/ffd/carried_normal.h core/ffd/control_point_range.h core/ffd/deformed_mesh.h core/ffd/direct_ffd.h core/ffd/lattice.h core/ffd/outside/ core/ffd/pick/ core/ffd/plan/ core/ffd/stage_matrices.h core/ffd/sum/ core/ffd/tessellation_pattern.h core/ffd/turned/ core/ffd/weights/"
# layer    prefixes of paths that it may include
declare -A allowed=(
  [core/base]="core/base/"
  [core/mesh]="core/base/ core/mesh/"
  [core/ffd]="core/base/ core/mesh/ $below_edits"
  [core/ffd/edit]="core/base/ core/mesh/ $below_edits core/ffd/constraints/ core/ffd/edit/"
  [core/ffd/history]="core/base/ core/mesh/ core/ffd/"
  [core/measure]="core/base/ core/mesh/ core/ffd/ core/points/ core/view/cpu_arena.h core/measure/"
  [core/adaptive]="core/base/ core/mesh/ core/ffd/ core/adaptive/"
  [core/folds]="core/base/ core/mesh/ core/ffd/ core/folds/"
  [core/patches]="core/base/ core/mesh/ core/ffd/ core/adaptive/ core/codec/octahedral.h core/patches/"
  [core/backend]="core/base/ core/mesh/ core/ffd/ core/adaptive/ core/patches/ core/backend.h"
  [core/codec]="core/base/ core/mesh/ core/ffd/ core/codec/"
  [core/view]="core/base/ core/mesh/ core/ffd/ core/adaptive/ core/patches/ core/codec/ core/backend.h core/view/"
  [core/points]="core/base/ core/ffd/ core/view/cpu_arena.h core/points/"
  [core/cpu/gemm]="$below_backends core/cpu/cpu_context.h core/cpu/vertex_kernel.h core/points/ core/cpu/gemm/"
  [core/cpu/fused/kernel]="$below_backends core/cpu/fused/kernel/"
  [core/cpu/fused]="$below_backends core/cpu/cpu_context.h core/cpu/flush_denormals.h core/cpu/vertex_kernel.h core/cpu/fused/"
  [core/cpu/adaptive/bounds]="$below_backends core/cpu/cpu_context.h core/cpu/flush_denormals.h core/cpu/fused/ core/cpu/adaptive/kernel/ core/cpu/adaptive/surface/ core/cpu/adaptive/bounds/"
  [core/cpu/adaptive/surface]="$below_backends core/cpu/flush_denormals.h core/cpu/fused/ core/cpu/gemm/ core/cpu/adaptive/kernel/ core/cpu/adaptive/surface/ core/points/"
  [core/cpu/adaptive/kernel]="$below_backends core/cpu/fused/kernel/ core/cpu/adaptive/kernel/"
  [core/cpu/adaptive]="$below_backends core/cpu/cpu_context.h core/cpu/flush_denormals.h core/cpu/fused/ core/cpu/adaptive/"
  [core/cpu]="core/"
  [cuda/device]="$below_backends cuda/device/"
  [cuda/plan]="$below_backends cuda/device/ cuda/plan/"
  [cuda/streams]="$below_backends cuda/device/ cuda/streams/"
  [cuda/draco]="$below_backends cuda/device/ cuda/streams/ cuda/draco/"
  [cuda/meshopt]="$below_backends cuda/device/ cuda/streams/ cuda/meshopt/"
  [cuda/view]="$below_backends cuda/device/ cuda/plan/ cuda/streams/ cuda/draco/ cuda/meshopt/ cuda/view/"
  [cuda/points]="$below_backends core/points/ cuda/device/ cuda/points/"
  [cuda/gemm]="$below_backends cuda/device/ cuda/plan/ cuda/view/ cuda/gemm/"
  [cuda/fused]="$below_backends cuda/device/ cuda/plan/ cuda/view/ cuda/fused/"
  [cuda/adaptive]="$below_backends cuda/device/ cuda/plan/ cuda/streams/ cuda/view/ cuda/fused/ cuda/adaptive/"
  [cuda/adaptive/surface]="$below_backends cuda/device/ cuda/plan/ cuda/fused/ cuda/adaptive/adaptive_kernels.h cuda/adaptive/point_site.cuh cuda/adaptive/store_bounds.cuh cuda/adaptive/surface/"
  [cuda/bounds]="$below_backends cuda/device/ cuda/plan/ cuda/view/ cuda/fused/ cuda/adaptive/ cuda/bounds/"
  [cuda]="$below_backends cuda/"
  [server/base]="core/ server/base/"
  [server/base/auth]="core/base/ server/base/option_file.h server/base/options.h server/base/auth/"
  [server/base/quotas]="core/base/ server/base/auth/tenant.h server/base/option_file.h server/base/quotas/"
  [server/net]="core/base/ server/base/ server/net/"
  [server/store/files]="core/base/ server/base/ server/store/store_errors.h server/store/objects/mesh_objects.h server/store/objects/mesh_names.h server/store/files/"
  [server/store/objects]="core/base/ server/base/ server/store/store_errors.h server/store/objects/"
  [server/store/postgres]="core/base/ server/base/ server/store/files/ server/store/queue/ server/store/store.h server/store/store_errors.h server/store/row_sum.h server/store/postgres/"
  [server/store/queue]="core/base/ server/base/ server/store/store.h server/store/store_errors.h server/store/queue/"
  [server/store/records]="core/ server/store/records/"
  [server/store/sqlite/database]="core/base/ server/base/ server/store/store_errors.h server/store/sqlite/database/"
  [server/store/sqlite]="core/base/ server/base/ server/store/files/ server/store/queue/ server/store/store.h server/store/store_errors.h server/store/row_sum.h server/store/sqlite/"
  [server/store]="core/ server/base/ server/store/"
  [server/engine/memory]="core/ server/engine/memory/"
  [server/engine/lattices]="core/ server/engine/lattices/"
  [server/engine/scene]="core/ server/store/ server/engine/memory/ server/engine/lattices/ server/engine/scene/"
  [server/engine/points]="core/ server/engine/memory/ server/engine/render/ server/engine/scene/ server/engine/points/"
  [server/engine/render]="core/ server/base/engine_counts.h server/engine/memory/ server/engine/scene/ server/engine/render/"
  [server/engine/watch]="core/ server/engine/scene/ server/engine/render/ server/engine/watch/"
  [server/engine/exports]="core/ server/engine/scene/ server/engine/render/ server/engine/exports/"
  [server/engine]="core/ server/base/ server/store/ server/engine/"
  [server/stores]="core/ server/base/ server/store/ server/engine/ server/stores/"
  [server/wire]="core/ latticed/v1/ server/base/ server/store/ server/engine/ server/stores/ server/wire/"
  [server/check]="core/base/ server/store/ server/engine/scene/ server/wire/ server/check/"
  [server/rpc]="core/ latticed/v1/ server/base/ server/store/ server/engine/ server/stores/ server/wire/ server/rpc/"
  [server/rpc/points]="core/ latticed/v1/ server/base/ server/engine/ server/stores/ server/wire/ server/rpc/"
  [server/rpc/backup]="core/base/ latticed/v1/ server/base/ server/store/ server/engine/memory/ server/engine/scene/ server/stores/ server/wire/ server/rpc/"
  [server/rpc/access]="core/base/ server/base/audit_log.h server/base/auth/ server/base/quotas/ server/stores/ server/wire/ server/rpc/"
  [server/edge]="core/ latticed/v1/ server/base/ server/net/ server/engine/ server/stores/ server/rpc/ server/wire/ server/edge/"
  [server/web]="core/base/ latticed/v1/ server/base/ server/net/ server/wire/ server/web/"
  [server]="core/ cuda/cuda_backend.h latticed/v1/ server/"
  [client/decoder/lanes]="core/base/ core/codec/diamond-inl.h core/codec/draco_symbols.h core/codec/octahedral.h client/decoder/lanes/"
  [client/python]="client/decoder/chunk_decoder.h core/codec/octahedral.h"
  [client/decoder]="core/codec/draco_container.h core/codec/meshopt/meshopt_format.h core/codec/octahedral.h core/codec/rans_model.h client/decoder/"
  [client/library]="client/decoder/chunk_decoder.h core/base/ core/mesh/ core/ffd/ core/adaptive/ core/codec/ core/patches/ latticed/v1/ client/cpp/library/"
  [client/latticectl/backup]="core/base/ latticed/v1/ client/cpp/latticectl/backup/"
  [client/latticectl/output]="core/base/ client/cpp/library/ client/cpp/latticectl/output/"
  [client/latticectl/geometry]="core/base/ core/mesh/ core/ffd/ core/codec/ latticed/v1/ client/cpp/latticectl/geometry/"
  [client/latticectl/vtk]="core/base/ client/cpp/latticectl/vtk/"
  [client/latticectl/command_line]="core/base/ latticed/v1/ client/cpp/latticectl/output/ client/cpp/latticectl/command_line/"
  [client/latticectl/reference]="client/cpp/latticectl/command_line/ client/cpp/latticectl/reference/"
  [client/latticectl/session]="core/base/ core/mesh/ latticed/v1/ client/cpp/library/ client/cpp/latticectl/output/ client/cpp/latticectl/geometry/ client/cpp/latticectl/command_line/ client/cpp/latticectl/session/ server/in_process.h server/base/options.h"
  [client/latticectl/torture]="core/base/ core/ffd/ latticed/v1/ client/cpp/library/ client/cpp/latticectl/output/ client/cpp/latticectl/geometry/ client/cpp/latticectl/command_line/ client/cpp/latticectl/session/ client/cpp/latticectl/torture/"
  [client/latticectl]="core/base/ core/mesh/ core/ffd/ core/codec/ latticed/v1/ client/cpp/library/ client/cpp/latticectl/"
  [client/load]="core/base/ core/mesh/ core/ffd/ core/codec/ latticed/v1/ client/cpp/"
  [tests]="core/ cuda/ server/ client/ latticed/v1/ tests/"
)

# Third-party headers that only some files may include: a regular expression of headers, then one of files.
readonly guarded=(
  '^(grpcpp|grpc|google/protobuf|google/rpc)/' '^(server/(wire|rpc|edge|web|[a-z_]+\.)|client/|tests/)'
  '^(spdlog|CLI)/' '^(server|client|tests)/'
  '^boost/' '^(server|tests/server)/web/|^tests/fuzz/http|^server/(net|edge)/|^server/rpc/server_env\.cc$'
  '^zlib' '^(core/patches/zlib_stream|client/cpp/latticectl/vtk/xml_array)'
  '^draco' '^(core/codec|client|server|tests)/'
  '^(tbb|oneapi)/' '^(core/(cpu|view)|client/cpp/load|server|tests)/'
  '^hwy/' '^(core/(cpu|codec|measure|view|points)|client/cpp/library/patches|client/decoder/lanes|client/decoder/meshopt|tests)/'
  '^prometheus/' '^server/edge/metric'
  '^libpq' '^(server|tests/server)/store/'
  '^cjose/' '^server/base/auth/'
  '^sqlite3' '^(server|tests/server)/store/'
  '^curl/' '^server/store/objects/'
  '^cblas' '^core/cpu/gemm/cpu_gemm'
  '^cublas' '^cuda/device/cuda_(gemm|status)'
  '^epoxy/' '^tests/(bench/paper/shaders|client/patches/shader)/'
  '^(cuda_runtime|cuda\.h|cuda_fp16)' '^(cuda|tests/(bench|cuda))/')

# Sets $layer rather than printing it: $(…) would start a process for each of thousands of includes.
set_layer() {  # FILE
  case $1 in
    core/base/*) layer=core/base ;; core/mesh/*) layer=core/mesh ;;
    core/ffd/edit/* | core/ffd/constraints/*) layer=core/ffd/edit ;; core/ffd/history/*) layer=core/ffd/history ;; core/ffd/*) layer=core/ffd ;;
    core/measure/*) layer=core/measure ;; core/adaptive/*) layer=core/adaptive ;; core/folds/*) layer=core/folds ;; core/patches/*) layer=core/patches ;; core/codec/*) layer=core/codec ;; core/view/*) layer=core/view ;; core/points/*) layer=core/points ;; core/cpu/*/*) layer=${1%/*} ;; core/cpu/*) layer=core/cpu ;; core/*) layer=core/backend ;;
    cuda/*/*) layer=${1%/*} ;; cuda/*) layer=cuda ;;
    server/*/*) layer=${1%/*} ;; server/*) layer=server ;; tests/*) layer=tests ;;
    client/decoder/lanes/*) layer=client/decoder/lanes ;; client/decoder/*) layer=client/decoder ;;
    client/python/*) layer=client/python ;;
    client/cpp/latticectl/commands/*) layer=client/latticectl ;;
    client/cpp/latticectl/*/*) layer=${1#*/cpp/} layer=client/${layer%/*} ;;
    client/cpp/library/* | client/cpp/latticectl/* | client/cpp/load/*) layer=${1#*/cpp/} layer=client/${layer%%/*} ;;
    client/*) layer=client ;;
    *) layer=none ;;
  esac
}

failures=0
fail() { echo "$1"; failures=$((failures + 1)); }

check_include() {  # FILE LAYER HEADER QUOTED
  local file=$1 layer=$2 header=$3 quoted=$4 prefix i
  case $header in
    core/* | cuda/* | server/* | client/* | tests/* | latticed/v1/*)
      for prefix in ${allowed[$layer]-}; do [[ $header == "$prefix"* ]] && return; done
      fail "$file: $layer may not include $header"
      return ;;
  esac
  [[ $quoted == '"' && $header != */* ]] && fail "$file: name $header from the root of the tree"
  for ((i = 0; i < ${#guarded[@]}; i += 2)); do
    [[ $header =~ ${guarded[i]} && ! $file =~ ${guarded[i + 1]} ]] && fail "$file: $header is not for $layer"
  done
  [[ $file == *.cu && $header =~ ^(absl|grpcpp|spdlog)/ ]] && fail "$file: kernels know no $header"
  return 0
}

mapfile -t files < <(find core cuda server client tests proto dev .ci -name node_modules -prune -o -type f \
  \( -name '*.cc' -o -name '*.h' -o -name '*.cu' -o -name '*.cuh' -o -name '*.proto' -o -name '*.py' \
  -o -name '*.js' -o -name '*.mjs' -o -name '*.ts' -o -name '*.sh' -o -name dev -o -name run \) -print | sort)
((${#files[@]} > 20)) || fail "only ${#files[@]} sources found under $1"

while read -r count file; do
  ((count <= 400)) || fail "$file: $count lines; past 400 a file wants to be two"
done < <(wc -l "${files[@]}" | grep -v ' total$')

while read -r file; do fail "$file: no SPDX header in its first lines"; done < <(
  for file in "${files[@]}"; do
    mapfile -n 3 head <"$file"
    [[ ${head[*]} == *SPDX-FileCopyrightText:*SPDX-License-Identifier:* ]] || echo "$file"
  done)

mapfile -t code < <(printf '%s\n' "${files[@]}" | grep -E '\.(cc|h|cu|cuh)$')
while IFS=: read -r file text; do
  [[ $text =~ \#[[:space:]]*include[[:space:]]*([\"\<])([^\"\>]+) ]] || continue
  set_layer "$file"
  check_include "$file" "$layer" "${BASH_REMATCH[2]}" "${BASH_REMATCH[1]}"
done < <(grep -HE '^[[:space:]]*#[[:space:]]*include[[:space:]]*["<]' "${code[@]}")

# host_device.h is the only file that may distinguish nvcc from a host compiler.
while read -r line; do fail "$line: backends are chosen by CMake and by name, never by #if"; done < <(
  printf '%s\n' "${code[@]}" | grep -v '^core/base/host_device.h$' |
    xargs grep -nE '^[[:space:]]*#[[:space:]]*(if|ifdef|ifndef|elif)\b.*(LATTICED_(CUDA|CPU|BACKEND)|__CUDACC__|__CUDA_ARCH__|ENABLE_(GPU|CUDA))' |
    grep -v '#ifndef LATTICED_[A-Z0-9_]*_\(CU\)\?H_$')

# Some calls wait by their name, and cudaFree, cudaMemcpy and cudaMemset wait as a side effect.
while read -r line; do fail "$line: waits for all of the device, where a stream or an event is meant"; done < <(
  printf '%s\n' "${code[@]}" | grep '^cuda/' |
    xargs grep -HnE '\b((cudaDevice|cudaThread|cudaCtx|cuCtx)Synchronize|cudaDeviceReset)\b|\bcuda(Free|Memcpy|Memset) *\(')

((failures == 0)) && echo "layering: ${#files[@]} sources, every arrow goes down" || { echo "$failures violations"; exit 1; }
