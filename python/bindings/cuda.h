// Maps the renderer's device memory into CUDA, for libraries that compute there. CUDA's driver is loaded on first use.
#pragma once

#include <latelight/latelight.h>

namespace latelight::python {

struct CudaPointer {
  void* pointer = nullptr;
  int device = 0;  // CUDA's index of the device, as torch counts
};

// Returns CUDA's address of the array. The memory is imported once. Before the renderer reuses it, it waits for all
// work of CUDA in this context. Throws Error(NoDevice) if CUDA is absent or does not know the device.
CudaPointer cudaPointerOf(const DeviceArray& array);

}  // namespace latelight::python
