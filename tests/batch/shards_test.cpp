// Shards of a job: the frames of each, and that together they produce the same data set.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <nlohmann/json.hpp>

#include "base/error.h"
#include "batch/sets.h"
#include "data/batch/parts_lock.h"
#include "data/batch/shard.h"

namespace latelight::data {
namespace {

using app::Folder;
using app::latelight;
using app::Outcome;
using testing::HasSubstr;

using Variables = std::map<std::string, std::string>;

std::string chosen(const std::string& text, const Variables& variables = {}) try {
  const SelectedShard part = chooseShard(text, [&](const char* name) {
    const auto found = variables.find(name);
    return found == variables.end() ? std::nullopt : std::optional(found->second);
  });
  return part.by.empty() ? part.shard.name() : part.shard.name() + " by " + part.by;
} catch (const Error& error) {
  return error.what();
}

TEST(Shard, EveryFrameIsInOne) {
  for (const uint64_t frames : {0ul, 1ul, 7ul, 100ul, 12'345'678'901ul})
    for (const uint32_t count : {1u, 3u, 8u, 1000u}) {
      uint64_t next = 0;
      for (uint32_t i = 0; i < count; ++i) {
        const auto [first, end] = Shard{i, count}.range(frames);
        EXPECT_EQ(first, next);
        EXPECT_LE(end - first, frames / count + 1);
        next = end;
      }
      EXPECT_EQ(next, frames);
    }
}

const Variables kArray{{"SLURM_ARRAY_TASK_ID", "12"},
                       {"SLURM_ARRAY_TASK_MIN", "10"},
                       {"SLURM_ARRAY_TASK_MAX", "13"},
                       {"SLURM_ARRAY_TASK_COUNT", "4"}};
const Variables kStep{
    {"SLURM_STEP_ID", "0"}, {"SLURM_PROCID", "1"}, {"SLURM_NTASKS", "2"}, {"SLURM_STEP_NUM_TASKS", "2"}};
const Variables kOpenMpi{{"OMPI_COMM_WORLD_RANK", "3"}, {"OMPI_COMM_WORLD_SIZE", "4"}};

Variables together(Variables a, const Variables& b) {
  a.insert(b.begin(), b.end());
  return a;
}

TEST(Shard, IsReadFromWhatStartedTheProcess) {
  EXPECT_EQ(chosen(""), "0-of-1");
  EXPECT_EQ(chosen("2/8"), "2-of-8");
  EXPECT_EQ(chosen("", kArray), "2-of-4 by SLURM_ARRAY_TASK_ID, _MIN and _COUNT");
  EXPECT_EQ(chosen("", kStep), "1-of-2 by SLURM_PROCID and SLURM_STEP_NUM_TASKS");
  EXPECT_EQ(chosen("", {{"SLURM_STEP_ID", "3"}, {"SLURM_PROCID", "1"}, {"SLURM_NTASKS", "2"}}),
            "1-of-2 by SLURM_PROCID and SLURM_NTASKS");
  EXPECT_EQ(chosen("", together(kArray, kStep)),
            "5-of-8 by SLURM_ARRAY_TASK_ID, _MIN and _COUNT with SLURM_PROCID and SLURM_STEP_NUM_TASKS");
  EXPECT_EQ(chosen("", kOpenMpi), "3-of-4 by OMPI_COMM_WORLD_RANK and OMPI_COMM_WORLD_SIZE");
  EXPECT_EQ(chosen("", {{"PMI_RANK", "0"}, {"PMI_SIZE", "4"}}), "0-of-4 by PMI_RANK and PMI_SIZE");
  EXPECT_EQ(chosen("/8", {{"JOB_COMPLETION_INDEX", "7"}}), "7-of-8 by JOB_COMPLETION_INDEX");
  EXPECT_EQ(chosen("0/2", {{"PMI_RANK", "3"}, {"PMI_SIZE", "4"}}), "0-of-2") << "what is given counts";
}

// sbatch sets rank 0 and the number of tasks for the script itself, which is a single process.
TEST(Shard, ABatchScriptIsNoPart) {
  const Variables script{{"SLURM_JOB_ID", "7"}, {"SLURM_PROCID", "0"}, {"SLURM_NTASKS", "4"}, {"SLURM_NPROCS", "4"}};
  EXPECT_EQ(chosen("", script), "0-of-1");
  EXPECT_EQ(chosen("", together(script, {{"SLURM_STEP_ID", "4294967291"}})), "0-of-1") << "the batch step's number";
  EXPECT_EQ(chosen("", together(script, {{"SLURM_STEP_ID", "4294967290"}})), "0-of-1") << "an interactive step's";
  EXPECT_EQ(chosen("", together(kArray, script)), "2-of-4 by SLURM_ARRAY_TASK_ID, _MIN and _COUNT");
}

// mpirun starts its daemons as a job step, one per node, and these start the processes.
TEST(Shard, MpirunWithinAStepCountsItsOwnProcesses) {
  EXPECT_EQ(chosen("", together(kStep, kOpenMpi)), "3-of-4 by OMPI_COMM_WORLD_RANK and OMPI_COMM_WORLD_SIZE");
  EXPECT_THAT(chosen("", together(kArray, kOpenMpi)), testing::StartsWith("11-of-16 by SLURM_ARRAY_TASK_ID"));
}

TEST(Shard, RefusesWhatIsNone) {
  for (const char* wrong : {"8/8", "1", "a/2", "1/0", "-1/2", "1/2/3", "/8", "1/"})
    EXPECT_THAT(chosen(wrong), HasSubstr("--shard takes i/n")) << wrong;
  EXPECT_THAT(chosen("", {{"SLURM_ARRAY_TASK_ID", "4"},
                          {"SLURM_ARRAY_TASK_MIN", "0"},
                          {"SLURM_ARRAY_TASK_MAX", "8"},
                          {"SLURM_ARRAY_TASK_COUNT", "3"}}),
              HasSubstr("without gaps"));
  EXPECT_THAT(chosen("", {{"PMI_RANK", "x"}, {"PMI_SIZE", "4"}}), HasSubstr("PMI_RANK must be a whole number"));
}

// The scene's file is written once, because shards that run concurrently read it.
struct PartsFolder : Folder {
  PartsFolder() { write("empty.gltf", std::string_view(kCameraAlone)); }
};

// Two scenes, one of which contains only a camera.
app::Command parts(const PartsFolder& folder, const std::string& set, std::vector<std::string> more,
                   const char* repeat = "11") {
  std::vector<std::string> all{"--scenes",  "builtin:boxes",
                               "--scenes",  "empty.gltf",
                               "--repeat",  repeat,
                               "-o",        set,
                               "--formats", R"({"format": "files", "outputs": ["color", "normal"]})"};
  all.insert(all.end(), more.begin(), more.end());
  return batch(folder, all);
}

TEST(Shards, HoweverItIsSplitTheSetIsTheSame) {
  PartsFolder folder;
  const Outcome whole = latelight(parts(folder, "whole", {"--threads", "1", "--validate"}));
  ASSERT_EQ(whole.code, 0) << whole.text();
  EXPECT_EQ(latelight(parts(folder, "workers", {"--threads", "3", "--workers", "2", "--validate"})).code, 0);
  expectSame(filesOf(folder, "workers"), filesOf(folder, "whole"));
  for (const size_t count : {3, 8}) {
    const std::string set = "of" + std::to_string(count);
    app::inPairs(count, [&](size_t i) {  // last shards first
      const std::string shard = std::to_string(count - 1 - i) + "/" + std::to_string(count);
      const Outcome outcome = latelight(parts(folder, set, {"--shard", shard, "--threads", std::to_string(1 + i % 3)}));
      EXPECT_EQ(outcome.code, 0) << outcome.text();
    });
    expectSame(filesOf(folder, set), filesOf(folder, "whole"));
  }
}

TEST(Shards, APartByTheEnvironmentIsSaid) {
  PartsFolder folder;
  const auto run = [&](const std::string& set, const std::map<std::string, std::string>& variables) {
    app::Command command = parts(folder, set, {"--dry-run"});
    command.environment = variables;
    return latelight(command);
  };
  const Outcome step = run("a", kStep);
  EXPECT_THAT(step.err, HasSubstr("part 1/2 of the frames, chosen by SLURM_PROCID and SLURM_STEP_NUM_TASKS"));
  EXPECT_THAT(step.out, HasSubstr("11 frames would be rendered"));
  const Outcome script = run("b", {{"SLURM_PROCID", "0"}, {"SLURM_NTASKS", "4"}});
  EXPECT_EQ(script.err, "");
  EXPECT_THAT(script.out, HasSubstr("22 frames would be rendered"));
}

TEST(Shards, SomeAreMergedOnceOthersAreThere) {
  PartsFolder folder;
  const auto run = [&](std::vector<std::string> arguments) {
    return latelight({.arguments = std::move(arguments), .folder = folder.path()});
  };
  ASSERT_EQ(latelight(parts(folder, "set", {"--shard", "0/2"})).code, 0);
  const Outcome status = run({"batch", "status", "set"});
  EXPECT_EQ(status.code, 6);
  EXPECT_THAT(status.out, HasSubstr("11 of 22 frames are finished"));
  const Outcome early = run({"batch", "merge", "set"});
  EXPECT_EQ(early.code, 6);
  EXPECT_THAT(early.err, HasSubstr("11 of the 22 frames are missing"));
  EXPECT_EQ(latelight(parts(folder, "set", {"--shard", "0/2"})).code, 2) << "that one is there";
  EXPECT_EQ(latelight(parts(folder, "set", {"--shard", "0/3"})).code, 2) << "split otherwise";
  EXPECT_EQ(latelight(parts(folder, "set", {"--shard", "1/2", "--exposure", "1"})).code, 2) << "another job";
  // After a change of the number of shards, existing frames are kept.
  ASSERT_EQ(latelight(parts(folder, "set", {"--resume"})).code, 0);
  EXPECT_THAT(folder.read("set/.latelight/log"), HasSubstr("shard 0-of-1 begins: 11 of 22 frames"));
  EXPECT_EQ(run({"batch", "status", "set"}).code, 0);
  EXPECT_EQ(run({"batch", "merge", "set"}).code, 0) << "it may be merged again";
}

TEST(Shards, AShardIsMadeByOneProcess) {
  PartsFolder folder;
  std::vector<Outcome> outcomes(2);
  app::inPairs(2, [&](size_t i) { outcomes[i] = latelight(parts(folder, "set", {"--resume"}, "500")); });
  const bool second = outcomes[1].code == 2;
  const Outcome &refused = outcomes[second], &done = outcomes[!second];
  EXPECT_EQ(done.code, 0) << done.text();
  EXPECT_EQ(refused.code, 2) << refused.text();
  EXPECT_THAT(refused.err, HasSubstr("another process is working on 'set/.latelight/shard-0-of-1.jsonl'"));
}

// The files that formats name are relative to the working directory of the job, and merging does not read them.
TEST(Shards, AreMergedFromAnyWorkingDirectory) {
  Folder folder, elsewhere;
  folder.write("rules.json", std::string_view(R"({"plastic": "cup", "": "thing"})"));
  const auto run = [&](const std::string& shard) {
    return latelight(batch(folder, {"--scenes", "builtin:boxes", "--repeat", "2", "-o", "set", "--shard", shard,
                                    "--formats", R"({"format": "coco", "categories": "rules.json"})"}));
  };
  ASSERT_EQ(run("0/2").code, 0);
  ASSERT_EQ(run("1/2").code, 0);
  const auto before = filesOf(folder, "set");
  std::filesystem::remove(folder.path() / "rules.json");
  const Outcome merged = latelight({.arguments = {"batch", "merge", folder.at("set")}, .folder = elsewhere.path()});
  EXPECT_EQ(merged.code, 0) << merged.text();
  expectSame(filesOf(folder, "set"), before);
  EXPECT_THAT(before.at("annotations/instances.json"), HasSubstr("cup"));
}

// A job is stored before its plan, so a process that is killed in between leaves frames of the previous job.
TEST(Shards, AreNotMergedByAnotherJob) {
  Folder folder;
  const Outcome outcome = latelight(batch(folder, {"--scenes", "builtin:boxes", "-o", "set", "--formats", "coco"}));
  ASSERT_EQ(outcome.code, 0) << outcome.text();
  const auto mergedBy = [&](std::string_view job) {
    folder.write("set/.latelight/job.json", job);
    return latelight({.arguments = {"batch", "merge", "set"}, .folder = folder.path()});
  };
  const Outcome formats = mergedBy(R"({"formats": ["coco", "yolo"]})");
  EXPECT_EQ(formats.code, 3) << formats.text();
  EXPECT_THAT(formats.err, HasSubstr("'set' has frames of another job"));
  const std::string_view sameNumber[] = {R"({"formats": ["bop"]})",
                                         R"({"formats": [{"format": "coco", "categories": {"plastic": "cup"}}]})"};
  for (const std::string_view job : sameNumber) {
    const Outcome merged = mergedBy(job);
    EXPECT_EQ(merged.code, 3) << merged.text();
    EXPECT_THAT(merged.err, HasSubstr("'set' has frames of another job"));
  }
  // Plans of version 0.2.0 do not name their job.
  auto plan = nlohmann::json::parse(folder.read("set/.latelight/plan.json"));
  EXPECT_EQ(plan.erase("document"), 1u);
  folder.write("set/.latelight/plan.json", std::string_view(plan.dump()));
  const Outcome categories = mergedBy(R"({"formats": [{"format": "coco", "categories": {"plastic": "unheard of"}}]})");
  EXPECT_EQ(categories.code, 3) << categories.text();
  EXPECT_THAT(categories.err, HasSubstr("which the job does not define: run the job with --resume"));
}

// Parts of different numbers overlap.
TEST(Shards, ProcessesUseTheSameNumber) {
  PartsFolder folder;
  std::filesystem::create_directories(folder.path() / "set/.latelight");
  const auto run = [&] { return latelight(parts(folder, "set", {"--shard", "0/2", "--resume"}, "1")); };
  {
    const PartsLock others(folder.path() / "set/.latelight/parts.lock", 3);
    const Outcome refused = run();
    EXPECT_EQ(refused.code, 2) << refused.text();
    EXPECT_THAT(refused.err, HasSubstr("another process is rendering 'set' in 3 parts, and this one would in 2"));
  }
  const PartsLock another(folder.path() / "set/.latelight/parts.lock", 2);
  const Outcome done = run();
  EXPECT_EQ(done.code, 0) << done.text();
}

}  // namespace
}  // namespace latelight::data
