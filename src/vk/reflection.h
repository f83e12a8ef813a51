// What a shader's SPIR-V says of its interface: what it binds, its push constants, its specialization constants, and
// how the structs lie that it has in memory. Names are there unless they were stripped.
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
  uint32_t bytes;      // up to the end of the last member, padding behind it left out
  uint32_t alignment;  // of its largest scalar, which C++ pads the struct to
};

struct DeclaredConstant {
  uint32_t id;
  bool isWord;  // a bool or a 32-bit integer, which is what a Constant can be
  std::string name;
};

struct MemberLayout {
  std::string name;
  uint32_t offset;        // bytes
  uint32_t matrixStride;  // bytes from column to column; 0: no matrix
};

struct StructLayout {
  std::string name;
  bool isBlock;     // the whole of a buffer or of the push constants, not a part
  uint32_t bytes;   // up to the end of the last member
  uint32_t stride;  // bytes from element to element of arrays of it; 0: there is no such array
  std::vector<MemberLayout> members;
};

struct Reflection {
  std::vector<UsedBinding> bindings;  // that the entry point uses statically, in functions that it calls too
  std::optional<PushBlock> push;
  std::vector<DeclaredConstant> constants;
  std::vector<StructLayout> structs;  // all that have offsets; one name may stand for several types
};

// Of a module with one entry point. Throws Error(Internal) where the words are no SPIR-V.
Reflection reflect(std::span<const uint32_t> code);

}  // namespace latelight::vk
