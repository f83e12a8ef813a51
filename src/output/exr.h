// OpenEXR files in memory.
#pragma once

#include <cstddef>
#include <filesystem>
#include <span>
#include <vector>

#include "output/aov.h"
#include "output/metadata.h"
#include "output/read.h"

namespace latelight::output {

// All AOVs in one part, channels as AovInfo says. Attributes: chromaticities (Rec.709), software, worldToCamera and
// worldToNDC as OpenEXR defines them, idManifest (OpenEXR's own, for the channels id, part and material), and
// latelight: the side file's text without its files and ids. The same input gives the same bytes, whatever the number
// of threads.
std::vector<std::byte> encodeExr(std::span<const AovImage* const> images, const Metadata& metadata);

// Throws Error(BadInput) that names `path`.
ReadImage decodeExr(std::span<const std::byte> bytes, const std::filesystem::path& path);

}  // namespace latelight::output
