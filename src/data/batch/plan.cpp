#include "data/batch/plan.h"

#include <latelight/latelight.h>

#include <algorithm>
#include <bit>
#include <unordered_map>

#include "base/error.h"
#include "base/files.h"
#include "base/hash.h"
#include "base/text.h"
#include "data/batch/camera_checks.h"
#include "data/batch/file_claims.h"
#include "data/batch/sensor_path.h"
#include "data/json_text.h"
#include "data/scene_files.h"
#include "data/stop.h"
#include "output/files.h"
#include "render/submit/id_manifest.h"
#include "scene/load/load.h"

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

Json describe(const scene::Camera& camera) {
  Json all{camera.name, camera.orthographic, camera.verticalFov, camera.yHalf, camera.aspect.value_or(0)};
  for (int i = 0; i < 16; ++i) all.push_back(std::bit_cast<uint64_t>(camera.toWorld[i / 4][i % 4]));
  for (const float value : {camera.nearClip, camera.farClip, camera.principal.x, camera.principal.y})
    all.push_back(std::bit_cast<uint32_t>(value));
  if (const auto& lens = camera.lens) {
    all.insert(all.end(), {lens->model, lens->width, lens->height, lens->fx, lens->fy, lens->cx, lens->cy});
    for (const double k : lens->distortion) all.push_back(k);
  }
  if (camera.aperture) all.push_back(scene::apertureText(*camera.aperture));
  if (camera.focusDistance) all.push_back(*camera.focusDistance);
  return all;
}

Json describe(const std::optional<double>& seconds) {
  return seconds ? Json(std::bit_cast<uint64_t>(*seconds)) : Json();
}

// Describes another image that a frame refers to.
Json describe(const CameraTimeline& cameras, const std::optional<CameraTimeline::Neighbor>& other) {
  if (!other) return {};
  Json all{describe(other->camera), describe(other->time), Json()};
  if (!other->place) return all;
  const JobCamera& c = cameras.camera(*other->place);
  all[2] = {*other->place, c.name, c.width, c.height};
  return all;
}

Json describe(const PairTarget& target) {
  return {target.kind, target.step, target.name};
}

// `moves`: the frame depends on its neighbors, even if it is exposed for an instant.
uint64_t hashOf(const CameraTimeline& cameras, size_t i, bool moves, const Extras& extras) {
  const JobCamera& c = cameras.camera(i);
  Json all{c.name, c.width, c.height, describe(c.camera), describe(cameras.time(i))};
  const CameraExposure& exposure = c.exposure;
  if (exposure != CameraExposure{})
    all.push_back({describe(exposure.shutter), describe(exposure.readout),
                   exposure.noiseSeed ? Json(*exposure.noiseSeed) : Json()});
  if (exposure.ev) all.push_back({"EV", *exposure.ev});
  const render::Settings settings = cameras.settingsOf(i);
  if (moves || settings.shutter > 0 || settings.readout != 0)
    for (const auto& neighbor : {cameras.previous(i), cameras.next(i)}) all.push_back(describe(cameras, neighbor));
  for (const PairTarget& target : extras.pairs) all.push_back(describe(cameras, cameras.target(i, target)));
  for (const auto& scan : extras.scans) {
    const CameraPath path(cameras, i, scan->seconds);
    for (const CameraPath::Leg& leg : path.legs())
      all.push_back({describe(leg.from), describe(leg.to), describe(leg.begin), describe(leg.seconds)});
  }
  return hashOf(all);
}

// Adds the files that cameras are read from.
void addCameraFiles(const Json& spec, std::vector<std::string>& files) {
  const auto add = [&](const std::filesystem::path& file) {
    std::error_code ignored;  // errors are reported when the cameras are read
    if (std::filesystem::is_regular_file(file, ignored)) files.push_back(file.string());
  };
  if (!spec.is_structured()) return;
  for (const auto& [key, value] : spec.items()) {
    addCameraFiles(value, files);
    if (!value.is_string()) continue;
    if (key == "file") add(value.get<std::string>());
    if (key == "folder")
      for (const char* name : {"cameras.bin", "images.bin", "cameras.txt", "images.txt"})
        add(std::filesystem::path(value.get<std::string>()) / name);
  }
}

// Describes the files that the variations read by their names and contents. Names have no folders, because shards of
// one set may see the files in different folders.
Json describeVariationFiles(const Job& job) {
  Json all = Json::array();
  for (const std::filesystem::path& file : variationFiles(job.variations, job.load)) {
    std::error_code ignored;  // missing files are reported when the variations are made
    if (!std::filesystem::is_regular_file(file, ignored)) continue;
    all.push_back({file.filename().string(), hashOfFiles({file.string()})});
  }
  return all;
}

// Returns a scene's or camera's name as one part of a path: characters with a special meaning are replaced.
std::string asPart(std::string name) {
  for (char& c : name)
    if (std::string_view("/\\{}").find(c) != std::string_view::npos || static_cast<unsigned char>(c) < 0x20 ||
        c == 0x7f)
      c = '_';
  if (name.empty() || name[0] == '.') name.insert(0, "_");
  return shortFileName(std::move(name));
}

constexpr uint32_t kIndexDigits = 6;  // at least
constexpr size_t kLongestName = 200;  // bytes per part of a path: formats append to it, and 255 are allowed

void checkPattern(const std::string& name) {
  const std::filesystem::path path(name);
  const bool leaves = path.is_absolute() || std::ranges::find(path, "..") != path.end();
  if (leaves || name.ends_with('/') || path.filename().string().starts_with('.'))
    badUsage("name must be a path below the data set's folder, not \"{}\"", name);
}

std::string sceneName(const std::string& source) {
  return asPart(source.starts_with("builtin:") ? source.substr(8) : std::filesystem::path(source).stem().string());
}

std::string number(uint64_t value, uint64_t most, uint64_t least = 0) {
  return fmt::format("{:0{}}", value, std::max(least, static_cast<uint64_t>(fmt::formatted_size("{}", most))));
}

Json describe(const PlannedScene& scene) {
  Json cameras = Json::array();
  for (const PlannedCamera& c : scene.cameras) cameras.push_back({c.name, c.hash, c.width, c.height, c.moment});
  return {{"source", scene.source},        {"name", scene.name},      {"files", scene.files}, {"hash", scene.hash},
          {"cameras", std::move(cameras)}, {"entries", scene.entries}};
}

// Returns Format::sceneEntry() of each format. Only formats that need ids have such entries.
std::vector<Json> entriesOf(const Job& job, const LoadedScene& loaded) {
  std::vector<Json> entries(job.formats.size());
  if (std::ranges::none_of(job.settings.aovs, output::holdsIds)) return entries;
  const output::IdManifest ids = loaded.idsOfAll() ? *loaded.idsOfAll() : render::idManifest(loaded.scene());
  for (size_t i = 0; i < entries.size(); ++i) entries[i] = job.formats[i].format->sceneEntry(ids);
  return entries;
}

// Returns an empty object if the file is missing or damaged; scenes are then loaded again.
Json readSaved(const std::filesystem::path& path) try { return parsed(readFile(path)); } catch (const std::exception&) {
  return Json::object();
}

}  // namespace

std::vector<std::filesystem::path> filesOfJob(const Job& job) {
  std::vector<std::filesystem::path> files = variationFiles(job.variations, job.load);
  std::vector<std::string> cameraFiles;
  addCameraFiles(job.cameras, cameraFiles);
  files.insert(files.end(), cameraFiles.begin(), cameraFiles.end());
  if (!job.hdri.empty()) files.emplace_back(job.hdri);
  return files;
}

uint64_t hashOfJob(const Json& document) {
  return hashOf(document);
}

Plan::Plan(const Job& job, const std::filesystem::path& saved) : job_(job) {
  checkPattern(job.name);
  const Json& d = job.document;
  Json whole = d;
  for (const char* perFrame : {"scenes", "cameras", "repeat", "name"}) whole.erase(perFrame);
  whole["version"] = version();
  std::error_code ignored;
  if (std::filesystem::is_regular_file(job.hdri, ignored)) whole["hdri-hash"] = hashOfFiles({job.hdri});
  const Json files = describeVariationFiles(job);
  if (!files.empty()) whole["variation-files"] = files;
  jobHash_ = hashOf(whole);
  const bool moves = std::ranges::any_of(job.settings.aovs, output::dependsOnNeighbors);
  std::vector<std::string> cameraFiles;
  addCameraFiles(job.cameras, cameraFiles);
  Json pairs = Json::array();
  for (const PairTarget& target : job.extras.pairs) pairs.push_back(data::describe(target));
  for (const auto& scan : job.extras.scans) pairs.push_back(data::describe(1 / scan->sensor.rate));
  loadHash_ = hashOf({d.value("cameras", Json()), hashOfFiles(cameraFiles), d.value("variant", Json()),
                      d.value("allow-outside", Json()), d.value("id-depth", Json()), d.value("id-nodes", Json()),
                      d.value("unit", Json()), d.value("up-axis", Json()), d.value("point-radius", Json()),
                      d.value("options", Json()), d.value("formats", Json()), moves, pairs, job.seed, version(),
                      d.value("variations", Json()), d.value("hdri", Json()), files});
  // The job states unit and axes for all scenes, whichever of them can be loaded.
  for (const std::string& source : job.scenes) scene::checkFrame(source, job.load);
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
  checkFiles();
}

bool Plan::findSaved(PlannedScene& scene, const Json& saved) const try {
  if (saved.value("load", uint64_t{0}) != loadHash_) return false;
  for (const Json& known : saved.at("scenes")) {
    if (known.at("source") != scene.source || known.at("cameras").empty()) continue;
    scene.name = known.at("name").get<std::string>();
    scene.files = known.at("files").get<std::vector<std::string>>();
    scene.hash = known.at("hash").get<uint64_t>();
    if (hashOfFiles(scene.files) != scene.hash) return false;
    scene.entries = known.at("entries").get<std::vector<Json>>();
    for (const Json& c : known.at("cameras"))
      scene.cameras.push_back({c.at(0).get<std::string>(), c.at(1).get<uint64_t>(), c.at(2).get<uint32_t>(),
                               c.at(3).get<uint32_t>(), c.at(4).get<uint64_t>()});
    return true;
  }
  return false;
} catch (const std::exception&) {  // the plan is damaged or a file is missing; loading the scene reports errors
  return false;
}

// Loads the scene of a plan to determine its cameras, and checks both.
void Plan::look(PlannedScene& scene) {
  std::unique_ptr<LoadedScene> loaded = load(scene);
  if (!loaded) return;
  try {
    checkScene(job_, *loaded);
    checkCameras(job_, *loaded, [&](const std::string& camera) { return filledName(scene.source, camera, "0", "0"); });
  } catch (const Error& error) {
    throw Error(error.code(), job_.places.located(error.what()));
  }
  if (job_.scenes.size() == 1) scene_ = std::move(loaded);
}

// Returns null if the scene is broken, which the plan then states.
std::unique_ptr<LoadedScene> Plan::load(PlannedScene& scene) const try {
  scene.files.clear();
  scene.cameras.clear();
  scene.entries.clear();
  scene::LoadOptions load = job_.load;
  load.textures = job_.scenes.size() == 1 || !job_.variations.is_null() || listsFilesOnlyWithTextures(scene.source);
  auto loaded = std::make_unique<LoadedScene>(job_, scene::load(scene.source, load));
  const bool moves = std::ranges::any_of(job_.settings.aovs, output::dependsOnNeighbors);
  const CameraTimeline& cameras = loaded->cameras();
  for (size_t i = 0; i < cameras.size(); ++i) {
    const JobCamera& c = cameras.camera(i);
    scene.cameras.push_back({c.name, hashOf(cameras, i, moves, job_.extras), c.width, c.height, cameras.momentOf(i)});
  }
  scene.entries = entriesOf(job_, *loaded);
  scene.name = loaded->scene().name;
  for (const std::filesystem::path& file : loaded->scene().files) scene.files.push_back(file.string());
  scene.hash = hashOfFiles(scene.files);
  return loaded;
} catch (const Error& error) {
  // If no scene has loaded so far, a usage error is attributed to the job.
  const bool anyLoaded = std::ranges::any_of(scenes_, [](const PlannedScene& other) { return other.error.empty(); });
  if (job_.scenes.size() == 1 || (error.code() == ExitCode::Usage && !anyLoaded)) throw;
  scene.error = error.what();
  return nullptr;
}

// Claims memory for the scene's cameras and entries, both in the list and in the JSON that the plan is saved and hashed
// as.
void Plan::claimMemory(const PlannedScene& scene) {
  constexpr uint64_t kJsonBytes = 384;
  uint64_t bytes = 0;
  for (const PlannedCamera& camera : scene.cameras) bytes += sizeof(camera) + kJsonBytes + 4 * camera.name.size();
  for (const Json& entry : scene.entries) bytes += 2 * dumped(entry).size();
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

std::optional<FrameLocation> Plan::at(uint64_t index) const {
  const auto next = std::ranges::upper_bound(starts_, index);
  const auto scene = static_cast<uint32_t>(next - starts_.begin() - 1);
  if (!scenes_[scene].error.empty()) return std::nullopt;
  const uint64_t within = index - starts_[scene], cameras = scenes_[scene].cameras.size();
  return FrameLocation{scene, static_cast<uint32_t>(within / cameras), static_cast<uint32_t>(within % cameras)};
}

std::string Plan::filledName(const std::string& source, const std::string& camera, const std::string& index,
                             const std::string& variation) const {
  std::string name = job_.name;
  replaceAll(name, "{index}", index);
  replaceAll(name, "{variation}", variation);
  replaceAll(name, "{scene}", sceneName(source));
  replaceAll(name, "{camera}", asPart(camera));
  return name;
}

std::string Plan::name(uint64_t index) const {
  const FrameLocation place = at(index).value();
  std::string name = filledName(scenes_[place.scene].source, camera(place).name,
                                number(index, frames() - 1, kIndexDigits), number(place.variation, job_.repeat - 1));
  if (name.find_first_of("{}") != std::string::npos)
    badUsage("name has braces, which hold one of {{index}}, {{scene}}, {{camera}}, {{variation}}, not \"{}\"",
             job_.name);
  for (const std::filesystem::path& part : std::filesystem::path(name))
    if (part.native().size() > kLongestName)
      badUsage("name makes \"{}\", which has {} bytes in one file name: shorten the pattern to at most {}",
               part.string(), part.native().size(), kLongestName);
  return name;
}

DataFrame Plan::frame(uint64_t index) const {
  const FrameLocation place = at(index).value();
  const PlannedCamera& planned = camera(place);
  DataFrame frame{.index = index,
                  .name = name(index),
                  .scene = place.scene,
                  .variation = place.variation,
                  .camera = place.camera,
                  .state = uint64_t{place.scene} * job_.repeat + place.variation};
  frame.picture.width = planned.width;
  frame.picture.height = planned.height;
  frame.metadata.scene = scenes_[place.scene].name;
  frame.metadata.frame = static_cast<uint32_t>(index);
  frame.metadata.frameDigits = kIndexDigits;
  frame.metadata.camera.name = planned.name;
  return frame;
}

bool Plan::hasIndexedNames() const {
  return job_.name.find("{index}") != std::string::npos;
}

// Names with the index differ in it, so files of different frames do, too: one frame per scene shows the others.
void Plan::checkFiles() const {
  FileClaims claims(job_, [this](uint64_t index) { return name(index); });
  for (size_t scene = 0; scene < scenes_.size(); ++scene) {
    if (!scenes_[scene].error.empty()) continue;
    const uint64_t frames = hasIndexedNames() ? 1 : scenes_[scene].places;
    for (uint64_t i = 0; i < frames; ++i) claims.add(frame(starts_[scene] + i));
  }
}

void Plan::checkNames() const {
  const bool indexed = hasIndexedNames();
  const auto placeholders = static_cast<size_t>(std::ranges::count(job_.name, '{'));
  if (indexed && job_.name.size() + placeholders * kShortFileName <= kLongestName) return;
  constexpr uint64_t kNameBytes = 192;  // placeholder values and the overhead of a set element
  const MemoryClaim memory(frames() * (kNameBytes + job_.name.size()), "the names of the job's frames");
  std::unordered_set<std::string> names;
  for (size_t scene = 0; scene < scenes_.size(); ++scene) {
    if (!scenes_[scene].error.empty()) continue;
    // Names with the index are unique, and they have the same length for all variations.
    const uint64_t frames = indexed ? scenes_[scene].cameras.size() : scenes_[scene].places;
    for (uint64_t i = 0; i < frames; ++i) {
      std::string name = this->name(starts_[scene] + i);
      if (!indexed && !names.insert(name).second) badUsage("name: two frames are called \"{}\"; add {{index}}", name);
    }
  }
  checkStoredNames(names);
}

// Formats that change names, such as webdataset, may make equal ones of different ones.
void Plan::checkStoredNames(const std::unordered_set<std::string>& names) const {
  constexpr uint64_t kNameBytes = 192;  // for two names and the overhead of a map's element
  for (const JobFormat& use : job_.formats) {
    MemoryClaim memory;
    std::unordered_map<std::string, const std::string*> frames;  // by stored name, if it differs from the frame's
    const auto reject = [&](const std::string& stored, const std::string& a, const std::string& b) {
      badUsage("name: the format {} stores the frames \"{}\" and \"{}\" as \"{}\"; add {{index}}", use.name,
               std::min(a, b), std::max(a, b), stored);
    };
    for (const std::string& name : names) {
      std::string stored = use.format->storedName(name);
      if (stored == name) continue;
      memory.grow(kNameBytes + stored.size(), "the names of the job's frames");
      if (names.contains(stored)) reject(stored, name, stored);
      const auto [known, isNew] = frames.try_emplace(std::move(stored), &name);
      if (!isNew) reject(known->first, name, *known->second);
    }
  }
}

uint64_t Plan::settings(uint64_t index) const {
  const FrameLocation place = at(index).value();
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
  json["document"] = hashOfJob(job_.document);
  const std::string text = dumped(json) + "\n";
  writeFile(path, std::as_bytes(std::span(text)));
}

}  // namespace latelight::data
