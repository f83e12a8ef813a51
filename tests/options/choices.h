// The values that each option of `latelight render` accepts, for random selection.
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

namespace latelight::app {

// How often a value changes: with every draw, or with every group of draws, because pipelines, a scene or an
// environment are recreated for it.
enum class Rate { Draw, Group };

struct Choice {
  double share = 0;                // share of the draws that give the option
  std::vector<std::string> right;  // valid values; an empty one for a flag
  std::vector<std::string> wrong;  // values that are rejected whatever other options are given
  Rate rate = Rate::Draw;
};

// By option, such as "--size"; "SCENE" is the argument. Flags, numbers and names come from the table of options, so new
// ones are drawn without a change here; values of texts are listed in choices.cpp. `models` and `panorama`: files.
// `folder`: for output.
std::map<std::string, Choice> choicesIn(const std::filesystem::path& folder, const std::vector<std::string>& models,
                                        const std::string& panorama);

}  // namespace latelight::app
