// OpenEXR files in memory.
#pragma once

#include <cstddef>
#include <filesystem>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "output/aov.h"
#include "output/metadata.h"
#include "output/read.h"

namespace latelight::output {

// What a file may have beside its outputs.
struct ExrExtras {
  struct Channel {
    std::string name;
    std::span<const float> values;  // one a pixel, rows from the top
  };
  std::vector<Channel> channels;
  std::vector<std::pair<std::string, std::string>> attributes;  // texts, by name
  ChannelNames names = ownNames;                                // of the outputs' channels
  bool idManifest = true;                                       // some readers refuse files that have one
};

// All AOVs in one part, channels as AovInfo says, or as other names say. Attributes: chromaticities (Rec.709),
// software, worldToCamera and worldToNDC as OpenEXR defines them, idManifest (OpenEXR's own, for the channels id, part
// and material), and latelight: the side file's text without its files and ids. The same input gives the same bytes,
// whatever the number of threads.
std::vector<std::byte> encodeExr(std::span<const AovImage* const> images, const Metadata& metadata,
                                 const ExrExtras& extras = {});

// Throws Error(BadInput) that names `path`.
ReadImage decodeExr(std::span<const std::byte> bytes, const std::filesystem::path& path);

}  // namespace latelight::output
