#include "data/formats/picture_file.h"

#include "data/formats/frame_files.h"

namespace latelight::data {

PictureFile::PictureFile(FormatOptions& options, const char* pattern)
    : pattern_(options.frameFile("picture", pattern, ".png")), isWritten_(options.flag("write-pictures", true)) {}

std::string PictureFile::file(const DataFrame& frame) const {
  return frameFile(pattern_, frame);
}

std::vector<FormatFile> PictureFile::files(const DataFrame& frame) const {
  if (!isWritten_) return {};
  return {{file(frame), kPictureContents}};
}

std::string PictureFile::write(FrameRecord& record, const DataFrame& frame, const std::filesystem::path& folder) const {
  const std::string name = file(frame);
  if (isWritten_) writeOf(record, folder, name, frame.picture.displayPng());
  return name;
}

std::string PictureFile::folder() const {
  return pattern_.substr(0, pattern_.rfind('/', pattern_.find("{name}")) + 1);
}

}  // namespace latelight::data
