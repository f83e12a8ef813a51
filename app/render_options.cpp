#include "app/render_options.h"

#include <latelight/latelight.h>

#include <algorithm>

#include "app/render_pick.h"
#include "base/error.h"
#include "base/memory.h"
#include "base/text.h"
#include "render/options/option_table.h"
#include "scene/ids.h"

namespace latelight::app {

namespace {

using render::Option;
using render::OptionKind;

void addList(render::OptionTable<RenderOptions>& table, std::vector<std::string> RenderOptions::*member, Option option,
             const char* type) {
  option.kind = OptionKind::List;
  option.unit = type;
  table.add(option, [member](RenderOptions& o, const Option&, std::string_view text) {
    (o.*member).emplace_back(text);
    return std::string(text);
  });
}

const render::OptionTable<RenderOptions>& commandTable() {
  using render::anything, render::atLeast, render::between;
  static const render::OptionTable<RenderOptions> made = [] {
    using O = RenderOptions;
    render::OptionTable<O> t;
#define ROW(M, N, H)                   \
  Option {                             \
    .name = N, .member = #M, .help = H \
  }
#define OPTION_GROUP(title) t.group(title);
#define OPTION_FLAG(member, name, effect, help) t.flag(&O::member, ROW(member, name, help));
#define OPTION_NUMBER(Type, member, name, defaultValue, range, unit, effect, help) \
  t.number<Type>(&O::member, ROW(member, name, help), defaultValue, range, unit);
#define OPTION_OPTIONAL(Type, member, name, range, unit, without, effect, help) \
  t.optional<Type>(&O::member, ROW(member, name, help), range, unit, without);
#define OPTION_TEXT(Type, member, name, defaultValue, topic, effect, help) \
  t.text(&O::member, ROW(member, name, help), defaultValue, topic);
#define OPTION_LIST(member, name, type, help) addList(t, &O::member, ROW(member, name, help), type);
#include "app/render_command.def"
#include "render/options/options.h"
#undef ROW
    return t;
  }();
  return made;
}

// Returns the placeholder for the value in the help.
std::string valueName(const Option& option) {
  switch (option.kind) {
    case OptionKind::Flag:
      return "";
    case OptionKind::Integer:
      return "INTEGER";
    case OptionKind::Number:
      return "NUMBER";
    case OptionKind::Choice:
      return "NAME";
    case OptionKind::Text:
      return "TEXT";
    case OptionKind::List:
      return option.unit;
  }
  return "";
}

// Returns the accepted names, or if there are many, the command that lists them.
std::string namesText(const Option& option) {
  constexpr size_t kFew = 60;  // letters
  std::vector<std::string> words;
  for (const render::NamedOption& named : option.names) words.emplace_back(named.name);
  const std::string names = joinedByOr(words);
  const bool all = option.kind == OptionKind::Choice && names.size() <= kFew;
  const std::string where = *option.topic ? fmt::format("latelight list {}", option.topic) : "";
  if (all && !names.empty()) return ": " + names;
  return where.empty() ? "" : " (" + where + ")";
}

std::string helpText(const Option& option) {
  std::string text = option.help + namesText(option);
  if (option.kind == OptionKind::Integer || option.kind == OptionKind::Number)
    if (const std::string range = render::rangeText(option); !range.empty()) text += " (" + range + ")";
  return text;
}

}  // namespace

void addOption(CLI::App& command, const Option& option, const std::function<void(const std::string&)>& take) {
  CLI::Option* added = nullptr;
  if (option.kind == OptionKind::Flag) {
    added = command.add_flag_callback(
        option.name, [take] { take(""); }, helpText(option));
  } else if (option.kind == OptionKind::List) {
    const auto takeAll = [take](const std::vector<std::string>& texts) {
      for (const std::string& text : texts) take(text);
    };
    added = command.add_option_function<std::vector<std::string>>(option.name, takeAll, helpText(option));
    added->expected(1)->take_all();
  } else {
    added = command.add_option_function<std::string>(option.name, take, helpText(option));
  }
  if (option.kind != OptionKind::Flag) added->type_name(valueName(option));
  if (!option.defaultValue.empty()) added->default_str(option.defaultValue);
  if (option.name[0] == '-') added->group(option.group);
}

std::span<const Option> commandOptions() {
  return commandTable().options();
}

CLI::Option& optionOf(CLI::App& command, std::string_view key) {
  for (CLI::Option* option : command.get_options())
    if (std::ranges::find(option->get_lnames(), key) != option->get_lnames().end()) return *option;
  fail(ExitCode::Internal, "There is no option --{}.", key);
}

UnsupportedOptions::UnsupportedOptions(std::initializer_list<std::string_view> supported,
                                       std::initializer_list<std::string_view> others)
    : keys_(others.begin(), others.end()) {
  for (const Option& option : commandOptions()) {
    const std::string_view key = render::keyOf(option);
    if (option.group == "Output" && std::ranges::find(supported, key) == supported.end()) keys_.emplace_back(key);
  }
}

void UnsupportedOptions::hide(CLI::App& command) const {
  for (const std::string& key : keys_) optionOf(command, key).group("");
}

std::optional<std::string> UnsupportedOptions::findIn(const RenderOptions& options) const {
  for (const std::string& key : keys_)
    if (options.isExplicit(key)) return "--" + key;
  return std::nullopt;
}

namespace {

// Stores the text as it appears in metadata.
void give(RenderOptions& o, const Option& option, std::string text) {
  o.given.insert_or_assign(std::string(render::keyOf(option)), std::move(text));
}

}  // namespace

void addCommandOption(CLI::App& command, RenderOptions& o, const Option& option) {
  addOption(command, option,
            [&o, &option](const std::string& text) { give(o, option, commandTable().read(o, option, text)); });
}

void addRenderOptions(CLI::App& command, RenderOptions& o) {
  for (const Option& option : commandOptions()) addCommandOption(command, o, option);
  for (const Option& option : render::options())
    addOption(command, option,
              [&o, &option](const std::string& text) { give(o, option, render::read(o.settings, option, text)); });
}

void limitMemory(const std::string& text) {
  if (text.empty()) return;
  const uint64_t limit = parseMemory(text);
  if (limit == 0) badUsage("--memory takes a size, as in 512M or 4G, not \"{}\"", text);
  setMemoryLimit(limit);
}

void checkOptions(RenderOptions& o) {
  const render::Settings& s = o.settings;
  limitMemory(o.memory);
  o.idGrouping.depth = o.idDepth;
  if (!o.idNodes.empty()) {
    const std::vector<std::string_view> names = splitAtCommas(o.idNodes);
    o.idGrouping.nodes.assign(names.begin(), names.end());
  }
  scene::checkGrouping(o.idGrouping);
  render::checkSettings(s);
  o.pixels = parsePixels(o.picks);
  render::checkPixels(s, o.pixels);
  render::checkLayoutOptions(s, o.given);
}

scene::LoadOptions loadOptions(const RenderOptions& o) {
  return {.variant = o.variant,
          .allowOutside = o.allowOutside,
          .ids = o.idGrouping,
          .unit = o.unit,
          .upAxis = o.upAxis,
          .pointRadius = o.pointRadius};
}

}  // namespace latelight::app
