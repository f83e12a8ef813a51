#include "api/world_array.h"

#include "api/device_array.h"
#include "base/error.h"

namespace latelight {

namespace {

ElementKind kindOf(WorldArray::Element element) {
  using enum WorldArray::Element;
  if (element == Uint8) return ElementKind::Mask;
  return element == Int32 || element == Int64 ? ElementKind::Integers : ElementKind::Numbers;
}

}  // namespace

uint64_t elementBytes(const WorldArray& array) {
  using enum WorldArray::Element;
  if (array.element == Uint8) return 1;
  return array.element == Float64 || array.element == Int64 ? 8 : 4;
}

void checkWorldArray(const WorldArray& array, ElementKind kind, const vk::Device& device, const std::string& name) {
  if (static_cast<size_t>(array.element) > static_cast<size_t>(WorldArray::Element::Int64))
    badUsage("{} has unknown elements {}: choose one of WorldArray::Element", name, static_cast<int>(array.element));
  constexpr const char* kElements[] = {"Float32 or Float64", "Uint8", "Int32 or Int64"};
  if (kindOf(array.element) != kind)
    badUsage("{} must have elements of the type {}", name, kElements[static_cast<size_t>(kind)]);
  if (array.host && array.device) badUsage("{} must be in one memory only", name);
  if (array.offset % 16 != 0) badUsage("{} must begin at a multiple of 16 bytes", name);
  if (array.device) DeviceArrayMemory::of(*array.device, device, name);
}

}  // namespace latelight
