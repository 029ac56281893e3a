// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "collinea/base/result.h"
#include "collinea/base/run.h"
#include "collinea/base/words.h"

namespace collinea {

// What was signed is what is delivered: the SHA-256 of every file that a project was made of and that it made, kept in
// report/hashes.json and compared by `verify`. The signature block of the report has the digests over inputs and
// products, so that also a hashes.json that was exchanged shows: its digests are then not those on paper.

/// Where the record lies, below the folder of the project.
inline constexpr const char* kHashesFile = "report/hashes.json";

/// What a file is to a project.
enum class FileRole : std::uint8_t {
  kImage,    ///< a photograph of the block
  kGiven,    ///< another file that an option names: control, positions, a geoid
  kProduct,  ///< made for the user
  kReport,   ///< says how good it is: report and adjustment
};
inline constexpr Word<FileRole> kFileRoleWords[] = {{FileRole::kImage, "image"},
                                                    {FileRole::kGiven, "given"},
                                                    {FileRole::kProduct, "product"},
                                                    {FileRole::kReport, "report"}};
[[nodiscard]] constexpr std::span<const Word<FileRole>> words(FileRole) { return kFileRoleWords; }

struct SignedFile {
  FileRole role{};
  std::string name;              ///< below `folder`, of images and products with subfolders
  std::filesystem::path folder;  ///< absolute; empty: that of the project
  std::uint64_t bytes = 0;
  std::string sha256 = {};  ///< 64 digits; empty: the file could not be read

  [[nodiscard]] bool is_input() const { return role == FileRole::kImage || role == FileRole::kGiven; }
};

/// The record of all of them, and with what they were made.
struct SignedFiles {
  std::string version;  ///< of the program
  std::uint64_t seed = 0;
  std::vector<SignedFile> files;
};

/// Fills size and hash of each file, `run.threads` at a time and in pieces; those that cannot be read keep none.
/// Relative folders are below `project`. Errors: kCancelled.
Result<> hash_files(const std::filesystem::path& project, std::vector<SignedFile>& files, const Run& run);

enum class SignedPart : std::uint8_t { kInputs, kProducts };

/// The SHA-256 of the lines "HASH  NAME\n" of inputs or products by name, as `sha256sum` prints them; files without a
/// hash have no line. Empty: there is no such file.
[[nodiscard]] std::string digest_of(const SignedFiles& all, SignedPart part);

enum class FileState : std::uint8_t { kSame, kChanged, kMissing, kUnknown };  ///< unknown: it never had a hash
inline constexpr Word<FileState> kFileStateWords[] = {{FileState::kSame, "same"},
                                                      {FileState::kChanged, "changed"},
                                                      {FileState::kMissing, "missing"},
                                                      {FileState::kUnknown, "unknown"}};
[[nodiscard]] constexpr std::span<const Word<FileState>> words(FileState) { return kFileStateWords; }

/// A file, and what has become of it.
struct VerifiedFile {
  SignedFile file;
  FileState state{};
};
struct Verified {
  SignedFiles record;               ///< as the report left it
  std::vector<VerifiedFile> files;  ///< those that were looked at

  [[nodiscard]] bool agrees() const;
};

/// Hashes the files again and compares. Errors: kCancelled.
[[nodiscard]] Result<Verified> compared(SignedFiles record, const std::filesystem::path& project,
                                        std::vector<SignedFile> files, const Run& run);

/// hashes.json and back. Errors: not JSON, members that are missing or of a wrong kind, hashes that are none.
[[nodiscard]] std::string signed_files_json(const SignedFiles& all);
[[nodiscard]] Result<SignedFiles> signed_files_of(std::string_view json);

/// For people: a line a file that is not the same (or every file), then how many are, and the digests.
[[nodiscard]] std::string verified_text(const Verified& verified);
[[nodiscard]] std::string verified_json(const Verified& verified);

}  // namespace collinea
