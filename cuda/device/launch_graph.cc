// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "cuda/device/launch_graph.h"

#include <algorithm>

#include "cuda/device/cuda_status.h"

namespace latticed {

absl::Status LaunchGraph::Launch(std::span<kernels::KernelCall> calls, cudaStream_t stream) {
  if (executable_ == nullptr) {
    if (const auto e = Make(calls, stream); e != cudaSuccess) {
      executable_.reset();
      return CudaStatus(e, "the graph of an evaluation");
    }
  } else {
    for (size_t k = 0; k < calls.size(); ++k) {
      if (const auto e = calls[k].Replace(executable_.get(), nodes_[k]); e != cudaSuccess) {
        return CudaStatus(e, "the graph of an evaluation");
      }
    }
  }
  return CudaStatus(cudaGraphLaunch(executable_.get(), stream), "the launch of an evaluation");
}

cudaError_t LaunchGraph::Make(std::span<kernels::KernelCall> calls, cudaStream_t stream) {
  // Stream capture turns a dependent launch into the matching edge of the graph.
  if (const auto e = cudaStreamBeginCapture(stream, cudaStreamCaptureModeThreadLocal);
      e != cudaSuccess) {
    return e;
  }
  cudaError_t launched = cudaSuccess;
  for (kernels::KernelCall& call : calls) {
    if (launched == cudaSuccess) launched = call.Launch(stream);
  }
  cudaGraph_t graph = nullptr;
  const cudaError_t captured = cudaStreamEndCapture(stream, &graph);
  graph_.reset(graph);
  if (launched != cudaSuccess) return launched;
  if (captured != cudaSuccess) return captured;
  if (const auto e = FindNodes(calls); e != cudaSuccess) return e;
  cudaGraphExec_t executable = nullptr;
  const cudaError_t made = cudaGraphInstantiate(&executable, graph, 0);
  executable_.reset(executable);
  return made;
}

cudaError_t LaunchGraph::FindNodes(std::span<const kernels::KernelCall> calls) {
  size_t count = calls.size();
  std::vector<cudaGraphNode_t> all(count);
  if (const auto e = cudaGraphGetNodes(graph_.get(), all.data(), &count); e != cudaSuccess) {
    return e;
  }
  nodes_.assign(calls.size(), nullptr);
  for (cudaGraphNode_t node : all) {
    cudaKernelNodeParams params{};
    if (const auto e = cudaGraphKernelNodeGetParams(node, &params); e != cudaSuccess) return e;
    const auto call = std::find_if(calls.begin(), calls.end(), [&](const kernels::KernelCall& c) {
      return c.kernel() == params.func;
    });
    if (call == calls.end()) return cudaErrorInvalidValue;
    nodes_[static_cast<size_t>(call - calls.begin())] = node;
  }
  return cudaSuccess;
}

}  // namespace latticed
