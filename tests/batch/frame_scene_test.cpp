// The scene of a frame that `latelight export --job` writes.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstring>
#include <glm/gtc/type_ptr.hpp>
#include <glm/mat4x4.hpp>
#include <map>
#include <nlohmann/json.hpp>

#include "batch/sets.h"

namespace latelight::data {
namespace {

using app::Folder;
using app::latelight;
using app::Outcome;
using nlohmann::json;

// A node without a mesh, above a triangle, above another node without a mesh. `more` are further members of the file.
void writeHinge(const Folder& folder, const std::string& more = "") {
  const float values[] = {-0.5f, -0.5f, 0, 0.5f, -0.5f, 0, 0, 0.5f, 0, 0, 1, 0, 0, 0, 0, 3, 0};
  folder.write("hinge.bin", std::string_view(reinterpret_cast<const char*>(values), sizeof(values)));
  folder.write("hinge.gltf", R"({"asset": {"version": "2.0"}, "scenes": [{"nodes": [0]}],
    "nodes": [{"name": "hinge", "children": [1]}, {"name": "door", "mesh": 0, "children": [2]},
              {"name": "tip", "translation": [0, 0.7, 0]}],
    "buffers": [{"uri": "hinge.bin", "byteLength": 68}],
    "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}],
    "bufferViews": [{"buffer": 0, "byteLength": 36}, {"buffer": 0, "byteOffset": 36, "byteLength": 8},
                    {"buffer": 0, "byteOffset": 44, "byteLength": 24}],
    "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3", "min": [-0.5, -0.5, 0],
      "max": [0.5, 0.5, 0]}, {"bufferView": 1, "componentType": 5126, "count": 2, "type": "SCALAR", "min": [0],
      "max": [1]}, {"bufferView": 2, "componentType": 5126, "count": 2, "type": "VEC3"}])" +
                                 more + "}");
}

// Returns where the nodes of an exported frame are, by name.
std::map<std::string, glm::dvec3> placesIn(const Folder& folder, const json& job, const char* frame = "0") {
  folder.write("job.json", job.dump());
  const Outcome outcome = latelight(
      {.arguments = {"export", "--job", "job.json", "--frame", frame, "-o", "frame.glb"}, .folder = folder.path()});
  EXPECT_EQ(outcome.code, 0) << outcome.text();
  const std::string glb = folder.read("frame.glb");
  uint32_t bytes = 0;
  std::memcpy(&bytes, &glb.at(12), sizeof(bytes));
  const json root = json::parse(glb.substr(20, bytes)), nodes = root["nodes"];
  std::map<std::string, glm::dvec3> places;
  const auto visit = [&](const auto& self, size_t i, const glm::dmat4& parent) -> void {
    glm::dmat4 local(1);
    if (nodes[i].contains("matrix")) local = glm::make_mat4(nodes[i]["matrix"].get<std::vector<double>>().data());
    if (nodes[i].contains("translation"))
      for (int axis = 0; axis < 3; ++axis) local[3][axis] = nodes[i]["translation"][static_cast<size_t>(axis)];
    places[nodes[i]["name"]] = glm::dvec3((parent * local)[3]);
    for (const size_t child : nodes[i].value("children", std::vector<size_t>())) self(self, child, parent * local);
  };
  for (const size_t node : root["scenes"][0]["nodes"]) visit(visit, node, glm::dmat4(1));
  return places;
}

std::map<std::string, glm::dvec3> placesOf(const Folder& folder, const char* variation) {
  const json camera{{"type", "list"}, {"cameras", {{{"eye", {0, 0, 9}}, {"target", {0, 0, 0}}}}}};
  return placesIn(
      folder, {{"scenes", "hinge.gltf"}, {"cameras", camera}, {"variations", json::array({json::parse(variation)})}});
}

void expectNear(const glm::dvec3& place, const glm::dvec3& expected, const char* name) {
  for (int axis = 0; axis < 3; ++axis) EXPECT_NEAR(place[axis], expected[axis], 1e-6) << name;
}

// Nodes without meshes move with the meshes above and below them.
TEST(FrameScene, NodesWithoutMeshesAreWhereTheVariationPutsThem) {
  const Folder folder;
  writeHinge(folder);
  const auto places = placesOf(folder, R"({"type": "transforms", "nodes": "hinge", "translation": [2, 0, 0]})");
  expectNear(places.at("hinge"), {2, 0, 0}, "hinge");
  expectNear(places.at("door"), {2, 0, 0}, "door");
  expectNear(places.at("tip"), {2, 0.7, 0}, "tip");
}

// The animation lifts the door by 3 m per second.
TEST(FrameScene, NodesWithoutMeshesMoveInAnAnimatedScene) {
  const Folder folder;
  writeHinge(folder, R"(, "animations": [{"samplers": [{"input": 1, "output": 2}],
      "channels": [{"sampler": 0, "target": {"node": 1, "path": "translation"}}]}])");
  const auto places = placesOf(folder, R"({"type": "transforms", "nodes": "hinge", "translation": [2, 0, 0]})");
  expectNear(places.at("door"), {2, 0, 0}, "door");
  expectNear(places.at("tip"), {2, 0.7, 0}, "tip");
}

// A camera 2 m in front of a node at (1, 0, 0), which the animation lifts by 3 m per second.
void writeCrane(const Folder& folder) {
  const float values[] = {0, 1, 1, 0, 0, 1, 3, 0};
  folder.write("crane.bin", std::string_view(reinterpret_cast<const char*>(values), sizeof(values)));
  folder.write("crane.gltf", std::string_view(R"({"asset": {"version": "2.0"}, "scenes": [{"nodes": [0]}],
    "nodes": [{"name": "crane", "translation": [1, 0, 0], "children": [1]},
              {"name": "seat", "translation": [0, 0, 2], "camera": 0}],
    "cameras": [{"type": "perspective", "name": "eye", "perspective": {"yfov": 0.5, "znear": 0.1}}],
    "buffers": [{"uri": "crane.bin", "byteLength": 32}],
    "bufferViews": [{"buffer": 0, "byteLength": 8}, {"buffer": 0, "byteOffset": 8, "byteLength": 24}],
    "accessors": [{"bufferView": 0, "componentType": 5126, "count": 2, "type": "SCALAR", "min": [0], "max": [1]},
                  {"bufferView": 1, "componentType": 5126, "count": 2, "type": "VEC3"}],
    "animations": [{"samplers": [{"input": 0, "output": 1}],
      "channels": [{"sampler": 0, "target": {"node": 0, "path": "translation"}}]}]})"));
}

// The crane turns by a quarter about Y, which leads from Z to X, and moves by 4 m. The right camera is 0.5 m to the
// right of the left one, which looks along -X.
TEST(FrameScene, CamerasFollowTheNodesThatTheVariationMoves) {
  const Folder folder;
  writeCrane(folder);
  json job{
      {"scenes", "crane.gltf"},
      {"cameras", {{"type", "stereo"}, {"baseline", 0.5}, {"cameras", {{"type", "scene"}}}}},
      {"variations", {{{"type", "transforms"}, {"nodes", "crane"}, {"translation", {0, 4, 0}}, {"rotation", 90}}}}};
  expectNear(placesIn(folder, job).at("eye-left"), {3, 4, 0}, "left");
  expectNear(placesIn(folder, job, "1").at("eye-right"), {3, 4, -0.5}, "right");
  job["options"]["time"] = 0.5;  // the animation no longer moves the crane
  expectNear(placesIn(folder, job).at("eye-left"), {3, 4, 0}, "left");
  expectNear(placesIn(folder, job, "1").at("eye-right"), {3, 4, -0.5}, "right");
  job["variations"][0]["nodes"] = "seat";
  expectNear(placesIn(folder, job).at("eye-left"), {1, 4, 2}, "left");
  job.erase("variations");
  expectNear(placesIn(folder, job).at("eye-left"), {1, 1.5, 2}, "left");
}

}  // namespace
}  // namespace latelight::data
