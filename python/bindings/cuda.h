// Device memory of the renderer's as CUDA's, for libraries that compute there. CUDA's driver is loaded when it is
// needed.
#pragma once

#include <latelight/latelight.h>

namespace latelight::python {

struct CudaPlace {
  void* pointer = nullptr;
  int device = 0;  // CUDA's number of it, as torch counts
};

// Where CUDA has the array. Its memory is imported once, and again waits for all that CUDA does there before the
// renderer uses it anew. Throws Error(NoDevice) where there is no CUDA, or the device is none of CUDA's.
CudaPlace cudaPlaceOf(const DeviceArray& array);

}  // namespace latelight::python
