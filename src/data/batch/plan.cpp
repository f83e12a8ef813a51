#include "data/batch/plan.h"

#include <latelight/latelight.h>

#include <algorithm>
#include <bit>
#include <unordered_set>

#include "base/error.h"
#include "base/files.h"
#include "base/hash.h"
#include "base/text.h"
#include "data/json_text.h"
#include "data/stop.h"
#include "output/files.h"

namespace latelight::data {

using Json = nlohmann::ordered_json;

namespace {

uint64_t hashOf(const Json& json) {
  const std::string text = dumped(json);
  return hash64(text.data(), text.size());
}

uint64_t hashOfFiles(const std::vector<std::string>& files) {
  uint64_t hash = 0;
  for (const std::string& file : files) {
    const std::vector<std::byte> bytes = readFile(file);
    hash = hash64(bytes.data(), bytes.size(), hash);
  }
  return hash;
}

uint64_t hashOf(const JobCamera& c) {
  const scene::Camera& camera = c.camera;
  Json all{c.name, c.width, c.height, camera.name, camera.orthographic, camera.verticalFov, camera.yHalf};
  for (int i = 0; i < 16; ++i) all.push_back(std::bit_cast<uint32_t>(camera.toWorld[i / 4][i % 4]));
  for (const float value : {camera.nearClip, camera.farClip, camera.principal.x, camera.principal.y})
    all.push_back(std::bit_cast<uint32_t>(value));
  if (const auto& lens = camera.lens) {
    all.insert(all.end(), {lens->model, lens->width, lens->height, lens->fx, lens->fy, lens->cx, lens->cy});
    for (const double k : lens->distortion) all.push_back(k);
  }
  return hashOf(all);
}

// A scene's or camera's name as part of a path: what has a meaning there is replaced.
std::string asPart(std::string name) {
  for (char& c : name)
    if (std::string_view("/\\{}").find(c) != std::string_view::npos || static_cast<unsigned char>(c) < 0x20 ||
        c == 0x7f)
      c = '_';
  if (name.empty() || name[0] == '.') name.insert(0, "_");
  return name;
}

void checkPattern(const std::string& name) {
  const std::filesystem::path path(name);
  const bool leaves = path.is_absolute() || std::ranges::find(path, "..") != path.end();
  if (leaves || name.ends_with('/') || path.filename().string().starts_with('.'))
    badUsage("name is a place below the data set's folder, not \"{}\"", name);
}

std::string sceneName(const std::string& source) {
  return asPart(source.starts_with("builtin:") ? source.substr(8) : std::filesystem::path(source).stem().string());
}

std::string number(uint64_t value, uint64_t most, uint64_t least = 0) {
  return fmt::format("{:0{}}", value, std::max(least, static_cast<uint64_t>(fmt::formatted_size("{}", most))));
}

Json describe(const PlannedScene& scene) {
  Json cameras = Json::array();
  for (const PlannedCamera& c : scene.cameras) cameras.push_back({c.name, c.hash, c.width, c.height});
  return {{"source", scene.source}, {"files", scene.files}, {"hash", scene.hash}, {"cameras", std::move(cameras)}};
}

// Whatever a damaged file holds: then scenes are loaded again.
Json readSaved(const std::filesystem::path& path) try { return parsed(readFile(path)); } catch (const std::exception&) {
  return Json::object();
}

}  // namespace

Plan::Plan(const Job& job, const std::filesystem::path& saved) : job_(job) {
  checkPattern(job.name);
  const Json& d = job.document;
  Json whole = d;
  for (const char* perFrame : {"scenes", "cameras", "repeat", "name"}) whole.erase(perFrame);
  whole["version"] = version();
  std::error_code ignored;
  if (std::filesystem::is_regular_file(job.hdri, ignored)) whole["hdri-hash"] = hashOfFiles({job.hdri});
  jobHash_ = hashOf(whole);
  loadHash_ = hashOf({d.value("cameras", Json()), d.value("variant", Json()), d.value("allow-outside", Json()),
                      d.value("id-depth", Json()), d.value("id-nodes", Json()), job.seed, job.settings.width,
                      job.settings.height, version()});
  const Json known = readSaved(saved);
  for (const std::string& source : job.scenes) {
    PlannedScene scene{.source = source};
    throwIfStopped();
    if (!findSaved(scene, known)) look(scene);
    claimMemory(scene);
    scenes_.push_back(std::move(scene));
  }
  order();
  checkNames();
}

bool Plan::findSaved(PlannedScene& scene, const Json& saved) const try {
  if (saved.value("load", uint64_t{0}) != loadHash_) return false;
  for (const Json& known : saved.at("scenes")) {
    if (known.at("source") != scene.source || known.at("cameras").empty()) continue;
    scene.files = known.at("files").get<std::vector<std::string>>();
    scene.hash = known.at("hash").get<uint64_t>();
    if (hashOfFiles(scene.files) != scene.hash) return false;
    for (const Json& c : known.at("cameras"))
      scene.cameras.push_back(
          {c.at(0).get<std::string>(), c.at(1).get<uint64_t>(), c.at(2).get<uint32_t>(), c.at(3).get<uint32_t>()});
    return true;
  }
  return false;
} catch (const std::exception&) {  // damaged, or a file that is gone: loading says what is wrong
  return false;
}

void Plan::look(PlannedScene& scene) try {
  scene.files.clear();
  scene.cameras.clear();
  scene::LoadOptions load = job_.load;
  load.textures = job_.scenes.size() == 1 || !job_.variations.is_null();
  auto loaded = std::make_unique<LoadedScene>(job_, scene::load(scene.source, load));
  for (const JobCamera& c : loaded->cameras()) scene.cameras.push_back({c.name, hashOf(c), c.width, c.height});
  for (const std::filesystem::path& file : loaded->scene().files) scene.files.push_back(file.string());
  scene.hash = hashOfFiles(scene.files);
  if (job_.scenes.size() == 1) scene_ = std::move(loaded);
} catch (const Error& error) {
  // What no scene takes is the job's fault.
  const bool someGood = std::ranges::any_of(scenes_, [](const PlannedScene& other) { return other.error.empty(); });
  if (job_.scenes.size() == 1 || (error.code() == ExitCode::Usage && !someGood)) throw;
  scene.error = error.what();
}

// Of a camera in the list, and in the JSON that the plan is saved and hashed by.
void Plan::claimMemory(const PlannedScene& scene) {
  constexpr uint64_t kJsonBytes = 384;
  uint64_t bytes = 0;
  for (const PlannedCamera& camera : scene.cameras) bytes += sizeof(camera) + kJsonBytes + 4 * camera.name.size();
  memory_.grow(bytes, "the plan of the job's frames");
}

void Plan::order() {
  const auto good = std::ranges::find_if(scenes_, [](const PlannedScene& scene) { return scene.error.empty(); });
  if (good == scenes_.end()) badInput("no scene can be loaded: {}", scenes_.front().error);
  starts_ = {0};
  for (PlannedScene& scene : scenes_) {
    scene.places = job_.repeat * (scene.error.empty() ? scene.cameras : good->cameras).size();
    starts_.push_back(starts_.back() + scene.places);
  }
}

std::optional<FramePlace> Plan::at(uint64_t index) const {
  const auto next = std::ranges::upper_bound(starts_, index);
  const auto scene = static_cast<uint32_t>(next - starts_.begin() - 1);
  if (!scenes_[scene].error.empty()) return std::nullopt;
  const uint64_t within = index - starts_[scene], cameras = scenes_[scene].cameras.size();
  return FramePlace{scene, static_cast<uint32_t>(within / cameras), static_cast<uint32_t>(within % cameras)};
}

std::string Plan::name(uint64_t index) const {
  constexpr uint64_t kDigits = 6;
  const FramePlace place = at(index).value();
  std::string name = job_.name;
  replaceAll(name, "{index}", number(index, frames() - 1, kDigits));
  replaceAll(name, "{variation}", number(place.variation, job_.repeat - 1));
  replaceAll(name, "{scene}", sceneName(scenes_[place.scene].source));
  replaceAll(name, "{camera}", asPart(camera(place).name));
  if (name.find_first_of("{}") != std::string::npos)
    badUsage("name has braces, which hold one of {{index}}, {{scene}}, {{camera}}, {{variation}}, not \"{}\"",
             job_.name);
  return name;
}

void Plan::checkNames() const {
  if (job_.name.find("{index}") != std::string::npos) return;
  constexpr uint64_t kNameBytes = 192;  // with what is filled in, and its place in the set
  const MemoryClaim memory(frames() * (kNameBytes + job_.name.size()), "the names of the job's frames");
  std::unordered_set<std::string> names;
  for (uint64_t index = 0; index < frames(); ++index)
    if (at(index) && !names.insert(name(index)).second)
      badUsage("name: two frames are called \"{}\"; {{index}} tells them apart", name(index));
}

uint64_t Plan::settings(uint64_t index) const {
  const FramePlace place = at(index).value();
  const PlannedScene& scene = scenes_[place.scene];
  return hashOf({jobHash_, scene.source, scene.hash, place.variation, camera(place).hash, index, name(index)});
}

Json Plan::describe() const {
  Json scenes = Json::array(), broken = Json::array();
  for (const PlannedScene& scene : scenes_)
    if (scene.error.empty())
      scenes.push_back(data::describe(scene));
    else
      broken.push_back(scene.source);
  return {{"job", jobHash_},    {"load", loadHash_},           {"repeat", job_.repeat},      {"name", job_.name},
          {"frames", frames()}, {"broken", std::move(broken)}, {"scenes", std::move(scenes)}};
}

uint64_t Plan::hash() const {
  return hashOf(describe());
}

void Plan::save(const std::filesystem::path& path) const {
  Json json = describe();
  json["hash"] = hashOf(json);
  const std::string text = dumped(json) + "\n";
  writeFile(path, std::as_bytes(std::span(text)));
}

}  // namespace latelight::data
