// The format "voc": images, and an XML file per image with the box of each visible object, as in Pascal VOC (Everingham
// et al. 2010, "The Pascal Visual Object Classes Challenge").
#include <fmt/format.h>

#include "base/utf8.h"
#include "data/formats/categories.h"
#include "data/formats/formats.h"
#include "data/formats/frame_files.h"
#include "data/formats/options.h"
#include "data/formats/picture_file.h"

namespace latelight::data {

namespace {

using Json = nlohmann::ordered_json;

// Returns a text for the content of an element. Characters that XML does not allow (XML 1.0, production 2) are
// replaced: control characters by blanks, and bytes that are not UTF-8, which names of files may have, by U+FFFD.
std::string escaped(std::string_view text) {
  std::string out;
  while (!text.empty()) {
    const auto [code, bytes] = firstUtf8Character(text);
    if (code == '&')
      out += "&amp;";
    else if (code == '<')
      out += "&lt;";
    else if (code == '>')
      out += "&gt;";
    else if (code == Utf8Character::kInvalid || code == 0xfffe || code == 0xffff)
      out += "\ufffd";
    else
      out += code < 0x20 ? " " : text.substr(0, bytes);
    text.remove_prefix(bytes);
  }
  return out;
}

class Voc : public Format {
 public:
  explicit Voc(const Json& json) : Voc(json, FormatOptions("voc", json)) {}

  std::vector<output::Aov> needs() const override { return {output::Aov::Id}; }
  bool needsDisplay() const override { return picture_.isWritten(); }
  Extras needsExtras() const override { return {.boxes = true, .alone = true}; }
  std::vector<FormatFile> files(const DataFrame& frame) const override {
    std::vector<FormatFile> files = picture_.files(frame);
    files.push_back({frameFile(annotations_, frame)});
    return files;
  }

  void writeFiles(const DataFrame& frame, const std::filesystem::path& folder, FrameRecord& record) const override {
    const std::filesystem::path picture = picture_.write(record, frame, folder);
    const output::AovImage& ids = imageOf(frame.picture, output::Aov::Id);
    const std::map<uint32_t, Mask> masks = masksOf(ids);
    std::string text = fmt::format(
        "<annotation>\n  <folder>{}</folder>\n  <filename>{}</filename>\n  <source><database>Latelight</database>"
        "</source>\n  <size><width>{}</width><height>{}</height><depth>4</depth></size>\n"
        "  <segmented>0</segmented>\n",
        escaped(picture.parent_path().string()), escaped(picture.filename().string()), ids.width, ids.height);
    uint64_t count = 0;
    for (const Object& object : frame.objects) {
      const auto mask = masks.find(object.id);
      const std::string category = mask != masks.end() ? categories_.of(object.id, *frame.metadata.ids) : "";
      if (category.empty()) continue;
      ++count;
      text += describe(category, object, mask->second);
    }
    text += "</annotation>\n";
    writeOf(record, folder, frameFile(annotations_, frame), std::as_bytes(std::span(text)));
    record.entry = count;
  }

  std::vector<std::string> writeSet(const SetEntries& set, const std::filesystem::path& folder) const override {
    categories_.warnIfUnused(std::vector<uint64_t>(set.frames.begin(), set.frames.end()));
    return {};
  }

 private:
  Voc(const Json& json, FormatOptions options) : categories_("voc", options.find("categories")) {
    annotations_ = options.frameFile("annotations", "Annotations/{name}.xml", ".xml");
    picture_ = PictureFile(options);
    options.finish();
  }

  // Pixels are counted from 1, and the box includes its last ones. An object is truncated if a part of it lies beyond
  // the picture, and occluded if less than 95 % of its pixels in the picture are visible; VOC leaves this to
  // annotators.
  static std::string describe(const std::string& category, const Object& object, const Mask& mask) {
    const PixelBox box = mask.box();
    const bool isTruncated = object.pixels > object.alone.area();
    const bool isOccluded = double(mask.area()) < 0.95 * double(object.alone.area());
    return fmt::format(
        "  <object>\n    <name>{}</name>\n    <pose>Unspecified</pose>\n    <truncated>{}</truncated>\n"
        "    <occluded>{}</occluded>\n    <difficult>0</difficult>\n    <bndbox><xmin>{}</xmin><ymin>{}</ymin>"
        "<xmax>{}</xmax><ymax>{}</ymax></bndbox>\n  </object>\n",
        escaped(category), int(isTruncated), int(isOccluded), box.x + 1, box.y + 1, box.x + box.width,
        box.y + box.height);
  }

  Categories categories_;
  std::string annotations_;
  PictureFile picture_;
};

}  // namespace

std::unique_ptr<Format> makeVoc(const Json& options) {
  return std::make_unique<Voc>(options);
}

}  // namespace latelight::data
