// Compares plans of random graphs with the memory model: each plan must be correct and contain nothing superfluous.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <numeric>
#include <random>

#include "graph/aliasing.h"
#include "graph/graph.h"
#include "memory_model.h"
#include "plan_text.h"

namespace latelight::graph {
namespace {

const std::vector<std::vector<Use>> kImageUses = {{Use::ColorAttachment},
                                                  {Use::ColorAttachmentLoad},
                                                  {Use::DepthAttachment},
                                                  {Use::DepthAttachmentLoad},
                                                  {Use::DepthTest},
                                                  {Use::SampledFragment},
                                                  {Use::SampledCompute},
                                                  {Use::StorageRead},
                                                  {Use::StorageWrite},
                                                  {Use::StorageReadWrite},
                                                  {Use::FragmentWrite},
                                                  {Use::FragmentReadWrite},
                                                  {Use::CopySource},
                                                  {Use::CopyTarget},
                                                  {Use::DepthTest, Use::SampledFragment},
                                                  {Use::SampledFragment, Use::SampledCompute}};
const std::vector<std::vector<Use>> kBufferUses = {{Use::StorageRead},       {Use::StorageWrite},
                                                   {Use::StorageReadWrite},  {Use::FragmentWrite},
                                                   {Use::FragmentReadWrite}, {Use::VertexRead},
                                                   {Use::IndirectRead},      {Use::CopySource},
                                                   {Use::CopyTarget},        {Use::IndirectRead, Use::VertexRead}};

bool needsContents(const std::vector<Use>& uses) {
  for (const Use use : uses) {
    if (reads(use) && use != Use::CopyTarget) return true;
  }
  return false;
}

// A graph with a separate record of its declarations.
struct RandomGraph {
  // `transient`: many resources, few of them imported or exported, each used by few passes.
  explicit RandomGraph(uint32_t seed, bool transient = false) : random(seed), transient(transient) {
    const size_t resourceCount = 1 + pick(transient ? 16 : 6);
    for (size_t i = 0; i < resourceCount; ++i) addResource(i);
    const size_t passCount = 1 + pick(transient ? 40 : 16);
    for (size_t i = 0; i < passCount; ++i) addPass(i);
    for (size_t i = 0; i < resources.size(); ++i) addExport(i);
  }

  size_t pick(size_t count) { return random() % count; }

  void addResource(size_t index) {
    const std::string name = fmt::format("r{}", index);
    const bool isImage = pick(2), imported = pick(transient ? 8 : 3) == 0;
    Resource resource{.imported = imported};
    std::optional<Use> before;
    if (imported && pick(3)) {
      const auto& uses = isImage ? kImageUses : kBufferUses;
      before = uses[pick(uses.size())][0];
      resource.before = {*before};
    }
    if (isImage) {
      resource.image = imported ? graph.import(outsideImage, before) : graph.create(vk::ImageDesc{.name = name});
    } else {
      resource.buffer = imported ? graph.import(outsideBuffer, before) : graph.create(vk::BufferDesc{.name = name});
    }
    defined.push_back(before || (imported && !isImage));
    resources.push_back(resource);
  }

  void addPass(size_t index) {
    ModelPass pass;
    for (size_t i = 0; i < resources.size(); ++i) {
      if (pick(transient ? 4 : 2)) continue;
      const auto& all = resources[i].image ? kImageUses : kBufferUses;
      const std::vector<Use>& uses = all[pick(all.size())];
      if (!defined[i] && needsContents(uses)) continue;
      for (const Use use : uses) {
        if (resources[i].image)
          pass.accesses.emplace_back(resources[i].image, use);
        else
          pass.accesses.emplace_back(resources[i].buffer, use);
        if (writes(use)) defined[i] = true;
      }
    }
    graph.pass(Stage::Post, fmt::format("p{}", index), pass.accesses, {});
    passes.push_back(pass);
  }

  void addExport(size_t i) {
    if (!defined[i] || (transient ? pick(3) != 0 : pick(3) == 0)) return;
    const auto& all = resources[i].image ? kImageUses : kBufferUses;
    const Use use = !resources[i].image && pick(2) ? Use::HostRead : all[pick(all.size())][0];
    resources[i].exported = {use};
    if (resources[i].image)
      graph.exports(resources[i].image, use);
    else
      graph.exports(resources[i].buffer, use);
  }

  std::string text(const Plan& plan) const {
    std::string result;
    for (const std::string& line : planText(graph, plan)) result += line + "\n";
    return result;
  }

  std::mt19937 random;
  bool transient;
  const vk::Image outsideImage;
  const vk::Buffer outsideBuffer;
  Graph graph;
  std::vector<Resource> resources;
  std::vector<ModelPass> passes;
  std::vector<bool> defined;
};

constexpr uint32_t kGraphs = 5000;

std::vector<Barrier*> allBarriers(Plan& plan) {
  std::vector<Barrier*> all;
  for (Plan::Step& step : plan.steps) {
    for (Barrier& barrier : step.before) all.push_back(&barrier);
  }
  for (Barrier& barrier : plan.after) all.push_back(&barrier);
  return all;
}

TEST(RandomGraphs, HaveNoHazards) {
  size_t barriers = 0, steps = 0;
  for (uint32_t seed = 0; seed < kGraphs; ++seed) {
    const RandomGraph random(seed);
    Plan plan = random.graph.compile();
    const std::vector<std::string> wrong = findHazards(random.resources, random.passes, plan);
    ASSERT_TRUE(wrong.empty()) << "seed " << seed << ": " << wrong[0] << "\n" << random.text(plan);
    barriers += allBarriers(plan).size();
    steps += plan.steps.size();
  }
  // The generated graphs contain what the test checks.
  EXPECT_GT(barriers, 5 * kGraphs);
  EXPECT_GT(steps, kGraphs);
}

TEST(RandomGraphs, HaveNoBarrierTooMany) {
  for (uint32_t seed = 0; seed < kGraphs; ++seed) {
    const RandomGraph random(seed);
    const Plan plan = random.graph.compile();
    const auto complains = [&](const Plan& less) {
      return !findHazards(random.resources, random.passes, less).empty();
    };
    for (size_t s = 0; s <= plan.steps.size(); ++s) {
      const size_t count = s < plan.steps.size() ? plan.steps[s].before.size() : plan.after.size();
      for (size_t b = 0; b < count; ++b) {
        Plan less = plan;
        std::vector<Barrier>& list = s < plan.steps.size() ? less.steps[s].before : less.after;
        list.erase(list.begin() + static_cast<ptrdiff_t>(b));
        ASSERT_TRUE(complains(less)) << "seed " << seed << ", barrier " << b << " of step " << s << " is not needed\n"
                                     << random.text(plan);
      }
    }
  }
}

// Calls the function with each bit removed in turn.
template <typename Flags>
void expectEachBitNeeded(const RandomGraph& random, Plan& plan, const Barrier& barrier, Flags& flags) {
  const Flags whole = flags;
  for (Flags rest = whole; rest; rest &= rest - 1) {
    flags = whole & ~(rest & (~rest + 1));
    const bool noticed = !findHazards(random.resources, random.passes, plan).empty();
    const std::string less = barrierText(random.graph, barrier);
    flags = whole;
    ASSERT_TRUE(noticed) << less << " would do in\n" << random.text(plan);
  }
}

TEST(RandomGraphs, HaveNoBitTooMany) {
  for (uint32_t seed = 0; seed < kGraphs / 4 && !testing::Test::HasFatalFailure(); ++seed) {
    const RandomGraph random(seed);
    Plan plan = random.graph.compile();
    for (Barrier* barrier : allBarriers(plan)) {
      expectEachBitNeeded(random, plan, *barrier, barrier->targetStage);
      // A write after reads waits again for what the reads have already waited for. This is simpler and flushes no
      // memory.
      if (barrier->sourceAccess) expectEachBitNeeded(random, plan, *barrier, barrier->targetAccess);
    }
  }
}

// A plan in which transients of random sizes share memory.
struct AliasedPlan {
  explicit AliasedPlan(uint32_t seed) : graph(seed, true), plan(graph.graph.compile()) {
    std::vector<Footprint> footprints;
    for (const Plan::Lifetime& life : plan.lives)
      footprints.push_back({.size = 1 + graph.pick(graph.pick(2) ? 4 : 40), .first = life.first, .last = life.last});
    const Packing packing = pack(footprints, ~uint64_t{0});
    for (size_t i = 0; i < plan.lives.size(); ++i) {
      Resource& resource = resourceOf(plan.lives[i]);
      resource.begin = packing.places[i].offset;
      resource.end = resource.begin + footprints[i].size;
    }
    addAliasingBarriers(plan, footprints, packing);
  }

  Resource& resourceOf(const Plan::Transient& transient) {
    return *std::find_if(graph.resources.begin(), graph.resources.end(), [&](const Resource& resource) {
      return transient.image ? resource.image == transient.image : resource.buffer == transient.buffer;
    });
  }

  // Counts the resources whose memory had other contents before.
  std::vector<Barrier*> aliasingBarriers() {
    std::vector<Barrier*> result;
    for (const Plan::Lifetime& life : plan.lives)
      for (Barrier& barrier : plan.steps[life.first].before)
        if (barrier.image == life.image && barrier.buffer == life.buffer && barrier.sourceStage)
          result.push_back(&barrier);
    return result;
  }

  std::vector<std::string> hazards() const {
    std::vector<std::string> wrong = findHazards(graph.resources, graph.passes, plan);
    const std::vector<std::string> aliasing = findAliasingHazards(graph.resources, graph.passes, plan);
    wrong.insert(wrong.end(), aliasing.begin(), aliasing.end());
    return wrong;
  }

  RandomGraph graph;
  Plan plan;
};

TEST(RandomGraphs, HaveNoHazardsWhereTransientsShareMemory) {
  size_t aliases = 0;
  for (uint32_t seed = 0; seed < kGraphs; ++seed) {
    AliasedPlan aliased(seed);
    const std::vector<std::string> wrong = aliased.hazards();
    ASSERT_TRUE(wrong.empty()) << "seed " << seed << ": " << wrong[0] << "\n" << aliased.graph.text(aliased.plan);
    aliases += aliased.aliasingBarriers().size();
  }
  EXPECT_GT(aliases, kGraphs / 4);  // enough aliases to test
}

// Removes either all stages or one of the accesses that a barrier waits for, and expects that the model notices.
// (Single stages may be superfluous: reads that a barrier has ordered before later reads are waited for again. The same
// holds for accesses to images: writes to an image are waited for again if buffers have used its memory since.)
TEST(RandomGraphs, NoticeWhatAnAliasingBarrierLacks) {
  size_t noticed = 0;  // accesses of images
  for (uint32_t seed = 0; seed < kGraphs; ++seed) {
    AliasedPlan aliased(seed);
    const auto expectNoticed = [&](const Barrier& less) {
      ASSERT_FALSE(aliased.hazards().empty())
          << "seed " << seed << ": " << barrierText(aliased.graph.graph, less) << " would do in\n"
          << aliased.graph.text(aliased.plan);
    };
    for (Barrier* barrier : aliased.aliasingBarriers()) {
      const Barrier whole = *barrier;
      barrier->sourceStage = 0;
      expectNoticed(*barrier);
      for (VkAccessFlags2 rest = whole.sourceAccess; rest; rest &= rest - 1) {
        *barrier = whole;
        barrier->sourceAccess &= ~(rest & (~rest + 1));
        if (!barrier->image) expectNoticed(*barrier);
        noticed += barrier->image && !aliased.hazards().empty();
      }
      *barrier = whole;
      if (testing::Test::HasFatalFailure()) return;
    }
  }
  EXPECT_GT(noticed, kGraphs / 8);
}

TEST(RandomGraphs, RunWhatTheExportsNeedAndNothingElse) {
  for (uint32_t seed = 0; seed < kGraphs; ++seed) {
    const RandomGraph random(seed);
    const Plan plan = random.graph.compile();
    std::vector<uint32_t> everything(random.passes.size()), planned;
    std::iota(everything.begin(), everything.end(), 0);
    for (const Plan::Step& step : plan.steps) planned.push_back(step.pass);
    ASSERT_TRUE(std::is_sorted(planned.begin(), planned.end()));

    const std::vector<uint64_t> right = exportedValues(random.resources, random.passes, everything);
    ASSERT_EQ(exportedValues(random.resources, random.passes, planned), right) << "seed " << seed;
    for (size_t i = 0; i < planned.size(); ++i) {
      std::vector<uint32_t> less = planned;
      less.erase(less.begin() + static_cast<ptrdiff_t>(i));
      ASSERT_NE(exportedValues(random.resources, random.passes, less), right)
          << "seed " << seed << ": pass " << planned[i] << " is not needed\n"
          << random.text(plan);
    }
  }
}

}  // namespace
}  // namespace latelight::graph
