# SPDX-FileCopyrightText: The latticed authors
# SPDX-License-Identifier: Apache-2.0
#
# Decides between the CUDA backend and its stub: sets latticed_with_cuda and enables the language.
# The root includes it, since a language is enabled for the folder that asks and those below it.
set(latticed_with_cuda OFF)
if(LATTICED_CUDA STREQUAL "AUTO" AND LATTICED_SANITIZE)
  message(STATUS "CUDA backend: the stub, since sanitizers are not nvcc's")
elseif(LATTICED_CUDA)  # AUTO or ON
  if(NOT CMAKE_CUDA_COMPILER AND NOT DEFINED ENV{CUDACXX})
    find_program(LATTICED_NVCC nvcc
      HINTS ENV CUDA_HOME ENV CUDA_PATH PATHS /usr/local/cuda PATH_SUFFIXES bin)
    if(LATTICED_NVCC)
      set(ENV{CUDACXX} ${LATTICED_NVCC})
    endif()
  endif()
  include(CheckLanguage)
  check_language(CUDA)
  if(CMAKE_CUDA_COMPILER)
    set(latticed_with_cuda ON)
    # Machine code for A100 and H100/H200, PTX for what comes after; before the language, or nvcc's
    # default takes their place. CMake's own variable of the environment goes before both.
    if(NOT DEFINED CMAKE_CUDA_ARCHITECTURES AND NOT DEFINED ENV{CUDAARCHS})
      set(CMAKE_CUDA_ARCHITECTURES 80-real 90-real 90-virtual)
    endif()
    enable_language(CUDA)
    # nvcc knows C++20; CMake 3.25 does not know that it does.
    set(CMAKE_CUDA20_STANDARD_COMPILE_OPTION "-std=c++20")
    set(CMAKE_CUDA20_EXTENSION_COMPILE_OPTION "-std=c++20")
    set(CMAKE_CUDA_STANDARD 20)
    set(CMAKE_CUDA_STANDARD_REQUIRED ON)
    # CMake 3.25.1, that of Debian 12, sets a property of this target, which CUDA 13 no longer has.
    if(NOT TARGET CUDA::nvToolsExt)
      add_library(CUDA::nvToolsExt INTERFACE IMPORTED)
    endif()
    find_package(CUDAToolkit REQUIRED)
    message(STATUS "CUDA backend: ${CMAKE_CUDA_COMPILER}, for ${CMAKE_CUDA_ARCHITECTURES}")
  elseif(LATTICED_CUDA STREQUAL "AUTO")
    message(STATUS "CUDA backend: the stub, since there is no nvcc")
  else()
    message(FATAL_ERROR "LATTICED_CUDA=${LATTICED_CUDA}, but there is no nvcc that works: put it on "
      "PATH or name it in CUDACXX, or configure with LATTICED_CUDA=AUTO.")
  endif()
endif()
