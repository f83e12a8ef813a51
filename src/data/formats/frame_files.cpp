#include "data/formats/frame_files.h"

#include "base/error.h"
#include "base/files.h"
#include "output/png.h"

namespace latelight::data {

namespace fs = std::filesystem;

const output::AovImage& imageOf(const output::FrameOutput& picture, output::Aov aov) {
  for (const output::AovImage& image : picture.aovs)
    if (image.aov == aov) return image;
  fail(ExitCode::Internal, "the frame has no {}", output::info(aov).name);
}

std::string frameFile(std::string_view pattern, const DataFrame& frame) {
  constexpr std::string_view kName = "{name}";
  std::string file(pattern);
  for (size_t at = file.find(kName); at != std::string::npos; at = file.find(kName, at + frame.name.size()))
    file.replace(at, kName.size(), frame.name);
  return file;
}

void writeBelow(const fs::path& folder, const std::string& name, std::span<const std::byte> bytes) {
  const fs::path path = folder / name;
  std::error_code ignored;  // writing reports what is wrong
  fs::create_directories(path.parent_path(), ignored);
  writeFile(path, bytes);
}

void writeOf(FrameRecord& record, const fs::path& folder, const std::string& name, std::span<const std::byte> bytes) {
  writeBelow(folder, name, bytes);
  record.files.push_back(name);
}

std::vector<std::byte> displayPng(const output::FrameOutput& picture) {
  return output::encodePng(output::Picture{picture.width, picture.height, picture.display});
}

std::string jsonText(const nlohmann::ordered_json& json) {
  return json.dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace) + "\n";
}

}  // namespace latelight::data
