// SPDX-License-Identifier: Apache-2.0
#include "collinea/edit/internal/ring_words.h"

#include <algorithm>
#include <cmath>

#include "collinea/edit/internal/words_in.h"
#include "collinea/io/text.h"

namespace collinea {

Result<std::vector<Eigen::Vector2d>> ring_in(std::span<const std::string> words, std::string_view form,
                                             std::string_view x, std::string_view y) {
  if (words.size() < 6 || words.size() % 2 != 0) return wrong_form(form);
  if (words.size() / 2 > kMostRingPoints)
    return fail(Errc::kBadInput,
                "the outline has more than " + std::to_string(kMostRingPoints) + " points: draw several");
  std::vector<Eigen::Vector2d> ring(words.size() / 2);
  for (std::size_t i = 0; i < ring.size(); ++i) {
    COLLINEA_TRY(ring[i].x(), number_in(words[2 * i], x));
    COLLINEA_TRY(ring[i].y(), number_in(words[2 * i + 1], y));
  }
  return ring;
}

void append_words(const std::vector<Eigen::Vector2d>& ring, std::vector<std::string>& words) {
  for (const Eigen::Vector2d& point : ring) {
    words.push_back(exact(point.x()));
    words.push_back(exact(point.y()));
  }
}

Result<> check_ring(const std::vector<Eigen::Vector2d>& ring) {
  // An area of less than a billionth of the square around it is rounding.
  constexpr double kThinnest = 1e-9;
  double largest = 0, twice_area = 0;
  for (std::size_t i = 0; i < ring.size(); ++i) {
    const Eigen::Vector2d a = ring[i] - ring[0], b = ring[(i + 1) % ring.size()] - ring[0];
    largest = std::max(largest, a.squaredNorm());
    twice_area += std::abs(a.x() * b.y() - a.y() * b.x());
  }
  if (!(twice_area > kThinnest * largest)) return fail(Errc::kBadInput, "the outline encloses nothing");
  return {};
}

}  // namespace collinea
