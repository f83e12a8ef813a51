// Random combinations of all options of `latelight render`, in process. Each either succeeds or is rejected with a
// sentence, produces finite numbers, and causes no validation messages. A repetition produces the same bytes and
// creates no pipeline.
//
//   LATELIGHT_RANDOM_GROUPS=400 LATELIGHT_RANDOM_SEED=7 build/release/tests/test_options
//
// A failure names the options, as they can be passed to the program. Combinations come in groups that share the options
// on which pipelines depend.
#include <fmt/core.h>
#include <unistd.h>

#include <array>
#include <cmath>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <optional>

#include "app/folder.h"
#include "app/render_run.h"
#include "base/error.h"
#include "base/log.h"
#include "long_tests.h"
#include "options/choices.h"
#include "options/everything.h"
#include "output/exr.h"
#include "output/read.h"
#include "render/gbuffer/layout.h"
#include "render/lighting/technique.h"
#include "render/submit/raster_choice.h"
#include "render/submit/session.h"
#include "render/support.h"
#include "scene/load/load.h"
#include "shared/random.h"

namespace latelight::app {
namespace {

using Options = std::map<std::string, std::string>;  // the options of a draw with their values

constexpr uint32_t kDraws = 8;  // per group
constexpr const char* kSensor[] = {"--vignetting", "--bayer", "--full-well", "--white-balance", "--response"};

uint64_t fromEnvironment(const char* name, uint64_t otherwise) {
  const char* value = std::getenv(name);
  return value ? std::strtoull(value, nullptr, 10) : otherwise;
}

std::vector<std::string> argumentsOf(const Options& options) {
  std::vector<std::string> arguments;
  for (const auto& [name, value] : options) {
    if (name == "SCENE")
      arguments.push_back(value);
    else if (value.empty())  // a flag
      arguments.push_back(name);
    else
      arguments.push_back(name + "=" + value);
  }
  return arguments;
}

std::string commandOf(const Options& options) {
  std::string line = "latelight render";
  for (const std::string& argument : argumentsOf(options)) line += " '" + argument + "'";
  return line;
}

// The current command, for the message if a signal ends the process.
char current[4096];
void sayCurrent(int signal) {
  [[maybe_unused]] const auto written = write(STDERR_FILENO, current, std::strlen(current));
  std::signal(signal, SIG_DFL);
  std::raise(signal);
}

// --- drawing --------------------------------------------------------------------------------------------------------

class Drawing {
 public:
  Drawing(std::map<std::string, Choice> choices, uint64_t seed) : choices_(std::move(choices)), random_(seed) {}

  Options draw(Rate rate) {
    Options options;
    for (const auto& [name, choice] : choices_)
      if (choice.rate == rate && random_.uniform() < choice.share) options[name] = any(choice.right);
    return options;
  }

  // Most draws avoid options that exclude each other; in the others, the program must reject them.
  void reconcile(Options& o) {
    if (random_.uniform() < 0.1f) return;
    if (o.contains("--debug")) {
      o.erase("--aov");
      o["--out"] = choices_.at("--dump-graph").right.front() + ".png";
    }
    if (o.contains("--frames")) {
      for (const char* name : {"--time", "--pick", "--frame"}) o.erase(name);
      if (std::string& out = o["--out"]; out != "-" && !out.empty()) out.insert(out.rfind('.'), "{frame}");
      for (const char* name : {"--labels", "--correspond"})
        if (o.contains(name)) o[name].insert(o[name].rfind('.'), "{frame}");
    }
    const auto drop = [&](const char* name, bool useless) {
      if (useless) o.erase(name);
    };
    if (o.contains("--eye")) o.try_emplace("--target", "0,0.5,0");
    drop("--keypoints", !o.contains("--labels"));
    drop("--target", !o.contains("--eye"));
    drop("--up", !o.contains("--eye"));
    const bool builtin = o.at("SCENE").starts_with("builtin:");
    for (const char* name : {"--variant", "--animation", "--id-nodes"}) drop(name, builtin);
    drop("--id-nodes", o.contains("--id-depth"));
    if (o.contains("--layout")) {
      const render::Layout& layout = render::findLayout(o.at("--layout"));
      drop("--normals", layout.fixedNormal);
      drop("--position", layout.fixedPosition);
      for (const auto& [name, drawn] : {std::pair("--raster", "hardware"), std::pair("--lighting", "volumes")})
        drop(name, !layout.hasTargets() && o.contains(name) && o.at(name) == drawn);
    }
    if ((o.contains("--animation") || o.contains("--loop")) && !o.contains("--frames")) o["--time"] = "0.4";
    if (o.contains("--aa") && o.at("--aa").starts_with("msaa") && o.at("--aa") != "msaa4") {
      drop("--raster", true);
      drop("--aa", o.contains("--lighting") && render::findTechnique(o.at("--lighting")).draws);
    }
    const bool traces = o.contains("--lighting") && render::findTechnique(o.at("--lighting")).traces;
    const bool forward = o.contains("--lighting") && render::findTechnique(o.at("--lighting")).forward;
    const bool rays = o.contains("--shadows") && o.at("--shadows") == "rays";
    drop("--shadows", rays && forward);
    drop("--indirect", forward);
    const bool ground = o.contains("--ground") && o.at("--ground") == "shadow";
    drop("--aa", o.contains("--aa") && o.at("--aa").starts_with("msaa") &&
                     (traces || rays || ground || o.contains("--indirect")));
    const auto is = [&](const char* name, std::string_view value) { return o.contains(name) && o.at(name) == value; };
    const bool senses = std::ranges::any_of(kSensor, [&](const char* name) { return o.contains(name); });
    drop("--aperture", is("--lens", "equirectangular"));
    drop("--aa", (is("--aa", "taa") && (o.contains("--shutter") || o.contains("--aperture"))) ||
                     (is("--aa", "fxaa") && senses));
    drop("--readout", is("--aa", "taa") || is("--aa", "fxaa") || o.contains("--bloom") || o.contains("--ao") ||
                          o.contains("--aov") || o.contains("--debug"));
    drop("--camera", o.contains("--eye") || o.contains("--orbit"));
    drop("--orbit", o.contains("--eye"));
    drop("--json", o["--out"] == "-");
    reconcileSecondPicture(o);
  }

  // Gives pictures at rest a second camera, and at most one second camera and time.
  static void reconcileSecondPicture(Options& o) {
    constexpr std::array kSecond = {"--to", "--to-time", "--to-camera", "--to-eye", "--to-target"};
    if (!o.contains("--correspond"))
      for (const char* name : kSecond) o.erase(name);
    if (!o.contains("--correspond")) return;
    const bool isTimed = o.contains("--time") || o.contains("--frames");
    if (!isTimed || o.contains("--to-eye")) {
      o.try_emplace("--to-eye", "0.4,1.2,6");
      o.try_emplace("--to-target", "0,0.5,0");
      o.erase("--to-camera");
    } else {
      o.erase("--to-target");
    }
    if (!isTimed || o.contains("--to-time")) o.erase("--to");
    if (!isTimed) o.erase("--to-time");
  }

  // Sets one option to a value that must be rejected.
  void spoil(Options& options) {
    auto at = std::next(choices_.begin(), static_cast<ptrdiff_t>(random_.bits() % choices_.size()));
    while (at->second.wrong.empty()) at = std::next(at) == choices_.end() ? choices_.begin() : std::next(at);
    options[at->first] = any(at->second.wrong);
  }

  shared::Random& random() { return random_; }

 private:
  const std::string& any(const std::vector<std::string>& values) { return values[random_.bits() % values.size()]; }

  std::map<std::string, Choice> choices_;
  shared::Random random_;
};

// --- running --------------------------------------------------------------------------------------------------------

// The result of a run, and its files.
struct Outcome {
  int code = 0;
  std::string sentence;                      // set if the exit code is not 0
  std::map<std::string, std::string> files;  // by name; "-" is standard output
};

// Scenes, environments and renderers. They are cached for a group, scenes longer.
class Stage {
 public:
  explicit Stage(vk::Device& device) : device_(device) {}
  void endGroup() { renderers_.clear(); }

  const scene::Scene& scene(const RenderOptions& o) {
    const std::string depth = o.idGrouping.depth ? fmt::format("{}", *o.idGrouping.depth) : "";
    auto& kept = scenes_[fmt::format("{}\n{}\n{}\n{}", o.scene, o.variant, depth, o.idNodes)];
    if (!kept) kept = std::make_unique<scene::Scene>(scene::load(o.scene, {.variant = o.variant, .ids = o.idGrouping}));
    return *kept;
  }
  render::Renderer& renderer(const scene::Scene& scene, const std::string& environment) {
    auto& kept = renderers_[{&scene, environment}];
    if (kept) return *kept;
    if (!environments_.contains(environment)) environments_[environment] = render::loadEnvironment(scene, environment);
    const std::optional<scene::Environment>& light = environments_[environment];
    return *(kept = std::make_unique<render::Renderer>(device_, scene, light ? &*light : nullptr));
  }
  vk::Device& device() { return device_; }

 private:
  vk::Device& device_;
  std::map<std::string, std::unique_ptr<scene::Scene>> scenes_;
  std::map<std::string, std::optional<scene::Environment>> environments_;
  std::map<std::pair<const scene::Scene*, std::string>, std::unique_ptr<render::Renderer>> renderers_;
};

// As in the main function of the program.
void run(Stage& stage, const Options& options) {
  CLI::App command;
  RenderOptions o;
  addRenderOptions(command, o);
  std::vector<std::string> arguments = argumentsOf(options);
  std::reverse(arguments.begin(), arguments.end());  // in the order that CLI11 expects
  command.parse(arguments);
  const RenderPlan plan = planRender(o);
  const scene::Scene& scene = stage.scene(o);
  const Timeline timeline(scene, o);
  const std::string environment = environmentOf(o, scene);
  o.settings.raster = render::chooseRaster(stage.device(), o.settings, scene).raster;
  RenderRun run{o, plan, scene, timeline, environment, stage.device(), stage.renderer(scene, environment)};
  renderAll(run);
}

Outcome outcomeOf(Stage& stage, const Options& options, const Folder& folder) {
  Outcome outcome;
  testing::internal::CaptureStdout();
  try {
    run(stage, options);
  } catch (const CLI::ParseError& error) {
    outcome = {int(ExitCode::Usage), error.what(), {}};
  } catch (const Error& error) {
    outcome = {int(error.code()), error.what(), {}};
  } catch (const std::exception& error) {
    outcome = {int(ExitCode::Internal), error.what(), {}};
  }
  outcome.files["-"] = testing::internal::GetCapturedStdout();
  for (const std::string& name : folder.names())
    if (!name.ends_with('/')) outcome.files[name] = folder.read(name);
  return outcome;
}

// --- checks ---------------------------------------------------------------------------------------------------------

void expectSentence(const std::string& sentence) {
  EXPECT_GE(sentence.size(), 10u) << sentence;
  EXPECT_LE(sentence.size(), 1000u) << sentence;
  EXPECT_EQ(sentence.find('\n'), std::string::npos) << sentence;
}

// In the background, depth and distance are infinite, and pixels that correspond are NaN. No other value ever is.
void expectFinite(const std::filesystem::path& file) {
  const std::string name = file.filename().string();
  for (const output::Channel& channel : output::readImage(file).channels) {
    const bool far = channel.name == "Z" || channel.name == "distance" || name.starts_with("o.depth") ||
                     name.starts_with("o.distance");
    const bool matched = channel.name.starts_with("match.");
    const auto broken = std::count_if(channel.values.begin(), channel.values.end(), [&](double value) {
      return !std::isfinite(value) && !(far && value == INFINITY) && !(matched && std::isnan(value));
    });
    EXPECT_EQ(broken, 0) << "values of " << name << ", channel " << channel.name << ", are not finite";
  }
}

// A folder whose files are deleted with the test, and the files that draws read.
class RandomOptions : public render::test::RenderTest {
 protected:
  RandomOptions() {
    inputs.write("everything.glb", everythingModel());
    inputs.write("no_masked.glb", everythingModel({.masked = false}));
    inputs.write("no_blended.glb", everythingModel({.blended = false}));
    inputs.write("no_lights.glb", everythingModel({.lights = false}));
    inputs.write("layered.glb", everythingModel({.masked = false, .blended = false, .layered = true}));
    inputs.write("glass_alone.glb", everythingModel({.opaque = false, .masked = false}));
    output::AovImage sky = output::makeAovImage(output::Aov::Color, 32, 16);
    for (size_t i = 0; i < sky.values.size(); ++i) sky.values[i] = static_cast<float>(i % 40) / 20;
    const output::AovImage* images[] = {&sky};
    const output::Metadata plain;
    inputs.write("sky.exr", output::encodeExr(images, plain));
  }
  std::map<std::string, Choice> choices() const {
    std::vector<std::string> models;
    for (const std::string& name : inputs.names())
      if (name.ends_with(".glb")) models.push_back(inputs.at(name));
    models.insert(models.end(), 2, inputs.at("everything.glb"));
    return choicesIn(outputs.path(), models, inputs.at("sky.exr"));
  }
  void empty() const {
    for (const auto& entry : std::filesystem::directory_iterator(outputs.path()))
      std::filesystem::remove_all(entry.path());
  }
  // Returns true if it was rendered.
  bool check(Stage& stage, const Options& options, bool spoiled) const {
    SCOPED_TRACE(commandOf(options));
    fmt::format_to_n(current, sizeof(current) - 1, "{}\n", commandOf(options)).out[0] = '\0';
    empty();
    const Outcome first = outcomeOf(stage, options, outputs);
    for (const std::string& message : device().validationMessages()) ADD_FAILURE() << message;
    if (first.code != 0) {
      EXPECT_EQ(first.code, int(ExitCode::Usage)) << first.sentence;
      expectSentence(first.sentence);
      EXPECT_TRUE(first.files.size() == 1 && first.files.at("-").empty()) << "something was written though it failed";
      return false;
    }
    EXPECT_FALSE(spoiled) << "a wrong value was taken";
    for (const auto& [name, bytes] : first.files)
      if (name.ends_with(".exr") || name.ends_with(".npy")) expectFinite(outputs.path() / name);
    empty();
    const uint64_t pipelines = device().pipelinesMade();
    const Outcome second = outcomeOf(stage, options, outputs);
    EXPECT_EQ(second.code, 0) << "the second time: " << second.sentence;
    EXPECT_EQ(device().pipelinesMade(), pipelines) << "pipelines were made anew";
    expectSame(first, second, options.contains("--json"));
    return true;
  }
  static void expectSame(const Outcome& first, const Outcome& second, bool timesOut) {
    ASSERT_EQ(first.files.size(), second.files.size());
    for (const auto& [name, bytes] : first.files) {
      if (name == "-" && timesOut) continue;
      if (name.ends_with(".dot")) continue;  // may differ once: it uploads what the command before had changed
      EXPECT_TRUE(second.files.at(name) == bytes) << name << " has other bytes";
    }
  }

  Folder inputs, outputs;
};

TEST_F(RandomOptions, DrawFromAllThatThereAre) {
  CLI::App command;
  RenderOptions o;
  addRenderOptions(command, o);
  std::map<std::string, Choice> missing = choices();
  for (const CLI::Option* option : command.get_options()) {
    const std::string name = option->get_positional() ? "SCENE" : "--" + option->get_lnames().front();
    if (name == "--help") continue;
    ASSERT_TRUE(missing.contains(name)) << name << " is in no table";
    const Choice& choice = missing.at(name);
    const bool rejected = name == "--unit" || name == "--up-axis" || name == "--point-radius";  // by glTF files
    EXPECT_EQ(choice.share == 0, rejected)
        << name << " is never drawn: say in tests/options/choices.cpp what texts it takes";
    EXPECT_FALSE(choice.right.empty()) << name;
    missing.erase(name);
  }
  for (const auto& [name, choice] : missing) ADD_FAILURE() << "there is no option " << name;
}

TEST_F(RandomOptions, AreDoneOrRefused) {
  setQuiet(true);
  for (int signal : {SIGSEGV, SIGABRT, SIGFPE, SIGBUS, SIGILL}) std::signal(signal, sayCurrent);
  const uint64_t seed = fromEnvironment("LATELIGHT_RANDOM_SEED", 1),
                 groups = fromEnvironment("LATELIGHT_RANDOM_GROUPS", latelight::test::rounds(10, 2));
  Stage stage(device());
  size_t rendered = 0, refused = 0;
  for (uint64_t group = 0; group < groups; ++group) {
    Drawing drawing(choices(), seed << 32 | group);
    const Options shared = drawing.draw(Rate::Group);
    for (uint32_t i = 0; i < kDraws; ++i) {
      Options options = drawing.draw(Rate::Draw);
      options.insert(shared.begin(), shared.end());
      drawing.reconcile(options);
      const bool spoiled = drawing.random().uniform() < 0.08f;
      if (spoiled) drawing.spoil(options);
      ++(check(stage, options, spoiled) ? rendered : refused);
    }
    stage.endGroup();
  }
  fmt::print("{} combinations rendered, {} refused\n", rendered, refused);
  EXPECT_GT(rendered, refused) << "most that is drawn should be a picture";
}

}  // namespace
}  // namespace latelight::app
