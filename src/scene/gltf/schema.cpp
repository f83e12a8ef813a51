// Table-driven validation of glTF 2.0 JSON: one rule per property (its kind, range, and target of indices) and a
// recursive check that repairs values out of range.
#include "scene/gltf/schema.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "base/error.h"
#include "base/log.h"

namespace latelight::scene::gltf {
namespace {

using nlohmann::json;

// The arrays in the file to which an index may refer.
enum class Target {
  Accessors,
  Buffers,
  BufferViews,
  Cameras,
  Images,
  ImageBasedLights,
  Lights,
  Materials,
  Meshes,
  Nodes,
  Samplers,
  Scenes,
  Skins,
  Textures,
  Variants,
  Count
};

enum class Kind {
  Boolean,
  Integer,
  Number,
  String,
  Numbers,   // array
  Strings,   // array
  Index,     // into `target`
  Indices,   // array of indices
  IndexMap,  // object with indices as values and arbitrary names
  IndexMaps,
  Ids,     // object with integers >= 0 as values and arbitrary names
  Object,  // object with the rules of `schema`
  Objects,
  Lists  // array of arrays, each as `list` specifies
};

struct Schema;

struct Rule {
  std::string_view key;
  Kind kind;
  bool required = false;
  double least = -std::numeric_limits<float>::max(), most = std::numeric_limits<float>::max();
  bool allowsZero = false;                                         // 0 is valid, although it is below `least`
  size_t fewest = 0, atMost = std::numeric_limits<size_t>::max();  // number of array items
  Target target = Target::Count;
  const Schema* schema = nullptr;
  const Rule* list = nullptr;
};

struct Schema {
  std::span<const Rule> rules;
};

constexpr double kMaxCount = 4294967295.0;
constexpr double kMaxInt = 2147483647.0;       // these are stored in an int
constexpr double kMaxBytes = 1099511627776.0;  // 1 TiB: sums of a few can't overflow
constexpr double kPositive = 1.17549435e-38;   // the smallest normal float
constexpr double kMaxFloat = std::numeric_limits<float>::max();

constexpr Rule index(std::string_view key, Target target, bool required = false) {
  return {.key = key, .kind = Kind::Index, .required = required, .target = target};
}
constexpr Rule indices(std::string_view key, Target target, bool required = false) {
  return {.key = key, .kind = Kind::Indices, .required = required, .target = target};
}
constexpr Rule integer(std::string_view key, double least, double most, bool required = false) {
  return {.key = key, .kind = Kind::Integer, .required = required, .least = least, .most = most};
}
constexpr Rule number(std::string_view key, double least = -kMaxFloat, double most = kMaxFloat, bool required = false) {
  return {.key = key, .kind = Kind::Number, .required = required, .least = least, .most = most};
}
constexpr Rule numbers(std::string_view key, size_t fewest, size_t atMost, double least = -kMaxFloat,
                       double most = kMaxFloat) {
  return {.key = key, .kind = Kind::Numbers, .least = least, .most = most, .fewest = fewest, .atMost = atMost};
}
constexpr Rule share(std::string_view key) {
  return number(key, 0, 1);
}
constexpr Rule shares(std::string_view key, size_t count = 3) {  // an RGB color, or an RGBA one
  return numbers(key, count, count, 0, 1);
}
constexpr Rule string(std::string_view key, bool required = false) {
  return {.key = key, .kind = Kind::String, .required = required};
}
constexpr Rule boolean(std::string_view key) {
  return {.key = key, .kind = Kind::Boolean};
}
constexpr Rule object(std::string_view key, const Schema* schema, bool required = false) {
  return {.key = key, .kind = Kind::Object, .required = required, .schema = schema};
}
constexpr Rule objects(std::string_view key, const Schema* schema, bool required = false, size_t fewest = 0) {
  return {.key = key, .kind = Kind::Objects, .required = required, .fewest = fewest, .schema = schema};
}
constexpr Rule extensions(const Schema* schema) {
  return object("extensions", schema);
}

// --- the tables: glTF 2.0 appendix A and the schemas of the extensions -----------------------------------------------

constexpr Schema kAnyValue{};

constexpr Rule kAssetRules[] = {string("version", true), string("minVersion"), string("generator")};
constexpr Schema kAsset{kAssetRules};

constexpr Rule kMeshoptBufferRules[] = {boolean("fallback")};
constexpr Schema kMeshoptBuffer{kMeshoptBufferRules};
constexpr Rule kBufferExtensionRules[] = {object("EXT_meshopt_compression", &kMeshoptBuffer)};
constexpr Schema kBufferExtensions{kBufferExtensionRules};
constexpr Rule kBufferRules[] = {integer("byteLength", 1, kMaxBytes, true), string("uri"), string("name"),
                                 extensions(&kBufferExtensions)};
constexpr Schema kBuffer{kBufferRules};

constexpr Rule kMeshoptViewRules[] = {index("buffer", Target::Buffers, true),
                                      integer("byteOffset", 0, kMaxBytes),
                                      integer("byteLength", 1, kMaxBytes, true),
                                      integer("byteStride", 2, 256, true),
                                      integer("count", 1, kMaxCount, true),
                                      string("mode", true),
                                      string("filter")};
constexpr Schema kMeshoptView{kMeshoptViewRules};
constexpr Rule kViewExtensionRules[] = {object("EXT_meshopt_compression", &kMeshoptView)};
constexpr Schema kViewExtensions{kViewExtensionRules};
constexpr Rule kViewRules[] = {index("buffer", Target::Buffers, true),
                               integer("byteOffset", 0, kMaxBytes),
                               integer("byteLength", 1, kMaxBytes, true),
                               integer("byteStride", 4, 252),
                               string("name"),
                               extensions(&kViewExtensions)};
constexpr Schema kView{kViewRules};

constexpr Rule kSparseIndicesRules[] = {index("bufferView", Target::BufferViews, true),
                                        integer("byteOffset", 0, kMaxInt), integer("componentType", 5121, 5125, true)};
constexpr Schema kSparseIndices{kSparseIndicesRules};
constexpr Rule kSparseValuesRules[] = {index("bufferView", Target::BufferViews, true),
                                       integer("byteOffset", 0, kMaxInt)};
constexpr Schema kSparseValues{kSparseValuesRules};
constexpr Rule kSparseRules[] = {integer("count", 1, kMaxInt, true), object("indices", &kSparseIndices, true),
                                 object("values", &kSparseValues, true)};
constexpr Schema kSparse{kSparseRules};
constexpr Rule kAccessorRules[] = {index("bufferView", Target::BufferViews),
                                   integer("byteOffset", 0, kMaxBytes),
                                   integer("componentType", 5120, 5126, true),
                                   boolean("normalized"),
                                   integer("count", 1, kMaxCount, true),
                                   string("type", true),
                                   object("sparse", &kSparse)};
constexpr Schema kAccessor{kAccessorRules};

constexpr Rule kDracoRules[] = {index("bufferView", Target::BufferViews, true),
                                {.key = "attributes", .kind = Kind::Ids, .required = true}};
constexpr Schema kDraco{kDracoRules};
constexpr Rule kMappingRules[] = {indices("variants", Target::Variants, true),
                                  index("material", Target::Materials, true)};
constexpr Schema kMapping{kMappingRules};
constexpr Rule kPrimitiveVariantsRules[] = {objects("mappings", &kMapping, true)};
constexpr Schema kPrimitiveVariants{kPrimitiveVariantsRules};
constexpr Rule kPrimitiveExtensionRules[] = {object("KHR_draco_mesh_compression", &kDraco),
                                             object("KHR_materials_variants", &kPrimitiveVariants)};
constexpr Schema kPrimitiveExtensions{kPrimitiveExtensionRules};
constexpr Rule kPrimitiveRules[] = {
    {.key = "attributes", .kind = Kind::IndexMap, .required = true, .target = Target::Accessors},
    index("indices", Target::Accessors),
    index("material", Target::Materials),
    integer("mode", 0, 6),
    {.key = "targets", .kind = Kind::IndexMaps, .target = Target::Accessors},
    extensions(&kPrimitiveExtensions)};
constexpr Schema kPrimitive{kPrimitiveRules};
constexpr Rule kMeshRules[] = {objects("primitives", &kPrimitive, true, 1), numbers("weights", 0, 1u << 20),
                               string("name")};
constexpr Schema kMesh{kMeshRules};

constexpr Rule kNodeLightRules[] = {index("light", Target::Lights, true)};
constexpr Schema kNodeLight{kNodeLightRules};
constexpr Rule kInstancingRules[] = {
    {.key = "attributes", .kind = Kind::IndexMap, .required = true, .target = Target::Accessors}};
constexpr Schema kInstancing{kInstancingRules};
constexpr Rule kVisibilityRules[] = {boolean("visible")};
constexpr Schema kVisibility{kVisibilityRules};
constexpr Rule kNodeExtensionRules[] = {object("KHR_lights_punctual", &kNodeLight),
                                        object("KHR_node_visibility", &kVisibility),
                                        object("EXT_mesh_gpu_instancing", &kInstancing)};
constexpr Schema kNodeExtensions{kNodeExtensionRules};
constexpr Rule kNodeRules[] = {index("camera", Target::Cameras), indices("children", Target::Nodes),
                               index("skin", Target::Skins),     numbers("matrix", 16, 16),
                               index("mesh", Target::Meshes),    numbers("rotation", 4, 4),
                               numbers("scale", 3, 3),           numbers("translation", 3, 3),
                               numbers("weights", 0, 1u << 20),  string("name"),
                               extensions(&kNodeExtensions)};
constexpr Schema kNode{kNodeRules};

constexpr Rule kSceneLightRules[] = {index("light", Target::ImageBasedLights, true)};
constexpr Schema kSceneLight{kSceneLightRules};
constexpr Rule kSceneExtensionRules[] = {object("EXT_lights_image_based", &kSceneLight)};
constexpr Schema kSceneExtensions{kSceneExtensionRules};
constexpr Rule kSceneRules[] = {indices("nodes", Target::Nodes), string("name"), extensions(&kSceneExtensions)};
constexpr Schema kScene{kSceneRules};

constexpr Rule kSkinRules[] = {index("inverseBindMatrices", Target::Accessors), index("skeleton", Target::Nodes),
                               indices("joints", Target::Nodes, true), string("name")};
constexpr Schema kSkin{kSkinRules};

constexpr Rule kAnimationPointerRules[] = {string("pointer", true)};
constexpr Schema kAnimationPointer{kAnimationPointerRules};
constexpr Rule kTargetExtensionRules[] = {object("KHR_animation_pointer", &kAnimationPointer)};
constexpr Schema kTargetExtensions{kTargetExtensionRules};
constexpr Rule kAnimationTargetRules[] = {index("node", Target::Nodes), string("path", true),
                                          extensions(&kTargetExtensions)};
constexpr Schema kAnimationTarget{kAnimationTargetRules};
constexpr Rule kChannelRules[] = {integer("sampler", 0, kMaxInt, true), object("target", &kAnimationTarget, true)};
constexpr Schema kChannel{kChannelRules};
constexpr Rule kAnimationSamplerRules[] = {index("input", Target::Accessors, true),
                                           index("output", Target::Accessors, true), string("interpolation")};
constexpr Schema kAnimationSampler{kAnimationSamplerRules};
constexpr Rule kAnimationRules[] = {objects("channels", &kChannel, true), objects("samplers", &kAnimationSampler, true),
                                    string("name")};
constexpr Schema kAnimation{kAnimationRules};

constexpr Rule kPerspectiveRules[] = {number("yfov", -kMaxFloat, kMaxFloat, true), number("znear", 0, kMaxFloat, true),
                                      number("zfar", kPositive), number("aspectRatio", kPositive)};
constexpr Schema kPerspective{kPerspectiveRules};
constexpr Rule kOrthographicRules[] = {number("xmag", -kMaxFloat, kMaxFloat, true),
                                       number("ymag", -kMaxFloat, kMaxFloat, true), number("znear", 0, kMaxFloat, true),
                                       number("zfar", kPositive, kMaxFloat, true)};
constexpr Schema kOrthographic{kOrthographicRules};
constexpr Rule kCameraRules[] = {string("type", true), object("perspective", &kPerspective),
                                 object("orthographic", &kOrthographic), string("name")};
constexpr Schema kCamera{kCameraRules};

constexpr Rule kTransformRules[] = {numbers("offset", 2, 2), number("rotation"), numbers("scale", 2, 2),
                                    integer("texCoord", 0, 1000)};
constexpr Schema kTransform{kTransformRules};
constexpr Rule kTextureInfoExtensionRules[] = {object("KHR_texture_transform", &kTransform)};
constexpr Schema kTextureInfoExtensions{kTextureInfoExtensionRules};
constexpr Rule kTextureInfoRules[] = {index("index", Target::Textures, true), integer("texCoord", 0, 1000),
                                      number("scale"), number("strength"), extensions(&kTextureInfoExtensions)};
constexpr Schema kTextureInfo{kTextureInfoRules};

constexpr Rule kPbrRules[] = {shares("baseColorFactor", 4), object("baseColorTexture", &kTextureInfo),
                              share("metallicFactor"), share("roughnessFactor"),
                              object("metallicRoughnessTexture", &kTextureInfo)};
constexpr Schema kPbr{kPbrRules};
constexpr Rule kEmissiveStrengthRules[] = {number("emissiveStrength", 0)};
constexpr Schema kEmissiveStrength{kEmissiveStrengthRules};
constexpr Rule kIorRules[] = {{.key = "ior", .kind = Kind::Number, .least = 1, .allowsZero = true}};
constexpr Schema kIor{kIorRules};
constexpr Rule kSpecularRules[] = {share("specularFactor"), object("specularTexture", &kTextureInfo),
                                   numbers("specularColorFactor", 3, 3, 0),
                                   object("specularColorTexture", &kTextureInfo)};
constexpr Schema kSpecular{kSpecularRules};
constexpr Rule kClearcoatRules[] = {
    share("clearcoatFactor"), object("clearcoatTexture", &kTextureInfo), share("clearcoatRoughnessFactor"),
    object("clearcoatRoughnessTexture", &kTextureInfo), object("clearcoatNormalTexture", &kTextureInfo)};
constexpr Schema kClearcoat{kClearcoatRules};
constexpr Rule kSheenRules[] = {shares("sheenColorFactor"), object("sheenColorTexture", &kTextureInfo),
                                share("sheenRoughnessFactor"), object("sheenRoughnessTexture", &kTextureInfo)};
constexpr Schema kSheen{kSheenRules};
constexpr Rule kAnisotropyRules[] = {share("anisotropyStrength"), number("anisotropyRotation"),
                                     object("anisotropyTexture", &kTextureInfo)};
constexpr Schema kAnisotropy{kAnisotropyRules};
constexpr Rule kIridescenceRules[] = {share("iridescenceFactor"),
                                      object("iridescenceTexture", &kTextureInfo),
                                      number("iridescenceIor", 1),
                                      number("iridescenceThicknessMinimum", 0),
                                      number("iridescenceThicknessMaximum", 0),
                                      object("iridescenceThicknessTexture", &kTextureInfo)};
constexpr Schema kIridescence{kIridescenceRules};
constexpr Rule kTransmissionRules[] = {share("transmissionFactor"), object("transmissionTexture", &kTextureInfo)};
constexpr Schema kTransmission{kTransmissionRules};
constexpr Rule kVolumeRules[] = {number("thicknessFactor", 0), object("thicknessTexture", &kTextureInfo),
                                 number("attenuationDistance", kPositive), shares("attenuationColor")};
constexpr Schema kVolume{kVolumeRules};
constexpr Rule kDispersionRules[] = {number("dispersion", 0)};
constexpr Schema kDispersion{kDispersionRules};
constexpr Rule kDiffuseTransmissionRules[] = {
    share("diffuseTransmissionFactor"), object("diffuseTransmissionTexture", &kTextureInfo),
    shares("diffuseTransmissionColorFactor"), object("diffuseTransmissionColorTexture", &kTextureInfo)};
constexpr Schema kDiffuseTransmission{kDiffuseTransmissionRules};
constexpr Rule kSpecularGlossinessRules[] = {shares("diffuseFactor", 4), object("diffuseTexture", &kTextureInfo),
                                             shares("specularFactor"), share("glossinessFactor"),
                                             object("specularGlossinessTexture", &kTextureInfo)};
constexpr Schema kSpecularGlossiness{kSpecularGlossinessRules};
constexpr Rule kMaterialExtensionRules[] = {object("KHR_materials_pbrSpecularGlossiness", &kSpecularGlossiness),
                                            object("KHR_materials_unlit", &kAnyValue),
                                            object("KHR_materials_emissive_strength", &kEmissiveStrength),
                                            object("KHR_materials_ior", &kIor),
                                            object("KHR_materials_specular", &kSpecular),
                                            object("KHR_materials_clearcoat", &kClearcoat),
                                            object("KHR_materials_sheen", &kSheen),
                                            object("KHR_materials_anisotropy", &kAnisotropy),
                                            object("KHR_materials_iridescence", &kIridescence),
                                            object("KHR_materials_transmission", &kTransmission),
                                            object("KHR_materials_volume", &kVolume),
                                            object("KHR_materials_dispersion", &kDispersion),
                                            object("KHR_materials_diffuse_transmission", &kDiffuseTransmission)};
constexpr Schema kMaterialExtensions{kMaterialExtensionRules};
constexpr Rule kMaterialRules[] = {object("pbrMetallicRoughness", &kPbr),
                                   object("normalTexture", &kTextureInfo),
                                   object("occlusionTexture", &kTextureInfo),
                                   object("emissiveTexture", &kTextureInfo),
                                   numbers("emissiveFactor", 3, 3, 0),
                                   string("alphaMode"),
                                   number("alphaCutoff", 0),
                                   boolean("doubleSided"),
                                   string("name"),
                                   extensions(&kMaterialExtensions)};
constexpr Schema kMaterial{kMaterialRules};

constexpr Rule kOtherSourceRules[] = {index("source", Target::Images)};
constexpr Schema kOtherSource{kOtherSourceRules};
constexpr Rule kTextureExtensionRules[] = {object("EXT_texture_webp", &kOtherSource),
                                           object("EXT_texture_avif", &kOtherSource),
                                           object("KHR_texture_basisu", &kOtherSource)};
constexpr Schema kTextureExtensions{kTextureExtensionRules};
constexpr Rule kTextureRules[] = {index("sampler", Target::Samplers), index("source", Target::Images), string("name"),
                                  extensions(&kTextureExtensions)};
constexpr Schema kTexture{kTextureRules};
constexpr Rule kImageRules[] = {string("uri"), string("mimeType"), index("bufferView", Target::BufferViews),
                                string("name")};
constexpr Schema kImage{kImageRules};
constexpr Rule kSamplerRules[] = {integer("magFilter", 9728, 9729), integer("minFilter", 9728, 9987),
                                  integer("wrapS", 10497, 33648), integer("wrapT", 10497, 33648)};
constexpr Schema kSampler{kSamplerRules};

constexpr Rule kSpotRules[] = {number("innerConeAngle", 0, 1.5708), number("outerConeAngle", 0, 1.5708)};
constexpr Schema kSpot{kSpotRules};
constexpr Rule kLightRules[] = {string("type", true),       shares("color"),        number("intensity", 0),
                                number("range", kPositive), object("spot", &kSpot), string("name")};
constexpr Schema kLight{kLightRules};
constexpr Rule kLightsRules[] = {objects("lights", &kLight, true)};
constexpr Schema kLights{kLightsRules};
constexpr Rule kCoefficients = numbers("", 3, 3);
constexpr Rule kFaces{.key = "", .kind = Kind::Indices, .fewest = 6, .atMost = 6, .target = Target::Images};
constexpr Rule kImageBasedLightRules[] = {
    string("name"),
    numbers("rotation", 4, 4),
    number("intensity", 0),
    {.key = "irradianceCoefficients",
     .kind = Kind::Lists,
     .required = true,
     .fewest = 9,
     .atMost = 9,
     .list = &kCoefficients},
    {.key = "specularImages", .kind = Kind::Lists, .required = true, .fewest = 1, .atMost = 32, .list = &kFaces},
    integer("specularImageSize", 1, 16384, true)};
constexpr Schema kImageBasedLight{kImageBasedLightRules};
constexpr Rule kImageBasedLightsRules[] = {objects("lights", &kImageBasedLight, true)};
constexpr Schema kImageBasedLights{kImageBasedLightsRules};
constexpr Rule kVariantRules[] = {string("name", true)};
constexpr Schema kVariant{kVariantRules};
constexpr Rule kVariantsRules[] = {objects("variants", &kVariant, true)};
constexpr Schema kVariants{kVariantsRules};
constexpr Rule kRootExtensionRules[] = {object("KHR_lights_punctual", &kLights),
                                        object("EXT_lights_image_based", &kImageBasedLights),
                                        object("KHR_materials_variants", &kVariants)};
constexpr Schema kRootExtensions{kRootExtensionRules};

constexpr Rule kRootRules[] = {object("asset", &kAsset, true),
                               {.key = "extensionsUsed", .kind = Kind::Strings},
                               {.key = "extensionsRequired", .kind = Kind::Strings},
                               objects("accessors", &kAccessor),
                               objects("animations", &kAnimation),
                               objects("buffers", &kBuffer),
                               objects("bufferViews", &kView),
                               objects("cameras", &kCamera),
                               objects("images", &kImage),
                               objects("materials", &kMaterial),
                               objects("meshes", &kMesh),
                               objects("nodes", &kNode),
                               objects("samplers", &kSampler),
                               index("scene", Target::Scenes),
                               objects("scenes", &kScene),
                               objects("skins", &kSkin),
                               objects("textures", &kTexture),
                               extensions(&kRootExtensions)};
constexpr Schema kRoot{kRootRules};

struct TargetArray {
  Target target;
  const char* pointer;  // RFC 6901
  const char* name;
};
constexpr TargetArray kTargetArrays[] = {
    {Target::Accessors, "/accessors", "accessors"},
    {Target::Buffers, "/buffers", "buffers"},
    {Target::BufferViews, "/bufferViews", "bufferViews"},
    {Target::Cameras, "/cameras", "cameras"},
    {Target::Images, "/images", "images"},
    {Target::ImageBasedLights, "/extensions/EXT_lights_image_based/lights", "image-based lights"},
    {Target::Lights, "/extensions/KHR_lights_punctual/lights", "lights"},
    {Target::Materials, "/materials", "materials"},
    {Target::Meshes, "/meshes", "meshes"},
    {Target::Nodes, "/nodes", "nodes"},
    {Target::Samplers, "/samplers", "samplers"},
    {Target::Scenes, "/scenes", "scenes"},
    {Target::Skins, "/skins", "skins"},
    {Target::Textures, "/textures", "textures"},
    {Target::Variants, "/extensions/KHR_materials_variants/variants", "variants"},
};

// --- the checks ------------------------------------------------------------------------------------------------------

class Validator {
 public:
  explicit Validator(json& root) : root_(root) {
    for (const TargetArray& array : kTargetArrays) {
      json::json_pointer pointer(array.pointer);
      if (root.contains(pointer) && root.at(pointer).is_array()) sizes_[size_t(array.target)] = root.at(pointer).size();
    }
  }

  void run() { object(root_, kRoot); }

 private:
  // The position in the JSON for messages, as pieces of "accessors[3].sparse.count".
  class Place {
   public:
    Place(Validator& v, std::string_view key) : v_(v) { v_.place_.push_back({key, kNoIndex}); }
    Place(Validator& v, size_t index) : v_(v) { v_.place_.push_back({{}, index}); }
    ~Place() { v_.place_.pop_back(); }

   private:
    Validator& v_;
  };
  static constexpr size_t kNoIndex = ~size_t{0};
  struct Step {
    std::string_view key;
    size_t index;
  };

  std::string where() const {
    std::string text;
    for (const Step& step : place_) {
      if (step.index != kNoIndex)
        text += fmt::format("[{}]", step.index);
      else
        text += fmt::format("{}{}", text.empty() ? "" : ".", step.key);
    }
    return text.empty() ? "the file" : text;
  }
  template <typename... Args>
  [[noreturn]] void bad(fmt::format_string<Args...> format, Args&&... args) const {
    badInput("{} {}", where(), fmt::format(format, std::forward<Args>(args)...));
  }

  void object(json& value, const Schema& schema) {
    if (!value.is_object()) bad("should be a JSON object");
    for (const Rule& rule : schema.rules) {
      auto found = value.find(rule.key);
      Place place(*this, rule.key);
      if (found == value.end()) {
        if (rule.required) bad("is missing");
      } else if (!rule.required && isNotPositive(*found, rule)) {
        warn("{} is {}, and is left out: it has to be above 0", where(), found->dump());
        value.erase(found);
      } else {
        check(*found, rule);
      }
    }
  }

  // Returns true for a number that must be positive but is not. It is removed, because clamping it to the end of its
  // range would be meaningless.
  static bool isNotPositive(const json& value, const Rule& rule) {
    return rule.kind == Kind::Number && rule.least == kPositive && value.is_number() && value.get<double>() < kPositive;
  }

  void check(json& value, const Rule& rule) {
    switch (rule.kind) {
      case Kind::Boolean:
        if (!value.is_boolean()) bad("should be true or false");
        return;
      case Kind::String:
        if (!value.is_string()) bad("should be a string");
        return;
      case Kind::Integer:
        return integer(value, rule.least, rule.most);
      case Kind::Number:
        return number(value, rule);
      case Kind::Index:
        return index(value, rule);
      case Kind::Object:
        return object(value, *rule.schema);
      case Kind::IndexMap:
      case Kind::Ids:
        return map(value, rule);
      case Kind::Numbers:
      case Kind::Strings:
      case Kind::Indices:
      case Kind::IndexMaps:
      case Kind::Objects:
      case Kind::Lists:
        return array(value, rule);
    }
  }

  void integer(json& value, double least, double most) {
    if (value.is_number_float()) {
      double d = value.get<double>();
      if (d == std::floor(d) && std::abs(d) < 9007199254740992.0) value = static_cast<int64_t>(d);
    }
    if (!value.is_number_integer()) bad("should be a whole number");
    double d = value.get<double>();
    if (d < least || d > most) bad("is {}, which is not in [{:.0f}, {:.0f}]", value.dump(), least, most);
  }

  // Clamps numbers to their range, because exporters round factors and angles, and some write values outside the range
  // that glTF allows.
  void number(json& value, const Rule& rule) {
    if (!value.is_number()) bad("should be a number");
    const double d = value.get<double>();
    if (!std::isfinite(static_cast<float>(d))) bad("is {}, which is out of range", value.dump());
    const double nearest = rule.allowsZero && d <= 0 ? 0 : std::clamp(d, rule.least, rule.most);
    if (nearest == d) return;
    warn("{} is {}, which is out of range: it is read as {}", where(), value.dump(), nearest);
    value = nearest;
  }

  void index(json& value, const Rule& rule) {
    const TargetArray& array = kTargetArrays[size_t(rule.target)];
    size_t size = sizes_[size_t(rule.target)];
    if (!value.is_number()) bad("should be an index into {}", array.name);
    integer(value, 0, kMaxInt);
    if (value.get<size_t>() >= size) bad("is {}, but there are {} {}", value.dump(), size, array.name);
  }

  void map(json& value, const Rule& rule) {
    if (!value.is_object()) bad("should be a JSON object");
    for (auto item = value.begin(); item != value.end(); ++item) {
      Place place(*this, item.key());
      if (rule.kind == Kind::IndexMap)
        index(item.value(), rule);
      else
        integer(item.value(), 0, kMaxInt);
    }
  }

  void array(json& value, const Rule& rule) {
    if (!value.is_array()) bad("should be an array");
    if (value.size() < rule.fewest || value.size() > rule.atMost)
      bad("has {} items, which is {}", value.size(), value.size() < rule.fewest ? "too few" : "too many");
    for (size_t i = 0; i < value.size(); ++i) {
      Place place(*this, i);
      item(value[i], rule);
    }
  }

  void item(json& value, const Rule& rule) {
    switch (rule.kind) {
      case Kind::Numbers:
        return number(value, rule);
      case Kind::Strings:
        if (!value.is_string()) bad("should be a string");
        return;
      case Kind::Indices:
        return index(value, rule);
      case Kind::Objects:
        return object(value, *rule.schema);
      case Kind::Lists:
        return array(value, *rule.list);
      default: {
        Rule one = rule;
        one.kind = Kind::IndexMap;
        return map(value, one);
      }
    }
  }

  json& root_;
  size_t sizes_[size_t(Target::Count)] = {};
  std::vector<Step> place_;
};

static_assert(std::size(kTargetArrays) == size_t(Target::Count));

}  // namespace

void validate(json& root) {
  Validator(root).run();
}

}  // namespace latelight::scene::gltf
