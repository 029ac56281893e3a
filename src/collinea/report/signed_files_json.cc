// SPDX-License-Identifier: Apache-2.0
// hashes.json, and what verify says.
#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>

#include "collinea/report/internal/counted.h"
#include "collinea/report/signed_files.h"

namespace collinea {
namespace {

using json = nlohmann::ordered_json;

constexpr const char* kFormat = "collinea hashes 1";

json file_json(const SignedFile& file) {
  json one = {{"role", word_of(file.role)}, {"name", file.name}};
  if (!file.folder.empty()) one["folder"] = file.folder.string();
  one["bytes"] = file.bytes;
  one["sha256"] = file.sha256.empty() ? json(nullptr) : json(file.sha256);
  return one;
}

// Throws what signed_files_of() turns into words.
SignedFile file_of(const json& one) {
  SignedFile file;
  const auto role = from_word<FileRole>(one.at("role").get<std::string>());
  if (!role) throw std::invalid_argument("no role is called \"" + one.at("role").get<std::string>() + "\"");
  file.role = *role;
  file.name = one.at("name").get<std::string>();
  if (one.contains("folder")) file.folder = one.at("folder").get<std::string>();
  file.bytes = one.at("bytes").get<std::uint64_t>();
  if (one.at("sha256").is_null()) return file;
  file.sha256 = one.at("sha256").get<std::string>();
  const bool is_hash =
      file.sha256.size() == 64 && file.sha256.find_first_not_of("0123456789abcdef") == std::string::npos;
  if (!is_hash) throw std::invalid_argument("the hash of " + file.name + " is none");
  return file;
}

std::string text(const json& value) { return value.dump(1, ' ', false, json::error_handler_t::replace) + "\n"; }

json digest(const SignedFiles& all, SignedPart part) {
  const std::string hash = digest_of(all, part);
  return hash.empty() ? json(nullptr) : json(hash);
}

std::string digest_line(const char* name, const SignedFiles& all, SignedPart part) {
  const std::string hash = digest_of(all, part);
  return hash.empty() ? "" : fmt::format("{:<9} SHA-256 {}\n", name, hash);
}

}  // namespace

std::string signed_files_json(const SignedFiles& all) {
  json files = json::array();
  for (const SignedFile& file : all.files) files.push_back(file_json(file));
  return text({{"format", kFormat},
               {"collinea", all.version},
               {"seed", all.seed},
               {"inputs_sha256", digest(all, SignedPart::kInputs)},
               {"products_sha256", digest(all, SignedPart::kProducts)},
               {"files", files}});
}

Result<SignedFiles> signed_files_of(std::string_view bytes) {
  try {
    const json j = json::parse(bytes);
    if (const auto format = j.at("format").get<std::string>(); format != kFormat)
      return fail(Errc::kUnsupported, "its format is \"" + format + "\", not \"" + kFormat + "\"");
    SignedFiles all{j.at("collinea").get<std::string>(), j.at("seed").get<std::uint64_t>(), {}};
    for (const json& one : j.at("files")) all.files.push_back(file_of(one));
    return all;
  } catch (const std::exception& error) {
    return fail(Errc::kBadFormat, error.what());
  }
}

std::string verified_text(const Verified& verified) {
  std::string lines;
  std::map<FileState, std::size_t> count;
  for (const auto& [file, state] : verified.files) {
    ++count[state];
    lines += fmt::format("{:<9} {}\n", word_of(state), file.name);
  }
  lines += digest_line("inputs", verified.record, SignedPart::kInputs) +
           digest_line("products", verified.record, SignedPart::kProducts);
  std::string states;
  for (const auto& [state, files] : count)
    states += fmt::format("{}{} {}", states.empty() ? "" : ", ", files, word_of(state));
  return lines + fmt::format(
                     "{}: {}. The report was made by collinea {} with seed {}; its signature block must show "
                     "the same two hashes.\n",
                     counted(verified.files.size(), "file"), states.empty() ? "nothing to compare" : states,
                     verified.record.version, verified.record.seed);
}

std::string verified_json(const Verified& verified) {
  json files = json::array();
  for (const auto& [file, state] : verified.files) {
    files.push_back(file_json(file));
    files.back()["state"] = word_of(state);
  }
  return text({{"agrees", verified.agrees()},
               {"collinea", verified.record.version},
               {"seed", verified.record.seed},
               {"inputs_sha256", digest(verified.record, SignedPart::kInputs)},
               {"products_sha256", digest(verified.record, SignedPart::kProducts)},
               {"files", files}});
}

}  // namespace collinea
