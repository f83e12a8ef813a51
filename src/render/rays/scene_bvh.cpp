#include "render/rays/scene_bvh.h"

#include <algorithm>
#include <cmath>

#include "base/parallel.h"
#include "base/stopwatch.h"
#include "render/rays/emitters.h"
#include "render/rays/refit.h"
#include "render/rays/triangle_boxes.h"
#include "vk/read_back.h"

namespace latelight::render {

namespace {

// Relative bounds of what rounding to floats can add up to: of a transformed ray, and of a box in world space.
constexpr double kRounding = 0x1p-20;

constexpr uint64_t kNoRevision = ~uint64_t{0};  // differs from all revisions
constexpr size_t kTrianglesAtOnce = 65536;      // per call of a parallel loop

// For fewer triangles at once, the host is faster than a GPU and need not wait for it. A CPU device uses the code paths
// for GPUs only in tests, whose meshes are small.
constexpr uint64_t kMinTrianglesOnDevice = 65536;

// A GPU's builder does not divide triangles, so the host builds meshes of up to so many that gain from it.
constexpr size_t kMaxDividedTriangles = 262144;

bool gainsFromDivision(const scene::Mesh& mesh) {
  return mesh.indices.size() / 3 <= kMaxDividedTriangles && !triangleBoxes(mesh).triangles.empty();
}

Bvh bvhOf(const scene::Mesh& mesh) {
  const TriangleBoxes boxes = triangleBoxes(mesh);
  Bvh bvh = buildBvh(boxes.boxes, shared::kMaxRayLeaf, shared::kMaxMeshDepth);
  if (!boxes.triangles.empty())
    for (uint32_t& item : bvh.items) item = boxes.triangles[item];
  return bvh;
}

// Maximum distance of the corners of a box from the origin of its space, in world space.
double reachOf(const Box& box, const glm::dmat3& worldFromObject) {
  double reach = 0;
  for (int corner = 0; corner < 8; ++corner) {
    const glm::dvec3 at(corner & 1 ? box.high.x : box.low.x, corner & 2 ? box.high.y : box.low.y,
                        corner & 4 ? box.high.z : box.low.z);
    reach = std::max(reach, glm::length(worldFromObject * at));
  }
  return reach;
}

// Sets the rows of the transform to object space. An axis that the instance flattens has no inverse: its boxes become
// unbounded, so that rays visit all of them along this axis.
void setRows(shared::RayInstance& record, glm::dmat3 worldFromObject) {
  constexpr float kInfinity = std::numeric_limits<float>::infinity();
  bool flat[3]{};
  for (int axis = 0; axis < 3; ++axis) {
    if (glm::length(worldFromObject[axis]) > 1e-30) continue;
    flat[axis] = true;
    const glm::dvec3 normal = glm::cross(worldFromObject[(axis + 1) % 3], worldFromObject[(axis + 2) % 3]);
    if (glm::length(normal) > 0) worldFromObject[axis] = glm::normalize(normal);
  }
  const glm::dmat3 rows = glm::transpose(glm::inverse(worldFromObject));
  for (int axis = 0; axis < 3; ++axis) {
    const double length = glm::length(rows[axis]);
    const bool usable = !flat[axis] && std::isfinite(length) && length < 1e30;
    record.rows[axis] = usable ? glm::vec4(rows[axis], length * kRounding) : glm::vec4(0, 0, 0, kInfinity);
  }
}

uint32_t rayFlags(const shared::Instance& instance, const shared::Material& material) {
  uint32_t flags = 0;
  if (material.flags & shared::kMaterialDoubleSided) flags |= shared::kRayDoubleSided;
  flags |= shared::rayAlphaFlags(material.flags, material.textures, instance.flags);
  if (shared::translucent(material.flags)) flags |= shared::kRayTranslucent;
  if (instance.flags & shared::kInstanceClockwise) flags |= shared::kRayClockwise;
  return flags;
}

}  // namespace

SceneBvh::SceneBvh(vk::Device& device, graph::Executor& executor, const scene::Scene& scene, GpuScene& gpuScene)
    : device_(device),
      scene_(scene),
      gpuScene_(gpuScene),
      nodes_(device, "ray nodes of instances"),
      instances_(device, "ray instances"),
      record_(device, "ray scene"),
      emitters_(device, "emitters"),
      emitterIndices_(device, "emitters of instances"),
      worldMeshes_(device),
      worlds_(device),
      worldEmitters_(device, "emitters in any world"),
      worldEmitterIndices_(device, "emitters of instances in any world"),
      refitPipeline_(refitPipeline(device)),
      meshEdits_(scene.edits.meshes.revision()) {
  if (!device.hasCpuShaders()) builder_ = std::make_unique<DeviceBvhBuilder>(device, executor, scene, gpuScene);
}

bool SceneBvh::isShown(uint32_t instance) const {
  return gpuScene_.instances().bounds(instance).radius >= 0 &&
         !scene_.meshes[gpuScene_.instances().record(instance).mesh].indices.empty();
}

void SceneBvh::update() {
  const GpuInstances& instances = gpuScene_.instances();
  if (geometryRevision_ != gpuScene_.geometry().revision() || instanceRevision_ != instances.revision() ||
      materialRevision_ != gpuScene_.materials().revision()) {
    const Stopwatch stopwatch;
    geometryRevision_ = kNoRevision;  // until the uploads have succeeded
    followMeshes();
    buildInstances();
    emittingInWorlds_.clear();
    recordedEnvironment_.reset();
    geometryRevision_ = gpuScene_.geometry().revision();
    instanceRevision_ = instances.revision();
    materialRevision_ = gpuScene_.materials().revision();
    buildSeconds_ += stopwatch.seconds();
  }
  storeRecord();
  if (gpuScene_.hasWorlds()) followWorlds();
}

void SceneBvh::followWorlds() {
  std::vector<shared::MeshHierarchy> meshes;
  std::vector<const DeviceBvh*> atRest;
  for (const MeshBvh& mesh : meshes_) {
    meshes.push_back(mesh.buffer ? shared::MeshHierarchy{mesh.buffer.address(), mesh.triangles()}
                                 : shared::MeshHierarchy{});
    atRest.push_back(&mesh);
  }
  worldMeshes_.update(gpuScene_, atRest, meshBuilds_, meshes);
  shared::RayScene common{.environment = environment_,
                          .emitters = emitters_.address(),
                          .emitterIndices = emitterIndices_.address(),
                          .emitterCount = emitterCount_};
  if (gpuScene_.worlds().hasMaterials()) {
    listWorldEmitters();
    common.emitters = worldEmitters_.address();
    common.emitterIndices = worldEmitterIndices_.address();
    common.emitterCount = worldEmitterCount_;
  }
  worlds_.update(gpuScene_, std::move(meshes), common, gpuScene_.uploads());
}

void SceneBvh::listWorldEmitters() {
  std::vector<bool> emitting = emittingInWorlds(gpuScene_);
  if (emitting == emittingInWorlds_) return;
  emittingInWorlds_.clear();  // until the uploads have succeeded
  const Emitters emitters = emittersOf(scene_, gpuScene_, emitting);
  worldEmitterCount_ = static_cast<uint32_t>(emitters.triangles.size());
  if (worldEmitterCount_ > 0) {
    worldEmitters_.upload(gpuScene_.uploads(), emitters.triangles);
    worldEmitterIndices_.upload(gpuScene_.uploads(), emitters.indices);
  }
  emittingInWorlds_ = std::move(emitting);
}

VkDeviceAddress SceneBvh::address(uint32_t world) const {
  return gpuScene_.hasWorlds() ? worlds_.address() + world * sizeof(shared::RayScene) : record_.address();
}

uint32_t SceneBvh::emitterCount() const {
  return gpuScene_.hasWorlds() && gpuScene_.worlds().hasMaterials() ? worldEmitterCount_ : emitterCount_;
}

void SceneBvh::followMeshes() {
  meshes_.resize(scene_.meshes.size());
  for (const uint32_t mesh : scene_.edits.meshes.since(meshEdits_)) {
    meshes_[mesh] = {};
    std::erase(refits_, mesh);
  }
  meshEdits_ = scene_.edits.meshes.revision();
  std::vector<bool> shown(meshes_.size());
  for (uint32_t i = 0; i < gpuScene_.instances().count(); ++i)
    if (isShown(i)) shown[gpuScene_.instances().record(i).mesh] = true;
  std::vector<uint32_t> absent;
  for (uint32_t mesh = 0; mesh < meshes_.size(); ++mesh)
    if (shown[mesh] && !meshes_[mesh].buffer) absent.push_back(mesh);
  buildMeshes(absent);
  if (!absent.empty()) ++meshBuilds_;
  for (uint32_t mesh = 0; mesh < meshes_.size(); ++mesh) {
    MeshBvh& bvh = meshes_[mesh];
    if (!bvh.buffer || !shown[mesh] || bvh.revision == gpuScene_.geometry().revision(mesh)) continue;
    const bool deformed = gpuScene_.geometry().isDeformed(mesh);
    if ((deformed || bvh.refitted) && std::ranges::find(refits_, mesh) == refits_.end()) refits_.push_back(mesh);
    bvh.refitted = deformed;
    bvh.revision = gpuScene_.geometry().revision(mesh);
  }
}

void SceneBvh::buildMeshes(std::span<const uint32_t> meshes) {
  uint64_t triangles = 0;
  for (const uint32_t mesh : meshes) triangles += scene_.meshes[mesh].indices.size() / 3;
  const bool some = builder_ && (device_.isCpu() || triangles >= kMinTrianglesOnDevice);
  std::vector<uint8_t> suits(meshes.size());  // for the device
  parallelFor(meshes.size(), 1, [&](size_t begin, size_t end) {
    for (size_t i = begin; some && i < end; ++i) {
      const scene::Mesh& mesh = scene_.meshes[meshes[i]];
      suits[i] = DeviceBvhBuilder::supports(device_, mesh.indices.size() / 3) && !gainsFromDivision(mesh);
    }
  });
  std::vector<uint32_t> onHost, onDevice;
  for (size_t i = 0; i < meshes.size(); ++i) (suits[i] ? onDevice : onHost).push_back(meshes[i]);
  buildOnHost(onHost);
  if (onDevice.empty()) return;
  std::vector<DeviceBvh> built = builder_->build(onDevice);
  for (size_t i = 0; i < built.size(); ++i) meshes_[onDevice[i]] = {std::move(built[i])};
}

// Builds a limited number of meshes at once, so that few of them are in the host's memory.
void SceneBvh::buildOnHost(std::span<const uint32_t> meshes) {
  constexpr size_t kAtOnce = 256;
  for (size_t first = 0; first < meshes.size(); first += kAtOnce) {
    const std::span<const uint32_t> some = meshes.subspan(first, std::min(kAtOnce, meshes.size() - first));
    std::vector<Bvh> built(some.size());
    parallelFor(some.size(), 1, [&](size_t begin, size_t end) {
      for (size_t i = begin; i < end; ++i) built[i] = bvhOf(scene_.meshes[some[i]]);
    });
    for (size_t i = 0; i < some.size(); ++i) meshes_[some[i]] = {uploaded(scene_.meshes[some[i]], built[i])};
  }
}

DeviceBvh SceneBvh::uploaded(const scene::Mesh& mesh, const Bvh& bvh) {
  std::vector<shared::RayTriangle> triangles(bvh.items.size());
  parallelFor(triangles.size(), kTrianglesAtOnce, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) {
      const uint32_t* corners = &mesh.indices[3 * size_t{bvh.items[i]}];
      triangles[i] = {{corners[0], corners[1], corners[2]}, bvh.items[i]};
    }
  });
  DeviceBvh target{.nodes = static_cast<uint32_t>(bvh.nodes.size())};
  target.buffer = vk::Buffer(device_, {.size = target.nodeBytes() + triangles.size() * sizeof(shared::RayTriangle),
                                       .name = mesh.name + ", BVH"});
  gpuScene_.uploads().upload(target.buffer, std::as_bytes(std::span(bvh.nodes)));
  gpuScene_.uploads().upload(target.buffer, std::as_bytes(std::span(triangles)), target.nodeBytes());
  for (const shared::RayNode& root : std::span(bvh.nodes).first(1)) {
    target.bounds.add(Box{root.lowA, root.highA});
    if (root.b != shared::kRayNone) target.bounds.add(Box{root.lowB, root.highB});
  }
  return target;
}

// Returns the bounds of an instance in the device's world space. They contain the vertices as shaders place them.
Box SceneBvh::boundsOf(uint32_t index) const {
  const shared::Instance& instance = gpuScene_.instances().record(index);
  const glm::dmat3 linear(glm::mat3(instance.objectToWorld));
  const glm::dvec3 translation(instance.objectToWorld[3]);
  glm::dvec3 low(std::numeric_limits<double>::infinity()), high = -low;
  if (gpuScene_.geometry().isDeformed(instance.mesh)) {
    const Sphere& sphere = gpuScene_.instances().bounds(index);
    low = glm::dvec3(sphere.center) - double{sphere.radius};
    high = glm::dvec3(sphere.center) + double{sphere.radius};
  } else {
    const Box& box = meshes_[instance.mesh].bounds;
    for (int corner = 0; corner < 8; ++corner) {
      const glm::dvec3 at =
          linear * glm::dvec3(corner & 1 ? box.high.x : box.low.x, corner & 2 ? box.high.y : box.low.y,
                              corner & 4 ? box.high.z : box.low.z) +
          translation;
      low = glm::min(low, at), high = glm::max(high, at);
    }
  }
  const glm::dvec3 extent = glm::max(glm::abs(low), glm::abs(high));
  const double slack = kRounding * (extent.x + extent.y + extent.z + glm::length(translation)) + 1e-30;
  return {glm::vec3(low - slack), glm::vec3(high + slack)};
}

shared::RayInstance SceneBvh::recordOf(uint32_t index) const {
  const shared::Instance& instance = gpuScene_.instances().record(index);
  const MeshBvh& bvh = meshes_[instance.mesh];
  const glm::dmat3 linear(glm::mat3(instance.objectToWorld));
  shared::RayInstance record{.nodes = bvh.buffer.address(),
                             .triangles = bvh.triangles(),
                             .instance = index,
                             .flags = rayFlags(instance, gpuScene_.materials().record(instance.material))};
  setRows(record, linear);
  double reach = reachOf(bvh.bounds, linear);
  if (gpuScene_.geometry().isDeformed(instance.mesh)) {
    const Sphere& sphere = gpuScene_.instances().bounds(index);
    reach = glm::length(glm::dvec3(sphere.center) - glm::dvec3(instance.objectToWorld[3])) + sphere.radius;
  }
  record.reach = static_cast<float>(reach * (1 + kRounding));
  return record;
}

void SceneBvh::buildInstances() {
  std::vector<uint32_t> shown;
  for (uint32_t i = 0; i < gpuScene_.instances().count(); ++i)
    if (isShown(i)) shown.push_back(i);
  std::vector<Box> boxes(shown.size());
  std::vector<shared::RayInstance> records(shown.size());
  constexpr size_t kAtOnce = 4096;
  parallelFor(shown.size(), kAtOnce, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) boxes[i] = boundsOf(shown[i]);
  });
  const Bvh bvh = buildBvh(boxes, 1, shared::kMaxInstanceDepth);
  parallelFor(shown.size(), kAtOnce, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) records[i] = recordOf(shown[bvh.items[i]]);
  });
  vk::Uploader& uploads = gpuScene_.uploads();
  if (!shown.empty()) {
    nodes_.upload(uploads, bvh.nodes);
    instances_.upload(uploads, records);
  }
  const Emitters emitters = emittersOf(scene_, gpuScene_, emittingInstances(gpuScene_));
  emitterCount_ = static_cast<uint32_t>(emitters.triangles.size());
  if (emitterCount_ > 0) {
    emitters_.upload(uploads, emitters.triangles);
    emitterIndices_.upload(uploads, emitters.indices);
  }
  instanceNodes_ = bvh.nodes.size();
  instanceCount_ = shown.size();
}

// Uploads the record of the scene without worlds, if it has changed.
void SceneBvh::storeRecord() {
  if (gpuScene_.hasWorlds() || recordedEnvironment_ == environment_) return;
  recordedEnvironment_.reset();  // until the upload has succeeded
  const shared::RayScene record{.nodes = nodes_.address(),
                                .instances = instances_.address(),
                                .environment = environment_,
                                .emitters = emitters_.address(),
                                .emitterIndices = emitterIndices_.address(),
                                .instanceCount = static_cast<uint32_t>(instanceCount_),
                                .emitterCount = emitterCount_};
  record_.upload(gpuScene_.uploads(), std::span(&record, 1));
  recordedEnvironment_ = environment_;
}

void SceneBvh::addChanges(graph::Graph& graph) const {
  if (!refits_.empty())
    graph.prologue(graph::Stage::Deformation, "refit", [this](graph::Context& context) { recordRefits(context); });
  worldMeshes_.addTo(graph);
  worlds_.addTo(graph);
}

void SceneBvh::changesSubmitted() {
  refits_.clear();
  worldMeshes_.submitted();
  worlds_.submitted();
}

void SceneBvh::discardChanges() {
  for (const uint32_t mesh : refits_) {
    meshes_[mesh].revision = kNoRevision;
    meshes_[mesh].refitted = true;  // its boxes may be those of an earlier pose
    geometryRevision_ = kNoRevision;
  }
  refits_.clear();
  worldMeshes_.discard();
  worlds_.discard();
}

void SceneBvh::recordRefits(graph::Context& context) const {
  for (const uint32_t mesh : refits_) {
    const MeshBvh& bvh = meshes_[mesh];
    const shared::RayRefitPush push{.meshes = gpuScene_.geometry().address(),
                                    .nodes = bvh.buffer.address(),
                                    .triangles = bvh.triangles(),
                                    .mesh = mesh,
                                    .nodeCount = bvh.nodes,
                                    .meshStride = 0,
                                    .padding = 0};
    recordRefit(context, refitPipeline_, push);
  }
}

uint64_t SceneBvh::bytes() const {
  uint64_t bytes = instanceNodes_ * sizeof(shared::RayNode) + instanceCount_ * sizeof(shared::RayInstance) +
                   emitterCount_ * sizeof(shared::RayEmitter) + worldMeshes_.bytes() + worlds_.bytes();
  for (const MeshBvh& mesh : meshes_)
    if (mesh.buffer) bytes += mesh.buffer.size();
  return bytes;
}

BvhStatistics SceneBvh::statistics() const {
  BvhStatistics statistics{.bytes = bytes(), .buildSeconds = buildSeconds_};
  if (builder_) statistics.deviceSeconds = 1e-3 * builder_->milliseconds();
  for (uint32_t mesh = 0; mesh < meshes_.size(); ++mesh)
    if (meshes_[mesh].buffer) statistics.triangles += scene_.meshes[mesh].indices.size() / 3;
  return statistics;
}

BvhCosts SceneBvh::costs() const {
  BvhCosts costs;
  double triangles = 0;
  for (uint32_t mesh = 0; mesh < meshes_.size(); ++mesh) {
    if (!meshes_[mesh].buffer) continue;
    const auto weight = static_cast<double>(scene_.meshes[mesh].indices.size());
    triangles += weight;
    costs.inUse += weight * sahCost(readMesh(mesh));
    costs.onHost += weight * sahCost(bvhOf(scene_.meshes[mesh]));
  }
  return {costs.inUse / triangles, costs.onHost / triangles};
}

Bvh SceneBvh::readMesh(uint32_t index) const {
  Bvh bvh;
  const MeshBvh& mesh = meshes_[index];
  if (!mesh.buffer) return bvh;
  std::vector<std::byte> host(mesh.buffer.size());
  gpuScene_.uploads().flush();
  vk::readBack(device_, mesh.buffer, 0, host);
  const auto* nodes = reinterpret_cast<const shared::RayNode*>(host.data());
  bvh.nodes.assign(nodes, nodes + mesh.nodes);
  const auto* triangles = reinterpret_cast<const shared::RayTriangle*>(host.data() + mesh.nodeBytes());
  size_t count = 0;
  for (const shared::RayNode& node : bvh.nodes)
    for (const uint32_t child : {node.a, node.b})
      if (child != shared::kRayNone && (child & shared::kRayLeaf)) count += (child >> shared::kRayCountShift & 7) + 1;
  for (size_t i = 0; i < count; ++i) bvh.items.push_back(triangles[i].number);
  return bvh;
}

}  // namespace latelight::render
