// Reads the scenes, meshes and animations of validated glTF JSON; model_materials.cpp reads the materials.
#include "scene/gltf/model.h"

#include <algorithm>
#include <string_view>

#include "base/error.h"
#include "base/log.h"
#include "scene/gltf/json.h"
#include "scene/gltf/model_materials.h"

namespace latelight::scene::gltf::file {
namespace {

using nlohmann::json;

// Calls read(element, index) for each element of an array that may be absent.
template <typename Read>
auto readAll(const json& object, const char* key, Read read) {
  const json& array = arrayIn(object, key);
  std::vector<decltype(read(array, size_t{0}))> all;
  all.reserve(array.size());
  for (const json& element : array) all.push_back(read(element, all.size()));
  return all;
}

template <typename T>
std::vector<T> listIn(const json& object, const char* key) {
  const json* found = findProperty(object, key);
  return found ? found->get<std::vector<T>>() : std::vector<T>();
}

int indexIn(const json& object, const char* key) {
  return object.value(key, -1);
}

std::string stringIn(const json& object, const char* key) {
  return object.value(key, std::string());
}

// --- geometry --------------------------------------------------------------------------------------------------------

struct ElementType {
  std::string_view name;
  size_t columns, rows;
};
constexpr ElementType kElementTypes[] = {{"SCALAR", 1, 1}, {"VEC2", 1, 2}, {"VEC3", 1, 3}, {"VEC4", 1, 4},
                                         {"MAT2", 2, 2},   {"MAT3", 3, 3}, {"MAT4", 4, 4}};

void setType(Accessor& accessor, const std::string& type, size_t index) {
  const auto found = std::ranges::find(kElementTypes, type, &ElementType::name);
  if (found == std::end(kElementTypes)) badInput("accessors[{}].type is \"{}\", which glTF does not have", index, type);
  accessor.columns = found->columns;
  accessor.rows = found->rows;
}

Sparse readSparse(const json& source) {
  const json &indices = source["indices"], &values = source["values"];
  return {.count = source["count"].get<size_t>(),
          .indices = {.bufferView = indexIn(indices, "bufferView"),
                      .byteOffset = indices.value("byteOffset", size_t{0}),
                      .componentType = indices["componentType"].get<int>()},
          .values = {.bufferView = indexIn(values, "bufferView"), .byteOffset = values.value("byteOffset", size_t{0})}};
}

Accessor readAccessor(const json& source, size_t index) {
  Accessor accessor{.bufferView = indexIn(source, "bufferView"),
                    .byteOffset = source.value("byteOffset", size_t{0}),
                    .componentType = source["componentType"].get<int>(),
                    .normalized = source.value("normalized", false),
                    .count = source["count"].get<size_t>()};
  setType(accessor, source["type"].get_ref<const std::string&>(), index);
  if (const json* sparse = findProperty(source, "sparse")) accessor.sparse = readSparse(*sparse);
  return accessor;
}

Primitive readPrimitive(const json& source) {
  Primitive primitive{.attributes = source["attributes"].get<Attributes>(),
                      .indices = indexIn(source, "indices"),
                      .material = indexIn(source, "material"),
                      .mode = source.value("mode", int{kTriangles}),
                      .targets = listIn<Attributes>(source, "targets")};
  if (const json* draco = findExtension(source, "KHR_draco_mesh_compression"))
    primitive.draco = {.bufferView = indexIn(*draco, "bufferView"),
                       .attributes = (*draco)["attributes"].get<std::map<std::string, int>>()};
  if (const json* variants = findExtension(source, "KHR_materials_variants"))
    primitive.variants = readAll(*variants, "mappings", [](const json& mapping, size_t) {
      return VariantMapping{listIn<int>(mapping, "variants"), indexIn(mapping, "material")};
    });
  return primitive;
}

Mesh readMesh(const json& source, size_t) {
  return {.name = stringIn(source, "name"),
          .primitives =
              readAll(source, "primitives", [](const json& primitive, size_t) { return readPrimitive(primitive); }),
          .weights = listIn<double>(source, "weights")};
}

// --- nodes -----------------------------------------------------------------------------------------------------------

Node readNode(const json& source, size_t) {
  Node node{.name = stringIn(source, "name"),
            .children = listIn<int>(source, "children"),
            .camera = indexIn(source, "camera"),
            .mesh = indexIn(source, "mesh"),
            .skin = indexIn(source, "skin"),
            .matrix = listIn<double>(source, "matrix"),
            .weights = listIn<double>(source, "weights")};
  if (node.matrix.empty()) {
    node.translation = vectorIn(source, "translation", node.translation);
    node.rotation = vectorIn(source, "rotation", node.rotation);
    node.scale = vectorIn(source, "scale", node.scale);
  }
  if (const json* light = findExtension(source, "KHR_lights_punctual")) {
    node.light = indexIn(*light, "light");
    node.extras = source.value("extras", json());
  }
  if (const json* extras = findProperty(source, "extras"); extras && extras->is_object())
    node.areaLight = extras->value("areaLight", json());
  if (const json* visibility = findExtension(source, "KHR_node_visibility"))
    node.visible = visibility->value("visible", true);
  if (const json* instancing = findExtension(source, "EXT_mesh_gpu_instancing"))
    node.instancing = (*instancing)["attributes"].get<Attributes>();
  return node;
}

Scene readScene(const json& source, size_t) {
  const json* light = findExtension(source, "EXT_lights_image_based");
  return {.nodes = listIn<int>(source, "nodes"), .imageBasedLight = light ? indexIn(*light, "light") : -1};
}

Skin readSkin(const json& source, size_t) {
  return {.joints = listIn<int>(source, "joints"), .inverseBindMatrices = indexIn(source, "inverseBindMatrices")};
}

Camera readCamera(const json& source, size_t index) {
  const auto& type = source["type"].get_ref<const std::string&>();
  if (type != "perspective" && type != "orthographic")
    badInput("cameras[{}].type is \"{}\": it must be \"perspective\" or \"orthographic\"", index, type);
  const json* found = findProperty(source, type.c_str());
  if (!found) badInput("cameras[{}].{} is missing", index, type);
  const auto number = [&](const char* key) { return found->value(key, 0.0); };
  Camera camera{.name = stringIn(source, "name"), .projection = {}};
  if (type == "perspective")
    camera.projection = Perspective{number("yfov"), number("znear"), number("zfar"), number("aspectRatio")};
  else
    camera.projection = Orthographic{number("xmag"), number("ymag"), number("znear"), number("zfar")};
  return camera;
}

Light readLight(const json& source, size_t index) {
  Light light{.name = stringIn(source, "name"), .type = stringIn(source, "type")};
  light.color = vectorIn(source, "color", light.color);
  light.intensity = source.value("intensity", light.intensity);
  light.range = source.value("range", light.range);
  light.extras = source.value("extras", json());
  if (light.type != "spot") return light;
  const json* spot = findProperty(source, "spot");
  if (!spot) badInput("extensions.KHR_lights_punctual.lights[{}].spot is missing", index);
  light.innerConeAngle = spot->value("innerConeAngle", light.innerConeAngle);
  light.outerConeAngle = spot->value("outerConeAngle", light.outerConeAngle);
  if (light.innerConeAngle > light.outerConeAngle) {
    warn(
        "extensions.KHR_lights_punctual.lights[{}].spot.innerConeAngle is {}, above the outerConeAngle of {}: it is "
        "read as {}",
        index, light.innerConeAngle, light.outerConeAngle, light.outerConeAngle);
    light.innerConeAngle = light.outerConeAngle;
  }
  return light;
}

ImageBasedLight readImageBasedLight(const json& source, size_t) {
  ImageBasedLight light;
  light.rotation = vectorIn(source, "rotation", light.rotation);
  light.intensity = source.value("intensity", light.intensity);
  for (size_t i = 0; i < light.irradianceCoefficients.size(); ++i)
    light.irradianceCoefficients[i] = vectorOf<glm::vec3>(source["irradianceCoefficients"][i]);
  light.specularImages = source["specularImages"][0].get<std::array<int, 6>>();
  light.specularImageSize = source["specularImageSize"].get<int>();
  return light;
}

// --- animations ------------------------------------------------------------------------------------------------------

AnimationChannel readChannel(const json& source, size_t) {
  const json& target = source["target"];
  AnimationChannel channel{.sampler = source["sampler"].get<size_t>(),
                           .node = indexIn(target, "node"),
                           .path = stringIn(target, "path"),
                           .pointer = {}};
  if (const json* pointer = findExtension(target, "KHR_animation_pointer"))
    channel.pointer = stringIn(*pointer, "pointer");
  return channel;
}

AnimationSampler readAnimationSampler(const json& source, size_t) {
  AnimationSampler sampler{.input = indexIn(source, "input"), .output = indexIn(source, "output")};
  sampler.interpolation = source.value("interpolation", sampler.interpolation);
  return sampler;
}

Animation readAnimation(const json& source, size_t) {
  Animation animation{.name = {},
                      .channels = readAll(source, "channels", readChannel),
                      .samplers = readAll(source, "samplers", readAnimationSampler)};
  if (const json* name = findProperty(source, "name")) animation.name = name->get<std::string>();
  return animation;
}

}  // namespace

Model readModel(const json& root) {
  Model model{.accessors = readAll(root, "accessors", readAccessor),
              .meshes = readAll(root, "meshes", readMesh),
              .nodes = readAll(root, "nodes", readNode),
              .scenes = readAll(root, "scenes", readScene),
              .scene = indexIn(root, "scene"),
              .skins = readAll(root, "skins", readSkin),
              .cameras = readAll(root, "cameras", readCamera),
              .samplers = readAll(root, "samplers", readSampler),
              .textures = readAll(root, "textures", readTexture),
              .materials = readAll(root, "materials", readMaterial),
              .animations = readAll(root, "animations", readAnimation)};
  if (const json* lights = findExtension(root, "KHR_lights_punctual"))
    model.lights = readAll(*lights, "lights", readLight);
  if (const json* lights = findExtension(root, "EXT_lights_image_based"))
    model.imageBasedLights = readAll(*lights, "lights", readImageBasedLight);
  if (const json* variants = findExtension(root, "KHR_materials_variants"))
    model.variants = readAll(*variants, "variants", [](const json& v, size_t) { return stringIn(v, "name"); });
  return model;
}

}  // namespace latelight::scene::gltf::file
