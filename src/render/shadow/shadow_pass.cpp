#include "render/shadow/shadow_pass.h"

#include <cstring>

#include "render/visibility/hardware.h"
#include "shared/shadow.h"

namespace latelight::render {

namespace {

constexpr uint32_t kUnitOffset = 16;  // of the push constants: varyings.glsl

bool isPacked(uint32_t format) {
  return format == shared::kShadowRgba8 || format == shared::kShadowRgba8Classic;
}

vk::Pipeline makeShadowPipeline(vk::Device& device, const GpuScene& scene, const FrameSetup& setup, bool masked) {
  vk::GraphicsDesc desc;
  desc.vertex = "scene.vert";
  desc.fragment = masked ? "shadow_masked.frag" : "shadow.frag";
  desc.materialSet = scene.materialSetLayout();
  desc.constants = setup.constants();
  if (isPacked(setup.shadowFormat)) desc.colors = {shadowImageFormat(setup.shadowFormat)};
  desc.depth = setup.shadowFormat == shared::kShadowD16 ? VK_FORMAT_D16_UNORM : VK_FORMAT_D32_SFLOAT;
  desc.depthCompare = VK_COMPARE_OP_LESS;  // not reversed: depth is linear, and 1 is what a map is cleared to
  desc.name = masked ? "shadow masked" : "shadow";
  return vk::makePipeline(device, desc);
}

template <typename T>
vk::Buffer uploaded(vk::Device& device, const char* name, std::span<const T> values) {
  vk::Buffer buffer(device, {.size = values.size_bytes(), .kind = vk::MemoryKind::Upload, .name = name});
  std::memcpy(buffer.mapped(), values.data(), values.size_bytes());
  return buffer;
}

// What a map holds where nothing is: the farthest. rgba8-classic makes 0 of 1, so its maps are cleared to what no
// depth is packed to, and decodes to a little over 1.
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
  return glm::length(a.centre - b.centre) < a.radius + b.radius;
}

}  // namespace

VkFormat shadowImageFormat(uint32_t format) {
  if (isPacked(format)) return VK_FORMAT_R8G8B8A8_UNORM;
  return format == shared::kShadowD16 ? VK_FORMAT_D16_UNORM : VK_FORMAT_D32_SFLOAT;
}

ShadowMaps uploadShadows(vk::Device& device, ShadowPlan plan, const shared::FrameConstants& frame, uint32_t format) {
  ShadowMaps made{.plan = std::move(plan)};
  made.atlas = vk::Image(device, {.format = shadowImageFormat(format),
                                  .width = made.plan.width,
                                  .height = made.plan.height,
                                  .usage = VK_IMAGE_USAGE_SAMPLED_BIT | VK_IMAGE_USAGE_TRANSFER_SRC_BIT |
                                           (isPacked(format) ? VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT
                                                             : VK_IMAGE_USAGE_DEPTH_STENCIL_ATTACHMENT_BIT),
                                  .name = "shadow atlas"});
  std::vector<shared::View> views;
  for (const ShadowView& view : made.plan.views) views.push_back(view.drawn);
  made.maps = uploaded<shared::ShadowMap>(device, "shadow maps", made.plan.maps);
  made.views = uploaded<shared::View>(device, "shadow views", views);
  shared::FrameConstants constants = frame;
  constants.views = made.views.address();
  constants.viewCount = static_cast<uint32_t>(views.size());
  made.constants = uploaded<shared::FrameConstants>(device, "shadow constants", {&constants, 1});
  return made;
}

VkDeviceAddress ShadowMaps::addressOf(const ShadowPlan::Entry& entry, bool sun) const {
  static_assert(sizeof(shared::ShadowMap) % 4 == 0);  // two bits are free
  const VkDeviceAddress flags =
      (sun ? shared::kShadowSun : 0u) | (plan.maps[entry.first].maps == 6 ? shared::kShadowCube : 0u);
  return (maps.address() + entry.first * sizeof(shared::ShadowMap)) | flags;
}

ShadowPass::ShadowPass(vk::Device& device, const GpuScene& scene, const FrameSetup& setup)
    : format_(setup.shadowFormat), opaque_(makeShadowPipeline(device, scene, setup, false)) {
  if (anyMasked(scene)) masked_ = makeShadowPipeline(device, scene, setup, true);
}

graph::ImageId ShadowPass::add(graph::Graph& graph, const FrameInputs& inputs) const {
  ShadowMaps& maps = *inputs.shadows;
  const ShadowPlan& plan = maps.plan;
  if (maps.drawn) return graph.import(maps.atlas, graph::Use::SampledCompute);
  maps.drawn = true;
  const graph::ImageId atlas = graph.import(maps.atlas, std::nullopt);
  graph.exports(atlas, graph::Use::SampledCompute);
  graph::ImageId depth = atlas;
  std::vector<graph::Access> accesses;
  if (isPacked(format_)) {
    depth = graph.create(vk::ImageDesc{
        .format = VK_FORMAT_D32_SFLOAT, .width = plan.width, .height = plan.height, .name = "shadow depth"});
    accesses.emplace_back(atlas, graph::Use::ColorAttachment);
  }
  accesses.emplace_back(depth, graph::Use::DepthAttachment);
  graph.pass(graph::Stage::Shadows, "shadow maps", std::move(accesses), [=, this](graph::Context& context) {
    const VkRenderingAttachmentInfo color =
        cleared(context.image(atlas).view(), VkClearValue{.color = emptyTexel(format_)});
    const VkRenderingAttachmentInfo depthTarget =
        cleared(context.image(depth).view(), VkClearValue{.depthStencil = {1, 0}});
    const VkRenderingInfo rendering{.sType = VK_STRUCTURE_TYPE_RENDERING_INFO,
                                    .renderArea = {{0, 0}, {plan.width, plan.height}},
                                    .layerCount = 1,
                                    .colorAttachmentCount = isPacked(format_) ? 1u : 0u,
                                    .pColorAttachments = &color,
                                    .pDepthAttachment = &depthTarget};
    vkCmdBeginRendering(context.get(), &rendering);
    for (uint32_t map = 0; map < plan.views.size(); ++map) drawMap(context, inputs, map);
    vkCmdEndRendering(context.get());
  });
  return atlas;
}

void ShadowPass::drawMap(graph::Context& context, const FrameInputs& inputs, uint32_t map) const {
  const ShadowView& view = inputs.shadows->plan.views[map];
  const AtlasTile& tile = view.tile;
  const auto x = static_cast<float>(tile.x), y = static_cast<float>(tile.y), size = static_cast<float>(tile.size);
  const VkViewport viewport{x, y + size, size, -size, 0, 1};  // y up, as projection.h has it
  const VkRect2D area{{static_cast<int32_t>(tile.x), static_cast<int32_t>(tile.y)}, {tile.size, tile.size}};
  vkCmdSetViewport(context.get(), 0, 1, &viewport);
  vkCmdSetScissor(context.get(), 0, 1, &area);
  vkCmdPushConstants(context.get(), opaque_.layout.get(), VK_SHADER_STAGE_ALL, kUnitOffset, sizeof(view.unit),
                     &view.unit);
  FrameInputs drawn = inputs;
  drawn.constants = inputs.shadows->constants.address();
  SceneBinder binder(context, drawn, map, opaque_, masked_, {});
  const Frustum frustum(view.view);
  std::vector<Draw> runs;
  for (const Draw& draw : inputs.scene.draws()) {
    if (inputs.scene.material(draw.material).flags & shared::kMaterialBlended) continue;
    runs.clear();
    inputs.scene.appendRuns(
        draw,
        [&](const Sphere& bounds) {
          return frustum.touches(bounds) && (!view.within || overlap(*view.within, bounds));
        },
        runs);
    if (runs.empty()) continue;
    binder.bind(draw);
    vkCmdSetCullMode(context.get(), VK_CULL_MODE_NONE);
    for (const Draw& run : runs) drawRun(context, run);
  }
}

}  // namespace latelight::render
