// The table of options: defaults, ranges and names agree in its text, in Settings and in the C++ API.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <latelight/latelight.h>

#include <cmath>
#include <functional>
#include <limits>
#include <set>

#include "base/error.h"
#include "render/options/options.h"
#include "render/support.h"
#include "scene/builtin/builtin.h"
#include "scene/load/load.h"

namespace latelight::render {
namespace {

using testing::AnyOf;
using testing::HasSubstr;
using testing::StartsWith;

void expectSame(const Settings& a, const Settings& b) {
#define EXPECT_MEMBER(member, name) EXPECT_TRUE(a.member == b.member) << name;
#define OPTION_FLAG(member, name, ...) EXPECT_MEMBER(member, name)
#define OPTION_NUMBER(Type, member, name, ...) EXPECT_MEMBER(member, name)
#define OPTION_ANGLE(member, name, ...) EXPECT_MEMBER(member, name)
#define OPTION_OPTIONAL(Type, member, name, ...) EXPECT_MEMBER(member, name)
#define OPTION_CHOICE(Enum, member, name, ...) EXPECT_MEMBER(member, name)
#define OPTION_ENTRY(Type, member, name, ...) EXPECT_MEMBER(member, name)
#define OPTION_TEXT(Type, member, name, ...) EXPECT_MEMBER(member, name)
#define OPTION_SIZE(width, height, name, ...) EXPECT_MEMBER(width, name) EXPECT_MEMBER(height, name)
#define OPTION_SUN(member, name, ...) EXPECT_MEMBER(member, name)
#define OPTION_EXPOSURE(member, name, ...) EXPECT_MEMBER(member, name)
#include <latelight/options.def>
#undef EXPECT_MEMBER
}

// The message if the text is rejected; empty if it is accepted.
std::string refusal(const Option& option, const std::string& text) {
  Settings settings;
  try {
    read(settings, option, text);
    checkSettings(settings);
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ExitCode::Usage);
    return error.what();
  }
  return "";
}

TEST(OptionTable, NamesAreDifferentAndExplained) {
  std::set<std::string_view> names, members;
  for (const Option& option : options()) {
    EXPECT_TRUE(names.insert(keyOf(option)).second) << option.name;
    EXPECT_TRUE(members.insert(option.member).second) << option.member;
    EXPECT_THAT(option.name, StartsWith("--"));
    EXPECT_GE(std::string(option.help).size(), 10u) << option.name;
    for (const NamedOption& named : option.names) EXPECT_GE(std::string(named.description).size(), 10u) << named.name;
    EXPECT_TRUE(option.kind != OptionKind::Choice || *option.topic) << option.name << " is in no list";
  }
}

TEST(OptionTable, DefaultsAreWhatTheirTextsSay) {
  const Settings untouched;
  checkSettings(untouched);
  Settings settings;
  for (const Option& option : options()) {
    if (option.defaultValue.empty()) continue;
    EXPECT_EQ(read(settings, option, option.defaultValue), option.defaultValue) << option.name;
  }
  expectSame(settings, untouched);
}

TEST(OptionTable, NumbersKeepToTheirRange) {
  size_t ends = 0;
  for (const Option& option : options()) {
    if (option.kind != OptionKind::Integer && option.kind != OptionKind::Number) continue;
    SCOPED_TRACE(option.name);
    const auto expectRefused = [&](const std::string& text) {
      EXPECT_THAT(refusal(option, text), HasSubstr(fmt::format("{} takes a ", option.name)));
      EXPECT_THAT(refusal(option, text), HasSubstr(fmt::format("not \"{}\"", text)));
    };
    for (const char* text : {"nan", "inf", "many", "", "1 ", "0x1"}) expectRefused(text);
    if (std::isfinite(option.range.most)) {
      EXPECT_EQ(refusal(option, fmt::format("{}", option.range.most)), "");
      expectRefused(fmt::format("{}", option.range.most + 1));
      ++ends;
    }
    if (std::isfinite(option.range.least)) {
      const std::string least = fmt::format("{}", option.range.least);
      EXPECT_EQ(refusal(option, least).empty(), !option.range.open);
      expectRefused(fmt::format("{}", option.range.least - 1));
      ++ends;
    }
  }
  EXPECT_GT(ends, 20u);
}

TEST(OptionTable, ChoicesTakeTheirNamesAndNoOthers) {
  size_t names = 0;
  for (const Option& option : options()) {
    if (option.kind != OptionKind::Choice) continue;
    std::string all;
    for (const NamedOption& named : option.names) {
      EXPECT_EQ(refusal(option, named.name), "");
      all += (all.empty() ? "" : ", ") + std::string(named.name);
      ++names;
    }
    for (const char* wrong : {"", "nothing", "None "})
      EXPECT_EQ(refusal(option, wrong), fmt::format("{} takes one of these, not \"{}\": {}", option.name, wrong, all));
  }
  EXPECT_GT(names, 50u);
}

// Cameras of the API and of data sets have the limits of the options.
TEST(OptionTable, HasTheLimitsOfExposures) {
  EXPECT_EQ(rangeOf("--shutter").least, 0);
  EXPECT_EQ(rangeOf("--shutter").most, 10'000);
  EXPECT_EQ(rangeOf("--readout").least, -10'000);
  EXPECT_EQ(rangeOf("--readout").most, 10'000);
  EXPECT_THROW(rangeOf("shutter"), Error);
  for (const double ev : {-60.0, 0.0, 60.0}) EXPECT_TRUE(isValidExposure(ev)) << ev;
  const double infinity = std::numeric_limits<double>::infinity();
  for (const double ev : {-60.001, 60.001, infinity, -infinity, std::nan("")}) EXPECT_FALSE(isValidExposure(ev)) << ev;
}

// --- the C++ API ----------------------------------------------------------------------------------------------------

using Change = std::function<void(latelight::Options&)>;

// Returns whether the type has values that are not in the range. A seed may have any.
template <typename T>
bool excludesAny(const Range& range) {
  return std::is_floating_point_v<T> || range.least > static_cast<double>(std::numeric_limits<T>::lowest()) ||
         range.most < static_cast<double>(std::numeric_limits<T>::max());
}

// For each member, a value that the API must reject.
std::vector<std::pair<std::string, Change>> wrongMembers() {
  const auto beyond = [](const Range& range) {
    if (std::isfinite(range.most)) return range.most + 1;
    return std::isfinite(range.least) ? range.least - 1 : std::nan("");
  };
  std::vector<std::pair<std::string, Change>> wrong;
#define WRONG(name, statement) wrong.emplace_back(name, [=](latelight::Options& o) { statement; });
#define OPTION_NUMBER(Type, member, name, normal, range, ...) \
  if (excludesAny<Type>(range)) WRONG(name, o.member = static_cast<Type>(beyond(range)))
#define OPTION_ANGLE(member, name, normal, range, ...) WRONG(name, o.member = beyond(range))
#define OPTION_OPTIONAL(Type, member, name, range, ...) WRONG(name, o.member = static_cast<Type>(beyond(range)))
#define OPTION_CHOICE(Enum, member, name, ...) WRONG(name, o.member = "nothing")
#define OPTION_ENTRY(Type, member, name, ...) WRONG(name, o.member = "nothing")
#define OPTION_SIZE(width, height, name, defaultWidth, defaultHeight, most, ...) WRONG(name, o.height = most + 1)
#define OPTION_SUN(member, name, ...) WRONG(name, (o.member = Sun{.illuminance = -1}))
#define OPTION_EXPOSURE(member, name, ...) WRONG(name, o.member = latelight::Exposure::metered(61))
#include <latelight/options.def>
#undef WRONG
  wrong.emplace_back("--aa", [](latelight::Options& o) { o.aa = "ss17"; });
  wrong.emplace_back("--background", [](latelight::Options& o) { o.background = "blue"; });
  wrong.emplace_back("--fog-color", [](latelight::Options& o) { o.fogColor = "#12345g"; });
  return wrong;
}

TEST(OptionsOfTheApi, AreCheckedByTheTable) {
  const Scene scene("builtin:boxes");
  latelight::Renderer renderer(scene, "cpu");
  for (const auto& [name, change] : wrongMembers()) {
    latelight::Options options;
    change(options);
    try {
      renderer.render(scene.defaultCamera(1), options);
      ADD_FAILURE() << name << " takes anything";
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ExitCode::Usage) << error.what();
      EXPECT_THAT(error.what(), AnyOf(StartsWith(name + " takes "), StartsWith(name + " requires ")));
    }
  }
}

// A picture of the C++ API equals that of the same options as text.
TEST(OptionsOfTheApi, MeanWhatTheCommandLineMeans) {
  struct Case {
    Change change;
    std::vector<std::pair<const char*, const char*>> texts;
  };
  const Case cases[] = {
      {[](latelight::Options& o) {}, {}},
      {[](latelight::Options& o) {
         o.exposure = 1.5f, o.tonemap = "agx", o.aa = "ss2", o.background = "#204060", o.lighting = "forward";
       },
       {{"--exposure", "1.5"},
        {"--tonemap", "agx"},
        {"--aa", "ss2"},
        {"--background", "#204060"},
        {"--lighting", "forward"}}},
      {[](latelight::Options& o) {
         o.sun = Sun{.azimuth = 30, .elevation = 50, .illuminance = 2};
         o.shadowFilter = "pcss", o.sunAngle = 4, o.shadowLights = "1", o.layout = "thin", o.normals = "xyz";
       },
       {{"--sun", "30,50,2"},
        {"--shadow-filter", "pcss"},
        {"--sun-angle", "4"},
        {"--shadow-lights", "1"},
        {"--layout", "thin"},
        {"--normals", "xyz"}}},
      {[](latelight::Options& o) {
         o.ambientOcclusion = "gtao", o.aoRadius = 0.5f, o.bloom = 0.1f, o.fogDensity = 0.05f,
         o.fogColor = "0.9,0.5,0.1";
       },
       {{"--ao", "gtao"},
        {"--ao-radius", "0.5"},
        {"--bloom", "0.1"},
        {"--fog", "0.05"},
        {"--fog-color", "0.9,0.5,0.1"}}}};
  const Scene scene("builtin:boxes");
  latelight::Renderer api(scene, "cpu");
  const scene::Scene loaded = scene::load("builtin:boxes");
  vk::Device device({.selector = "cpu"});
  Renderer renderer(device, loaded, nullptr);
  std::set<std::string> pictures;
  for (const Case& c : cases) {
    latelight::Options options;
    options.width = 64, options.height = 36;
    c.change(options);
    Settings settings;
    settings.width = 64, settings.height = 36;
    for (const auto& [name, text] : c.texts)
      for (const Option& option : render::options())
        if (option.name == std::string_view(name)) read(settings, option, text);
    const std::vector<uint8_t> picture = api.render(scene.cameras().front(), options).rgba;
    EXPECT_TRUE(picture == renderer.render({&loaded.cameras.front(), 1}, settings).front().display);
    pictures.emplace(picture.begin(), picture.end());
  }
  EXPECT_EQ(pictures.size(), std::size(cases)) << "an option does nothing";
}

}  // namespace
}  // namespace latelight::render
