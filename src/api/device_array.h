// The private part of the public API's arrays in device memory.
#pragma once

#include <latelight/latelight.h>

#include <map>
#include <memory>
#include <string>

#include "base/fork.h"
#include "render/outputs/exported.h"
#include "vk/device.h"
#include "vk/resources.h"

namespace latelight {

struct DeviceArray::Impl {
  OwnerProcess owner;
  std::shared_ptr<vk::Device> device;  // destroyed after the memory
  std::shared_ptr<render::ExportedMemory> memory;
};

struct DeviceArrayMemory {
  static const vk::Buffer& bufferOf(const DeviceArray& array);
  static std::shared_ptr<const void> held(const DeviceArray& array);  // whoever holds it keeps the memory
  // Returns the memory of an array that a call uses. Throws Error(Usage) if the array is empty or in memory of another
  // device than the renderer's. `role`: the array in messages, such as "WorldRays::origins".
  static std::shared_ptr<render::ExportedMemory> of(const DeviceArray& array, const vk::Device& device,
                                                    const std::string& role);
  // Returns true if a non-empty array has `count` times `eachBytes` bytes from an offset on, whatever these numbers
  // are.
  static bool contains(const DeviceArray& array, uint64_t offset, uint64_t count, uint64_t eachBytes);
  // Throws Error(Usage) if two arrays are in the same memory, in which one output would overwrite the other.
  static void checkDistinct(const std::map<std::string, DeviceArray>& arrays);
  static render::ExportTargets targets(const std::map<std::string, DeviceArray>& arrays, const vk::Device& device);
};

}  // namespace latelight
