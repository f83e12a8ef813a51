// The format "coco", COCO instances: one JSON file for the set, with a box, an instance mask and a category for each
// visible object.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <map>

#include "base/parallel.h"
#include "data/formats/categories.h"
#include "data/formats/formats.h"
#include "data/formats/frame_files.h"
#include "data/formats/names.h"
#include "data/formats/options.h"
#include "data/formats/picture_file.h"
#include "data/json_text.h"

namespace latelight::data {

namespace {

using Json = nlohmann::ordered_json;

Json boxOf(const PixelBox& box) {
  return {box.x, box.y, box.width, box.height};
}

std::string imageOfSet(const Json& entry) {
  Json image = Json::object();
  for (const auto& [key, value] : entry.items())
    if (key != "objects") image[key] = value;
  return dumped(image);
}

// Returns the comma-separated annotations of a picture. `number` is the id of the first.
std::string annotationsOf(const Json& entry, uint64_t number, const std::map<std::string, uint64_t>& categories) {
  std::string text;
  for (const Json& object : entry["objects"]) {
    Json annotation{{"id", number++},
                    {"image_id", entry["id"]},
                    {"category_id", categories.at(object["category"].get<std::string>())},
                    {"iscrowd", 0}};
    annotation.update(object);
    annotation.erase("category");
    if (!text.empty()) text += ',';
    text += dumped(annotation);
  }
  return text;
}

class Coco : public Format {
 public:
  explicit Coco(const Json& json) : Coco(json, FormatOptions("coco", json)) {}

  std::vector<output::Aov> needs() const override { return {output::Aov::Id}; }
  bool needsDisplay() const override { return picture_.isWritten(); }

  FrameRecord writeFrame(const DataFrame& frame, const std::filesystem::path& folder) const override {
    FrameRecord record;
    const std::string picture = picture_.write(record, frame, folder);
    const output::AovImage& ids = imageOf(frame.picture, output::Aov::Id);
    Json objects = Json::array();
    for (const auto& [id, mask] : masksOf(ids)) {
      const std::string category = categories_.of(id, *frame.metadata.ids);
      if (category.empty()) continue;
      objects.push_back({{"category", category},
                         {"area", mask.area()},
                         {"bbox", boxOf(mask.box())},
                         {"segmentation", {{"size", {mask.height, mask.width}}, {"counts", mask.counts()}}},
                         {"object", id},
                         {"node", nameOf(*entryOf(*frame.metadata.ids, id))}});
    }
    record.entry = {{"id", frame.index},
                    {"file_name", picture},
                    {"width", ids.width},
                    {"height", ids.height},
                    {"objects", objects}};
    return record;
  }

  std::vector<std::string> writeSet(std::span<const Json> entries, const std::filesystem::path& folder) const override {
    std::map<std::string, uint64_t> numbers;
    const Json categories = categoriesOf(entries, numbers);
    std::vector<uint64_t> first(entries.size() + 1, 1);  // id of each picture's first annotation
    for (size_t i = 0; i < entries.size(); ++i) first[i + 1] = first[i] + entries[i]["objects"].size();
    std::vector<std::string> images(entries.size()), annotations(entries.size());
    parallelFor(entries.size(), 16, [&](size_t begin, size_t end) {
      for (size_t i = begin; i < end; ++i) {
        images[i] = imageOfSet(entries[i]);
        annotations[i] = annotationsOf(entries[i], first[i], numbers);
      }
    });
    std::erase(annotations, "");
    const std::string text = fmt::format(
        R"({{"info":{{"description":"rendered by Latelight"}},"licenses":[],"images":[{}],"annotations":[{}],)"
        R"("categories":{}}})"
        "\n",
        fmt::join(images, ","), fmt::join(annotations, ","), dumped(categories));
    writeIn(folder, file_, std::as_bytes(std::span(text)));
    return {file_};
  }

 private:
  Coco(const Json& json, FormatOptions options) : categories_("coco", options.find("categories")) {
    file_ = options.setFile("file", "annotations/instances.json", ".json");
    picture_ = PictureFile(options);
    options.finish();
  }

  // Numbers the categories from 1.
  Json categoriesOf(std::span<const Json> entries, std::map<std::string, uint64_t>& numbers) const {
    Json categories = Json::array();
    for (const std::string& name : categories_.all(entries)) {
      numbers[name] = categories.size() + 1;
      categories.push_back({{"id", categories.size() + 1}, {"name", name}, {"supercategory", ""}});
    }
    return categories;
  }

  Categories categories_;
  std::string file_;
  PictureFile picture_;
};

}  // namespace

std::unique_ptr<Format> makeCoco(const Json& options) {
  return std::make_unique<Coco>(options);
}

}  // namespace latelight::data
