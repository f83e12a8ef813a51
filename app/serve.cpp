// `latelight serve`: runs viewing sessions in browsers.
#include "serve/server.h"

#include <fmt/core.h>

#include <algorithm>
#include <cstdio>

#include "app/commands.h"
#include "app/view_start.h"
#include "base/log.h"
#include "base/lowercase.h"
#include "vk/driver_cache.h"

namespace latelight::app {

namespace {

struct ServeArguments {
  ViewOptions render;
  serve::ServerOptions server{.port = 8765};
};

void serveScene(ServeArguments& a) {
  const view::Start start = viewStart(a.render, "serve");
  for (std::string& name : a.server.names) name = lowercase(name);
  vk::avoidFullDriverCache();
  serve::Server server(a.server, start);
  fmt::print("{} on {}; open this page, and keep its address to yourself:\n\n  {}\n\n", printable(start.scene),
             printable(server.device()), server.url());
  if (a.server.address == serve::ServerOptions{}.address)
    fmt::print("From another machine, first: ssh -L {0}:127.0.0.1:{0} THIS_MACHINE\n", server.port());
  fmt::print("Ctrl-C ends it.\n");
  if (std::fflush(stdout) != 0) return;  // nobody knows the address; main() reports the error
  server.run();
}

}  // namespace

void addServeCommand(CLI::App& app) {
  auto arguments = std::make_shared<ServeArguments>();
  ServeArguments& a = *arguments;
  CLI::App* command =
      app.add_subcommand("serve", "Show a scene interactively in a browser, without a display on this machine");
  addViewOptions(*command, a.render);
  command->add_option("--port", a.server.port, "Port; 0: any free port")
      ->capture_default_str()
      ->check(CLI::Range(0, 65535))
      ->group("Server");
  command->add_option("--address", a.server.address, "Address to listen on; 0.0.0.0: all addresses of this machine")
      ->capture_default_str()
      ->group("Server");
  command
      ->add_option("--host-name", a.server.names,
                   "Additional host name that browsers may use for this machine; may be repeated")
      ->expected(1)
      ->take_all()
      ->group("Server");
  command->add_option("--sessions", a.server.sessions, "Maximum number of open pages")
      ->capture_default_str()
      ->check(CLI::Range(1, 64))
      ->group("Server");
  command->callback([arguments] { serveScene(*arguments); });
}

}  // namespace latelight::app
