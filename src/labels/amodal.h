// Amodal masks: renders each object of a frame in isolation to find the pixels that it would cover if nothing occluded
// it (Zhu, Tian, Metaxas and Dollár 2017, "Semantic Amodal Segmentation").
#pragma once

#include <span>
#include <vector>

#include "labels/objects.h"
#include "render/submit/renderer.h"

namespace latelight::labels {

// Fills Object::alone, Object::pixels and Object::full. The masks come from the output `id`, rendered with the frame's
// settings but without lighting. Objects whose screen bounds do not overlap share a view, and several views are
// rendered at once. Objects that cross the picture's border are rendered a second time in a picture three times as wide
// and high around it. Pixels beyond the border are not counted if there can be no such picture: for lenses that bend
// rays and for the largest sizes. An object at exactly the position of another object with the same mesh and material
// is never drawn and has an empty mask.
//
// `order` also fills Object::occludes: the distances of the isolated objects tell which is in front of which at the
// pixels that both cover.
void renderIsolated(render::Renderer& renderer, const scene::Scene& scene, const scene::Camera& camera,
                    const render::Settings& settings, const render::SceneState& moment, std::vector<Object>& objects,
                    bool order = false);

// The same for several cameras, which may show different worlds, with one list of objects each. Objects with the same
// id share an image with other objects only if their bounds do not overlap in any view. This includes the bounds of
// objects that are visible only in the enlarged pictures of other objects.
void renderIsolated(render::Renderer& renderer, const scene::Scene& scene, const std::vector<scene::Camera>& cameras,
                    const render::Settings& settings, const render::SceneState& moment,
                    std::span<std::vector<Object>> objects, bool order = false);

}  // namespace latelight::labels
