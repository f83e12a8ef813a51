#include "render/outputs/exported.h"

#include <algorithm>
#include <atomic>

#include "base/error.h"
#include "base/keep.h"

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
            keepForReuse(pool->free_, std::unique_ptr<ExportedMemory>(back));
          }};
}

std::vector<ExportedArray> exportedArrays(vk::Device& device, ExportPool& pool, const Settings& settings, uint32_t rows,
                                          size_t views, const ExportTargets& targets) {
  const ExportFormats& formats = settings.exports;
  std::vector<ExportedArray> arrays;
  const auto add = [&](std::optional<output::Aov> aov, uint32_t channels, uint32_t elementBytes, bool changed) {
    ExportedArray array{.aov = aov,
                        .views = views,
                        .rows = rows,
                        .columns = settings.width,
                        .channels = channels,
                        .elementBytes = elementBytes,
                        .channelsFirst = formats.channelsFirst};
    array.converted = changed || (formats.channelsFirst && channels > 1);
    const uint64_t bytes = array.viewBytes() * views;
    const auto target = targets.find(aov);
    if (target != targets.end() && target->second->buffer.size() < bytes)
      badUsage("an array to render into is smaller than the output: use one of a call with the same size and formats");
    array.memory = target != targets.end() ? target->second : pool.take(device, bytes);
    arrays.push_back(std::move(array));
  };
  if (settings.display) add(std::nullopt, formats.rgb ? 3 : 4, 1, formats.rgb);
  for (const output::Aov aov : settings.aovs) {
    const bool shorter = std::ranges::count(formats.shorter, aov) > 0;
    add(aov, output::info(aov).channels, shorter ? 2 : 4, shorter);
  }
  return arrays;
}

}  // namespace latelight::render
