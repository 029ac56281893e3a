// SPDX-License-Identifier: Apache-2.0
#include "collinea/serve/internal/open_link.h"

#include <fcntl.h>
#include <spawn.h>
#include <unistd.h>

#include <array>
#include <system_error>

#include "collinea/base/file.h"

extern char** environ;

namespace collinea {
namespace {

constexpr const char* kPage = "open.html";

// Nothing of the browser is to be read in the terminal; it may outlive this program.
bool start(const char* program, const std::string& argument) {
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  for (const int stream : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO})
    posix_spawn_file_actions_addopen(&actions, stream, "/dev/null", O_RDWR, 0);
  posix_spawnattr_t attributes;
  posix_spawnattr_init(&attributes);
  posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETSID);
  std::string name(program), value(argument);
  std::array<char*, 3> words{name.data(), value.data(), nullptr};
  pid_t process = 0;
  const int failed = ::posix_spawnp(&process, program, &actions, &attributes, words.data(), environ);
  posix_spawnattr_destroy(&attributes);
  posix_spawn_file_actions_destroy(&actions);
  return failed == 0;
}

}  // namespace

Result<OpenedLink> OpenedLink::open(const std::string& link) {
  std::error_code error;
  std::string folder = (std::filesystem::temp_directory_path(error) / "collinea-XXXXXX").string();
  if (error || ::mkdtemp(folder.data()) == nullptr)  // of mode 0700
    return fail(Errc::kBadInput, "no temporary folder can be made to open the browser with: open the link by hand",
                {"open"_option});
  OpenedLink opened{std::filesystem::path(folder)};
  const std::filesystem::path page = opened.folder_ / kPage;
  COLLINEA_TRY(
      write_file(page, "<!doctype html><meta charset=\"utf-8\"><meta http-equiv=\"refresh\" content=\"0; url=" + link +
                           "\"><title>collinea</title>"));
  if (!start("xdg-open", page.string()))
    return fail(Errc::kNotFound, "xdg-open is missing: open the link by hand", {"open"_option});
  return opened;
}

OpenedLink::~OpenedLink() {
  if (folder_.empty()) return;
  std::error_code ignored;
  std::filesystem::remove(folder_ / kPage, ignored);
  std::filesystem::remove(folder_, ignored);
}

}  // namespace collinea
