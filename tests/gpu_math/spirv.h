// Reads SPIR-V: words from a file, and where the members of its structs lie.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

namespace latelight::test {

// The words of `name`.spv in the build's folder of test shaders. Throws Error where it cannot be read.
std::vector<uint32_t> readSpirv(const std::string& name);

struct StructLayout {
  std::vector<std::string> members;       // in order
  std::vector<uint32_t> offsets;          // bytes, one a member
  std::map<uint32_t, uint32_t> matrices;  // member -> bytes from column to column
  uint32_t stride = 0;                    // bytes from element to element of arrays of it; 0: there is no such array
};

// Every struct that has offsets (that lies in a buffer), by its GLSL name. Needs names (glslang -g).
std::map<std::string, StructLayout> structLayouts(const std::vector<uint32_t>& words);

}  // namespace latelight::test
