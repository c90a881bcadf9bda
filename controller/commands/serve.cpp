#include <fmt/format.h>

#include <cstdio>

#include "common/json/io.hpp"
#include "controller/commands/commands.hpp"
#include "controller/commands/watched.hpp"
#include "controller/serve/server.hpp"

namespace granary::commands {

Result<Exit> serve(const std::filesystem::path& dir, const std::string& address, int port) {
  GRANARY_TRY(watch::Watcher watcher, watcher_of(dir));
  GRANARY_TRY(serve::Server server,
              serve::Server::open({address, port}, [&] { return json::dump(watch::to_json(watcher.look())); }));
  fmt::print("{}\n", server.url());
  std::fflush(stdout);
  fmt::print(stderr, "Ctrl-C ends this page, not the campaign. From another machine: ssh -L {0}:{1}:{0} THIS_HOST\n",
             server.port(), address);
  server.run();
  return Exit::ok;
}

}  // namespace granary::commands
