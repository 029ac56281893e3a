// SPDX-License-Identifier: Apache-2.0
#include "collinea/camera/film_gallery.h"

#include <string>

namespace collinea {
namespace {

constexpr double kNominalSigma_mm = 0.02;

// Half the distance between opposite marks; zero: the camera has none there.
struct NominalMarks {
  double corner_mm = 0, side_mm = 0;
};

NominalMarks nominal_marks(FilmCameraType type) {
  switch (type) {
    case FilmCameraType::kRc8:
      return {106, 0};
    case FilmCameraType::kRc10:
      return {106, 110};
    case FilmCameraType::kRc30:
      return {106, 112};
    case FilmCameraType::kRmkA:
      return {0, 113};
  }
  return {};
}

}  // namespace

FilmCalibration nominal_calibration(FilmCameraType type) {
  const auto [corner, side] = nominal_marks(type);
  FilmCalibration c;
  c.camera = std::string(word_of(type)) + ", nominal";
  const MarkKind kind = type == FilmCameraType::kRmkA ? MarkKind::kDot : MarkKind::kCross;
  const auto add = [&](int number, double x, double y) {
    c.marks.push_back({.name = std::to_string(number), .film_mm = {x, y}, .sigma_mm = kNominalSigma_mm, .kind = kind});
  };
  if (corner > 0) {
    add(1, -corner, -corner);
    add(2, corner, corner);
    add(3, -corner, corner);
    add(4, corner, -corner);
  }
  if (side > 0) {
    add(5, -side, 0);
    add(6, side, 0);
    add(7, 0, side);
    add(8, 0, -side);
  }
  return c;
}

}  // namespace collinea
