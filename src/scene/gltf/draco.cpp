// KHR_draco_mesh_compression: checks the sizes in a Draco header against the budget, decodes the mesh with Google's
// library, and converts its attributes to accessor elements.
#include "scene/gltf/draco.h"

#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wunused-parameter"
#include <draco/compression/decode.h>
#pragma GCC diagnostic pop

#include <algorithm>
#include <optional>

#include "base/error.h"

namespace latelight::scene::gltf {
namespace {

// Reads little-endian numbers of a Draco header; returns nullopt after its end.
class HeaderReader {
 public:
  explicit HeaderReader(Bytes bytes) : bytes_(bytes) {}

  std::optional<uint64_t> fixed(size_t size) {
    if (bytes_.size() - at_ < size) return std::nullopt;
    uint64_t value = 0;
    for (size_t i = 0; i < size; ++i) value |= uint64_t(bytes_[at_++]) << (8 * i);
    return value;
  }
  std::optional<uint64_t> varint() {  // 7 bits per byte, least significant first
    uint64_t value = 0;
    for (int shift = 0; shift < 35; shift += 7) {
      std::optional<uint64_t> byte = fixed(1);
      if (!byte) return std::nullopt;
      value |= (*byte & 127) << shift;
      if (!(*byte & 128)) return value;
    }
    return std::nullopt;
  }
  bool skip(std::optional<uint64_t> size) {
    if (!size || bytes_.size() - at_ < *size) return false;
    at_ += *size;
    return true;
  }
  size_t position() const { return at_; }

 private:
  Bytes bytes_;
  size_t at_ = 0;
};

// Skips one element of metadata except for the elements below it: named entries of bytes. Returns the number of
// elements below it.
std::optional<uint64_t> skipEntries(HeaderReader& reader) {
  const std::optional<uint64_t> entries = reader.varint();
  for (uint64_t i = 0; i < entries.value_or(0); ++i)
    if (!reader.skip(reader.fixed(1)) || !reader.skip(reader.varint())) return std::nullopt;
  return entries ? reader.varint() : std::nullopt;
}

// Skips a tree of metadata, whose elements are stored depth first. Elements below the first one have names. Returns
// false if the tree is incomplete, or so deep that its destructor, which is recursive, could overflow the stack.
bool skipMetadata(HeaderReader& reader) {
  constexpr size_t kMaxDepth = 100;
  std::optional<uint64_t> below = skipEntries(reader);
  if (!below) return false;
  std::vector<uint64_t> left{*below};  // elements that follow, per level
  while (!left.empty()) {
    if (left.back() == 0) {
      left.pop_back();
      continue;
    }
    --left.back();
    if (left.size() == kMaxDepth || !reader.skip(reader.fixed(1))) return false;
    below = skipEntries(reader);
    if (!below) return false;
    left.push_back(*below);
  }
  return true;
}

// Skips the metadata of all attributes, each after the attribute's id, and of the mesh.
bool skipAllMetadata(HeaderReader& reader) {
  const std::optional<uint64_t> attributes = reader.varint();
  for (uint64_t i = 0; i < attributes.value_or(0); ++i)
    if (!reader.varint() || !skipMetadata(reader)) return false;
  return attributes && skipMetadata(reader);
}

struct Sizes {
  uint64_t faces = 0, points = 0, metadata = 0;  // the last in bytes
};

// Returns the sizes that the decoder will allocate. They are read in advance because the decoder trusts the header
// (Draco bitstream 2.2, the version that the extension names; sections "Header", "Metadata", "Sequential connectivity"
// and "EdgeBreaker connectivity").
std::optional<Sizes> peekSizes(Bytes data) {
  constexpr uint64_t kMesh = 1, kMetadataFlag = 0x8000;
  HeaderReader reader(data);
  std::optional<uint64_t> magic = reader.fixed(5), major = reader.fixed(1), minor = reader.fixed(1);
  std::optional<uint64_t> type = reader.fixed(1), method = reader.fixed(1), flags = reader.fixed(2);
  constexpr uint64_t kMagic = 0x4F43415244;  // "DRACO"
  if (!flags || *magic != kMagic || *type != kMesh || *major != 2 || *minor < 2) return std::nullopt;
  const size_t begin = reader.position();
  if (*flags & kMetadataFlag && !skipAllMetadata(reader)) return std::nullopt;
  const uint64_t metadata = reader.position() - begin;
  if (*method == 1) reader.fixed(1);  // EdgeBreaker: the traversal method
  std::optional<uint64_t> first = reader.varint(), second = reader.varint();
  if (!first || !second) return std::nullopt;
  if (*method == 1) return Sizes{.faces = *second, .points = *first, .metadata = metadata};
  return Sizes{.faces = *first, .points = *second, .metadata = metadata};
}

template <typename T>
bool convertPoints(const draco::Mesh& mesh, const draco::PointAttribute& attribute, size_t components, T* out) {
  for (draco::PointIndex i(0); i < mesh.num_points(); ++i, out += components) {
    draco::AttributeValueIndex value = attribute.mapped_index(i);
    if (value.value() >= attribute.size() || !attribute.ConvertValue<T>(value, int8_t(components), out)) return false;
  }
  return true;
}

bool convert(const draco::Mesh& mesh, const draco::PointAttribute& attribute, const Elements& e, std::byte* out) {
  switch (e.componentType) {
    case file::kByte:
      return convertPoints(mesh, attribute, e.components, reinterpret_cast<int8_t*>(out));
    case file::kUnsignedByte:
      return convertPoints(mesh, attribute, e.components, reinterpret_cast<uint8_t*>(out));
    case file::kShort:
      return convertPoints(mesh, attribute, e.components, reinterpret_cast<int16_t*>(out));
    case file::kUnsignedShort:
      return convertPoints(mesh, attribute, e.components, reinterpret_cast<uint16_t*>(out));
    case file::kUnsignedInt:
      return convertPoints(mesh, attribute, e.components, reinterpret_cast<uint32_t*>(out));
    default:
      return convertPoints(mesh, attribute, e.components, reinterpret_cast<float*>(out));
  }
}

// The accessor specifies the type of the values, and Draco their number. The accessor's count is ignored, because many
// files state that of the mesh before its compression (glTF's issue 1342).
Elements readAttribute(const Document& document, const draco::Mesh& mesh, int uniqueId, int accessorIndex,
                       const std::string& name) {
  const file::Accessor& accessor = document.model.accessors[size_t(accessorIndex)];
  const draco::PointAttribute* attribute = mesh.GetAttributeByUniqueId(uint32_t(uniqueId));
  if (!attribute) badInput("{} has no compressed attribute {}", name, uniqueId);
  size_t component = componentBytes(accessor.componentType);
  const size_t components = accessor.columns * accessor.rows;
  if (component == 0 || components > 4) badInput("{} has an accessor of an unusable type", name);
  if (components != size_t(attribute->num_components()))
    badInput("{} has {} compressed components per vertex, but accessors[{}] has {}", name, attribute->num_components(),
             accessorIndex, components);
  Elements elements{.count = mesh.num_points(),
                    .stride = component * components,
                    .componentType = accessor.componentType,
                    .components = components,
                    .columns = accessor.columns,
                    .normalized = accessor.normalized,
                    .name = fmt::format("accessors[{}]", accessorIndex)};
  size_t bytes = elements.count * elements.stride;
  document.budget.charge(bytes, name);
  elements.owned = std::make_shared_for_overwrite<std::byte[]>(bytes);
  elements.data = elements.owned.get();
  if (!convert(mesh, *attribute, elements, elements.owned.get())) badInput("{} cannot be decompressed", name);
  return elements;
}

std::unique_ptr<draco::Mesh> decodeBytes(const Document& document, Bytes data, const std::string& name) {
  std::optional<Sizes> sizes = peekSizes(data);
  if (!sizes) badInput("{} is not a mesh of Draco's bitstream 2.2", name);
  // The decoder requires about 100 bytes per face or point for connectivity and attributes, and per byte of metadata
  // for its tree.
  document.budget.charge((sizes->faces + sizes->points + sizes->metadata) * 100, name);
  draco::DecoderBuffer buffer;
  buffer.Init(reinterpret_cast<const char*>(data.data()), data.size());
  draco::Decoder decoder;
  auto result = decoder.DecodeMeshFromBuffer(&buffer);
  if (!result.ok()) badInput("{} cannot be decompressed: {}", name, result.status().error_msg_string());
  return std::move(result).value();
}

}  // namespace

DracoMesh decodeDraco(const Document& document, const file::Primitive& primitive, const std::string& name) {
  Bytes data = document.views[size_t(primitive.draco->bufferView)].bytes;
  std::unique_ptr<draco::Mesh> mesh = decodeBytes(document, data, name);

  DracoMesh out;
  out.indices.resize(size_t(mesh->num_faces()) * 3);
  for (draco::FaceIndex f(0); f < mesh->num_faces(); ++f)
    for (int i = 0; i < 3; ++i) out.indices[size_t(f.value()) * 3 + size_t(i)] = mesh->face(f)[size_t(i)].value();

  if (primitive.draco->attributes.empty()) badInput("{} has no compressed attributes", name);
  for (const auto& [key, uniqueId] : primitive.draco->attributes) {
    auto accessor = primitive.attributes.find(key);
    if (accessor == primitive.attributes.end()) continue;
    out.attributes[key] = readAttribute(document, *mesh, uniqueId, accessor->second, fmt::format("{}'s {}", name, key));
  }
  return out;
}

}  // namespace latelight::scene::gltf
