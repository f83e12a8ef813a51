#include "base/files.h"
#include "fuzz/seeds/seeds.h"
#include "scene/gltf_busy_file.h"
#include "scene/gltf_compressed_files.h"

namespace latelight::fuzz {

namespace {

using namespace scene::test;

// The stream of a compressed bufferView, with the bytes by which the target meshopt selects mode, filter, stride and
// count.
void addMeshoptStreams(Seeds& seeds, const GltfBuilder& b) {
  const auto indexOf = [](std::string_view name) {
    return char(name == "TRIANGLES" || name == "OCTAHEDRAL" ? 1
                : name == "INDICES" || name == "QUATERNION" ? 2
                : name == "EXPONENTIAL"                     ? 3
                                                            : 0);
  };
  for (const json& view : b.root["bufferViews"]) {
    if (!view.contains("extensions")) continue;
    const json& stream = view["extensions"]["EXT_meshopt_compression"];
    const size_t elements = stream["count"].get<size_t>() - 1;
    const char prefix[] = {indexOf(stream["mode"].get<std::string>()), indexOf(stream["filter"].get<std::string>()),
                           char(stream["byteStride"].get<size_t>() - 2), char(elements), char(elements >> 8)};
    seeds.add("meshopt", {prefix, sizeof(prefix)},
              std::span(b.buffer).subspan(stream["byteOffset"].get<size_t>(), stream["byteLength"].get<size_t>()));
  }
}

GltfBuilder materialsFile() {
  GltfBuilder b = triangleFile();
  const std::string png =
      "data:image/"
      "png;base64,iVBORw0KGgoAAAANSUhEUgAAAAEAAAABCAYAAAAfFcSJAAAADUlEQVR42mP8z8BQDwAEhQGAhKmMIQAAAABJRU5ErkJg"
      "gg==";
  b.add("images", {{"uri", png}});
  b.add("samplers", {{"wrapS", 33071}, {"minFilter", 9987}});
  b.add("textures", {{"source", 0}, {"sampler", 0}});
  const json map = {{"index", 0}};
  b.add("materials", {{"pbrMetallicRoughness", {{"baseColorTexture", map}, {"metallicRoughnessTexture", map}}},
                      {"normalTexture", map},
                      {"emissiveTexture", map},
                      {"alphaMode", "MASK"},
                      {"extensions",
                       {{"KHR_materials_clearcoat", {{"clearcoatFactor", 1}, {"clearcoatNormalTexture", map}}},
                        {"KHR_materials_sheen", {{"sheenColorFactor", {1, 0, 0}}, {"sheenRoughnessTexture", map}}},
                        {"KHR_materials_transmission", {{"transmissionFactor", 1}, {"transmissionTexture", map}}},
                        {"KHR_materials_volume", {{"thicknessFactor", 1}, {"attenuationDistance", 2}}},
                        {"KHR_materials_iridescence", {{"iridescenceFactor", 1}}},
                        {"KHR_materials_anisotropy", {{"anisotropyStrength", 1}, {"anisotropyTexture", map}}},
                        {"KHR_materials_emissive_strength", {{"emissiveStrength", 5}}},
                        {"KHR_materials_specular", {{"specularFactor", 0.5}, {"specularColorTexture", map}}}}}});
  b.primitive()["material"] = 0;
  b.primitive()["mode"] = 5;
  return b;
}

// Animation pointers to properties of each kind of element.
GltfBuilder pointersFile() {
  GltfBuilder b = materialsFile();
  b.root["materials"][0]["extensions"]["KHR_materials_pbrSpecularGlossiness"] = {{"glossinessFactor", 0.5},
                                                                                 {"diffuseTexture", {{"index", 0}}}};
  b.add("materials", {{"extensions", {{"KHR_materials_unlit", json::object()}}}});
  b.add("cameras", {{"type", "perspective"}, {"perspective", {{"yfov", 0.7}, {"znear", 0.1}}}});
  b.root["extensions"]["KHR_lights_punctual"]["lights"] = {{{"type", "point"}, {"intensity", 2}}};
  b.node({{"camera", 0}, {"extensions", {{"KHR_lights_punctual", {{"light", 0}}}}}});
  const int times = b.accessor(b.view(std::vector<float>{0, 1}), kFloat, "SCALAR", 2);
  const int numbers = b.accessor(b.view(std::vector<float>{0.5f, 1}), kFloat, "SCALAR", 2);
  const int vectors = b.vectors(std::vector<scene::vec3>(2, scene::vec3(1)));
  json samplers = json::array({{{"input", times}, {"output", numbers}}, {{"input", times}, {"output", vectors}}});
  json channels = json::array();
  const auto point = [&](const char* pointer, int sampler) {
    channels.push_back(
        {{"sampler", sampler},
         {"target", {{"path", "pointer"}, {"extensions", {{"KHR_animation_pointer", {{"pointer", pointer}}}}}}}});
  };
  point("/materials/0/emissiveFactor", 1);
  point("/materials/0/pbrMetallicRoughness/metallicFactor", 0);
  point("/materials/0/extensions/KHR_materials_volume/thicknessFactor", 0);
  point("/extensions/KHR_lights_punctual/lights/0/intensity", 0);
  point("/cameras/0/perspective/yfov", 0);
  point("/nodes/0/translation", 1);
  b.add("animations", {{"channels", channels}, {"samplers", samplers}});
  b.root["extensionsUsed"] = {"KHR_animation_pointer", "KHR_lights_punctual"};
  return b;
}

// Lights that are areas or an environment, light through thin surfaces, and other kinds of nodes, cameras and pointers.
GltfBuilder lightsFile() {
  GltfBuilder b = materialsFile();
  const json map = {{"index", 0}, {"extensions", {{"KHR_texture_transform", {{"scale", {2, 2}}}}}}};
  b.root["materials"][0]["occlusionTexture"] = map;
  b.add("materials", {{"extensions",
                       {{"KHR_materials_diffuse_transmission",
                         {{"diffuseTransmissionFactor", 0.5},
                          {"diffuseTransmissionTexture", map},
                          {"diffuseTransmissionColorFactor", {1, 0, 0}},
                          {"diffuseTransmissionColorTexture", map}}}}}});
  const json panel = {
      {"type", "rect"}, {"intensity", 9}, {"color", {1, 0.5, 0}}, {"size", 2}, {"rect", {{"aspect", 2}}}};
  b.node({{"extras", {{"areaLight", panel}}}, {"matrix", {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 2, 1}}});
  const json tube = {{"type", "tube"}, {"name", "lamp"}, {"tube", {{"length", 3}}}, {"castShadow", true}};
  b.node({{"extras", {{"areaLight", tube}}}});
  b.node({{"extras", {{"areaLight", {{"type", "disk"}, {"twoSided", true}}}}}});
  b.add("cameras", {{"type", "orthographic"}, {"orthographic", {{"xmag", 1}, {"ymag", 1}, {"znear", 0}, {"zfar", 9}}}});
  b.node({{"camera", 0}});
  const json light = {{"intensity", 2},
                      {"rotation", {0, 0, 0, 1}},
                      {"irradianceCoefficients", json(size_t{9}, json::array({1, 0, 0.5}))},
                      {"specularImageSize", 1},
                      {"specularImages", json::array({json(size_t{6}, json(0))})}};
  b.root["extensions"]["EXT_lights_image_based"]["lights"] = json::array({light});
  b.root["scenes"][0]["extensions"]["EXT_lights_image_based"]["light"] = 0;

  b.primitive()["targets"] = json::array({{{"POSITION", b.primitive()["attributes"]["POSITION"]}}});
  const int times = b.accessor(b.view(std::vector<float>{0, 1}), kFloat, "SCALAR", 2);
  json channels = json::array();
  for (const char* pointer :
       {"/nodes/0/weights/0", "/meshes/0/weights", "/nodes/0/extensions/KHR_node_visibility/visible"})
    channels.push_back(
        {{"sampler", 0},
         {"target", {{"path", "pointer"}, {"extensions", {{"KHR_animation_pointer", {{"pointer", pointer}}}}}}}});
  b.add("animations", {{"channels", channels}, {"samplers", json::array({{{"input", times}, {"output", times}}})}});
  b.root["extensionsUsed"] = {"EXT_lights_image_based", "KHR_animation_pointer"};
  return b;
}

}  // namespace

void addScenes(Seeds& seeds) {
  const GltfBuilder busy = busyFile(), meshopt = meshoptFile(), materials = materialsFile(), pointers = pointersFile(),
                    lights = lightsFile();
  const GltfBuilder sequential = dracoFile(draco::MESH_SEQUENTIAL_ENCODING),
                    edgebreaker = dracoFile(draco::MESH_EDGEBREAKER_ENCODING);
  for (const GltfBuilder* b : {&busy, &meshopt, &materials, &pointers, &lights, &sequential, &edgebreaker}) {
    seeds.add("gltf", b->glb());
    seeds.add("glb", b->glb());
  }
  seeds.add("gltf", busy.embedded());
  seeds.add("glb", busy.root.dump());
  addMeshoptStreams(seeds, meshopt);
  for (const GltfBuilder* b : {&sequential, &edgebreaker}) {
    const json& view = b->root["bufferViews"][0];
    // Component type FLOAT and three components for both accessors.
    seeds.add("draco", {"\6\2\6\2", 4}, std::span(b->buffer).first(view["byteLength"].get<size_t>()));
  }
}

}  // namespace latelight::fuzz
