// Arrays of numbers of all worlds, as calls of the public API give them.
#pragma once

#include <latelight/latelight.h>

#include <cstdint>
#include <string>

#include "vk/device.h"

namespace latelight {

enum class ElementKind : uint8_t { Numbers, Mask, Integers };

uint64_t elementBytes(const WorldArray& array);

// Throws Error(Usage) unless the array has elements of this kind, and begins at a multiple of 16 bytes of one memory,
// that of the host or of this device. `name`: the array in messages, such as "WorldRays::origins".
void checkWorldArray(const WorldArray& array, ElementKind kind, const vk::Device& device, const std::string& name);

}  // namespace latelight
