#version 460
#extension GL_GOOGLE_include_directive : require
// Builds the BVH over the instances of each world, one workgroup per world. Instances are sorted by the Morton codes of
// the centers of their boxes (Lauterbach et al. 2009, Fast BVH Construction on GPUs, section 4).
//
// Up to kMaxClustered instances are merged from the leaves to the root: in each round, each cluster finds the one with
// which its box has the smallest surface, and clusters that find each other become children of a node (Meister and
// Bittner 2018, Parallel Locally-Ordered Clustering for Bounding Volume Hierarchy Construction, IEEE TVCG 24(3)). All
// clusters are candidates, because there are few of them, in shared memory.
//
// More instances are the leaves of a complete binary tree in the order of the codes. Its depth is the logarithm of
// their number, and positions of nodes follow from the number only, so neither a search for splits nor a list of nodes
// is required.
//
// No result depends on the order in which invocations run. The host's counterpart for scenes without worlds is
// SceneBvh::buildInstances().
#include "render/glsl/ordered_bits.glsl"
#include "render/rays/worlds/world_bvh.glsl"

layout(buffer_reference, scalar, buffer_reference_align = 8) readonly buffer HierarchiesRef { MeshHierarchy v[]; };
layout(buffer_reference, scalar, buffer_reference_align = 8) coherent buffer KeysRef { uint64_t v[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) coherent buffer BoxesRef { ItemBox v[]; };
layout(buffer_reference, scalar, buffer_reference_align = 16) coherent buffer NodesRef { RayNode v[]; };
layout(buffer_reference, scalar, buffer_reference_align = 8) writeonly buffer RayInstancesRef { RayInstance v[]; };

// Relative bounds of what rounding to floats can add up to: of a transformed ray, and of a box in world space.
const double kRounding = 9.5367431640625e-7lf;  // 2^-20
const uint64_t kAbsentKey = 0xfffffffffffffffful;

shared uint lowCenter[3], highCenter[3];  // of all boxes, as ordered bits
shared uint presentCount;

uint lane() { return gl_LocalInvocationID.x; }

// Orders what the workgroup has written before what it reads next.
void synchronize() {
  memoryBarrierBuffer();
  memoryBarrierShared();
  barrier();
}

dmat3 linearOf(Instance instance) {
  return dmat3(dvec3(instance.objectToWorld[0]), dvec3(instance.objectToWorld[1]), dvec3(instance.objectToWorld[2]));
}

// The box of a mesh in object space, that of its root.
ItemBox meshBox(uint64_t nodes) {
  RayNode root = NodesRef(nodes).v[0];
  if (root.b == kRayNone) return ItemBox(root.lowA, root.highA);
  return ItemBox(min(root.lowA, root.lowB), max(root.highA, root.highB));
}

// Returns a corner of the box, relative to the instance's origin, in world space.
dvec3 cornerOf(dmat3 linear, ItemBox box, uint corner) {
  return linear * dvec3((corner & 1u) != 0u ? box.high.x : box.low.x, (corner & 2u) != 0u ? box.high.y : box.low.y,
                        (corner & 4u) != 0u ? box.high.z : box.low.z);
}

// Returns bounds that contain the vertices as shaders place them.
ItemBox worldBox(Instance instance, ItemBox mesh) {
  dmat3 linear = linearOf(instance);
  dvec3 translation = dvec3(instance.objectToWorld[3]), low = cornerOf(linear, mesh, 0u) + translation, high = low;
  for (uint corner = 1u; corner < 8u; ++corner) {
    dvec3 at = cornerOf(linear, mesh, corner) + translation;
    low = min(low, at);
    high = max(high, at);
  }
  dvec3 extent = max(abs(low), abs(high));
  double slack = kRounding * (extent.x + extent.y + extent.z + length(translation)) + 1e-30lf;
  return ItemBox(vec3(low - slack), vec3(high + slack));
}

// --- order -----------------------------------------------------------------------------------------------------------

// Writes the boxes of all instances, and marks those that rays do not hit. Computes the bounds of the centers.
void writeBoxes(WorldBvhJob job) {
  for (uint i = lane(); i < job.instanceCount; i += kWorldBvhGroup) {
    Instance instance = InstancesRef(job.instances).v[i];
    uint64_t nodes = HierarchiesRef(job.meshes).v[instance.mesh].nodes;
    bool present = nodes != 0ul && (instance.flags & kInstanceAbsent) == 0u;
    KeysRef(job.keys).v[i] = present ? uint64_t(i) : kAbsentKey;
    if (!present) continue;
    ItemBox box = worldBox(instance, meshBox(nodes));
    BoxesRef(job.boxes).v[i] = box;
    atomicAdd(presentCount, 1u);
    vec3 center = 0.5 * box.low + 0.5 * box.high;
    for (uint axis = 0u; axis < 3u; ++axis) {
      atomicMin(lowCenter[axis], orderedBits(center[axis]));
      atomicMax(highCenter[axis], orderedBits(center[axis]));
    }
  }
}

// Returns the ten bits with two zeros after each.
uint spread(uint bits) {
  bits = (bits | bits << 16u) & 0x030000ffu;
  bits = (bits | bits << 8u) & 0x0300f00fu;
  bits = (bits | bits << 4u) & 0x030c30c3u;
  return (bits | bits << 2u) & 0x09249249u;
}

// Completes the keys: the Morton code of the center, and then the instance.
void writeKeys(WorldBvhJob job) {
  vec3 low, scale;
  for (uint axis = 0u; axis < 3u; ++axis) {
    low[axis] = fromOrderedBits(lowCenter[axis]);
    float extent = fromOrderedBits(highCenter[axis]) - low[axis];
    scale[axis] = extent > 0.0 ? 1024.0 / extent : 0.0;
  }
  for (uint i = lane(); i < job.instanceCount; i += kWorldBvhGroup) {
    if (KeysRef(job.keys).v[i] == kAbsentKey) continue;
    ItemBox box = BoxesRef(job.boxes).v[i];
    uvec3 cell = uvec3(clamp((0.5 * box.low + 0.5 * box.high - low) * scale, 0.0, 1023.0));
    uint code = spread(cell.x) | spread(cell.y) << 1u | spread(cell.z) << 2u;
    KeysRef(job.keys).v[i] = packUint2x32(uvec2(i, code));
  }
}

// Sorts the keys: a bitonic sorting network whose comparisons all have one direction, so that it fits any number of
// keys (Batcher 1968, Sorting Networks and Their Applications).
void sortKeys(uint64_t keys, uint count) {
  for (uint size = 2u; size < 2u * count; size *= 2u)
    for (uint step = size / 2u; step > 0u; step /= 2u) {
      uint flip = step == size / 2u ? size - 1u : step;  // the first step mirrors the upper half
      for (uint i = lane(); i < count; i += kWorldBvhGroup) {
        uint other = i ^ flip;
        if (other <= i || other >= count) continue;
        uint64_t a = KeysRef(keys).v[i], b = KeysRef(keys).v[other];
        if (a <= b) continue;
        KeysRef(keys).v[i] = b;
        KeysRef(keys).v[other] = a;
      }
      synchronize();
    }
}

// --- leaves ----------------------------------------------------------------------------------------------------------

// Sets the rows of the transform to object space. An axis that the instance flattens has no inverse: its boxes become
// unbounded, so that rays visit all of them along this axis.
void setRows(inout RayInstance record, dmat3 linear) {
  bool flattened[3];
  for (uint axis = 0u; axis < 3u; ++axis) {
    flattened[axis] = length(linear[axis]) <= 1e-30lf;
    dvec3 normal = cross(linear[(axis + 1u) % 3u], linear[(axis + 2u) % 3u]);
    if (flattened[axis] && length(normal) > 0.0lf) linear[axis] = normal / length(normal);
  }
  double determinant = dot(linear[0], cross(linear[1], linear[2]));
  for (uint axis = 0u; axis < 3u; ++axis) {
    dvec3 row = cross(linear[(axis + 1u) % 3u], linear[(axis + 2u) % 3u]) / determinant;
    double size = length(row);
    bool usable = !flattened[axis] && size < 1e30lf;
    record.rows[axis] = usable ? vec4(vec3(row), float(size * kRounding)) : vec4(vec3(0.0), uintBitsToFloat(0x7f800000u));
  }
}

uint rayFlags(WorldBvhJob job, Instance instance) {
  MaterialRef material = MaterialRef(job.materials + uint64_t(instance.material) * kMaterialBytes);
  uint flags = rayAlphaFlags(material.v.flags, material.v.textures, instance.flags);
  if ((material.v.flags & kMaterialDoubleSided) != 0u) flags |= kRayDoubleSided;
  if (translucent(material.v.flags)) flags |= kRayTranslucent;
  if ((instance.flags & kInstanceClockwise) != 0u) flags |= kRayClockwise;
  return flags;
}

void writeInstances(WorldBvhJob job, uint count) {
  for (uint i = lane(); i < count; i += kWorldBvhGroup) {
    uint item = unpackUint2x32(KeysRef(job.keys).v[i]).x;
    Instance instance = InstancesRef(job.instances).v[item];
    MeshHierarchy hierarchy = HierarchiesRef(job.meshes).v[instance.mesh];
    ItemBox mesh = meshBox(hierarchy.nodes);
    dmat3 linear = linearOf(instance);
    double reach = 0.0lf;
    for (uint corner = 0u; corner < 8u; ++corner) reach = max(reach, length(cornerOf(linear, mesh, corner)));
    RayInstance record;
    setRows(record, linear);
    record.nodes = hierarchy.nodes;
    record.triangles = hierarchy.triangles;
    record.reach = float(reach * (1.0lf + kRounding));
    record.instance = item;
    record.flags = rayFlags(job, instance);
    record.padding = 0u;
    RayInstancesRef(job.rayInstances).v[i] = record;
  }
}

// --- nodes by clustering ---------------------------------------------------------------------------------------------

const uint kMaxClustered = kWorldBvhGroup;  // one cluster per invocation
// After these rounds, clusters are merged in order, so that the depth is at most 16 + 6, within kMaxInstanceDepth.
const uint kNearestRounds = 16u;

shared vec3 clusterLows[kMaxClustered], clusterHighs[kMaxClustered];
shared uint clusterNodes[kMaxClustered];  // RayNode::a of the parent
shared uint clusterNearest[kMaxClustered];
shared uint mergingBits[2], absorbedBits[2];  // a bit per cluster that merges with a later one, or with an earlier one

// Returns a number that increases with half the surface of the box of both clusters, up to a difference of 1/512. At
// equal surfaces, such as those of a regular grid, it is lowest for an even cluster and the next one, so that all of
// them merge in the same round. It is symmetric, and differs between all partners of a cluster, so each round merges at
// least one pair.
uint mergeCost(uint a, uint b) {
  const uint kSurface = ~0u << 14u;  // the bits that keep nine of the mantissa
  vec3 extent = max(clusterHighs[a], clusterHighs[b]) - min(clusterLows[a], clusterLows[b]);
  float area = extent.x * extent.y + extent.y * extent.z + extent.z * extent.x;
  return (floatBitsToUint(area) & kSurface) | (a ^ b);
}

uint nearestCluster(uint cluster, uint count) {
  uint nearest = cluster, lowest = ~0u;
  for (uint i = 0u; i < count; ++i) {
    uint cost = mergeCost(cluster, i);
    if (i == cluster || cost >= lowest) continue;
    lowest = cost;
    nearest = i;
  }
  return nearest;
}

// Returns how many of the first `count` bits are set.
uint bitsBefore(uint bits[2], uint count) {
  uint low = count < 32u ? (1u << count) - 1u : ~0u, high = count > 32u ? (1u << (count - 32u)) - 1u : 0u;
  return uint(bitCount(bits[0] & low) + bitCount(bits[1] & high));
}

void writeMerged(WorldBvhJob job, uint index, RayNode node) {
  node.parent = kRayNone;
  node.refitted = 0u;
  NodesRef(job.nodes).v[index] = node;
  if ((node.a & kRayLeaf) == 0u) NodesRef(job.nodes).v[node.a].parent = index;
  if ((node.b & kRayLeaf) == 0u) NodesRef(job.nodes).v[node.b].parent = index;
}

// Merges the clusters that have found each other. The merged ones and the others keep their order. `end`: the number of
// nodes that are not written yet; the last ones are written first, so that the root becomes node 0. Returns the number
// of pairs.
uint mergeClusters(WorldBvhJob job, uint count, uint end) {
  uint i = lane(), other = i < count ? clusterNearest[i] : i;
  bool pairs = other != i && other < count && clusterNearest[other] == i;
  bool merges = pairs && i < other, absorbed = pairs && i > other;
  if (merges) atomicOr(mergingBits[i / 32u], 1u << (i & 31u));
  if (absorbed) atomicOr(absorbedBits[i / 32u], 1u << (i & 31u));
  RayNode node;
  node.lowA = clusterLows[i];
  node.highA = clusterHighs[i];
  node.a = clusterNodes[i];
  node.lowB = clusterLows[merges ? other : i];
  node.highB = clusterHighs[merges ? other : i];
  node.b = clusterNodes[merges ? other : i];
  synchronize();
  uint reference = merges ? end - 1u - bitsBefore(mergingBits, i) : node.a;
  if (merges) writeMerged(job, reference, node);
  if (i < count && !absorbed) {
    uint kept = i - bitsBefore(absorbedBits, i);
    clusterLows[kept] = min(node.lowA, node.lowB);
    clusterHighs[kept] = max(node.highA, node.highB);
    clusterNodes[kept] = reference;
  }
  return uint(bitCount(mergingBits[0]) + bitCount(mergingBits[1]));
}

// Writes the nodes of at least two instances.
void writeClusters(WorldBvhJob job, uint count) {
  if (lane() < count) {
    ItemBox box = BoxesRef(job.boxes).v[unpackUint2x32(KeysRef(job.keys).v[lane()]).x];
    clusterLows[lane()] = box.low;
    clusterHighs[lane()] = box.high;
    clusterNodes[lane()] = kRayLeaf | lane();
  }
  synchronize();
  uint end = count - 1u, left = count;
  for (uint round = 0u; left > 1u; ++round) {
    if (lane() < 2u) mergingBits[lane()] = absorbedBits[lane()] = 0u;
    if (lane() < left) clusterNearest[lane()] = round < kNearestRounds ? nearestCluster(lane(), left) : lane() ^ 1u;
    synchronize();
    uint merged = mergeClusters(job, left, end);
    end -= merged;
    left -= merged;
    synchronize();
  }
}

// --- nodes of a complete tree ----------------------------------------------------------------------------------------

// The tree in the order of a heap: `count` leaves follow count - 1 inner nodes, and the children of node i are 2i + 1
// and 2i + 2. The leaves of the last level precede the others in Morton order.
struct Heap {
  uint count;
  uint lastLevel;  // the first node of the last level
};

uint leafReference(Heap heap, uint node) {
  uint deep = 2u * heap.count - 1u - heap.lastLevel;  // leaves of the last level
  uint leaf = node >= heap.lastLevel ? node - heap.lastLevel : deep + node - (heap.count - 1u);
  return kRayLeaf | leaf;
}

ItemBox childBox(WorldBvhJob job, uint reference) {
  if ((reference & kRayLeaf) != 0u) {
    uint item = unpackUint2x32(KeysRef(job.keys).v[reference & kRayFirstMask]).x;
    return BoxesRef(job.boxes).v[item];
  }
  RayNode node = NodesRef(job.nodes).v[reference];
  return ItemBox(min(node.lowA, node.lowB), max(node.highA, node.highB));
}

void writeNode(WorldBvhJob job, Heap heap, uint index) {
  RayNode node;
  uint inner = heap.count - 1u, a = 2u * index + 1u, b = a + 1u;
  node.a = a < inner ? a : leafReference(heap, a);
  node.b = b < inner ? b : leafReference(heap, b);
  if (heap.count == 1u) node.b = kRayNone;
  if (heap.count == 1u) node.a = kRayLeaf;
  ItemBox boxA = childBox(job, node.a), boxB = boxA;
  if (node.b != kRayNone) boxB = childBox(job, node.b);
  node.lowA = boxA.low;
  node.highA = boxA.high;
  node.lowB = boxB.low;
  node.highB = boxB.high;
  node.parent = index == 0u ? kRayNone : (index - 1u) / 2u;
  node.refitted = 0u;
  NodesRef(job.nodes).v[index] = node;
}

// Writes the nodes level by level from below.
void writeNodes(WorldBvhJob job, uint count) {
  uint depth = count <= 1u ? 0u : uint(findMSB(count - 1u)) + 1u, inner = max(count - 1u, 1u);
  Heap heap = Heap(count, (1u << depth) - 1u);
  for (uint level = max(depth, 1u); level-- > 0u;) {
    uint end = min((2u << level) - 1u, inner);
    for (uint i = (1u << level) - 1u + lane(); i < end; i += kWorldBvhGroup) writeNode(job, heap, i);
    synchronize();
  }
}

// Returns the job with the addresses of a world's own lists.
WorldBvhJob jobOf(WorldBvhJob all, uint world) {
  WorldBvhJob job = all;
  uint64_t first = uint64_t(world) * all.instanceCount;
  job.instances += first * kInstanceBytes;
  job.keys += first * 8ul;
  job.boxes += first * 24ul;
  job.rayInstances += first * kRayInstanceBytes;
  job.nodes += uint64_t(world) * all.nodeCount * kRayNodeBytes;
  return job;
}

void main() {
  WorldBvhJob all = JobRef(push.job).v;
  for (uint world = gl_WorkGroupID.x; world < all.worlds; world += gl_NumWorkGroups.x) {
    WorldBvhJob job = jobOf(all, world);
    if (lane() < 3u) lowCenter[lane()] = ~0u, highCenter[lane()] = 0u;
    if (lane() == 0u) presentCount = 0u;
    synchronize();
    writeBoxes(job);
    synchronize();
    writeKeys(job);
    synchronize();
    sortKeys(job.keys, job.instanceCount);
    uint count = presentCount;
    writeInstances(job, count);
    if (count > 1u && count <= kMaxClustered)
      writeClusters(job, count);
    else if (count > 0u)
      writeNodes(job, count);
    if (lane() == 0u) {
      RayScene scene = job.scene;
      scene.nodes = job.nodes;
      scene.instances = job.rayInstances;
      scene.instanceCount = count;
      ScenesRef(job.scenes).v[world] = scene;
    }
    synchronize();
  }
}
