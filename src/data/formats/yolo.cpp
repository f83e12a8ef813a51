// The format "yolo": images, a text file per image with the class, box and keypoints of each visible object, and
// data.yaml with the names of the classes, as Ultralytics reads them. Classes are numbered over the whole set, so the
// text files are written at its end.
#include <fmt/format.h>

#include <map>

#include "base/parallel.h"
#include "base/text.h"
#include "data/formats/categories.h"
#include "data/formats/formats.h"
#include "data/formats/frame_files.h"
#include "data/formats/options.h"
#include "data/formats/picture_file.h"
#include "data/json_text.h"

namespace latelight::data {

namespace {

using Json = nlohmann::ordered_json;

// Returns a name as a double-quoted string of YAML: JSON's, in which the characters that YAML does not allow or that
// are its line breaks are escaped, too (YAML 1.1, 5.1 and 5.4).
std::string yamlString(const std::string& name) {
  std::string text = dumped(Json(name));
  replaceAll(text, "\x7f", "\\u007f");
  for (int code = 0x80; code < 0xa0; ++code)
    replaceAll(text, std::string{'\xc2', static_cast<char>(code)}, fmt::format("\\u{:04x}", code));
  replaceAll(text, "\u2028", "\\u2028");
  replaceAll(text, "\u2029", "\\u2029");
  replaceAll(text, "\ufeff", "\\ufeff");
  replaceAll(text, "\ufffe", "\\ufffe");
  replaceAll(text, "\uffff", "\\uffff");
  return text;
}

class Yolo : public Format {
 public:
  explicit Yolo(const Json& json) : Yolo(json, FormatOptions("yolo", json)) {}

  std::vector<output::Aov> needs() const override { return {output::Aov::Id}; }
  Extras needsExtras() const override { return {.keypoints = keypoints_}; }
  bool needsDisplay() const override { return picture_.isWritten(); }
  std::vector<FormatFile> files(const DataFrame& frame) const override {
    std::vector<FormatFile> files = picture_.files(frame);
    files.push_back({frameFile(labels_, frame)});
    files.push_back({.name = file_, .ofSet = true});
    return files;
  }

  void writeFiles(const DataFrame& frame, const std::filesystem::path& folder, FrameRecord& record) const override {
    picture_.write(record, frame, folder);
    const output::AovImage& ids = imageOf(frame.picture, output::Aov::Id);
    Json objects = Json::array();
    for (const auto& [id, mask] : masksOf(ids)) {
      const std::string category = categories_.of(id, *frame.metadata.ids);
      if (category.empty()) continue;
      const PixelBox box = mask.box();
      const double width = ids.width, height = ids.height;
      objects.push_back(
          {{"category", category},
           {"box",
            {(double(box.x) + double(box.width) / 2) / width, (double(box.y) + double(box.height) / 2) / height,
             double(box.width) / width, double(box.height) / height}}});
      if (!keypoints_.empty()) objects.back()["keypoints"] = keypointsOf(frame, id, ids);
    }
    record.entry = {{"file", frameFile(labels_, frame)}, {"objects", std::move(objects)}};
  }

  Json sceneEntry(const output::IdManifest& ids) const override { return categories_.ofScene(ids); }
  std::vector<std::string> writeSet(const SetEntries& set, const std::filesystem::path& folder) const override {
    const std::span<const Json> entries = set.frames;
    const std::vector<std::string> names = categories_.all(set);
    std::map<std::string, uint64_t> numbers;
    for (size_t i = 0; i < names.size(); ++i) numbers[names[i]] = i;
    categories_.warnIfUnused(Categories::countsOf(entries));
    std::vector<std::string> files(entries.size());
    parallelFor(entries.size(), 16, [&](size_t begin, size_t end) {
      for (size_t i = begin; i < end; ++i) files[i] = writeLabels(entries[i], numbers, folder);
    });
    // Without "path", Ultralytics starts from the file's own folder.
    const std::string pictures = yamlString(pictureFolder());
    std::string text = fmt::format("train: {0}\nval: {0}\n", pictures);
    if (!keypoints_.empty()) text += fmt::format("kpt_shape: [{}, 3]\n", keypoints_.size());
    text += "names:\n";
    for (size_t i = 0; i < names.size(); ++i) text += fmt::format("  {}: {}\n", i, yamlString(names[i]));
    writeIn(folder, file_, std::as_bytes(std::span(text)));
    files.push_back(file_);
    return files;
  }

 private:
  Yolo(const Json& json, FormatOptions options) : categories_("yolo", options.find("categories")) {
    file_ = options.setFile("file", "data.yaml", ".yaml");
    labels_ = options.frameFile("labels", "labels/{name}.txt", ".txt");
    picture_ = PictureFile(options);
    if (const Json* list = options.find("keypoints")) keypoints_ = readKeypoints(*list, "keypoints of the format yolo");
    options.finish();
  }

  // Returns the folder of the pictures, relative to that of data.yaml.
  std::string pictureFolder() const {
    const std::filesystem::path set("/");
    const auto folderOf = [&](const std::string& file) { return (set / file).lexically_normal().parent_path(); };
    return folderOf(picture_.folder() + "name").lexically_relative(folderOf(file_));
  }

  // Three values per keypoint: coordinates as shares of the image's width and height, and COCO's visibility. Readers
  // expect as many for each object: a keypoint that is not there is 0 0 0.
  Json keypointsOf(const DataFrame& frame, uint32_t id, const output::AovImage& ids) const {
    Json values = Json::array();
    const auto found = frame.keypoints.find(id);
    for (size_t i = 0; i < keypoints_.size(); ++i) {
      const bool has = found != frame.keypoints.end();
      const labels::ProjectedKeypoint point = has ? found->second[i] : labels::ProjectedKeypoint{};
      const bool isInside = has && point.visibility != labels::KeypointVisibility::Outside;
      values.push_back(isInside ? point.pixel.x / ids.width : 0);
      values.push_back(isInside ? point.pixel.y / ids.height : 0);
      values.push_back(isInside ? static_cast<uint32_t>(point.visibility) : 0);
    }
    return values;
  }

  // One line per object: class, center and size, as shares of the image's width and height, and keypoints. No lines: no
  // objects.
  static std::string writeLabels(const Json& entry, const std::map<std::string, uint64_t>& numbers,
                                 const std::filesystem::path& folder) {
    std::string text;
    for (const Json& object : entry["objects"]) {
      const Json& box = object["box"];
      text += fmt::format("{} {:.8f} {:.8f} {:.8f} {:.8f}", Categories::numberOf(object, numbers), box[0].get<double>(),
                          box[1].get<double>(), box[2].get<double>(), box[3].get<double>());
      if (object.contains("keypoints")) text += keypointText(object["keypoints"]);
      text += '\n';
    }
    std::string file = entry["file"].get<std::string>();
    writeIn(folder, file, std::as_bytes(std::span(text)));
    return file;
  }

  static std::string keypointText(const Json& keypoints) {
    std::string text;
    for (size_t i = 0; i + 2 < keypoints.size(); i += 3)
      text += fmt::format(" {:.8f} {:.8f} {}", keypoints[i].get<double>(), keypoints[i + 1].get<double>(),
                          keypoints[i + 2].get<uint32_t>());
    return text;
  }

  Categories categories_;
  std::string file_, labels_;
  PictureFile picture_;
  std::vector<ObjectKeypoint> keypoints_;
};

}  // namespace

std::unique_ptr<Format> makeYolo(const Json& options) {
  return std::make_unique<Yolo>(options);
}

}  // namespace latelight::data
