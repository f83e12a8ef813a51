// Golden image tests: compare small pictures with stored ones. `LATELIGHT_BLESS=1 test_app --gtest_filter='*Golden*'`
// stores the rendered pictures instead; inspect every picture that it changes.
#include <gtest/gtest.h>

#include <cstdlib>

#include "app/folder.h"
#include "app/process.h"
#include "models/models.h"
#include "output/compare.h"
#include "output/files.h"

namespace latelight::app {
namespace {

using namespace models;
namespace fs = std::filesystem;

// A pixel may differ by two levels, because devices round the G-buffer, textures and exp2 differently. At most this
// share of the pixels may differ by more: there an edge, a mip level or a highlight falls on the other side.
constexpr double kTolerance = 2.0 / 255;
constexpr double kShare = 0.005;

struct Golden {
  const char* name;
  std::string scene;
  std::vector<std::string> options;
};
std::ostream& operator<<(std::ostream& out, const Golden& golden) {
  return out << golden.name;
}

// Half a degree of sun is smaller than a pixel here, so the sun of the panorama spans ten (models.h).
void writeModels(const Folder& folder) {
  folder.write("punctual.glb", punctualModel());
  folder.write("textured.glb", texturedModel());
  folder.write("intricate.glb", intricateModel());
  folder.write("sky.hdr", radiancePanorama(256, 128));
}

fs::path stored(const Golden& golden) {
  return fs::path(LATELIGHT_SOURCE_DIR) / "tests/golden" / (std::string(golden.name) + ".png");
}

// The folder next to the test program into which a failing test writes the picture and the difference.
fs::path failures() {
  return fs::read_symlink("/proc/self/exe").parent_path() / "golden-failures";
}

void keepForTheEye(const Golden& golden, const fs::path& rendered, const output::Picture& difference) {
  fs::create_directories(failures());
  const fs::path base = failures() / golden.name;
  fs::copy_file(rendered, base.string() + ".png", fs::copy_options::overwrite_existing);
  output::writePicture(base.string() + ".difference.png", difference);
}

void expectLike(const Golden& golden, const fs::path& rendered) {
  ASSERT_TRUE(fs::exists(stored(golden))) << "tests/golden has no " << golden.name << ".png: look, then bless";
  const output::ReadImage expected = output::readImage(stored(golden)), actual = output::readImage(rendered);
  const output::CompareOptions options{.tolerance = kTolerance};
  const output::Comparison comparison = output::compare(expected, actual, options);
  if (comparison.share() <= kShare) return;
  const std::vector<double> excesses = output::excesses(expected, actual, options);
  keepForTheEye(golden, rendered, output::differencePicture(expected.width, expected.height, excesses));
  ADD_FAILURE() << golden.name << ": " << comparison.share() * 100 << " % of the pixels are beyond " << kTolerance
                << ", at most " << comparison.maximum << " in " << comparison.worstChannel << " at "
                << comparison.worstX << "," << comparison.worstY << "; see " << (failures() / golden.name).string()
                << ".difference.png";
}

class GoldenTest : public testing::TestWithParam<Golden> {};

TEST_P(GoldenTest, LooksAsStored) {
  const Golden& golden = GetParam();
  Folder folder;
  writeModels(folder);
  std::vector<std::string> arguments{"render", golden.scene, "-o",       "picture.png",
                                     "--size", "160x90",     "--device", "cpu"};
  arguments.insert(arguments.end(), golden.options.begin(), golden.options.end());
  const Outcome outcome = latelight({.arguments = arguments, .folder = folder.path()});
  ASSERT_EQ(outcome.code, 0) << outcome.text();
  const char* bless = std::getenv("LATELIGHT_BLESS");
  if (bless && std::string(bless) == "1") {
    fs::copy_file(folder.at("picture.png"), stored(golden), fs::copy_options::overwrite_existing);
    GTEST_SKIP() << "Blessed " << golden.name << ".png: look at it.";
  }
  expectLike(golden, folder.at("picture.png"));
}

std::string nameOf(const testing::TestParamInfo<Golden>& info) {
  return info.param.name;
}

INSTANTIATE_TEST_SUITE_P(
    Boxes, GoldenTest,
    testing::Values(Golden{"boxes", "builtin:boxes", {}}, Golden{"boxes_xyz", "builtin:boxes", {"--normals", "xyz"}},
                    Golden{"boxes_optimized", "builtin:boxes", {"--layout", "optimized"}},
                    Golden{"boxes_optimized_xyz", "builtin:boxes", {"--layout", "optimized", "--normals", "xyz"}},
                    Golden{"boxes_exact", "builtin:boxes", {"--layout", "exact"}},
                    Golden{"boxes_blinn_phong", "builtin:boxes", {"--shading", "blinn-phong"}},
                    Golden{
                        "boxes_orbit", "builtin:boxes", {"--orbit", "30,25", "--fov", "30", "--background", "#203040"}},
                    Golden{"boxes_smooth", "builtin:boxes", {"--aa", "ss4"}},
                    Golden{"boxes_ids", "builtin:boxes", {"--debug", "id"}},
                    Golden{"boxes_depth", "builtin:boxes", {"--debug", "depth"}},
                    Golden{"boxes_sheet", "builtin:boxes", {"--debug", "sheet"}}),
    nameOf);

INSTANTIATE_TEST_SUITE_P(
    Spheres, GoldenTest,
    testing::Values(Golden{"spheres", "builtin:spheres", {}},
                    Golden{"spheres_aces", "builtin:spheres", {"--exposure", "2", "--tonemap", "aces"}},
                    Golden{"spheres_agx", "builtin:spheres", {"--exposure", "2", "--tonemap", "agx"}},
                    Golden{"spheres_khronos", "builtin:spheres", {"--exposure", "2", "--tonemap", "khronos"}},
                    Golden{"spheres_reinhard", "builtin:spheres", {"--exposure", "2", "--tonemap", "reinhard"}},
                    Golden{"spheres_clamped", "builtin:spheres", {"--exposure", "2", "--tonemap", "none"}},
                    Golden{"spheres_sky", "builtin:spheres", {"--hdri", "sky.hdr", "--background", "hdri"}},
                    Golden{"spheres_sky_turned",
                           "builtin:spheres",
                           {"--hdri", "sky.hdr", "--background", "hdri", "--hdri-rotate", "120", "--hdri-intensity",
                            "0.5"}}),
    nameOf);

INSTANTIATE_TEST_SUITE_P(
    Hall, GoldenTest,
    testing::Values(Golden{"hall", "builtin:hall,triangles=50k", {}},
                    Golden{"hall_smooth", "builtin:hall,triangles=50k,lights=16,seed=2", {"--aa", "ss2"}}),
    nameOf);

INSTANTIATE_TEST_SUITE_P(
    Files, GoldenTest,
    testing::Values(
        Golden{"punctual", "punctual.glb", {}},
        Golden{"punctual_optimized_blinn_phong", "punctual.glb", {"--layout", "optimized", "--shading", "blinn-phong"}},
        Golden{"textured", "textured.glb", {}},
        Golden{"textured_optimized", "textured.glb", {"--layout", "optimized", "--background", "0.5,0.5,0.5"}},
        Golden{"textured_orthographic", "textured.glb", {"--camera", "above/orthographic"}},
        Golden{"textured_normals", "textured.glb", {"--debug", "normal"}}, Golden{"intricate", "intricate.glb", {}},
        Golden{"intricate_blue", "intricate.glb", {"--variant", "blue"}}),
    nameOf);

}  // namespace
}  // namespace latelight::app
