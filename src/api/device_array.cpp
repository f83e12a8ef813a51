// Arrays in the memory of a device.
#include "api/device_array.h"

#include <algorithm>
#include <cstring>
#include <iterator>
#include <optional>
#include <utility>

#include "api/renderer.h"
#include "base/error.h"
#include "base/log.h"
#include "output/aov.h"
#include "vk/read_back.h"

namespace latelight {

namespace {

// Returns the bytes of the array's elements. The renderer's memory may be larger than the array, and a caller may have
// changed the array's public shape.
uint64_t bytesOf(const DeviceArray& array) {
  using enum DeviceArray::Element;
  uint64_t bytes = array.element == Uint8 ? 1 : array.element == Float16 || array.element == Uint16 ? 2 : 4;
  for (const uint64_t length : array.shape) bytes *= length;
  return std::min(bytes, uint64_t{DeviceArrayMemory::bufferOf(array).size()});
}

}  // namespace

const vk::Buffer& DeviceArrayMemory::bufferOf(const DeviceArray& array) {
  return array.impl_->memory->buffer;
}
std::shared_ptr<const void> DeviceArrayMemory::held(const DeviceArray& array) {
  return array.impl_->memory;
}
std::shared_ptr<render::ExportedMemory> DeviceArrayMemory::of(const DeviceArray& array, const vk::Device& device,
                                                              const std::string& role) {
  if (!array.impl_) badUsage("{} is empty", role);
  // Addresses and handles of Vulkan are those of a single VkDevice, even if two renderers share the physical device.
  if (array.impl_->device.get() != &device)
    badUsage("{} belongs to another renderer: use an array of the renderer that is called", role);
  return array.impl_->memory;
}
bool DeviceArrayMemory::contains(const DeviceArray& array, uint64_t offset, uint64_t count, uint64_t eachBytes) {
  const uint64_t size = bytesOf(array);
  return offset <= size && (count == 0 || eachBytes <= (size - offset) / count);
}
void DeviceArrayMemory::checkDistinct(const std::map<std::string, DeviceArray>& arrays) {
  for (auto a = arrays.begin(); a != arrays.end(); ++a)
    for (auto b = std::next(a); b != arrays.end(); ++b)
      if (a->second.impl_ && b->second.impl_ && a->second.impl_->memory == b->second.impl_->memory)
        badUsage("the outputs {} and {} have the same array: use one array per output", printable(a->first),
                 printable(b->first));
}

const DeviceArray::Impl& DeviceArray::filled() const {
  if (!impl_) badUsage("this array is empty: use one that takeArrays(), cast() or inputArray() has returned");
  return *impl_;
}
const void* DeviceArray::host() const {
  return filled().memory->buffer.mapped();
}
int DeviceArray::exportMemory() const {
  filled().owner.require("the array's device");
  if (host()) badUsage("the host has this array: it is read there");
  return filled().memory->buffer.exportMemory();
}
uint64_t DeviceArray::memoryBytes() const {
  return filled().memory->buffer.memorySize();
}
void DeviceArray::copyToHost(std::span<std::byte> to) const {
  filled().owner.require("the array's device");
  const vk::Buffer& from = filled().memory->buffer;
  const uint64_t bytes = bytesOf(*this);
  if (to.size() != bytes)
    badUsage("the array has {} bytes, but is to be copied to {} bytes: give it memory of its size", bytes, to.size());
  if (host()) {
    std::memcpy(to.data(), host(), to.size());
    return;
  }
  requireIdle(*filled().device);
  vk::readBack(*filled().device, from, 0, to);
}
std::string DeviceArray::deviceUuid() const {
  return filled().device->info().uuid;
}
void DeviceArray::attach(std::shared_ptr<void> object) const {
  filled().memory->attached = std::move(object);
}
std::shared_ptr<void> DeviceArray::attached() const {
  return filled().memory->attached;
}
void DeviceArray::beforeReuse(std::function<void()> call) const {
  filled().memory->beforeReuse = std::move(call);
}

render::ExportTargets DeviceArrayMemory::targets(const std::map<std::string, DeviceArray>& arrays,
                                                 const vk::Device& device) {
  render::ExportTargets targets;
  for (const auto& [name, array] : arrays) {
    const output::AovInfo* info = output::findAov(name);
    if (!info && name != "rgba") badUsage("there is no output \"{}\" to render into", printable(name));
    targets[info ? std::optional(info->aov) : std::nullopt] =
        of(array, device, fmt::format("the array to render {} into", name));
  }
  checkDistinct(arrays);
  return targets;
}

}  // namespace latelight
