#include "options/everything.h"

#include <cmath>
#include <glm/gtc/quaternion.hpp>

#include "output/png.h"
#include "scene/gltf_builder.h"

namespace latelight::app {

namespace {

using glm::vec2;
using glm::vec3;
using glm::vec4;
using nlohmann::json;
using scene::test::GltfBuilder;

constexpr int kFront = 0;  // the node of the animated camera

json quaternion(float degrees, vec3 axis) {
  const glm::quat q = glm::angleAxis(glm::radians(degrees), axis);
  return {q.x, q.y, q.z, q.w};
}

// A square of `cells` by `cells` over [-1, 1]^2 in the XY plane, facing +Z, with v pointing down.
struct Grid {
  std::vector<vec3> positions;
  std::vector<vec2> uv;
  std::vector<uint16_t> indices;

  explicit Grid(int cells) {
    for (int y = 0; y <= cells; ++y)
      for (int x = 0; x <= cells; ++x) {
        const vec2 share(static_cast<float>(x) / static_cast<float>(cells),
                         static_cast<float>(y) / static_cast<float>(cells));
        positions.emplace_back(2.0f * share - 1.0f, 0);
        uv.emplace_back(share.x, 1 - share.y);
      }
    for (int y = 0; y < cells; ++y)
      for (int x = 0; x < cells; ++x) {
        const int a = y * (cells + 1) + x, c = a + cells + 1;
        for (int i : {a, a + 1, c + 1, a, c + 1, c}) indices.push_back(static_cast<uint16_t>(i));
      }
  }
};

json primitiveOf(GltfBuilder& file, const Grid& grid, int material) {
  const std::vector<vec3> normals(grid.positions.size(), vec3(0, 0, 1));
  return {
      {"attributes",
       {{"POSITION", file.positions(grid.positions)},
        {"NORMAL", file.vectors(normals)},
        {"TEXCOORD_0", file.vectors(grid.uv)}}},
      {"indices", file.accessor(file.view(grid.indices), scene::test::kUnsignedShort, "SCALAR", grid.indices.size())},
      {"material", material}};
}

int meshOf(GltfBuilder& file, json primitive) {
  return file.add("meshes", {{"primitives", json::array({std::move(primitive)})}});
}

int place(GltfBuilder& file, const char* name, int mesh, vec3 at, vec3 scale, json more = json::object()) {
  more["name"] = name;
  more["mesh"] = mesh;
  more["translation"] = {at.x, at.y, at.z};
  more["scale"] = {scale.x, scale.y, scale.z};
  return file.node(more);
}

// A checkerboard of two colors, eight pixels wide and high.
int addTexture(GltfBuilder& file, glm::u8vec4 even, glm::u8vec4 odd) {
  output::Picture picture{8, 8, {}};
  for (int i = 0; i < 64; ++i) {
    const glm::u8vec4 color = (i % 8 / 2 + i / 16) % 2 ? odd : even;
    for (int c = 0; c < 4; ++c) picture.rgba.push_back(color[c]);
  }
  const int image =
      file.add("images", {{"bufferView", file.view(output::encodePng(picture))}, {"mimeType", "image/png"}});
  return file.add("textures", {{"source", image}});
}

int addMaterial(GltfBuilder& file, const char* name, vec4 color, float metallic, float roughness,
                const json& more = json::object()) {
  json material = {{"name", name},
                   {"pbrMetallicRoughness",
                    {{"baseColorFactor", {color.r, color.g, color.b, color.a}},
                     {"metallicFactor", metallic},
                     {"roughnessFactor", roughness}}}};
  material.merge_patch(more);
  return file.add("materials", material);
}

// --- surfaces -------------------------------------------------------------------------------------------------------

void addFloorAndWall(GltfBuilder& file) {
  const int colors = addTexture(file, {230, 220, 180, 255}, {60, 100, 140, 255});
  const int bumps = addTexture(file, {150, 128, 240, 255}, {128, 150, 240, 255});
  const int rough = addTexture(file, {255, 60, 255, 255}, {120, 200, 0, 255});  // occlusion, roughness, metalness
  const int tiles =
      addMaterial(file, "tiles", vec4(1), 1, 1,
                  {{"normalTexture", {{"index", bumps}}},
                   {"occlusionTexture", {{"index", rough}}},
                   {"pbrMetallicRoughness",
                    {{"baseColorTexture", {{"index", colors}}}, {"metallicRoughnessTexture", {{"index", rough}}}}}});
  const int floor = meshOf(file, primitiveOf(file, Grid(2), tiles));
  place(file, "floor", floor, vec3(0), {4, 3, 1}, {{"rotation", quaternion(-90, vec3(1, 0, 0))}});
  const int wall = meshOf(file, primitiveOf(file, Grid(1), addMaterial(file, "wall", vec4(0.7f, 0.6f, 0.6f, 1), 0, 1)));
  place(file, "wall", wall, {0.5f, 1.5f, -2.5f}, {3, 1.5f, 1});  // next to it the background is visible
}

// Brushed metal with a clear coat, a cloth, and a pane of colored glass.
template <typename Card>
void addLayeredCards(GltfBuilder& file, const Card& card) {
  const auto layered = [&](const char* name, vec4 color, float metallic, json extensions) {
    for (const auto& [extension, value] : extensions.items()) file.use(extension.c_str());
    return addMaterial(file, name, color, metallic, 0.4f, {{"extensions", std::move(extensions)}});
  };
  card("lacquer",
       layered("lacquer", vec4(0.8f, 0.5f, 0.2f, 1), 1,
               {{"KHR_materials_clearcoat", {{"clearcoatFactor", 1}}},
                {"KHR_materials_anisotropy", {{"anisotropyStrength", 0.6}}},
                {"KHR_materials_iridescence", {{"iridescenceFactor", 0.5}}}}),
       {-1.5f, 0.7f, 0.8f}, 15);
  card("cloth",
       layered("cloth", vec4(0.2f, 0.1f, 0.4f, 1), 0,
               {{"KHR_materials_sheen", {{"sheenColorFactor", {0.8, 0.6, 0.9}}, {"sheenRoughnessFactor", 0.4}}},
                {"KHR_materials_diffuse_transmission", {{"diffuseTransmissionFactor", 0.4}}}}),
       {1.6f, 0.7f, 0.6f}, -30);
  card("lens",
       layered("lens", vec4(0.9f, 1, 0.9f, 1), 0,
               {{"KHR_materials_transmission", {{"transmissionFactor", 0.9}}},
                {"KHR_materials_volume", {{"thicknessFactor", 0.2}}},
                {"KHR_materials_dispersion", {{"dispersion", 2}}}}),
       {0.3f, 0.8f, 1.4f}, 5);
}

void addCards(GltfBuilder& file, const Kinds& kinds) {
  const int holes = addTexture(file, {220, 90, 60, 255}, {220, 90, 60, 0});
  const int panes = addTexture(file, {90, 200, 90, 160}, {200, 200, 255, 0});
  const auto card = [&](const char* name, int material, vec3 at, float degrees) {
    place(file, name, meshOf(file, primitiveOf(file, Grid(1), material)), at, vec3(0.6f),
          {{"rotation", quaternion(degrees, vec3(0, 1, 0))}});
  };
  const auto textured = [](int texture) {
    return json{{"pbrMetallicRoughness", {{"baseColorTexture", {{"index", texture}}}}}};
  };
  if (kinds.masked) {
    json masked = textured(holes);
    masked.update({{"alphaMode", "MASK"}, {"doubleSided", true}});
    card("masked", addMaterial(file, "masked", vec4(1), 0, 0.6f, masked), {-2.2f, 0.8f, 0.4f}, 200);
  }
  if (kinds.blended) {
    json pane = textured(panes);
    pane.update({{"alphaMode", "BLEND"}, {"doubleSided", true}});
    card("pane", addMaterial(file, "pane", vec4(1), 0, 0.2f, pane), {-0.7f, 0.9f, 1.2f}, 25);
    card("glass", addMaterial(file, "glass", vec4(0.6f, 0.8f, 1, 0.3f), 0, 0.05f, {{"alphaMode", "BLEND"}}),
         {-0.4f, 1, 1.5f}, -20);
  }
  if (kinds.layered) addLayeredCards(file, card);
  if (!kinds.opaque) return;
  file.use("KHR_materials_unlit");
  card("unlit",
       addMaterial(file, "unlit", vec4(0.2f, 0.9f, 0.4f, 1), 0, 1,
                   {{"extensions", {{"KHR_materials_unlit", json::object()}}}}),
       {2.6f, 0.7f, -0.5f}, 0);
  card("glow", addMaterial(file, "glow", vec4(0, 0, 0, 1), 0, 0.5f, {{"emissiveFactor", {1, 0.5, 0.1}}}),
       {-2.8f, 1.6f, -1.5f}, 10);
}

// Boxes with only positions: one whose variant selects one of two materials, and a mirrored one.
void addBoxes(GltfBuilder& file) {
  file.use("KHR_materials_variants");
  file.root["extensions"]["KHR_materials_variants"]["variants"] = {{{"name", "red"}}, {{"name", "blue"}}};
  const int red = addMaterial(file, "red", vec4(0.8f, 0.1f, 0.1f, 1), 0, 0.4f),
            blue = addMaterial(file, "blue", vec4(0.1f, 0.2f, 0.9f, 1), 1, 0.3f);
  std::vector<vec3> corners;
  for (int i = 0; i < 8; ++i) corners.emplace_back(i & 1 ? 1 : -1, i & 2 ? 1 : -1, i & 4 ? 1 : -1);
  const std::vector<uint16_t> faces = {0, 2, 3, 0, 3, 1, 4, 5, 7, 4, 7, 6, 0, 1, 5, 0, 5, 4,
                                       2, 6, 7, 2, 7, 3, 0, 4, 6, 0, 6, 2, 1, 3, 7, 1, 7, 5};
  const json box = {
      {"attributes", {{"POSITION", file.positions(corners)}}},
      {"indices", file.accessor(file.view(faces), scene::test::kUnsignedShort, "SCALAR", faces.size())},
      {"material", red},
      {"extensions",
       {{"KHR_materials_variants",
         {{"mappings", {{{"material", red}, {"variants", {0}}}, {{"material", blue}, {"variants", {1}}}}}}}}}};
  const int mesh = meshOf(file, box);
  place(file, "box", mesh, {0.9f, 0.4f, 0}, vec3(0.4f), {{"rotation", quaternion(30, vec3(0, 1, 0))}});
  place(file, "mirrored", mesh, {1.8f, 0.5f, 0.6f}, {-0.3f, 0.5f, 0.3f});
}

// --- animations -----------------------------------------------------------------------------------------------------

// An animation of nodes that lasts two seconds.
class Animation {
 public:
  Animation(GltfBuilder& file, const char* name) : file_(file), json_{{"name", name}} {}
  void add(int node, const char* path, int output) {
    const int input = file_.accessor(file_.view(std::vector<float>{0, 2}), scene::test::kFloat, "SCALAR", 2);
    json_["channels"].push_back({{"sampler", json_["samplers"].size()}, {"target", {{"node", node}, {"path", path}}}});
    json_["samplers"].push_back({{"input", input}, {"output", output}});
  }
  void move(int node, vec3 from, vec3 to) { add(node, "translation", file_.positions({from, to})); }
  void turn(int node, float from, float to, vec3 axis) {
    std::vector<vec4> turns;
    for (float degrees : {from, to}) {
      const glm::quat q = glm::angleAxis(glm::radians(degrees), axis);
      turns.emplace_back(q.x, q.y, q.z, q.w);
    }
    add(node, "rotation", file_.vectors(turns));
  }
  void finish() { file_.add("animations", json_); }

 private:
  GltfBuilder& file_;
  json json_;
};

// A strip that bends in the middle. Returns the joint that rotates.
int addSkinned(GltfBuilder& file, int material) {
  const Grid grid(4);
  json primitive = primitiveOf(file, grid, material);
  std::vector<uint8_t> joints;
  std::vector<vec4> weights;
  for (const vec3& p : grid.positions) {
    joints.insert(joints.end(), {0, 1, 0, 0});
    weights.emplace_back(p.y < 0 ? 1 : 0.2f, p.y < 0 ? 0 : 0.8f, 0, 0);
  }
  primitive["attributes"]["JOINTS_0"] =
      file.accessor(file.view(joints), scene::test::kUnsignedByte, "VEC4", weights.size());
  primitive["attributes"]["WEIGHTS_0"] = file.vectors(weights);
  const int upper = file.add("nodes", {{"name", "upper"}});
  const int lower = file.node({{"name", "lower"}, {"translation", {2.4f, 1.5f, -1.5f}}, {"children", {upper}}});
  file.add("skins", {{"joints", {lower, upper}}});
  place(file, "strip", meshOf(file, primitive), vec3(0), vec3(1), {{"skin", 0}});
  return upper;
}

int addMorphed(GltfBuilder& file, int material) {
  const Grid grid(4);
  json primitive = primitiveOf(file, grid, material);
  std::vector<vec3> moved;
  for (const vec3& p : grid.positions) moved.emplace_back(0.3f * p.y, 0, 1 - p.x * p.x);
  primitive["targets"] = {{{"POSITION", file.positions(moved)}}};
  return place(file, "pillow", meshOf(file, primitive), {-1.4f, 0.7f, -1.2f}, vec3(0.7f));
}

int addLight(GltfBuilder& file, const char* name, const json& light, vec3 at, float pitch) {
  json& lights = file.root["extensions"]["KHR_lights_punctual"]["lights"];
  lights.push_back(light);
  lights.back()["name"] = name;
  return file.node({{"name", name},
                    {"translation", {at.x, at.y, at.z}},
                    {"rotation", quaternion(pitch, vec3(1, 0, 0))},
                    {"extensions", {{"KHR_lights_punctual", {{"light", lights.size() - 1}}}}}});
}

void addCameras(GltfBuilder& file) {
  file.add("cameras", {{"type", "perspective"}, {"perspective", {{"yfov", 0.7}, {"znear", 0.1}}}});
  file.add("cameras",
           {{"type", "orthographic"}, {"orthographic", {{"xmag", 4}, {"ymag", 2.25}, {"znear", 0.1}, {"zfar", 20}}}});
  file.node({{"name", "front"}, {"camera", 0}, {"translation", {0, 1.6f, 6.5f}}});
  file.node(
      {{"name", "above"}, {"camera", 1}, {"translation", {0, 8, 0}}, {"rotation", quaternion(-90, vec3(1, 0, 0))}});
}

}  // namespace

std::vector<std::byte> everythingModel(const Kinds& kinds) {
  GltfBuilder file;
  addCameras(file);
  Animation move(file, "move"), sway(file, "sway");
  move.move(kFront, {0, 1.6f, 6.5f}, {0.6f, 1.8f, 5.5f});
  addCards(file, kinds);
  if (kinds.opaque) {
    addFloorAndWall(file);
    addBoxes(file);
    const int cloth = addMaterial(file, "cloth", vec4(0.7f, 0.5f, 0.2f, 1), 0, 0.8f, {{"doubleSided", true}});
    sway.turn(addSkinned(file, cloth), 0, 70, vec3(0, 0, 1));
    const int weights = file.accessor(file.view(std::vector<float>{0, 1}), scene::test::kFloat, "SCALAR", 2);
    sway.add(addMorphed(file, cloth), "weights", weights);
  }
  if (kinds.lights) {
    file.use("KHR_lights_punctual");
    move.turn(addLight(file, "sun", {{"type", "directional"}, {"intensity", 1.5}}, {0, 5, 0}, -50), -50, -20,
              vec3(1, 0, 0));
    move.move(addLight(file, "lamp", {{"type", "point"}, {"intensity", 12}, {"range", 5}, {"color", {0.3, 0.6, 1}}},
                       {-1.1f, 2.2f, 1.2f}, 0),
              {-1.1f, 2.2f, 1.2f}, {1.5f, 1, 1.5f});
    addLight(file, "spot", {{"type", "spot"}, {"intensity", 60}, {"spot", {{"outerConeAngle", 0.4}}}}, {2, 4, 2}, -60);
  }
  move.finish();
  if (kinds.opaque) sway.finish();
  return file.glb();
}

}  // namespace latelight::app
