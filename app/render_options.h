// The options of `latelight render`, as given and as parsed.
#pragma once

#include <CLI/CLI.hpp>
#include <cstdint>
#include <functional>
#include <glm/vec2.hpp>
#include <initializer_list>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "render/options/options.h"
#include "render/settings/settings.h"
#include "scene/scene.h"

namespace latelight::app {

struct RenderOptions {
#define OPTION_GROUP(title)
#define OPTION_FLAG(member, ...) bool member = false;
#define OPTION_NUMBER(Type, member, name, defaultValue, ...) Type member = defaultValue;
#define OPTION_OPTIONAL(Type, member, ...) std::optional<Type> member;
#define OPTION_TEXT(Type, member, name, defaultValue, ...) Type member = defaultValue;
#define OPTION_LIST(member, ...) std::vector<std::string> member;
#include "app/render_command.def"

  render::Settings settings;
  scene::IdGrouping idGrouping;                           // parsed from `idDepth` and `idNodes`
  std::map<std::string, std::string, std::less<>> given;  // the options that were given, by key ("exposure"), as text
  std::vector<glm::uvec2> pixels;                         // parsed from `picks`

  bool isExplicit(std::string_view key) const {
    return given.contains(key);
  }
};

// Returns the options that only the command line has; render::options() returns the others.
std::span<const render::Option> commandOptions();

// Returns the option --key of a command. CLI::App::get_option() allocates in a function that must not throw, so it
// would end the process when memory runs out.
CLI::Option& optionOf(CLI::App& command, std::string_view key);

// Options of `latelight render` that a command does not support, by key: those of the group "Output", which define the
// files and texts that `render` writes, except `supported`, and `others`.
class UnsupportedOptions {
 public:
  UnsupportedOptions(std::initializer_list<std::string_view> supported, std::initializer_list<std::string_view> others);

  // Omits them from the help of a command with the options of `render`.
  void hide(CLI::App& command) const;
  // Returns the name of one that was passed, such as "--aov"; nothing if there is none.
  std::optional<std::string> findIn(const RenderOptions& options) const;

 private:
  std::vector<std::string> keys_;
};

// Adds one option to a command. `take` is called with the text of each value, or "" for a flag.
void addOption(CLI::App& command, const render::Option& option, const std::function<void(const std::string&)>& take);

// Adds one of commandOptions(), whose value `options` stores.
void addCommandOption(CLI::App& command, RenderOptions& options, const render::Option& option);
void addRenderOptions(CLI::App& command, RenderOptions& options);
// Applies the value of --memory to the process; empty means that the option was not passed. Throws Error(Usage) if the
// text is not a size.
void limitMemory(const std::string& text);
// Checks limits and contradictions that parsing does not detect. Throws Error(Usage).
void checkOptions(RenderOptions& options);
// Returns how to load the scene, with all its textures, from options that checkOptions() has checked.
scene::LoadOptions loadOptions(const RenderOptions& options);

}  // namespace latelight::app
