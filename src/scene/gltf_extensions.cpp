// The supported extensions, and the messages about the others.
#include <algorithm>
#include <string>
#include <string_view>

#include "base/error.h"
#include "base/log.h"
#include "scene/gltf_document.h"

namespace latelight::scene::gltf {
namespace {

constexpr std::string_view kSupported[] = {
    "EXT_mesh_gpu_instancing",    "EXT_meshopt_compression", "EXT_texture_webp",
    "KHR_draco_mesh_compression", "KHR_lights_punctual",     "KHR_materials_emissive_strength",
    "KHR_materials_ior",          "KHR_materials_specular",  "KHR_materials_unlit",
    "KHR_materials_variants",     "KHR_mesh_quantization",   "KHR_texture_transform",
    "KHR_texture_basisu",         "KHR_node_visibility",     "KHR_animation_pointer",
};

// Extensions that don't affect how the scene looks at rest.
constexpr std::string_view kHarmless[] = {
    "KHR_xmp_json_ld",
    "KHR_xmp",
    "KHR_node_selectability",
    "KHR_node_hoverability",
    "KHR_accessor_float64",
    "KHR_audio",
    "KHR_audio_emitter",
    "KHR_interactivity",
    "KHR_physics_rigid_bodies",
    "EXT_structural_metadata",
    "EXT_mesh_features",
    "EXT_instance_features",
    "MSFT_lod",
    "MSFT_audio_emitter",
    "MSFT_packing_occlusionRoughnessMetallic",
    "MSFT_packing_normalRoughnessMetallic",
    "VRM",
    "VRMC_vrm",
    "EXT_property_animation",
    "AGI_articulations",
    "AGI_stk_metadata",
    "FB_geometry_metadata",
    "GODOT_single_root",
};

template <size_t N>
bool contains(const std::string_view (&names)[N], std::string_view name) {
  return std::find(std::begin(names), std::end(names), name) != std::end(names);
}

}  // namespace

void checkExtensions(const nlohmann::json& root) {
  auto required = root.find("extensionsRequired");
  if (required != root.end() && required->is_array()) {
    for (const nlohmann::json& item : *required) {
      if (!item.is_string()) continue;  // validate() reports it
      std::string name = item.get<std::string>();
      if (!contains(kSupported, name))
        badInput("it requires the glTF extension {}, which is not supported: export it without", name);
    }
  }
  auto used = root.find("extensionsUsed");
  if (used == root.end() || !used->is_array()) return;
  for (const nlohmann::json& item : *used) {
    if (!item.is_string()) continue;
    std::string name = item.get<std::string>();
    if (!contains(kSupported, name) && !contains(kHarmless, name))
      warn("the glTF extension {} is not supported: the picture is made as if it were not there", name);
  }
}

const tinygltf::Value* extension(const tinygltf::ExtensionMap& map, const char* name) {
  auto found = map.find(name);
  return found == map.end() || !found->second.IsObject() ? nullptr : &found->second;
}

double numberOr(const tinygltf::Value& object, const char* key, double otherwise) {
  const tinygltf::Value& value = object.Get(key);
  return value.IsNumber() ? value.GetNumberAsDouble() : otherwise;
}

int indexOr(const tinygltf::Value& object, const char* key, int otherwise) {
  const tinygltf::Value& value = object.Get(key);
  return value.IsInt() ? value.Get<int>() : otherwise;
}

}  // namespace latelight::scene::gltf
