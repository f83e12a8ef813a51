// Outputs of each frame as plain files: PNG, EXR or NPY, with a side file.
#include "data/formats/files.h"

#include <algorithm>

#include "base/error.h"
#include "output/files.h"

namespace latelight::data {

namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

constexpr std::string_view kName = "{name}";

class Files : public Format {
 public:
  explicit Files(const Json& options) {
    for (const auto& [key, value] : options.items()) take(key, value);
    const size_t at = request_.pattern.find(kName);
    if (at == std::string::npos) badUsage("pattern needs {{name}}, or each frame would replace the one before");
    if (fs::path(request_.pattern).is_absolute() || request_.pattern.find("..") != std::string::npos)
      badUsage("pattern is a name below the data set's folder, not \"{}\"", request_.pattern);
    output::OutputRequest filled = request_;
    filled.pattern.replace(at, kName.size(), 1, '0');
    output::fillPattern(filled.pattern, "", {});
    if (output::formatOf(filled.pattern) == output::Format::Png)
      for (const output::Aov aov : request_.aovs)
        if (output::info(aov).png == output::PngCoding::None)
          badUsage("a PNG file can't hold {}; end the pattern in .exr or .npy", output::info(aov).name);
  }

  std::vector<output::Aov> needs() const override {
    std::vector<output::Aov> aovs = request_.aovs;
    if (needsDisplay()) std::erase(aovs, output::Aov::Color);
    return aovs;
  }
  bool needsDisplay() const override { return output::usesDisplay(request_); }

  FrameRecord writeFrame(const DataFrame& frame, const fs::path& folder) const override {
    output::OutputRequest request = request_;
    request.pattern.replace(request.pattern.find(kName), kName.size(), frame.name);
    request.pattern = (folder / request.pattern).string();
    for (const fs::path& path : output::outputPaths(request, frame.metadata)) {
      std::error_code ignored;  // writing reports what is wrong
      fs::create_directories(path.parent_path(), ignored);
    }
    FrameRecord record;
    for (const fs::path& path : output::writeOutput(request, frame.picture, frame.metadata))
      record.files.push_back(path.lexically_relative(folder).generic_string());
    return record;
  }

 private:
  void take(const std::string& key, const Json& value) {
    if (key == "pattern") {
      if (!value.is_string()) badUsage("pattern takes a text, as in {{name}}.png");
      request_.pattern = value.get<std::string>();
    } else if (key == "side-file") {
      if (!value.is_boolean()) badUsage("side-file takes true or false");
      request_.sideFile = value.get<bool>();
    } else if (key == "outputs") {
      request_.aovs = outputsOf(value);
    } else {
      badUsage("files has no key \"{}\"; it has outputs, pattern and side-file", key);
    }
  }

  static std::vector<output::Aov> outputsOf(const Json& names) {
    std::string list;
    const auto isText = [](const Json& name) { return name.is_string(); };
    if (!names.is_array() || names.empty() || !std::ranges::all_of(names, isText))
      badUsage("outputs takes a list of names (latelight list aovs)");
    for (const Json& name : names) {
      list += list.empty() ? "" : ",";
      list += name.get<std::string>();
    }
    return output::parseAovs(list);
  }

  output::OutputRequest request_{.pattern = "{name}.png"};
};

}  // namespace

std::unique_ptr<Format> makeFiles(const Json& options) {
  return std::make_unique<Files>(options);
}

}  // namespace latelight::data
