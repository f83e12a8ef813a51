// Outputs that stay in device memory as arrays of a whole request, which other APIs of the device (CUDA, another
// Vulkan device) may import; on a CPU device the host has them.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <vector>

#include "output/aov.h"
#include "render/settings.h"
#include "vk/resources.h"

namespace latelight::render {

struct ExportedMemory {
  vk::Buffer buffer;
  std::shared_ptr<void> import;       // an importer's own, kept as long as the memory
  std::function<void()> beforeReuse;  // called before it is rendered to again
};

// Memory of arrays, used again once nobody has them: to allocate and import it takes longer than to render what is in
// it. Arrays may be given back by any thread, at any time.
class ExportPool : public std::enable_shared_from_this<ExportPool> {
 public:
  // At least so many bytes. Throws Error(NoDevice) where the device exports none, Error(DeviceLost) where it has no
  // room.
  std::shared_ptr<ExportedMemory> take(vk::Device& device, uint64_t bytes);

 private:
  std::unique_ptr<ExportedMemory> takeFree(uint64_t bytes);
  std::mutex mutex_;
  std::vector<std::unique_ptr<ExportedMemory>> free_;
};

// Views x rows x columns x channels, without gaps.
struct ExportedArray {
  std::optional<output::Aov> aov;  // none: the picture to look at, 8 bits a channel
  size_t views = 0;
  uint32_t rows = 0, columns = 0, channels = 0;
  uint64_t rowBytes = 0;
  std::shared_ptr<ExportedMemory> memory;
};

// An array for each output of such a picture.
std::vector<ExportedArray> exportedArrays(vk::Device& device, ExportPool& pool, const Settings& settings, uint32_t rows,
                                          size_t views);

}  // namespace latelight::render
