// The format "yolo": images, a text file per image with the class and box of each visible object, and data.yaml with
// the names of the classes, as Ultralytics reads them. Classes are numbered over the whole set, so the text files are
// written at its end.
#include <fmt/format.h>

#include <map>

#include "base/parallel.h"
#include "data/formats/categories.h"
#include "data/formats/formats.h"
#include "data/formats/frame_files.h"
#include "data/formats/options.h"
#include "data/formats/picture_file.h"
#include "data/json_text.h"

namespace latelight::data {

namespace {

using Json = nlohmann::ordered_json;

class Yolo : public Format {
 public:
  explicit Yolo(const Json& json) : Yolo(json, FormatOptions("yolo", json)) {}

  std::vector<output::Aov> needs() const override { return {output::Aov::Id}; }
  bool needsDisplay() const override { return picture_.isWritten(); }

  FrameRecord writeFrame(const DataFrame& frame, const std::filesystem::path& folder) const override {
    FrameRecord record;
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
    }
    record.entry = {{"file", frameFile(labels_, frame)}, {"objects", std::move(objects)}};
    return record;
  }

  std::vector<std::string> writeSet(std::span<const Json> entries, const std::filesystem::path& folder) const override {
    const std::vector<std::string> names = categories_.all(entries);
    std::map<std::string, size_t> numbers;
    for (size_t i = 0; i < names.size(); ++i) numbers[names[i]] = i;
    std::vector<std::string> files(entries.size());
    parallelFor(entries.size(), 16, [&](size_t begin, size_t end) {
      for (size_t i = begin; i < end; ++i) files[i] = writeLabels(entries[i], numbers, folder);
    });
    std::string text = "path: .\ntrain: images\nval: images\nnames:\n";
    for (size_t i = 0; i < names.size(); ++i) text += fmt::format("  {}: {}\n", i, dumped(Json(names[i])));
    writeIn(folder, file_, std::as_bytes(std::span(text)));
    files.push_back(file_);
    return files;
  }

 private:
  Yolo(const Json& json, FormatOptions options) : categories_("yolo", options.find("categories")) {
    file_ = options.setFile("file", "data.yaml", ".yaml");
    labels_ = options.frameFile("labels", "labels/{name}.txt", ".txt");
    picture_ = PictureFile(options);
    options.finish();
  }

  // One line per object: class, center and size, as shares of the image's width and height. No lines: no objects.
  static std::string writeLabels(const Json& entry, const std::map<std::string, size_t>& numbers,
                                 const std::filesystem::path& folder) {
    std::string text;
    for (const Json& object : entry["objects"]) {
      const Json& box = object["box"];
      text += fmt::format("{} {:.8f} {:.8f} {:.8f} {:.8f}\n", numbers.at(object["category"].get<std::string>()),
                          box[0].get<double>(), box[1].get<double>(), box[2].get<double>(), box[3].get<double>());
    }
    std::string file = entry["file"].get<std::string>();
    writeIn(folder, file, std::as_bytes(std::span(text)));
    return file;
  }

  Categories categories_;
  std::string file_, labels_;
  PictureFile picture_;
};

}  // namespace

std::unique_ptr<Format> makeYolo(const Json& options) {
  return std::make_unique<Yolo>(options);
}

}  // namespace latelight::data
