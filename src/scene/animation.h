// The moving parts of a scene, as plain data, and their poses over time: animated nodes, skins and morph targets of
// glTF 2.0 (3.7.2.2, 3.7.3, 3.11). Evaluated on the CPU; render/deform is the device version of deform().
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

// A value over time.
struct Curve {
  Interpolation interpolation = Interpolation::Linear;
  uint32_t width = 3;         // components per value: of a quaternion 4 (xyzw), of weights their number
  std::vector<float> times;   // seconds, non-decreasing, at least one
  std::vector<float> values;  // `width` per time; Cubic: three times that: in-tangent, value, out-tangent
};

// One property of one node.
struct Track : Curve {
  uint32_t node = 0;  // index into Rig::nodes
  AnimatedProperty property = AnimatedProperty::Translation;
  int element = -1;  // of the weights: one alone; -1: all of them
};

// One property of materials, lights or cameras (KHR_animation_pointer).
struct ValueTrack : Curve {
  AnimatedElements elements = AnimatedElements::Materials;
  std::vector<uint32_t> indices;  // of those in the scene: a light or a camera of the file may be there several times
  uint32_t property = 0;          // its number in animated_values.cpp
  uint32_t slot = 0;              // of a texture's transform: whose
};

struct Animation {
  std::string name;
  float duration = 0;  // seconds: the last time of any track
  std::vector<Track> tracks;
  std::vector<ValueTrack> values;
};

struct RigNode {
  int parent = -1;
  bool hasMatrix = false;  // then `matrix` is its transform, and only its parents move it
  glm::dmat4 matrix{1};
  glm::dvec3 translation{0}, scale{1};
  glm::dvec4 rotation{0, 0, 0, 1};  // xyzw
  std::vector<float> weights;       // of its mesh's morph targets, at rest
  bool visible = true;              // where all its parents are, too
};

struct Skin {
  std::vector<uint32_t> joints;  // indices into Rig::nodes
  std::vector<glm::mat4> inverseBind;
  // Skinned vertices are relative to this point of the file's frame, so that floats hold them anywhere on a planet. It
  // is 0 unless the joints at rest lie far from the frame's origin.
  glm::dvec3 origin{0};
};

// Everything that poses need. Empty where the file has no animations.
struct Rig {
  std::vector<RigNode> nodes;   // all of the file's, in order: joints need not be in the scene shown
  std::vector<uint32_t> order;  // of them, parents first
  std::vector<Skin> skins;
  std::vector<Animation> animations;
  std::vector<uint32_t> sceneNodes;  // for each of Scene::nodes, its index in `nodes`
  // EXT_mesh_gpu_instancing: each instance's transform relative to its node. Empty where no node has several.
  std::vector<glm::dmat4> offsets;
  std::map<uint32_t, MaterialParts> materials;  // that animations change

  bool empty() const { return nodes.empty(); }
};

struct MorphTarget {  // deltas; each empty, or one per vertex
  std::vector<glm::vec3> positions, normals, tangents;
};

// How the vertices of a mesh move: morphed first, then skinned.
struct Deformation {
  int skin = -1;                     // index into Rig::skins; -1: none
  int weightsNode = -1;              // the node whose weights count, index into Rig::nodes; -1: no morph targets
  bool flatNormals = false;          // the file has no normals: uses those of the triangles, which share no vertices
  bool mirroredAtRest = false;       // by its joints: the mesh's indices are those of the file turned over
  std::vector<glm::vec3> positions;  // undeformed
  std::vector<shared::VertexAttributes> attributes;  // texture coordinates don't change
  uint32_t influences = 0;                           // joints per vertex: a multiple of 4, 0 where there is no skin
  std::vector<uint32_t> joints;                      // of the skin; `influences` per vertex
  std::vector<float> jointWeights;                   // the same; at least 0, their sum is 1
  std::vector<MorphTarget> targets;
};

// What a track of values gives at a time.
struct PosedValue {
  uint32_t animation, track;  // of Animation::values
  glm::vec4 value;            // as many components as it has
};

// The pose of all nodes at a time. An empty one is the pose at rest, as in the file.
struct Pose {
  std::vector<glm::dmat4> world;            // of Rig::nodes, in the file's own frame
  std::vector<std::vector<float>> weights;  // of Rig::nodes
  std::vector<bool> hidden;                 // of Rig::nodes
  std::vector<PosedValue> values;
  bool empty() const { return world.empty(); }
};

// The animations that play, by number; later ones override earlier ones.
struct Playback {
  std::vector<uint32_t> animations;
  bool loop = false;  // time past the end wraps around; else the ends hold
};

// "", the first one; a name or a number; "all". Throws Error(Usage) that lists the scene's animations. A scene without
// animations is fine where none is asked for.
Playback choosePlayback(const Scene& scene, const std::string& wanted, bool loop);
float duration(const Scene& scene, const Playback& playback);  // the longest one's
// Any finite time is valid. Empty where nothing in the scene moves. Throws Error(BadInput) where a transform overflows
// floats.
Pose poseAt(const Scene& scene, const Playback& playback, double seconds);

// --- a pose's consequences; those of an empty pose are what the scene itself holds -----------------------------------

std::vector<glm::dmat4> instanceTransforms(const Scene& scene, const Pose& pose);
std::vector<Camera> posedCameras(const Scene& scene, const Pose& pose);
// Those that are hidden as if they were removed.
std::vector<Light> posedLights(const Scene& scene, const Pose& pose);
// Those that the pose changes, by their number.
std::map<uint32_t, shared::Material> posedMaterials(const Scene& scene, const Pose& pose);
bool isShown(const Scene& scene, const Pose& pose, const Instance& instance);
// From bind space to the file's own frame; the skinned mesh's own node is ignored (3.7.3.3).
std::vector<glm::mat4> jointMatrices(const Skin& skin, const Pose& pose);

struct DeformedVertices {
  std::vector<glm::vec3> positions;
  std::vector<shared::VertexAttributes> attributes;
};
DeformedVertices deform(const Deformation& deformation, std::span<const glm::mat4> joints,
                        std::span<const float> weights);

// Bounds of the undeformed vertices that one joint moves. A skinned vertex is a weighted mean of the positions that its
// joints would give it, so the box around the transformed spheres contains the mesh.
struct JointSphere {
  uint32_t joint;
  glm::vec3 centre;
  float radius;
  float weight;  // the sum of the joint's over all vertices
};
// The extent of a deformation, for culling.
struct Reach {
  std::vector<JointSphere> spheres;  // without a skin: one, of joint 0, which must be the identity
  std::vector<float> targets;        // for each morph target, the farthest it moves a vertex
};
Reach reachOf(const Deformation& deformation);
struct ReachBox {
  glm::vec3 low, high;
};
ReachBox deformedBox(const Reach& reach, std::span<const glm::mat4> joints, std::span<const float> weights);
// True where joints of negative determinant move most of the mesh: its triangles then wind the other way round, as
// those of a node with such a transform do (glTF 2.0, 3.7.4).
bool isMirrored(const Reach& reach, std::span<const glm::mat4> joints);

// Translation, rotation (quaternion xyzw, normalised), scale.
glm::dmat4 composeTransform(glm::dvec3 translation, glm::dvec4 rotation, glm::dvec3 scale);

}  // namespace latelight::scene
