// A renderer in a forked process, through the public API.
#include <gtest/gtest.h>
#include <latelight/latelight.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdio>
#include <functional>

namespace latelight {
namespace {

// Returns the exit code of a forked process that returns the result of `body`; -1 if it did not end within a minute.
int inFork(const std::function<int()>& body) {
  const pid_t child = fork();
  if (child == 0) {
    alarm(60);
    try {
      _exit(body());
    } catch (const std::exception& error) {
      std::fprintf(stderr, "%s\n", error.what());
      _exit(99);
    }
  }
  int status = 0;
  waitpid(child, &status, 0);
  return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

bool isRefused(const std::function<void()>& call) {
  try {
    call();
  } catch (const Error& error) {
    return error.code() == ExitCode::Usage && std::string(error.what()).find("forked") != std::string::npos;
  }
  return false;
}

Options small() {
  Options options;
  options.width = options.height = 16;
  options.aovs = {"depth"};
  return options;
}

TEST(Forked, RenderersOfTheParentAreRefusedAndNewOnesWork) {
  Scene scene("builtin:boxes");
  Renderer renderer(scene, "cpu");
  const Camera camera = scene.defaultCamera(1);
  const Frame expected = renderer.render(camera, small());
  Ticket ticket = renderer.submit({camera}, small());
  EXPECT_EQ(inFork([&] {
              const std::function<void()> calls[] = {
                  [&] { renderer.render(camera, small()); },
                  [&] { renderer.submit({camera}, small()); },
                  [&] {
                    renderer.pick(camera, {{0, 0}}, small());
                  },
                  [&] { static_cast<void>(renderer.deviceName()); },
                  [&] { renderer.validationMessages(); },
                  [&] { renderer.whileWaiting({}); },
                  [&] { renderer.finish(); },
                  [&] { static_cast<void>(ticket.done()); },
                  [&] { ticket.take(); },
                  [&] { ticket.takeArrays(); },
              };
              int number = 1;
              for (const auto& call : calls) {
                if (!isRefused(call)) return number;
                ++number;
              }
              Renderer own(scene, "cpu");
              if (own.render(camera, small()).rgba != expected.rgba) return 20;
              scene.removeInstance(scene.instances().front());
              if (own.render(camera, small()).rgba == expected.rgba) return 21;
              return 7;
            }),
            7);
  EXPECT_EQ(ticket.take().front().rgba, expected.rgba) << "the parent's go on";
  EXPECT_EQ(renderer.render(camera, small()).rgba, expected.rgba);
}

// Destroying objects in the forked process waits for nothing, and the parent's device stays valid.
TEST(Forked, DestructorsLeaveTheDeviceAlone) {
  Scene scene("builtin:boxes");
  auto renderer = std::make_unique<Renderer>(scene, "cpu");
  const Camera camera = scene.defaultCamera(1);
  const Frame expected = renderer->render(camera, small());
  auto ticket = std::make_unique<Ticket>(renderer->submit({camera, camera}, small()));
  auto arrays = renderer->submit({camera}, small(), Results::Arrays).takeArrays();
  EXPECT_EQ(inFork([&] {
              ticket.reset();
              arrays.clear();
              renderer.reset();
              return 7;
            }),
            7);
  EXPECT_EQ(ticket->take().back().rgba, expected.rgba);
  EXPECT_EQ(renderer->render(camera, small()).rgba, expected.rgba);
}

}  // namespace
}  // namespace latelight
