// Shaders: SPIR-V that is embedded in the library. A ShaderKey identifies each; its name is what logs, messages and
// .spv files call it.
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace latelight::vk {

// A variant of a shader (cmake/shaders.cmake lists the variants).
struct ShaderKey {
  enum class Samples : uint8_t {
    One,
    Multisampled,  // of multisampled images
    SampleLayers,  // of images with an array layer per sample
  };
  // The kind of hit of the raster compute: how a pixel that a triangle covers is stored (raster_hit.glsl).
  enum class Hit : uint8_t { Opaque, Masked, Blended, Overdraw, Lens, LensBlended };

  ShaderKey() = default;
  // Implicit, because most shaders have only one form.
  ShaderKey(const char* file) : file(file) {}
  ShaderKey(std::string file, std::string layout = {}) : file(std::move(file)), layout(std::move(layout)) {}

  std::string file;    // without its folder: "geometry.frag"
  std::string layout;  // the G-buffer layout's file; empty: the shader is the same for all
  Samples samples = Samples::One;
  Hit hit = Hit::Opaque;
  bool coated = false;   // for materials that may have coats
  bool indexed = false;  // for bindless textures

  bool empty() const { return file.empty(); }
  // The suffix of `hit` without its +, such as "lens-blended"; empty for Opaque.
  std::string_view hitName() const;
  // The name under which the build embeds this variant, such as "geometry.frag@thin+msaa".
  std::string name() const;
  bool operator==(const ShaderKey&) const = default;
};

// Returns SPIR-V words. Throws Error(Internal) if there is no such shader or variant, and Error(BadInput) if a file of
// the folder set by useShadersOf() is not SPIR-V.
std::span<const uint32_t> shaderCode(const ShaderKey& shader);
bool hasShader(const ShaderKey& shader);
std::vector<std::string_view> shaderNames();
std::span<const uint32_t> shaderCodeOf(std::string_view name);  // as shaderCode(), for one of shaderNames()

// For shader development: replaces the embedded shader NAME by the file NAME.spv of a folder, such as
// build/release/spirv. This affects pipelines created later in the whole process; devices keep their existing
// pipelines. An empty path restores the embedded shaders. Throws Error(BadInput) if the folder has none of them.
void useShadersOf(const std::filesystem::path& folder);
std::vector<std::filesystem::path> shaderFiles();  // the .spv files of that folder

}  // namespace latelight::vk
