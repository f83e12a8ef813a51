// Memory aliasing: which transients share memory, tested on plain data.
#include "graph/aliasing.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "plan_text.h"

namespace latelight::graph {
namespace {

using testing::ElementsAre;

constexpr uint64_t kAnySize = ~uint64_t{0};

bool lifetimesOverlap(const Footprint& a, const Footprint& b) {
  return a.first <= b.last && b.first <= a.last;
}

// Expects that resources with overlapping lifetimes do not overlap in memory, and that each has a heap of its type and
// its alignment.
void expectRight(const std::vector<Footprint>& footprints, const Packing& packing) {
  ASSERT_EQ(packing.places.size(), footprints.size());
  for (size_t i = 0; i < footprints.size(); ++i) {
    const Placement& place = packing.places[i];
    ASSERT_LT(place.heap, packing.heaps.size());
    const Packing::Heap& heap = packing.heaps[place.heap];
    EXPECT_EQ(heap.type, footprints[i].type);
    EXPECT_EQ(heap.alignment % footprints[i].alignment, 0u);
    EXPECT_EQ(place.offset % footprints[i].alignment, 0u);
    EXPECT_LE(place.offset + footprints[i].size, heap.size);
    for (size_t j = 0; j < i; ++j) {
      const Placement& other = packing.places[j];
      if (place.heap != other.heap || !lifetimesOverlap(footprints[i], footprints[j])) continue;
      EXPECT_TRUE(place.offset + footprints[i].size <= other.offset ||
                  other.offset + footprints[j].size <= place.offset)
          << i << " and " << j << " overlap";
    }
  }
}

// Returns the maximum sum of sizes that are needed in one step, a lower bound for any packing.
uint64_t largestNeed(const std::vector<Footprint>& footprints) {
  uint64_t largest = 0;
  for (const Footprint& at : footprints) {
    uint64_t sum = 0;
    for (const Footprint& f : footprints) sum += f.first <= at.first && at.first <= f.last ? f.size : 0;
    largest = std::max(largest, sum);
  }
  return largest;
}

uint64_t sumOf(const std::vector<Footprint>& footprints) {
  uint64_t sum = 0;
  for (const Footprint& f : footprints) sum += f.size;
  return sum;
}

TEST(Packing, OfNothingIsEmpty) {
  const Packing packing = pack({}, kAnySize);
  EXPECT_TRUE(packing.heaps.empty());
  EXPECT_EQ(packing.bytes(), 0u);
}

TEST(Packing, SharesWhatIsNeededAtDifferentTimes) {
  const std::vector<Footprint> chain = {{100, 1, 0, 0, 1}, {100, 1, 0, 1, 2}, {100, 1, 0, 2, 3}, {100, 1, 0, 3, 4}};
  const Packing packing = pack(chain, kAnySize);
  expectRight(chain, packing);
  EXPECT_EQ(packing.bytes(), 200u);
  EXPECT_EQ(packing.places[0].offset, packing.places[2].offset);
}

TEST(Packing, KeepsApartWhatIsOfDifferentTypes) {
  const std::vector<Footprint> two = {{100, 1, 3, 0, 0}, {100, 1, 5, 1, 1}};
  const Packing packing = pack(two, kAnySize);
  expectRight(two, packing);
  EXPECT_EQ(packing.heaps.size(), 2u);
}

TEST(Packing, TakesAnotherHeapWhereOneWouldBeTooLarge) {
  const std::vector<Footprint> five = {
      {60, 1, 0, 0, 9}, {60, 1, 0, 0, 9}, {30, 1, 0, 0, 9}, {400, 1, 0, 0, 9}, {40, 1, 0, 0, 9}};
  const Packing packing = pack(five, 100);
  expectRight(five, packing);
  EXPECT_EQ(packing.bytes(), 590u);
  for (const Packing::Heap& heap : packing.heaps) EXPECT_TRUE(heap.size <= 100 || heap.size == 400) << heap.size;
  EXPECT_EQ(packing.heaps.size(), 3u);
}

// Sizes and lifetimes similar to those of frames: targets of a few kinds and small buffers, most of them short-lived.
std::vector<Footprint> randomFootprints(std::mt19937& random) {
  const auto pick = [&](uint32_t count) { return static_cast<uint32_t>(random() % count); };
  std::vector<Footprint> footprints(1 + pick(60));
  const uint32_t steps = 1 + pick(40);
  for (Footprint& f : footprints) {
    f.alignment = uint64_t{1} << pick(13);
    f.size = f.alignment * (1 + pick(pick(2) ? 8 : 300));
    f.first = pick(steps);
    f.last = std::min(steps - 1, f.first + pick(pick(3) ? 4 : steps));
  }
  return footprints;
}

TEST(Packing, OfRandomLivesIsRightAndTight) {
  std::mt19937 random(1);
  double worst = 0, sum = 0;
  constexpr int kRounds = 3000;
  for (int round = 0; round < kRounds && !testing::Test::HasFailure(); ++round) {
    const std::vector<Footprint> footprints = randomFootprints(random);
    const Packing packing = pack(footprints, kAnySize);
    expectRight(footprints, packing);
    EXPECT_GE(packing.bytes(), largestNeed(footprints));
    const double ratio = static_cast<double>(packing.bytes()) / static_cast<double>(largestNeed(footprints));
    worst = std::max(worst, ratio);
    sum += ratio;
    // Alignment may leave gaps, but the result is at most as large as without sharing.
    uint64_t aligned = 0;
    for (const Footprint& f : footprints) aligned += f.size + f.alignment - 1;
    EXPECT_LE(packing.bytes(), aligned);
  }
  EXPECT_LE(worst, 1.3);
  EXPECT_LE(sum / kRounds, 1.02);
}

TEST(Packing, OfRandomLivesIsAtMostTheirSumWhereAlignmentsAreAlike) {
  std::mt19937 random(2);
  for (int round = 0; round < 1000; ++round) {
    std::vector<Footprint> footprints = randomFootprints(random);
    for (Footprint& f : footprints) {
      f.size = (f.size + 255) / 256 * 256;
      f.alignment = 256;
    }
    ASSERT_LE(pack(footprints, kAnySize).bytes(), sumOf(footprints));
  }
}

TEST(Packing, OfRandomLivesKeepsToHeapsOfALimitedSize) {
  std::mt19937 random(3);
  for (int round = 0; round < 500 && !testing::Test::HasFailure(); ++round) {
    std::vector<Footprint> footprints = randomFootprints(random);
    for (Footprint& f : footprints) f.type = random() % 2;
    constexpr uint64_t kLargest = 400000;
    const Packing packing = pack(footprints, kLargest);
    expectRight(footprints, packing);
    for (const Packing::Heap& heap : packing.heaps) {
      const bool alone =
          std::any_of(footprints.begin(), footprints.end(), [&](const Footprint& f) { return f.size == heap.size; });
      EXPECT_TRUE(heap.size <= kLargest || alone) << heap.size;
    }
  }
}

class Aliasing : public testing::Test {
 protected:
  ImageId image(const char* name) { return graph.create(vk::ImageDesc{.name = name}); }
  BufferId buffer(const char* name) { return graph.create(vk::BufferDesc{.size = 256, .name = name}); }
  void pass(const char* name, std::vector<Access> accesses) { graph.pass(Stage::Post, name, std::move(accesses), {}); }

  // Returns the plan if all resources that may share memory start at offset 0 of one heap.
  std::vector<std::string> plan(const std::vector<uint64_t>& sizes = {}) const {
    Plan plan = graph.compile();
    std::vector<Footprint> footprints;
    for (size_t i = 0; i < plan.lives.size(); ++i)
      footprints.push_back({sizes.empty() ? 64 : sizes[i], 1, 0, plan.lives[i].first, plan.lives[i].last});
    const Packing packing = pack(footprints, kAnySize);
    addAliasingBarriers(plan, footprints, packing);
    return planText(graph, plan);
  }
  Graph graph;
};

TEST_F(Aliasing, KnowsTheLivesOfTransients) {
  const ImageId color = image("color"), lit = image("lit");
  const BufferId list = buffer("list"), unused = buffer("unused"), out = buffer("out");
  const BufferId upload = graph.create(vk::BufferDesc{.size = 4, .kind = vk::MemoryKind::Upload, .name = "upload"});
  const vk::Buffer outside;
  const BufferId imported = graph.import(outside, std::nullopt);
  pass("cull", {{imported, Use::StorageRead}, {list, Use::StorageWrite}});
  pass("unseen", {{unused, Use::StorageWrite}});
  pass("draw", {{list, Use::IndirectRead}, {color, Use::ColorAttachment}, {upload, Use::CopyTarget}});
  pass("light", {{color, Use::SampledCompute}, {upload, Use::StorageRead}, {lit, Use::StorageWrite}});
  pass("more light", {{lit, Use::StorageReadWrite}});
  pass("copy", {{lit, Use::CopySource}, {out, Use::CopyTarget}});
  graph.exports(out, Use::HostRead);
  const Plan plan = graph.compile();
  std::vector<std::string> lives, kept;
  for (const Plan::Lifetime& life : plan.lives)
    lives.push_back(fmt::format("{} {}-{}, then {}[{}]",
                                life.image ? graph.desc(life.image).name : graph.desc(life.buffer).name, life.first,
                                life.last, stageText(life.lastStages), accessText(life.lastWrites)));
  EXPECT_THAT(lives, ElementsAre("list 0-1, then draw[-]", "color 1-2, then comp[-]", "lit 2-4, then copy[-]"));
  for (const Plan::Transient& transient : plan.kept) kept.push_back(graph.desc(transient.buffer).name);
  EXPECT_THAT(kept, ElementsAre("out", "upload"));
}

// A blur of a blur: the third image has the memory of the first.
TEST_F(Aliasing, WaitsForTheLastReads) {
  const ImageId a = image("a"), b = image("b"), c = image("c");
  pass("draw", {{a, Use::ColorAttachment}});
  pass("blur", {{a, Use::SampledCompute}, {b, Use::StorageWrite}});
  pass("again", {{b, Use::StorageRead}, {c, Use::ColorAttachment}});
  pass("out", {{c, Use::ColorAttachmentLoad}});
  const BufferId out = buffer("out");
  pass("copy", {{c, Use::CopySource}, {out, Use::CopyTarget}});
  graph.exports(out, Use::HostRead);
  EXPECT_THAT(plan(), ElementsAre("draw",                                               //
                                  "  a: -[-] -> color[Cr|Cw] undefined>attachment",     //
                                  "blur",                                               //
                                  "  a: color[Cw] -> comp[T] attachment>readonly",      //
                                  "  b: -[-] -> comp[Sw] undefined>general",            //
                                  "again",                                              //
                                  "  b: comp[Sw] -> comp[Sr] general",                  //
                                  "  c: comp[-] -> color[Cr|Cw] undefined>attachment",  // had the memory of a
                                  "out",                                                //
                                  "  c: color[Cw] -> color[Cr|Cw] attachment",          //
                                  "copy",                                               //
                                  "  c: color[Cw] -> copy[Xr] attachment>source",       //
                                  "end",                                                //
                                  "  out: copy[Xw] -> host[H]"));
}

// The first use of a buffer needs no barrier except for aliasing, and writes that were never read must become
// available.
TEST_F(Aliasing, WaitsForWritesThatNobodyRead) {
  const BufferId a = buffer("a"), side = buffer("side"), b = buffer("b"), out = buffer("out");
  pass("first", {{side, Use::FragmentWrite}, {a, Use::StorageWrite}, {out, Use::StorageWrite}});
  pass("second", {{b, Use::CopyTarget}});
  pass("third", {{b, Use::StorageRead}, {out, Use::StorageReadWrite}});
  graph.exports(out, Use::HostRead);
  EXPECT_THAT(plan({64, 64, 128}), ElementsAre("first",                           //
                                               "second",                          //
                                               "  b: frag|comp[Sw] -> copy[Xw]",  // had the memory of both
                                               "third",                           //
                                               "  b: copy[Xw] -> comp[Sr]",       //
                                               "  out: comp[Sw] -> comp[Sr|Sw]",  //
                                               "end",                             //
                                               "  out: comp[Sw] -> host[H]"));
}

}  // namespace
}  // namespace latelight::graph
