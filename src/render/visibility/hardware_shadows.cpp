// Shadow maps by the graphics pipeline. Every surface that is not blended casts shadows from both sides, even if its
// material is single-sided, so that a wall modeled from the inside blocks light from the outside. Masked surfaces are
// alpha tested.
#include "base/parallel.h"
#include "render/shadow/frame_shadows.h"
#include "render/visibility/hardware.h"
#include "shared/shadow.h"

namespace latelight::render {

namespace {

ScenePipelines shadowPipelines(const FrameContext& f) {
  const uint32_t format = f.setup.shadowFormat;
  vk::GraphicsDesc desc;
  desc.constants = f.setup.constants();
  desc.pushBytes = pushBytesWith<shared::ShadowDraw>();
  if (shadowIsPacked(format)) desc.colors = {shadowImageFormat(format)};
  desc.depth = format == shared::kShadowD16 ? VK_FORMAT_D16_UNORM : VK_FORMAT_D32_SFLOAT;
  desc.depthCompare = VK_COMPARE_OP_LESS;  // not reversed: depth is linear and maps are cleared to 1
  desc.fragment = "shadow.frag";
  desc.name = "shadow";
  vk::GraphicsDesc masked = desc;
  masked.fragment = "shadow_masked.frag";
  desc.vertex = "scene_depth.vert";
  return scenePipelines(f, desc, masked);
}

// Returns the texel of an empty map, the farthest depth. rgba8-classic packs 1 as 0, so its maps are cleared to a value
// that no depth packs to and that decodes to slightly more than 1.
VkClearColorValue emptyTexel(uint32_t format) {
  VkClearColorValue value{};
  const shared::vec4 packed = format == shared::kShadowRgba8 ? shared::packDepth(1.0f) : shared::vec4(1);
  for (int i = 0; i < 4; ++i) value.float32[i] = packed[i];
  return value;
}

VkRenderingAttachmentInfo cleared(VkImageView view, const VkClearValue& value) {
  return {.sType = VK_STRUCTURE_TYPE_RENDERING_ATTACHMENT_INFO,
          .imageView = view,
          .imageLayout = VK_IMAGE_LAYOUT_ATTACHMENT_OPTIMAL,
          .loadOp = VK_ATTACHMENT_LOAD_OP_CLEAR,
          .storeOp = VK_ATTACHMENT_STORE_OP_STORE,
          .clearValue = value};
}

bool overlap(const Sphere& a, const Sphere& b) {
  return glm::length(a.center - b.center) < a.radius + b.radius;
}

// Selects the shadow casters, one list per map.
DeviceDraws selectCasters(const FrameContext& f, const DrawOrder& order) {
  const std::span<const FrameShadows::Map> maps = f.shadows->maps();
  std::vector<DrawList> lists(maps.size());
  parallelFor(maps.size(), 1, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) {
      const ShadowView& map = *maps[i].view;
      const Frustum frustum(map.view);
      lists[i] = order.select(
          f.scene, DrawOrder::Kind::Solid,
          [&](const Sphere& bounds) {
            return frustum.touches(bounds) && (!map.within || overlap(*map.within, bounds));
          },
          0, map.view.world);
    }
  });
  return {f.device, std::move(lists)};
}

struct ShadowTargets {
  graph::ImageId atlas, depth;  // equal if depth is not packed
  bool packed;
  uint32_t format;
};

void beginLayer(graph::Context& context, const ShadowTargets& targets, uint32_t layer) {
  const vk::Image& atlas = context.image(targets.atlas);
  const VkRenderingAttachmentInfo color =
      cleared(atlas.layerView(layer), VkClearValue{.color = emptyTexel(targets.format)});
  const VkRenderingAttachmentInfo depth =
      cleared(context.image(targets.depth).layerView(targets.packed ? 0 : layer), VkClearValue{.depthStencil = {1, 0}});
  const VkRenderingInfo rendering{.sType = VK_STRUCTURE_TYPE_RENDERING_INFO,
                                  .renderArea = {{0, 0}, {atlas.desc().width, atlas.desc().height}},
                                  .layerCount = 1,
                                  .colorAttachmentCount = targets.packed ? 1u : 0u,
                                  .pColorAttachments = &color,
                                  .pDepthAttachment = &depth};
  vkCmdBeginRendering(context.get(), &rendering);
}

void setTile(graph::Context& context, const AtlasTile& tile) {
  const auto x = static_cast<float>(tile.x), y = static_cast<float>(tile.y), size = static_cast<float>(tile.size);
  const VkViewport viewport{x, y + size, size, -size, 0, 1};  // y up, as in projection.h
  const VkRect2D area{{static_cast<int32_t>(tile.x), static_cast<int32_t>(tile.y)}, {tile.size, tile.size}};
  vkCmdSetViewport(context.get(), 0, 1, &viewport);
  vkCmdSetScissor(context.get(), 0, 1, &area);
}

}  // namespace

void HardwareVisibility::addShadowMaps(const FrameContext& f, const Gbuffer&, graph::ImageId atlas) const {
  ShadowTargets targets{atlas, atlas, shadowIsPacked(f.setup.shadowFormat), f.setup.shadowFormat};
  std::vector<graph::Access> accesses;
  if (targets.packed) {
    const vk::ImageDesc& desc = f.graph.desc(atlas);
    targets.depth = f.graph.create(vk::ImageDesc{
        .format = VK_FORMAT_D32_SFLOAT, .width = desc.width, .height = desc.height, .name = "shadow depth"});
    accesses.emplace_back(atlas, graph::Use::ColorAttachment);
  }
  accesses.emplace_back(targets.depth, graph::Use::DepthAttachment);
  const ScenePipelines pipelines = shadowPipelines(f);
  const auto casters = std::make_shared<DeviceDraws>(selectCasters(f, order_));
  f.graph.pass(graph::Stage::Shadows, "shadow maps", std::move(accesses), [=, this](graph::Context& context) {
    const std::span<const FrameShadows::Map> maps = f.shadows->maps();
    for (uint32_t i = 0; i < maps.size(); ++i) {
      const uint32_t layer = maps[i].tile.layer;
      if (i == 0 || layer != maps[i - 1].tile.layer) beginLayer(context, targets, layer);
      setTile(context, maps[i].tile);
      const VkDeviceAddress frame =
          f.shadows->mapConstants() + (scene_.hasWorlds() ? i * sizeof(shared::FrameConstants) : 0);
      const VkDeviceAddress instances = scene_.instancesOf(maps[i].view->view.world).address;
      SceneBinder binder(context, scene_, *casters, {frame, f.shadows->mapViews(), i, instances}, pipelines);
      for (const Draw& draw : (*casters)[i]) {
        pushMore(context, binder.bind(draw), shared::ShadowDraw{maps[i].view->unit});
        vkCmdSetCullMode(context.get(), VK_CULL_MODE_NONE);
        recordDraw(context, scene_, draw);
      }
      if (i + 1 == maps.size() || layer != maps[i + 1].tile.layer) vkCmdEndRendering(context.get());
    }
  });
}

}  // namespace latelight::render
