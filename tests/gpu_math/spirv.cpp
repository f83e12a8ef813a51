#include "gpu_math/spirv.h"

#include <fmt/format.h>

#include <cstring>
#include <fstream>
#include <iterator>
#include <stdexcept>

namespace latelight::test {
namespace {

// Opcodes and decorations of the SPIR-V specification, 1.6.
enum : uint32_t { kOpName = 5, kOpMemberName = 6, kOpTypeArray = 28, kOpTypeRuntimeArray = 29 };
enum : uint32_t { kOpDecorate = 71, kOpMemberDecorate = 72 };
enum : uint32_t { kArrayStride = 6, kMatrixStride = 7, kOffset = 35 };
constexpr size_t kHeaderWords = 5;

struct Tables {
  std::map<uint32_t, std::string> names;                       // id -> name
  std::map<uint32_t, std::map<uint32_t, std::string>> member;  // struct -> index -> name
  std::map<uint32_t, std::map<uint32_t, uint32_t>> offset, matrixStride;
  std::map<uint32_t, uint32_t> arrayStride;   // array type -> bytes
  std::map<uint32_t, uint32_t> arrayElement;  // array type -> element type
};

std::string text(const uint32_t* words) {
  return reinterpret_cast<const char*>(words);
}

void readInstruction(Tables& tables, uint32_t opcode, const uint32_t* operands, size_t count) {
  switch (opcode) {
    case kOpName:
      tables.names[operands[0]] = text(operands + 1);
      break;
    case kOpMemberName:
      tables.member[operands[0]][operands[1]] = text(operands + 2);
      break;
    case kOpTypeArray:
    case kOpTypeRuntimeArray:
      tables.arrayElement[operands[0]] = operands[1];
      break;
    case kOpDecorate:
      if (count > 2 && operands[1] == kArrayStride) tables.arrayStride[operands[0]] = operands[2];
      break;
    case kOpMemberDecorate:
      if (count > 3 && operands[2] == kOffset) tables.offset[operands[0]][operands[1]] = operands[3];
      if (count > 3 && operands[2] == kMatrixStride) tables.matrixStride[operands[0]][operands[1]] = operands[3];
      break;
    default:
      break;
  }
}

}  // namespace

std::vector<uint32_t> readSpirv(const std::string& name) {
  const std::string path = fmt::format("{}/{}.spv", LATELIGHT_TEST_SPIRV, name);
  std::ifstream file(path, std::ios::binary);
  const std::vector<char> bytes((std::istreambuf_iterator<char>(file)), std::istreambuf_iterator<char>());
  if (bytes.size() < 4 * kHeaderWords) throw std::runtime_error(fmt::format("{} is not a SPIR-V module", path));
  std::vector<uint32_t> words(bytes.size() / 4);
  std::memcpy(words.data(), bytes.data(), words.size() * 4);
  return words;
}

std::map<std::string, StructLayout> structLayouts(const std::vector<uint32_t>& words) {
  Tables tables;
  for (size_t at = kHeaderWords; at < words.size(); at += words[at] >> 16)
    readInstruction(tables, words[at] & 0xffff, &words[at] + 1, (words[at] >> 16) - 1);

  std::map<uint32_t, uint32_t> strides;  // element type -> bytes
  for (const auto& [array, element] : tables.arrayElement)
    if (tables.arrayStride.count(array)) strides[element] = tables.arrayStride[array];

  std::map<std::string, StructLayout> layouts;
  for (const auto& [id, offsets] : tables.offset) {
    StructLayout layout;
    for (const auto& [index, offset] : offsets) {
      layout.members.push_back(tables.member[id][index]);
      layout.offsets.push_back(offset);
    }
    layout.matrices = tables.matrixStride[id];
    layout.stride = strides.count(id) ? strides[id] : 0;
    layouts[tables.names[id]] = layout;
  }
  return layouts;
}

}  // namespace latelight::test
