// SPDX-License-Identifier: Apache-2.0
#include "collinea/base/record_spool.h"

#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <cstring>
#include <system_error>

namespace collinea {

Result<RecordSpool> RecordSpool::create(const std::filesystem::path& file) {
  static std::atomic<unsigned> count = 0;
  RecordSpool spool;
  spool.name_ = file.string();
  const std::string name = spool.name_ + ".part" + std::to_string(::getpid()) + "." + std::to_string(count++);
  spool.file_.reset(std::fopen(name.c_str(), "w+b"));
  if (!spool.file_) return fail(Errc::kBadInput, spool.name_ + ": cannot be written: " + std::strerror(errno));
  std::error_code ignored;
  std::filesystem::remove(name, ignored);
  std::setvbuf(spool.file_.get(), nullptr, _IOFBF, 1 << 16);
  return spool;
}

void RecordSpool::append(std::string_view bytes) {
  if (std::fwrite(bytes.data(), 1, bytes.size(), file_.get()) != bytes.size() && failure_ == 0) failure_ = errno;
  size_ += bytes.size();
}

Result<std::string> RecordSpool::read(std::uint64_t at, std::uint64_t bytes) const {
  const auto failed = [&](const std::string& what) {
    return fail(Errc::kBadInput, name_ + ": what lies beside it for a while cannot be " + what);
  };
  if (failure_ != 0 || std::fflush(file_.get()) != 0)
    return failed(std::string("written: ") + std::strerror(failure_ != 0 ? failure_ : errno));
  if (at > size_ || bytes > size_ - at) return failed("read: there is less of it");
  std::string read(bytes, '\0');
  for (std::uint64_t done = 0; done < bytes;) {
    const ::ssize_t piece = ::pread(::fileno(file_.get()), read.data() + done, bytes - done, ::off_t(at + done));
    if (piece == 0) return failed("read: there is less of it");
    if (piece < 0 && errno != EINTR) return failed(std::string("read: ") + std::strerror(errno));
    if (piece > 0) done += std::uint64_t(piece);
  }
  return read;
}

}  // namespace collinea
