// SPDX-License-Identifier: Apache-2.0
#include "collinea/serve/serve.h"

#include <unistd.h>

#include <algorithm>
#include <array>

#include "collinea/serve/internal/open_link.h"
#include "collinea/serve/server.h"
#include "collinea/serve/step_job.h"

namespace collinea {
namespace {

bool is_loopback(const std::string& address) { return address == "::1" || address.starts_with("127."); }

// As it stands in a URL.
std::string host_of(const std::string& address) {
  return address.find(':') == std::string::npos ? address : "[" + address + "]";
}

std::string name_of_machine() {
  std::array<char, 256> name{};
  return ::gethostname(name.data(), name.size() - 1) == 0 ? name.data() : "";
}

ServerNames names_of(const std::string& address, int port) {
  ServerNames names{.port = port};
  names.any_address = address == "0.0.0.0" || address == "::";
  if (names.any_address) {
    std::string machine = name_of_machine();
    std::transform(machine.begin(), machine.end(), machine.begin(),
                   [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
    if (!machine.empty()) names.hosts.push_back(std::move(machine));
  } else {
    names.hosts.push_back(host_of(address));
  }
  return names;
}

Result<> check_folders(std::vector<std::filesystem::path>& roots) {
  if (roots.empty()) roots.emplace_back(".");
  for (std::filesystem::path& root : roots) {
    std::error_code error;
    const auto canonical = std::filesystem::canonical(root, error);
    if (error || !std::filesystem::is_directory(canonical, error))
      return fail(Errc::kNotFound, root.string() + " is no folder");
    root = canonical;
  }
  return {};
}

}  // namespace

Result<> serve(std::vector<std::filesystem::path> roots, const ServeOptions& options, const Run& run) {
  COLLINEA_TRY(validate(options));
  COLLINEA_TRY(check_folders(roots));
  const std::string address = options.listen.value_or("127.0.0.1");
  COLLINEA_TRY(Server server, Server::listen(address, options.port));
  const ServerNames names = names_of(address, server.port());
  Access access(names);
  const std::string host =
      "http://" + (names.any_address ? "127.0.0.1" : host_of(address)) + ":" + std::to_string(server.port());
  if (!is_loopback(address))
    run.say(
        "warning: other machines can reach this server. What it sends and its link are not encrypted, and who has "
        "the link can run steps and read what they read. A tunnel (ssh -L) from the other machine is safer.");
  run.say(std::to_string(find_projects(roots).size()) + " projects; open " + host + access.link());
  JobBoard board(run_step_job, run);
  Site site{std::move(roots), access, board,
            [&] { run.say("a browser came in; the link for another one: " + host + access.link()); }};
  if (options.open) COLLINEA_TRY(open_link(host + access.link()));
  server.run(site, run.stop);
  return {};
}

}  // namespace collinea
