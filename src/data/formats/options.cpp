#include "data/formats/options.h"

#include <fmt/ranges.h>

#include <algorithm>
#include <filesystem>

#include "base/error.h"
#include "base/lowercase.h"

namespace latelight::data {

using Json = nlohmann::ordered_json;

namespace {

// Returns true if a relative name may lead out of the folder that it is relative to.
bool leavesFolder(const std::filesystem::path& name) {
  return name.is_absolute() || std::ranges::find(name, "..") != name.end();
}

}  // namespace

const Json* FormatOptions::find(std::string_view key) {
  if (std::ranges::find(known_, key) == known_.end()) known_.emplace_back(key);
  const auto found = options_.find(std::string(key));
  return found == options_.end() ? nullptr : &*found;
}

void FormatOptions::wrong(std::string_view key, std::string_view takes) const {
  badUsage("{} of the format {} takes {}", key, format_, takes);
}

bool FormatOptions::flag(std::string_view key, bool preset) {
  const Json* value = find(key);
  if (!value) return preset;
  if (!value->is_boolean()) wrong(key, "true or false");
  return value->get<bool>();
}

double FormatOptions::number(std::string_view key, double preset, double minimum, double maximum) {
  const Json* value = find(key);
  if (!value) return preset;
  if (!value->is_number() || !(value->get<double>() >= minimum && value->get<double>() <= maximum))
    wrong(key, fmt::format("a number from {} to {}", minimum, maximum));
  return value->get<double>();
}

std::string FormatOptions::text(std::string_view key, std::string_view preset) {
  const Json* value = find(key);
  if (!value) return std::string(preset);
  if (!value->is_string() || value->get_ref<const std::string&>().empty()) wrong(key, "a text");
  return value->get<std::string>();
}

std::string FormatOptions::choice(std::string_view key, std::initializer_list<std::string_view> names) {
  const std::string name = text(key, *names.begin());
  if (std::ranges::find(names, name) == names.end())
    wrong(key, fmt::format("one of {}", fmt::join(names.begin(), names.end(), ", ")));
  return name;
}

std::vector<output::Aov> FormatOptions::outputs(std::string_view key, const std::vector<output::Aov>& preset) {
  const Json* value = find(key);
  if (!value) return preset;
  const auto isText = [](const Json& name) { return name.is_string(); };
  if (!value->is_array() || value->empty() || !std::ranges::all_of(*value, isText))
    wrong(key, "a list of names (latelight list aovs)");
  return output::parseAovs(fmt::format("{}", fmt::join(value->get<std::vector<std::string>>(), ",")));
}

std::string FormatOptions::file(std::string_view key, std::string_view preset, std::string_view ending) {
  const std::string name = text(key, preset);
  if (leavesFolder(name) || !lowercase(name).ends_with(ending))
    wrong(key, fmt::format("a file below the data set's folder that ends in {}", ending));
  return name;
}

std::string FormatOptions::frameFile(std::string_view key, std::string_view preset, std::string_view ending) {
  const std::string name = file(key, preset, ending);
  if (name.find("{name}") == std::string::npos)
    wrong(key, "a file with {name} in it, or each frame would replace the one before");
  return name;
}

std::string FormatOptions::setFile(std::string_view key, std::string_view preset, std::string_view ending) {
  return file(key, preset, ending);
}

std::string FormatOptions::setFolder(std::string_view key, std::string_view preset) {
  const std::string name = text(key, preset);
  if (leavesFolder(name)) wrong(key, fmt::format("a folder below the data set's folder, not \"{}\"", name));
  return name;
}

void FormatOptions::finish() const {
  for (const auto& [key, value] : options_.items())
    if (std::ranges::find(known_, key) == known_.end())
      badUsage("the format {} has no option \"{}\"; it has {}", format_, key, fmt::join(known_, ", "));
}

}  // namespace latelight::data
