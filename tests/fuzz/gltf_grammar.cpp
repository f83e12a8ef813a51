#include "fuzz/gltf_grammar.h"

#include <array>
#include <cstring>

namespace latelight::fuzz {

namespace {

using Json = nlohmann::json;

constexpr uint32_t kMagic = 0x46546C67, kJsonChunk = 0x4E4F534A, kBinaryChunk = 0x004E4942;
constexpr int kMaxDepth = 24;
constexpr size_t kMaxParts = 4096;

// Members by the name of the object or array that contains them, each with values that it may have (glTF 2.0 and the
// extensions in docs/gltf.md). Indices and counts are changed further by replace().
const Json& grammar() {
  static const Json made = Json::parse(R"({
    "": {"scene": [0], "scenes": [[{"nodes": [0]}]], "nodes": [[{"mesh": 0}]], "skins": [[{"joints": [0]}]],
         "cameras": [[{"type": "orthographic", "orthographic": {"xmag": 1, "ymag": 1, "zfar": 9, "znear": 0}}]],
         "materials": [[{}]], "textures": [[{"source": 0}]], "samplers": [[{}]], "extensions": [{}],
         "images": [[{"bufferView": 0, "mimeType": "image/png"}], [{"uri": "data:image/png;base64,iVBORw0KGgo="}]],
         "animations": [[{"channels": [{"sampler": 0, "target": {"node": 0, "path": "weights"}}],
                          "samplers": [{"input": 0, "output": 1}]}]]},
    "nodes": {"children": [[1], [0, 2]], "translation": [[1, 2, 3]], "rotation": [[0, 0, 0, 1], [0.5, 0.5, 0.5, 0.5]],
              "scale": [[1, 1, 1], [0, 1, -1]], "matrix": [[1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]],
              "mesh": [0], "skin": [0], "camera": [0], "weights": [[0.5]], "extensions": [{}], "name": ["n"],
              "extras": [{"areaLight": {"type": "rect"}}]},
    "areaLight": {"type": ["rect", "disk", "sphere", "tube"], "size": [0.5, 0, 1e30], "rect": [{"aspect": 2}],
                  "tube": [{"length": 3}], "intensity": [9, -1], "color": [[1, 0, 0]], "twoSided": [true],
                  "castShadow": [false], "name": ["l"]},
    "scenes": {"nodes": [[0], [1, 0]], "extensions": [{"EXT_lights_image_based": {"light": 0}}]},
    "accessors": {"bufferView": [0, 1, 2], "byteOffset": [0, 4, 8], "count": [1, 2, 3, 6, 1000],
                  "componentType": [5120, 5121, 5122, 5123, 5125, 5126], "normalized": [true, false],
                  "type": ["SCALAR", "VEC2", "VEC3", "VEC4", "MAT2", "MAT3", "MAT4"], "min": [[0, 0, 0]],
                  "sparse": [{"count": 1, "indices": {"bufferView": 0, "componentType": 5121},
                              "values": {"bufferView": 1}}]},
    "sparse": {"count": [1, 2, 3], "indices": [{"bufferView": 0, "componentType": 5123, "byteOffset": 2}],
               "values": [{"bufferView": 0, "byteOffset": 4}]},
    "bufferViews": {"buffer": [0], "byteOffset": [0, 4, 12], "byteLength": [4, 12, 36], "byteStride": [4, 8, 12, 16],
                    "target": [34962, 34963], "extensions": [{}]},
    "buffers": {"uri": ["data:,abcd", "data:application/octet-stream;base64,AAAAAAAAgD8=", "beside.bin", "../up.bin"],
                "byteLength": [1, 4, 36], "extensions": [{"EXT_meshopt_compression": {"fallback": true}}]},
    "primitives": {"attributes": [{"POSITION": 0}], "indices": [0, 1, 2], "material": [0], "mode": [0, 1, 4, 5, 6],
                   "targets": [[{"POSITION": 0, "NORMAL": 0, "TANGENT": 0}]], "extensions": [{}]},
    "attributes": {"POSITION": [0], "NORMAL": [0, 1], "TANGENT": [1, 2], "TEXCOORD_0": [1], "TEXCOORD_1": [1],
                   "COLOR_0": [2], "JOINTS_0": [3], "WEIGHTS_0": [4], "JOINTS_1": [3], "WEIGHTS_1": [4],
                   "TRANSLATION": [0], "ROTATION": [1], "SCALE": [0], "_CUSTOM": [0]},
    "targets": {"POSITION": [0], "NORMAL": [1], "TANGENT": [0]},
    "meshes": {"weights": [[0.5], [0, 1]], "primitives": [[{"attributes": {"POSITION": 0}}]], "name": ["m"]},
    "skins": {"joints": [[0], [1, 0]], "inverseBindMatrices": [0, 5], "skeleton": [0]},
    "cameras": {"type": ["perspective", "orthographic"], "perspective": [{"yfov": 1, "znear": 0.1}],
                "orthographic": [{"xmag": 1, "ymag": 1, "zfar": 9, "znear": 0}]},
    "perspective": {"zfar": [10], "aspectRatio": [1.5], "yfov": [0.5, 3], "znear": [0.01]},
    "channels": {"sampler": [0], "target": [{"node": 0, "path": "rotation"}, {"path": "pointer", "extensions":
                 {"KHR_animation_pointer": {"pointer": "/materials/0/pbrMetallicRoughness/baseColorFactor"}}}]},
    "target": {"node": [0, 1], "path": ["translation", "rotation", "scale", "weights", "pointer"], "extensions":
               [{"KHR_animation_pointer": {"pointer": "/nodes/0/scale"}},
                {"KHR_animation_pointer": {"pointer": "/extensions/KHR_lights_punctual/lights/0/intensity"}},
                {"KHR_animation_pointer": {"pointer": "/cameras/0/perspective/yfov"}}]},
    "samplers": {"input": [0], "output": [1], "interpolation": ["LINEAR", "STEP", "CUBICSPLINE"], "wrapS": [33071],
                 "magFilter": [9728], "minFilter": [9984]},
    "materials": {"pbrMetallicRoughness": [{"baseColorFactor": [1, 0, 0, 1]}], "normalTexture": [{"index": 0}],
                  "occlusionTexture": [{"index": 0, "strength": 0.5}], "emissiveTexture": [{"index": 0}],
                  "emissiveFactor": [[1, 1, 1]], "alphaMode": ["OPAQUE", "MASK", "BLEND"], "alphaCutoff": [0.3],
                  "doubleSided": [true], "extensions": [{}]},
    "pbrMetallicRoughness": {"baseColorFactor": [[1, 1, 1, 0.5]], "metallicFactor": [0.5], "roughnessFactor": [0],
                             "baseColorTexture": [{"index": 0, "texCoord": 1}],
                             "metallicRoughnessTexture": [{"index": 0}]},
    "baseColorTexture": {"texCoord": [0, 1, 2], "extensions":
                         [{"KHR_texture_transform": {"offset": [1, 2], "rotation": 1, "scale": [2, 2], "texCoord": 1}}]},
    "textures": {"source": [0], "sampler": [0], "extensions": [{"KHR_texture_basisu": {"source": 0}},
                 {"EXT_texture_webp": {"source": 0}}, {"EXT_texture_avif": {"source": 0}}]},
    "images": {"uri": ["data:image/png;base64,iVBORw0KGgo=", "a%20b.png"], "bufferView": [0], "name": ["i"]},
    "extensions": {
      "KHR_lights_punctual": [{"light": 0}, {"lights": [{"type": "point", "intensity": 9, "range": 4}]},
                              {"lights": [{"type": "spot", "spot": {"outerConeAngle": 0.4}}, {"type": "directional"}]}],
      "KHR_materials_variants": [{"variants": [{"name": "a"}]}, {"mappings": [{"material": 0, "variants": [0]}]}],
      "EXT_mesh_gpu_instancing": [{"attributes": {"TRANSLATION": 0, "ROTATION": 1}}],
      "KHR_node_visibility": [{"visible": false}], "KHR_materials_unlit": [{}], "KHR_materials_ior": [{"ior": 1.3}],
      "KHR_materials_clearcoat": [{"clearcoatFactor": 1, "clearcoatTexture": {"index": 0}}],
      "KHR_materials_sheen": [{"sheenColorFactor": [1, 0, 0]}], "KHR_materials_transmission": [{"transmissionFactor": 1}],
      "KHR_materials_volume": [{"thicknessFactor": 1, "attenuationDistance": 2}],
      "KHR_materials_specular": [{"specularFactor": 0.5}], "KHR_materials_iridescence": [{"iridescenceFactor": 1}],
      "KHR_materials_anisotropy": [{"anisotropyStrength": 1}], "KHR_materials_emissive_strength": [{"emissiveStrength": 5}],
      "KHR_materials_diffuse_transmission": [{"diffuseTransmissionFactor": 1, "diffuseTransmissionTexture": {"index": 0}}],
      "KHR_materials_dispersion": [{"dispersion": 0.2}], "KHR_materials_pbrSpecularGlossiness": [{"glossinessFactor": 1}],
      "KHR_draco_mesh_compression": [{"bufferView": 0, "attributes": {"POSITION": 0, "NORMAL": 1}}],
      "EXT_lights_image_based": [{"light": 0}, {"lights": [{"intensity": 1, "irradianceCoefficients":
        [[1,1,1],[0,0,0],[0,0,0],[0,0,0],[0,0,0],[0,0,0],[0,0,0],[0,0,0],[0,0,0]], "specularImageSize": 4,
        "specularImages": [[0, 0, 0, 0, 0, 0]]}]}],
      "EXT_meshopt_compression": [{"buffer": 0, "byteLength": 20, "byteStride": 4, "count": 3, "mode": "ATTRIBUTES"},
                                  {"buffer": 0, "byteLength": 20, "byteStride": 2, "count": 3, "mode": "TRIANGLES"}]}
  })");
  return made;
}

uint32_t wordAt(std::span<const uint8_t> bytes, size_t at) {
  uint32_t word = 0;
  std::memcpy(&word, &bytes[at], sizeof(word));
  return word;
}

void appendWord(std::vector<uint8_t>& bytes, size_t word) {
  for (int i = 0; i < 4; ++i) bytes.push_back(static_cast<uint8_t>(word >> (8 * i)));
}

}  // namespace

std::optional<Glb> readGlb(std::span<const uint8_t> bytes) {
  if (bytes.size() < 20 || wordAt(bytes, 0) != kMagic || wordAt(bytes, 16) != kJsonChunk) return std::nullopt;
  const size_t length = wordAt(bytes, 12);
  if (length > bytes.size() - 20) return std::nullopt;
  const auto json = bytes.subspan(20, length);
  Glb glb{Json::parse(json.begin(), json.end(), nullptr, false), {}};
  if (!glb.root.is_object()) return std::nullopt;
  const size_t at = 20 + length;
  if (at + 8 <= bytes.size() && wordAt(bytes, at) <= bytes.size() - at - 8)
    glb.binary.assign(bytes.begin() + ptrdiff_t(at) + 8, bytes.begin() + ptrdiff_t(at + 8 + wordAt(bytes, at)));
  return glb;
}

std::vector<uint8_t> writeGlb(const Glb& glb) {
  std::string text = glb.root.dump(-1, ' ', false, Json::error_handler_t::replace);
  text.resize((text.size() + 3) / 4 * 4, ' ');
  const size_t binary = (glb.binary.size() + 3) / 4 * 4;
  std::vector<uint8_t> bytes;
  for (const size_t word :
       {size_t{kMagic}, size_t{2}, 20 + text.size() + (binary ? 8 + binary : 0), text.size(), size_t{kJsonChunk}})
    appendWord(bytes, word);
  bytes.insert(bytes.end(), text.begin(), text.end());
  if (binary == 0) return bytes;
  appendWord(bytes, binary), appendWord(bytes, kBinaryChunk);
  bytes.insert(bytes.end(), glb.binary.begin(), glb.binary.end());
  bytes.resize(bytes.size() + binary - glb.binary.size());
  return bytes;
}

void GltfMutator::mutate() {
  parts_.clear();
  collect(root_, {&root_, "", nullptr, "", 0}, 0);
  Part& part = anyPart();
  switch (below(8)) {
    case 0:
      return remove(part);
    case 1:
      return copy(part);
    case 2:
    case 3:
    case 4:
      return add(part);
    default:
      return replace(part);
  }
}

void GltfMutator::collect(Json& value, const Part& part, int depth) {
  if (depth > kMaxDepth || parts_.size() >= kMaxParts) return;
  parts_.push_back(part);
  if (value.is_object())
    for (auto& [key, member] : value.items()) collect(member, {&member, key, &value, key, 0}, depth + 1);
  if (value.is_array())
    for (size_t i = 0; i < value.size(); ++i) collect(value[i], {&value[i], part.name, &value, "", i}, depth + 1);
}

// Values of other types are rare, because the schema rejects them at once.
void GltfMutator::replace(Part& part) {
  Json& value = *part.value;
  if (part.parent && part.parent->is_object() && below(2) == 0) {
    for (const Json& object : grammar())
      if (object.contains(part.key) && below(2) == 0) {
        value = object[part.key][below(object[part.key].size())];
        return;
      }
  }
  if (value.is_number())
    value = number(value);
  else if (value.is_string())
    value = text();
  else if (value.is_boolean())
    value = !value.get<bool>();
  else if (value.is_array() && !value.empty())
    value.insert(value.begin() + ptrdiff_t(below(value.size())), value[below(value.size())]);
  else if (below(16) == 0)
    value = nullptr;
}

void GltfMutator::add(Part& part) {
  Json& value = *part.value;
  if (value.is_array()) {
    if (value.size() < 64) value.push_back(value.empty() ? Json(0) : value[below(value.size())]);
    return;
  }
  const auto object = grammar().find(part.name);
  if (!value.is_object() || object == grammar().end()) return replace(part);
  auto member = object->begin();
  std::advance(member, below(object->size()));
  value[member.key()] = (*member)[below(member->size())];
}

void GltfMutator::remove(Part& part) {
  if (!part.parent) return;
  if (part.parent->is_object())
    part.parent->erase(part.key);
  else
    part.parent->erase(part.element);
}

void GltfMutator::copy(Part& part) {
  std::vector<Part*> alike;
  for (Part& other : parts_)
    if (other.name == part.name && other.value->type() == part.value->type()) alike.push_back(&other);
  const Json copied = *alike[below(alike.size())]->value;
  *part.value = copied;
}

Json GltfMutator::number(const Json& before) {
  constexpr std::array kIntegers{int64_t{-1},  int64_t{0},       int64_t{1},          int64_t{2},
                                 int64_t{3},   int64_t{4},       int64_t{5},          int64_t{255},
                                 int64_t{256}, int64_t{65535},   int64_t{2147483647}, int64_t{4294967295},
                                 int64_t{8},   int64_t{1} << 40, int64_t{16}};
  constexpr std::array kReals{0.0, -0.0, 1e-45, 1e-30, 0.5, 1.0, -1.0, 3.4e38, 1e300, 1e15, 3.14159265};
  switch (below(4)) {
    case 0:
      return kIntegers[below(kIntegers.size())];
    case 1:
      return kReals[below(kReals.size())];
    case 2:
      return before.is_number_float() ? Json(before.get<double>() * -1.5)
                                      : Json(int64_t(before.get<uint64_t>() + 1 - below(3)));
    default:
      return below(16);
  }
}

Json GltfMutator::text() {
  constexpr std::array kTexts{"",
                              "SCALAR",
                              "VEC2",
                              "VEC3",
                              "VEC4",
                              "MAT4",
                              "LINEAR",
                              "STEP",
                              "BLEND",
                              "MASK",
                              "CUBICSPLINE",
                              "translation",
                              "scale",
                              "rotation",
                              "weights",
                              "spot",
                              "point",
                              "directional",
                              "perspective",
                              "pointer",
                              "ATTRIBUTES",
                              "INDICES",
                              "2.0",
                              "data:,",
                              "OCTAHEDRAL",
                              "QUATERNION",
                              "EXPONENTIAL",
                              "/nodes/0",
                              "/",
                              "~",
                              "/materials/0/emissiveFactor",
                              "\xff"};
  return kTexts[below(kTexts.size())];
}

}  // namespace latelight::fuzz
