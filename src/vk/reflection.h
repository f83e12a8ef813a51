// Shader reflection: extracts the interface of a shader from its SPIR-V. The interface consists of the bindings, push
// constants, specialization constants, and the memory layout of its structs. Names are available unless they were
// stripped.
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
  std::optional<Binding> kind;  // Uniform also stands for DynamicUniform; empty: a type that no pipeline supports
  std::string name;
};

struct PushBlock {
  std::string name;
  uint32_t bytes;      // up to the end of the last member, without padding after it
  uint32_t alignment;  // of its largest scalar; C++ pads the struct to a multiple of it
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
  bool isBlock;     // a complete buffer or push constant block, not a part
  uint32_t bytes;   // up to the end of the last member
  uint32_t stride;  // bytes from element to element in arrays of this struct; 0: no array of it exists
  std::vector<MemberLayout> members;
};

struct Reflection {
  std::vector<UsedBinding> bindings;  // that the entry point and the functions that it calls use statically
  std::optional<PushBlock> push;
  std::vector<DeclaredConstant> constants;
  std::vector<StructLayout> structs;  // all structs with offsets; several types may have the same name
};

// Requires a module with one entry point. Throws Error(Internal) if the words are not SPIR-V.
Reflection reflect(std::span<const uint32_t> code);

}  // namespace latelight::vk
