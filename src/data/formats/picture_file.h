// The picture for viewing that a format's entries name: its file, and whether the format writes it itself.
#pragma once

#include "data/format.h"
#include "data/formats/options.h"

namespace latelight::data {

class PictureFile {
 public:
  PictureFile() = default;
  // The options "picture" and "write-pictures".
  explicit PictureFile(FormatOptions& options);

  bool isWritten() const { return isWritten_; }
  // The frame's, written where it is to be.
  std::string write(FrameRecord& record, const DataFrame& frame, const std::filesystem::path& folder) const;

 private:
  std::string pattern_;
  bool isWritten_ = false;
};

}  // namespace latelight::data
