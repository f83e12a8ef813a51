// From a rendered frame to files: their names and formats.
#pragma once

#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "output/aov.h"
#include "output/metadata.h"

namespace latelight::output {

enum class Format { Png, Exr, Npy };

struct OutputRequest {
  // The extension picks the format: .png, .exr, .npy. {aov}, {frame}, {camera} and {scene} are filled in; other braces
  // are an error. Several AOVs go into one .exr, or into one file each where the pattern says {aov}; .png and .npy hold
  // one each, so without {aov} the AOV's name is inserted before the extension: out.depth.png; colour stays out.png.
  // Folders from the first placeholder on are created, and all where the pattern has {frame}; others must exist. "-" is
  // standard output: a PNG of the first AOV.
  std::string pattern;
  std::vector<Aov> aovs{Aov::Color};
  // The JSON side file: the pattern with .json as its extension and "meta" for {aov}. Unset: if any AOV but color is
  // asked for. Never with "-".
  std::optional<bool> sideFile;
  // One frame of a sequence: its side file refers to the id manifest, which all frames share (writeIdManifest()), and
  // its EXR files list only the ids that they show.
  bool inSequence = false;
};

struct FrameOutput {
  uint32_t width = 0, height = 0;
  // Each requested AOV; colour may be left out where usesDisplay(). Colour is linear, scene-referred, exposed, not
  // tonemapped, alpha premultiplied.
  std::vector<AovImage> aovs;
  // RGBA, 8 bits, sRGB, straight alpha, tonemapped: colour in PNG files. If empty, colour is clamped instead.
  std::vector<uint8_t> display;

  // `display` as a PNG file. Kept from the first call on: several formats of a data set write it. From one thread at a
  // time.
  std::span<const std::byte> displayPng() const;
  mutable std::vector<std::byte> keptPng = {};
};

// Makes motion to the previous frame, to the next one, or both NaN: there is no such frame.
void forgetMotion(FrameOutput& frame, bool previous, bool next);

// The format by the pattern's extension. Throws Error(Usage) that names the three.
Format formatOf(std::string_view pattern);

// Whether colour is output, and as FrameOutput::display (PNG), not as the Color AOV.
bool usesDisplay(const OutputRequest& request);

// The path of one output: the pattern with its placeholders filled in.
std::filesystem::path fillPattern(std::string_view pattern, std::string_view aov, const Metadata& metadata);

// Creates the folders of such a path that need not exist.
void makeFilledFolders(const std::filesystem::path& pattern, const std::filesystem::path& path);

// Throws Error(Usage) for errors that can be found before rendering: the extension, placeholders, an AOV that the
// format does not support, a folder that is missing or can't be written to.
void checkOutput(const OutputRequest& request);

// The files that writeOutput writes: one path per AOV, or one for all, then the side file's. None for "-".
std::vector<std::filesystem::path> outputPaths(const OutputRequest& request, const Metadata& metadata);

// The file of a sequence's id manifest: the side file's name with "ids" for {frame}. Nothing where the request is not
// of a sequence, or writes no side files with ids.
std::optional<std::filesystem::path> idManifestPath(const OutputRequest& request, const Metadata& metadata);
// Writes it, once for all frames. Throws Error(Usage) where that can't be done.
void writeIdManifest(const OutputRequest& request, const Metadata& metadata);

// Writes all files, each whole or not at all, and returns their paths (the side file last; none for "-").
// Throws Error(Usage) where one can't be written; other files of this call may then exist already.
std::vector<std::filesystem::path> writeOutput(const OutputRequest& request, const FrameOutput& frame,
                                               const Metadata& metadata);

// A picture as PNG; "-" is standard output.
void writePicture(const std::filesystem::path& path, const Picture& picture);

}  // namespace latelight::output
