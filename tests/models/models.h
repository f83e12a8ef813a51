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

// A tiled floor, a back wall and spheres under a directional, a point with a range, and a spot light. Camera "front".
Bytes punctualModel();

// Every texture slot: a floor with base colour, normal map and texture transform; a sphere with a metal-roughness
// picture and vertex colours; a card cut out by alpha; a card that glows by an emissive picture; a card that is unlit.
// Two cameras: "front", "above/orthographic". No light.
Bytes texturedModel();

// How the pictures of texturedModel() are stored.
enum class PictureKind { Png, Jpeg, Webp };
Bytes texturedModel(PictureKind kind);

// What few files use: sparse accessors, quantised and normalised attributes, a strip, a fan, GPU instancing, variants,
// a mirrored node, and buffer views compressed by EXT_meshopt_compression.
Bytes intricateModel();

// The same scene as one .gltf with a data URI.
std::string embeddedModel();

// A worm of two units' height that stands on the ground, of four joints in a chain; animations "bend" and "twist" of a
// second each, both at rest at its start and end.
// Its lowest joint lies at `foot`, in the file's frame.
Bytes skinnedModel(glm::dvec3 foot = glm::dvec3(0));

// A ball that two targets, with normals, make flat and long; animation "breathe", a second.
Bytes morphedModel();

// Panes of red and green glass before two balls on a floor, a ball of glass among them, and a card with holes. No
// light.
Bytes blendedModel();

// A hundred balls, each of a material of its own, of fifty textures of different sizes, stored as PNG, JPEG and WebP
// and sampled in five ways. No camera, no light.
Bytes manyMaterialsModel();

// All of the above, by the names of files.
std::map<std::string, Bytes> allModels();

// `made`, and of `real`, the names of files in a folder beside the checkout, those that are there; says aloud which are
// not. So a fresh checkout runs each test, on models of its own.
std::vector<std::string> withReal(std::vector<std::string> made, const std::vector<std::string>& real);

// A model of allModels(), written into a folder that goes with the process, or a real one beside the checkout.
std::filesystem::path modelPath(const std::string& name);

// Panoramas of a sky with a bright sun: as Radiance (new run lengths) and as OpenEXR.
Bytes radiancePanorama(uint32_t width, uint32_t height);
Bytes exrPanorama(uint32_t width, uint32_t height);

}  // namespace latelight::models
