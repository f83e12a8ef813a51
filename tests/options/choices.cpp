#include "options/choices.h"

#include "output/aov.h"
#include "render/gbuffer/layout.h"
#include "render/lighting/technique.h"
#include "render/settings.h"
#include "scene/builtin.h"

namespace latelight::app {

namespace {

using Values = std::vector<std::string>;

template <typename Range>
Values namesIn(const Range& range) {
  Values names;
  for (const auto& entry : range) names.emplace_back(entry.name);
  return names;
}

// The names of a registry, and what is none.
template <typename Range>
Choice oneOf(double share, const Range& range, Rate rate = Rate::Draw) {
  return {share, namesIn(range), {"nothing"}, rate};
}

// Numbers, the ends of what is allowed among them, and those that lie beyond.
Choice number(double share, Values right, Values wrong = {}) {
  wrong.insert(wrong.end(), {"nan", "many"});
  return {share, std::move(right), std::move(wrong)};
}

Choice flag(double share) {
  return {share, {""}, {}};
}

Values antiAliasings() {
  Values names;
  for (const render::AntiAliasing& aa : render::antiAliasings()) names.emplace_back(aa.set ? aa.name : "ss2");
  return names;
}

// Each alone, all, all that PNG has, and lists of two.
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

// The hall is drawn small and with glass; others as they are.
Values scenes(const Values& models) {
  Values names;
  for (const scene::Builtin& builtin : scene::builtins()) {
    std::string name = "builtin:" + std::string(builtin.name);
    if (builtin.name == "hall") name += ",triangles=50k,lights=12,glass=1";
    names.push_back(name);
  }
  for (int i = 0; i < 2; ++i) names.insert(names.end(), models.begin(), models.end());  // they have more to show
  return names;
}

using Table = std::map<std::string, Choice>;

void addScene(Table& t, const Values& models, const std::filesystem::path& folder) {
  t["SCENE"] = {1, scenes(models), {"builtin:nothing"}, Rate::Group};
  t["--variant"] = {0.15, {"red", "blue"}, {"green"}, Rate::Group};
  t["--allow-outside"] = {0.1, {folder.string()}, {}};  // looked at where a file is loaded
  t["--memory"] = {0.1, {"4G", "100G"}, {"0", "much", "-1G"}};
  t["--id-depth"] = {0.15, {"0", "1", "9"}, {"-1", "deep"}, Rate::Group};
  t["--id-nodes"] = {0.15, {"box", "/floor,mirrored", "lower,strip"}, {}, Rate::Group};  // looked for in the scene
  t["--size"] = {1, {"48x27", "48x27", "48x27", "33x17", "7x40", "1x1"}, {"0x9", "20000x9", "48", "-4x4"}};
  t["--camera"] = {0.15, {"0"}, {"99", "nobody"}};
  t["--eye"] = {0.2, {"0.3,1.2,6", "0,1,0.2", "-3,2,3"}, {"1,2", "a,b,c", "nan,0,0"}};
  t["--target"] = {0.15, {"0,0.5,0", "1,1,-1"}, {"1,2"}};
  t["--up"] = {0.1, {"0,1,0", "1,1,0"}, {"0,1"}};
  t["--orbit"] = {0.15, {"30,20", "-120,-10,4", "0,89"}, {"1", "x,y"}};
  t["--fov"] = number(0.2, {"40", "100", "1", "179"}, {"0", "-5", "180", "1e-308"});
  t["--frame"] = {0.1, {"0", "7"}, {"-1", "x"}};
}

void addTime(Table& t) {
  t["--time"] = number(0.3, {"0", "0.7", "-1", "1000"}, {"1e9"});
  t["--frames"] = {0.12, {"0-2", "5", "47-48"}, {"3-1", "x"}};
  t["--fps"] = number(0.15, {"1", "24", "0.001", "10000"}, {"0", "-1", "1e9"});
  t["--animation"] = {0.15, {"0", "all"}, {"nothing"}};
  t["--loop"] = flag(0.15);
  t["--turn"] = number(0.15, {"30", "-720", "1000000"}, {"1e9"});
}

void addLook(Table& t, const std::string& panorama) {
  t["--layout"] = oneOf(0.8, render::layouts(), Rate::Group);
  t["--normals"] = oneOf(0.5, render::normalEncodings(), Rate::Group);
  t["--normal-space"] = oneOf(0.3, render::normalSpaces(), Rate::Group);
  t["--position"] = oneOf(0.4, render::positionMethods(), Rate::Group);
  t["--lighting"] = oneOf(0.9, render::techniques(), Rate::Group);
  t["--shading"] = oneOf(0.3, render::shadings(), Rate::Group);
  t["--volumes-order"] = oneOf(0.3, render::volumesOrders(), Rate::Group);
  t["--transparency"] = oneOf(0.5, render::transparencies(), Rate::Group);
  t["--shadows"] = oneOf(0.6, render::shadowFormats(), Rate::Group);
  t["--shadow-filter"] = oneOf(0.5, render::shadowFilters(), Rate::Group);
  t["--shadow-lights"] = {
      0.3, {"auto", "all", "none", "0", "2", "lamp", "spot,sun"}, {}};  // names are looked for where lights shine
  t["--shadow-atlas"] = {0.3, {"256", "1000", "16384"}, {"255", "16385", "x"}};
  t["--light-size"] = number(0.2, {"0", "0.3", "1e6"}, {"-1", "inf"});
  t["--sun-angle"] = number(0.2, {"0", "5", "90"}, {"-1", "91"});
  t["--sun"] = {0.25, {"30,40", "-60,-10,0", "0,90,1e6"}, {"1", "a,b", "0,0,-1"}};
  t["--aa"] = {0.7, antiAliasings(), {"ss0", "ss17", "msaa"}, Rate::Group};
  t["--anisotropy"] = number(0.2, {"1", "2", "16"}, {"0", "17"});
  t["--anisotropy"].rate = Rate::Group;
  t["--hdri"] = {0.4, {"studio", "none", panorama}, {}, Rate::Group};
  t["--hdri-rotate"] = number(0.15, {"0", "90", "-721.5"}, {"inf"});
  t["--hdri-intensity"] = number(0.15, {"0", "2.5", "1e30"}, {"-1", "inf"});
  t["--exposure"] = number(0.2, {"1.5", "-60", "60"}, {"61", "inf"});
  t["--tonemap"] = oneOf(0.3, render::tonemaps());
  t["--background"] = {0.3, {"transparent", "hdri", "#102030", "0.2,0.3,0.4", "#fff0e0"}, {"#12", "sky", "1,2"}};
}

void addPost(Table& t) {
  t["--ao"] = oneOf(0.3, render::ambientOcclusions(), Rate::Group);
  t["--ao-radius"] = number(0.2, {"0.01", "1", "1e30"}, {"0", "-1"});
  t["--ao-strength"] = number(0.2, {"0", "2", "10"}, {"-1", "11"});
  t["--bloom"] = number(0.3, {"0", "0.05", "1"}, {"-0.1", "1.1"});
  t["--bloom-radius"] = number(0.2, {"0", "0.5", "1"}, {"2"});
  t["--bloom-threshold"] = number(0.2, {"0", "1", "65504"}, {"-1", "1e9"});
  t["--bloom-fireflies"] = oneOf(0.2, render::bloomFireflies());
  t["--fog"] = {0.3, {"0.05", "1e6", "0"}, {"-1", "1e9", "nan"}, Rate::Group};
  t["--fog-color"] = {0.2, {"#ffffff", "0,0,0"}, {"white"}};
  t["--fog-height"] = number(0.2, {"0", "2", "1e6", "1e-30"}, {"-1", "1e9"});
  t["--fog-base"] = number(0.2, {"0", "1", "-1e6"}, {"1e9"});
}

void addOutput(Table& t, const std::filesystem::path& folder) {
  const auto at = [&](const char* name) { return (folder / name).string(); };
  t["--out"] = {0.97,
                {at("o.exr"), at("o.exr"), at("o.exr"), at("o.{aov}.exr"), at("o.{aov}.npy"), at("o.png"), at("o.png"),
                 at("{scene}/o.{aov}.{camera}.png"), "-"},
                {at("o.gif"), at("{x}.png"), at("none/o.png"), folder.string() + "/"}};
  t["--aov"] = {0.7, aovLists(), {"nothing", "color,,depth"}};
  t["--data-surfaces"] = oneOf(0.6, render::dataSurfaces());
  t["--pick"] = {0.12, {"0,0"}, {"99,0", "1", "-1,0"}};
  t["--debug"] = {0.2, debugPictures(), {"nothing"}};
  t["--normal-frame"] = {0.3, {"world", "opencv", "opengl"}, {"file"}};
  t["--axes"] = {0.2, {"file", "z-up"}, {"y-up"}};
  t["--no-side-file"] = flag(0.15);
  t["--device"] = {0.1, {"auto", "cpu", "0"}, {}};  // one is there already: what it names is not looked for
  t["--json"] = flag(0.12);
  t["--dump-graph"] = {0.1, {at("graph.dot")}, {at("none/graph.dot")}};
  t["--validate"] = flag(0.05);  // all runs are under it
}

}  // namespace

std::map<std::string, Choice> choicesIn(const std::filesystem::path& folder, const std::vector<std::string>& models,
                                        const std::string& panorama) {
  Table table;
  addScene(table, models, folder);
  addTime(table);
  addLook(table, panorama);
  addPost(table);
  addOutput(table, folder);
  return table;
}

}  // namespace latelight::app
