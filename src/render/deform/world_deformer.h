// Deforms meshes per world on the device: skinned meshes by transforms of joints, and other meshes by positions of
// their vertices, both from arrays of a call (WorldDeformations). Each world has a mesh record of its own for each of
// these meshes, after the records of the scene's meshes.
//
//   arrays of joints ---> pose_joints.comp ------> mat4x3[worlds][meshes][slots][joints]
//                                |
//                                +---------------> deform.comp: positions and attributes of skinned meshes
//   arrays of vertices -> deform_vertices.comp --> positions and attributes of other meshes
//                                |
//                         bound_deformed.comp ---> DeformedBounds[worlds][meshes], Mesh[worlds][meshes]
#pragma once

#include <array>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "render/deform/deformer.h"
#include "render/deform/world_deform_push.h"
#include "render/gpu_scene/buffer.h"
#include "render/gpu_scene/geometry.h"
#include "render/gpu_scene/world_array.h"

namespace latelight::render {

// Joints and vertices of worlds as a caller gave them. Times: 0 the current, 1 the previous and 2 the next frame; if
// the latter are not given, they are the current one.
struct WorldDeformations {
  std::vector<uint32_t> joints;                     // nodes of the scene's rig, by index
  WorldArray jointTransforms[3];                    // by time: [worlds][joints] matrices to the file's frame
  std::vector<uint32_t> meshes;                     // meshes of the scene, by index
  WorldArray vertices[3];                           // by time: [worlds][vertices of all meshes, mesh by mesh] rows of 3
  std::vector<std::shared_ptr<const void>> memory;  // what the arrays are in; the call holds it until it has finished
  // The current frame's numbers if the host places the worlds; the same as in the arrays.
  std::vector<double> jointNumbers, vertexNumbers;
  bool empty() const { return joints.empty() && meshes.empty(); }
  // Returns true if the joints of the mesh's skin include a listed one, and its vertices are not given.
  bool poses(const scene::Scene& scene, uint32_t mesh) const;
  // From the numbers above: the scene's pose with the listed joints as a world has them, and the vertices of one of
  // `meshes`, by its position in that list.
  scene::Pose poseIn(uint32_t world, const scene::Scene& scene, const scene::Pose& scenePose) const;
  std::vector<glm::vec3> verticesIn(uint32_t world, const scene::Scene& scene, size_t listed) const;
};

class WorldDeformer {
 public:
  // The arrays of WorldDeformations, by time.
  struct Arrays {
    std::array<shared::WorldNumbers, 3> joints{}, vertices{};
  };
  static Arrays arraysOf(const WorldDeformations& given);

  explicit WorldDeformer(vk::Device& device);
  static bool runsOn(const vk::Device& device);  // it requires doubles in shaders

  // Prepares the deformation of `worlds` worlds. `deformer` is that of the scene, or null if no joints are given. The
  // other poses are those of joints that are not given. The deformation is pending until the next graph.
  void update(const scene::Scene& scene, const WorldDeformations& given, uint32_t worlds, const Poses& poses,
              const Deformer* deformer, GpuGeometry& geometry, vk::Uploader& uploader);
  // The same for the last update()'s joints and meshes with the arrays of another call, which have the same types.
  // Calls in flight may read the earlier ones. Does nothing if there is no deformation.
  void repeat(const Arrays& arrays);
  Arrays arrays() const { return arrays_; }  // of the last update() or repeat()
  void clear();
  // Adds the pending deformation to the prologue of a graph. `status`: uint[worlds], to which the shaders add kWorld*
  // bits; 0: the host has checked the arrays.
  void addTo(graph::Graph& graph, VkDeviceAddress status) const;
  void submitted() { pending_ = false; }
  bool isPending() const { return pending_; }

  bool empty() const { return parts_.empty(); }
  uint32_t meshCount() const { return static_cast<uint32_t>(parts_.size()); }
  // Returns the place of one of the scene's meshes among the deformed ones, or kNowhere.
  uint32_t placeOf(uint32_t mesh) const;
  std::vector<uint32_t> meshes() const;  // the scene's, in this order
  // Returns the bounds of each deformed mesh in a world, if the host places the worlds.
  struct HostBounds {
    scene::ReachBox box;  // object space
    float longestEdge;
    bool turnedOver;
  };
  std::vector<HostBounds> boundsIn(uint32_t world, const scene::Scene& scene, const WorldDeformations& given,
                                   const Poses& poses) const;
  bool posesJoints() const { return jointCount_ > 0; }
  uint32_t firstMesh() const { return firstMesh_; }             // index of the first world's first mesh record
  VkDeviceAddress bounds() const { return bounds_.address(); }  // DeformedBounds[worlds][meshCount()]

 private:
  struct Part {  // one mesh
    uint32_t mesh;
    bool skinned;
    uint32_t vertices;
    uint32_t firstJoint = 0, jointCount = 0;  // among those of all parts
    uint32_t firstVertex = 0;                 // among those of the arrays
    uint64_t positions = 0, attributes = 0;   // byte offsets of the first world
    uint64_t spheres = 0, weights = 0;        // elements before its own
    uint64_t fans = 0, fanTriangles = 0;
  };
  std::vector<Part> partsOf(const scene::Scene& scene, const WorldDeformations& given) const;
  void describeMeshes(const scene::Scene& scene, const Deformer* deformer, const GpuGeometry& geometry,
                      vk::Uploader& uploader);
  void reserve(GpuGeometry& geometry, vk::Uploader& uploader);
  void uploadFans(const scene::Scene& scene, vk::Uploader& uploader);
  void poseJoints(const scene::Scene& scene, const WorldDeformations& given, const Poses& poses,
                  const Deformer& deformer, vk::Uploader& uploader);
  void recordSkinned(graph::Context& context, const Part& part, VkDeviceAddress weights) const;
  shared::VertexJob vertexJob(const Part& part, const GpuGeometry& geometry, const scene::Scene& scene) const;

  vk::Device& device_;
  struct Pipelines {
    vk::PipelineRef joints, vertices, bounds;
  };
  std::optional<Pipelines> pipelines_;  // none before the first call
  std::vector<Part> parts_;
  const Deformer* deformer_ = nullptr;
  uint32_t worlds_ = 0, slots_ = 1, jointCount_ = 0, firstMesh_ = 0;
  std::optional<uint64_t> meshRevision_ = 0;              // of the scene's meshes when the fans were uploaded
  std::vector<uint32_t> fanMeshes_;                       // meshes whose fans were uploaded
  std::vector<std::pair<uint64_t, uint64_t>> firstFans_;  // by these: elements before its own in both lists
  bool pending_ = false;
  Arrays arrays_;
  std::vector<float> weights_;  // of morph targets: [parts][slots][targets]
  shared::JointJob jointJob_{};
  std::vector<shared::VertexJob> vertexJobs_;  // by part
  shared::BoundJob boundJob_{};
  // The values that the last call uploaded; only those that differ are uploaded again.
  std::vector<shared::PosedJoint> jointValues_;
  std::vector<double> originValues_;
  std::vector<glm::mat4x3> sceneValues_;
  std::vector<shared::DeformedMesh> meshValues_;
  std::vector<shared::DeviceJointSphere> sphereValues_;
  GpuList<shared::PosedJoint> joints_;
  GpuList<double> origins_;
  GpuList<glm::mat4x3> scenePalette_, palettes_;
  GpuList<shared::DeformedMesh> meshes_;
  GpuList<shared::DeviceJointSphere> spheres_;
  GpuList<shared::DeformedBounds> bounds_;
  GpuList<uint32_t> fans_;
  GpuList<shared::DeviceFanTriangle> fanTriangles_;
  vk::Buffer positions_, attributes_;  // deformed
};

}  // namespace latelight::render
