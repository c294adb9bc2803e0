// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Every figure of Tables 1 to 3 as the paper prints it.
//                              Cui & Feng 2014, doi:10.1007/s11766-014-3239-6, section 4
//
// B-spline volumes of degree 2 x 2 x 2. Each patch becomes 100 triangles: 10 segments, 66 points.
//
// Layout   each table has one row per model, in the order of kPaperModels
// Units    milliseconds; `saved` is in percent
#ifndef LATTICED_TESTS_BENCH_PAPER_PRINTED_TABLES_H_
#define LATTICED_TESTS_BENCH_PAPER_PRINTED_TABLES_H_

#include <array>
#include <cstddef>
#include <limits>

namespace latticed::bench {

struct PaperModel {
  const char* name;
  size_t patches;
};
inline constexpr std::array kPaperModels{
    PaperModel{"bird", 17'119}, PaperModel{"amphora", 19'924}, PaperModel{"snail", 46'742},
    PaperModel{"spaceship", 96'314}, PaperModel{"tree", 113'663}};
inline constexpr size_t kPaperModelCount = kPaperModels.size();

inline constexpr char kPaperMachine[] =
    "Intel Core i5 760 at 2.8 GHz; NVIDIA GeForce GTX 465 (Fermi, 2010: 855 GFLOPS and 102.6 GB/s "
    "by its data sheet), CUBLAS, Arch Linux";

// A figure that is in the paper but cannot be read in its print.
inline constexpr double kNotLegible = std::numeric_limits<double>::quiet_NaN();

// Table 1: the products alone. The trivial form has (18) in the place of (24), and (21)-(23) in the
// place of (25).
struct PrintedProducts {
  struct Form {
    double formula24, formula25, sum;
  };
  Form trivial, optimal;
  double saved;
};
inline constexpr std::array<PrintedProducts, kPaperModelCount> kPaperTable1{{
    {{0.024, 3.954, 3.978}, {0.011, 2.827, 2.838}, 28.66},
    {{0.024, 4.898, 4.922}, {0.011, 3.529, 3.540}, 28.08},
    {{0.024, 9.861, 9.885}, {0.011, 7.221, 7.232}, 26.84},
    {{0.024, 20.225, 20.249}, {0.012, 14.921, 14.933}, 26.25},
    {{0.024, 22.707, 22.731}, {0.011, 16.839, 16.850}, 25.87},
}};

// Table 2: whole evaluations. CUDA and the tessellation shader include drawing; the CPU, with
// CBLAS, does not draw.
struct PrintedEvaluations {
  double cuda, shader, shader_to_cuda, cpu, cpu_to_cuda;
};
inline constexpr std::array<PrintedEvaluations, kPaperModelCount> kPaperTable2{{
    {12.757, 33.657, 2.638, 661, 51.81},
    {15.468, 41.568, 2.687, 831, 53.72},
    {32.333, 86.324, 2.670, 1'707, 52.79},
    {64.885, 179.261, 2.763, 3'528, 54.37},
    {74.458, 201.758, 2.710, 4'003, 53.76},
}};

// Table 3, first part: the tensor-product algorithm of Cui & Feng 2013.
struct PrintedTensorStages {
  double copy, control_points, tessellation, drawing, total;
};
inline constexpr std::array<PrintedTensorStages, kPaperModelCount> kPaperTable3Tensor{{
    {0.009, 4.138, 9.652, 6, 19.799},
    {0.009, 4.171, 11.067, 7, 22.247},
    {0.009, 10.916, 24.920, 16, 51.845},
    {0.009, 20.675, 49.871, 32, 102.555},
    {0.009, 25.936, 58.286, 37, 121.231},
}};

// Table 3, second part: the paper's own algorithm.
struct PrintedStages {
  double copy, samples, formula24, formula25, to_vbo, drawing, total, saved;

  // (25) and the copy to the vertex buffer object, from the total. Known for each model.
  constexpr double formula25_and_to_vbo() const {
    return total - copy - samples - formula24 - drawing;
  }
  constexpr double computed() const { return total - copy - drawing; }  // samples ... copy to VBO
};
inline constexpr std::array<PrintedStages, kPaperModelCount> kPaperTable3{{
    {0.009, 2.601, 0.011, 2.840, 1.110, 6, 12.571, 36.51},
    {0.009, 3.266, 0.011, 3.558, 1.393, 7, 15.237, 31.51},
    {0.009, 6.680, 0.011, kNotLegible, kNotLegible, 16, 32.837, 36.66},
    {0.009, 13.799, 0.011, 15.025, 5.910, 32, 66.754, 34.91},
    {0.009, 15.601, 0.011, 16.962, 6.660, 37, 76.243, 37.11},
}};

// Where the paper's text and its own figures differ.
inline constexpr char kPaperSlipShaders[] =
    "The paper's text says that CUDA is 1.6 to 1.7 times faster than the shaders; its Table 2 has "
    "2.6 to 2.8. (shader - CUDA) / CUDA is 1.6 to 1.8, so \"faster by\" was meant.";
inline constexpr char kPaperSlipTensor[] =
    "The paper's text says that samples, (24) and (25) are almost twice as fast as the tensor "
    "product's control points and tessellation; its Table 3 has 2.2 to 2.6 times, and 1.9 to 2.1 "
    "with "
    "the copy to the VBO.";
inline constexpr char kPaperSlipFormula20[] =
    "The paper prints (20) as f < 3q = 198, because it counts the product of a number and a vector "
    "as one multiplication. In scalars Method 1 takes 3m²f + 9mqf and Method 2 3m²q + 9mqf, so it "
    "should read f < q = 66.";

}  // namespace latticed::bench

#endif  // LATTICED_TESTS_BENCH_PAPER_PRINTED_TABLES_H_
