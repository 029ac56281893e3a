// SPDX-License-Identifier: Apache-2.0
#include "collinea/report/signed_files.h"

#include <algorithm>
#include <atomic>
#include <numeric>
#include <utility>

#include "collinea/base/file.h"
#include "collinea/base/parallel.h"
#include "collinea/base/sha256.h"

namespace collinea {
namespace {

namespace fs = std::filesystem;

fs::path path_of(const fs::path& project, const SignedFile& file) {
  return (file.folder.empty() ? project : file.folder) / file.name;
}

}  // namespace

Result<> hash_files(const fs::path& project, std::vector<SignedFile>& files, const Run& run) {
  std::uint64_t total = 0;
  for (SignedFile& file : files) {
    std::error_code missing;
    const auto bytes = fs::file_size(path_of(project, file), missing);
    file.bytes = missing ? 0 : bytes;
    total += file.bytes;
  }
  std::vector<std::size_t> largest_first(files.size());  // no thread shall end with the largest alone
  std::iota(largest_first.begin(), largest_first.end(), std::size_t{0});
  std::stable_sort(largest_first.begin(), largest_first.end(),
                   [&](std::size_t a, std::size_t b) { return files[a].bytes > files[b].bytes; });
  std::atomic<std::uint64_t> done = 0;
  parallel_for(run, files.size(), [&](std::size_t i) {
    SignedFile& file = files[largest_first[i]];
    file.sha256 = sha256_of_file(path_of(project, file), run).value_or("");
    run.report("hashes", double(done += file.bytes) / double(std::max<std::uint64_t>(total, 1)));
  });
  if (run.stopped()) return fail(Errc::kCancelled, "stopped");
  return {};
}

std::string digest_of(const SignedFiles& all, SignedPart part) {
  std::vector<std::pair<std::string, std::string>> lines;
  for (const SignedFile& file : all.files)
    if (!file.sha256.empty() && (part == SignedPart::kInputs ? file.is_input() : file.role == FileRole::kProduct))
      lines.emplace_back(file.name, file.sha256);
  if (lines.empty()) return "";
  std::sort(lines.begin(), lines.end());
  Sha256 hash;
  for (const auto& [name, sha256] : lines) hash.add(sha256).add("  ").add(name).add("\n");
  return hash.hex();
}

bool Verified::agrees() const {
  return !files.empty() &&
         std::all_of(files.begin(), files.end(), [](const VerifiedFile& one) { return one.state == FileState::kSame; });
}

Result<Verified> compared(SignedFiles record, const fs::path& project, std::vector<SignedFile> files, const Run& run) {
  std::vector<SignedFile> now = files;
  COLLINEA_TRY(hash_files(project, now, run));
  Verified verified{std::move(record), {}};
  for (std::size_t i = 0; i < files.size(); ++i) {
    const bool there = is_there(path_of(project, now[i]));
    const FileState state = !there                             ? FileState::kMissing
                            : files[i].sha256.empty()          ? FileState::kUnknown
                            : files[i].sha256 == now[i].sha256 ? FileState::kSame
                                                               : FileState::kChanged;
    verified.files.push_back({std::move(files[i]), state});
  }
  return verified;
}

}  // namespace collinea
