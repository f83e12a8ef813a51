// Arrays of numbers of all worlds, as calls of the public API give them: their elements, checks and numbers.
#pragma once

#include <latelight/latelight.h>

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "vk/device.h"

namespace latelight {

enum class ElementKind : uint8_t { Numbers, Mask, Integers };

uint64_t elementBytes(const WorldArray& array);
uint32_t elementOf(const WorldArray& array);  // shared::kNumber*

// Throws Error(Usage) unless the array has elements of this kind, and begins at a multiple of 16 bytes of one memory,
// that of the host or of this device. `name`: the array in messages, such as "WorldRays::origins".
void checkWorldArray(const WorldArray& array, ElementKind kind, const vk::Device& device, const std::string& name);

// Throws Error(Usage) unless shaders can index an array of this many numbers, with 32 bits. `things`: in the message.
void checkIndexable(const char* things, uint64_t numbers);

// Return the first `count` numbers, or matrices, of an array. Those of the device's memory are read back after
// everything that was submitted.
std::vector<double> numbersOf(vk::Device& device, const WorldArray& array, size_t count);
std::vector<Transform> matricesOf(vk::Device& device, const WorldArray& array, size_t count);

// Returns true if all values are finite as floats.
bool areFinite(std::span<const double> values);

}  // namespace latelight
