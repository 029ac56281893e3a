// SPDX-License-Identifier: Apache-2.0
#include "collinea/edit/journal.h"

#include <fcntl.h>
#include <fmt/chrono.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <ctime>
#include <system_error>
#include <thread>

namespace collinea {
namespace {

namespace fs = std::filesystem;

std::string reason() { return std::generic_category().message(errno); }

/// A file that is closed, and its lock let go, at the end.
class Descriptor {
 public:
  explicit Descriptor(int value) : value_(value) {}
  ~Descriptor() {
    if (value_ >= 0) ::close(value_);
  }
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  [[nodiscard]] int value() const { return value_; }

 private:
  int value_;
};

// Moments, as others hold it while they write a few lines. File systems without locks have none to wait for.
Result<> lock(int descriptor, const fs::path& file) {
  constexpr std::chrono::milliseconds kLongest(10'000), kPause(2);
  const auto end = std::chrono::steady_clock::now() + kLongest;
  while (::flock(descriptor, LOCK_EX | LOCK_NB) != 0) {
    if (errno != EWOULDBLOCK && errno != EINTR) return {};
    if (std::chrono::steady_clock::now() > end)
      return fail(Errc::kBadInput, file.string() + ": another program has held it for 10 s: try again");
    std::this_thread::sleep_for(kPause);
  }
  return {};
}

bool is_still(int descriptor, const fs::path& file) {
  struct stat opened {
  }, named{};
  return ::fstat(descriptor, &opened) == 0 && ::stat(file.c_str(), &named) == 0 && opened.st_dev == named.st_dev &&
         opened.st_ino == named.st_ino;
}

// A new name is in the folder for good only when that is on the disk.
void sync_folder(const fs::path& folder) {
  const Descriptor opened(::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
  if (opened.value() >= 0) ::fsync(opened.value());
}

// All of it, on the disk; else the file is as it was.
Result<> write_at_end(int descriptor, const std::string& bytes, std::uint64_t end, const fs::path& file) {
  ssize_t written = 0;
  do written = ::write(descriptor, bytes.data(), bytes.size());
  while (written < 0 && errno == EINTR);
  const bool is_whole = written == static_cast<ssize_t>(bytes.size());
  if (is_whole && ::fsync(descriptor) == 0) return {};
  const bool is_full = written >= 0 && !is_whole;
  const std::string why = reason();
  [[maybe_unused]] const int cut = ::ftruncate(descriptor, static_cast<off_t>(end));
  if (is_full) return fail(Errc::kBadInput, file.string() + " cannot be written: the disk is full");
  return fail(Errc::kBadInput, file.string() + " cannot be written: " + why);
}

std::string now() {
  return fmt::format("{:%Y-%m-%dT%H:%M:%SZ}",
                     fmt::gmtime(std::chrono::system_clock::to_time_t(std::chrono::system_clock::now())));
}

}  // namespace

Journal::Journal(const fs::path& project) : file_(project / "journal.jsonl") {}

void Journal::forget() { *this = Journal(file_.parent_path()); }

Result<> Journal::refresh() {
  const Descriptor opened(::open(file_.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK));
  if (opened.value() < 0) {
    if (errno != ENOENT) return fail(Errc::kBadInput, file_.string() + " cannot be read: " + reason());
    forget();
    return {};
  }
  return read_on(opened.value());
}

Result<> Journal::read_on(int descriptor) {
  constexpr std::size_t kBlock = std::size_t{1} << 20;
  struct stat about {};
  if (::fstat(descriptor, &about) != 0 || !S_ISREG(about.st_mode))
    return fail(Errc::kBadInput, file_.string() + " is no file");
  const auto size = static_cast<std::uint64_t>(about.st_size);
  if (about.st_dev != device_ || about.st_ino != inode_ || size < position_) forget();
  device_ = about.st_dev;
  inode_ = about.st_ino;
  std::string pending;
  for (std::uint64_t at = position_; at < size;) {
    const std::size_t before = pending.size();
    pending.resize(before + static_cast<std::size_t>(std::min<std::uint64_t>(kBlock, size - at)));
    const ssize_t count = ::pread(descriptor, pending.data() + before, pending.size() - before, static_cast<off_t>(at));
    if (count < 0) return fail(Errc::kBadInput, file_.string() + " cannot be read: " + reason());
    pending.resize(before + static_cast<std::size_t>(count));
    if (count == 0) break;
    at += static_cast<std::uint64_t>(count);
    std::size_t begin = 0;
    for (std::size_t end = 0; (end = pending.find('\n', begin)) != std::string::npos; begin = end + 1) {
      COLLINEA_TRY(take(std::string_view(pending).substr(begin, end - begin)));
      position_ += end + 1 - begin;
    }
    pending.erase(0, begin);
    if (pending.size() > kLongestLine)
      return fail(Errc::kBadFormat, fmt::format("{}: line {}: the line is too long", file_.string(), number() + 1));
  }
  return {};
}

Result<> Journal::take(std::string_view line) {
  const auto in_line = [&](Error error) {
    return std::move(error).within(fmt::format("{}: line {}", file_.string(), number() + 1));
  };
  COLLINEA_TRY(JournalLine read, parse_journal_line(line).map_error([&](Error error) {
    error.code = Errc::kBadFormat;
    return in_line(std::move(error));
  }));
  if (read.number != number() + 1)
    return tl::unexpected(in_line(Error{Errc::kBadFormat, fmt::format("its number is {}", read.number)}));
  return history_.add(std::move(read.edit), std::move(read.time)).map_error([&](Error error) {
    error.code = Errc::kBadFormat;
    return in_line(std::move(error));
  });
}

Result<std::uint64_t> Journal::append(const Make& make) {
  const bool is_new = ::access(file_.c_str(), F_OK) != 0;
  int descriptor = -1;
  do descriptor = ::open(file_.c_str(), O_RDWR | O_CREAT | O_APPEND | O_CLOEXEC | O_NONBLOCK, 0644);
  while (descriptor < 0 && errno == EINTR);
  const Descriptor opened(descriptor);
  if (descriptor < 0) return fail(Errc::kBadInput, file_.string() + " cannot be written: " + reason());
  COLLINEA_TRY(lock(descriptor, file_));
  if (!is_still(descriptor, file_)) return append(make);  // it was replaced meanwhile
  COLLINEA_TRY(read_on(descriptor));
  COLLINEA_TRY(const std::vector<NewEdit> edits, make(history_));
  struct stat about {};
  if (::fstat(descriptor, &about) != 0) return fail(Errc::kBadInput, file_.string() + ": " + reason());
  if (static_cast<std::uint64_t>(about.st_size) > position_ &&
      ::ftruncate(descriptor, static_cast<off_t>(position_)) != 0)
    return fail(Errc::kBadInput, file_.string() + ": a broken last line cannot be cut off: " + reason());
  if (edits.empty()) return number();
  for (const NewEdit& one : edits) {  // what could not be read again must not be written
    const bool is_alone = edits.size() == 1 || !is_of_history(one.edit);
    COLLINEA_CHECK(is_alone);
    COLLINEA_TRY(history_.check(one.edit));
    const Words words = words_of(one.edit);
    const auto again = parse_edit(words);
    if (!again) return tl::unexpected(Error(again.error()).within(words[0] + (words.size() > 1 ? " " + words[1] : "")));
  }
  std::string bytes;
  const std::string time = now();
  for (std::size_t i = 0; i < edits.size(); ++i) {
    JournalLine line{number() + 1 + i, time, edits[i].edit, edits[i].replaced};
    std::string text = text_of(line);
    if (text.size() > kLongestLine) {
      line.replaced.clear();
      text = text_of(line);
    }
    if (text.size() > kLongestLine)
      return fail(Errc::kBadInput, "an edit is longer than a line of the journal may be, " +
                                       std::to_string(kLongestLine >> 20) + " MiB: make several of it");
    bytes += text + "\n";
  }
  COLLINEA_TRY(write_at_end(descriptor, bytes, position_, file_));
  if (is_new) sync_folder(file_.parent_path());
  COLLINEA_TRY(read_on(descriptor));
  return number();
}

}  // namespace collinea
