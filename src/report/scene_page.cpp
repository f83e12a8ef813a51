#include "report/scene_page.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <numeric>
#include <optional>

#include "base/error.h"
#include "base/log.h"
#include "output/debug.h"
#include "render/gbuffer/layout.h"
#include "render/lighting/technique.h"
#include "render/options/options.h"
#include "render/visibility/compute/compute.h"
#include "report/chart.h"
#include "report/command.h"
#include "report/html.h"
#include "report/layout_errors.h"
#include "report/planes.h"
#include "report/spheres.h"
#include "report/times.h"
#include "study/study.h"

namespace latelight::report {

namespace {

using Json = nlohmann::ordered_json;
using Words = std::vector<std::string>;

constexpr uint32_t kNormalSamples = 100'000;  // directions
constexpr uint32_t kNormalBits[] = {8, 12, 16};

class ScenePage {
 public:
  explicit ScenePage(const Subject& subject) : s_(subject) {}

  std::string build() {
    page_.title = "Latelight: " + s_.scene.source;
    page_.introduction = introduction();
    page_.sections.push_back({"compare", "Compare", std::string(webFile("compare.html"))});
    page_.sections.push_back({"layouts", "G-buffer layouts", layouts()});
    page_.sections.push_back({"lighting", "Lighting techniques", lighting()});
    page_.sections.push_back({"times", "Pass times", timesHtml(s_)});
    page_.sections.push_back({"normals", "Normal encodings", normals()});
    page_.data["width"] = s_.settings.width;
    page_.data["height"] = s_.settings.height;
    page_.data["views"] = views_;
    page_.values = planes_.toHtml();
    std::string page = toHtml(page_);
    checkBytes(page.size());
    return page;
  }

 private:
  Words rendering(const render::Layout& layout, const render::TechniqueInfo& technique, const Words& more) const {
    const render::Raster raster = settingsFor(s_, layout).raster;
    const Words choice{"--raster", render::nameOf(raster), "--layout", layout.name, "--lighting", technique.name};
    return joined(joined(joined({"render"}, optionsFor(s_, layout)), choice), more);
  }
  static std::string counted(size_t count, std::string_view noun) {
    return fmt::format("{} {}{}", count, noun, count == 1 ? "" : "s");
  }
  std::string sizeText() const { return fmt::format("{}x{}", s_.settings.width, s_.settings.height); }

  std::string introduction() const {
    const vk::DeviceInfo& info = s_.device.info();
    return fmt::format(
               "<p>{} and {}, {}, on {} ({}). The command that produces a number or "
               "image is next to it. This page was created by:</p>\n",
               counted(s_.scene.triangleCount(), "triangle"), counted(s_.scene.lights.size(), "light"), sizeText(),
               escaped(info.name), escaped(info.driver)) +
           "<p class=\"command\"><code>" + escaped(s_.command) + "</code></p>\n";
  }

  // Adds an image to the page and to the lists of images that can be compared.
  std::string show(const std::string& group, const std::string& name, const output::Picture& picture, Json values) {
    const std::string id = fmt::format("image-{}", views_.size());
    views_.push_back({{"group", group}, {"name", name}, {"image", id}, {"values", std::move(values)}});
    std::string html = figure(id, picture, group + ": " + name, escaped(name));
    imageBytes_ += html.size();
    checkBytes(imageBytes_ + planes_.toHtml().size());
    return html;
  }

  // Large images would take minutes and gigabytes until the page is complete.
  void checkBytes(size_t bytes) const {
    if (bytes > s_.maxBytes)
      badUsage(
          "the page's first {} images and their values have {} MB, more than its limit of {}: use a smaller "
          "--size than {}",
          views_.size(), bytes / 1'000'000, s_.maxBytes / 1'000'000, sizeText());
  }

  // Adds a value of every pixel: every `stride`-th float, starting with `first`.
  Json value(const std::string& name, std::span<const float> values, size_t first = 0, size_t stride = 1) {
    std::vector<uint32_t> words;
    for (size_t i = first; i < values.size(); i += stride) words.push_back(std::bit_cast<uint32_t>(values[i]));
    return {{"name", name}, {"kind", "float"}, {"plane", planes_.add(words)}};
  }
  Json value(const std::string& name, std::span<const uint32_t> values, size_t first) {
    std::vector<uint32_t> words;
    for (size_t i = first; i < values.size(); i += 4) words.push_back(values[i]);
    return {{"name", name}, {"kind", "integer"}, {"plane", planes_.add(words)}};
  }

  std::string showLit(const std::string& group, const output::FrameOutput& frame) {
    std::vector<uint32_t> words;
    for (size_t i = 0; i < frame.display.size(); i += 4)
      words.push_back(frame.display[i] | frame.display[i + 1] << 8 | frame.display[i + 2] << 16 |
                      uint32_t{frame.display[i + 3]} << 24);
    return show(group, "picture", {frame.width, frame.height, frame.display},
                {{{"name", "red, green, blue, alpha"}, {"kind", "bytes"}, {"plane", planes_.add(words)}}});
  }

  output::FrameOutput lit(const render::Settings& settings) {
    return std::move(s_.renderer.render({&s_.camera, 1}, settings, s_.moment).front());
  }

  // --- layouts -------------------------------------------------------------------------------------------------------

  std::string layouts() {
    BarChart chart{"Bytes per pixel of each layout", "bytes", {"targets", "depth", "light"}, {}};
    study::Table table{
        "layouts", {"layout", "description", "targets B/px", "depth B/px", "light B/px", "total B/px", "image MB"}, {}};
    const double samples = double(s_.settings.width) * s_.settings.height * s_.settings.aa.samples;
    for (const render::Layout& layout : render::layouts()) {
      const render::LayoutBytes bytes = layout.bytesPerPixel(s_.settings.normals->index);
      chart.bars.push_back({layout.name, {double(bytes.targets), double(bytes.depth), double(bytes.light)}});
      table.rows.push_back({layout.name, layout.description, double(bytes.targets), double(bytes.depth),
                            double(bytes.light), double(bytes.total()), bytes.total() * samples / 1e6});
    }
    std::string html = "<h3>Bytes per pixel</h3>\n" + toHtml(chart) + toHtml(table, "Bytes of each layout") +
                       commandHtml(Words{"list", "layouts", "--size", sizeText(), "--samples",
                                         fmt::format("{}", s_.settings.aa.samples)});
    std::string targets;
    study::Table errors{"layout errors",
                        {"layout", "normal mean deg", "max deg", "position mean mm", "max mm", "albedo mean", "max",
                         "roughness mean", "max"},
                        {}};
    std::optional<output::RawGbuffer> exact;
    for (const render::Layout& layout : render::layouts())
      if (canLight(s_, layout)) targets += layoutHtml(layout, exact, errors);
    return html + errorsHtml(errors) +
           "<p>The targets as shaders read them. World space has X right, Y away and Z up, as with --axes z-up.</p>\n" +
           targets;
  }

  static std::string errorsHtml(const study::Table& errors) {
    return "<h3>Errors of layouts in this scene</h3>\n<p>Unpacked surfaces relative to those of the layout exact, over "
           "all pixels that show a surface: the angle between normals, the distance between positions, the largest "
           "channel "
           "error of the linear diffuse color of lit surfaces, and perceptual roughness. The command at the top of "
           "this page creates this table.</p>\n" +
           toHtml(errors, "Errors of each layout");
  }

  output::RawGbuffer readTargets(const render::Layout& layout) {
    return s_.renderer.readTargets(s_.camera, settingsFor(s_, layout), s_.moment).gbuffer;
  }

  // `exact`: the targets of the layout exact; read if they are not yet, after the first image has passed checkBytes().
  std::string layoutHtml(const render::Layout& layout, std::optional<output::RawGbuffer>& exact, study::Table& errors) {
    const render::Settings settings = settingsFor(s_, layout);
    const auto command = [&](const Words& more) { return commandHtml(rendering(layout, *settings.lighting, more)); };
    const std::string group = "Layout " + layout.name;
    std::string html = fmt::format("<h3>{}</h3>\n<div class=\"pictures\">\n", escaped(layout.name));
    html += showLit(group, lit(settings));
    std::string commands = command({"-o", layout.name + ".png"});
    if (layout.hasTargets()) {
      const output::RawGbuffer gbuffer = readTargets(layout);
      if (!exact) exact = readTargets(render::findLayout("exact"));
      const LayoutErrors e = layoutErrors(layout, gbuffer, *exact, settings, s_.camera);
      errors.rows.push_back({layout.name, e.normal.mean, e.normal.most, e.position.mean, e.position.most, e.albedo.mean,
                             e.albedo.most, e.roughness.mean, e.roughness.most});
      for (const output::Labelled& target : output::targetPictures(gbuffer))
        html += show(group, target.label, target.picture, targetValues(gbuffer, target.label));
      commands += command({"--debug", "targets", "-o", layout.name + "-targets.png"});
    }
    progress_.step();
    return html + "</div>\n" + commands;
  }

  // Returns the values of the target with which the label begins.
  Json targetValues(const output::RawGbuffer& gbuffer, const std::string& label) {
    Json values = Json::array();
    for (const output::RawTarget& target : gbuffer.targets) {
      if (!label.starts_with(target.name + ".")) continue;
      const bool vector = target.channels.starts_with("xyz");
      for (size_t channel = 0; channel < target.count; ++channel) {
        const std::string name = fmt::format("{}.{}", target.name, (vector ? "xyzw" : "rgba")[channel]);
        values.push_back(target.words.empty() ? value(name, target.values, channel, 4)
                                              : value(name, target.words, channel));
      }
    }
    if (label == "depth") values.push_back(value("depth, meters", gbuffer.depth));
    return values;
  }

  // --- lighting ------------------------------------------------------------------------------------------------------

  std::string lighting() {
    study::Table table{
        "lights", {"technique", "description", "tested, mean", "tested, max", "used, mean", "used, max"}, {}};
    std::string pictures;
    for (const render::TechniqueInfo& technique : render::techniques())
      if (canLight(s_, technique)) pictures += techniqueHtml(technique, table);
    return "<p>The number of lights that a technique tests for each pixel, and the number that contribute to it, on a "
           "logarithmic scale from 0 (black) to 4095 (white).</p>\n" +
           toHtml(table, "Lights per pixel") + pictures;
  }

  std::string techniqueHtml(const render::TechniqueInfo& technique, study::Table& table) {
    render::Settings settings = settingsFor(s_, technique);
    settings.aovs = {output::Aov::LightsTested, output::Aov::LightsUsed, output::Aov::Id};
    const output::FrameOutput frame = lit(settings);
    std::vector<study::Cell> row{technique.name, technique.description};
    const std::string group = "Lighting " + technique.name;
    std::string html =
        fmt::format("<h3>{}</h3>\n<div class=\"pictures\">\n", escaped(technique.name)) + showLit(group, frame);
    for (const output::AovImage& counts : std::span(frame.aovs).first(2)) {
      const std::string name(output::info(counts.aov).name);
      html += show(group, name, output::debugPicture(counts, &frame.aovs.back()), {value(name, counts.values)});
      const double sum = std::accumulate(counts.values.begin(), counts.values.end(), 0.0);
      row.insert(row.end(), {sum / double(counts.values.size()), double(*std::ranges::max_element(counts.values))});
    }
    table.rows.push_back(std::move(row));
    progress_.step();
    const auto command = [&](const Words& more) { return commandHtml(rendering(*settings.layout, technique, more)); };
    return html + "</div>\n" + command({"-o", technique.name + ".png"}) +
           command({"--debug", "lights", "-o", technique.name + "-lights.png"}) +
           command({"--aov", "lights-tested,lights-used", "-o", technique.name + ".npy"});
  }

  // --- normals -------------------------------------------------------------------------------------------------------

  std::string normals() {
    study::Options options = s_.normals;
    options.samples = kNormalSamples;
    options.bits.assign(std::begin(kNormalBits), std::end(kNormalBits));
    const study::Table errors = study::studyNormals(options).tables.front();
    page_.data["spheres"] = describeSpheres(kNormalBits, errors, planes_);
    std::string bits;
    for (const uint32_t b : kNormalBits) bits += fmt::format("{}{}", bits.empty() ? "" : ",", b);
    return spheresHtml(kNormalBits) + toHtml(errors, "Errors of normal encodings, in degrees") +
           commandHtml(Words{"study", "normals", "--samples", fmt::format("{}", kNormalSamples), "--bits", bits,
                             "--device", s_.normals.device});
  }

  const Subject& s_;
  Progress progress_{"Rendering", render::layouts().size() + render::techniques().size()};
  Page page_;
  Planes planes_;
  Json views_ = Json::array();
  size_t imageBytes_ = 0;
};

}  // namespace

std::vector<std::string> optionsFor(const Subject& subject, const render::Layout& layout) {
  std::vector<std::string> words;
  for (size_t i = 0; i < subject.given.size(); ++i) {
    const std::string& word = subject.given[i];
    if ((word == "--normals" && layout.fixedNormal) || (word == "--position" && layout.fixedPosition))
      ++i;  // skips its value
    else
      words.push_back(word);
  }
  return words;
}

bool canLight(const Subject& subject, const render::Layout& layout) {
  return layout.hasTargets() || render::missingForComputeRaster(subject.device).empty();
}

bool canLight(const Subject& subject, const render::TechniqueInfo& technique) {
  if (technique.draws && !subject.device.hasGraphics()) return false;
  try {
    render::checkSettings(settingsFor(subject, technique));
  } catch (const latelight::Error&) {
    return false;
  }
  return true;
}

render::Settings settingsFor(const Subject& subject, const render::Layout& layout) {
  render::Settings settings = subject.settings;
  settings.layout = &layout;
  const bool drawn = layout.hasTargets();
  // Forward techniques have no layout to compare.
  if (settings.lighting->forward || (settings.lighting->draws && !drawn))
    settings.lighting = render::Settings().lighting;
  if (!drawn) settings.raster = render::Raster::Compute;
  return settings;
}

render::Settings settingsFor(const Subject& subject, const render::TechniqueInfo& technique) {
  render::Settings settings = subject.settings;
  settings.lighting = &technique;
  if (technique.draws && !technique.forward && !settings.layout->hasTargets())
    settings.layout = render::Settings().layout;
  return settings;
}

std::string scenePage(const Subject& subject) {
  return ScenePage(subject).build();
}

}  // namespace latelight::report
