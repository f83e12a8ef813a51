// A format of data sets: which files it writes, and what each frame adds to files of the whole set. A file in
// src/data/formats each; formats() lists them.
#pragma once

#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "data/frame.h"

namespace latelight::data {

// What one frame left: its files, relative to the data set's folder, and what the format's files of the whole set say
// of it. It is kept in the manifest, so that a set rendered in any number of parts gives the same files.
struct FrameRecord {
  std::vector<std::string> files;
  nlohmann::ordered_json entry;  // the format's own; null: nothing
};

class Format {
 public:
  virtual ~Format() = default;

  // Outputs that a frame must have for it.
  virtual std::vector<output::Aov> needs() const = 0;
  // Whether it is written from FrameOutput::display, the picture for viewing.
  virtual bool needsDisplay() const { return false; }
  virtual Extras needsExtras() const { return {}; }

  // Writes the frame's own files below `folder`, each whole or not at all. Called for several frames at once, from
  // several threads: it depends on nothing but the frame. Throws Error(Usage) where a file can't be written.
  virtual FrameRecord writeFrame(const DataFrame& frame, const std::filesystem::path& folder) const = 0;

  // Writes the files of the whole set from all its entries, by the frames' index, and returns them relative to
  // `folder`.
  virtual std::vector<std::string> writeSet(std::span<const nlohmann::ordered_json> entries,
                                            const std::filesystem::path& folder) const {
    return {};
  }
};

// An entry of the table of formats. `make` takes the options that the job gives the format, an object; throws
// Error(Usage) that names a key that is wrong.
struct FormatInfo {
  std::string_view name, description;
  std::unique_ptr<Format> (*make)(const nlohmann::ordered_json& options);
};
std::span<const FormatInfo> formats();

}  // namespace latelight::data
