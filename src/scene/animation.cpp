// Evaluates keyframe animation on the CPU: interpolates curves, computes poses of the node hierarchy, and deforms
// vertices by morph targets and skinning.
#include "scene/animation.h"

#include <algorithm>
#include <cmath>
#include <glm/gtc/matrix_transform.hpp>
#include <glm/gtc/quaternion.hpp>

#include "base/error.h"
#include "base/parallel.h"
#include "base/text.h"
#include "scene/objects.h"
#include "scene/scene.h"
#include "shared/deform.h"

namespace latelight::scene {

namespace {

using glm::dmat4;
using glm::dvec3;
using glm::dvec4;

// --- keyframe interpolation -----------------------------------------------------------------------------------------

glm::dquat quaternion(const dvec4& v) {
  const double length = glm::length(v);
  return length > 0 ? glm::dquat(v.w / length, v.x / length, v.y / length, v.z / length) : glm::dquat(1, 0, 0, 0);
}

// The position of a time among the keyframes: `fraction` of the interval between `key` and the next key.
struct KeyPosition {
  size_t key;
  double fraction;
  double span;  // seconds between the two keys
};

// Times before the first key or after the last one are clamped to it (glTF 2.0, 3.11). Keys are floats, so the time is
// compared as a float, too: frame 1 at 24 frames per second has reached the key that the file rounds from 1/24.
KeyPosition keyAt(const std::vector<float>& times, double seconds) {
  const auto after = static_cast<size_t>(std::ranges::upper_bound(times, static_cast<float>(seconds)) - times.begin());
  if (after == 0) return {0, 0, 0};
  if (after == times.size()) return {after - 1, 0, 0};
  const double from = times[after - 1], span = times[after] - from;
  return {after - 1, std::clamp((seconds - from) / span, 0.0, 1.0), span};
}

// Cubic Hermite spline with tangents per second (glTF 2.0, appendix C).
double cubic(const float* key, uint32_t width, uint32_t i, const KeyPosition& position) {
  const double u = position.fraction, u2 = u * u, u3 = u2 * u, span = position.span;
  const double from = key[width + i], leaving = key[2 * width + i];
  if (span == 0) return from;
  const double arriving = key[3 * width + i], to = key[4 * width + i];
  return (2 * u3 - 3 * u2 + 1) * from + span * (u3 - 2 * u2 + u) * leaving + (3 * u2 - 2 * u3) * to +
         span * (u3 - u2) * arriving;
}

dvec4 slerp(const float* from, const float* to, double fraction) {
  const glm::dquat a = quaternion({from[0], from[1], from[2], from[3]});
  const glm::dquat b = quaternion({to[0], to[1], to[2], to[3]});
  const glm::dquat q = glm::slerp(a, b, fraction);  // along the shorter arc
  return {q.x, q.y, q.z, q.w};
}

void valueAt(const Curve& track, bool rotation, double seconds, std::span<double> out) {
  const KeyPosition position = keyAt(track.times, seconds);
  const uint32_t width = track.width;
  const float* key = &track.values[position.key * width * (track.interpolation == Interpolation::Cubic ? 3 : 1)];
  const bool between = position.span > 0 && track.interpolation == Interpolation::Linear;
  if (between && rotation) {
    const dvec4 q = slerp(key, key + width, position.fraction);
    for (int i = 0; i < 4; ++i) out[i] = q[i];
    return;
  }
  for (uint32_t i = 0; i < width; ++i) {
    if (track.interpolation == Interpolation::Cubic)
      out[i] = cubic(key, width, i, position);
    else
      out[i] = between ? key[i] + (double{key[width + i]} - key[i]) * position.fraction : key[i];
  }
}

void apply(const Track& track, double seconds, RigNode& node) {
  std::vector<double> value(track.width);
  valueAt(track, track.property == AnimatedProperty::Rotation, seconds, value);
  switch (track.property) {
    case AnimatedProperty::Translation:
      node.translation = {value[0], value[1], value[2]};
      break;
    case AnimatedProperty::Rotation:
      node.rotation = {value[0], value[1], value[2], value[3]};
      break;
    case AnimatedProperty::Scale:
      node.scale = {value[0], value[1], value[2]};
      break;
    case AnimatedProperty::Weights:
      if (track.element < 0)
        node.weights.assign(value.begin(), value.end());
      else
        node.weights[size_t(track.element)] = float(value[0]);
      break;
    case AnimatedProperty::Visible:
      node.visible = value[0] != 0;
      break;
  }
}

glm::vec4 valueAt(const ValueTrack& track, double seconds) {
  double value[4] = {};
  valueAt(track, false, seconds, {value, track.width});
  for (double v : value)
    if (!std::isfinite(float(v))) badInput("the scene's animation sets a property to a value that is not finite");
  return {value[0], value[1], value[2], value[3]};
}

// --- playback -------------------------------------------------------------------------------------------------------

std::string animationList(const Scene& scene) {
  std::string names;
  for (size_t i = 0; i < scene.rig.animations.size(); ++i)
    names += fmt::format("{}{} \"{}\"", i ? ", " : "", i, scene.rig.animations[i].name);
  return names.empty() ? "it has none" : "it has: " + names;
}

double wrapped(double seconds, double duration) {
  if (!(duration > 0)) return 0;
  const double rest = std::fmod(seconds, duration);
  return rest < 0 ? rest + duration : rest;
}

// --- nodes ----------------------------------------------------------------------------------------------------------

Pose poseOf(const Rig& rig, std::vector<RigNode> nodes) {
  Pose pose;
  pose.world.resize(nodes.size());
  pose.hidden.resize(nodes.size());
  for (uint32_t index : rig.order) {
    const RigNode& node = nodes[index];
    pose.hidden[index] = !node.visible || (node.parent >= 0 && pose.hidden[static_cast<size_t>(node.parent)]);
    const dmat4 local = node.hasMatrix ? node.matrix : composeTransform(node.translation, node.rotation, node.scale);
    dmat4& world = pose.world[index];
    world = node.parent < 0 ? local : pose.world[static_cast<size_t>(node.parent)] * local;
    for (int i = 0; i < 16; ++i)
      if (!std::isfinite(static_cast<float>(world[i / 4][i % 4])))
        badInput("the scene's animation sets nodes[{}] to a transform that is not finite", index);
  }
  for (RigNode& node : nodes) pose.weights.push_back(std::move(node.weights));
  return pose;
}

const dmat4& worldOf(const Scene& scene, const Pose& pose, uint32_t node) {
  return pose.world[scene.rig.sceneNodes[node]];
}

// Nodes that edits added follow the file's nodes and are never hidden by a pose.
bool isHidden(const Scene& scene, const Pose& pose, uint32_t node) {
  return node < scene.rig.sceneNodes.size() && pose.hidden[scene.rig.sceneNodes[node]];
}

template <typename Body>
void forEachValue(const Scene& scene, const Pose& pose, AnimatedElements elements, Body body) {
  for (const PosedValue& posed : pose.values) {
    const ValueTrack& track = scene.rig.animations[posed.animation].values[posed.track];
    if (track.elements != elements) continue;
    for (uint32_t index : track.indices) body(index, track, posed.value);
  }
}

// --- vertices -------------------------------------------------------------------------------------------------------

glm::mat4 blendJoints(const Deformation& d, std::span<const glm::mat4> joints, size_t vertex) {
  glm::mat4 sum(0);
  for (uint32_t i = 0; i < d.influences; ++i) {
    const size_t at = vertex * d.influences + i;
    if (d.jointWeights[at] > 0) sum += joints[d.joints[at]] * d.jointWeights[at];
  }
  return sum;
}

template <typename V>
V morphed(V value, std::vector<glm::vec3> MorphTarget::*stream, const Deformation& d, std::span<const float> weights,
          size_t vertex) {
  for (size_t t = 0; t < d.targets.size() && t < weights.size(); ++t) {
    const std::vector<glm::vec3>& deltas = d.targets[t].*stream;
    if (deltas.empty() || weights[t] == 0) continue;
    for (int c = 0; c < 3; ++c) value[c] += deltas[vertex][c] * weights[t];
  }
  return value;
}

glm::vec3 unitOr(glm::vec3 v, glm::vec3 otherwise) {
  const float squared = glm::dot(v, v);
  return squared > 1e-30f && std::isfinite(squared) ? v / std::sqrt(squared) : otherwise;
}

void deformVertex(const Deformation& d, std::span<const glm::mat4> joints, std::span<const float> weights, size_t i,
                  DeformedVertices& out) {
  const shared::VertexAttributes& base = d.attributes[i];
  glm::vec3 position = morphed(d.positions[i], &MorphTarget::positions, d, weights, i);
  glm::vec3 normal = unitOr(morphed(base.normal, &MorphTarget::normals, d, weights, i), base.normal);
  glm::vec4 tangent = morphed(base.tangent, &MorphTarget::tangents, d, weights, i);
  if (d.influences > 0) {
    const glm::mat4 m = blendJoints(d, joints, i);
    const glm::vec3 x(m[0]), y(m[1]), z(m[2]);
    position = glm::vec3(m * glm::vec4(position, 1));
    normal = shared::skinnedNormal(x, y, z, normal);
    tangent = shared::skinnedTangent(x, y, z, tangent);
  }
  out.positions[i] = position;
  out.attributes[i] = {normal, tangent, base.uv0};
}

}  // namespace

dmat4 composeTransform(dvec3 translation, dvec4 rotation, dvec3 scale) {
  dmat4 m = glm::mat4_cast(quaternion(rotation));
  for (int i = 0; i < 3; ++i) m[i] *= scale[i];
  m[3] = dvec4(translation, 1);
  return m;
}

Playback choosePlayback(const Scene& scene, const std::string& requested, bool loop) {
  const std::vector<Animation>& all = scene.rig.animations;
  Playback playback{.animations = {}, .loop = loop};
  if (requested.empty() || requested == "all") {
    const size_t count = requested.empty() ? std::min<size_t>(all.size(), 1) : all.size();
    for (size_t i = 0; i < count; ++i) playback.animations.push_back(static_cast<uint32_t>(i));
    if (requested == "all" && all.empty()) badUsage("{} has no animation: omit --animation", scene.source);
    return playback;
  }
  for (size_t i = 0; i < all.size(); ++i)
    if (all[i].name == requested) return playback.animations = {static_cast<uint32_t>(i)}, playback;
  const auto number = parseNumber<uint32_t>(requested);
  if (!number || *number >= all.size())
    badUsage("{} has no animation \"{}\"; {}", scene.source, requested, animationList(scene));
  playback.animations = {*number};
  return playback;
}

float duration(const Scene& scene, const Playback& playback) {
  float longest = 0;
  for (uint32_t index : playback.animations) longest = std::max(longest, scene.rig.animations[index].duration);
  return longest;
}

Pose poseAt(const Scene& scene, const Playback& playback, double seconds) {
  if (!scene.rig.isAnimated()) return {};
  std::vector<RigNode> nodes = scene.rig.nodes;
  if (playback.loop) seconds = wrapped(seconds, duration(scene, playback));
  for (uint32_t index : playback.animations)
    for (const Track& track : scene.rig.animations[index].tracks) apply(track, seconds, nodes[track.node]);
  Pose pose = poseOf(scene.rig, std::move(nodes));
  for (uint32_t index : playback.animations) {
    const std::vector<ValueTrack>& tracks = scene.rig.animations[index].values;
    for (uint32_t track = 0; track < tracks.size(); ++track)
      pose.values.push_back({index, track, valueAt(tracks[track], seconds)});
  }
  return pose;
}

Pose restPose(const Scene& scene) {
  return poseOf(scene.rig, scene.rig.nodes);
}

std::vector<dmat4> instanceTransforms(const Scene& scene, const Pose& pose) {
  std::vector<dmat4> transforms(scene.instances.size());
  parallelFor(transforms.size(), 16384, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) {
      const Instance& instance = scene.instances[i];
      const bool isPlaced = pose.empty() || instance.placed;
      transforms[i] = isPlaced ? instance.toWorld : followedToWorld(scene, pose, static_cast<uint32_t>(i));
    }
  });
  return transforms;
}

std::vector<Camera> posedCameras(const Scene& scene, const Pose& pose) {
  std::vector<Camera> cameras = scene.cameras;
  if (pose.empty()) return cameras;
  for (Camera& camera : cameras)
    if (camera.node >= 0) placeCamera(camera, worldOf(scene, pose, static_cast<uint32_t>(camera.node)));
  forEachValue(scene, pose, AnimatedElements::Cameras,
               [&](uint32_t i, const ValueTrack& track, const glm::vec4& value) {
                 setValue(cameras[i], track.property, value);
               });
  for (size_t i = 0; i < cameras.size(); ++i) limitValues(cameras[i], scene.cameras[i]);
  return cameras;
}

std::vector<Light> posedLights(const Scene& scene, const Pose& pose) {
  std::vector<Light> lights = scene.lights;
  for (Light& light : lights) {
    const bool follows = !pose.empty() && light.node >= 0;
    light.removed |= follows ? isHidden(scene, pose, static_cast<uint32_t>(light.node)) : light.hidden;
    if (follows) placeLight(light, worldOf(scene, pose, static_cast<uint32_t>(light.node)));
  }
  forEachValue(scene, pose, AnimatedElements::Lights, [&](uint32_t i, const ValueTrack& track, const glm::vec4& value) {
    setValue(lights[i], track.property, value);
  });
  for (Light& light : lights) light.innerCone = std::min(light.innerCone, light.outerCone);
  return lights;
}

std::map<uint32_t, shared::Material> posedMaterials(const Scene& scene, const Pose& pose) {
  std::map<uint32_t, shared::Material> materials;
  std::map<uint32_t, MaterialParts> parts = scene.rig.materials;
  forEachValue(scene, pose, AnimatedElements::Materials,
               [&](uint32_t i, const ValueTrack& track, const glm::vec4& value) {
                 shared::Material& material = materials.try_emplace(i, scene.materials[i].data).first->second;
                 setValue(material, parts[i], track.property, track.slot, value);
               });
  return materials;
}

bool isShown(const Scene& scene, const Pose& pose, const Instance& instance) {
  if (instance.removed) return false;
  return pose.empty() ? !instance.hidden : !isHidden(scene, pose, instance.node);
}

std::vector<glm::mat4> jointMatrices(const Skin& skin, const Pose& pose) {
  std::vector<glm::mat4> matrices;
  matrices.reserve(skin.joints.size());
  for (size_t i = 0; i < skin.joints.size(); ++i)
    matrices.emplace_back(glm::translate(dmat4(1), -skin.origin) * pose.world[skin.joints[i]] *
                          dmat4(skin.inverseBind[i]));
  return matrices;
}

DeformedVertices deform(const Deformation& d, std::span<const glm::mat4> joints, std::span<const float> weights) {
  const size_t count = d.positions.size();
  DeformedVertices out{std::vector<glm::vec3>(count), std::vector<shared::VertexAttributes>(count)};
  parallelFor(count, 1 << 14, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) deformVertex(d, joints, weights, i, out);
  });
  if (!d.flatNormals) return out;
  for (size_t i = 0; i + 2 < count; i += 3) {
    glm::vec3 normal = shared::flatNormal(out.positions[i], out.positions[i + 1], out.positions[i + 2]);
    if (d.influences > 0) {
      const glm::mat4 m = blendJoints(d, joints, i);
      normal *= shared::handedness(glm::vec3(m[0]), glm::vec3(m[1]), glm::vec3(m[2]));
    }
    for (size_t corner = i; corner < i + 3; ++corner) out.attributes[corner].normal = normal;
  }
  return out;
}

Reach reachOf(const Deformation& d) {
  Reach reach;
  for (const MorphTarget& target : d.targets) {
    float farthest = 0;
    for (const glm::vec3& delta : target.positions) farthest = std::max(farthest, glm::length(delta));
    reach.targets.push_back(farthest);
  }
  const uint32_t jointCount = d.joints.empty() ? 1 : *std::max_element(d.joints.begin(), d.joints.end()) + 1;
  constexpr float kInfinity = std::numeric_limits<float>::infinity();
  std::vector<ReachBox> boxes(jointCount, {glm::vec3(kInfinity), glm::vec3(-kInfinity)});
  std::vector<double> weights(jointCount);
  const auto extend = [&](uint32_t joint, const glm::vec3& p, float weight) {
    boxes[joint] = {glm::min(boxes[joint].low, p), glm::max(boxes[joint].high, p)};
    weights[joint] += weight;
  };
  for (size_t i = 0; i < d.positions.size(); ++i) {
    if (d.influences == 0) extend(0, d.positions[i], 1);
    for (size_t k = i * d.influences; k < (i + 1) * d.influences; ++k)
      if (d.jointWeights[k] > 0) extend(d.joints[k], d.positions[i], d.jointWeights[k]);
  }
  for (uint32_t joint = 0; joint < jointCount; ++joint) {
    const ReachBox& box = boxes[joint];
    if (box.low.x > box.high.x) continue;
    reach.spheres.push_back({joint, (box.low + box.high) * 0.5f, glm::length(box.high - box.low) * 0.5f,
                             static_cast<float>(weights[joint])});
  }
  return reach;
}

ReachBox deformedBox(const Reach& reach, std::span<const glm::mat4> joints, std::span<const float> weights) {
  float moved = 0;
  for (size_t t = 0; t < reach.targets.size() && t < weights.size(); ++t)
    moved += reach.targets[t] * std::abs(weights[t]);
  ReachBox box{glm::vec3(std::numeric_limits<float>::infinity()), glm::vec3(-std::numeric_limits<float>::infinity())};
  for (const JointSphere& sphere : reach.spheres) {
    const glm::mat4& m = joints[sphere.joint];
    const glm::vec3 center(m * glm::vec4(sphere.center, 1));
    // A linear map stretches a sphere along axis i by the length of its row i.
    glm::vec3 half;
    for (int i = 0; i < 3; ++i) half[i] = glm::length(glm::vec3(m[0][i], m[1][i], m[2][i])) * (sphere.radius + moved);
    // Slack, because the shader rounds differently.
    half = half * 1.0001f + (glm::abs(center) + half) * 1e-6f;
    box = {glm::min(box.low, center - half), glm::max(box.high, center + half)};
  }
  return box;
}

bool isMirrored(const Reach& reach, std::span<const glm::mat4> joints) {
  double balance = 0;
  for (const JointSphere& sphere : reach.spheres) {
    const double determinant = glm::determinant(glm::dmat3(joints[sphere.joint]));
    balance += determinant < 0 ? -double{sphere.weight} : determinant > 0 ? double{sphere.weight} : 0;
  }
  return balance < 0;
}

}  // namespace latelight::scene
