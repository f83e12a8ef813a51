// Encodes and decodes OpenEXR files in memory.
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

// Optional contents of a file in addition to its outputs.
struct ExrExtras {
  struct Channel {
    std::string name;
    std::span<const float> values;  // one per pixel, rows from the top
  };
  std::vector<Channel> channels;
  std::vector<std::pair<std::string, std::string>> attributes;  // texts, by name
  ChannelNames names = ownNames;                                // names of the outputs' channels
  bool idManifest = true;                                       // some readers reject files with a manifest
};

// Writes all AOVs into one part, with the channel names of AovInfo or of `extras.names`. Attributes: chromaticities
// (Rec.709); software; worldToCamera and worldToNDC as OpenEXR defines them; idManifest (OpenEXR's own, for the
// channels id, part and material); and latelight: the text of the side file without its files and ids. The same input
// produces the same bytes, regardless of the number of threads.
std::vector<std::byte> encodeExr(std::span<const AovImage* const> images, const Metadata& metadata,
                                 const ExrExtras& extras = {});

// Throws Error(BadInput) that names `path`.
ReadImage decodeExr(std::span<const std::byte> bytes, const std::filesystem::path& path);

}  // namespace latelight::output
