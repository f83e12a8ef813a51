#include "api/worlds/world_array.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>

#include "api/device_array.h"
#include "base/error.h"
#include "render/gpu_scene/world_inputs_push.h"
#include "vk/read_back.h"

namespace latelight {

namespace {

ElementKind kindOf(WorldArray::Element element) {
  using enum WorldArray::Element;
  if (element == Uint8) return ElementKind::Mask;
  return element == Int32 || element == Int64 ? ElementKind::Integers : ElementKind::Numbers;
}

std::vector<std::byte> readBack(vk::Device& device, const WorldArray& array, uint64_t bytes) {
  std::vector<std::byte> host(bytes);
  vk::readBack(device, DeviceArrayMemory::bufferOf(*array.device), array.offset, host);
  return host;
}

}  // namespace

uint64_t elementBytes(const WorldArray& array) {
  using enum WorldArray::Element;
  if (array.element == Uint8) return 1;
  return array.element == Float64 || array.element == Int64 ? 8 : 4;
}

uint32_t elementOf(const WorldArray& array) {
  using enum WorldArray::Element;
  if (array.element == Int32) return shared::kNumberInt;
  if (array.element == Int64) return shared::kNumberLong;
  return array.element == Float64 ? shared::kNumberDouble : shared::kNumberFloat;
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

void checkIndexable(const char* things, uint64_t numbers) {
  if (numbers > std::numeric_limits<uint32_t>::max())
    badUsage("an array that describes {} of worlds must have fewer than 2^32 numbers: render fewer worlds per call",
             things);
}

std::vector<double> numbersOf(vk::Device& device, const WorldArray& array, size_t count) {
  std::vector<std::byte> copied;
  const void* numbers = array.host;
  if (array.device) numbers = (copied = readBack(device, array, count * elementBytes(array))).data();
  const auto all = [&]<typename T>(const T* from) { return std::vector<double>(from, from + count); };
  using enum WorldArray::Element;
  if (array.element == Float64) return all(static_cast<const double*>(numbers));
  if (array.element == Float32) return all(static_cast<const float*>(numbers));
  if (array.element == Int32) return all(static_cast<const int32_t*>(numbers));
  if (array.element == Int64) return all(static_cast<const int64_t*>(numbers));
  return all(static_cast<const uint8_t*>(numbers));
}

std::vector<Transform> matricesOf(vk::Device& device, const WorldArray& array, size_t count) {
  const size_t size = 4 * array.rows;
  const std::vector<double> numbers = numbersOf(device, array, count * size);
  std::vector<Transform> matrices(count, Transform{0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1});
  for (size_t i = 0; i < count; ++i)
    std::copy_n(numbers.begin() + static_cast<std::ptrdiff_t>(i * size), size, matrices[i].begin());
  return matrices;
}

bool areFinite(std::span<const double> values) {
  return std::ranges::all_of(values, [](double value) { return std::isfinite(static_cast<float>(value)); });
}

}  // namespace latelight
