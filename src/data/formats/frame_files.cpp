#include "data/formats/frame_files.h"

#include "base/error.h"
#include "base/files.h"
#include "base/text.h"
#include "data/json_text.h"

namespace latelight::data {

namespace fs = std::filesystem;

const output::AovImage& imageOf(const output::FrameOutput& picture, output::Aov aov) {
  for (const output::AovImage& image : picture.aovs)
    if (image.aov == aov) return image;
  fail(ExitCode::Internal, "the frame has no {}", output::info(aov).name);
}

output::Metadata metadataOf(const DataFrame& frame) {
  output::Metadata metadata = frame.metadata;
  if (metadata.ids)
    metadata.ids = std::make_shared<output::IdManifest>(output::shownIn(*frame.metadata.ids, frame.picture.aovs));
  return metadata;
}

std::vector<uint8_t> rgbOverBlack(const output::FrameOutput& picture) {
  std::vector<uint8_t> rgb(picture.display.size() / 4 * 3);
  for (size_t i = 0; i < rgb.size(); ++i) {
    const uint8_t* pixel = &picture.display[i / 3 * 4];
    rgb[i] = static_cast<uint8_t>((pixel[i % 3] * pixel[3] + 127) / 255);
  }
  return rgb;
}

std::string frameFile(std::string_view pattern, const DataFrame& frame) {
  std::string file(pattern);
  replaceAll(file, "{name}", frame.name);
  return file;
}

void writeIn(const fs::path& folder, const std::string& name, std::span<const std::byte> bytes) {
  const fs::path path = folder / name;
  std::error_code ignored;  // errors are reported when the file is written
  fs::create_directories(path.parent_path(), ignored);
  writeFile(path, bytes);
}

void writeOf(FrameRecord& record, const fs::path& folder, const std::string& name, std::span<const std::byte> bytes) {
  writeIn(folder, name, bytes);
  record.files.push_back(name);
}

void writeJsonIn(const fs::path& folder, const std::string& name, const nlohmann::ordered_json& json) {
  const std::string text = dumped(json) + "\n";
  writeIn(folder, name, std::as_bytes(std::span(text)));
}

}  // namespace latelight::data
