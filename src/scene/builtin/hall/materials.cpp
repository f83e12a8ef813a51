// The textures and materials of the hall.
#include "scene/builtin/hall/hall.h"
#include "scene/builtin/hall/patterns.h"

namespace latelight::scene::builtin::hall {
namespace {

using shared::kTextureBaseColor;
using shared::kTextureEmissive;
using shared::kTextureMetallicRoughness;
using shared::kTextureNormal;

void setSlot(Material& material, uint32_t slot, int texture) {
  if (texture < 0) return;
  material.slots[slot].texture = texture;
  material.data.textures |= 1u << slot;
}

Material mapped(const std::string& name, const SurfaceMaps& maps, vec3 tint, float roughness, float normalScale = 1) {
  Material material = plainMaterial(name, tint, 1, roughness);
  setSlot(material, kTextureBaseColor, maps.color);
  setSlot(material, kTextureNormal, maps.normal);
  setSlot(material, kTextureMetallicRoughness, maps.roughness);
  material.data.normalScale = normalScale;
  return material;
}

Material veined(const std::string& name, int texture, vec3 tint, float roughness) {
  Material material = plainMaterial(name, tint, 0, roughness);
  setSlot(material, kTextureBaseColor, texture);
  return material;
}

Material metal(const std::string& name, vec3 color, float roughness) {
  return plainMaterial(name, color, 1, roughness);
}

Material glowing(const std::string& name, vec3 emissive) {
  Material material = plainMaterial(name, vec3(0.02f), 0, 0.4f);
  material.data.emissive = emissive;
  return material;
}

Material blended(const std::string& name, vec3 color, float alpha) {
  Material material = plainMaterial(name, color, 0, 0.12f);
  material.data.baseColor.a = alpha;
  material.data.flags |= shared::kMaterialBlended | shared::kMaterialDoubleSided;
  return material;
}

// The textures of the hall. Material tints are linear.
struct Maps {
  SurfaceMaps nave, aisle, ashlar, plaster, mosaic, tile;
  int pale, dark, glass;
};

Maps addTextures(Scene& scene, uint32_t seed, uint32_t slots) {
  const auto maps = [&](const char* name, ImageSize size, MapTexel (*texel)(vec2, uint32_t)) {
    return addMaps(
        scene, name, size, [=](vec2 place) { return texel(place, seed); }, slots);
  };
  const auto colors = [&](const char* name, ImageSize size, vec3 (*color)(vec2, uint32_t), uint32_t slot) {
    if ((slots >> slot & 1u) == 0) return -1;
    return addColorMap(scene, name, size, [=](vec2 place) { return color(place, seed); });
  };
  Maps all;
  all.nave = maps("nave floor", {2048, 1024}, naveFloor);
  all.aisle = maps("aisle floor", {512, 512}, aisleFloor);
  all.ashlar = maps("ashlar", {1024, 1024}, ashlar);
  all.plaster = maps("plaster", {512, 512}, plaster);
  all.mosaic = maps("mosaic", {512, 512}, mosaic);
  all.tile = maps("glazed tile", {512, 512}, glazedTile);
  all.pale = colors("pale marble", {512, 512}, paleMarble, kTextureBaseColor);
  all.dark = colors("dark marble", {512, 512}, darkMarble, kTextureBaseColor);
  all.glass = colors("leaded glass", {256, 256}, leadedGlass, kTextureEmissive);
  return all;
}

Material makeMaterial(HallMaterial material, const Maps& maps) {
  switch (material) {
    case HallMaterial::NaveFloor:
      return mapped("nave floor", maps.nave, vec3(1), 1);
    case HallMaterial::AisleFloor:
      return mapped("aisle floor", maps.aisle, vec3(1), 1);
    case HallMaterial::Ashlar:
      return mapped("ashlar", maps.ashlar, vec3(1), 1);
    case HallMaterial::Plaster:
      return mapped("plaster", maps.plaster, vec3(1), 1);
    case HallMaterial::Trim:
      return mapped("pale stone", maps.plaster, {0.56f, 0.57f, 0.56f}, 0.85f, 0.6f);
    case HallMaterial::Marble:
      return veined("white marble", maps.pale, vec3(1), 0.3f);
    case HallMaterial::RedMarble:
      return veined("red marble", maps.dark, {1.0f, 0.60f, 0.48f}, 0.24f);
    case HallMaterial::GreenMarble:
      return veined("green marble", maps.dark, {0.74f, 0.92f, 0.78f}, 0.24f);
    case HallMaterial::BlackMarble:
      return veined("black marble", maps.dark, {0.09f, 0.09f, 0.10f}, 0.22f);
    case HallMaterial::VaultBlue:
      return mapped("painted plaster", maps.plaster, {0.05f, 0.12f, 0.30f}, 0.8f, 0.6f);
    case HallMaterial::Mosaic:
      return mapped("gold mosaic", maps.mosaic, vec3(1), 1);
    case HallMaterial::Tile:
      return mapped("glazed tile", maps.tile, vec3(1), 1);
    case HallMaterial::Gilt:
      return metal("gilt", {1.0f, 0.72f, 0.32f}, 0.38f);
    case HallMaterial::Brass:
      return metal("brass", {0.91f, 0.73f, 0.42f}, 0.36f);
    case HallMaterial::Bronze:
      return metal("bronze", {0.62f, 0.40f, 0.24f}, 0.45f);
    case HallMaterial::Copper:
      return metal("copper", {0.93f, 0.50f, 0.36f}, 0.3f);
    case HallMaterial::Steel:
      return metal("steel", {0.66f, 0.64f, 0.62f}, 0.28f);
    case HallMaterial::Ceramic:
      return plainMaterial("ceramic", {0.58f, 0.13f, 0.05f}, 0, 0.22f);
    case HallMaterial::Celadon:
      return plainMaterial("celadon", {0.38f, 0.60f, 0.48f}, 0, 0.16f);
    case HallMaterial::Obsidian:
      return plainMaterial("obsidian", {0.02f, 0.02f, 0.025f}, 0, 0.12f);
    case HallMaterial::LampGlass:
      return glowing("lamp glass", {6.0f, 3.9f, 2.0f});
    case HallMaterial::DarkGlass:
      return plainMaterial("dark glass", {0.10f, 0.09f, 0.08f}, 0, 0.2f);
    case HallMaterial::WindowGlass: {
      Material material = glowing("leaded glass", vec3(0.9f));
      setSlot(material, kTextureEmissive, maps.glass);
      return material;
    }
    case HallMaterial::CaseGlass:
      return blended("case glass", {0.55f, 0.75f, 0.70f}, 0.2f);
    case HallMaterial::AmberGlass:
      return blended("amber glass", {0.95f, 0.42f, 0.06f}, 0.5f);
    case HallMaterial::BlueGlass:
      return blended("blue glass", {0.08f, 0.20f, 0.75f}, 0.5f);
    case HallMaterial::GreenGlass:
      return blended("green glass", {0.06f, 0.55f, 0.22f}, 0.5f);
    case HallMaterial::Count:
      break;
  }
  return plainMaterial("none", vec3(0.5f), 0, 1);
}

}  // namespace

void addMaterials(Scene& scene, const HallParameters& p) {
  const Maps maps = addTextures(scene, static_cast<uint32_t>(p.seed), p.textureSlots);
  const auto end = static_cast<uint32_t>(p.glass ? HallMaterial::Count : HallMaterial::CaseGlass);
  for (uint32_t i = 0; i < end; ++i) scene.materials.push_back(makeMaterial(static_cast<HallMaterial>(i), maps));
}

}  // namespace latelight::scene::builtin::hall
