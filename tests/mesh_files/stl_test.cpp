// STL files, binary and ASCII, with known corners.
#include "base/log.h"
#include "mesh_files/support.h"

namespace latelight::scene::test {
namespace {

using testing::HasSubstr;

const std::vector<std::array<float, 9>> kFacets = {{0, 0, 0, 1, 0, 0, 0, 2, 0}, {0, 0, 3, 0, 2, 3, 1, 0, 3}};

std::string binaryStl(const std::string& start, const std::vector<std::array<float, 9>>& facets, uint32_t count) {
  std::string text = start;
  text.resize(80, ' ');
  text += bytesOf<uint32_t>({count});
  for (const auto& facet : facets)
    text += std::string(12, '\0') + bytesOf<float>({facet.begin(), facet.end()}) + std::string(2, '\0');
  return text;
}

std::string asciiFacet(const std::array<float, 9>& f) {
  return fmt::format(
      "facet normal 0 0 0\n outer loop\n  vertex {} {} {}\n  vertex {} {} {}\n  vertex {} {} {}\n "
      "endloop\nendfacet\n",
      f[0], f[1], f[2], f[3], f[4], f[5], f[6], f[7], f[8]);
}

void expectFacets(const Scene& scene) {
  const std::vector<dvec3> corners = cornersOf(scene);
  ASSERT_EQ(corners.size(), 6u);
  for (size_t i = 0; i < 6; ++i) {
    const float* expected = &kFacets[i / 3][3 * (i % 3)];
    EXPECT_TRUE(near(corners[i], {expected[0], expected[1], expected[2]})) << i;
  }
}

TEST(Stl, BinaryAndAsciiHaveTheirCorners) {
  const MeshFile binary("a.stl", binaryStl("solid like ASCII facet", kFacets, 2));
  expectFacets(binary.load());
  const MeshFile ascii("a.stl", "solid part\n" + asciiFacet(kFacets[0]) + asciiFacet(kFacets[1]) + "endsolid part\n");
  const Scene scene = ascii.load();
  expectFacets(scene);
  EXPECT_EQ(scene.nodes.back().path, "/a/part");
  const MeshFile upper("a.STL", "SOLID\r\n" + asciiFacet(kFacets[0]) + asciiFacet(kFacets[1]) + "ENDSOLID\r\n");
  expectFacets(upper.load());
}

// The specification separates words by any white space, so lines have no meaning except for the names of solids.
TEST(Stl, AsciiStatementsMayShareLines) {
  const std::string lines = "solid a facet of wood\n" + asciiFacet(kFacets[0]) +
                            "endsolid a facet of wood\nsolid two\n" + asciiFacet(kFacets[1]) + "endsolid two\n";
  std::string oneLine = lines, carriageReturns = lines;
  std::ranges::replace(oneLine, '\n', ' ');
  std::ranges::replace(carriageReturns, '\n', '\r');
  for (const std::string& text : {lines, oneLine, carriageReturns}) {
    const Scene scene = MeshFile("a.stl", text).load();
    ASSERT_EQ(scene.instances.size(), 2u) << text;
    EXPECT_EQ(scene.nodes[scene.instances[0].node].path, "/a/a facet of wood") << text;
    EXPECT_EQ(scene.nodes[scene.instances[1].node].path, "/a/two") << text;
    expectFacets(scene);
  }
  std::string facetOnALine = asciiFacet(kFacets[1]), wordOnALine = asciiFacet(kFacets[1]);
  std::ranges::replace(facetOnALine, '\n', ' ');
  std::ranges::replace(wordOnALine, ' ', '\n');
  for (const std::string& second : {facetOnALine, wordOnALine})
    expectFacets(MeshFile("a.stl", "solid\n" + asciiFacet(kFacets[0]) + second + "\nendsolid\n").load());
}

TEST(Stl, NormalsAreThoseOfTheTriangles) {
  const Scene scene = MeshFile("a.stl", binaryStl("", kFacets, 2)).load();
  const Mesh& mesh = scene.meshes.at(0);
  EXPECT_EQ(mesh.attributes[0].normal, vec3(0, 0, 1));
  EXPECT_EQ(mesh.attributes[3].normal, vec3(0, 0, -1));
}

TEST(Stl, UnitsAndAxesAreThoseOfTheOptions) {
  const MeshFile file("a.stl", binaryStl("", kFacets, 2));
  EXPECT_FALSE(file.load().yUp);
  const Scene scene = file.load({.unit = "mm", .upAxis = "y"});
  EXPECT_TRUE(scene.yUp);
  EXPECT_TRUE(near(cornersOf(scene)[2], {0, 0.002, 0}));
  const dvec3 world = worldBounds(scene).max;  // the world has Z up, so the file's z points toward -y
  EXPECT_TRUE(near(world, {0.001, 0, 0.002}));
  EXPECT_THAT(file.error(ExitCode::Usage, {.unit = "yd"}), HasSubstr("mm, cm, m, in or ft"));
  EXPECT_THAT(file.error(ExitCode::Usage, {.upAxis = "x"}), HasSubstr("y or z"));
  EXPECT_THAT(file.error(ExitCode::Usage, {.variant = "red"}), HasSubstr("variant"));
  EXPECT_THROW(scene::load("builtin:boxes", {.unit = "mm"}), Error);
}

TEST(Stl, EachSolidIsANode) {
  const Scene scene = MeshFile("a.stl", "solid one\n" + asciiFacet(kFacets[0]) + "endsolid one\nsolid two words\n" +
                                            asciiFacet(kFacets[1]) + "endsolid\n")
                          .load();
  ASSERT_EQ(scene.instances.size(), 2u);
  EXPECT_EQ(scene.nodes[scene.instances[0].node].path, "/a/one");
  EXPECT_EQ(scene.nodes[scene.instances[1].node].path, "/a/two words");
  EXPECT_NE(scene.instances[0].id, scene.instances[1].id);
}

// The names are in UTF-8 and in Latin-1.
TEST(Stl, NamesOfSolidsAreUtf8) {
  const MeshFile file("a.stl", "solid S\xc3\xb8\n" + asciiFacet(kFacets[0]) + "endsolid\nsolid B\xe6k\n" +
                                   asciiFacet(kFacets[1]) + "endsolid\n");
  const Scene scene = file.load();
  ASSERT_EQ(scene.nodes.size(), 3u);
  EXPECT_EQ(scene.nodes[1].path, "/a/Sø");
  EXPECT_EQ(scene.nodes[2].path, "/a/Bæk");
}

TEST(Stl, WrongFilesAreReported) {
  EXPECT_THAT(MeshFile("a.stl", binaryStl("", kFacets, 1'000'000'000)).error(), HasSubstr("1000000000 facets"));
  EXPECT_THAT(MeshFile("a.stl", binaryStl("", {}, 0)).error(), HasSubstr("no facets"));
  EXPECT_THAT(MeshFile("a.stl", "").error(), HasSubstr("0 bytes"));
  EXPECT_THAT(MeshFile("a.stl", "solid a\nfacet\nvertex 1 2\n").error(), HasSubstr("line 3"));
  EXPECT_THAT(MeshFile("a.stl", "solid a\nfacet\nvertex 1 2 3\n").error(), HasSubstr("ends within a facet"));
  EXPECT_THAT(MeshFile("a.stl", "solid a\nfacet\nvertex 1 2 3\nendfacet\n").error(), HasSubstr("line 4"));
  EXPECT_THAT(MeshFile("a.stl", "solid a\nfacet\nvertexes 1 2 3\n").error(), HasSubstr("vertexes"));
  EXPECT_THAT(MeshFile("a.stl", "solid a\rfacet\rvertex 1 2 3 4\r").error(), HasSubstr("line 3 contains \"4\""));
  EXPECT_EQ(cornersOf(MeshFile("a.stl",
                               "solid a\nfacet normal -nan(ind) -nan(ind) 1.#QNAN vertex 0 0 0\nvertex 1 0 0\n"
                               "vertex 0 1 0 endfacet")
                          .load())
                .size(),
            3u);
  std::vector<std::array<float, 9>> broken(1, kFacets[0]);
  broken[0][4] = NAN;
  EXPECT_THAT(MeshFile("a.stl", binaryStl("", broken, 1)).error(), HasSubstr("finite"));
  broken.push_back(kFacets[1]);
  EXPECT_EQ(cornersOf(MeshFile("a.stl", binaryStl("", broken, 2)).load()).size(), 3u);
}

// The end of an ASCII file is missing. After complete facets the model may be complete, too.
TEST(Stl, TruncatedAsciiFilesAreReported) {
  const std::string first = "solid a\n" + asciiFacet(kFacets[0]), second = asciiFacet(kFacets[1]),
                    last = "endsolid a\n";
  const auto warningsOf = [](const std::string& text) {
    std::vector<std::string> warnings;
    const WarningCapture capture(warnings);
    MeshFile("a.stl", text).load();
    return warnings;
  };
  EXPECT_THAT(warningsOf(first + second + last), testing::IsEmpty());
  EXPECT_THAT(warningsOf(first + second), testing::ElementsAre(HasSubstr("ends without \"endsolid\"")));
  EXPECT_THAT(warningsOf(first + last + "solid b\n"), testing::ElementsAre(HasSubstr("ends without \"endsolid\"")));
  EXPECT_THAT(MeshFile("a.stl", first + "facet").error(), HasSubstr("ends within a facet"));
  EXPECT_THAT(MeshFile("a.stl", first + "facet normal 0 0\n").error(), HasSubstr("ends within a facet"));
  EXPECT_THAT(MeshFile("a.stl", first + "facet normal 0 0 1\nfacet normal 0 0 1\n").error(),
              HasSubstr("begins a facet"));
  for (size_t size = 1; size < second.size() - 1; ++size)  // the last character is a line end
    EXPECT_NE(MeshFile("a.stl", first + second.substr(0, size)).error(), "") << size;
}

TEST(Stl, ContentsDecideWithoutAnExtension) {
  expectFacets(MeshFile("part", binaryStl("", kFacets, 2)).load());
  EXPECT_EQ(cornersOf(MeshFile("part.txt", "solid a\n" + asciiFacet(kFacets[0])).load()).size(), 3u);
  EXPECT_EQ(cornersOf(MeshFile("part.txt", "# made by hand\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n").load()).size(), 3u);
  EXPECT_THAT(MeshFile("part.txt", "hello").error(), HasSubstr("not a scene file"));
  EXPECT_THAT(MeshFile("robot.urdf", "<robot/>").error(), HasSubstr("from_urdf()"));
  EXPECT_THAT(MeshFile("stage.usda", "#usda 1.0").error(), HasSubstr("from_usd()"));
}

}  // namespace
}  // namespace latelight::scene::test
