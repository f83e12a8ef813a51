// Compares compiled plans with plans written by hand: the passes that run, and every barrier.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "base/error.h"
#include "error_of.h"
#include "graph/graph.h"
#include "plan_text.h"

namespace latelight::graph {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

class Plans : public testing::Test {
 protected:
  ImageId image(const char* name, uint32_t layers = 1) {
    return graph.create(
        vk::ImageDesc{.format = VK_FORMAT_R8G8B8A8_UNORM, .width = 64, .height = 32, .layers = layers, .name = name});
  }
  BufferId buffer(const char* name) { return graph.create(vk::BufferDesc{.size = 256, .name = name}); }
  void pass(const char* name, std::vector<Access> accesses) { graph.pass(Stage::Post, name, std::move(accesses), {}); }
  std::vector<std::string> plan() const { return planText(graph, graph.compile()); }
  std::string complaint() const {
    try {
      graph.compile();
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ExitCode::Internal);
      return error.what();
    }
    return "";
  }
  Graph graph;
};

TEST_F(Plans, OfAnEmptyGraphIsEmpty) {
  EXPECT_THAT(plan(), ElementsAre("end"));
}

TEST_F(Plans, DeferredChain) {
  const ImageId depth = image("depth"), albedo = image("albedo"), color = image("color");
  const BufferId out = buffer("out");
  pass("geometry", {{depth, Use::DepthAttachment}, {albedo, Use::ColorAttachment}});
  pass("light", {{depth, Use::SampledCompute}, {albedo, Use::SampledCompute}, {color, Use::StorageWrite}});
  pass("read back", {{color, Use::CopySource}, {out, Use::CopyTarget}});
  graph.exports(out, Use::HostRead);
  EXPECT_THAT(plan(), ElementsAre("geometry",                                                 //
                                  "  depth: -[-] -> early|late[Dr|Dw] undefined>attachment",  //
                                  "  albedo: -[-] -> color[Cr|Cw] undefined>attachment",      //
                                  "light",                                                    //
                                  "  depth: early|late[Dw] -> comp[T] attachment>readonly",   //
                                  "  albedo: color[Cw] -> comp[T] attachment>readonly",       //
                                  "  color: -[-] -> comp[Sw] undefined>general",              //
                                  "read back",                                                //
                                  "  color: comp[Sw] -> copy[Xr] general>source",             //
                                  "end",                                                      //
                                  "  out: copy[Xw] -> host[H]"));
}

TEST_F(Plans, DiamondReadsOneWriteOnEachSide) {
  const BufferId top = buffer("top"), left = buffer("left"), right = buffer("right"), bottom = buffer("bottom");
  pass("top", {{top, Use::StorageWrite}});
  pass("left", {{top, Use::StorageRead}, {left, Use::StorageWrite}});
  pass("right", {{top, Use::StorageRead}, {right, Use::StorageWrite}});
  pass("bottom", {{left, Use::StorageRead}, {right, Use::StorageRead}, {bottom, Use::StorageWrite}});
  graph.exports(bottom, Use::StorageRead);
  EXPECT_THAT(plan(), ElementsAre("top",                            //
                                  "left",                           //
                                  "  top: comp[Sw] -> comp[Sr]",    //
                                  "right",                          // already visible
                                  "bottom",                         //
                                  "  left: comp[Sw] -> comp[Sr]",   //
                                  "  right: comp[Sw] -> comp[Sr]",  //
                                  "end",                            //
                                  "  bottom: comp[Sw] -> comp[Sr]"));
}

TEST_F(Plans, LeaveOutWhatLeadsToNoExport) {
  const BufferId a = buffer("a"), b = buffer("b"), c = buffer("c"), unused = buffer("unused");
  pass("a", {{a, Use::StorageWrite}});
  pass("debug", {{a, Use::StorageRead}, {b, Use::StorageWrite}});
  pass("debug more", {{b, Use::StorageRead}, {unused, Use::StorageWrite}});
  pass("c", {{a, Use::StorageRead}, {c, Use::StorageWrite}});
  pass("only reads", {{c, Use::StorageRead}});
  graph.exports(c, Use::CopySource);
  EXPECT_THAT(plan(), ElementsAre("a", "c", "  a: comp[Sw] -> comp[Sr]", "end", "  c: comp[Sw] -> copy[Xr]"));
}

TEST_F(Plans, LeaveOutResultsThatAreOverwrittenUnread) {
  const ImageId color = image("color");
  pass("lost", {{color, Use::ColorAttachment}});
  pass("lost too", {{color, Use::ColorAttachmentLoad}});
  pass("kept", {{color, Use::ColorAttachment}});
  pass("drawn over", {{color, Use::ColorAttachmentLoad}});
  graph.exports(color, Use::SampledFragment);
  EXPECT_THAT(plan(), ElementsAre("kept",                                                //
                                  "  color: -[-] -> color[Cr|Cw] undefined>attachment",  //
                                  "drawn over",                                          //
                                  "  color: color[Cw] -> color[Cr|Cw] attachment",       //
                                  "end",                                                 //
                                  "  color: color[Cw] -> frag[T] attachment>readonly"));
}

TEST_F(Plans, KeepWhatIsReadBeforeItIsOverwritten) {
  const BufferId a = buffer("a"), b = buffer("b");
  pass("first", {{a, Use::StorageWrite}});
  pass("read", {{a, Use::StorageRead}, {b, Use::StorageWrite}});
  pass("second", {{a, Use::StorageWrite}});
  graph.exports(a, Use::HostRead);
  graph.exports(b, Use::HostRead);
  EXPECT_THAT(plan(), ElementsAre("first",                      //
                                  "read",                       //
                                  "  a: comp[Sw] -> comp[Sr]",  //
                                  "second",                     //
                                  "  a: comp[-] -> comp[Sw]",   // write after read: no flush needed
                                  "end",                        //
                                  "  a: comp[Sw] -> host[H]",   //
                                  "  b: comp[Sw] -> host[H]"));
}

// The sequence of exact transparency: counters are cleared, incremented by fragments, and read by compute shaders.
TEST_F(Plans, OrderWhatFragmentsStore) {
  const BufferId counts = buffer("counts"), list = buffer("list"), out = buffer("out");
  pass("clear", {{counts, Use::CopyTarget}});
  pass("store", {{list, Use::FragmentWrite}, {counts, Use::FragmentReadWrite}});
  pass("more", {{counts, Use::FragmentReadWrite}});
  pass("sort", {{list, Use::StorageRead}, {counts, Use::StorageRead}, {out, Use::StorageWrite}});
  graph.exports(out, Use::HostRead);
  EXPECT_THAT(plan(), ElementsAre("clear",                              //
                                  "store",                              //
                                  "  counts: copy[Xw] -> frag[Sr|Sw]",  //
                                  "more",                               //
                                  "  counts: frag[Sw] -> frag[Sr|Sw]",  //
                                  "sort",                               //
                                  "  list: frag[Sw] -> comp[Sr]",       //
                                  "  counts: frag[Sw] -> comp[Sr]",     //
                                  "end",                                //
                                  "  out: comp[Sw] -> host[H]"));
  const BufferId unwritten = buffer("unwritten");
  pass("count", {{unwritten, Use::FragmentReadWrite}, {out, Use::CopyTarget}});
  EXPECT_THAT(complaint(), HasSubstr("pass 'count' reads 'unwritten', which nothing wrote"));
}

// A copy may write only a part of its target, so earlier contents may remain.
TEST_F(Plans, KeepWhatACopyMayLeave) {
  const BufferId a = buffer("a");
  pass("clear", {{a, Use::CopyTarget}});
  pass("part", {{a, Use::CopyTarget}});
  graph.exports(a, Use::HostRead);
  EXPECT_THAT(plan(), ElementsAre("clear", "part", "  a: copy[Xw] -> copy[Xw]", "end", "  a: copy[Xw] -> host[H]"));
}

TEST_F(Plans, MakeAWriteVisibleToEachStageOnce) {
  const BufferId list = buffer("list"), out = buffer("out");
  pass("write", {{list, Use::StorageWrite}});
  pass("draw", {{list, Use::IndirectRead}, {list, Use::VertexRead}, {out, Use::StorageReadWrite}});
  pass("compute", {{list, Use::StorageRead}, {out, Use::StorageReadWrite}});
  pass("draw again", {{list, Use::VertexRead}, {out, Use::StorageReadWrite}});
  pass("compute again", {{list, Use::StorageRead}, {out, Use::StorageReadWrite}});
  pass("rewrite", {{list, Use::StorageWrite}});
  graph.exports(out, Use::HostRead);
  graph.exports(list, Use::HostRead);
  // `out` is initially unwritten.
  EXPECT_THAT(complaint(), HasSubstr("pass 'draw' reads 'out', which nothing wrote"));

  graph = Graph();
  const BufferId list2 = buffer("list"), out2 = buffer("out");
  pass("write", {{list2, Use::StorageWrite}, {out2, Use::StorageWrite}});
  pass("draw", {{list2, Use::IndirectRead}, {list2, Use::VertexRead}, {out2, Use::CopyTarget}});
  pass("compute", {{list2, Use::StorageRead}, {out2, Use::CopyTarget}});
  pass("draw again", {{list2, Use::VertexRead}, {out2, Use::CopyTarget}});
  pass("compute again", {{list2, Use::StorageRead}, {out2, Use::CopyTarget}});
  pass("rewrite", {{list2, Use::StorageWrite}});
  graph.exports(out2, Use::HostRead);
  graph.exports(list2, Use::HostRead);
  EXPECT_THAT(plan(), ElementsAre("write",                                       //
                                  "draw",                                        //
                                  "  list: comp[Sw] -> draw|vert|frag[I|Sr]",    //
                                  "  out: comp[Sw] -> copy[Xw]",                 //
                                  "compute",                                     //
                                  "  list: comp[Sw] -> comp[Sr]",                //
                                  "  out: copy[Xw] -> copy[Xw]",                 //
                                  "draw again",                                  //
                                  "  out: copy[Xw] -> copy[Xw]",                 //
                                  "compute again",                               //
                                  "  out: copy[Xw] -> copy[Xw]",                 //
                                  "rewrite",                                     //
                                  "  list: draw|vert|frag|comp[-] -> comp[Sw]",  //
                                  "end",                                         //
                                  "  list: comp[Sw] -> host[H]",                 //
                                  "  out: copy[Xw] -> host[H]"));
}

// The second reader's barrier starts at the stage of the first reader, which waited for the transition.
TEST_F(Plans, OrderLaterReadersAfterTheLayoutTransition) {
  const ImageId color = image("color");
  const BufferId out = buffer("out");
  pass("draw", {{color, Use::ColorAttachment}});
  pass("compute", {{color, Use::SampledCompute}, {out, Use::CopyTarget}});
  pass("fragment", {{color, Use::SampledFragment}, {out, Use::CopyTarget}});
  pass("copy", {{color, Use::CopySource}, {out, Use::CopyTarget}});
  pass("fragment again", {{color, Use::SampledFragment}, {out, Use::CopyTarget}});
  graph.exports(out, Use::HostRead);
  EXPECT_THAT(plan(), ElementsAre("draw",                                                //
                                  "  color: -[-] -> color[Cr|Cw] undefined>attachment",  //
                                  "compute",                                             //
                                  "  color: color[Cw] -> comp[T] attachment>readonly",   //
                                  "fragment",                                            //
                                  "  color: comp[-] -> frag[T] readonly",                //
                                  "  out: copy[Xw] -> copy[Xw]",                         //
                                  "copy",                                                //
                                  "  color: frag|comp[-] -> copy[Xr] readonly>source",   //
                                  "  out: copy[Xw] -> copy[Xw]",                         //
                                  "fragment again",                                      //
                                  "  color: copy[-] -> frag[T] source>readonly",         //
                                  "  out: copy[Xw] -> copy[Xw]",                         //
                                  "end",                                                 //
                                  "  out: copy[Xw] -> host[H]"));
}

TEST_F(Plans, TestAndSampleDepthInOnePass) {
  const ImageId depth = image("depth"), color = image("color");
  pass("geometry", {{depth, Use::DepthAttachment}});
  pass("volumes", {{depth, Use::DepthTest}, {depth, Use::SampledFragment}, {color, Use::ColorAttachment}});
  pass("fog", {{depth, Use::SampledFragment}, {color, Use::ColorAttachmentLoad}});
  pass("transparent", {{depth, Use::DepthAttachmentLoad}, {color, Use::ColorAttachmentLoad}});
  graph.exports(color, Use::ColorAttachmentLoad);
  EXPECT_THAT(plan(), ElementsAre("geometry",                                                              //
                                  "  depth: -[-] -> early|late[Dr|Dw] undefined>attachment",               //
                                  "volumes",                                                               //
                                  "  depth: early|late[Dw] -> frag|early|late[Dr|T] attachment>readonly",  //
                                  "  color: -[-] -> color[Cr|Cw] undefined>attachment",                    //
                                  "fog",                                                                   //
                                  "  color: color[Cw] -> color[Cr|Cw] attachment",                         //
                                  "transparent",                                                           //
                                  "  depth: frag|early|late[-] -> early|late[Dr|Dw] readonly>attachment",  //
                                  "  color: color[Cw] -> color[Cr|Cw] attachment",                         //
                                  "end",                                                                   //
                                  "  color: color[Cw] -> color[Cr|Cw] attachment"));
}

TEST_F(Plans, DiscardWhatIsOverwrittenInAnotherLayout) {
  const ImageId color = image("color");
  const BufferId out = buffer("out");
  pass("draw", {{color, Use::ColorAttachment}});
  pass("copy", {{color, Use::CopySource}, {out, Use::CopyTarget}});
  pass("draw again", {{color, Use::ColorAttachment}});
  graph.exports(out, Use::HostRead);
  graph.exports(color, Use::ColorAttachmentLoad);
  const std::vector<std::string> lines = plan();
  EXPECT_THAT(lines, testing::Contains("  color: copy[-] -> color[Cr|Cw] undefined>attachment"));
}

TEST_F(Plans, TreatAllLayersAsOne) {
  const ImageId views = image("views", 6);
  pass("first view", {{views, Use::ColorAttachment}});
  pass("other views", {{views, Use::ColorAttachmentLoad}});
  graph.exports(views, Use::SampledCompute);
  EXPECT_THAT(plan(), ElementsAre("first view",                                          //
                                  "  views: -[-] -> color[Cr|Cw] undefined>attachment",  //
                                  "other views",                                         //
                                  "  views: color[Cw] -> color[Cr|Cw] attachment",       //
                                  "end",                                                 //
                                  "  views: color[Cw] -> comp[T] attachment>readonly"));
}

TEST_F(Plans, StartFromHowImportedResourcesWereLeft) {
  const vk::Image texture, target;
  const vk::Buffer scene, counters;
  const ImageId t = graph.import(texture, Use::SampledFragment), c = graph.import(target, Use::CopySource);
  const BufferId s = graph.import(scene, std::nullopt), n = graph.import(counters, Use::StorageReadWrite);
  pass("draw", {{t, Use::SampledFragment}, {s, Use::VertexRead}, {n, Use::VertexRead}, {c, Use::ColorAttachment}});
  pass("compute", {{t, Use::SampledCompute}, {s, Use::StorageRead}, {c, Use::StorageReadWrite}});
  graph.exports(c, Use::CopySource);
  EXPECT_THAT(plan(), ElementsAre("draw",                                              //
                                  "  : copy[-] -> color[Cr|Cw] undefined>attachment",  //
                                  "  : comp[Sw] -> vert|frag[Sr]",                     //
                                  "compute",                                           //
                                  "  : frag[-] -> comp[T] readonly",                   //
                                  "  : color[Cw] -> comp[Sr|Sw] attachment>general",   //
                                  "end",                                               //
                                  "  : comp[Sw] -> copy[Xr] general>source"));
}

TEST_F(Plans, BringBorrowedResourcesBack) {
  const vk::Image texture, kept;
  const ImageId t = graph.import(texture, Use::SampledFragment), k = graph.import(kept, Use::SampledFragment);
  const BufferId out = buffer("out");
  pass("copy", {{t, Use::CopySource}, {k, Use::SampledFragment}, {out, Use::CopyTarget}});
  graph.exports(out, Use::HostRead);
  EXPECT_THAT(plan(), ElementsAre("copy",                                     //
                                  "  : frag[-] -> copy[Xr] readonly>source",  //
                                  "end",                                      //
                                  "  : copy[-] -> frag[T] source>readonly",   //
                                  "  out: copy[Xw] -> host[H]"));
}

TEST_F(Plans, NeedAnExportToWriteWhatIsImported) {
  const vk::Buffer outside;
  const BufferId b = graph.import(outside, Use::StorageRead);
  pass("write", {{b, Use::StorageWrite}});
  EXPECT_THAT(plan(), ElementsAre("end"));
  graph.exports(b, Use::StorageRead);
  EXPECT_THAT(plan(), ElementsAre("write", "  : comp[-] -> comp[Sw]", "end", "  : comp[Sw] -> comp[Sr]"));
}

TEST_F(Plans, PassOnAnImportThatNothingTouches) {
  const vk::Image outside;
  const ImageId i = graph.import(outside, Use::CopySource);
  graph.exports(i, Use::SampledFragment);
  EXPECT_THAT(plan(), ElementsAre("end", "  : copy[-] -> frag[T] source>readonly"));
}

TEST_F(Plans, BeginWithThePrologue) {
  const BufferId a = buffer("a");
  graph.prologue(Stage::Upload, "upload", {});
  pass("draw", {{a, Use::FragmentWrite}});
  graph.prologue(Stage::Deformation, "deform", {});
  pass("unseen", {{buffer("unseen"), Use::StorageWrite}});
  graph.exports(a, Use::HostRead);
  EXPECT_THAT(plan(), ElementsAre("upload",                                  //
                                  "deform",                                  //
                                  "  memory: comp|copy[Sw|Xw] -> all[R|W]",  //
                                  "draw",                                    //
                                  "  memory: comp|copy[Sw|Xw] -> all[R|W]",  //
                                  "end",                                     //
                                  "  a: frag[Sw] -> host[H]"));
}

TEST_F(Plans, MayBeAPrologueAlone) {
  graph.prologue(Stage::Upload, "upload", {});
  EXPECT_THAT(plan(), ElementsAre("upload", "end", "  memory: comp|copy[Sw|Xw] -> all[R|W]"));
}

TEST_F(Plans, RefuseToReadWhatNothingWrote) {
  const ImageId color = image("color"), out = image("out");
  pass("light", {{color, Use::SampledFragment}, {out, Use::ColorAttachment}});
  EXPECT_EQ(complaint(), "");  // culled
  graph.exports(out, Use::CopySource);
  EXPECT_THAT(complaint(), HasSubstr("pass 'light' reads 'color', which nothing wrote"));
}

TEST_F(Plans, RefuseToExportWhatNothingWrote) {
  graph.exports(image("color"), Use::CopySource);
  EXPECT_THAT(complaint(), HasSubstr("the export reads 'color'"));
}

TEST_F(Plans, RefuseUsesThatDoNotFit) {
  const ImageId i = image("color");
  const BufferId b = buffer("list");
  EXPECT_THAT(errorOf(
                  [&] {
                    pass("p", {{b, Use::ColorAttachment}});
                  },
                  ExitCode::Internal),
              HasSubstr("buffer 'list' cannot be used as ColorAttachment"));
  EXPECT_THAT(errorOf(
                  [&] {
                    pass("p", {{i, Use::IndirectRead}});
                  },
                  ExitCode::Internal),
              HasSubstr("image 'color' cannot be used as IndirectRead"));
  EXPECT_THAT(errorOf([&] { graph.exports(i, Use::HostRead); }, ExitCode::Internal),
              HasSubstr("cannot be used as HostRead"));
  EXPECT_THAT(errorOf(
                  [&] {
                    pass("p", {{b, Use::HostRead}});
                  },
                  ExitCode::Internal),
              HasSubstr("HostRead is for exports"));
  EXPECT_THAT(errorOf(
                  [&] {
                    pass("p", {{i, Use::ColorAttachment}, {i, Use::SampledFragment}});
                  },
                  ExitCode::Internal),
              HasSubstr("'color' as ColorAttachment and as SampledFragment, which need different layouts"));
  EXPECT_THAT(errorOf([&] { graph.import(vk::Image(), Use::VertexRead); }, ExitCode::Internal),
              HasSubstr("cannot be used as VertexRead"));
}

TEST_F(Plans, GiveResourcesTheUsageTheyNeed) {
  const ImageId i = image("color");
  const BufferId b = buffer("list");
  EXPECT_EQ(graph.desc(i).usage, 0u);
  pass("draw", {{i, Use::ColorAttachment}, {b, Use::IndirectRead}});
  pass("compute", {{i, Use::SampledCompute}});
  graph.exports(i, Use::CopySource);
  EXPECT_EQ(graph.desc(i).usage, VkImageUsageFlags(VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT | VK_IMAGE_USAGE_SAMPLED_BIT |
                                                   VK_IMAGE_USAGE_TRANSFER_SRC_BIT));
  EXPECT_TRUE(graph.desc(b).usage & VK_BUFFER_USAGE_INDIRECT_BUFFER_BIT);
}

}  // namespace
}  // namespace latelight::graph
