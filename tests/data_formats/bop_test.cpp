// Objects of a BOP set that share a model. Poses transform the model's vertices to those of the object.
#include <gmock/gmock.h>

#include <cmath>
#include <fstream>

#include "base/error.h"
#include "data_formats/support.h"
#include "labels/shape.h"
#include "scene/scene_builder.h"

namespace latelight::data::test {
namespace {

using glm::dmat4, glm::dvec3, glm::dvec4;
using testing::ElementsAre;
using testing::HasSubstr;

// A mesh without symmetries, so that every rotation is observable.
scene::Mesh tetrahedron(dvec3 tip = {0.2, 0.3, 0.9}) {
  scene::Mesh mesh{.name = "geometry_0"};
  mesh.positions = {{0, 0, 0}, {1, 0.1f, 0}, {0.1f, 0.6f, 0.05f}, glm::vec3(tip)};
  mesh.attributes.resize(4);
  mesh.indices = {0, 2, 1, 0, 1, 3, 1, 2, 3, 2, 0, 3};
  mesh.boundsMin = mesh.boundsMax = mesh.positions[0];
  for (const glm::vec3 p : mesh.positions)
    mesh.boundsMin = glm::min(mesh.boundsMin, p), mesh.boundsMax = glm::max(mesh.boundsMax, p);
  return mesh;
}

// Rotates about an axis that is not parallel to any axis of the mesh.
glm::mat4 turned(double angle, dvec3 scale, dvec3 at) {
  const dvec3 k = glm::normalize(dvec3(1, 2, -0.5));
  const double c = std::cos(angle), s = std::sin(angle);
  dmat4 m(1);
  for (int column = 0; column < 3; ++column) {
    dvec3 axis(0);
    axis[column] = 1;
    // Rodrigues' formula.
    m[column] = dvec4((axis * c + glm::cross(k, axis) * s + k * glm::dot(k, axis) * (1 - c)) * scale[column], 0);
  }
  m[3] = dvec4(at, 1);
  return glm::mat4(m);
}

class BopTest : public FormatsTest {
 protected:
  struct Placed {
    const char* name;
    uint32_t mesh;
    glm::mat4 local;
  };

  static scene::Scene sceneOf(const std::vector<scene::Mesh>& meshes, const std::vector<Placed>& placed) {
    scene::SceneBuilder builder("test");
    builder.scene.meshes = meshes;
    builder.scene.materials.push_back(scene::plainMaterial("grey", {0.5f, 0.5f, 0.5f}, 0, 1));
    builder.scene.materials[0].data.id = 1;
    for (const Placed& p : placed)
      builder.scene.nodes[builder.addInstance(p.name, 0, p.mesh, 0, p.local)].mesh = meshes[p.mesh].name;
    return std::move(builder.scene);
  }

  // Returns the entry of a frame, and the set that consists of it.
  Json frameOf(const scene::Scene& scene, const Json& options = Json::object()) {
    Studio studio(device(), scene);
    const auto format = make("bop", options);
    const scene::Camera camera = render::test::frontPerspective(shared::kPi / 2, 8);
    const DataFrame frame = studio.frame(camera, 128, 128, {format.get()});
    worldToCamera = glm::inverse(frame.metadata.camera.cameraToWorld);
    return format->writeFrame(frame, folder).entry;
  }
  std::vector<uint32_t> idsOf(const std::vector<Json>& entries, const Json& options = Json::object()) {
    make("bop", options)->writeSet({entries}, folder);
    const Json poses = json("train/000000/scene_gt.json");
    std::vector<uint32_t> ids;
    for (const auto& [image, objects] : poses.items())
      for (const Json& object : objects) ids.push_back(object["obj_id"].get<uint32_t>());
    return ids;
  }
  // Sorted by the objects' ids, as in a frame.
  static std::vector<std::string> nodesOf(const Json& entry) {
    std::vector<std::string> nodes;
    for (const Json& object : entry["objects"]) nodes.push_back(object["node"].get<std::string>());
    return nodes;
  }
  std::map<std::string, uint32_t> idsByNode(const Json& entry, const Json& options = Json::object()) {
    const std::vector<uint32_t> ids = idsOf({entry}, options);
    std::map<std::string, uint32_t> byNode;
    for (size_t i = 0; i < ids.size(); ++i) byNode[nodesOf(entry)[i]] = ids[i];
    return byNode;
  }
  std::string written(const std::string& name, const Json& content) {
    std::ofstream(folder / name) << content.dump();
    return (folder / name).string();
  }

  dmat4 worldToCamera{1};
};

TEST_F(BopTest, CopiesThatAreTurnedShareAModel) {
  std::vector<Placed> placed;
  std::vector<std::string> names;
  for (int i = 0; i < 12; ++i) names.push_back("copy" + std::to_string(i));
  for (int i = 0; i < 12; ++i)
    placed.push_back(
        {names[size_t(i)].c_str(), 0, turned(0.61 * i, dvec3(0.7), {i % 4 * 2.5 - 3.7, i / 4 * 2.5 - 3, 0.1 * i})});
  const Json entry = frameOf(sceneOf({tetrahedron()}, placed));
  ASSERT_EQ(entry["objects"].size(), 12u);
  EXPECT_THAT(idsOf({entry}), testing::Each(1u));
  EXPECT_EQ(json("models/models_info.json").size(), 1u);
}

TEST_F(BopTest, ShapeSizeAndHandednessTellModelsApart) {
  const scene::Scene scene = sceneOf(
      {tetrahedron(), tetrahedron({0.2, 0.3, 0.8}), tetrahedron()},
      {{"plain", 0, turned(1, dvec3(1), {-5, 0, 0})},
       {"other", 1, turned(1, dvec3(1), {-3, 0, 0})},  // of the same name, in a box of the same width and depth
       {"twin", 2, turned(2, dvec3(1), {-1, 0, 0})},   // the same vertices, as another mesh
       {"large", 0, turned(3, dvec3(1.2), {1, 0, 0})},
       {"mirrored", 0, turned(1, dvec3(-1, 1, 1), {3, 0, 0})},
       {"mirrored too", 0, turned(4, dvec3(1, 1, -1), {5, 0, 0})},  // along another axis: the previous one, rotated
       {"twice", 0, turned(2, dvec3(-1, -1, 1), {-3, 3, 0})},       // two reflections are a rotation
       {"squeezed", 0, turned(2, dvec3(1, 0.5, 1), {0, 3, 0})},
       {"nearly", 0, turned(0.2, dvec3(1.00001), {3, 3, 0})}});  // equal except for rounding
  auto ids = idsByNode(frameOf(scene));
  ASSERT_EQ(ids.size(), 9u);
  EXPECT_EQ(ids["/test/twin"], ids["/test/plain"]);
  EXPECT_EQ(ids["/test/twice"], ids["/test/plain"]);
  EXPECT_EQ(ids["/test/nearly"], ids["/test/plain"]);
  EXPECT_EQ(ids["/test/mirrored too"], ids["/test/mirrored"]);
  const std::set<uint32_t> different{ids["/test/plain"], ids["/test/other"], ids["/test/large"], ids["/test/mirrored"],
                                     ids["/test/squeezed"]};
  EXPECT_EQ(different, (std::set<uint32_t>{1, 2, 3, 4, 5}));
}

TEST(Shapes, OrderOfPartsDoesNotMatter) {
  const labels::Shape::Part first{1, {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0}},
      second{2, {1, 0, 0, 3, 0, 1, 0, 0, 0, 0, 1, 0}}, moved{2, {1, 0, 0, 4, 0, 1, 0, 0, 0, 0, 1, 0}};
  EXPECT_TRUE(labels::isSameShape({{first, second}, 4}, {{second, first}, 4}));
  EXPECT_FALSE(labels::isSameShape({{first, second}, 4}, {{moved, first}, 4}));
  EXPECT_FALSE(labels::isSameShape({{first, second, second}, 4}, {{second, first, first}, 4}));
}

// The model has the vertices of its first object: the mesh with the scale in its own frame. Each pose transforms them
// to the vertices that the node's matrix produces from the mesh.
TEST_F(BopTest, PosesTakeTheModelToEachObject) {
  std::vector<Placed> placed{{"a", 0, turned(0.4, {0.8, 1.1, 0.6}, {-4, 1, 0})},
                             {"b", 0, turned(2.9, {0.8, 1.1, 0.6}, {0, -1, 0.5})},
                             {"c", 0, turned(5.1, {-0.8, -1.1, 0.6}, {4, 2, 0})},
                             {"m", 0, turned(1.7, {-0.8, 1.1, 0.6}, {-2, -4, 0})},
                             {"n", 0, turned(3.3, {0.8, 1.1, -0.6}, {3, -4, 0})}};
  const scene::Scene scene = sceneOf({tetrahedron()}, placed);
  const Json entry = frameOf(scene);
  const std::vector<uint32_t> ids = idsOf({entry});
  const Json models = json("models/models.json"), poses = json("train/000000/scene_gt.json")["0"];
  ASSERT_EQ(models.size(), 2u);
  for (size_t i = 0; i < ids.size(); ++i) {
    const Json& model = *std::ranges::find_if(models, [&](const Json& m) { return m["obj_id"] == ids[i]; });
    const auto rows = model["shape"]["parts"][0]["place"].get<std::vector<double>>();
    const auto r = poses[i]["cam_R_m2c"].get<std::vector<double>>(),
               t = poses[i]["cam_t_m2c"].get<std::vector<double>>();
    const std::string node = nodesOf(entry)[i];
    const auto& at = *std::ranges::find_if(placed, [&](const Placed& p) { return node.ends_with(p.name); });
    double determinant =
        r[0] * (r[4] * r[8] - r[5] * r[7]) - r[1] * (r[3] * r[8] - r[5] * r[6]) + r[2] * (r[3] * r[7] - r[4] * r[6]);
    EXPECT_NEAR(determinant, 1, 1e-6) << "a rotation";
    for (const glm::vec3 v : scene.meshes[0].positions) {
      dvec3 inModel, inCamera;
      for (int row = 0; row < 3; ++row)
        inModel[row] = rows[4 * row] * v.x + rows[4 * row + 1] * v.y + rows[4 * row + 2] * v.z + rows[4 * row + 3];
      for (int row = 0; row < 3; ++row)
        inCamera[row] =
            (r[3 * row] * inModel.x + r[3 * row + 1] * inModel.y + r[3 * row + 2] * inModel.z) + t[row] / 1000;
      const dvec3 expected(worldToCamera * dmat4(at.local) * dvec4(v, 1));
      EXPECT_LT(glm::length(inCamera - expected), 1e-4) << node;
    }
  }
}

// Splits agree if one uses the other's list: models in both keep their numbers, and new ones follow.
TEST_F(BopTest, NumbersComeFromAnotherSet) {
  const auto meshes = std::vector{tetrahedron(), tetrahedron({0.2, 0.3, 0.8}), tetrahedron({0.1, 0.1, 0.5})};
  const Json train =
      frameOf(sceneOf(meshes, {{"x", 1, turned(1, dvec3(1), {-3, 0, 0})}, {"y", 2, turned(1, dvec3(1), {3, 0, 0})}}));
  auto first = idsByNode(train);
  const std::string list = written("TRAIN.JSON", json("models/models.json"));
  const Json options{{"models", list}};
  const Json test = frameOf(
      sceneOf(meshes, {{"new", 0, turned(1, dvec3(1), {-3, 0, 0})}, {"old", 2, turned(2, dvec3(1), {3, 0, 0})}}),
      options);
  auto second = idsByNode(test, options);
  EXPECT_EQ(second["/test/old"], first["/test/y"]);
  EXPECT_EQ(second["/test/new"], 3u);
  // The numbers of models that are not visible stay reserved.
  EXPECT_EQ(json("models/models_info.json").size(), 3u);
  EXPECT_EQ(json("models/models.json").size(), 3u);
  // Without the list, the same objects may get other numbers.
  EXPECT_EQ(idsOf({test}).size(), 2u);
}

TEST_F(BopTest, NumbersComeFromRules) {
  const scene::Scene scene =
      sceneOf({tetrahedron(), tetrahedron({0.2, 0.3, 0.8})}, {{"wheel left", 0, turned(1, dvec3(1), {-4, 0, 0})},
                                                              {"wheel right", 0, turned(2, dvec3(1), {-1, 0, 0})},
                                                              {"door", 1, turned(1, dvec3(1), {2, 0, 0})},
                                                              {"floor", 1, turned(1, dvec3(2), {4, 0, 0})}});
  const Json options{{"models", {{"/wheel", 7}, {"door$", 3}}}};
  const Json entry = frameOf(scene, options);
  auto ids = idsByNode(entry, options);
  EXPECT_EQ(ids,
            (std::map<std::string, uint32_t>{{"/test/wheel left", 7}, {"/test/wheel right", 7}, {"/test/door", 3}}))
      << "the floor is none of them";
  const Json wrong{{"models", {{"/wheel|door", 7}}}};
  const Json both = frameOf(scene, wrong);
  try {
    idsOf({both}, wrong);
    ADD_FAILURE() << "two shapes have one number";
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ExitCode::BadInput);
    EXPECT_THAT(error.what(), HasSubstr("gives the obj_id 7 to"));
  }
}

TEST_F(BopTest, RefusesOtherMappings) {
  const std::string noList = written("a.json", {{{"obj_id", 1}}}), noJson = (folder / "missing.json").string();
  const std::pair<Json, const char*> wrongs[] = {
      {7, "takes an object"},           {"models.txt", "takes an object"}, {Json::object(), "takes an object"},
      {{{"a", 0}}, "takes an object"},  {{{"a", 3e9}}, "takes an object"}, {{{"(", 1}}, "no regular expression"},
      {noList, "is no list of models"}, {noJson, "missing.json"}};
  for (const auto& [models, says] : wrongs) try {
      make("bop", {{"models", models}});
      ADD_FAILURE() << models;
    } catch (const Error& error) {
      EXPECT_THAT(error.what(), HasSubstr(says)) << models;
    }
}

// Whatever the order of a mesh's vertices and triangles in its lists.
TEST(GeometryHash, FollowsVerticesAndTriangles) {
  const std::vector<glm::vec3> a{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}},
      b{{0, 0, 1}, {-0.0f, 1, 0}, {1, 0, 0}, {0, 0, 0}, {1, 0, 0}};
  const std::vector<uint32_t> of_a{0, 1, 2, 0, 2, 3}, of_b{1, 0, 3, 3, 4, 1};
  EXPECT_EQ(labels::geometryHash(a, of_a), labels::geometryHash(b, of_b));
  EXPECT_NE(labels::geometryHash(a, of_a), labels::geometryHash(a, std::vector<uint32_t>{0, 2, 1, 0, 2, 3}))
      << "turned inside out";
  EXPECT_NE(labels::geometryHash(a, of_a), labels::geometryHash(a, std::vector<uint32_t>{0, 1, 2, 0, 1, 3}))
      << "joined otherwise";
}

}  // namespace
}  // namespace latelight::data::test
