// A renderer for Python, and the worlds of its calls.
#pragma once

#include <latelight/latelight.h>
#include <nanobind/nanobind.h>

#include <memory>
#include <mutex>
#include <utility>

#include "cuda.h"
#include "options.h"
#include "scene.h"
#include "worlds.h"

namespace latelight::python {

// A renderer that any thread may call. Calls are serialized.
class SharedRenderer {
 public:
  SharedRenderer(std::shared_ptr<SharedScene> scene, std::unique_ptr<Renderer> renderer);
  ~SharedRenderer();
  SharedRenderer(const SharedRenderer&) = delete;
  SharedRenderer& operator=(const SharedRenderer&) = delete;

  // Calls `work` with the renderer, while nothing edits its scene. Errors name options as keyword arguments.
  template <typename Work>
  auto use(Work work) {
    return inPython([&] {
      // Throws in a forked process, where locks of other threads stay locked.
      static_cast<void>(renderer_->deviceName());
      return scene_->read([&](const Scene&) {
        const std::lock_guard lock(busy_);
        return work(*renderer_);
      });
    });
  }

  const std::shared_ptr<SharedScene>& scene() const { return scene_; }

  // Copies of arrays in CUDA's memory to the renderer's. The first call needs CUDA.
  CudaInputs& cudaInputs();
  uint64_t copiedBytes() const { return cudaInputs_ ? cudaInputs_->copiedBytes() : 0; }

 private:
  std::shared_ptr<SharedScene> scene_;
  std::unique_ptr<Renderer> renderer_;
  std::unique_ptr<CudaInputs> cudaInputs_;  // null before arrays in CUDA's memory were passed
  std::mutex busy_;
};

// The worlds of a call, before their tensors are copied.
struct WorldCall {
  std::unique_ptr<GivenWorlds> given;
  uintptr_t stream = 0;
};

// Removes the arguments that describe worlds from `keywords`.
WorldCall worldCall(const std::shared_ptr<SharedRenderer>& renderer, nanobind::handle count, nanobind::handle cameras,
                    nanobind::dict& keywords);
// Returns the stream that will read the call's arrays in CUDA's memory.
uintptr_t readerOf(SharedRenderer& renderer, WorldCall& call);
// Returns the worlds with all arrays in the renderer's memory. Called in SharedRenderer::use().
Worlds& completed(WorldCall& call, SharedRenderer& shared, Renderer& renderer);

}  // namespace latelight::python
