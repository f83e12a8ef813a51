// The OBJ, PLY and STL files of Debian's assimp-testmodels: as many triangles, and the same bounds, as trimesh 5.2.0
// finds in them (trimesh.load(file, process=False), vertices of faces only).
#include "base/log.h"
#include "mesh_files/support.h"

namespace latelight::scene::test {
namespace {

struct Installed {
  const char* file;
  uint64_t triangles;
  dvec3 low, high;
};

const Installed kInstalled[] = {
    {"OBJ/WusonOBJ.obj", 3732, {-0.459976, -0.000566, -1.622242}, {0.459976, 1.515251, 1.622242}},
    {"OBJ/box.obj", 12, {-0.5, -0.5, -0.5}, {0.5, 0.5, 0.5}},
    {"OBJ/box_longline.obj", 944, {-0.5, -0.5, -0.5}, {0.5, 0.5, 0.5}},
    {"OBJ/box_mat_with_spaces.obj", 12, {-0.5, -0.5, -0.5}, {0.5, 0.5, 0.5}},
    {"OBJ/box_without_lineending.obj", 12, {-0.5, -0.5, -0.5}, {0.5, 0.5, 0.5}},
    {"OBJ/concave_polygon.obj", 64, {-1.146, 1.6575, 1.6055}, {-1.146, 3.1425, 3.0905}},
    {"OBJ/cube_mtllib_after_g.obj", 12, {0, 0, 0}, {1, 1, 1}},
    {"OBJ/cube_usemtl.obj", 12, {0, 0, 0}, {1, 1, 1}},
    {"OBJ/cube_with_vertexcolors.obj", 12, {0, 0, 0}, {1, 1, 1}},
    {"OBJ/cube_with_vertexcolors_uni.obj", 12, {0, 0, 0}, {1, 1, 1}},
    {"OBJ/empty_mat.obj", 256, {-1, -1, -1}, {1, 2.802455, 1}},
    {"OBJ/multiple_spaces.obj", 1, {1, 1, 1}, {3, 3, 3}},
    {"OBJ/regr01.obj", 2710, {-194.1995, -204.5116, 0}, {1442.086, 967.6153, 337.509}},
    {"OBJ/regr_3429812.obj", 4, {0.0418548, 0.961535, 0.0939126}, {0.0498759, 0.964456, 0.0980526}},
    {"OBJ/space_in_material_name.obj", 64, {-1.146, 1.6575, 1.6055}, {-1.146, 3.1425, 3.0905}},
    {"OBJ/spider.obj", 1368, {-92.65524, -42.23383, -106.6912}, {57.93622, 37.50395, 86.6912}},
    {"OBJ/testmixed.obj", 12, {-0.5, -0.5, -0.5}, {0.5, 0.5, 0.5}},
    {"PLY/Wuson.ply", 3732, {-0.459976, -0.000566, -1.622242}, {0.459976, 1.515251, 1.622242}},
    {"PLY/cube.ply", 12, {0, 0, 0}, {1, 1, 1}},
    {"PLY/cube_binary.ply", 12, {0, 0, 0}, {1, 1, 1}},
    {"PLY/cube_uv.ply", 12, {-1, -1.000001, -1}, {1, 1, 1}},
    {"PLY/float-color.ply", 1, {0, 0, 0}, {200, 200, 0}},
    {"STL/3DSMaxExport.STL", 2000, {-27.37004, -2.428122, 9.69857}, {29.6645, 45.91314, 62.34256}},
    {"STL/Spider_ascii.stl", 1368, {-3.114895, -4, -1.649329}, {3.114895, 4, 1.649329}},
    {"STL/Spider_binary.stl", 1368, {-3.114895, -4, -1.649329}, {3.114895, 4, 1.649329}},
    {"STL/Wuson.stl", 3732, {-0.459976, -0.000566, -1.622242}, {0.459976, 1.515251, 1.622242}},
    {"STL/sphereWithHole.stl", 285, {0, 0, 0}, {3, 3, 3}},
    {"STL/triangle.stl", 1, {-1, -1, 0}, {1, 1, 0}},
    {"STL/triangle_with_empty_solid.stl", 1, {-1, -1, 0}, {1, 1, 0}},
    {"STL/triangle_with_two_solids.stl", 2, {-1, -1, 0}, {3, 3, 0}}};

TEST(InstalledMeshFiles, HaveTheTrianglesAndBoundsThatTrimeshFinds) {
  const std::filesystem::path folder = "/usr/share/assimp/models";
  if (!std::filesystem::exists(folder)) GTEST_SKIP() << "assimp-testmodels is not installed";
  setQuiet(true);
  for (const Installed& model : kInstalled) {
    SCOPED_TRACE(model.file);
    const Scene scene = load((folder / model.file).string(), {.upAxis = "z"});
    EXPECT_EQ(scene.triangleCount(), model.triangles);
    const std::vector<dvec3> corners = cornersOf(scene);
    ASSERT_FALSE(corners.empty());
    dvec3 low = corners[0], high = corners[0];
    for (const dvec3& corner : corners) low = glm::min(low, corner), high = glm::max(high, corner);
    const double size = 1e-6 * std::max(glm::length(model.low), glm::length(model.high));
    EXPECT_LT(glm::length(low - model.low), size);
    EXPECT_LT(glm::length(high - model.high), size);
  }
  setQuiet(false);
}

}  // namespace
}  // namespace latelight::scene::test
