// The table of resource uses: pipeline stages, access flags, image layouts and usage flags.
#include "graph/use.h"

#include <array>

namespace latelight::graph {
namespace {

// clang-format off
constexpr VkPipelineStageFlags2 kColorStage = VK_PIPELINE_STAGE_2_COLOR_ATTACHMENT_OUTPUT_BIT;
constexpr VkPipelineStageFlags2 kDepthStages =
    VK_PIPELINE_STAGE_2_EARLY_FRAGMENT_TESTS_BIT | VK_PIPELINE_STAGE_2_LATE_FRAGMENT_TESTS_BIT;
constexpr VkPipelineStageFlags2 kCompute = VK_PIPELINE_STAGE_2_COMPUTE_SHADER_BIT;
constexpr VkPipelineStageFlags2 kFragment = VK_PIPELINE_STAGE_2_FRAGMENT_SHADER_BIT;
constexpr VkPipelineStageFlags2 kDraw = VK_PIPELINE_STAGE_2_VERTEX_SHADER_BIT | kFragment;
constexpr VkPipelineStageFlags2 kCopy = VK_PIPELINE_STAGE_2_ALL_TRANSFER_BIT;  // copies, blits, resolves and clears

// Blending and depth tests read the attachment even if its contents before the pass are not needed.
constexpr VkAccessFlags2 kColorRead = VK_ACCESS_2_COLOR_ATTACHMENT_READ_BIT;
constexpr VkAccessFlags2 kColorWrite = VK_ACCESS_2_COLOR_ATTACHMENT_WRITE_BIT;
constexpr VkAccessFlags2 kDepthRead = VK_ACCESS_2_DEPTH_STENCIL_ATTACHMENT_READ_BIT;
constexpr VkAccessFlags2 kDepthWrite = VK_ACCESS_2_DEPTH_STENCIL_ATTACHMENT_WRITE_BIT;
constexpr VkAccessFlags2 kSampled = VK_ACCESS_2_SHADER_SAMPLED_READ_BIT;
constexpr VkAccessFlags2 kStorageRead = VK_ACCESS_2_SHADER_STORAGE_READ_BIT;
constexpr VkAccessFlags2 kStorageWrite = VK_ACCESS_2_SHADER_STORAGE_WRITE_BIT;

// One layout for all read-only uses, so that a depth buffer can be tested and sampled in one pass.
constexpr VkImageLayout kAttachment = VK_IMAGE_LAYOUT_ATTACHMENT_OPTIMAL;
constexpr VkImageLayout kReadOnly = VK_IMAGE_LAYOUT_READ_ONLY_OPTIMAL;
constexpr VkImageLayout kGeneral = VK_IMAGE_LAYOUT_GENERAL;
constexpr VkImageLayout kNoImages = VK_IMAGE_LAYOUT_UNDEFINED;

constexpr VkImageUsageFlags kColorUsage = VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT;
constexpr VkImageUsageFlags kDepthUsage = VK_IMAGE_USAGE_DEPTH_STENCIL_ATTACHMENT_BIT;
constexpr VkImageUsageFlags kSampledUsage = VK_IMAGE_USAGE_SAMPLED_BIT;
constexpr VkImageUsageFlags kStorageUsage = VK_IMAGE_USAGE_STORAGE_BIT;
constexpr VkBufferUsageFlags kStorage = VK_BUFFER_USAGE_STORAGE_BUFFER_BIT;

constexpr std::array<UseInfo, 17> kTable = {{
  // name                  stages        reading       writing        layout       image usage    buffer usage  buffers keeps
  {"ColorAttachment",      kColorStage,  kColorRead,   kColorWrite,   kAttachment, kColorUsage,   0,            false,  false},
  {"ColorAttachmentLoad",  kColorStage,  kColorRead,   kColorWrite,   kAttachment, kColorUsage,   0,            false,  true},
  {"DepthAttachment",      kDepthStages, kDepthRead,   kDepthWrite,   kAttachment, kDepthUsage,   0,            false,  false},
  {"DepthAttachmentLoad",  kDepthStages, kDepthRead,   kDepthWrite,   kAttachment, kDepthUsage,   0,            false,  true},
  {"DepthTest",            kDepthStages, kDepthRead,   0,             kReadOnly,   kDepthUsage,   0,            false,  true},
  {"SampledFragment",      kFragment,    kSampled,     0,             kReadOnly,   kSampledUsage, 0,            false,  true},
  {"SampledCompute",       kCompute,     kSampled,     0,             kReadOnly,   kSampledUsage, 0,            false,  true},
  {"StorageRead",          kCompute,     kStorageRead, 0,             kGeneral,    kStorageUsage, kStorage,     true,   true},
  {"StorageWrite",         kCompute,     0,            kStorageWrite, kGeneral,    kStorageUsage, kStorage,     true,   false},
  {"StorageReadWrite",     kCompute,     kStorageRead, kStorageWrite, kGeneral,    kStorageUsage, kStorage,     true,   true},
  {"FragmentWrite",        kFragment,    0,            kStorageWrite, kGeneral,    kStorageUsage, kStorage,     true,   false},
  {"FragmentReadWrite",    kFragment,    kStorageRead, kStorageWrite, kGeneral,    kStorageUsage, kStorage,     true,   true},
  {"VertexRead",           kDraw,        kStorageRead, 0,             kNoImages,   0,             kStorage,     true,   true},
  {"IndirectRead",         VK_PIPELINE_STAGE_2_DRAW_INDIRECT_BIT, VK_ACCESS_2_INDIRECT_COMMAND_READ_BIT, 0,
                           kNoImages,    0, VK_BUFFER_USAGE_INDIRECT_BUFFER_BIT, true, true},
  {"CopySource",           kCopy, VK_ACCESS_2_TRANSFER_READ_BIT, 0, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL,
                           VK_IMAGE_USAGE_TRANSFER_SRC_BIT, 0, true, true},
  {"CopyTarget",           kCopy, 0, VK_ACCESS_2_TRANSFER_WRITE_BIT, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL,
                           VK_IMAGE_USAGE_TRANSFER_DST_BIT, 0, true, true},
  {"HostRead",             VK_PIPELINE_STAGE_2_HOST_BIT, VK_ACCESS_2_HOST_READ_BIT, 0, kNoImages, 0, 0, true, true},
}};
// clang-format on
static_assert(kTable.size() == size_t(Use::HostRead) + 1);

}  // namespace

const UseInfo& useInfo(Use use) {
  return kTable[static_cast<size_t>(use)];
}

bool writes(Use use) {
  return useInfo(use).writing != 0;
}

bool reads(Use use) {
  return useInfo(use).keeps;
}

void ResourceUse::add(Use use, bool image) {
  const UseInfo& info = useInfo(use);
  stages |= info.stages;
  access |= info.reading | info.writing;
  writing |= info.writing;
  if (image) layout = info.layout;
  keeps |= info.keeps;
  reads |= info.keeps && info.reading;
}

}  // namespace latelight::graph
