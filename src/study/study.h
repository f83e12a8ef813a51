// Studies: `latelight study NAME` measures one subject, as a paper would. Each study is a function from options to
// tables and images in its own source file. study.cpp lists them.
#pragma once

#include <algorithm>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "output/aov.h"
#include "study/plot.h"
#include "study/table.h"

namespace latelight::study {

// The sweeps of `lights`. Empty lists select the study's own choice for the kind of device.
struct SweepOptions {
  double budget = 10;  // seconds: a step is skipped if its frames are estimated to exceed it
  std::vector<uint64_t> lights, triangles;
  std::vector<std::pair<uint32_t, uint32_t>> sizes;  // pixels
};

struct Options {
  std::string device = "auto";
  bool validation = false;       // any message of the Vulkan validation layers is an error
  uint32_t samples = 4'000'000;  // directions; a quarter as many depths; for light a thousandth per pixel
  std::vector<uint32_t> bits;    // per channel, 8 to 16, 0 for floats; empty: the study's own choice
  std::optional<uint32_t> seed;  // directions: random ones instead of a lattice
  SweepOptions sweep;
  std::vector<std::string> environments;  // files for `accuracy`, in addition to its own environments
  bool pictures = false;
};

struct NamedPicture {
  std::string name;  // base name of the file
  output::Picture picture;
};

struct Result {
  std::string device;  // the device used in addition to the host
  std::vector<Table> tables;
  std::vector<NamedPicture> pictures;
  std::vector<Plot> plots;
};

struct Study {
  const char* name;
  const char* description;
  Result (*run)(const Options& options);
  // Names of the options of `latelight study` that set the Options it uses, such as "samples". All studies use the
  // device, validation and pictures.
  std::vector<std::string_view> options;

  bool uses(std::string_view option) const { return std::ranges::find(options, option) != options.end(); }
};

std::span<const Study> studies();
const Study& findStudy(std::string_view name);  // throws Error(Usage) that lists them

Result studyNormals(const Options& options);
Result studyDepth(const Options& options);
Result studyPosition(const Options& options);
Result studyLights(const Options& options);
Result studyAccuracy(const Options& options);

}  // namespace latelight::study
