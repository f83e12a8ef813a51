// Models that deform: by a skin, and by morph targets.
#include <cmath>
#include <glm/gtc/constants.hpp>

#include "models/parts.h"

namespace latelight::models {

namespace {

using glm::vec2;
using glm::vec3;
using glm::vec4;
using namespace scene::test;

constexpr int kJoints = 4;
constexpr float kJointLength = 0.5f;

// Its lower end on the ground, its upper end a dome; its axis is Y.
Shape worm() {
  Shape s = sphere(24, 36);
  for (size_t i = 0; i < s.positions.size(); ++i) {
    const float height = kJoints * kJointLength, y = height * (1 - s.uv[i].y);
    const float radius = 0.3f * std::sqrt(std::min(1.0f, 1.001f - std::pow(std::abs(y - 0.9f) / 1.1f, 6.0f)));
    const float azimuth = glm::two_pi<float>() * s.uv[i].x;  // at the poles, too, unlike that of the normal
    const vec2 around(-std::sin(azimuth), -std::cos(azimuth));
    s.positions[i] = {radius * around.x, y, radius * around.y};
    s.normals[i] = glm::normalize(vec3(around.x, 0.4f * std::pow((y - 0.9f) / 1.1f, 5.0f), around.y));
  }
  return s;
}

// Two joints a vertex: those between whose middles it lies.
void addWeights(GltfBuilder& file, json& primitive, const Shape& shape) {
  std::vector<uint8_t> joints;
  std::vector<vec4> weights;
  for (const vec3 p : shape.positions) {
    const float at = glm::clamp(p.y / kJointLength - 0.5f, 0.0f, kJoints - 1.001f);
    const auto lower = static_cast<uint8_t>(at);
    joints.insert(joints.end(), {lower, static_cast<uint8_t>(lower + 1), 0, 0});
    weights.emplace_back(1 - glm::fract(at), glm::fract(at), 0, 0);
  }
  primitive["attributes"]["JOINTS_0"] = file.accessor(file.view(joints), kUnsignedByte, "VEC4", weights.size());
  primitive["attributes"]["WEIGHTS_0"] = file.vectors(weights);
}

// A chain of joints as nodes, each above the last: the index of the lowest.
int addJoints(GltfBuilder& file) {
  const int first = file.node({{"name", "joint 0"}, {"children", json::array()}});
  for (int i = 1; i < kJoints; ++i) {
    const int joint =
        file.add("nodes", {{"name", "joint " + std::to_string(i)}, {"translation", {0, kJointLength, 0}}});
    file.root["nodes"][joint - 1]["children"] = {joint};
  }
  std::vector<float> matrices;
  for (int i = 0; i < kJoints; ++i)
    for (int k = 0; k < 16; ++k)
      matrices.push_back(k == 13 ? -kJointLength * static_cast<float>(i) : k % 5 == 0 ? 1.0f : 0.0f);
  json all = json::array();
  for (int i = 0; i < kJoints; ++i) all.push_back(first + i);
  file.add("skins",
           {{"joints", all}, {"inverseBindMatrices", file.accessor(file.view(matrices), kFloat, "MAT4", kJoints)}});
  return first;
}

// Every joint turns about `axis` to one side, the other, and back, in a second.
void addSway(GltfBuilder& file, const char* name, int firstJoint, vec3 axis, float degrees) {
  const std::vector<float> times{0, 0.25f, 0.75f, 1};
  const int input = file.accessor(file.view(times), kFloat, "SCALAR", times.size());
  std::vector<vec4> turns;
  for (const float part : {0, 1, -1, 0}) {
    const float half = glm::radians(part * degrees) / 2;
    turns.emplace_back(axis * std::sin(half), std::cos(half));
  }
  json animation{{"name", name}, {"samplers", {{{"input", input}, {"output", file.vectors(turns)}}}}};
  for (int i = 0; i < kJoints; ++i)
    animation["channels"].push_back({{"sampler", 0}, {"target", {{"node", firstJoint + i}, {"path", "rotation"}}}});
  file.add("animations", animation);
}

int checkered(GltfBuilder& file, const char* name) {
  const Picture picture = paint(64, 32, [](vec2 uv) {
    const bool light = (static_cast<int>(uv.x * 12) + static_cast<int>(uv.y * 12)) % 2 == 0;
    return light ? vec4(0.85, 0.8, 0.4, 1) : vec4(0.3, 0.5, 0.25, 1);
  });
  const int texture = addTexture(file, picture, PictureKind::Jpeg);
  return file.add("materials",
                  {{"name", name},
                   {"pbrMetallicRoughness",
                    {{"baseColorTexture", {{"index", texture}}}, {"metallicFactor", 0}, {"roughnessFactor", 0.6}}}});
}

}  // namespace

Bytes skinnedModel(glm::dvec3 foot, bool animated) {
  GltfBuilder file;
  const Shape shape = worm();
  json skinned = primitive(file, shape, checkered(file, "scales"));
  addWeights(file, skinned, shape);
  const int shown = file.add("meshes", {{"primitives", json::array({skinned})}});
  const int first = addJoints(file);
  file.root["nodes"][first]["translation"] = {foot.x, foot.y, foot.z};
  place(file, "worm", shown, {0, 0, 0}, {{"skin", 0}});
  if (animated) addSway(file, "bend", first, {0, 0, 1}, 25);
  if (animated) addSway(file, "twist", first, {0, 1, 0}, 40);
  return file.glb();
}

Bytes morphedModel() {
  GltfBuilder file;
  const Shape ball = sphere(32, 16);
  json morphed = primitive(file, ball, checkered(file, "skin"));
  // Flat, and drawn out along X; the normals of an ellipsoid, to first order.
  std::vector<vec3> flat, flatNormals, drawn, drawnNormals;
  for (const vec3 p : ball.positions) {
    flat.emplace_back(0, -0.6f * p.y, 0);
    flatNormals.emplace_back(0, 0.6f * p.y, 0);
    drawn.emplace_back(0.8f * p.x, 0, 0);
    drawnNormals.emplace_back(-0.4f * p.x, 0, 0);
  }
  morphed["targets"] = {{{"POSITION", file.positions(flat)}, {"NORMAL", file.vectors(flatNormals)}},
                        {{"POSITION", file.positions(drawn)}, {"NORMAL", file.vectors(drawnNormals)}}};
  const int shown = file.add("meshes", {{"primitives", json::array({morphed})}, {"weights", {0.2, 0}}});
  place(file, "ball", shown, {0, 1, 0});
  const std::vector<float> times{0, 0.5f, 1}, weights{0, 0, 1, 0.5f, 0, 1};
  file.add("animations", {{"name", "breathe"},
                          {"samplers",
                           {{{"input", file.accessor(file.view(times), kFloat, "SCALAR", times.size())},
                             {"output", file.accessor(file.view(weights), kFloat, "SCALAR", weights.size())}}}},
                          {"channels", {{{"sampler", 0}, {"target", {{"node", 0}, {"path", "weights"}}}}}}});
  return file.glb();
}

}  // namespace latelight::models
