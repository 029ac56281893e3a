// SPDX-License-Identifier: Apache-2.0
#include "collinea/base/sha256.h"

#include <fmt/format.h>
#include <openssl/evp.h>

#include <array>
#include <cstdio>
#include <system_error>
#include <vector>

namespace collinea {

struct Sha256::State {
  struct Free {
    void operator()(EVP_MD_CTX* context) const { EVP_MD_CTX_free(context); }
  };
  std::unique_ptr<EVP_MD_CTX, Free> context{EVP_MD_CTX_new()};
};

Sha256::Sha256() : state_(std::make_unique<State>()) {
  COLLINEA_CHECK(state_->context && EVP_DigestInit_ex(state_->context.get(), EVP_sha256(), nullptr) == 1);
}
Sha256::Sha256(Sha256&&) noexcept = default;
Sha256& Sha256::operator=(Sha256&&) noexcept = default;
Sha256::~Sha256() = default;

Sha256& Sha256::add(std::string_view bytes) {
  COLLINEA_CHECK(EVP_DigestUpdate(state_->context.get(), bytes.data(), bytes.size()) == 1);
  return *this;
}

std::string Sha256::hex() {
  std::array<unsigned char, EVP_MAX_MD_SIZE> digest{};
  unsigned int size = 0;
  COLLINEA_CHECK(EVP_DigestFinal_ex(state_->context.get(), digest.data(), &size) == 1 && size == 32);
  std::string text;
  for (unsigned int i = 0; i < size; ++i) text += fmt::format("{:02x}", digest[i]);
  return text;
}

Result<std::string> sha256_of_file(const std::filesystem::path& path, const Run& run) {
  std::error_code missing;
  if (!std::filesystem::is_regular_file(path, missing)) return fail(Errc::kNotFound, "no file " + path.string());
  struct Close {
    void operator()(std::FILE* file) const { std::fclose(file); }
  };
  const std::unique_ptr<std::FILE, Close> file(std::fopen(path.c_str(), "rb"));
  if (!file) return fail(Errc::kNotFound, "cannot open " + path.string());
  std::setvbuf(file.get(), nullptr, _IONBF, 0);  // the pieces are large
  Sha256 hash;
  std::vector<char> piece(std::size_t{1} << 20);
  while (const std::size_t bytes = std::fread(piece.data(), 1, piece.size(), file.get())) {
    if (run.stopped()) return fail(Errc::kCancelled, "stopped");
    hash.add({piece.data(), bytes});
  }
  if (std::ferror(file.get())) return fail(Errc::kNotFound, path.string() + " cannot be read");
  return hash.hex();
}

}  // namespace collinea
