// The format "correspondence": where the surfaces of each frame are in other frames, one set of arrays per pair, and
// the list of all pairs.
#include <algorithm>

#include "base/error.h"
#include "base/text.h"
#include "data/formats/correspondence_arrays.h"
#include "data/formats/formats.h"
#include "data/formats/frame_files.h"
#include "data/formats/options.h"

namespace latelight::data {

namespace {

using Json = nlohmann::ordered_json;

// Returns the part of file names that identifies the target: "next", "previous", "+3", "-2", or a name.
std::string labelOf(const PairTarget& target) {
  if (target.kind == PairTarget::Kind::Step)
    return target.step == 1 ? "next" : target.step == -1 ? "previous" : fmt::format("{:+}", target.step);
  std::string label = target.name;
  for (char& c : label)
    if (c == '/' || c == '\\') c = '_';
  return label;
}

class CorrespondenceFiles : public Format {
 public:
  explicit CorrespondenceFiles(const Json& json) {
    FormatOptions options("correspondence", json);
    as_ = options.choice("as", {"npz", "npy", "exr"});
    file_ = options.frameFile("file", "correspondence/{name}.{to}." + as_, "." + as_);
    list_ = options.setFile("pairs", "correspondence/pairs.json", ".json");
    readTargets(options.find("to"));
    options.finish();
    if (targets_.size() > 1 && file_.find("{to}") == std::string::npos)
      badUsage("file of the format correspondence needs {{to}} in it, or each pair would replace the one before");
  }

  std::vector<output::Aov> needs() const override { return {output::Aov::Id}; }
  Extras needsExtras() const override { return {.pairs = targets_}; }
  std::vector<FormatFile> files(const DataFrame& frame) const override {
    std::vector<FormatFile> files;
    for (const PairTarget& target : targets_) {
      const std::string file = fileOf(frame, target);
      if (as_ == "npy")
        for (const auto& [array, bytes] : correspondenceArrays({})) files.push_back({arrayFile(file, array)});
      else
        files.push_back({file});
    }
    files.push_back({.name = list_, .ofSet = true});
    return files;
  }

  void writeFiles(const DataFrame& frame, const std::filesystem::path& folder, FrameRecord& record) const override {
    record.entry = Json::array();
    for (const FramePair& pair : frame.pairs) {
      if (std::ranges::find(targets_, pair.target) == targets_.end()) continue;
      const std::string file = fileOf(frame, pair.target);
      const Json time = pair.time ? Json(*pair.time) : Json(),
                 second = pair.second.empty() ? Json() : Json(pair.second);
      record.entry.push_back(
          {{"first", frame.name}, {"to", labelOf(pair.target)}, {"second", second}, {"time", time}, {"file", file}});
      if (as_ == "npz") writeOf(record, folder, file, encodeCorrespondenceNpz(pair.match));
      if (as_ == "exr") writeOf(record, folder, file, encodeCorrespondenceExr(pair.match, frame.metadata));
      if (as_ != "npy") continue;
      for (const auto& [array, bytes] : correspondenceArrays(pair.match))
        writeOf(record, folder, arrayFile(file, array), bytes);
    }
  }

  std::vector<std::string> writeSet(const SetEntries& set, const std::filesystem::path& folder) const override {
    const std::span<const Json> entries = set.frames;
    Json pairs = Json::array();
    for (const Json& entry : entries)
      for (const Json& pair : entry) pairs.push_back(pair);
    writeJsonIn(folder, list_, {{"pairs", pairs}});
    return {list_};
  }

 private:
  std::string fileOf(const DataFrame& frame, const PairTarget& target) const {
    std::string file = frameFile(file_, frame);
    replaceAll(file, "{to}", labelOf(target));
    return file;
  }
  // Inserts an array's name before the extension of a pair's file.
  static std::string arrayFile(std::string file, const std::string& array) {
    return file.insert(file.rfind('.'), "." + array);
  }

  void readTargets(const Json* to) {
    if (!to) {
      targets_ = {PairTarget{}};
      return;
    }
    for (const Json& each : to->is_array() ? *to : Json::array({*to})) targets_.push_back(targetOf(each));
    if (targets_.empty()) wrong();
    for (size_t i = 0; i < targets_.size(); ++i)
      for (size_t j = 0; j < i; ++j)
        if (labelOf(targets_[i]) == labelOf(targets_[j]))
          badUsage("to of the format correspondence has \"{}\" twice", labelOf(targets_[i]));
  }

  static PairTarget targetOf(const Json& json) {
    if (json == "next") return {.step = 1};
    if (json == "previous") return {.step = -1};
    if (json.is_number_integer() && json != 0 && json >= -kMaxStep && json <= kMaxStep)
      return {.step = json.get<int64_t>()};
    if (!json.is_object() || json.size() != 1 || !json.front().is_string() || json.front().get<std::string>().empty())
      wrong();
    const std::string key = json.begin().key();
    if (key != "camera" && key != "member") wrong();
    return {.kind = key == "camera" ? PairTarget::Kind::Camera : PairTarget::Kind::Member,
            .name = json.front().get<std::string>()};
  }

  [[noreturn]] static void wrong() {
    badUsage(
        "to of the format correspondence takes one or a list of next, previous, a number of frames other than 0, "
        "{{\"camera\": NAME}} and {{\"member\": NAME}}");
  }

  static constexpr int64_t kMaxStep = 1'000'000;  // the maximum number of cameras of a source

  std::string as_, file_, list_;
  std::vector<PairTarget> targets_;
};

}  // namespace

std::unique_ptr<Format> makeCorrespondence(const Json& options) {
  return std::make_unique<CorrespondenceFiles>(options);
}

}  // namespace latelight::data
