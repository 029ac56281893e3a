// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <string>

#include "collinea/block/subject_label.h"
#include "collinea/import/import.h"
#include "collinea/raster/image_file.h"

namespace collinea {

inline ImageHeader drone_header() {
  ImageHeader header;
  header.maker = "Maker";
  header.model = "Model";
  header.focal_mm = 8.8;
  header.focal_35mm_mm = 24;
  return header;
}

inline ImageHeader header_at(double latitude_deg, double longitude_deg) {
  ImageHeader header = drone_header();
  header.latitude_deg = latitude_deg;
  header.longitude_deg = longitude_deg;
  header.height_m = 400;
  return header;
}

// No two images have the same bytes.
inline void put_image(const std::filesystem::path& path, const ImageHeader* header, int width_px = 120,
                      int height_px = 90) {
  static std::uint8_t shade = 0;
  Raster<std::uint8_t> image(width_px, height_px, 1);
  std::fill(image.data.begin(), image.data.end(), ++shade);
  std::filesystem::create_directories(path.parent_path());
  ASSERT_TRUE(write_jpeg(path, image, 90, header));
}

// What the findings of that code say, one a line.
inline std::string labels_of(const Imported& imported, FindingCode code) {
  std::string text;
  for (const Finding& one : imported.findings)
    if (one.code == code) text += label_of(one, imported.block) + "\n";
  return text;
}

// Three points of a control file, without their images.
inline const std::string kControl = R"(# collinea control, EPSG:32633
point, A, 546800, 5338600, 310, 0.01, 0.01, 0.02, control
point, B, 546850, 5338600, 311, 0.01, 0.01, 0.02, control
point, C, 546800, 5338650, 312, 0.01, 0.01, 0.02, check
)";

}  // namespace collinea
