// What moves in a scene, as plain data, and where it is at a time: animated nodes, skins and morph targets of glTF 2.0
// (3.7.2.2, 3.7.3, 3.11). Evaluated on the CPU; render/deform does to vertices on the device what deform() does here.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <span>
#include <string>
#include <vector>

#include "shared/types.h"

namespace latelight::scene {

struct Scene;
struct Camera;
struct Light;

enum class Interpolation : uint8_t { Step, Linear, Cubic };
enum class AnimatedProperty : uint8_t { Translation, Rotation, Scale, Weights };

// One property of one node over time.
struct Track {
  uint32_t node = 0;  // index into Rig::nodes
  AnimatedProperty property = AnimatedProperty::Translation;
  Interpolation interpolation = Interpolation::Linear;
  uint32_t width = 3;         // numbers a value: 3, 4 (a quaternion, xyzw), or as many as there are weights
  std::vector<float> times;   // seconds, never falling, at least one
  std::vector<float> values;  // `width` a time; Cubic: three times that, the tangent in, the value, the tangent out
};

struct Animation {
  std::string name;
  float duration = 0;  // seconds: the last time of any track
  std::vector<Track> tracks;
};

struct RigNode {
  int parent = -1;
  bool hasMatrix = false;  // then `matrix` is its transform, and nothing moves it but its parents
  glm::dmat4 matrix{1};
  glm::dvec3 translation{0}, scale{1};
  glm::dvec4 rotation{0, 0, 0, 1};  // xyzw
  std::vector<float> weights;       // of its mesh's morph targets, at rest
};

struct Skin {
  std::vector<uint32_t> joints;  // indices into Rig::nodes
  std::vector<glm::mat4> inverseBind;
};

// Everything that poses need. Empty where the file has no animation: then nothing moves.
struct Rig {
  std::vector<RigNode> nodes;   // all of the file, in its order: joints need not be in the scene shown
  std::vector<uint32_t> order;  // of them, parents first
  std::vector<Skin> skins;
  std::vector<Animation> animations;
  std::vector<uint32_t> sceneNodes;  // of each of Scene::nodes, its place in `nodes`
  // EXT_mesh_gpu_instancing: of each instance, its transform below its node. Empty where no node has several.
  std::vector<glm::dmat4> offsets;

  bool empty() const { return nodes.empty(); }
};

struct MorphTarget {  // what is added; each empty, or one a vertex
  std::vector<glm::vec3> positions, normals, tangents;
};

// How the vertices of a mesh move: morphed first, then skinned.
struct Deformation {
  int skin = -1;                     // index into Rig::skins; -1: none
  int weightsNode = -1;              // the node whose weights count, index into Rig::nodes; -1: no morph targets
  bool flatNormals = false;          // the file has none: those of the triangles, which share no vertices
  std::vector<glm::vec3> positions;  // before all of it
  std::vector<shared::VertexAttributes> attributes;  // texture coordinates stay
  uint32_t influences = 0;                           // joints a vertex: a multiple of 4, 0 where there is no skin
  std::vector<uint32_t> joints;                      // of the skin; `influences` a vertex
  std::vector<float> jointWeights;                   // the same; at least 0, their sum is 1
  std::vector<MorphTarget> targets;
};

// Where all nodes are at a time. An empty one is the pose at rest, as the file has it.
struct Pose {
  std::vector<glm::dmat4> world;            // of Rig::nodes, in the file's own frame
  std::vector<std::vector<float>> weights;  // of Rig::nodes
  bool empty() const { return world.empty(); }
};

// What plays: animations by their number, later ones over earlier ones where both move the same.
struct Playback {
  std::vector<uint32_t> animations;
  bool loop = false;  // time beyond the end begins again; else the ends hold
};

// "", the first one; a name or a number; "all". Throws Error(Usage) that lists what the scene has. A scene without
// animations has nothing to play, which is fine where nothing is asked for.
Playback choosePlayback(const Scene& scene, const std::string& wanted, bool loop);
float duration(const Scene& scene, const Playback& playback);  // the longest one's
// Any finite time will do. Empty where the scene has nothing that moves. Throws Error(BadInput) where a transform
// leaves the range of floats.
Pose poseAt(const Scene& scene, const Playback& playback, double seconds);

// --- a pose's consequences; those of an empty pose are what the scene itself holds -----------------------------------

std::vector<glm::mat4> instanceTransforms(const Scene& scene, const Pose& pose);
std::vector<Camera> posedCameras(const Scene& scene, const Pose& pose);
std::vector<Light> posedLights(const Scene& scene, const Pose& pose);
// From bind space to the file's own frame; the skinned mesh's own node does not count (3.7.3.3).
std::vector<glm::mat4> jointMatrices(const Skin& skin, const Pose& pose);

struct DeformedVertices {
  std::vector<glm::vec3> positions;
  std::vector<shared::VertexAttributes> attributes;
};
DeformedVertices deform(const Deformation& deformation, std::span<const glm::mat4> joints,
                        std::span<const float> weights);

// The vertices that one joint moves, before it does: whatever the joints do, a skinned vertex is a mean of where each
// of its joints would carry it, so the carried spheres hold the mesh.
struct JointSphere {
  uint32_t joint;
  glm::vec3 centre;
  float radius;
};
// How far a deformation reaches, for culling.
struct Reach {
  std::vector<JointSphere> spheres;  // without a skin: one, of joint 0, which is to be the identity
  std::vector<float> targets;        // of each morph target, the farthest it moves a vertex
};
Reach reachOf(const Deformation& deformation);
struct ReachBox {
  glm::vec3 low, high;
};
ReachBox deformedBox(const Reach& reach, std::span<const glm::mat4> joints, std::span<const float> weights);

// Translation, rotation (quaternion xyzw, made unit), scale.
glm::dmat4 composeTransform(glm::dvec3 translation, glm::dvec4 rotation, glm::dvec3 scale);

}  // namespace latelight::scene
