// The job of `latelight batch`: the data set's frames (scenes x variations x cameras), formats and settings.
#pragma once

#include <filesystem>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "data/batch/job_file.h"
#include "data/format.h"
#include "render/settings/settings.h"
#include "scene/scene.h"

namespace latelight::data {

// One of the job's formats, with the options from the job.
struct JobFormat {
  std::string name;
  // Without files: the contents of a .json file replace its name, so that the format can be created again, in any
  // working directory, and is the same after the file has changed.
  nlohmann::ordered_json options = nlohmann::ordered_json::object();
  std::unique_ptr<Format> format;
  std::shared_ptr<MemoryClaim> memory;  // for the contents of a file
};

struct Job {
  // The name of the job's file and the lines of its cameras, variations and options, for messages; without the
  // contents.
  JobDocument places;
  // The job's document without its output folder, which is not part of a data set's identity, and with the contents of
  // the files that its formats name.
  nlohmann::ordered_json document;
  std::filesystem::path folder;
  std::vector<std::string> scenes;  // files and built-in scenes, with patterns expanded
  nlohmann::ordered_json cameras, variations;
  uint32_t repeat = 1;
  uint64_t seed = 0;
  std::string name = "{index}";
  std::vector<JobFormat> formats;
  Extras extras;  // the requirements of all formats

  render::Settings settings;
  std::map<std::string, std::string, std::less<>> given;  // values of the options that the job sets, by key
  scene::LoadOptions load;
  std::string hdri;                     // the environment; empty: chosen by the scene
  std::shared_ptr<MemoryClaim> memory;  // for the document
};

// Creates a data set format from its name, or from an object of its name and options. Throws Error(Usage) whose message
// begins with `place`.
JobFormat makeFormat(const nlohmann::ordered_json& spec, const std::string& place);

// Returns the bytes per pixel of all outputs, at least 1.
uint64_t bytesOfPixel(const render::Settings& settings);

// Validates a document and creates its job. Throws Error(BadInput) for missing files and Error(Usage) for all other
// errors. The message names the key and its line.
Job makeJob(const JobDocument& document);

}  // namespace latelight::data
