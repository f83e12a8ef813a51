// Arrays in CUDA's memory as arguments: any object with DLPack or __cuda_array_interface__ (torch, JAX, CuPy, Warp).
#pragma once

#include <latelight/latelight.h>
#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>

#include <cstdint>
#include <string>
#include <vector>

namespace latelight::python {

// CUDA's handles of its default streams, which DLPack numbers in the same way.
constexpr uintptr_t kLegacyStream = 1;

// A contiguous array in CUDA's memory.
struct Tensor {
  uintptr_t pointer = 0;
  int device = 0;  // CUDA's index
  std::vector<int64_t> shape;
  WorldArray::Element element = WorldArray::Element::Float32;
  uint64_t bytes = 0;
  uintptr_t writer = 0;    // the stream whose work must precede reads; 0: the reader's stream already waits for it
  nanobind::object owner;  // keeps the memory, as does the view by DLPack, if any
  nanobind::ndarray<nanobind::ro> view{};
};

// Returns true if the value is in CUDA's memory. `name` names the argument in messages.
bool isTensor(nanobind::handle value);
// `reader`: the stream that will read it. Throws Error(Usage) for other element types and for arrays with gaps.
Tensor tensorOf(nanobind::handle value, const char* name, uintptr_t reader);
// A stream of the caller: a number, or an object of torch, CuPy or Warp.
uintptr_t streamOf(nanobind::handle value);

}  // namespace latelight::python
