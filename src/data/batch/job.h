// What `latelight batch` is asked for: scenes x variations x cameras, and the formats of the data set.
#pragma once

#include <filesystem>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "data/batch/job_file.h"
#include "data/format.h"
#include "render/settings.h"
#include "scene/scene.h"

namespace latelight::data {

// One of the job's formats, as the job describes it.
struct JobFormat {
  std::string name;
  nlohmann::ordered_json options = nlohmann::ordered_json::object();
  std::unique_ptr<Format> format;
};

struct Job {
  // The document without the folder, which is no part of what a set is.
  nlohmann::ordered_json document;
  std::filesystem::path folder;
  std::vector<std::string> scenes;  // files and built-in ones: patterns are filled in
  nlohmann::ordered_json cameras, variations;
  uint32_t repeat = 1;
  uint64_t seed = 0;
  std::string name = "{index}";
  std::vector<JobFormat> formats;

  render::Settings settings;
  std::map<std::string, std::string, std::less<>> given;  // the options that it has, by key, as text
  scene::LoadOptions load;
  std::string hdri;  // an environment; empty: by the scene
  std::shared_ptr<MemoryClaim> memory;  // of the document
};

// The format of a data set by its name and options; throws Error(Usage) that begins with `place`.
JobFormat makeFormat(const nlohmann::ordered_json& spec, const std::string& place);

// What the outputs of a pixel take in memory, and 1 where there is none.
uint64_t bytesOfPixel(const render::Settings& settings);

// Throws Error, Usage, or BadInput for a file that is missing, with a sentence that names the key, and its line.
Job makeJob(const JobDocument& document);

}  // namespace latelight::data
