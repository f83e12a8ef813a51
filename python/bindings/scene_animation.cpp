// Binds the nodes, skins and animations that a program adds to a scene, and the deformations of its meshes.
#include "scene.h"

#include "bindings.h"
#include "fields.h"

#include <fmt/ranges.h>

namespace latelight::python {

namespace {

// A channel whose values keep the shape (rows, columns) of the array that they came from.
struct ChannelRows : AnimationChannel {
  size_t columns = 3;
};

constexpr const char* kProperties[] = {"translation", "rotation", "scale", "weights",
                                       "visible"};                            // in the order of AnimatedProperty
constexpr const char* kInterpolations[] = {"step", "linear", "cubicspline"};  // in the order of Interpolation

template <typename Enum, size_t N>
Enum enumOf(nb::handle value, const char* name, const char* const (&names)[N]) {
  const std::string text = textOf(value, name);
  const auto* found = std::find(std::begin(names), std::end(names), text);
  if (found == std::end(names)) badValue("{} must be one of {}, not \"{}\"", name, fmt::join(names, ", "), text);
  return static_cast<Enum>(found - std::begin(names));
}

void setValues(ChannelRows& channel, nb::handle value, const char* name) {
  FloatArray array = floatsOf(value, name, {-1, -1});
  channel.values = std::move(array.values);
  channel.columns = static_cast<size_t>(array.shape[1]);
}

nb::object valuesOf(const ChannelRows& channel) {
  const size_t columns = std::max<size_t>(channel.columns, 1);
  return owned(std::vector(channel.values), {channel.values.size() / columns, columns});
}

void bindChannel(nb::module_& module) {
  Fields<ChannelRows>(
      module, "AnimationChannel",
      "Keyframes of one property of a node, as glTF 2.0 defines them (3.11), for Scene.add_animation().")
      .text("node", &ChannelRows::node, "its path")
      .field(
          "interpolation", "str", "step, linear or cubicspline",
          [](const ChannelRows& c) { return nb::str(kInterpolations[static_cast<size_t>(c.interpolation)]); },
          [](ChannelRows& c, nb::handle value, const char* name) {
            c.interpolation = enumOf<Interpolation>(value, name, kInterpolations);
          })
      .field(
          "times", "numpy.ndarray", "(K,): seconds, at least 0, ascending",
          [](const ChannelRows& c) { return owned(std::vector(c.times), {c.times.size()}); },
          [](ChannelRows& c, nb::handle value, const char* name) { c.times = floatsOf(value, name, {-1}).values; })
      .field("values", "numpy.ndarray",
             "(K, N): N is 3, 4 for a rotation (x, y, z, w), the number of morph targets for weights, and 1 for "
             "visible;\ncubicspline: (3 K, N), in-tangent, value and out-tangent of each key",
             valuesOf, setValues)
      // The last one: in the stub, @property after it would name the field and not the builtin.
      .field(
          "property", "str", "translation, rotation, scale, weights or visible",
          [](const ChannelRows& c) { return nb::str(kProperties[static_cast<size_t>(c.property)]); },
          [](ChannelRows& c, nb::handle value, const char* name) {
            c.property = enumOf<AnimatedProperty>(value, name, kProperties);
          })
      .done();
}

// --- nodes, skins and animations
// --------------------------------------------------------------------------------------

NodeData nodeOf(nb::handle name, nb::handle parent, nb::handle translation, nb::handle rotation, nb::handle scale,
                nb::handle matrix, nb::handle parts, nb::handle weights) {
  NodeData node;
  node.name = textOf(name, "name");
  node.parent = textOf(parent, "parent");
  node.translation = numbersOf<double, 3>(translation, "translation");
  node.rotation = numbersOf<double, 4>(rotation, "rotation");
  node.scale = numbersOf<double, 3>(scale, "scale");
  if (!matrix.is_none()) node.matrix = matrixOf<4, 4>(matrix, "matrix");
  for (const nb::handle item : itemsOf(parts, "parts", "a list of pairs of a mesh and a material")) {
    const nb::list pair = itemsOf(item, "parts", "a list of pairs of a mesh and a material");
    if (pair.size() != 2) badValue("parts must be pairs of a mesh and a material, and one has {} items", pair.size());
    node.parts.push_back({objectOf<Handle<Mesh>>(pair[0], "parts", "pairs of a MeshHandle and a MaterialHandle"),
                          objectOf<Handle<Material>>(pair[1], "parts", "pairs of a MeshHandle and a MaterialHandle")});
  }
  node.weights = floatsOf(weights, "weights", {-1}).values;
  return node;
}

Skin skinOf(nb::handle joints, nb::handle inverseBind) {
  Skin skin{.joints = textsOf(joints, "joints"), .inverseBind = {}};
  if (inverseBind.is_none()) return skin;
  const std::vector<double> numbers =
      doublesOf(inverseBind, "inverse_bind", {static_cast<int64_t>(skin.joints.size()), 4, 4});
  skin.inverseBind.resize(skin.joints.size());
  for (size_t i = 0; i < numbers.size(); ++i) skin.inverseBind[i / 16][i % 16] = numbers[i];
  return skin;
}

std::vector<std::array<float, 3>> deltasOf(const nb::dict& target, const char* key, size_t positions) {
  if (!target.contains(key) || nb::object(target[key]).is_none()) return {};
  const std::string name = fmt::format("the {} of a target", key);
  auto rows = rowsOf<3>(nb::object(target[key]), name);
  if (rows.size() != positions)
    badValue("{} must have a row for each of the {} positions, not {}", name, positions, rows.size());
  return rows;
}

}  // namespace

void deformationOf(nb::handle targets, nb::handle skin, nb::handle joints, nb::handle jointWeights, MeshData& mesh) {
  const size_t count = mesh.positions.size();
  for (const nb::handle item : itemsOf(targets, "targets", "a list of dicts of arrays")) {
    if (!nb::hasattr(item, "keys")) badType("targets must be a list of dicts of arrays, not of {}", typeName(item));
    const auto target = nb::cast<nb::dict>(nb::module_::import_("builtins").attr("dict")(item));
    for (const auto& [key, value] : target)
      if (const std::string name = shown(nb::borrow(key));
          name != "positions" && name != "normals" && name != "tangents")
        badValue("a target has positions, normals and tangents, but no \"{}\"", name);
    mesh.targets.push_back({deltasOf(target, "positions", count), deltasOf(target, "normals", count),
                            deltasOf(target, "tangents", count)});
  }
  if (!skin.is_none()) mesh.skin = objectOf<Handle<Skin>>(skin, "skin", "a SkinHandle");
  if (joints.is_none() != jointWeights.is_none()) badValue("joints and joint_weights must be given together");
  if (joints.is_none()) return;
  const auto rows = static_cast<int64_t>(count);
  const nb::object array = arrayOf(joints, "joints", Elements::Integers, {rows, -1}, "int64");
  const auto view = viewOf<int64_t>(array);
  for (size_t i = 0; i < view.size(); ++i) {
    if (view.data()[i] < 0 || view.data()[i] > UINT32_MAX)
      badValue("joints must be indices into those of the skin, and one is {}", view.data()[i]);
    mesh.joints.push_back(static_cast<uint32_t>(view.data()[i]));
  }
  const FloatArray weights =
      floatsOf(jointWeights, "joint_weights", {rows, static_cast<int64_t>(lengthOf(array, 1))}, Integers::Normalized);
  mesh.jointWeights = weights.values;
}

void defineAnimation(nb::module_& module, nb::class_<SharedScene>& type) {
  bindChannel(module);
  type.def(
      "add_node",
      [](SharedScene& s, nb::handle name, nb::handle parent, nb::handle translation, nb::handle rotation,
         nb::handle scale, nb::handle matrix, nb::handle parts, nb::handle weights) {
        const NodeData node = nodeOf(name, parent, translation, rotation, scale, matrix, parts, weights);
        return s.edit([&](Scene& s) { return s.addNode(node); });
      },
      argument("name") = "", argument("parent") = "", argument("translation") = nb::make_tuple(0, 0, 0),
      argument("rotation") = nb::make_tuple(0, 0, 0, 1), argument("scale") = nb::make_tuple(1, 1, 1),
      argument("matrix") = nb::none(), argument("parts") = nb::make_tuple(), argument("weights") = nb::make_tuple(),
      nb::sig("def add_node(self, name: str = \"\", parent: str = \"\", translation: numpy.typing.ArrayLike = (0, 0, "
              "0), rotation: numpy.typing.ArrayLike = (0, 0, 0, 1), scale: numpy.typing.ArrayLike = (1, 1, 1), "
              "matrix: numpy.typing.ArrayLike | None = None, parts: "
              "collections.abc.Sequence[tuple[MeshHandle, MaterialHandle]] = (), weights: numpy.typing.ArrayLike = ()) "
              "-> str"),
      "Adds a node that animations can move, and returns its path.\n\nparent: its path; empty: the node is a "
      "root\ntranslation, rotation (a quaternion x, y, z, w), scale: relative to the parent\nmatrix: (4, 4) in place "
      "of these three, which animations then cannot change\nparts: the meshes that the node shows, with their "
      "materials; "
      "a mesh with targets can be part of one node only\nweights: of the meshes' targets, at rest; empty: zeros");
  type.def(
      "set_node_transform",
      [](SharedScene& s, nb::handle node, nb::handle transform) {
        const std::string path = textOf(node, "node");
        const Transform matrix = matrixOf<4, 4>(transform, "transform");
        s.edit([&](Scene& s) { s.setNodeTransform(path, matrix); });
      },
      argument("node"), argument("transform"),
      nb::sig("def set_node_transform(self, node: str, transform: numpy.typing.ArrayLike) -> None"),
      "Moves a node, by its path, and all that follows it.\n\ntransform: (4, 4), relative to the parent, in the rest "
      "pose; animations of the node override it");
  type.def(
      "add_skin",
      [](SharedScene& s, nb::handle joints, nb::handle inverseBind) {
        const Skin skin = skinOf(joints, inverseBind);
        return s.edit([&](Scene& s) { return s.addSkin(skin); });
      },
      argument("joints"), argument("inverse_bind") = nb::none(),
      nb::sig("def add_skin(self, joints: collections.abc.Sequence[str], inverse_bind: numpy.typing.ArrayLike | None = "
              "None) -> SkinHandle"),
      "Adds joints that deform meshes, by the paths of their nodes.\n\ninverse_bind: (J, 4, 4): from the object space "
      "of the meshes to each joint; without it identities");
  type.def(
      "add_animation",
      [](SharedScene& s, nb::handle name, nb::handle channels) {
        const std::string text = textOf(name, "name");
        std::vector<AnimationChannel> all;
        for (const nb::handle item : itemsOf(channels, "channels", "a list of AnimationChannel"))
          all.push_back(objectOf<ChannelRows>(item, "channels", "a list of AnimationChannel"));
        s.edit([&](Scene& s) { s.addAnimation(text, all); });
      },
      argument("name"), argument("channels"),
      nb::sig("def add_animation(self, name: str, channels: collections.abc.Sequence[AnimationChannel]) -> None"),
      "Adds an animation, which the options `time`, `animation` and `loop` play.");
}

}  // namespace latelight::python
