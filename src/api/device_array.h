// The private part of the public API's arrays in device memory.
#pragma once

#include <latelight/latelight.h>

#include <map>
#include <memory>
#include <string>

#include "render/outputs/exported.h"
#include "vk/resources.h"

namespace latelight {

struct DeviceArrayMemory {
  static const vk::Buffer& bufferOf(const DeviceArray& array);
  static std::shared_ptr<const void> of(const DeviceArray& array);  // whoever holds it keeps the memory
  static render::ExportTargets targets(const std::map<std::string, DeviceArray>& arrays);
};

}  // namespace latelight
