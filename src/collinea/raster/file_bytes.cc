// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <memory>

#include "collinea/raster/codec.h"

namespace collinea {
namespace {

struct FileCloser {
  void operator()(std::FILE* file) const { std::fclose(file); }
};
using File = std::unique_ptr<std::FILE, FileCloser>;

Result<File> opened(const std::filesystem::path& path) {
  std::error_code error;
  if (!std::filesystem::exists(path, error)) return fail(Errc::kNotFound, path.string() + ": no such file");
  if (std::filesystem::is_directory(path, error)) return fail(Errc::kBadFormat, path.string() + " is a folder");
  File file(std::fopen(path.c_str(), "rb"));
  if (!file) return fail(Errc::kNotFound, path.string() + " cannot be opened: " + std::strerror(errno));
  return file;
}

}  // namespace

Result<FileKind> kind_of_file(const std::filesystem::path& path) {
  COLLINEA_TRY(const File file, opened(path));
  unsigned char head[8] = {};
  const std::size_t got = std::fread(head, 1, sizeof head, file.get());
  const auto begins = [&](const char* magic, std::size_t n) { return got >= n && std::memcmp(head, magic, n) == 0; };
  if (begins("\xff\xd8\xff", 3)) return FileKind::kJpeg;
  if (begins("\x89PNG\r\n\x1a\n", 8)) return FileKind::kPng;
  // Classic and Big TIFF, either byte order.
  if (begins("II\x2a\0", 4) || begins("MM\0\x2a", 4) || begins("II\x2b\0", 4) || begins("MM\0\x2b", 4))
    return FileKind::kTiff;
  if (got == 0) return fail(Errc::kBadFormat, path.string() + " is empty");
  return fail(Errc::kBadFormat, path.string() + " is neither JPEG, PNG nor TIFF");
}

Result<std::string> read_bytes(const std::filesystem::path& path, std::size_t most) {
  COLLINEA_TRY(const File file, opened(path));
  std::error_code error;
  const auto size = std::filesystem::file_size(path, error);
  if (error) return fail(Errc::kNotFound, path.string() + ": " + error.message());
  std::string bytes(std::min<std::uintmax_t>(size, most), '\0');
  bytes.resize(std::fread(bytes.data(), 1, bytes.size(), file.get()));
  if (std::ferror(file.get()))
    return fail(Errc::kBadFormat, path.string() + " cannot be read: " + std::strerror(errno));
  return bytes;
}

Result<> write_bytes(const std::filesystem::path& path, const std::string& bytes) {
  std::filesystem::path part = path;
  part += ".part";
  std::FILE* file = std::fopen(part.c_str(), "wb");
  if (!file) return fail(Errc::kBadInput, path.string() + " cannot be written: " + std::strerror(errno));
  const bool written = std::fwrite(bytes.data(), 1, bytes.size(), file) == bytes.size();
  const bool closed = std::fclose(file) == 0;
  std::error_code error;
  if (written && closed) std::filesystem::rename(part, path, error);
  if (written && closed && !error) return {};
  std::error_code ignored;
  std::filesystem::remove(part, ignored);
  return fail(Errc::kBadInput,
              path.string() + " cannot be written: " + (error ? error.message() : std::string("is the disk full?")));
}

Result<> check_size(std::uint64_t width, std::uint64_t height, std::uint64_t file_bytes, std::uint64_t px_per_byte) {
  constexpr std::uint64_t kMost_px = 2'000'000'000, kHarmless_px = 16'000'000;
  if (width == 0 || height == 0) return fail(Errc::kBadFormat, "the image has no pixels");
  const std::string size = std::to_string(width) + " x " + std::to_string(height) + " pixels";
  if (width > kMost_px || height > kMost_px || width * height > kMost_px)
    return fail(Errc::kUnsupported, size + " are more than can be read");
  if (width * height > kHarmless_px && width * height / px_per_byte > file_bytes)
    return fail(Errc::kBadFormat, "damaged: " + size + " cannot be in " + std::to_string(file_bytes) + " bytes");
  return {};
}

}  // namespace collinea
