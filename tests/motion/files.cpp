#include "motion/files.h"

#include <cmath>

namespace latelight::render::test {

using glm::vec2;
using glm::vec3;
using glm::vec4;
using scene::test::GltfBuilder;
using scene::test::json;
using namespace scene::test;

namespace {

json animate(GltfBuilder& b, int node, const char* path, const std::vector<float>& times, int output,
             const char* interpolation) {
  const int input = b.accessor(b.view(times), kFloat, "SCALAR", times.size());
  return {{"channels", {{{"sampler", 0}, {"target", {{"node", node}, {"path", path}}}}}},
          {"samplers", {{{"input", input}, {"output", output}, {"interpolation", interpolation}}}}};
}

int floats(GltfBuilder& b, const std::vector<float>& values) {
  return b.accessor(b.view(values), kFloat, "SCALAR", values.size());
}

// A grid over [-1, 1]^2 in the XY plane, facing +Z.
json grid(GltfBuilder& b, int cells, std::vector<vec3>& positions) {
  std::vector<uint16_t> indices;
  for (int y = 0; y <= cells; ++y)
    for (int x = 0; x <= cells; ++x) positions.emplace_back(2.0f * x / cells - 1, 2.0f * y / cells - 1, 0);
  for (int y = 0; y < cells; ++y)
    for (int x = 0; x < cells; ++x) {
      const int a = y * (cells + 1) + x, c = a + cells + 1;
      for (int i : {a, a + 1, c + 1, a, c + 1, c}) indices.push_back(uint16_t(i));
    }
  return {{"attributes",
           {{"POSITION", b.positions(positions)},
            {"NORMAL", b.vectors(std::vector<vec3>(positions.size(), vec3(0, 0, 1)))}}},
          {"indices", b.accessor(b.view(indices), kUnsignedShort, "SCALAR", indices.size())}};
}

}  // namespace

GltfBuilder movingBox(float away, float half) {
  GltfBuilder b;
  std::vector<vec3> corners;
  for (int i = 0; i < 8; ++i) corners.emplace_back(i & 1 ? 1 : -1, i & 2 ? 1 : -1, i & 4 ? 1 : -1);
  const std::vector<uint16_t> faces = {0, 2, 3, 0, 3, 1, 4, 5, 7, 4, 7, 6, 0, 1, 5, 0, 5, 4,
                                       2, 6, 7, 2, 7, 3, 0, 4, 6, 0, 6, 2, 1, 3, 7, 1, 7, 5};
  b.mesh({{"attributes", {{"POSITION", b.positions(corners)}}},
          {"indices", b.accessor(b.view(faces), kUnsignedShort, "SCALAR", faces.size())}});
  std::vector<vec3> wall;
  const int square = b.add("meshes", {{"primitives", json::array({grid(b, 1, wall)})}});
  b.node({{"mesh", square}, {"translation", {0, 0, -away}}, {"scale", {half, half, 1}}});
  json animation =
      animate(b, 0, "rotation", {0, 1},
              b.vectors(std::vector<vec4>{{0, 0, 0, 1}, {0, std::sqrt(0.5f), 0, std::sqrt(0.5f)}}), "LINEAR");
  json slide = animate(b, 0, "translation", {0, 1}, b.positions({{-1, 0, 0}, {1, 0.5f, 1}}), "LINEAR");
  slide["channels"][0]["sampler"] = 1;
  animation["channels"].push_back(slide["channels"][0]);
  animation["samplers"].push_back(slide["samplers"][0]);
  animation["name"] = "roll";
  b.add("animations", animation);
  return b;
}

GltfBuilder morphingSquare() {
  GltfBuilder b;
  std::vector<vec3> positions;
  json primitive = grid(b, 4, positions);
  std::vector<vec3> deltas, tilts;
  for (const vec3& p : positions) {
    deltas.emplace_back(0.3f * p.y, 0, 1 - p.x * p.x);
    tilts.emplace_back(p.x, 0, -0.2f);
  }
  primitive["targets"] = {{{"POSITION", b.positions(deltas)}, {"NORMAL", b.vectors(tilts)}}};
  b.mesh(primitive);
  b.add("animations", animate(b, 0, "weights", {0, 1}, floats(b, {0, 0, 0.5f, -0.5f, 1, 0}), "CUBICSPLINE"));
  return b;
}

GltfBuilder bendingStrip() {
  GltfBuilder b;
  std::vector<vec3> positions;
  json primitive = grid(b, 8, positions);
  std::vector<uint8_t> first, second;
  std::vector<uint16_t> firstWeights;
  std::vector<vec4> secondWeights;
  for (const vec3& p : positions) {
    const float upper = glm::smoothstep(-0.5f, 0.5f, p.y);
    first.insert(first.end(), {0, 1, 0, 0});
    second.insert(second.end(), {1, 0, 0, 0});
    const auto code = [](float x) { return uint16_t(std::lround(x * 65535)); };
    firstWeights.insert(firstWeights.end(), {code(1 - upper), code(upper * 0.5f), 0, 0});
    secondWeights.emplace_back(upper * 0.5f, 0, 0, 0);
  }
  const size_t count = positions.size();
  json& attributes = primitive["attributes"];
  attributes["JOINTS_0"] = b.accessor(b.view(first), kUnsignedByte, "VEC4", count);
  attributes["JOINTS_1"] = b.accessor(b.view(second), kUnsignedByte, "VEC4", count);
  attributes["WEIGHTS_0"] = b.accessor(b.view(firstWeights), kUnsignedShort, "VEC4", count);
  attributes["WEIGHTS_1"] = b.vectors(secondWeights);
  b.root["accessors"][attributes["WEIGHTS_0"].get<size_t>()]["normalized"] = true;
  b.mesh(primitive);
  b.root["nodes"][0]["skin"] = 0;
  b.root["nodes"][0]["translation"] = {50, 60, 70};  // ignored, because the mesh is skinned
  b.node({{"name", "lower"}, {"children", {2}}});
  b.add("nodes", {{"name", "upper"}});
  b.add("skins", {{"joints", {1, 2}}});
  const std::vector<int16_t> turns = {0, 0, 0, 32767, 23170, 0, 0, 23170};
  const int output = b.accessor(b.view(turns), kShort, "VEC4", 2);
  b.root["accessors"][size_t(output)]["normalized"] = true;
  b.add("animations", animate(b, 2, "rotation", {0, 1}, output, "LINEAR"));
  return b;
}

}  // namespace latelight::render::test
