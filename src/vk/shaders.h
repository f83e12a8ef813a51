// Shaders: SPIR-V embedded in the library, named by their file under src/render without its folder: "geometry.frag";
// one that is compiled for each G-buffer layout is "geometry.frag@thin".
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <string_view>
#include <vector>

namespace latelight::vk {

// SPIR-V words. Throws Error(Internal) if none of that name is embedded, Error(BadInput) where a folder's file is none.
std::span<const uint32_t> shaderCode(std::string_view name);
std::vector<std::string_view> shaderNames();
bool hasShader(std::string_view name);

// For those who edit shaders: from here on NAME.spv of a folder, such as build/release/spirv, takes the place of the
// embedded NAME in what is made, in the whole process; devices keep pipelines that they have. Of an empty path: none.
void useShadersOf(const std::filesystem::path& folder);
std::vector<std::filesystem::path> shaderFiles();  // that it has

}  // namespace latelight::vk
