// A shader's interface, from its SPIR-V: its bindings, push constants, specialization constants, and the memory layout
// of its structs. Names are available unless they were stripped.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "vk/pipeline.h"

namespace latelight::vk {

struct UsedBinding {
  uint32_t set, binding;
  std::optional<Binding> kind;  // Uniform where a pipeline may declare DynamicUniform; none: one that no pipeline has
  std::string name;
};

struct PushBlock {
  std::string name;
  uint32_t bytes;      // up to the end of the last member, without padding after it
  uint32_t alignment;  // of its largest scalar, to which C++ pads the struct
};

struct DeclaredConstant {
  uint32_t id;
  bool isWord;  // a bool or a 32-bit integer, the types that a Constant can have
  std::string name;
};

struct MemberLayout {
  std::string name;
  uint32_t offset;        // bytes
  uint32_t matrixStride;  // bytes from column to column; 0: not a matrix
};

struct StructLayout {
  std::string name;
  bool isBlock;     // a whole buffer or all push constants, not a part
  uint32_t bytes;   // up to the end of the last member
  uint32_t stride;  // bytes from element to element in arrays of it; 0: there is no such array
  std::vector<MemberLayout> members;
};

struct Reflection {
  std::vector<UsedBinding> bindings;  // that the entry point uses statically, including in functions that it calls
  std::optional<PushBlock> push;
  std::vector<DeclaredConstant> constants;
  std::vector<StructLayout> structs;  // all that have offsets; one name may stand for several types
};

// For a module with one entry point. Throws Error(Internal) where the words are not SPIR-V.
Reflection reflect(std::span<const uint32_t> code);

}  // namespace latelight::vk
