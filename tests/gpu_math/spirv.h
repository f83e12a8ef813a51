// SPIR-V of shaders that only tests use.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace latelight::test {

// Returns the words of `name`.spv in the build's folder of test shaders. Throws if the file cannot be read.
std::vector<uint32_t> readSpirv(const std::string& name);

}  // namespace latelight::test
