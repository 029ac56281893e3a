// SPDX-License-Identifier: Apache-2.0
#include "collinea/base/file.h"

#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <utility>

namespace collinea {
namespace {

std::string last_reason() { return std::strerror(errno); }

}  // namespace

Result<std::string> read_file(const std::filesystem::path& path, std::uint64_t limit_bytes) {
  std::error_code error;
  const auto status = std::filesystem::status(path, error);
  if (!std::filesystem::exists(status)) return fail(Errc::kNotFound, path.string() + ": no such file");
  if (std::filesystem::is_directory(status)) return fail(Errc::kBadInput, path.string() + ": a folder, not a file");
  if (std::filesystem::is_character_file(status) || std::filesystem::is_block_file(status))
    return fail(Errc::kBadInput, path.string() + ": a device, not a file");
  const std::unique_ptr<std::FILE, int (*)(std::FILE*)> file(std::fopen(path.c_str(), "rb"), std::fclose);
  if (!file) return fail(Errc::kNotFound, path.string() + ": cannot be opened: " + last_reason());
  std::string bytes;
  char buffer[1 << 16];
  while (const std::size_t got = std::fread(buffer, 1, sizeof(buffer), file.get())) {
    if (bytes.size() + got > limit_bytes) return fail(Errc::kUnsupported, path.string() + ": too large a file");
    bytes.append(buffer, got);
  }
  if (std::ferror(file.get())) return fail(Errc::kBadFormat, path.string() + ": cannot be read: " + last_reason());
  return bytes;
}

bool is_there(const std::filesystem::path& path) {
  std::error_code ignored;
  return std::filesystem::exists(path, ignored);
}

Result<> remove_file(const std::filesystem::path& path) {
  std::error_code error;
  std::filesystem::remove(path, error);
  if (error) return fail(Errc::kBadInput, path.string() + ": cannot be removed: " + error.message());
  return {};
}

Result<OutputFile> OutputFile::create(const std::filesystem::path& path) {
  std::error_code error;
  if (path.has_parent_path()) std::filesystem::create_directories(path.parent_path(), error);
  OutputFile output;
  output.path_ = path;
  output.temporary_ = path.string() + ".part" + std::to_string(::getpid());
  output.file_.reset(std::fopen(output.temporary_.c_str(), "wb"));
  if (!output.file_) return fail(Errc::kBadInput, path.string() + ": cannot be written: " + last_reason());
  std::setvbuf(output.file_.get(), nullptr, _IOFBF, 1 << 18);
  return output;
}

OutputFile::OutputFile(OutputFile&& other) noexcept
    : path_(std::move(other.path_)),
      temporary_(std::exchange(other.temporary_, {})),
      file_(std::move(other.file_)),
      size_(other.size_),
      failed_(other.failed_) {}

OutputFile::~OutputFile() {
  if (!file_) return;
  file_.reset();
  std::error_code ignored;
  std::filesystem::remove(temporary_, ignored);
}

void OutputFile::write(std::string_view bytes) {
  COLLINEA_CHECK(file_);
  failed_ |= std::fwrite(bytes.data(), 1, bytes.size(), file_.get()) != bytes.size();
  size_ += bytes.size();
}

void OutputFile::write_at(std::uint64_t offset, std::string_view bytes) {
  COLLINEA_CHECK(file_ && offset + bytes.size() <= size_);
  failed_ |= ::fseeko(file_.get(), ::off_t(offset), SEEK_SET) != 0;
  failed_ |= std::fwrite(bytes.data(), 1, bytes.size(), file_.get()) != bytes.size();
  failed_ |= ::fseeko(file_.get(), 0, SEEK_END) != 0;
}

Result<> OutputFile::finish() {
  COLLINEA_CHECK(file_);
  failed_ |= std::fflush(file_.get()) != 0;
  std::string reason = failed_ ? last_reason() : "";
  failed_ |= std::fclose(file_.release()) != 0;
  std::error_code error;
  if (!failed_) std::filesystem::rename(temporary_, path_, error);
  if (!failed_ && !error) return {};
  if (error) reason = error.message();
  std::filesystem::remove(temporary_, error);
  return fail(Errc::kBadInput, path_.string() + ": cannot be written: " + reason);
}

Result<> write_file(const std::filesystem::path& path, std::string_view bytes) {
  COLLINEA_TRY(OutputFile file, OutputFile::create(path));
  file.write(bytes);
  return file.finish();
}

}  // namespace collinea
