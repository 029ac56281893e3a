// SPDX-License-Identifier: Apache-2.0
#include "collinea/io/record_spool.h"

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
  failed_ |= std::fwrite(bytes.data(), 1, bytes.size(), file_.get()) != bytes.size();
  size_ += bytes.size();
}

Result<std::string> RecordSpool::read(std::uint64_t at, std::uint64_t bytes) const {
  std::string read(bytes, '\0');
  bool fine = !failed_ && std::fflush(file_.get()) == 0;
  for (std::uint64_t done = 0; fine && done < bytes;) {
    const ::ssize_t piece = ::pread(::fileno(file_.get()), read.data() + done, bytes - done, ::off_t(at + done));
    fine = piece > 0 || (piece < 0 && errno == EINTR);
    if (piece > 0) done += std::uint64_t(piece);
  }
  if (!fine) return fail(Errc::kBadInput, name_ + ": no room on the disk for what lies beside it for a while");
  return read;
}

}  // namespace collinea
