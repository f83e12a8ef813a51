// Writes accessors, and the GLB container (glTF 2.0, chapter 4).
#include "export/document.h"

#include <algorithm>
#include <array>
#include <charconv>

#include "base/error.h"

namespace latelight::exports {
namespace {

constexpr int kUnsignedByte = 5121, kUnsignedShort = 5123, kUnsignedInt = 5125, kFloat = 5126;

size_t componentsOf(std::string_view type) {
  return type == "SCALAR" ? 1 : type == "MAT4" ? 16 : static_cast<size_t>(type[3] - '0');
}

void append(std::vector<std::byte>& file, const void* data, size_t size) {
  const auto* bytes = static_cast<const std::byte*>(data);
  file.insert(file.end(), bytes, bytes + size);
}

void appendWords(std::vector<std::byte>& file, std::initializer_list<uint32_t> words) {
  for (const uint32_t word : words) append(file, &word, sizeof(word));  // GLB and all supported machines: little-endian
}

}  // namespace

double shortest(float value) {
  std::array<char, 32> text;
  const auto end = std::to_chars(text.begin(), text.end(), value).ptr;
  double result = value;
  std::from_chars(text.begin(), end, result);
  return result;
}

size_t Document::add(const char* key, Json element) {
  Json& list = arrayIn(root, key);
  list.push_back(std::move(element));
  return list.size() - 1;
}

size_t Document::addView(std::span<const std::byte> bytes, Target target) {
  binary_.resize((binary_.size() + 3) / 4 * 4);
  Json view{{"buffer", 0}, {"byteOffset", binary_.size()}, {"byteLength", bytes.size()}};
  if (target != Target::None) view["target"] = static_cast<int>(target);
  binary_.insert(binary_.end(), bytes.begin(), bytes.end());
  return add("bufferViews", std::move(view));
}

size_t Document::addAccessor(std::span<const std::byte> bytes, int componentType, const char* type, size_t count,
                             Target target) {
  const size_t view = addView(bytes, target);
  return add("accessors", {{"bufferView", view}, {"componentType", componentType}, {"count", count}, {"type", type}});
}

size_t Document::addNumbers(std::span<const float> values, const char* type, Target target) {
  return addAccessor(std::as_bytes(values), kFloat, type, values.size() / componentsOf(type), target);
}

size_t Document::addPositions(std::span<const glm::vec3> positions) {
  glm::vec3 low = positions[0], high = positions[0];
  for (const glm::vec3& p : positions) low = glm::min(low, p), high = glm::max(high, p);
  const size_t index = addVectors(positions);
  root["accessors"][index]["min"] = arrayOf(low);
  root["accessors"][index]["max"] = arrayOf(high);
  return index;
}

size_t Document::addIndices(std::span<const uint32_t> indices) {
  const uint32_t highest = indices.empty() ? 0 : *std::ranges::max_element(indices);
  if (highest >= 65535)  // the value that restarts primitives
    return addAccessor(std::as_bytes(indices), kUnsignedInt, "SCALAR", indices.size(), Target::Indices);
  const std::vector<uint16_t> narrow(indices.begin(), indices.end());
  return addAccessor(std::as_bytes(std::span(narrow)), kUnsignedShort, "SCALAR", indices.size(), Target::Indices);
}

size_t Document::addMatrices(std::span<const glm::mat4> matrices) {
  return addAccessor(std::as_bytes(matrices), kFloat, "MAT4", matrices.size(), Target::None);
}

size_t Document::addBytes(std::span<const uint8_t> values) {
  return addAccessor(std::as_bytes(values), kUnsignedByte, "SCALAR", values.size(), Target::None);
}

size_t Document::addJoints(std::span<const uint16_t> joints) {
  return addAccessor(std::as_bytes(joints), kUnsignedShort, "VEC4", joints.size() / 4, Target::Vertices);
}

size_t Document::addZeros(size_t count) {
  return add("accessors",
             {{"componentType", kFloat}, {"count", count}, {"type", "VEC3"}, {"min", {0, 0, 0}}, {"max", {0, 0, 0}}});
}

std::vector<std::byte> Document::glb() {
  binary_.resize((binary_.size() + 3) / 4 * 4);
  if (!binary_.empty()) root["buffers"] = Json::array({{{"byteLength", binary_.size()}}});
  if (!extensions_.empty()) root["extensionsUsed"] = extensions_;
  std::string text = root.dump(-1, ' ', false, Json::error_handler_t::replace);
  text.resize((text.size() + 3) / 4 * 4, ' ');
  const uint64_t total = 12 + 8 + text.size() + (binary_.empty() ? 0 : 8 + binary_.size());
  if (total > UINT32_MAX)
    badUsage("the scene has {} MiB, more than a .glb file can hold (4 GiB): export a part of it", total >> 20);
  constexpr uint32_t kMagic = 0x46546C67, kJson = 0x4E4F534A, kBinary = 0x004E4942;
  std::vector<std::byte> file;
  file.reserve(total);
  appendWords(file, {kMagic, 2, static_cast<uint32_t>(total), static_cast<uint32_t>(text.size()), kJson});
  append(file, text.data(), text.size());
  if (binary_.empty()) return file;
  appendWords(file, {static_cast<uint32_t>(binary_.size()), kBinary});
  append(file, binary_.data(), binary_.size());
  return file;
}

}  // namespace latelight::exports
