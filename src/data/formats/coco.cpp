// The format "coco", COCO instances: one JSON file for the set, with a box, an instance mask and a category for each
// visible object.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <map>

#include "base/error.h"
#include "base/log.h"
#include "base/parallel.h"
#include "data/formats/categories.h"
#include "data/formats/formats.h"
#include "data/formats/frame_files.h"
#include "data/formats/mask_json.h"
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
                    {"category_id", Categories::numberOf(object, categories)},
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
  Extras needsExtras() const override { return {.boxes = amodal_, .alone = amodal_, .keypoints = keypoints_}; }
  bool needsDisplay() const override { return picture_.isWritten(); }
  std::vector<FormatFile> files(const DataFrame& frame) const override {
    std::vector<FormatFile> files = picture_.files(frame);
    files.push_back({.name = file_, .ofSet = true});
    return files;
  }

  void writeFiles(const DataFrame& frame, const std::filesystem::path& folder, FrameRecord& record) const override {
    const std::string picture = picture_.write(record, frame, folder);
    const output::AovImage& ids = imageOf(frame.picture, output::Aov::Id);
    Json objects = Json::array();
    for (const auto& [id, mask] : masksOf(ids)) {
      const std::string category = categories_.of(id, *frame.metadata.ids);
      if (category.empty()) continue;
      objects.push_back({{"category", category},
                         {"area", mask.area()},
                         {"bbox", boxOf(mask.box())},
                         {"segmentation", segmentationOf(mask)},
                         {"object", id},
                         {"node", nameOf(*entryOf(*frame.metadata.ids, id))}});
      if (amodal_) addAmodal(objects.back(), frame, id, mask);
      // The frame also has keypoints if only another format of the job requires them.
      const auto keypoints = frame.keypoints.find(id);
      if (!keypoints_.empty() && keypoints != frame.keypoints.end()) addKeypoints(objects.back(), keypoints->second);
    }
    record.entry = {{"id", frame.index},
                    {"file_name", picture},
                    {"width", ids.width},
                    {"height", ids.height},
                    {"objects", objects}};
  }

  Json sceneEntry(const output::IdManifest& ids) const override { return categories_.ofScene(ids); }
  std::vector<std::string> writeSet(const SetEntries& set, const std::filesystem::path& folder) const override {
    const std::span<const Json> entries = set.frames;
    std::map<std::string, uint64_t> numbers;
    const Json categories = categoriesOf(set, numbers);
    const std::vector<uint64_t> counts = Categories::countsOf(entries);
    categories_.warnIfUnused(counts);
    std::vector<uint64_t> first(entries.size() + 1, 1);  // id of each picture's first annotation
    for (size_t i = 0; i < entries.size(); ++i) first[i + 1] = first[i] + counts[i];
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
    amodal_ = options.flag("amodal", false);
    if (const Json* list = options.find("keypoints")) keypoints_ = readKeypoints(*list, "keypoints of the format coco");
    if (const Json* list = options.find("skeleton")) readSkeleton(*list);
    options.finish();
  }

  // Reads pairs of keypoints that are connected.
  void readSkeleton(const Json& list) {
    const auto number = [&](const Json& name) {
      const auto isNamed = [&](const ObjectKeypoint& keypoint) { return name == keypoint.name; };
      const auto found = std::ranges::find_if(keypoints_, isNamed);
      if (found == keypoints_.end())
        badUsage("skeleton of the format coco names {}, which is not among its keypoints", dumped(name));
      return found - keypoints_.begin() + 1;
    };
    const bool pairs =
        list.is_array() && std::ranges::all_of(list, [](const Json& p) { return p.is_array() && p.size() == 2; });
    if (!pairs) badUsage("skeleton of the format coco takes a list of pairs of keypoints' names");
    for (const Json& pair : list) skeleton_.push_back(Json::array({number(pair[0]), number(pair[1])}));
  }

  // The object's amodal mask, with the keys of its visible mask, and the share of it that is visible.
  static void addAmodal(Json& annotation, const DataFrame& frame, uint32_t id, const Mask& visible) {
    const auto object = std::ranges::find(frame.objects, id, &Object::id);
    if (object == frame.objects.end()) return;
    annotation["amodal_area"] = object->alone.area();
    annotation["amodal_bbox"] = boxOf(object->alone.box());
    annotation["amodal_segmentation"] = segmentationOf(object->alone);
    annotation["visibility"] = static_cast<double>(visible.area()) / static_cast<double>(object->pixels);
  }

  static void addKeypoints(Json& annotation, const std::vector<labels::ProjectedKeypoint>& keypoints) {
    Json values = Json::array();
    uint64_t count = 0;
    for (const labels::ProjectedKeypoint& k : keypoints) {
      const bool inside = k.visibility != labels::KeypointVisibility::Outside;
      values.push_back(inside ? k.pixel.x : 0);
      values.push_back(inside ? k.pixel.y : 0);
      values.push_back(static_cast<uint32_t>(k.visibility));
      count += inside;
    }
    annotation["keypoints"] = std::move(values);
    annotation["num_keypoints"] = count;
  }

  // Numbers the categories from 1.
  Json categoriesOf(const SetEntries& set, std::map<std::string, uint64_t>& numbers) const {
    Json categories = Json::array();
    for (const std::string& name : categories_.all(set)) {
      numbers[name] = categories.size() + 1;
      categories.push_back({{"id", categories.size() + 1}, {"name", name}, {"supercategory", ""}});
    }
    if (!keypoints_.empty()) addKeypointNames(set.frames, numbers, categories);
    return categories;
  }

  // Adds the names of keypoints to the categories of objects that have any.
  void addKeypointNames(std::span<const Json> entries, const std::map<std::string, uint64_t>& numbers,
                        Json& categories) const {
    Json names = Json::array();
    for (const ObjectKeypoint& keypoint : keypoints_) names.push_back(keypoint.name);
    bool isAny = false;
    for (const Json& entry : entries)
      for (const Json& object : entry["objects"]) {
        if (!object.contains("keypoints")) continue;
        isAny = true;
        Json& category = categories[Categories::numberOf(object, numbers) - 1];
        category["keypoints"] = names;
        category["skeleton"] = skeleton_;
      }
    if (!isAny) warn("no visible object has a node of the keypoints: \"node\" is {}", kKeypointNodeHelp);
  }

  Categories categories_;
  std::string file_;
  PictureFile picture_;
  bool amodal_ = false;
  std::vector<ObjectKeypoint> keypoints_;
  Json skeleton_ = Json::array();  // pairs of numbers of keypoints, from 1
};

}  // namespace

std::unique_ptr<Format> makeCoco(const Json& options) {
  return std::make_unique<Coco>(options);
}

}  // namespace latelight::data
