// The format "files": the outputs of each frame as PNG, EXR or NPY files, with an optional side file of metadata.
#include "output/files.h"

#include "base/error.h"
#include "base/text.h"
#include "data/formats/formats.h"
#include "data/formats/frame_files.h"
#include "data/formats/options.h"
#include "data/formats/picture_file.h"

namespace latelight::data {

namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

constexpr std::string_view kName = "{name}";

class Files : public Format {
 public:
  explicit Files(const Json& json) {
    FormatOptions options("files", json);
    request_.aovs = options.outputs("outputs", request_.aovs);
    request_.pattern = options.text("pattern", request_.pattern);
    if (options.find("side-file")) request_.sideFile = options.flag("side-file", false);
    options.finish();
    checkPattern();
  }

  std::vector<output::Aov> needs() const override {
    std::vector<output::Aov> aovs = request_.aovs;
    if (needsDisplay()) std::erase(aovs, output::Aov::Color);
    return aovs;
  }
  bool needsDisplay() const override { return output::usesDisplay(request_); }

  std::vector<FormatFile> files(const DataFrame& frame) const override {
    std::vector<FormatFile> files;
    for (const fs::path& path : output::outputPaths(requestOf(frame), frame.metadata)) {
      const bool isPicture =
          needsDisplay() && files.size() < request_.aovs.size() && request_.aovs[files.size()] == output::Aov::Color;
      files.push_back({path.generic_string(), isPicture ? kPictureContents : ""});
    }
    return files;
  }

  void writeFiles(const DataFrame& frame, const fs::path& folder, FrameRecord& record) const override {
    output::OutputRequest request = requestOf(frame);
    request.pattern = (folder / request.pattern).string();
    for (const fs::path& path : output::outputPaths(request, frame.metadata)) {
      std::error_code ignored;  // errors are reported when the file is written
      fs::create_directories(path.parent_path(), ignored);
      record.files.push_back(path.lexically_relative(folder).generic_string());
    }
    const bool listsIds = output::writesMetadata(request);
    output::writeOutput(request, frame.picture, listsIds ? metadataOf(frame) : frame.metadata);
  }

 private:
  // Returns the request of a frame, with a path relative to the data set's folder.
  output::OutputRequest requestOf(const DataFrame& frame) const { return requestOf(frame.name); }
  output::OutputRequest requestOf(const std::string& name) const {
    output::OutputRequest request = request_;
    replaceAll(request.pattern, kName, name);
    return request;
  }

  void checkPattern() const {
    if (request_.pattern.find(kName) == std::string::npos)
      badUsage("pattern must contain {{name}}; otherwise each frame would replace the previous one");
    if (fs::path(request_.pattern).is_absolute() || request_.pattern.find("..") != std::string::npos)
      badUsage("pattern must be a path below the data set's folder, not \"{}\"", request_.pattern);
    const output::OutputRequest filled = requestOf("0");
    const output::Metadata nothing;
    output::fillPattern(filled.pattern, "", nothing);
    if (output::formatOf(filled.pattern) == output::Format::Png)
      for (const output::Aov aov : request_.aovs)
        if (output::info(aov).png == output::PngCoding::None)
          badUsage("a PNG file cannot store {}; use .exr or .npy in the pattern", output::info(aov).name);
  }

  output::OutputRequest request_{.pattern = "{name}.png"};
};

}  // namespace

std::unique_ptr<Format> makeFiles(const Json& options) {
  return std::make_unique<Files>(options);
}

}  // namespace latelight::data
