// Writes rendered frames to files: names, formats, folders and the side file.
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
  // The extension selects the format: .png, .exr, .npy. {aov}, {frame}, {camera} and {scene} are replaced; other braces
  // are an error. Several AOVs share one .exr, or have one file each if the pattern contains {aov}. A .png or .npy
  // holds one AOV, so without {aov} the AOV's name is inserted before the extension: out.depth.png; color stays
  // out.png. Folders from the first placeholder on are created, and all folders if the pattern contains {frame}; others
  // must exist. "-" is standard output, which receives a PNG of the only AOV.
  std::string pattern;
  std::vector<Aov> aovs{Aov::Color};
  // Writes the JSON side file, whose name is the pattern with the extension .json and "meta" for {aov}. Default: if any
  // AOV except color is requested. Never with "-".
  std::optional<bool> sideFile;
  // The request is one frame of a sequence. Its side file refers to the id manifest, which all frames share
  // (writeIdManifest()), and its EXR files list only the ids that they show.
  bool inSequence = false;
};

struct FrameOutput {
  uint32_t width = 0, height = 0;
  // Each requested AOV; color may be absent if usesDisplay(). Color is linear, scene-referred, exposed, not tone
  // mapped, with premultiplied alpha.
  std::vector<AovImage> aovs;
  // Color for PNG files: RGBA, 8 bits, sRGB, straight alpha, tone mapped. If empty, PNG files hold clamped color
  // instead.
  std::vector<uint8_t> display;
  float exposure = 1;  // the factor that color was multiplied by

  // `display` as a PNG file, cached from the first call on, because several formats of a data set write it. Not
  // thread-safe.
  std::span<const std::byte> displayPng() const;
  mutable std::vector<std::byte> cachedPng = {};
};

// Sets motion to the previous frame, to the next one, or both to NaN, because there is no such frame.
void forgetMotion(FrameOutput& frame, bool previous, bool next);

// Returns the format for the pattern's extension. Throws Error(Usage) that names the three extensions.
Format formatOf(std::string_view pattern);

// Returns true for a name that ends in .png and for "-". Other names, also without a known extension, are not PNG.
bool isPngName(std::string_view pattern);

// Returns true if color is output as FrameOutput::display (PNG) instead of the Color AOV.
bool usesDisplay(const OutputRequest& request);

// Returns true if a file contains the metadata: the side file or EXR.
bool writesMetadata(const OutputRequest& request);

// Returns the path of one output: the pattern with its placeholders replaced.
std::filesystem::path fillPattern(std::string_view pattern, std::string_view aov, const Metadata& metadata);

// Creates those folders of a filled pattern that need not exist beforehand.
void makeFilledFolders(const std::filesystem::path& pattern, const std::filesystem::path& path);

// Throws Error(Usage) for a pattern with other placeholders, or whose folder is missing or not writable. For files of
// frames that have other contents than images, too.
void checkPattern(std::string_view pattern);

// Throws Error(Usage) for errors that can be detected before rendering: the extension, placeholders, an AOV that the
// format does not support, several AOVs for "-", a folder that is missing or not writable.
void checkOutput(const OutputRequest& request);

// Returns the paths that writeOutput() writes: one per AOV, or one for all, then that of the side file. Empty for "-".
std::vector<std::filesystem::path> outputPaths(const OutputRequest& request, const Metadata& metadata);

// Returns the path of a sequence's id manifest: the side file's name with "ids" for {frame}. Empty if the request is
// not part of a sequence or writes no side files with ids.
std::optional<std::filesystem::path> idManifestPath(const OutputRequest& request, const Metadata& metadata);
// Writes the id manifest, once for all frames. Throws Error(Usage) if the file cannot be written.
void writeIdManifest(const OutputRequest& request, const Metadata& metadata);

// Writes all files, each whole or not at all, and returns their paths (the side file last; none for "-"). Throws
// Error(Usage) if a file cannot be written; other files of this call may then exist already.
std::vector<std::filesystem::path> writeOutput(const OutputRequest& request, const FrameOutput& frame,
                                               const Metadata& metadata);

// Writes an image as PNG; "-" is standard output.
void writePicture(const std::filesystem::path& path, const Picture& picture);

}  // namespace latelight::output
