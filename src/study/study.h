// Studies: `latelight study NAME` measures one subject, as a paper would. Each is a function from options to tables and
// pictures, one source file, listed in study.cpp.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "output/aov.h"
#include "study/table.h"

namespace latelight::study {

struct Options {
  std::string device = "auto";   // a selector of vk/device.h
  bool validation = false;       // any message of the Vulkan validation layers is an error
  uint32_t samples = 4'000'000;  // directions, or a quarter as many depths
  std::vector<uint32_t> bits;    // a channel, 8 to 16, 0 for floats; empty: the study's own choice
  std::optional<uint32_t> seed;  // directions: random ones instead of a lattice
  bool pictures = false;
};

struct NamedPicture {
  std::string name;  // of the file, without ending
  output::Picture picture;
};

struct Result {
  std::string device;  // what ran it, beside the host
  std::vector<Table> tables;
  std::vector<NamedPicture> pictures;
};

struct Study {
  const char* name;
  const char* description;
  Result (*run)(const Options& options);
};

std::span<const Study> studies();
const Study& findStudy(std::string_view name);  // throws Error(Usage) that lists them

Result studyNormals(const Options& options);
Result studyDepth(const Options& options);
Result studyPosition(const Options& options);

}  // namespace latelight::study
