// The interface of data set formats. A format writes files for each frame, and files of the whole set from the frames'
// entries. Each format is one file in src/data/formats; formats() lists them.
#pragma once

#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "data/frame.h"

namespace latelight::data {

// The result of writing one frame. The manifest stores it, so that the files of the whole set are the same for any
// number of shards.
struct FrameRecord {
  std::vector<std::string> files;  // relative to the data set's folder
  nlohmann::ordered_json entry;    // the frame's data for writeSet(), in the format's own structure; null if none
};

// The input of Format::writeSet().
struct SetEntries {
  std::span<const nlohmann::ordered_json> frames;       // FrameRecord::entry, in the order of the frames' indices
  std::span<const nlohmann::ordered_json> scenes = {};  // Format::sceneEntry(), in the order of the job's scenes
};

// A file that a format writes, stated before anything is rendered.
struct FormatFile {
  // Relative to the data set's folder. A slash at its end stands for any files in that folder.
  std::string name;
  // Describes the contents. Formats that state a name with the same description write the same bytes, so a job may have
  // both. Empty: no other format writes these contents, except one with equal options.
  std::string contents = {};
  bool ofSet = false;  // a file of the set to which the frame contributes, and not the frame's own
};

// Names relative to the data set's folder.
struct PackedFile {
  std::string file, archive;
};

class Format {
 public:
  virtual ~Format() = default;

  // The outputs of a frame that the format requires.
  virtual std::vector<output::Aov> needs() const = 0;
  // Returns true if the format requires FrameOutput::display, the picture for viewing.
  virtual bool needsDisplay() const { return false; }
  virtual Extras needsExtras() const { return {}; }

  // Returns the files that writeFrame() and writeSet() write for a frame, or may write. `frame` has what is known
  // before it is rendered: index, name, scene, variation, state, camera, the image's size, and in the metadata the
  // names of the scene and the camera.
  virtual std::vector<FormatFile> files(const DataFrame& frame) const = 0;
  // Returns the files of a frame that writeSet() reads and other formats of the job must write. `frame` is as above.
  virtual std::vector<std::string> filesOfOthers(const DataFrame& frame) const { return {}; }

  // Throws Error(Usage) if the format cannot store frames of this camera. `frame` has what is known before it is
  // rendered: the name (in the first variation, with the index 0), the camera, the exposure and the image's size.
  // writeFrame() calls it, too.
  virtual void check(const DataFrame& frame) const {}
  // Throws Error(Usage) if one set cannot have both frames. Called before anything is rendered, for the first camera of
  // each scene with each other camera of the scene.
  virtual void checkTogether(const DataFrame& first, const DataFrame& other) const {}

  // Writes the frame's own files below `folder`, all or none of them. Called concurrently for several frames. Throws
  // Error(Usage) if a file cannot be written.
  FrameRecord writeFrame(const DataFrame& frame, const std::filesystem::path& folder) const;

  // Returns a scene's data for writeSet(), in the format's own structure; null if none. `ids`: of all variations of the
  // scene. Unlike the entries of frames, it does not depend on what is visible.
  virtual nlohmann::ordered_json sceneEntry(const output::IdManifest& ids) const { return nullptr; }

  // Writes the files of the whole set. Returns the files' names relative to `folder`.
  virtual std::vector<std::string> writeSet(const SetEntries& set, const std::filesystem::path& folder) const {
    return {};
  }
  // Returns the name under which the format stores a frame, if it cannot store all names as they are. Names of
  // different frames must stay different.
  virtual std::string storedName(const std::string& frame) const { return frame; }
  // Returns the file of a frame with this entry that writeSet() copies into a file of the set, such as an archive, and
  // that is removed after the set is complete. Later calls of writeSet() must then find it in the archive.
  virtual std::optional<PackedFile> packed(const nlohmann::ordered_json& entry) const { return std::nullopt; }

 private:
  // Writes the frame's files, each whole or not at all, and completes the record, which is empty. It must depend only
  // on the frame. If it throws, the files that the record has so far are removed, so it must list a file once it may
  // exist.
  virtual void writeFiles(const DataFrame& frame, const std::filesystem::path& folder, FrameRecord& record) const = 0;
};

// Removes files below a folder. Ignores missing files, and keeps everything that is not a regular file.
void removeFiles(const std::filesystem::path& folder, const std::vector<std::string>& files);

// An entry of the table of formats. `make` accepts the format's options from the job, a JSON object. It throws
// Error(Usage) that names the invalid key.
struct FormatInfo {
  std::string_view name, description;
  std::unique_ptr<Format> (*make)(const nlohmann::ordered_json& options);
  // The option that accepts a value or the name of a .json file with that value; empty: none.
  std::string_view valueOrFile = {};
};
std::span<const FormatInfo> formats();

}  // namespace latelight::data
