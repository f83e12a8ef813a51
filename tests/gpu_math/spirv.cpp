#include "gpu_math/spirv.h"

#include <fmt/format.h>

#include <cstring>
#include <fstream>
#include <iterator>
#include <stdexcept>

namespace latelight::test {

std::vector<uint32_t> readSpirv(const std::string& name) {
  const std::string path = fmt::format("{}/{}.spv", LATELIGHT_TEST_SPIRV, name);
  std::ifstream file(path, std::ios::binary);
  const std::vector<char> bytes((std::istreambuf_iterator<char>(file)), std::istreambuf_iterator<char>());
  if (bytes.empty()) throw std::runtime_error(fmt::format("{} cannot be read", path));
  std::vector<uint32_t> words(bytes.size() / 4);
  std::memcpy(words.data(), bytes.data(), words.size() * 4);
  return words;
}

}  // namespace latelight::test
