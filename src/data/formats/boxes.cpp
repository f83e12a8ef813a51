// The format "boxes", one JSON file per frame. Each object has a 2D box of its visible pixels, a 2D box of its amodal
// mask, and an oriented 3D box; masks and keypoints are optional.
#include "data/formats/formats.h"
#include "data/formats/frame_files.h"
#include "data/formats/object_labels.h"
#include "data/formats/options.h"
#include "data/json_text.h"

namespace latelight::data {

namespace {

using Json = nlohmann::ordered_json;

class Boxes : public Format {
 public:
  explicit Boxes(const Json& json) {
    FormatOptions options("boxes", json);
    file_ = options.frameFile("file", "boxes/{name}.json", ".json");
    labels_.whole = options.flag("whole", true);
    labels_.masks = options.flag("masks", false);
    if (const Json* list = options.find("keypoints"))
      labels_.keypoints = readKeypoints(*list, "keypoints of the format boxes");
    options.finish();
  }

  std::vector<output::Aov> needs() const override { return labels_.needs(); }
  Extras needsExtras() const override { return labels_.needsExtras(); }
  std::vector<FormatFile> files(const DataFrame& frame) const override { return {{frameFile(file_, frame)}}; }

  void writeFiles(const DataFrame& frame, const std::filesystem::path& folder, FrameRecord& record) const override {
    const std::string text = dumped(labels_.describe(frame)) + "\n";
    writeOf(record, folder, frameFile(file_, frame), std::as_bytes(std::span(text)));
  }

 private:
  std::string file_;
  ObjectLabels labels_;
};

}  // namespace

std::unique_ptr<Format> makeBoxes(const Json& options) {
  return std::make_unique<Boxes>(options);
}

}  // namespace latelight::data
