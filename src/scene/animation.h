// Keyframe animation, skinning and morph targets of glTF 2.0 (3.7.2.2, 3.7.3, 3.11) as plain data: nodes, skins, morph
// targets and animated properties, and their poses at a given time. This is the CPU implementation; render/deform
// implements deform() on the device.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <map>
#include <span>
#include <string>
#include <vector>

#include "scene/animated_values.h"
#include "shared/types.h"

namespace latelight::scene {

struct Scene;
struct Camera;
struct Instance;
struct Light;

enum class Interpolation : uint8_t { Step, Linear, Cubic };
enum class AnimatedProperty : uint8_t { Translation, Rotation, Scale, Weights, Visible };

// A keyframed value over time.
struct Curve {
  Interpolation interpolation = Interpolation::Linear;
  uint32_t width = 3;         // components per value: 4 for a quaternion (xyzw), the number of targets for weights
  std::vector<float> times;   // seconds, non-decreasing, at least one
  std::vector<float> values;  // `width` per key; Cubic: three times as many (in-tangent, value, out-tangent)
};

// An animated property of one node.
struct Track : Curve {
  uint32_t node = 0;  // index into Rig::nodes
  AnimatedProperty property = AnimatedProperty::Translation;
  int element = -1;  // index of the animated weight; -1: all weights
};

// An animated property of materials, lights or cameras (KHR_animation_pointer).
struct ValueTrack : Curve {
  AnimatedElements elements = AnimatedElements::Materials;
  std::vector<uint32_t> indices;  // elements in the scene; a light or camera of the file may occur several times
  uint32_t property = 0;          // its index in animated_values.cpp
  uint32_t slot = 0;              // for texture transforms: the texture slot
};

struct Animation {
  std::string name;
  float duration = 0;  // in seconds: the last key time of all tracks
  std::vector<Track> tracks;
  std::vector<ValueTrack> values;
};

struct RigNode {
  int parent = -1;
  bool hasMatrix = false;  // `matrix` is the transform, and only the node's parents move it
  glm::dmat4 matrix{1};
  glm::dvec3 translation{0}, scale{1};
  glm::dvec4 rotation{0, 0, 0, 1};  // xyzw
  std::vector<float> weights;       // rest weights of its mesh's morph targets
  bool visible = true;              // effective only if all its parents are visible
};

struct Skin {
  std::vector<uint32_t> joints;  // indices into Rig::nodes
  std::vector<glm::mat4> inverseBind;
  // Skinned vertices are relative to this point of the file's frame, so that floats hold them anywhere on a planet. It
  // is 0 unless the joints at rest lie far from the frame's origin.
  glm::dvec3 origin{0};
};

// All data that poses require. It is empty if the file has neither animations nor skins.
struct Rig {
  std::vector<RigNode> nodes;   // all nodes of the file, in file order: joints need not be in the rendered scene
  std::vector<uint32_t> order;  // node indices, parents first
  std::vector<Skin> skins;
  std::vector<Animation> animations;
  std::vector<uint32_t> sceneNodes;             // for each of Scene::nodes, its index in `nodes`
  std::map<uint32_t, MaterialParts> materials;  // source values of the materials that animations change, by index

  bool empty() const { return nodes.empty(); }
  bool isAnimated() const { return !animations.empty(); }
};

struct MorphTarget {  // deltas; each array is empty or has one element per vertex
  std::vector<glm::vec3> positions, normals, tangents;
};

// How a mesh's vertices are deformed: morph targets first, then skinning.
struct Deformation {
  int skin = -1;                     // index into Rig::skins; -1: none
  int weightsNode = -1;              // index into Rig::nodes of the node that holds the weights; -1: no morph targets
  bool flatNormals = false;          // the file has no normals: use those of the triangles, which share no vertices
  bool mirroredAtRest = false;       // joints mirror the mesh at rest: its winding is opposite to the file's
  std::vector<glm::vec3> positions;  // undeformed
  std::vector<shared::VertexAttributes> attributes;  // texture coordinates don't change
  uint32_t influences = 0;                           // joints per vertex: a multiple of 4, 0 without a skin
  std::vector<uint32_t> joints;                      // indices into the skin's joints; `influences` per vertex
  std::vector<float> jointWeights;                   // `influences` per vertex; at least 0, with a sum of 1
  std::vector<MorphTarget> targets;
};

// The value of a track at a time.
struct PosedValue {
  uint32_t animation, track;  // indices into Rig::animations and Animation::values
  glm::vec4 value;            // the first Curve::width components are used
};

// The pose of all nodes at a time. An empty pose is the rest pose stored in the file.
struct Pose {
  std::vector<glm::dmat4> world;            // transforms of Rig::nodes, in the file's own frame
  std::vector<std::vector<float>> weights;  // morph target weights of Rig::nodes
  std::vector<bool> hidden;                 // per node of Rig::nodes
  std::vector<PosedValue> values;
  bool empty() const { return world.empty(); }
};

// The animations to play, by index; later ones override earlier ones.
struct Playback {
  std::vector<uint32_t> animations;
  bool loop = false;  // times past the end wrap around; otherwise they are clamped
};

// Selects animations by `wanted`: "" is the first one, otherwise a name, an index or "all". Throws Error(Usage) with a
// list of the scene's animations if none matches. "" is valid for scenes without animations.
Playback choosePlayback(const Scene& scene, const std::string& requested, bool loop);
float duration(const Scene& scene, const Playback& playback);  // the duration of the longest one
// Returns the pose at any finite time, or an empty pose if nothing in the scene is animated. Throws Error(BadInput) if
// a transform overflows floats.
Pose poseAt(const Scene& scene, const Playback& playback, double seconds);
// Returns the rest pose of all nodes of the rig, which is not empty unless the rig is.
Pose restPose(const Scene& scene);

// --- posed scene data; for an empty pose, the values of the scene itself ---------------------------------------------

std::vector<glm::dmat4> instanceTransforms(const Scene& scene, const Pose& pose);
std::vector<Camera> posedCameras(const Scene& scene, const Pose& pose);
// Hidden lights are omitted, as if they had been removed.
std::vector<Light> posedLights(const Scene& scene, const Pose& pose);
// Returns the materials that the pose changes, by index.
std::map<uint32_t, shared::Material> posedMaterials(const Scene& scene, const Pose& pose);
bool isShown(const Scene& scene, const Pose& pose, const Instance& instance);
// Transforms from bind space to the file's own frame. The transform of the skinned mesh's own node is ignored
// (3.7.3.3).
std::vector<glm::mat4> jointMatrices(const Skin& skin, const Pose& pose);

struct DeformedVertices {
  std::vector<glm::vec3> positions;
  std::vector<shared::VertexAttributes> attributes;
};
DeformedVertices deform(const Deformation& deformation, std::span<const glm::mat4> joints,
                        std::span<const float> weights);

// A bounding sphere of the undeformed vertices that one joint moves. A skinned vertex is a weighted mean of its
// positions under each joint, so the box around the transformed spheres contains the mesh.
struct JointSphere {
  uint32_t joint;
  glm::vec3 center;
  float radius;
  float weight;  // sum of the joint's weights over all vertices
};
// The maximum extent of a deformation, for culling.
struct Reach {
  std::vector<JointSphere> spheres;  // one sphere for joint 0, which must be the identity, if there is no skin
  std::vector<float> targets;        // per morph target, the maximum distance that it moves a vertex
};
Reach reachOf(const Deformation& deformation);
struct ReachBox {
  glm::vec3 low, high;
};
ReachBox deformedBox(const Reach& reach, std::span<const glm::mat4> joints, std::span<const float> weights);
// Returns true if joints with a negative determinant move most of the mesh. The winding of its triangles is then
// reversed, as for a node with such a transform (glTF 2.0, 3.7.4).
bool isMirrored(const Reach& reach, std::span<const glm::mat4> joints);

// Composes translation, rotation (a normalized quaternion, xyzw) and scale.
glm::dmat4 composeTransform(glm::dvec3 translation, glm::dvec4 rotation, glm::dvec3 scale);

}  // namespace latelight::scene
