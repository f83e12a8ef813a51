#include "options/choices.h"

#include <fmt/format.h>

#include <cmath>

#include "app/render_options.h"
#include "output/aov.h"
#include "render/options/options.h"
#include "scene/builtin/builtin.h"

namespace latelight::app {

namespace {

using Values = std::vector<std::string>;

template <typename Range>
Values namesIn(const Range& range) {
  Values names;
  for (const auto& entry : range) names.emplace_back(entry.name);
  return names;
}

// --- values from the table of options -------------------------------------------------------------------------------

// The limits of a number, its default and a value in between; and values beyond the limits.
Choice numberOf(const render::Option& option) {
  const bool whole = option.kind == render::OptionKind::Integer;
  const render::Range& range = option.range;
  const auto text = [&](double value) { return fmt::format("{}", value); };
  Choice choice{.right = {}, .wrong = {"nan", "many", "inf"}};
  const double least = std::isfinite(range.least) ? range.least : -721.5;
  const double most = std::isfinite(range.most) ? range.most : 1e6;
  if (!range.open) choice.right.push_back(text(least));
  choice.right.push_back(text(whole ? std::floor((least + most) / 2) : least + 0.01 * (most - least)));
  choice.right.push_back(text(most));
  if (!option.defaultValue.empty()) choice.right.push_back(option.defaultValue);
  if (whole) choice.wrong.push_back("1.5");
  if (range.open) choice.wrong.push_back(text(least));
  if (std::isfinite(range.least)) choice.wrong.push_back(text(least - 1));
  if (std::isfinite(range.most)) choice.wrong.push_back(text(most + std::abs(most) / 10));
  return choice;
}

// addTexts() adds the values of texts.
Choice choiceOf(const render::Option& option) {
  Choice choice;
  if (option.kind == render::OptionKind::Flag) {
    choice = {.share = 0.15, .right = {""}, .wrong = {}};
  } else if (option.kind == render::OptionKind::Choice) {
    choice = {.share = 0.4, .right = namesIn(option.names), .wrong = {"nothing"}};
  } else if (option.kind == render::OptionKind::Integer || option.kind == render::OptionKind::Number) {
    choice = numberOf(option);
    choice.share = 0.2;
  }
  if (option.effect == render::OptionEffect::Compiled) choice.rate = Rate::Group;
  return choice;
}

using Table = std::map<std::string, Choice>;

Table tableOf() {
  Table table;
  for (const std::span<const render::Option> options : {commandOptions(), render::options()})
    for (const render::Option& option : options) table[std::string(render::longName(option))] = choiceOf(option);
  return table;
}

// --- values that are not in the table -------------------------------------------------------------------------------

// The shares of options that are given more or less often than others of their kind.
void setShares(Table& t) {
  const std::pair<const char*, double> shares[] = {
      {"--layout", 0.8},        {"--normals", 0.5},       {"--lighting", 0.9}, {"--transparency", 0.5},
      {"--shadows", 0.6},       {"--shadow-filter", 0.5}, {"--time", 0.3},     {"--bloom", 0.3},
      {"--data-surfaces", 0.6}, {"--validate", 0.05},     {"--fog", 0.3},      {"--json", 0.12},
      {"--indirect", 0.15},     {"--ground", 0.15}};
  for (const auto& [name, share] : shares) t.at(name).share = share;
  t.at("--anisotropy").rate = Rate::Group;  // all samplers are recreated
  t.at("--samples").right = {"1"};          // paths take long, and a CPU device refuses many rays
  t.at("--camera-samples").right = {"1", "3"};
  t.at("--readout") = {0.1, {"0", "0.02", "-0.01"}, t.at("--readout").wrong};
  t.at("--bit-depth").right = {"8", "12", "16"};  // of which each has room for these black levels
  t.at("--black-level").right = {"0", "100"};
}

Values antiAliasings() {
  Values names;
  for (const render::AntiAliasingMode& aa : render::antiAliasingModes()) names.emplace_back(aa.sets ? aa.name : "ss2");
  return names;
}

// Each output by itself, all of them, all that PNG supports, and lists of two.
Values aovLists() {
  Values lists = namesIn(output::aovs());
  std::string all, png;
  for (const output::AovInfo& aov : output::aovs()) {
    lists.push_back("color," + std::string(aov.name));
    lists.push_back(std::string(aov.name) + ",lights-used,samples");
    all += (all.empty() ? "" : ",") + std::string(aov.name);
    if (aov.png != output::PngCoding::None) png += (png.empty() ? "" : ",") + std::string(aov.name);
  }
  lists.insert(lists.end(), 6, all);
  lists.insert(lists.end(), 3, png);
  return lists;
}

Values debugPictures() {
  Values pictures = namesIn(output::aovs());
  pictures.insert(pictures.end(), {"sheet", "sheet", "lights", "lights", "targets", "targets", "depth,samples"});
  return pictures;
}

// The hall is rendered small and with glass; the others as they are.
Values scenes(const Values& models) {
  Values names;
  for (const scene::Builtin& builtin : scene::builtins()) {
    std::string name = "builtin:" + std::string(builtin.name);
    if (builtin.name == "hall") name += ",triangles=50k,lights=12,glass=1";
    names.push_back(name);
  }
  // more often, because they contain more
  for (int i = 0; i < 2; ++i) names.insert(names.end(), models.begin(), models.end());
  return names;
}

void addSceneTexts(Table& t, const Values& models, const std::filesystem::path& folder) {
  t["SCENE"] = {1, scenes(models), {"builtin:nothing"}, Rate::Group};
  t["--variant"] = {0.15, {"red", "blue"}, {"green"}, Rate::Group};
  t["--allow-outside"] = {0.1, {folder.string()}, {}};  // checked when a file is loaded
  // These apply to other files than the models, which reject them.
  t["--unit"] = {0, {"mm"}, {}};
  t["--up-axis"] = {0, {"z"}, {}};
  t.at("--point-radius").share = 0;
  t["--memory"] = {0.1, {"4G", "100G"}, {"0", "much", "-1G"}};
  t["--id-depth"] = {0.15, {"0", "1", "9"}, {"-1", "deep"}, Rate::Group};
  t["--id-nodes"] = {0.15, {"box", "/floor,mirrored", "lower,strip"}, {}, Rate::Group};  // must be names in the scene
  t["--size"] = {1, {"48x27", "48x27", "48x27", "33x17", "7x40", "1x1"}, {"0x9", "20000x9", "48", "-4x4"}};
  t["--camera"] = {0.15, {"0"}, {"99", "nobody"}};
  t["--eye"] = {0.2, {"0.3,1.2,6", "0,1,0.2", "-3,2,3"}, {"1,2", "a,b,c", "nan,0,0"}};
  t["--target"] = {0.15, {"0,0.5,0", "1,1,-1"}, {"1,2"}};
  t["--up"] = {0.1, {"0,1,0", "1,1,0"}, {"0,1"}};
  t["--orbit"] = {0.15, {"30,20", "-120,-10,4", "0,89"}, {"1", "x,y"}};
  t["--fov"] = {0.2, {"40", "100", "1", "179"}, {"0", "-5", "180", "1e-308", "nan"}};
  t["--lens"] = {0.1,
                 {"pinhole:40,50,20,13", "opencv:40,40,24,13,-0.2,0.05,0.001,0.002", "fisheye:12,12,24,13,0.01",
                  "equirectangular", "ftheta:1,1,24,13,0,0.05,1e-4"},
                 {"fish", "opencv:1", "fisheye:0,1,2,3", "equirectangular:1", "cubemap:", "pinhole:1,1,nan,1"}};
  t["--frames"] = {0.12, {"0-2", "5", "47-48"}, {"3-1", "x"}};
  t["--frame"] = {0.1, {"0", "7"}, {"-1", "x"}};
  t["--animation"] = {0.15, {"0", "all"}, {"nothing"}};
}

void addPictureTexts(Table& t, const std::string& panorama) {
  t["--exposure"] = {0.2, {"-1.5", "2", "60", "auto", "auto-1"}, {"bright", "61", "auto1", "nan"}};
  t["--shadow-lights"] = {
      0.3, {"auto", "all", "none", "0", "2", "lamp", "spot,sun"}, {}};  // names must belong to lights that shine
  t["--sun"] = {0.25, {"30,40", "-60,-10,0", "0,90,1e6"}, {"1", "a,b", "0,0,-1"}};
  t["--aa"] = {0.7, antiAliasings(), {"ss0", "ss17", "msaa"}, Rate::Group};
  t["--hdri"] = {0.4, {"studio", "none", panorama}, {}, Rate::Group};
  t["--hdri-intensity"].right.push_back("1e30");
  t["--ao-radius"].right.push_back("1e30");
  t["--background"] = {0.3, {"transparent", "hdri", "#102030", "0.2,0.3,0.4", "#fff0e0"}, {"#12", "sky", "1,2"}};
  t["--position-origin"] = {0.2, {"0,0,0", "1,-2.5,3", "500000.25,0,-4600000"}, {"1,2", "a,b,c", "1,2,nan"}};
  t["--aperture"] = {0.2, {"pinhole", "f/2", "0.05"}, {"f/0", "wide", "-1", "101"}};
  t["--vignetting"] = {0.15, {"none", "cos4", "-0.3,-0.1", "0.2,-0.5,0.1"}, {"cos", "1,2,3,4", "nan"}};
  t["--white-balance"] = {0.15, {"1,1,1", "2,1,1.5"}, {"1,1", "-1,1,1"}};
  t["--response"] = {0.15, {"display", "gamma:2.2", "0,0.7,0.9,1"}, {"gamma:0", "0.5", "0,2"}};
  t["--fog-color"] = {0.2, {"#ffffff", "0,0,0"}, {"white"}};
}

void addOutputTexts(Table& t, const std::filesystem::path& folder) {
  const auto at = [&](const char* name) { return (folder / name).string(); };
  t["--out"] = {0.97,
                {at("o.exr"), at("o.exr"), at("o.exr"), at("o.{aov}.exr"), at("o.{aov}.npy"), at("o.png"), at("o.png"),
                 at("{scene}/o.{aov}.{camera}.png"), "-"},
                {at("o.gif"), at("{x}.png"), at("none/o.png"), folder.string() + "/"}};
  t["--aov"] = {0.7, aovLists(), {"nothing", "color,,depth"}};
  t["--labels"] = {
      0.12, {at("l.json"), at("{scene}/l.{camera}.json")}, {at("l.txt"), at("l.{aov}.json"), at("none/l.json")}};
  t["--keypoints"] = {0.08, {R"([{"name": "center"}])"}, {"[]", "[1", at("none.json")}};
  t["--correspond"] = {
      0.12, {at("c.npz"), at("{scene}/c.{camera}.exr")}, {at("c.npy"), at("c.{aov}.npz"), at("none/c.npz"), "-"}};
  t["--to"] = {0.06, {"next", "previous", "+3", "-2"}, {"0", "nearest", "1.5"}};
  t["--to-time"] = {0.06, {"0", "0.7", "-3"}, {"nan", "soon", "1e7"}};
  t["--to-camera"] = {0.06, {"0"}, {"99", "nobody"}};
  t["--to-eye"] = {0.08, {"0.4,1.2,6", "-3,2,3"}, {"1,2", "a,b,c", "nan,0,0"}};
  t["--to-target"] = {0.06, {"0,0.5,0", "1,1,-1"}, {"1,2"}};
  t["--pick"] = {0.12, {"0,0"}, {"99,0", "1", "-1,0"}};
  t["--debug"] = {0.2, debugPictures(), {"nothing"}};
  t["--device"] = {0.1, {"auto", "cpu", "0"}, {}};  // one exists already, so the name is not searched for
  t["--dump-graph"] = {0.1, {at("graph.dot")}, {at("none/graph.dot")}};
}

}  // namespace

std::map<std::string, Choice> choicesIn(const std::filesystem::path& folder, const std::vector<std::string>& models,
                                        const std::string& panorama) {
  Table table = tableOf();
  setShares(table);
  addSceneTexts(table, models, folder);
  addPictureTexts(table, panorama);
  addOutputTexts(table, folder);
  return table;
}

}  // namespace latelight::app
