#include "data/batch/job.h"

#include <glob.h>

#include <algorithm>

#include "base/error.h"
#include "base/files.h"
#include "base/lowercase.h"
#include "data/batch/schema.h"
#include "data/cameras/json_file.h"
#include "data/extras.h"
#include "data/variations/variations.h"
#include "render/options/options.h"
#include "render/outputs/outputs.h"
#include "render/sensor/sensor.h"
#include "scene/ids.h"

namespace latelight::data {

using Json = nlohmann::ordered_json;

namespace {

void checkThere(const std::string& file, const std::string& place) {
  if (!isThere(file)) badInput("{}: there is no file \"{}\"", place, file);
}

// Expands a glob pattern to files sorted by name. Returns an existing path and a built-in scene as it is.
std::vector<std::string> filesLike(const std::string& pattern, const std::string& place) {
  if (pattern.starts_with("builtin:") || isThere(pattern)) return {pattern};
  if (pattern.find_first_of("*?[") == std::string::npos) checkThere(pattern, place);
  glob_t found{};
  std::vector<std::string> files;
  if (glob(pattern.c_str(), 0, nullptr, &found) == 0) files.assign(found.gl_pathv, found.gl_pathv + found.gl_pathc);
  globfree(&found);
  if (files.empty()) badInput("{}: no file matches \"{}\"", place, pattern);
  std::ranges::sort(files);
  return files;
}

// Returns a key's value, or the elements if it is a list, each with its position for messages.
std::vector<std::pair<std::string, Json>> each(const JobDocument& document, const std::string& key) {
  std::vector<std::pair<std::string, Json>> all;
  const Json& value = document.json[key];
  if (!value.is_array()) return {{document.place(key), value}};
  for (size_t i = 0; i < value.size(); ++i) all.emplace_back(document.place(fmt::format("{}[{}]", key, i)), value[i]);
  return all;
}

// Returns a value as text, in the form of the command line.
std::string textOf(const Json& value) {
  return value.is_string() ? value.get<std::string>() : value.dump();
}

void readOptions(Job& job, const JobDocument& document) {
  for (const render::Option& option : render::options()) {
    const std::string key(render::keyOf(option));
    if (!document.json.contains("options") || !document.json["options"].contains(key)) continue;
    const Json& value = document.json["options"][key];
    if (value == false) continue;  // an unset flag
    try {
      job.given[key] = render::read(job.settings, option, textOf(value));
    } catch (const Error& error) {
      badUsage("{}: {}", document.place("options." + key), error.what());
    }
  }
  if (render::playsWithoutTime(job.settings))
    badUsage("{}: --animation and --loop require --time",
             document.place(job.settings.loop ? "options.loop" : "options.animation"));
}

// The renderer makes the same checks, but only when it renders a frame.
void checkOptions(const Job& job, const JobDocument& document) try {
  render::checkSettings(job.settings);
  render::checkLayoutOptions(job.settings, job.given);
  render::checkSensor(job.settings);
} catch (const Error& error) {
  throw Error(error.code(), document.located(error.what()));
}

void readScenes(Job& job, const JobDocument& document) {
  for (const auto& [place, scene] : each(document, "scenes"))
    for (std::string& file : filesLike(scene.get<std::string>(), place)) {
      if (std::ranges::find(job.scenes, file) != job.scenes.end())
        badUsage("{}: the scene \"{}\" is listed twice", place, file);
      job.scenes.push_back(std::move(file));
    }
  const Json& json = document.json;
  job.load.variant = json.value("variant", "");
  job.load.allowOutside = json.value("allow-outside", std::vector<std::string>());
  job.load.ids.nodes = json.value("id-nodes", std::vector<std::string>());
  if (json.contains("id-depth")) job.load.ids.depth = json["id-depth"].get<uint32_t>();
  job.load.unit = json.value("unit", "");
  job.load.upAxis = json.value("up-axis", "");
  if (json.contains("point-radius")) job.load.pointRadius = json["point-radius"].get<float>();
  job.load.tangents = addsNormalMaps(json.value("variations", Json()));
  scene::checkGrouping(job.load.ids);
  job.hdri = json.value("hdri", "");
  if (!job.hdri.empty() && job.hdri != "studio" && job.hdri != "none") checkThere(job.hdri, document.place("hdri"));
}

// Replaces the name of a .json file by its contents.
void readFileOf(JobFormat& use, const std::string& option) {
  const auto value = use.options.find(option);
  if (value == use.options.end() || !value->is_string()) return;
  const auto file = value->get<std::string>();
  if (lowercaseExtension(file) != ".json") return;
  JsonDocument contents = readJson(file);
  *value = std::move(contents.json);
  use.memory = std::move(contents.memory);
}

// Frames have one list of keypoints.
void checkKeypoints(const std::vector<JobFormat>& formats, const std::string& place) {
  const JobFormat& last = formats.back();
  const std::vector<ObjectKeypoint> keypoints = last.format->needsExtras().keypoints;
  for (const JobFormat& use : formats) {
    const std::vector<ObjectKeypoint> others = use.format->needsExtras().keypoints;
    if (!keypoints.empty() && !others.empty() && keypoints != others)
      badUsage(
          "{}: the keypoints of the format {} differ from those of the format {}: give all formats of a job the same "
          "keypoints, or render two data sets",
          place, last.name, use.name);
  }
}

void readFormats(Job& job, const JobDocument& document) {
  if (!document.json.contains("formats")) {
    job.formats.push_back(makeFormat("files", "formats"));
    return;
  }
  Json& stored = job.document["formats"] = Json::array();
  for (const auto& [place, spec] : each(document, "formats")) {
    const JobFormat& use = job.formats.emplace_back(makeFormat(spec, place));
    checkKeypoints(job.formats, place);
    stored.push_back(spec);
    if (spec.is_object()) stored.back().update(use.options);
  }
}

// Requests the outputs that the formats require.
void askForOutputs(Job& job) {
  job.settings.display = false;
  for (const JobFormat& use : job.formats) {
    job.settings.display |= use.format->needsDisplay();
    for (const output::Aov aov : use.format->needs())
      if (!output::contains(job.settings.aovs, aov)) job.settings.aovs.push_back(aov);
  }
  std::ranges::sort(job.settings.aovs);
}

}  // namespace

JobFormat makeFormat(const Json& spec, const std::string& place) {
  JobFormat use;
  if (spec.is_object()) {
    use.options = spec;
    use.options.erase("format");
    if (!spec.contains("format") || !spec["format"].is_string())
      badUsage("{}: the key \"format\" must name the format", place);
  }
  use.name = spec.is_object() ? spec["format"].get<std::string>() : spec.get<std::string>();
  std::string names;
  for (const FormatInfo& info : formats()) {
    names += (names.empty() ? "" : ", ") + std::string(info.name);
    if (info.name != use.name) continue;
    try {
      use.format = info.make(use.options);
    } catch (const Error& error) {
      badUsage("{}: {}", place, error.what());
    }
    readFileOf(use, std::string(info.valueOrFile));
    return use;
  }
  badUsage("{}: there is no format \"{}\"; there are: {}", place, use.name, names);
}

uint64_t bytesOfPixel(const render::Settings& settings) {
  return std::max<uint64_t>(render::bytesPerPixel(settings), 1);
}

Job makeJob(const JobDocument& document) {
  checkJob(document);
  Job job;
  job.memory = document.memory;
  job.places.name = document.name;
  for (const auto& [path, line] : document.lines)
    if (path.starts_with("cameras") || path.starts_with("variations") || path.starts_with("options"))
      job.places.lines[path] = line;
  job.document = document.json;
  job.document.erase("output");
  job.folder = document.json["output"].get<std::string>();
  readScenes(job, document);
  job.cameras = document.json.value("cameras", Json());
  job.variations = document.json.value("variations", Json());
  job.repeat = document.json.value("repeat", 1u);
  job.seed = document.json.value("seed", uint64_t{0});
  job.name = document.json.value("name", job.name);
  readFormats(job, document);
  for (const JobFormat& use : job.formats) job.extras = both(job.extras, use.format->needsExtras());
  readOptions(job, document);
  askForOutputs(job);
  checkOptions(job, document);
  return job;
}

}  // namespace latelight::data
