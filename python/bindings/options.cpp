#include "options.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <functional>
#include <limits>
#include <type_traits>

#include "cameras.h"
#include "interpreter.h"
#include "values.h"
#include "worlds.h"

namespace latelight::python {

namespace {

// --- values ---------------------------------------------------------------------------------------------------------

template <typename T>
T numberAs(nb::handle value, std::string_view name) {
  if constexpr (std::is_integral_v<T>)
    return static_cast<T>(integerOf(value, name, 0, std::numeric_limits<T>::max()));
  else
    return std::is_same_v<T, float> ? static_cast<T>(floatOf(value, name)) : static_cast<T>(numberOf(value, name));
}

Sun sunOf(nb::handle value, std::string_view name) {
  const std::vector<float> numbers = floatsOf(value, name, {-1}).values;
  if (numbers.size() < 2 || numbers.size() > 3)
    badValue("{} takes azimuth and elevation, and perhaps lux, not {} numbers", name, numbers.size());
  Sun sun{numbers[0], numbers[1]};
  if (numbers.size() == 3) sun.illuminance = numbers[2];
  return sun;
}

// Returns the exposure as the command line reads it.
Exposure exposureOf(nb::handle value, std::string_view name) {
  if (!PyUnicode_Check(value.ptr())) return static_cast<float>(floatOf(value, name));
  return Exposure::fromText(textOf(value, name));
}

// --- the table ------------------------------------------------------------------------------------------------------

struct Keyword {
  std::string name;
  const char* option;  // "--exposure"
  std::string type;    // as in the stub; empty: text, with the accepted names
  std::function<void(Options&, nb::handle, std::string_view)> set;
};

template <typename T>
std::string numberType() {
  return std::is_integral_v<T> ? "int" : "float";
}

std::vector<Keyword> makeKeywords() {
  std::vector<Keyword> all;
  const auto add = [&](const char* member, const char* option, std::string type, auto set) {
    all.push_back({snakeCase(member), option, std::move(type), set});
  };
#define SETTER [](Options & o, nb::handle value, std::string_view keyword)
#define OPTION_FLAG(member, name, ...) \
  add(                                 \
      #member, name, "bool", SETTER { o.member = boolOf(value, keyword); });
#define OPTION_NUMBER(T, member, name, ...) \
  add(                                      \
      #member, name, numberType<T>(), SETTER { o.member = numberAs<T>(value, keyword); });
#define OPTION_ANGLE(member, name, ...) \
  add(                                  \
      #member, name, "float", SETTER { o.member = numberOf(value, keyword); });
#define OPTION_OPTIONAL(T, member, name, ...)              \
  add(                                                     \
      #member, name, numberType<T>() + " | None", SETTER { \
        if (value.is_none())                               \
          o.member.reset();                                \
        else                                               \
          o.member = numberAs<T>(value, keyword);          \
      });
#define OPTION_CHOICE(Enum, member, name, ...) \
  add(                                         \
      #member, name, "", SETTER { o.member = textOf(value, keyword); });
#define OPTION_ENTRY(Type, member, name, ...) \
  add(                                        \
      #member, name, "", SETTER { o.member = textOf(value, keyword); });
#define OPTION_TEXT(Type, member, name, ...) \
  add(                                       \
      #member, name, "", SETTER { o.member = textOf(value, keyword); });
#define OPTION_SUN(member, name, ...)                                   \
  add(                                                                  \
      #member, name, "collections.abc.Sequence[float] | None", SETTER { \
        if (!value.is_none()) o.member = sunOf(value, keyword);         \
      });
#define OPTION_EXPOSURE(member, name, ...) \
  add(                                     \
      #member, name, "float | str", SETTER { o.member = exposureOf(value, keyword); });
#include <latelight/options.def>
#undef SETTER
  return all;
}

const std::vector<Keyword>& keywords() {
  static const std::vector<Keyword> all = makeKeywords();
  return all;
}

// Keywords outside the table, for options that the command line has in another form.
constexpr const char* kExtraOptions =
    ", previous_cameras: collections.abc.Sequence[Camera] | None = None"
    ", next_cameras: collections.abc.Sequence[Camera] | None = None, continues: bool = False"
    ", formats: collections.abc.Mapping[str, str] | None = None, channels_first: bool = False";

std::map<std::string, std::string> formatsOf(nb::handle value) {
  std::map<std::string, std::string> formats;
  if (value.is_none()) return formats;
  if (!nb::hasattr(value, "items")) badType("formats must map outputs to formats, not {}", typeName(value));
  const RunningPython section;
  for (const nb::handle item : value.attr("items")()) {
    const nb::tuple pair = nb::cast<nb::tuple>(item);
    formats[textOf(pair[0], "an output of formats")] = textOf(pair[1], "a format of formats");
  }
  return formats;
}

bool setExtraOption(Options& options, std::string_view name, nb::handle value) {
  if (name == "previous_cameras")
    options.previousCameras = value.is_none() ? std::vector<Camera>{} : camerasOf(value, name);
  else if (name == "next_cameras")
    options.nextCameras = value.is_none() ? std::vector<Camera>{} : camerasOf(value, name);
  else if (name == "continues")
    options.continues = boolOf(value, name);
  else if (name == "formats")
    options.formats = formatsOf(value);
  else if (name == "channels_first")
    options.channelsFirst = boolOf(value, name);
  else
    return false;
  return true;
}

// The arguments of methods of the renderer, except those of worlds, that are no options.
constexpr std::array<std::string_view, 16> kArguments{
    "camera",  "cameras", "count",   "directions", "first",  "keypoints",   "max_distance", "on_device",
    "origins", "out",     "outputs", "pixels",     "second", "second_time", "size",         "stream"};

// hasSize: the method has the argument size.
[[noreturn]] void rejectKeyword(const std::string& name, bool hasSize) {
  if (std::ranges::find(kArguments, name) != kArguments.end() || isWorldArgument(name))
    badType("the argument \"{}\" does not apply to this call: omit it", name);
  const RunningPython section;
  nb::list known;
  for (const Keyword& keyword : keywords()) known.append(keyword.name);
  for (const char* other : {"outputs", "previous_cameras", "next_cameras", "continues", "formats", "channels_first"})
    known.append(other);
  if (hasSize) known.append("size");
  const nb::list close(nb::module_::import_("difflib").attr("get_close_matches")(name, known, 1));
  if (close.size() == 0) badType("there is no option \"{}\"", name);
  badType("there is no option \"{}\": do you mean \"{}\"?", name, shown(close[0]));
}

void setKeyword(Options& options, const std::string& name, nb::handle value, bool hasSize) {
  const auto found = std::ranges::find(keywords(), name, &Keyword::name);
  if (found != keywords().end()) return found->set(options, value, name);
  if (!setExtraOption(options, name, value)) rejectKeyword(name, hasSize);
}

void setSize(Options& options, nb::handle size) {
  const nb::list pair = itemsOf(size, "size", "a width and a height in pixels");
  if (nb::len(pair) != 2) badType("size must be a width and a height in pixels, not {} values", nb::len(pair));
  options.width = static_cast<uint32_t>(integerOf(pair[0], "the width of size", 1, 16384));
  options.height = static_cast<uint32_t>(integerOf(pair[1], "the height of size", 1, 16384));
}

void setOutputs(Options& options, nb::handle outputs) {
  const std::vector<OutputInfo> known = outputInfos();
  options.picture = false;
  for (const std::string& name : textsOf(outputs, "outputs")) {
    if (name == "rgba") {
      options.picture = true;
      continue;
    }
    if (std::ranges::find(known, name, &OutputInfo::name) == known.end()) {
      std::string names = "rgba";
      for (const OutputInfo& info : known) names += ", " + info.name;
      badValue("outputs takes no \"{}\": there are {}", name, names);
    }
    options.aovs.push_back(name);
  }
  if (!options.picture && options.aovs.empty()) badValue("outputs must name something: \"rgba\", \"depth\" and so on");
}

// --- signatures and docstrings ---------------------------------------------------------------------------------------

// Returns the table entry of a keyword. Both lists have the order of the table, but size is not a keyword.
const OptionInfo& infoOf(const Keyword& keyword) {
  static const std::vector<OptionInfo> infos = optionInfos();
  return *std::ranges::find(infos, keyword.option, &OptionInfo::name);
}

std::string typeOf(const Keyword& keyword) {
  if (!keyword.type.empty()) return keyword.type;
  const OptionInfo& info = infoOf(keyword);
  if (info.anyText || info.names.empty()) return "str";
  std::string names;
  for (const OptionInfo::Name& name : info.names) names += (names.empty() ? "\"" : ", \"") + name.name + "\"";
  return "typing.Literal[" + names + "]";
}

std::string defaultOf(const Keyword& keyword) {
  const OptionInfo& info = infoOf(keyword);
  if (keyword.type.ends_with("None")) return "None";
  if (keyword.type == "bool") return "False";
  return keyword.type.empty() ? "\"" + info.defaultValue + "\"" : info.defaultValue;
}

std::string lineOf(const Keyword& keyword) {
  const OptionInfo& info = infoOf(keyword);
  std::string line = keyword.name + ": " + info.help;
  if (!info.range.empty())
    line += " (" + info.range + ")";
  else if (!info.unit.empty())
    line += " (" + info.unit + ")";
  return line;
}

}  // namespace

std::string snakeCase(std::string_view member) {
  std::string name;
  for (const char c : member) {
    if (std::isupper(static_cast<unsigned char>(c))) name += '_';
    name += static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  }
  return name;
}

Options optionsOf(nb::handle size, nb::handle outputs, const nb::dict& keywords) {
  Options options;
  if (!size.is_none()) setSize(options, size);
  setOutputs(options, outputs);
  for (const auto& [name, value] : keywords) setKeyword(options, shown(nb::borrow(name)), value, !size.is_none());
  return options;
}

void checkWorldKeywords(const nb::dict& keywords) {
  inPython([&] {
    Options options;
    for (const auto& [key, value] : keywords) {
      const std::string name = shown(nb::borrow(key));
      if (!isWorldArgument(name)) setKeyword(options, name, value, true);
    }
  });
}

std::string optionParameters(const std::vector<std::string>& except) {
  std::string text = kExtraOptions;
  for (const Keyword& keyword : keywords())
    if (std::ranges::find(except, keyword.name) == except.end())
      text += ", " + keyword.name + ": " + typeOf(keyword) + " = " + defaultOf(keyword);
  return text;
}

std::string optionDocs() {
  std::string text =
      "previous_cameras, next_cameras: where the cameras were and will be, a frame before and after, for the output "
      "motion\n"
      "continues: this frame follows the one rendered last, for temporal anti-aliasing and the temporal filter of "
      "indirect light\n"
      "formats: element types by output: {\"rgba\": \"rgb8\"} leaves alpha out, \"float16\" and \"uint16\" halve other "
      "outputs (half floats rounded to\nnearest even, finite ones at most 65504; ids above 65535 become 65535)\n"
      "channels_first: arrays are (..., C, H, W)";
  for (const Keyword& keyword : keywords()) text += "\n" + lineOf(keyword);
  return text;
}

std::string outputDocs() {
  std::string text = "rgba: the picture, uint8, sRGB, straight alpha; 4 channels";
  for (const OutputInfo& info : outputInfos()) {
    text += "\n" + info.name + ": " + info.description;
    if (!info.unit.empty()) text += " (" + info.unit + ")";
    text += info.ids ? "; uint32" : info.channels > 1 ? "; " + std::to_string(info.channels) + " channels" : "";
  }
  return text;
}

Error withKeywords(const Error& error) {
  std::string text = error.what();
  for (const Keyword& keyword : keywords()) {
    const std::string option = keyword.option;
    for (size_t at = text.find(option); at != text.npos; at = text.find(option, at + 1)) {
      const size_t end = at + option.size();
      if (end < text.size() && (std::isalnum(static_cast<unsigned char>(text[end])) || text[end] == '-')) continue;
      text.replace(at, option.size(), keyword.name);
    }
  }
  return {error.code(), text};
}

}  // namespace latelight::python
