// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The module latticed._decoder: client/decoder for Python.
#define PY_SSIZE_T_CLEAN
#include <Python.h>

#include <algorithm>
#include <mutex>
#include <new>
#include <span>
#include <utility>
#include <vector>

#include "client/decoder/chunk_decoder.h"
#include "core/codec/octahedral.h"

namespace {

using latticed::Vec3f;
using latticed::decoder::ChunkDecoder;
using latticed::decoder::ChunkForm;
using latticed::decoder::ChunkJob;
using latticed::decoder::kNumbersPerPoint;

constexpr size_t kBatch = 16;  // enough to be fast, and few enough for the cache

// An array of Python, as long as this lives.
class Buffer {
 public:
  Buffer() = default;
  Buffer(Buffer&& other) noexcept : view_(std::exchange(other.view_, {})) {}
  ~Buffer() {
    if (view_.obj != nullptr) PyBuffer_Release(&view_);
  }
  // False with a Python error set.
  bool Take(PyObject* array) { return PyObject_GetBuffer(array, &view_, PyBUF_WRITABLE) == 0; }
  size_t bytes() const { return static_cast<size_t>(view_.len); }
  void* data() const { return view_.buf; }

 private:
  Py_buffer view_{};
};

// What is decoded, and where to.
struct Request {
  std::vector<ChunkJob> jobs;
  std::vector<Buffer> positions, normals;  // one for each job; no normals if there are none
  ChunkForm form;
  double step = 0;
};

constexpr int kMostTableBits = 8;  // 255 x 255 unit vectors, 780 KB

// The unit vectors by s and t, made at the first use.
const std::vector<Vec3f>& NormalTable(int bits) {
  static std::once_flag made[kMostTableBits + 1];
  static std::vector<Vec3f> tables[kMostTableBits + 1];
  std::vector<Vec3f>& table = tables[bits];
  std::call_once(made[bits], [&] {
    const int top = latticed::OctahedralMax(bits);
    for (int s = 0; s <= top; ++s) {
      for (int t = 0; t <= top; ++t) table.push_back(latticed::DequantiseNormal({s, t}, bits));
    }
  });
  return table;
}

void WriteNormals(const ChunkJob& job, int bits, Vec3f* out) {
  const uint16_t* const end = job.out + kNumbersPerPoint * job.points;
  if (bits <= kMostTableBits) {
    const Vec3f* const table = NormalTable(bits).data();
    const int width = latticed::OctahedralMax(bits) + 1;
    for (const uint16_t* n = job.out; n != end; n += kNumbersPerPoint)
      *out++ = table[n[4] * width + n[5]];
  } else {
    for (const uint16_t* n = job.out; n != end; n += kNumbersPerPoint) {
      *out++ = latticed::DequantiseNormal({n[4], n[5]}, bits);
    }
  }
}

constexpr size_t kPositionBytes = 3 * sizeof(double), kNormalBytes = sizeof(Vec3f);
static_assert(kNormalBytes == 3 * sizeof(float));

void WritePoints(const Request& request, size_t i) {
  const ChunkJob& job = request.jobs[i];
  auto* position = static_cast<double*>(request.positions[i].data());
  const uint16_t* const end = job.out + kNumbersPerPoint * job.points;
  for (const uint16_t* n = job.out; n != end; n += kNumbersPerPoint) {
    for (int axis = 0; axis < 3; ++axis) *position++ = n[axis] * request.step;
  }
  if (request.normals.empty()) return;
  WriteNormals(job, request.form.normal_bits, static_cast<Vec3f*>(request.normals[i].data()));
}

void DecodeAll(Request& request) {
  ChunkDecoder decoder;
  std::vector<uint16_t> numbers;
  for (size_t first = 0; first < request.jobs.size(); first += kBatch) {
    const size_t count = std::min(kBatch, request.jobs.size() - first);
    const std::span batch = std::span(request.jobs).subspan(first, count);
    size_t points = 0;
    for (const ChunkJob& job : batch) points += job.points;
    numbers.resize(std::max(numbers.size(), kNumbersPerPoint * points));
    uint16_t* out = numbers.data();
    for (ChunkJob& job : batch) {
      job.out = out;
      out += kNumbersPerPoint * job.points;
    }
    decoder.Decode(request.form, batch);
    for (size_t i = first; i < first + count; ++i) {
      if (request.jobs[i].decoded) WritePoints(request, i);
    }
  }
}

// Adds a job. False with a Python error set.
bool AddJob(PyObject* stream, PyObject* positions, PyObject* normals, Request& request) {
  char* bytes = nullptr;
  Py_ssize_t size = 0;
  if (PyBytes_AsStringAndSize(stream, &bytes, &size) < 0) return false;
  if (!request.positions.emplace_back().Take(positions)) return false;
  if (normals != nullptr && !request.normals.emplace_back().Take(normals)) return false;
  const size_t position_bytes = request.positions.back().bytes();
  const size_t points = position_bytes / kPositionBytes;
  if (position_bytes % kPositionBytes != 0 || points > latticed::decoder::kMostPoints ||
      (normals != nullptr && request.normals.back().bytes() != points * kNormalBytes)) {
    PyErr_SetString(PyExc_ValueError, "an array has a wrong size");
    return false;
  }
  request.jobs.push_back(
      {.stream = {reinterpret_cast<const uint8_t*>(bytes), static_cast<size_t>(size)},
       .points = static_cast<uint32_t>(points)});
  return true;
}

PyObject* Run(PyObject* streams, PyObject* positions, PyObject* normals, Request& request) {
  const Py_ssize_t count = PyTuple_GET_SIZE(streams);
  const bool has_normals = request.form.normal_bits > 0;
  if (PyTuple_GET_SIZE(positions) != count ||
      PyTuple_GET_SIZE(normals) != (has_normals ? count : 0)) {
    PyErr_SetString(PyExc_ValueError, "streams and arrays differ in number");
    return nullptr;
  }
  for (Py_ssize_t i = 0; i < count; ++i) {
    PyObject* const normal = has_normals ? PyTuple_GET_ITEM(normals, i) : nullptr;
    if (!AddJob(PyTuple_GET_ITEM(streams, i), PyTuple_GET_ITEM(positions, i), normal, request))
      return nullptr;
  }
  bool has_memory = true;
  PyThreadState* const thread = PyEval_SaveThread();
  try {
    DecodeAll(request);
  } catch (const std::bad_alloc&) {
    has_memory = false;
  }
  PyEval_RestoreThread(thread);
  if (!has_memory) return PyErr_NoMemory();
  PyObject* const decoded = PyList_New(count);
  if (decoded == nullptr) return nullptr;
  for (Py_ssize_t i = 0; i < count; ++i) {
    PyList_SET_ITEM(decoded, i, PyBool_FromLong(request.jobs[static_cast<size_t>(i)].decoded));
  }
  return decoded;
}

PyObject* Decode(PyObject*, PyObject* arguments) {
  PyObject *streams = nullptr, *positions = nullptr, *normals = nullptr;
  try {
    Request request;
    int is_meshopt = 0;
    if (PyArg_ParseTuple(arguments, "O!piidO!O!", &PyTuple_Type, &streams, &is_meshopt,
                         &request.form.position_bits, &request.form.normal_bits, &request.step,
                         &PyTuple_Type, &positions, &PyTuple_Type, &normals) == 0) {
      return nullptr;
    }
    if (is_meshopt != 0) request.form.codec = latticed::decoder::Codec::kMeshopt;
    return Run(streams, positions, normals, request);
  } catch (const std::bad_alloc&) {
    return PyErr_NoMemory();
  }
}

constexpr char kDecodeText[] =
    "decode(streams, is_meshopt, position_bits, normal_bits, step, positions, normals) -> list of "
    "bool\n\n"
    "Decodes a tuple of chunks. Writes integer * step to positions, float64 (points, 3) for each "
    "chunk, and unit vectors to\n"
    "normals, float32 (points, 3); no arrays if normal_bits is 0. False for each chunk that is not "
    "as latticed writes it;\n"
    "its arrays then are as they were. Other threads run meanwhile.";

PyMethodDef methods[] = {{"decode", Decode, METH_VARARGS, kDecodeText},
                         {nullptr, nullptr, 0, nullptr}};
PyModuleDef module = {
    .m_base = PyModuleDef_HEAD_INIT,
    .m_name = "_decoder",
    .m_doc = "Decodes the Draco and meshopt streams that latticed writes.",
    .m_size = -1,
    .m_methods = methods,
};

}  // namespace

PyMODINIT_FUNC PyInit__decoder() { return PyModule_Create(&module); }
