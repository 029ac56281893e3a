// SPDX-License-Identifier: Apache-2.0
#include "collinea/serve/serve.h"

#include <unistd.h>

#include <algorithm>
#include <array>
#include <optional>

#include "collinea/report/error_text.h"
#include "collinea/serve/internal/open_link.h"
#include "collinea/serve/server.h"
#include "collinea/serve/step_job.h"

namespace collinea {
namespace {

// As it stands in a URL.
std::string host_of(const ServerAddress& address) {
  return address.text.find(':') == std::string::npos ? address.text : "[" + address.text + "]";
}

std::string name_of_machine() {
  std::array<char, 256> name{};
  return ::gethostname(name.data(), name.size() - 1) == 0 ? name.data() : "";
}

ServerNames names_of(const ServerAddress& address, int port) {
  ServerNames names{.port = port};
  names.any_address = address.is_unspecified;
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

Result<> serve(std::vector<std::filesystem::path> roots, const ServeOptions& options, const Run& run,
               const std::function<void(std::string_view line)>& show) {
  COLLINEA_TRY(validate(options));
  COLLINEA_TRY(check_folders(roots));
  COLLINEA_TRY(Server server, Server::listen(options.listen.value_or("127.0.0.1"), options.port));
  const ServerAddress& address = server.address();
  Access access(names_of(address, server.port()));
  const std::string host =
      "http://" + (address.is_unspecified ? "127.0.0.1" : host_of(address)) + ":" + std::to_string(server.port());
  if (!address.is_loopback)
    run.say(
        "warning: other machines can reach this server. What it sends and its link are not encrypted, and who has "
        "the link can run steps and read what they read. A tunnel (ssh -L) from the other machine is safer.");
  show(std::to_string(find_projects(roots).size()) + " projects; open " + host + access.link());
  Run of_jobs = run;
  of_jobs.spelling = {};  // their options have names, as forms and requests do
  JobBoard board(run_step_job, of_jobs);
  Site site{std::move(roots), access, board,
            [&] { show("a browser came in; the link for another one: " + host + access.link()); }};
  std::optional<OpenedLink> opened;
  if (options.open) {
    auto outcome = OpenedLink::open(host + access.link());
    if (outcome)
      opened.emplace(*std::move(outcome));
    else  // the link can be opened by hand
      run.say("warning: " + text_of(outcome.error(), run.spelling));
  }
  server.run(site, run.stop);
  return {};
}

}  // namespace collinea
