#include "render/outputs/exported.h"

#include <algorithm>
#include <atomic>

#include "base/error.h"

namespace latelight::render {

std::unique_ptr<ExportedMemory> ExportPool::takeFree(uint64_t bytes) {
  std::lock_guard lock(mutex_);
  const auto waste = [&](const auto& memory) {
    const uint64_t size = memory->buffer.size();
    return size < bytes || size / 2 > bytes ? ~uint64_t{0} : size - bytes;
  };
  const auto found = std::ranges::min_element(free_, {}, waste);
  if (found == free_.end() || waste(*found) == ~uint64_t{0}) {
    free_.clear();  // their sizes are for other pictures
    return nullptr;
  }
  std::unique_ptr<ExportedMemory> taken = std::move(*found);
  free_.erase(found);
  return taken;
}

std::shared_ptr<ExportedMemory> ExportPool::take(vk::Device& device, uint64_t bytes) {
  std::unique_ptr<ExportedMemory> memory = takeFree(bytes);
  if (memory && memory->beforeReuse) memory->beforeReuse();
  if (!memory) {
    const bool cpu = device.isCpu();
    if (!cpu && !vk::exportsBuffers(device))
      fail(ExitCode::NoDevice, "{} cannot export its memory to other libraries: read the images on the host.",
           device.info().name);
    static std::atomic<uint64_t> serial = 0;
    memory = std::make_unique<ExportedMemory>();
    memory->serial = ++serial;
    memory->buffer = {device,
                      {.size = bytes,
                       .kind = cpu ? vk::MemoryKind::Readback : vk::MemoryKind::Device,
                       .name = "exported output",
                       .exported = !cpu}};
  }
  return {memory.release(), [pool = shared_from_this()](ExportedMemory* back) {
            std::lock_guard lock(pool->mutex_);
            pool->free_.emplace_back(back);
          }};
}

std::vector<ExportedArray> exportedArrays(vk::Device& device, ExportPool& pool, const Settings& settings, uint32_t rows,
                                          size_t views) {
  std::vector<ExportedArray> arrays;
  const auto add = [&](std::optional<output::Aov> aov, uint32_t channels, uint64_t texelBytes) {
    const uint64_t rowBytes = texelBytes * settings.width;
    arrays.push_back(
        {aov, views, rows, settings.width, channels, rowBytes, pool.take(device, rowBytes * rows * views)});
  };
  if (settings.display) add(std::nullopt, 4, 4);
  for (const output::Aov aov : settings.aovs) add(aov, output::info(aov).channels, 4 * output::info(aov).channels);
  return arrays;
}

}  // namespace latelight::render
