// Outputs that stay in device memory as arrays of a whole request. Other APIs on the device (CUDA, another Vulkan
// device) may import them. On a CPU device they are in host memory.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <vector>

#include "output/aov.h"
#include "render/settings/settings.h"
#include "vk/resources.h"

namespace latelight::render {

struct ExportedMemory {
  vk::Buffer buffer;
  uint64_t serial = 0;                // differs from that of any other memory
  std::shared_ptr<void> attached;     // owned by an importer, released with the memory
  std::function<void()> beforeReuse;  // called before the memory is rendered to again
};

// Memory of arrays, reused after its owner releases it, because allocating and importing memory is slower than
// rendering into it. Any thread may release arrays at any time.
class ExportPool : public std::enable_shared_from_this<ExportPool> {
 public:
  // Returns at least `bytes` bytes. Throws Error(NoDevice) if the device cannot export memory, and Error(OutOfMemory)
  // if it has no memory left.
  std::shared_ptr<ExportedMemory> take(vk::Device& device, uint64_t bytes);

 private:
  std::unique_ptr<ExportedMemory> takeFree(uint64_t bytes);
  std::mutex mutex_;
  std::vector<std::unique_ptr<ExportedMemory>> free_;
};

// Views x rows x columns x channels, tightly packed; with channels first, views x channels x rows x columns.
struct ExportedArray {
  std::optional<output::Aov> aov;  // none: the display picture, 8 bits per channel
  size_t views = 0;
  uint32_t rows = 0, columns = 0, channels = 0;
  uint32_t elementBytes = 4;
  bool channelsFirst = false;
  bool converted = false;  // its elements are not those that passes pack (format.comp converts them)
  std::shared_ptr<ExportedMemory> memory{};

  uint64_t rowBytes() const { return uint64_t{elementBytes} * columns * (channelsFirst ? 1 : channels); }
  uint64_t viewBytes() const { return uint64_t{elementBytes} * columns * rows * channels; }
};

// The memory to use for outputs in place of the pool's; none: the display picture.
using ExportTargets = std::map<std::optional<output::Aov>, std::shared_ptr<ExportedMemory>>;

// Returns one array per output for `views` pictures with `rows` rows each. Throws Error(Usage) if a target is too
// small.
std::vector<ExportedArray> exportedArrays(vk::Device& device, ExportPool& pool, const Settings& settings, uint32_t rows,
                                          size_t views, const ExportTargets& targets = {});

}  // namespace latelight::render
