// Maps the renderer's device memory into CUDA, for libraries that compute there. CUDA's driver is loaded on first use.
#pragma once

#include <latelight/latelight.h>

#include <cstdint>
#include <functional>
#include <string>

namespace latelight::python {

struct CudaPointer {
  void* pointer = nullptr;
  int device = 0;  // CUDA's index of the device, as torch counts
};

// Copies arrays of CUDA's memory to a renderer's, ordered on the device: the copies follow the work of their writers'
// streams, and the renderer's submission follows the copies. The host waits for neither.
class CudaInputs {
 public:
  // `deviceUuid`: the renderer's device. `exportSemaphore` returns Renderer::exportInputSemaphore(). Throws
  // Error(NoDevice) if CUDA is absent or does not know the device.
  CudaInputs(const std::string& deviceUuid, const std::function<int()>& exportSemaphore);
  ~CudaInputs();
  CudaInputs(const CudaInputs&) = delete;
  CudaInputs& operator=(const CudaInputs&) = delete;

  int device() const { return device_; }  // CUDA's index
  uintptr_t stream() const;               // that copies if the caller has no stream of its own
  int deviceOf(uintptr_t pointer) const;  // CUDA's index of the device that has the memory
  // Enqueues a copy to an array of Renderer::inputArray(), at an offset. `writer`: as in Tensor.
  void copy(const DeviceArray& to, uint64_t offset, uintptr_t from, uint64_t bytes, uintptr_t stream, uintptr_t writer);
  // Returns the value of the semaphore after all work so far on the stream: WorldArrays::ready.
  uint64_t signal(uintptr_t stream);
  uint64_t copiedBytes() const { return copied_; }  // on the device, since the beginning

 private:
  int device_;
  void* context_;
  void *stream_ = nullptr, *semaphore_ = nullptr, *event_ = nullptr;
  void* signaled_ = nullptr;  // event after the last signal
  uint64_t value_ = 0, copied_ = 0;
};

// Returns CUDA's address of the array. The memory is imported once. Before the renderer reuses it, it waits for all
// work of CUDA in this context. Throws Error(NoDevice) if CUDA is absent or does not know the device.
CudaPointer cudaPointerOf(const DeviceArray& array);
// The same for memory that CUDA only writes, in the order that CudaInputs defines.
CudaPointer cudaInputPointerOf(const DeviceArray& array);

}  // namespace latelight::python
