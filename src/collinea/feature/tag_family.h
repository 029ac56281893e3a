// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>

#include "collinea/base/words.h"

namespace collinea {

/// Families of coded tags: a square of dark cells, one cell wide, about the n x n cells of a code, on light ground.
/// AprilTag 36h11 (Olson 2011); the dictionaries that ArUco of OpenCV prints (Garrido-Jurado et al. 2014), of which the
/// first 50 and 100 codes are dictionaries of their own with larger distances; the original ArUco, whose rows are words
/// of two bits each.
enum class TagFamily : std::uint8_t {
  kApriltag36h11,
  kAruco4x4x50,
  kAruco4x4x100,
  kAruco4x4x250,
  kAruco5x5x50,
  kAruco5x5x100,
  kAruco5x5x250,
  kAruco6x6x50,
  kAruco6x6x100,
  kAruco6x6x250,
  kArucoOriginal
};
inline constexpr Word<TagFamily> kTagFamilyWords[] = {
    {TagFamily::kApriltag36h11, "apriltag-36h11"}, {TagFamily::kAruco4x4x50, "aruco-4x4-50"},
    {TagFamily::kAruco4x4x100, "aruco-4x4-100"},   {TagFamily::kAruco4x4x250, "aruco-4x4-250"},
    {TagFamily::kAruco5x5x50, "aruco-5x5-50"},     {TagFamily::kAruco5x5x100, "aruco-5x5-100"},
    {TagFamily::kAruco5x5x250, "aruco-5x5-250"},   {TagFamily::kAruco6x6x50, "aruco-6x6-50"},
    {TagFamily::kAruco6x6x100, "aruco-6x6-100"},   {TagFamily::kAruco6x6x250, "aruco-6x6-250"},
    {TagFamily::kArucoOriginal, "aruco-original"}};
[[nodiscard]] constexpr std::span<const Word<TagFamily>> words(TagFamily) { return kTagFamilyWords; }

/// The families that contain all others.
inline constexpr TagFamily kWidestTagFamilies[] = {TagFamily::kApriltag36h11, TagFamily::kAruco4x4x250,
                                                   TagFamily::kAruco5x5x250, TagFamily::kAruco6x6x250,
                                                   TagFamily::kArucoOriginal};

/// n x n cells, row by row from the upper left, the last one being the lowest bit; 1 is light.
using TagBits = std::uint64_t;

struct TagCodes {
  int side = 0;  ///< n
  std::span<const TagBits> bits;
  /// Least number of cells in which two codes differ, in any of the four positions, or a code from itself turned; of
  /// the original ArUco 0, where a few of its 1024 codes are others turned.
  int distance = 0;
  /// Wrong cells that do not lead to another code.
  [[nodiscard]] int correctable() const { return distance > 0 ? (distance - 1) / 2 : 0; }
  /// The chance that random cells are read as one of the codes where so many wrong cells are corrected.
  [[nodiscard]] double chance_of_random(int corrected) const;
};
[[nodiscard]] const TagCodes& tag_codes(TagFamily family);

/// The bits as they read when the tag is turned by a quarter, clockwise.
[[nodiscard]] TagBits turned_tag(TagBits bits, int side);

/// A code that was read.
struct TagReading {
  int id = 0;
  int turns = 0;  ///< quarters, clockwise, by which the tag is turned from how it is printed
  TagBits wrong = 0;  ///< cells that were corrected, as the tag is printed
};
/// Of a family the code that is nearest to bits as they were read, at most `most_wrong` cells away and no more than can
/// be corrected. Nothing: there is none, or there are two.
[[nodiscard]] std::optional<TagReading> read_tag(TagFamily family, TagBits bits, int most_wrong);

/// Whether a point of this name is meant by a tag: the name is the number of the tag, or ends in it behind what is no
/// digit ("12", "tag12", "T-012").
[[nodiscard]] bool is_name_of_tag(std::string_view name, int id);

}  // namespace collinea
