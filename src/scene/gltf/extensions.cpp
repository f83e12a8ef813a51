// The table of glTF extensions and their treatment, and the check of a file's extensions.
#include "scene/gltf/extensions.h"

#include <algorithm>
#include <string>
#include <string_view>

#include "base/error.h"
#include "base/log.h"
#include "scene/gltf/document.h"

namespace latelight::scene {
namespace {

#ifdef LATELIGHT_AVIF
constexpr Treatment kAvif = Treatment::Read;
#else
constexpr Treatment kAvif = Treatment::Left;
#endif

using enum Treatment;

constexpr Extension kExtensions[] = {
    {"ADOBE_materials_clearcoat_specular", Left},
    {"ADOBE_materials_clearcoat_tint", Left},
    {"ADOBE_materials_thin_transparency", Left},
    {"AGI_articulations", Ignored},
    {"AGI_stk_metadata", Ignored},
    {"CESIUM_primitive_outline", Ignored},
    {"EXT_instance_features", Ignored},
    {"EXT_lights_ies", Left},
    {"EXT_lights_image_based", Read},
    {"EXT_mesh_features", Ignored},
    {"EXT_mesh_gpu_instancing", Read},
    {"EXT_mesh_manifold", Ignored},
    {"EXT_meshopt_compression", Read},
    {"EXT_primitive_voxels", Left},
    {"EXT_property_animation", Ignored},
    {"EXT_structural_metadata", Ignored},
    {"EXT_texture_avif", kAvif},
    {"EXT_texture_procedurals_mx_1_39", Left},
    {"EXT_texture_webp", Read},
    {"FB_geometry_metadata", Ignored},
    {"GODOT_single_root", Ignored},
    {"GRIFFEL_bim_data", Ignored},
    {"KHR_accessor_float64", Left},
    {"KHR_animation_pointer", Read},
    {"KHR_audio_emitter", Ignored},
    {"KHR_audio_graph", Ignored},
    {"KHR_collision_shapes", Ignored},
    {"KHR_draco_mesh_compression", Read},
    {"KHR_gaussian_splatting", Left},
    {"KHR_implicit_shapes", Ignored},
    {"KHR_interactivity", Ignored},
    {"KHR_lights_punctual", Read},
    {"KHR_materials_anisotropy", Read},
    {"KHR_materials_clearcoat", Read},
    {"KHR_materials_diffuse_transmission", Read},
    {"KHR_materials_dispersion", Read},
    {"KHR_materials_emissive_strength", Read},
    {"KHR_materials_ior", Read},
    {"KHR_materials_iridescence", Read},
    {"KHR_materials_pbrSpecularGlossiness", Read},
    {"KHR_materials_sheen", Read},
    {"KHR_materials_specular", Read},
    {"KHR_materials_subsurface", Left},
    {"KHR_materials_transmission", Read},
    {"KHR_materials_unlit", Read},
    {"KHR_materials_variants", Read},
    {"KHR_materials_volume", Read},
    {"KHR_materials_volume_scatter", Left},
    {"KHR_mesh_quantization", Read},
    {"KHR_meshopt_compression", Left},
    {"KHR_node_hoverability", Ignored},
    {"KHR_node_selectability", Ignored},
    {"KHR_node_visibility", Read},
    {"KHR_physics_rigid_bodies", Ignored},
    {"KHR_techniques_webgl", Left},
    {"KHR_texture_basisu", Read},
    {"KHR_texture_procedurals", Left},
    {"KHR_texture_transform", Read},
    {"KHR_texture_video", Left},
    {"KHR_xmp", Ignored},
    {"KHR_xmp_json_ld", Ignored},
    {"MPEG_accessor_timed", Left},
    {"MPEG_animation_timing", Left},
    {"MPEG_audio_spatial", Ignored},
    {"MPEG_buffer_circular", Left},
    {"MPEG_media", Left},
    {"MPEG_mesh_linking", Left},
    {"MPEG_scene_dynamic", Left},
    {"MPEG_texture_video", Left},
    {"MPEG_viewport_recommended", Ignored},
    {"MSFT_audio_emitter", Ignored},
    {"MSFT_lod", Ignored},
    {"MSFT_packing_normalRoughnessMetallic", Ignored},
    {"MSFT_packing_occlusionRoughnessMetallic", Ignored},
    {"MSFT_texture_dds", Left},
    {"NV_materials_mdl", Left},
    {"VRM", Ignored},
    {"VRMC_materials_mtoon", Left},
    {"VRMC_node_constraint", Ignored},
    {"VRMC_springBone", Ignored},
    {"VRMC_vrm", Ignored},
};
static_assert(std::ranges::is_sorted(kExtensions, {}, &Extension::name));

// Extensions that are not in the registry are also left, with a warning.
Treatment treatmentOf(std::string_view name) {
  const auto found = std::ranges::lower_bound(kExtensions, name, {}, &Extension::name);
  return found != std::end(kExtensions) && found->name == name ? found->treatment : Left;
}

}  // namespace

const bool kReadsAvif = kAvif == Read;

std::span<const Extension> extensions() {
  return kExtensions;
}

namespace gltf {

void checkExtensions(const nlohmann::json& root) {
  auto required = root.find("extensionsRequired");
  if (required != root.end() && required->is_array()) {
    for (const nlohmann::json& item : *required) {
      if (!item.is_string()) continue;  // validate() reports it
      std::string name = item.get<std::string>();
      if (treatmentOf(name) != Read)
        badInput("it requires the glTF extension {}, which is not supported: export the scene without it", name);
    }
  }
  auto used = root.find("extensionsUsed");
  if (used == root.end() || !used->is_array()) return;
  for (const nlohmann::json& item : *used) {
    if (!item.is_string()) continue;
    std::string name = item.get<std::string>();
    if (treatmentOf(name) == Left) warn("the glTF extension {} is not supported and is ignored", name);
  }
}

}  // namespace gltf
}  // namespace latelight::scene
