// Small glTF files that use the features that the renderer reads. The tests generate them, so no files and no package
// are required.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <glm/vec3.hpp>
#include <map>
#include <string>
#include <vector>

namespace latelight::models {

using Bytes = std::vector<std::byte>;

// A tiled floor, a back wall and spheres under a directional light, a point light with a range, and a spot light.
// Camera "front".
Bytes punctualModel();

// Every texture slot: a floor with base color, normal map and texture transform; a sphere with a metallic-roughness
// image and vertex colors; an alpha-masked card; a card that glows with an emissive image; an unlit card. Two cameras:
// "front", "above/orthographic". No light.
Bytes texturedModel();

// How the images of texturedModel() are stored.
enum class PictureKind { Png, Jpeg, Webp };
Bytes texturedModel(PictureKind kind);

// Features that few files use: sparse accessors, quantized and normalized attributes, a strip, a fan, GPU instancing,
// variants, a mirrored node, and buffer views compressed by EXT_meshopt_compression.
Bytes intricateModel();

// The same scene as a single .gltf file with a data URI.
std::string embeddedModel();

// A worm of 2 m height that stands on the ground, with a chain of four joints. The animations "bend" and "twist" last
// one second each and start and end at rest. The lowest joint is at `foot`, in the file's frame.
Bytes skinnedModel(glm::dvec3 foot = glm::dvec3(0), bool animated = true);

// A ball with two morph targets with normals, one flat and one long. The animation "breathe" lasts one second.
Bytes morphedModel();

// Panes of red and green glass in front of two balls on a floor, a glass ball among them, and a card with holes. No
// light.
Bytes blendedModel();

// A hundred balls, each with its own material, and fifty textures of different sizes, stored as PNG, JPEG and WebP and
// sampled in five ways. No camera, no light.
Bytes manyMaterialsModel();

// All of the above, by file name.
std::map<std::string, Bytes> allModels();

// Returns `made`, and the files named in `real` that exist in a folder next to the checkout; prints which ones are
// missing. A fresh checkout thus runs each test on the generated models.
std::vector<std::string> withReal(std::vector<std::string> made, const std::vector<std::string>& real);

// Returns the path of a model of allModels(), written into a folder that is deleted with the process, or of a real one
// next to the checkout.
std::filesystem::path modelPath(const std::string& name);

// Panoramas of a sky with a bright sun: as Radiance (new run-length encoding) and as OpenEXR.
Bytes radiancePanorama(uint32_t width, uint32_t height);
Bytes exrPanorama(uint32_t width, uint32_t height);

}  // namespace latelight::models
