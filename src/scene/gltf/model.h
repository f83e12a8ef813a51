// The contents of a glTF document as plain data, except for its buffers and images, whose bytes are in document.h.
// Members have the names, units and default values of the glTF 2.0 specification (Khronos, 2021) and of its extensions.
// Indices into other arrays of the document are -1 if a property is absent.
#pragma once

#include <array>
#include <cstddef>
#include <glm/glm.hpp>
#include <map>
#include <nlohmann/json_fwd.hpp>
#include <numbers>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "base/json_tree.h"
#include "scene/animated_values.h"

namespace latelight::scene::gltf::file {

// --- numbers of OpenGL, by which files specify types -----------------------------------------------------------------

enum ComponentType {
  kByte = 5120,
  kUnsignedByte = 5121,
  kShort = 5122,
  kUnsignedShort = 5123,
  kUnsignedInt = 5125,
  kFloat = 5126
};
enum PrimitiveMode { kTriangles = 4, kTriangleStrip = 5, kTriangleFan = 6 };
enum TextureFilter {
  kNearest = 9728,
  kLinear = 9729,
  kNearestMipmapNearest = 9984,
  kLinearMipmapNearest = 9985,
  kNearestMipmapLinear = 9986,
  kLinearMipmapLinear = 9987
};
enum TextureWrap { kRepeat = 10497, kClampToEdge = 33071, kMirroredRepeat = 33648 };

// --- geometry --------------------------------------------------------------------------------------------------------

struct SparseIndices {
  int bufferView = -1;
  size_t byteOffset = 0;
  int componentType = 0;
};

struct SparseValues {
  int bufferView = -1;
  size_t byteOffset = 0;
};

struct Sparse {
  size_t count = 0;
  SparseIndices indices;
  SparseValues values;
};

struct Accessor {
  int bufferView = -1;
  size_t byteOffset = 0;
  int componentType = 0;  // a number from 5120 to 5126, which may be none of ComponentType
  bool normalized = false;
  size_t count = 0;
  size_t columns = 1, rows = 1;  // of an element: 1 and 1 for SCALAR, 1 and 3 for VEC3, 3 and 3 for MAT3
  std::optional<Sparse> sparse;
};

using Attributes = std::map<std::string, int>;  // accessors by semantic, such as "POSITION"

struct DracoCompression {  // KHR_draco_mesh_compression
  int bufferView = -1;
  std::map<std::string, int> attributes;  // ids in the compressed data
};

struct VariantMapping {  // KHR_materials_variants
  std::vector<int> variants;
  int material = -1;
};

struct Primitive {
  Attributes attributes;
  int indices = -1;
  int material = -1;
  int mode = kTriangles;
  std::vector<Attributes> targets;
  std::optional<DracoCompression> draco;
  std::vector<VariantMapping> variants;
};

struct Mesh {
  std::string name;
  std::vector<Primitive> primitives;
  std::vector<double> weights;
};

// --- nodes -----------------------------------------------------------------------------------------------------------

struct Node {
  std::string name;
  std::vector<int> children;
  int camera = -1, mesh = -1, skin = -1;
  int light = -1;              // KHR_lights_punctual
  bool visible = true;         // KHR_node_visibility
  std::vector<double> matrix;  // 16 numbers, column by column; empty if the next three are the transform
  glm::dvec3 translation{0};
  glm::dvec4 rotation{0, 0, 0, 1};  // a quaternion, xyzw
  glm::dvec3 scale{1};
  std::vector<double> weights;           // empty: those of the mesh apply
  std::optional<Attributes> instancing;  // EXT_mesh_gpu_instancing
  JsonTree extras;                       // of nodes with a light; otherwise null
  JsonTree areaLight;                    // extras.areaLight (area_lights.h), or null
};

struct Scene {
  std::vector<int> nodes;
  int imageBasedLight = -1;  // EXT_lights_image_based
};

struct Skin {
  std::vector<int> joints;
  int inverseBindMatrices = -1;
};

struct Perspective {
  double yfov = 0, znear = 0;
  double zfar = 0, aspectRatio = 0;  // 0: not specified
};

struct Orthographic {
  double xmag = 0, ymag = 0, znear = 0, zfar = 0;
};

struct Camera {
  std::string name;
  std::variant<Perspective, Orthographic> projection;
};

struct Light {  // KHR_lights_punctual
  std::string name;
  std::string type;
  glm::vec3 color{1};
  double intensity = 1;
  double range = 0;  // 0: infinite
  double innerConeAngle = 0, outerConeAngle = std::numbers::pi / 4;
  JsonTree extras;
};

struct ImageBasedLight {  // EXT_lights_image_based
  glm::vec4 rotation{0, 0, 0, 1};
  double intensity = 1;
  std::array<glm::vec3, 9> irradianceCoefficients{};
  std::array<int, 6> specularImages{};  // the faces of the largest mip level
  int specularImageSize = 0;            // their width as the file states it
};

// --- materials -------------------------------------------------------------------------------------------------------

struct Sampler {
  int magFilter = -1, minFilter = -1;  // -1: not specified
  int wrapS = kRepeat, wrapT = kRepeat;
};

struct Texture {
  int sampler = -1;
  int image = -1;  // of the first extension whose format is supported, otherwise the texture's source
};

struct TextureInfo {
  int texture = -1;
  int texCoord = 0;          // KHR_texture_transform's, if it specifies one
  TransformParts transform;  // KHR_texture_transform
};

struct MetallicRoughness {
  glm::vec4 baseColorFactor{1};
  float metallicFactor = 1, roughnessFactor = 1;
  TextureInfo baseColorTexture, metallicRoughnessTexture;
};

struct SpecularGlossiness {
  glm::vec4 diffuseFactor{1};
  glm::vec3 specularFactor{1};
  float glossinessFactor = 1;
  TextureInfo diffuseTexture, specularGlossinessTexture;
};

struct Specular {
  float specularFactor = 1;
  glm::vec3 specularColorFactor{1};
  TextureInfo specularTexture, specularColorTexture;
};

struct Clearcoat {
  float clearcoatFactor = 0, clearcoatRoughnessFactor = 0;
  float clearcoatNormalScale = 1;
  TextureInfo clearcoatTexture, clearcoatRoughnessTexture, clearcoatNormalTexture;
};

struct Sheen {
  glm::vec3 sheenColorFactor{0};
  float sheenRoughnessFactor = 0;
  TextureInfo sheenColorTexture, sheenRoughnessTexture;
};

struct Anisotropy {
  float anisotropyStrength = 0, anisotropyRotation = 0;
  TextureInfo anisotropyTexture;
};

struct Iridescence {
  float iridescenceFactor = 0;
  float iridescenceIor = 1.3f;
  float iridescenceThicknessMinimum = 100, iridescenceThicknessMaximum = 400;  // in nanometers
  TextureInfo iridescenceTexture, iridescenceThicknessTexture;
};

struct Transmission {
  float transmissionFactor = 0;
  TextureInfo transmissionTexture;
};

struct Volume {
  float thicknessFactor = 0;
  float attenuationDistance = 0;  // 0: infinite
  glm::vec3 attenuationColor{1};
  TextureInfo thicknessTexture;
};

struct DiffuseTransmission {
  float diffuseTransmissionFactor = 0;
  glm::vec3 diffuseTransmissionColorFactor{1};
  TextureInfo diffuseTransmissionTexture, diffuseTransmissionColorTexture;
};

struct Material {
  std::string name;
  std::string alphaMode = "OPAQUE";
  float alphaCutoff = 0.5f;
  bool doubleSided = false;
  bool unlit = false;  // KHR_materials_unlit
  glm::vec3 emissiveFactor{0};
  float emissiveStrength = 1;  // KHR_materials_emissive_strength
  float normalScale = 1, occlusionStrength = 1;
  float ior = 1.5f;      // KHR_materials_ior
  float dispersion = 0;  // KHR_materials_dispersion
  TextureInfo normalTexture, occlusionTexture, emissiveTexture;
  MetallicRoughness metallicRoughness;
  std::optional<SpecularGlossiness> specularGlossiness;  // replaces `metallicRoughness`, `ior` and `specular`
  Specular specular;
  Clearcoat clearcoat;
  Sheen sheen;
  Anisotropy anisotropy;
  Iridescence iridescence;
  Transmission transmission;
  Volume volume;
  DiffuseTransmission diffuseTransmission;
};

// --- animations ------------------------------------------------------------------------------------------------------

struct AnimationChannel {
  size_t sampler = 0;  // not validated
  int node = -1;
  std::string path;
  std::optional<std::string> pointer;  // KHR_animation_pointer
};

struct AnimationSampler {
  int input = -1, output = -1;
  std::string interpolation = "LINEAR";
};

struct Animation {
  std::optional<std::string> name;
  std::vector<AnimationChannel> channels;
  std::vector<AnimationSampler> samplers;
};

struct Model {
  std::vector<Accessor> accessors;
  std::vector<Mesh> meshes;
  std::vector<Node> nodes;
  std::vector<Scene> scenes;
  int scene = -1;  // the default scene
  std::vector<Skin> skins;
  std::vector<Camera> cameras;
  std::vector<Light> lights;
  std::vector<ImageBasedLight> imageBasedLights;
  std::vector<Sampler> samplers;
  std::vector<Texture> textures;
  std::vector<Material> materials;
  std::vector<std::string> variants;  // KHR_materials_variants
  std::vector<Animation> animations;
};

// Reads validated JSON. Throws Error(BadInput) for what validate() (schema.h) does not check: the types of accessors
// and cameras, and spot lights without "spot".
Model readModel(const nlohmann::json& root);

}  // namespace latelight::scene::gltf::file
