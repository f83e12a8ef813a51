// Shaders: SPIR-V that is embedded in the library. A shader's name is the name of its file under src/render without the
// folder: "geometry.frag". A shader that is compiled for each G-buffer layout is called "geometry.frag@thin".
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <string_view>
#include <vector>

namespace latelight::vk {

// Returns SPIR-V words. Throws Error(Internal) if no shader has that name, and Error(BadInput) if a file of the folder
// set by useShadersOf() is not SPIR-V.
std::span<const uint32_t> shaderCode(std::string_view name);
std::vector<std::string_view> shaderNames();
bool hasShader(std::string_view name);

// For shader development: replaces the embedded shader NAME by the file NAME.spv of a folder, such as
// build/release/spirv. This affects pipelines created later in the whole process; devices keep their existing
// pipelines. An empty path restores the embedded shaders.
void useShadersOf(const std::filesystem::path& folder);
std::vector<std::filesystem::path> shaderFiles();  // the .spv files of that folder

}  // namespace latelight::vk
