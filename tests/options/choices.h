// The values that each option of `latelight render` accepts, for random selection.
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

namespace latelight::app {

// How often a value changes: by every draw, or by every group of draws, since pipelines, a scene or an environment are
// made anew for it.
enum class Rate { Draw, Group };

struct Choice {
  double share = 0;                // of the draws, how many give the option
  std::vector<std::string> right;  // values; of a flag, one that is empty
  std::vector<std::string> wrong;  // refused by themselves, whatever else is given
  Rate rate = Rate::Draw;
};

// By option, as "--size"; "SCENE" is the argument. Flags, numbers and names come from the table of options, so what is
// added there is drawn too; texts are given here. `models` and `panorama`: files. `folder`: for output.
std::map<std::string, Choice> choicesIn(const std::filesystem::path& folder, const std::vector<std::string>& models,
                                        const std::string& panorama);

}  // namespace latelight::app
