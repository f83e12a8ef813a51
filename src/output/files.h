// From a rendered frame to files: which, named how, in what format.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "output/aov.h"
#include "output/metadata.h"

namespace latelight::output {

enum class Format { Png, Exr, Npy };

struct OutputRequest {
  // The ending picks the format: .png, .exr, .npy. {aov}, {frame}, {camera} and {scene} are filled in; other braces are
  // an error. Several AOVs go into one .exr, or into one file each where the pattern says {aov}; .png and .npy hold one
  // each, so without {aov} the AOV's name is put before the ending: out.depth.png; colour stays out.png.
  // Folders named by braces are made, and all where the pattern says {frame}; others must be there. "-" is standard
  // output: a PNG of the first AOV.
  std::string pattern;
  std::vector<Aov> aovs{Aov::Color};
  // The JSON side file: pattern with .json for its ending and "meta" for {aov}. Unset: if any AOV but color is asked
  // for. Never with "-".
  std::optional<bool> sideFile;
};

struct FrameOutput {
  uint32_t width = 0, height = 0;
  // Each requested AOV; colour may be left out where usesDisplay(). Colour is linear, scene-referred, exposed, not
  // tonemapped, alpha premultiplied.
  std::vector<AovImage> aovs;
  // RGBA, 8 bits, sRGB, straight alpha, tonemapped: colour in PNG files. If empty, colour is clamped instead.
  std::vector<uint8_t> display;
};

// The format that the pattern's ending picks. Throws Error(Usage) that names the three.
Format formatOf(std::string_view pattern);

// Whether colour leaves at all, and as FrameOutput::display (PNG), not as the Color AOV.
bool usesDisplay(const OutputRequest& request);

// The path of one output: what stands in the pattern's braces filled in.
std::filesystem::path fillPattern(std::string_view pattern, std::string_view aov, const Metadata& metadata);

// Makes those folders of a path so filled in that need not be there.
void makeFilledFolders(const std::filesystem::path& pattern, const std::filesystem::path& path);

// Throws Error(Usage) for whatever can be known to go wrong before rendering: ending, placeholders, an AOV that the
// format does not offer, a folder that is missing or can't be written to.
void checkOutput(const OutputRequest& request);

// What writeOutput writes: one path an AOV, or one for all, then the side file's. None for "-".
std::vector<std::filesystem::path> outputPaths(const OutputRequest& request, const Metadata& metadata);

// Writes all files, each whole or not at all, and returns their paths (the side file last; none for "-").
// Throws Error(Usage) where one can't be written; then this call's other files may be there already.
std::vector<std::filesystem::path> writeOutput(const OutputRequest& request, const FrameOutput& frame,
                                               const Metadata& metadata);

// A picture as PNG; "-" is standard output.
void writePicture(const std::filesystem::path& path, const Picture& picture);

}  // namespace latelight::output
