// The options of `latelight render`: as given, and parsed.
#pragma once

#include <CLI/CLI.hpp>
#include <cstdint>
#include <functional>
#include <glm/vec2.hpp>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "render/settings/options.h"
#include "render/settings/settings.h"
#include "scene/scene.h"

namespace latelight::app {

struct RenderOptions {
#define OPTION_GROUP(title)
#define OPTION_FLAG(member, ...) bool member = false;
#define OPTION_NUMBER(Type, member, name, normal, ...) Type member = normal;
#define OPTION_OPTIONAL(Type, member, ...) std::optional<Type> member;
#define OPTION_TEXT(Type, member, name, normal, ...) Type member = normal;
#define OPTION_LIST(member, ...) std::vector<std::string> member;
#include "app/render_command.def"

  render::Settings settings;
  scene::IdGrouping idGrouping;                           // of `idDepth` and `idNodes`
  std::map<std::string, std::string, std::less<>> given;  // the options that were given, by key ("exposure"), as text
  std::vector<glm::uvec2> pixels;                         // of `picks`

  bool isGiven(std::string_view key) const {
    return given.contains(key);
  }
};

// Those of the command line only; render::options() has the others.
std::span<const render::Option> commandOptions();

// Adds one option to a command; `take` is called with the text of each value that is given, "" for a flag.
void addOption(CLI::App& command, const render::Option& option, const std::function<void(const std::string&)>& take);

void addRenderOptions(CLI::App& command, RenderOptions& options);
// The value of --memory, which is followed from then on; empty: it was not given. Throws Error(Usage) where it is no
// size.
void limitMemory(const std::string& text);
// Checks beyond parsing: limits and contradictions. Throws Error(Usage).
void checkOptions(RenderOptions& options);

}  // namespace latelight::app
