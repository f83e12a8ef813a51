// Invalid variations: each one ends with a one-sentence message that names the key.
#include "data_variations/support.h"

namespace latelight::data::test {
namespace {

struct WrongVariation {
  const char* spec;
  const char* says;
};

class WrongVariationTest : public testing::TestWithParam<WrongVariation> {};

TEST_P(WrongVariationTest, IsNamed) {
  try {
    Varied varied(GetParam().spec);
    FAIL() << "nothing was thrown";
  } catch (const Error& error) {
    EXPECT_THAT(error.what(), testing::HasSubstr(GetParam().says));
    EXPECT_EQ(error.code(), std::string_view(error.what()).find("/nowhere") == std::string_view::npos
                                ? ExitCode::Usage
                                : ExitCode::BadInput);
  }
}

constexpr WrongVariation kWrong[] = {
    {R"({})", "variations must be a list of objects, not {}"},
    {R"([4])", "variations[0] must be an object, not 4"},
    {R"([{"type": "weather"}])", "variations[0].type must be one of materials, textures"},
    {R"([{"type": "materials"}])", "variations[0] needs one of \"baseColor\""},
    {R"([{"type": "materials", "materials": "wood", "roughness": 1}])",
     "variations[0].materials: builtin:boxes has no material"},
    {R"([{"type": "materials", "roughness": [0, 1.5]}])",
     "variations[0].roughness[1] must be a number from 0 to 1, not 1.5"},
    {R"([{"type": "materials", "baseColor": [0.5, 0.5]}])", "variations[0].baseColor[0] must be a list of 3 numbers"},
    {R"([{"type": "materials", "baseColor": [[1, 0, 0], [0, 0, 0]]}])", "must list the minimum values first"},
    {R"([{"type": "materials", "roughness": 1, "rougness": 1}])", "variations[0] has the unknown key \"rougness\""},
    {R"([{"type": "textures", "materials": "matte"}])", "variations[0] needs either \"folder\" or \"files\""},
    {R"([{"type": "textures", "folder": "/nowhere/at/all"}])", "cannot read /nowhere/at/all"},
    {R"([{"type": "textures", "files": ["/nowhere/a.png"]}])", "/nowhere/a.png"},
    {R"([{"type": "textures", "slot": "colour", "files": ["/nowhere/a.png"]}])",
     "variations[0].slot must be one of baseColor"},
    {R"([{"type": "lights", "lights": "moon", "intensity": 1}])", "variations[0].lights: builtin:boxes has no light"},
    {R"([{"type": "lights"}])", "variations[0] needs one of \"intensity\""},
    {R"([{"type": "lights", "on": 7}])", "variations[0].on must be a number from 0 to 1, not 7"},
    {R"([{"type": "lights", "temperature": 100}])", "variations[0].temperature must be a number from 1667 to 25000"},
    {R"([{"type": "addedLights", "count": 1, "light": "laser", "intensity": 1}])",
     "variations[0].light must be a type listed by"},
    {R"([{"type": "addedLights", "count": 1.5, "intensity": 1}])", "variations[0].count must be whole numbers"},
    {R"([{"type": "addedLights", "count": 1, "intensity": 1}])", "variations[0] needs \"min\""},
    {R"([{"type": "environments", "environments": "/nowhere/sky.hdr"}])", "there is no environment /nowhere/sky.hdr"},
    {R"([{"type": "environments"}])", "variations[0] needs one of \"environments\""},
    {R"([{"type": "transforms", "nodes": "matte"}])", "variations[0] needs one of \"translation\""},
    {R"([{"type": "transforms", "nodes": "sofa", "scale": 2}])", "variations[0].nodes: builtin:boxes has no node"},
    {R"([{"type": "transforms", "nodes": "matte", "scale": 0}])",
     "variations[0].scale must be a number above 0, not 0"},
    {R"([{"type": "transforms", "nodes": "matte", "rotation": 1, "axis": [0, 0, 0]}])",
     "variations[0].axis must not be zero"},
    {R"([{"type": "visibility", "nodes": "matte"}])", "variations[0] needs either \"probability\" or \"visible\""},
    {R"([{"type": "visibility", "nodes": "matte", "probability": 2}])",
     "variations[0].probability must be a number from 0 to 1"},
    {R"([{"type": "visibility", "nodes": "matte", "visible": [0, 2]}])",
     "variations[0].visible[1] must be a number from 0 to 1"},
    {R"([{"type": "scatter", "objects": [{}], "count": 1, "on": "floor"}])",
     "variations[0].objects[0] needs either \"node\" or \"file\""},
    {R"([{"type": "scatter", "objects": [{"node": "sofa"}], "count": 1, "on": "floor"}])",
     "variations[0].objects[0].node: "},
    {R"([{"type": "scatter", "objects": [{"file": "/nowhere/a.glb"}], "count": 1, "on": "floor"}])", "/nowhere/a.glb"},
    {R"([{"type": "scatter", "objects": [{"file": "builtin:boxes", "unit": "cm"}], "count": 1, "on": "floor"}])",
     "variations[0].objects[0].unit is for .obj, .ply and .stl files"},
    {R"([{"type": "scatter", "objects": [{"node": "matte", "unit": "cm"}], "count": 1, "on": "floor"}])",
     "variations[0].objects[0] has the unknown key \"unit\""},
    {R"([{"type": "scatter", "objects": [{"node": "matte"}], "count": 1}])", "variations[0] needs either \"on\""},
    {R"([{"type": "scatter", "objects": [{"node": "matte"}], "count": 1, "on": "floor", "tries": 0}])",
     "variations[0].tries"},
    {R"([{"type": "scatter", "objects": [{"node": "matte"}], "count": 1, "on": "floor", "name": "a/b"}])",
     "variations[0].name must not contain a slash"},
};
INSTANTIATE_TEST_SUITE_P(Jobs, WrongVariationTest, testing::ValuesIn(kWrong));

}  // namespace
}  // namespace latelight::data::test
