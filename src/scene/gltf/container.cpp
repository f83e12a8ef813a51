// Converts a file's bytes to validated JSON: reads the GLB container (glTF 2.0, chapter 4) and checks the version.
#include <string_view>

#include "base/error.h"
#include "base/log.h"
#include "scene/gltf/document.h"
#include "scene/gltf/schema.h"

namespace latelight::scene::gltf {
namespace {

constexpr uint32_t kMagic = 0x46546C67;  // "glTF"
constexpr uint32_t kJsonChunk = 0x4E4F534A;
constexpr uint32_t kBinaryChunk = 0x004E4942;
constexpr size_t kHeaderBytes = 12, kChunkHeaderBytes = 8;
constexpr size_t kMaxJsonBytes = 1u << 30;
constexpr int kMaxDepth = 128;  // printing JSON recurses

uint32_t wordAt(Bytes bytes, size_t at) {  // GLB is little-endian
  uint32_t word = 0;
  for (size_t i = 0; i < 4; ++i) word |= uint32_t(bytes[at + i]) << (8 * i);
  return word;
}

// Returns true if a chunk's header and its bytes fit into the file.
bool chunkFits(Bytes file, size_t at) {
  return at + kChunkHeaderBytes <= file.size() && wordAt(file, at) <= file.size() - at - kChunkHeaderBytes;
}

// Returns the start of the chunk after one that ends at `end`. Chunks are padded to 4 bytes, and their lengths include
// the padding. Some writers pad without including it, others do neither.
size_t endOfChunk(Bytes file, size_t end, bool isJson) {
  const size_t padded = (end + 3) / 4 * 4;
  if (padded == end || end + kChunkHeaderBytes > file.size() || chunkFits(file, padded)) return padded;
  const char* which = isJson ? "JSON" : "binary";
  if (!chunkFits(file, end))
    badInput("the .glb file's {} chunk ends at byte {}, which is not a multiple of 4, and no other chunk follows",
             which, end);
  warn("the .glb file's {} chunk ends at byte {} instead of a multiple of 4, as glTF requires", which, end);
  return end;
}

Container readBinary(Bytes file) {
  if (file.size() < kHeaderBytes + kChunkHeaderBytes) badInput("the .glb file ends within its header");
  uint32_t version = wordAt(file, 4), length = wordAt(file, 8);
  if (version != 2) badInput("it is a version {} .glb file; version 2 is supported: convert it", version);
  if (length > file.size())
    badInput("the .glb file should be {} bytes long but ends after {}: copy it again", length, file.size());
  file = file.first(length);
  Container container;
  bool first = true;
  for (size_t at = kHeaderBytes; at + kChunkHeaderBytes <= file.size(); first = false) {
    uint32_t size = wordAt(file, at), type = wordAt(file, at + 4);
    at += kChunkHeaderBytes;
    if (size > file.size() - at)
      badInput("a chunk of the .glb file reaches {} bytes past its end", size - (file.size() - at));
    Bytes chunk = file.subspan(at, size);
    if (first != (type == kJsonChunk)) badInput("the .glb file's first chunk, and only that, must be JSON");
    if (type == kJsonChunk) container.json = chunk;
    if (type == kBinaryChunk && container.binary.empty()) container.binary = chunk;
    at = endOfChunk(file, at + size, type == kJsonChunk);
  }
  if (container.json.empty()) badInput("the .glb file has no JSON chunk");
  return container;
}

// Checks nesting on the text, before any parser or printer recurses over it.
void checkDepth(std::string_view text) {
  int depth = 0;
  bool inString = false;
  for (size_t i = 0; i < text.size(); ++i) {
    char c = text[i];
    if (inString) {
      if (c == '\\')
        ++i;
      else if (c == '"')
        inString = false;
    } else if (c == '"') {
      inString = true;
    } else if (c == '{' || c == '[') {
      if (++depth > kMaxDepth) badInput("its JSON is nested more than {} levels deep", kMaxDepth);
    } else if (c == '}' || c == ']') {
      --depth;
    }
  }
}

void checkVersion(const nlohmann::json& root) {
  const nlohmann::json& asset = root["asset"];
  std::string version = asset["version"].get<std::string>();
  if (version.substr(0, 2) != "2.") badInput("it is glTF {}; 2.0 is supported: convert it", version);
  if (!asset.contains("minVersion")) return;
  std::string least = asset["minVersion"].get<std::string>();
  if (least != "2.0") badInput("it requires glTF {}; 2.0 is supported", least);
}

}  // namespace

Container readContainer(Bytes file) {
  if (file.size() >= 4 && wordAt(file, 0) == kMagic) return readBinary(file);
  return {file, {}};
}

uint64_t treeBytes(Bytes json) {
  // Sizes in nlohmann::json on 64 bits: a value is 16 bytes, in a vector that grows by doubling; an object is a map of
  // nodes, each with its key's string. The contents of strings are at most as large as the text.
  constexpr uint64_t kValue = 32, kArray = 48, kObject = 64, kMember = 112;
  uint64_t bytes = json.size();
  bool inString = false;
  for (size_t i = 0; i < json.size(); ++i) {
    const char c = char(json[i]);
    if (inString) {
      i += c == '\\';
      inString = c != '"';
    } else if (c == '"') {
      inString = true;
    } else {
      bytes += c == ',' ? kValue : c == ':' ? kMember : c == '[' ? kArray : c == '{' ? kObject : 0;
    }
  }
  return bytes;
}

JsonTree readJson(Bytes bytes) {
  std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  if (text.empty()) badInput("the file is empty");
  if (text.size() > kMaxJsonBytes) badInput("its JSON is larger than 1 GiB");
  checkDepth(text);
  JsonTree tree;
  try {
    tree = nlohmann::json::parse(text);
  } catch (const nlohmann::json::exception& error) {
    std::string_view reason = error.what();  // "[json.exception.parse_error.101] parse error at line 1, ..."
    reason.remove_prefix(std::min(reason.size(), reason.find("] ") + 2));
    badInput("it is not glTF: {}", reason);
  }
  nlohmann::json& root = *tree;
  if (!root.is_object() || !root.contains("asset")) badInput("it is not glTF: its JSON has no \"asset\"");
  // Report an unsupported version or extension before detailed errors.
  if (root["asset"].is_object() && root["asset"].contains("version") && root["asset"]["version"].is_string())
    checkVersion(root);
  checkExtensions(root);
  validate(root);
  return tree;
}

}  // namespace latelight::scene::gltf
