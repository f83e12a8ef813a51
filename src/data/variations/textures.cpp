// The variation "textures": replaces the textures of a material slot by random image files.
#include <fmt/format.h>

#include <algorithm>
#include <optional>

#include "base/error.h"
#include "base/files.h"
#include "base/lowercase.h"
#include "base/memory.h"
#include "data/variations/draws.h"
#include "data/variations/pattern.h"
#include "data/variations/variation.h"
#include "scene/textures/texture.h"

namespace latelight::data {

namespace {

using Json = nlohmann::ordered_json;
namespace fs = std::filesystem;

struct Slot {
  std::string_view name;
  uint32_t slot;
  bool srgb;
};
constexpr Slot kSlots[] = {{"baseColor", shared::kTextureBaseColor, true},
                           {"metallicRoughness", shared::kTextureMetallicRoughness, false},
                           {"normal", shared::kTextureNormal, false},
                           {"occlusion", shared::kTextureOcclusion, false},
                           {"emissive", shared::kTextureEmissive, true}};

// Returns the images in a folder sorted by name, so that the order is the same on every machine.
std::vector<std::string> picturesIn(const std::string& folder) {
  constexpr std::string_view kEndings[] = {".png", ".jpg", ".jpeg", ".webp", ".bmp", ".tga"};
  std::vector<std::string> pictures;
  std::error_code error;
  for (fs::directory_iterator entry(folder, error), end; !error && entry != end; entry.increment(error))
    if (std::ranges::find(kEndings, lowercaseExtension(entry->path())) != std::end(kEndings))
      pictures.push_back(entry->path().string());
  if (error) badInput("cannot read {} as a folder of textures: {}", folder, error.message());
  if (pictures.empty()) badInput("{} has no images (.png, .jpg, .jpeg, .webp, .bmp or .tga)", folder);
  std::ranges::sort(pictures);
  return pictures;
}

class Textures : public Variation {
 public:
  Textures(Spec& spec, scene::Scene& scene) : path_(spec.path()) {
    materials_ = selectMaterials(spec, "materials", scene);
    const std::string name =
        spec.choice("slot", {"baseColor", "metallicRoughness", "normal", "occlusion", "emissive"}, "baseColor");
    slot_ = *std::ranges::find(kSlots, name, &Slot::name);
    if (spec.has("folder") == spec.has("files")) badUsage("{} needs either \"folder\" or \"files\"", path_);
    files_ = spec.has("folder") ? picturesIn(spec.text("folder")) : spec.texts("files");
    if (spec.has("repeat")) repeat_ = spec.interval("repeat", kPositive);
    for (const std::string& file : files_) load(file, scene);
  }

  Json draw(const Draw& draw, Draft& draft) const override {
    Json record{{"materials", Json::array()}};
    for (const uint32_t index : materials_) {
      const auto random = [&](const char* what) { return draw.of(fmt::format("{}/{}/{}", path_, index, what)); };
      const uint32_t chosen = random("texture").below(static_cast<uint32_t>(files_.size()));
      scene::Material& material = draft.material(index);
      material.slots[slot_.slot].texture = static_cast<int>(textures_[chosen]);
      material.data.textures |= 1u << slot_.slot;
      Json& own = record["materials"].emplace_back(
          Json{{"name", material.name}, {"slot", slot_.name}, {"texture", files_[chosen]}});
      if (!repeat_) continue;
      const float times = drawn(*repeat_, random("repeat"));
      shared::TextureTransform& transform = material.data.transforms[slot_.slot];
      transform.row0 *= times, transform.row1 *= times;
      own["repeat"] = times;
    }
    return record;
  }

 private:
  void load(const std::string& file, scene::Scene& scene) {
    const std::vector<std::byte> bytes = readFile(file);
    scene.memory.grow(scene::mipChainBytes(scene::imageSize(bytes, file)), "its textures");
    textures_.push_back(static_cast<uint32_t>(scene.textures.size()));
    scene.textures.push_back(scene::decodeTexture(bytes, slot_.srgb, file));
  }

  std::string path_;
  std::vector<uint32_t> materials_, textures_;  // textures: indices in the scene, by file
  std::vector<std::string> files_;
  Slot slot_{};
  std::optional<Interval> repeat_;
};

}  // namespace

std::vector<fs::path> texturesFiles(const Json& value, const scene::LoadOptions& /*load*/) {
  const Json folder = value.value("folder", Json()), files = value.value("files", Json());
  std::vector<fs::path> all;
  if (folder.is_string())
    for (const std::string& file : picturesIn(folder.get<std::string>())) all.emplace_back(file);
  for (const Json& file : files)
    if (file.is_string()) all.emplace_back(file.get<std::string>());
  return all;
}

std::unique_ptr<Variation> varyTextures(Spec& spec, const VariationContext& context) {
  return std::make_unique<Textures>(spec, context.scene);
}

}  // namespace latelight::data
