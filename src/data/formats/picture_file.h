// The file of the picture for viewing that a format's entries refer to. The format may also write the file.
#pragma once

#include "data/format.h"
#include "data/formats/options.h"

namespace latelight::data {

// Describes the contents of files with FrameOutput::displayPng(), as FormatFile::contents.
inline constexpr const char* kPictureContents = "image for viewing";

class PictureFile {
 public:
  PictureFile() = default;
  // Reads the options "picture", whose default is `pattern`, and "write-pictures".
  explicit PictureFile(FormatOptions& options, const char* pattern = "images/{name}.png");

  bool isWritten() const { return isWritten_; }
  std::string file(const DataFrame& frame) const;  // the name of the frame's file
  // Returns the frame's file with the description of its contents; empty unless isWritten().
  std::vector<FormatFile> files(const DataFrame& frame) const;
  // Returns the name of the frame's file, and writes the file if isWritten().
  std::string write(FrameRecord& record, const DataFrame& frame, const std::filesystem::path& folder) const;
  // The folder of all pictures: the part of the pattern up to the last slash before "{name}"; empty if there is none.
  std::string folder() const;

 private:
  std::string pattern_;
  bool isWritten_ = false;
};

}  // namespace latelight::data
