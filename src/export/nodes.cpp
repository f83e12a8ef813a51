// Writes nodes. Names and parents are those of the scene, so that paths, and with them ids, stay the same when the file
// is loaded. Transforms are in glTF's frame: a node whose parent and local transform multiply to its place is written
// as it is; one that an edit has moved gets the local transform that leads there. No local transform does if the scale
// of the parent is 0 along an axis: such a node becomes a root.
//
// Copies by EXT_mesh_gpu_instancing become nodes below theirs, named as the ids of copies are made.
//
// glTF has no meshes without triangles: their nodes are written without a mesh.
//
// glTF ignores the transform of a node with a skin (3.7.3.3). An instance of a skinned mesh that an edit or
// EXT_mesh_gpu_instancing has placed therefore has joints of its own, below a node with its transform.
#include "export/nodes.h"

#include <algorithm>
#include <glm/gtc/matrix_transform.hpp>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <utility>

#include "base/log.h"
#include "export/document_nodes.h"
#include "export/meshes.h"
#include "scene/decompose.h"
#include "scene/objects.h"
#include "scene/rig_edit.h"
#include "scene/tangents.h"

namespace latelight::exports {
namespace {

using namespace scene;

bool flattens(const dmat4& toWorld) {
  return glm::determinant(toWorld) == 0;
}

// Instances of a node that are at the same place and visible alike. Those that an edit has placed have the same skin.
struct Group {
  dmat4 toWorld{1};
  bool hidden = false;
  bool follows = false;  // an animated node moves it
  int copy = -1;
  int skin = -1;  // index into Rig::skins
  std::vector<uint32_t> instances;
};

class NodeWriter {
 public:
  NodeWriter(const Scene& scene, Document& document, Exported& exported)
      : scene_(scene),
        document_(document),
        exported_(exported),
        meshes_(scene, document),
        nodes_{.document = document} {
    for (const VariantMaterial& v : scene.variantMaterials) {
      variants_[v.instance].push_back({v.variant, exported.materials[v.material]});
      if (requiresOtherTangents(v)) omitsTangents_.insert(v.instance);
    }
  }

  void run() {
    collectInstances();
    if (scene_.rig.empty())
      addSceneNodes();
    else
      addRigNodes();
    for (uint32_t node = 0; node < scene_.nodes.size(); ++node)
      if (nodes_.ofScene[node] >= 0) addMeshes(node);
    addLights(scene_, nodes_, exported_.lights);
    addCameras(scene_, nodes_, exported_.cameras);
    keepPaths();
    Json scene = Json::object();  // without nodes if there are none, because a list has at least one
    for (const size_t root : findRoots()) arrayIn(scene, "nodes").push_back(root);
    document_.root["scene"] = 0;
    document_.add("scenes", std::move(scene));
  }

 private:
  // True if the mesh's tangents were generated for the instance's material, and those that the variant requires differ.
  // A file without tangents leads to both.
  bool requiresOtherTangents(const VariantMaterial& v) const {
    const Instance& instance = scene_.instances[v.instance];
    const std::optional<TangentSpace>& space = meshes_.meshAt(instance.mesh).tangentSpace;
    const auto required = tangentSpaceOf(scene_.materials[v.material]);
    return space && space == tangentSpaceOf(scene_.materials[instance.material]) && required && required != space;
  }

  // Instances that follow an animated node are at one place.
  void collectInstances() {
    groups_.resize(scene_.nodes.size());
    std::map<std::pair<uint32_t, int>, std::vector<size_t>> candidates;  // groups by node and copy
    for (uint32_t i = 0; i < scene_.instances.size(); ++i) {
      const Instance& instance = scene_.instances[i];
      if (instance.removed) continue;
      const bool follows = !scene_.rig.empty() && !instance.placed;
      const Mesh& mesh = scene_.meshes[instance.mesh];
      const int skin = mesh.deformation && !exports::isEmpty(mesh) ? mesh.deformation->skin : -1;
      std::vector<Group>& groups = groups_[instance.node];
      std::vector<size_t>& similar = candidates[{instance.node, instance.copy}];
      const auto isSame = [&](size_t group) {
        return groups[group].hidden == instance.hidden && groups[group].follows == follows &&
               (follows || (groups[group].toWorld == instance.toWorld && groups[group].skin == skin));
      };
      const auto found = std::ranges::find_if(similar, isSame);
      const size_t group = found == similar.end() ? groups.size() : *found;
      if (found == similar.end()) {
        groups.push_back({instance.toWorld, instance.hidden, follows, instance.copy, skin, {}});
        similar.push_back(group);
      }
      groups[group].instances.push_back(i);
      groups[group].skin = std::max(groups[group].skin, skin);
    }
  }

  // Returns the roots of the document's scene. Nodes of the file that are not in its loaded scene are left out, except
  // for trees with joints of skinned meshes, which glTF requires in the scene of the mesh. These are last, so that
  // their names do not change the paths of others.
  std::vector<size_t> findRoots() const {
    std::vector<size_t> roots;
    for (size_t i = 0; i < nodes_.parents.size(); ++i)
      if (nodes_.parents[i] < 0 && !isOutside(i)) roots.push_back(i);
    std::set<size_t> ofJoints;
    for (const std::vector<Group>& groups : groups_)
      for (const Group& group : groups) {
        if (group.skin < 0) continue;
        for (size_t joint : scene_.rig.skins[size_t(group.skin)].joints) {
          if (!isOutside(joint)) continue;
          while (nodes_.parents[joint] >= 0) joint = size_t(nodes_.parents[joint]);
          ofJoints.insert(joint);
        }
      }
    roots.insert(roots.end(), ofJoints.begin(), ofJoints.end());
    return roots;
  }

  // True for nodes of the rig that are not in the scene.
  bool isOutside(size_t node) const { return node < isOutside_.size() && isOutside_[node]; }

  // --- nodes --------------------------------------------------------------------------------------------------------

  // The place of a node, or that of its instances if an edit or a skin has moved all of them. Its path is that of its
  // mesh, so the mesh stays at the node; nodes below get local transforms that keep them where they are.
  void findPlaces() {
    nodes_.places.resize(scene_.nodes.size());
    for (size_t i = 0; i < nodes_.places.size(); ++i) {
      const bool movesAlone = groups_[i].size() == 1 && groups_[i][0].copy < 0 && !flattens(groups_[i][0].toWorld);
      nodes_.places[i] = movesAlone ? groups_[i][0].toWorld : scene_.nodes[i].toWorld;
    }
  }

  bool isRoot(size_t i) const {
    const Node& node = scene_.nodes[i];
    if (node.parent < 0) return true;
    const dmat4& parent = nodes_.places[size_t(node.parent)];
    return flattens(parent) && parent * node.local != nodes_.places[i];
  }

  void warnOfRoot(const std::string& name) const {
    warn("{} was moved below a node whose scale is 0 along an axis: it is exported as a root", name);
  }

  dmat4 localOf(size_t i) const {
    const Node& node = scene_.nodes[i];
    if (isRoot(i))
      return scene_.yUp && toWorldFromGltf() * node.local == nodes_.places[i] ? node.local : inFile(nodes_.places[i]);
    const dmat4& parent = nodes_.places[size_t(node.parent)];
    return parent * node.local == nodes_.places[i] ? node.local : glm::inverse(parent) * nodes_.places[i];
  }

  // Finds the nodes to hide. A scene without a rig knows only which instances and lights are hidden. A node can be
  // hidden in the file if nothing visible is at it or below it.
  void findHidden() {
    const size_t count = scene_.nodes.size();
    std::vector<bool> hasHidden(count), hasVisible(count);
    const auto note = [&](size_t node, bool hidden) { (hidden ? hasHidden : hasVisible)[node] = true; };
    for (const Instance& instance : scene_.instances)
      if (!instance.removed) note(instance.node, instance.hidden);
    for (const Light& light : scene_.lights)
      if (!light.removed && light.node >= 0) note(size_t(light.node), light.hidden);
    for (size_t i = count; i-- > 0;)
      if (scene_.nodes[i].parent >= 0 && hasVisible[i]) hasVisible[size_t(scene_.nodes[i].parent)] = true;
    nodes_.isHidden.resize(count);
    for (size_t i = 0; i < count; ++i) {
      const bool hiddenInFile = i < scene_.fileNodes.size() && !scene_.fileNodes[i].visible;
      nodes_.isHidden[i] = isBelowHidden(i) || (!hasVisible[i] && (hasHidden[i] || hiddenInFile));
    }
  }

  bool isBelowHidden(size_t i) const { return !isRoot(i) && nodes_.isHidden[size_t(scene_.nodes[i].parent)]; }

  void addSceneNodes() {
    findPlaces();
    findHidden();
    nodes_.ofScene.assign(scene_.nodes.size(), -1);
    std::vector<bool> isFree(scene_.nodes.size());
    for (const uint32_t free : scene_.edits.freeNodes) isFree[free] = true;
    for (size_t i = 0; i < scene_.nodes.size(); ++i) {
      if (isFree[i]) continue;
      Json node{{"name", scene_.nodes[i].name}};
      const dmat4 local = localOf(i);
      if (i < scene_.fileNodes.size() && local == scene_.nodes[i].local)
        setTransform(node, scene_.fileNodes[i]);
      else
        setTransform(node, local, nodeScaleSigns(scene_, static_cast<uint32_t>(i)));
      if (nodes_.isHidden[i] && !isBelowHidden(i)) nodes_.hide(node);
      const int parent = scene_.nodes[i].parent;
      const bool root = isRoot(i);
      if (root && parent >= 0) warnOfRoot(scene_.nodes[i].name);
      nodes_.ofScene[i] = nodes_.add(std::move(node), root ? -1 : nodes_.ofScene[size_t(parent)]);
    }
  }

  // The nodes of the rig whose transforms, or those of their parents, animations change.
  std::vector<bool> findMoving() const {
    const Rig& rig = scene_.rig;
    std::vector<bool> moving(rig.nodes.size());
    for (const Animation& animation : rig.animations)
      for (const Track& track : animation.tracks)
        if (track.property <= AnimatedProperty::Scale) moving[track.node] = true;
    for (const uint32_t node : rig.order)
      if (rig.nodes[node].parent >= 0 && moving[size_t(rig.nodes[node].parent)]) moving[node] = true;
    return moving;
  }

  // The nodes of the rig that other nodes, joints, lights or cameras follow.
  std::vector<bool> findFollowed() const {
    const Rig& rig = scene_.rig;
    std::vector<bool> followed(rig.nodes.size());
    for (const RigNode& node : rig.nodes)
      if (node.parent >= 0) followed[size_t(node.parent)] = true;
    for (const Skin& skin : rig.skins)
      for (const uint32_t joint : skin.joints) followed[joint] = true;
    const auto note = [&](int node) {
      if (node >= 0 && size_t(node) < rig.sceneNodes.size()) followed[rig.sceneNodes[size_t(node)]] = true;
    };
    for (const Light& light : scene_.lights) note(light.node);
    for (const Camera& camera : scene_.cameras) note(camera.node);
    return followed;
  }

  // Writes all nodes of the rig in its order, because joints need not be in the scene, and then added ones.
  void addRigNodes() {
    const Rig& rig = scene_.rig;
    const std::vector<bool> isFollowed = findFollowed();
    isMoving_ = findMoving();
    nodes_.places.resize(scene_.nodes.size());
    for (size_t i = 0; i < nodes_.places.size(); ++i) nodes_.places[i] = scene_.nodes[i].toWorld;
    std::vector<const Node*> source(rig.nodes.size());
    std::vector<std::optional<RigNode>> edited(rig.nodes.size());  // nodes that an edit has moved
    for (size_t i = 0; i < rig.sceneNodes.size(); ++i) {
      const uint32_t node = rig.sceneNodes[i];
      source[node] = &scene_.nodes[i];
      const bool isPlaced = groups_[i].size() == 1 && !groups_[i][0].follows && groups_[i][0].copy < 0;
      if (!isPlaced || isFollowed[node] || isMoving_[node]) continue;
      nodes_.places[i] = groups_[i][0].toWorld;
      edited[node] = nodeWithTransform(localOf(i), nodeScaleSigns(scene_, static_cast<uint32_t>(i)));
    }
    for (size_t i = 0; i < rig.nodes.size(); ++i) {
      Json node{{"name", source[i] ? source[i]->name : fmt::format("node{}", i)}};
      setTransform(node, edited[i] ? *edited[i] : rig.nodes[i]);
      if (!rig.nodes[i].visible) nodes_.hide(node);
      document_.add("nodes", std::move(node));
      nodes_.parents.push_back(rig.nodes[i].parent);
      exported_.rigNodes.push_back(static_cast<int>(i));
    }
    for (size_t i = 0; i < rig.nodes.size(); ++i)
      if (nodes_.parents[i] >= 0) arrayIn(nodes_.at(nodes_.parents[i]), "children").push_back(i);
    nodes_.ofScene.assign(rig.sceneNodes.begin(), rig.sceneNodes.end());
    isOutside_.assign(rig.nodes.size(), true);
    for (size_t i = 0; i < nodes_.ofScene.size(); ++i) {
      isOutside_[size_t(nodes_.ofScene[i])] = false;
      if (scene_.nodes[i].parent < 0)
        nodes_.parents[size_t(nodes_.ofScene[i])] = -1;  // a scene may list a node below another one
    }
    nodes_.isHidden.resize(scene_.nodes.size());
    for (uint32_t i = 0; i < rig.sceneNodes.size(); ++i) nodes_.isHidden[i] = isHiddenAtRest(scene_, i);
    for (size_t i = nodes_.ofScene.size(); i < scene_.nodes.size(); ++i) {
      if (scene_.nodes[i].path.empty()) {  // removed
        nodes_.ofScene.push_back(-1);
        continue;
      }
      Json node{{"name", scene_.nodes[i].name}};
      setTransform(node, inFile(nodes_.places[i]), nodeScaleSigns(scene_, static_cast<uint32_t>(i)));
      nodes_.ofScene.push_back(nodes_.add(std::move(node), -1));
    }
  }

  bool isEmpty(const Group& group) const {
    return std::ranges::all_of(group.instances,
                               [&](uint32_t i) { return exports::isEmpty(scene_.meshes[scene_.instances[i].mesh]); });
  }

  // --- meshes -------------------------------------------------------------------------------------------------------

  void addMeshes(uint32_t node) {
    bool isUsed = false;  // a node has one mesh
    for (const Group& group : groups_[node]) {
      if (isEmpty(group)) continue;
      const bool moves = node < scene_.rig.sceneNodes.size() && isMoving_[scene_.rig.sceneNodes[node]];
      const bool isAtNode = group.copy < 0 && (group.follows || (group.toWorld == nodes_.places[node] && !moves));
      const bool isStillCopy = group.copy >= 0 && !moves;  // stays below its node, so that its path and ids stay, too
      if (isAtNode && !isUsed && (group.follows || group.hidden == nodes_.isHidden[node])) {
        isUsed = true;
        setMesh(node, nodes_.ofScene[node], group);
        if (!group.follows) placeSkin(group, nodes_.ofScene[node]);
      } else if (group.follows || scene_.rig.empty() || node >= scene_.rig.sceneNodes.size() || isStillCopy) {
        addBelow(node, group);
      } else {
        addPlaced(node, group);
      }
    }
  }

  // Adds a root node with instances that an edit has placed.
  void addPlaced(uint32_t node, const Group& group) {
    Json placed{{"name", scene_.nodes[node].name}};
    setTransform(placed, inFile(group.toWorld), instanceScaleSigns(scene_, group.instances[0]));
    if (group.hidden) nodes_.hide(placed);
    const int index = nodes_.add(std::move(placed), -1);
    setMesh(node, index, group);
    placeSkin(group, index);
  }

  // Adds the joints of a group's skin again, below the node that places the group.
  void placeSkin(const Group& group, int place) {
    if (group.skin < 0) return;
    Json skeleton{{"name", "skeleton"}};
    setMatrix(skeleton, glm::translate(dmat4(1), -scene_.rig.skins[size_t(group.skin)].origin));
    nodes_.at(place)["skin"] = copySkin(group.skin, nodes_.add(std::move(skeleton), place));
  }

  // Adds the joints of a copy's skin again. They are not below the copy's node, because the nodes above it, which may
  // be animated, do not move a skinned mesh.
  void placeSkinOfCopy(const Group& group, int copy) {
    if (group.skin < 0) return;
    Json skeleton{{"name", fmt::format("{} skeleton", nodes_.at(copy)["name"].get<std::string>())}};
    setOffset(skeleton, group);
    nodes_.at(copy)["skin"] = copySkin(group.skin, nodes_.add(std::move(skeleton), -1));
  }

  // Adds the joints of a skin again, with the nodes above them, below a node. Returns the index of the skin with these.
  size_t copySkin(int index, int below) {
    const Rig& rig = scene_.rig;
    const Skin& skin = rig.skins[size_t(index)];
    std::vector<bool> isNeeded(rig.nodes.size());
    for (const uint32_t joint : skin.joints)
      for (int i = static_cast<int>(joint); i >= 0 && !isNeeded[size_t(i)]; i = rig.nodes[size_t(i)].parent)
        isNeeded[size_t(i)] = true;
    std::vector<int> copies(rig.nodes.size(), below);
    for (const uint32_t i : rig.order) {
      if (!isNeeded[i]) continue;
      Json copy{{"name", nodes_.at(exported_.rigNodes[i])["name"]}};
      setTransform(copy, rig.nodes[i]);
      const size_t above = rig.nodes[i].parent < 0 ? i : size_t(rig.nodes[i].parent);
      copies[i] = nodes_.add(std::move(copy), copies[above]);
      exported_.movedCopies.emplace(i, copies[i]);
    }
    SkinCopy copy{size_t(index), {}};
    for (const uint32_t joint : skin.joints) copy.joints.push_back(copies[joint]);
    exported_.skinCopies.push_back(std::move(copy));
    return rig.skins.size() + exported_.skinCopies.size() - 1;
  }

  // Writes the transform that a copy by EXT_mesh_gpu_instancing has relative to its node in the file.
  void setOffset(Json& node, const Group& group) const {
    const Instance& instance = scene_.instances[group.instances[0]];
    RigNode offset = statedTransform(scene_.fileCopies.at(instance.node), static_cast<size_t>(instance.copy));
    // Integers of the file state rotations that are not of unit length. A rotation of 0 is read as none.
    const double length = glm::length(offset.rotation);
    offset.rotation = length > 0 ? offset.rotation / length : glm::dvec4(0, 0, 0, 1);
    setTransform(node, offset);
  }

  // True if a group of copies is where its node and the file place it.
  bool isAtOffset(uint32_t node, const Group& group) const {
    if (group.copy < 0) return false;
    if (group.follows) return true;
    const dmat4 offset = nodeFromCopy(scene_.fileCopies.at(node), static_cast<size_t>(group.copy));
    return nodes_.places[node] * offset == group.toWorld;
  }

  void addBelow(uint32_t node, const Group& group) {
    const dmat4& parent = nodes_.places[node];
    const bool hasOffset = isAtOffset(node, group);
    const bool leavesParent = !hasOffset && group.toWorld != parent && flattens(parent);
    const std::string name = group.copy >= 0 ? fmt::format("instance{}", group.copy) : scene_.nodes[node].mesh;
    Json below{{"name", name}};
    if (hasOffset)
      setOffset(below, group);
    else if (leavesParent)
      setTransform(below, inFile(group.toWorld), instanceScaleSigns(scene_, group.instances[0]));
    else if (group.toWorld != parent)
      setTransform(below, glm::inverse(parent) * group.toWorld, copyScaleSigns(scene_, group.instances[0]));
    if (leavesParent) warnOfRoot(name);
    const int index = nodes_.add(std::move(below), leavesParent ? -1 : nodes_.ofScene[node]);
    if (group.hidden && (leavesParent || !nodes_.isHidden[node])) nodes_.hide(nodes_.at(index));
    setMesh(node, index, group);
    if (group.follows && group.copy >= 0)
      placeSkinOfCopy(group, index);
    else if (!group.follows)
      placeSkin(group, index);
  }

  void setMesh(uint32_t node, int index, const Group& group) {
    std::vector<Primitive> primitives;
    const Deformation* deformation = nullptr;
    for (const uint32_t i : group.instances) {
      const Instance& instance = scene_.instances[i];
      if (exports::isEmpty(scene_.meshes[instance.mesh])) continue;
      Primitive primitive{.mesh = instance.mesh, .material = exported_.materials[instance.material]};
      if (const auto variants = variants_.find(i); variants != variants_.end()) primitive.variants = variants->second;
      primitive.omitsTangents = omitsTangents_.contains(i);
      primitives.push_back(std::move(primitive));
      if (const auto& own = scene_.meshes[instance.mesh].deformation) deformation = own.get();
    }
    // Meshes are named after the node's; a mesh of several primitives has the numbers of these in the scene's names.
    nodes_.at(index)["mesh"] = meshes_.add(scene_.nodes[node].mesh, primitives);
    if (group.skin >= 0) nodes_.at(index)["skin"] = group.skin;
    if (!deformation || deformation->weightsNode < 0) return;
    const auto source = static_cast<uint32_t>(deformation->weightsNode);
    Json weights = Json::array();
    for (const float weight : scene_.rig.nodes[source].weights) weights.push_back(shortest(weight));
    if (!weights.empty()) nodes_.at(index)["weights"] = std::move(weights);
    if (exported_.rigNodes[source] != index) exported_.morphedCopies.emplace(source, index);
  }

  // --- paths --------------------------------------------------------------------------------------------------------

  // Loading appends "#2" and so on to the paths of siblings of equal names, in their order. Where the scene's path has
  // another number, because an edit has removed or added siblings, the node's name becomes the path's last part.
  void keepPaths() {
    std::vector<int> sources(nodes_.parents.size(), -1);  // nodes of the scene, per node of the document
    for (size_t i = 0; i < nodes_.ofScene.size(); ++i)
      if (nodes_.ofScene[i] >= 0) sources[size_t(nodes_.ofScene[i])] = static_cast<int>(i);
    std::set<std::pair<int, std::string>> used;               // by parent: last parts of paths
    std::map<std::pair<int, std::string>, uint32_t> numbers;  // by parent and name
    for (size_t i = 0; i < sources.size(); ++i) {
      if (isOutside(i)) continue;
      std::string name = nodes_.at(static_cast<int>(i))["name"].get<std::string>();
      if (name.empty()) name = fmt::format("node{}", i);  // as it is loaded
      std::string loaded = name;
      uint32_t& number = numbers.try_emplace({nodes_.parents[i], name}, 1).first->second;
      while (used.contains({nodes_.parents[i], loaded})) loaded = fmt::format("{}#{}", name, ++number);
      const std::string last = sources[i] < 0 ? loaded : lastPartOf(scene_.nodes[size_t(sources[i])], loaded);
      used.insert({nodes_.parents[i], last});
      if (last != loaded) nodes_.at(static_cast<int>(i))["name"] = last;
    }
  }

  std::string lastPartOf(const Node& node, const std::string& otherwise) const {
    const std::string above = (node.parent < 0 ? "" : scene_.nodes[size_t(node.parent)].path) + "/";
    return node.path.starts_with(above) ? node.path.substr(above.size()) : otherwise;
  }

  const Scene& scene_;
  Document& document_;
  Exported& exported_;
  MeshWriter meshes_;
  DocumentNodes nodes_;
  std::map<uint32_t, std::vector<std::pair<uint32_t, int>>> variants_;  // by instance
  std::set<uint32_t> omitsTangents_;                                    // instances: requiresOtherTangents()
  std::vector<std::vector<Group>> groups_;                              // per node of the scene
  std::vector<bool> isMoving_;                                          // per node of the rig
  std::vector<bool> isOutside_;                                         // per node of the rig: not in the scene
};

}  // namespace

void addNodes(const Scene& scene, Document& document, Exported& exported) {
  NodeWriter(scene, document, exported).run();
}

}  // namespace latelight::exports
