// SPDX-License-Identifier: Apache-2.0
#include "collinea/cloud/las.h"
#include "collinea/cloud/ply.h"
#include "target.h"

namespace collinea::fuzz {
namespace {

std::vector<CloudPoint> small_cloud() {
  std::vector<CloudPoint> points(40);
  for (std::size_t i = 0; i < points.size(); ++i) {
    points[i].position = {500000 + 0.37 * double(i), 5300000 + 0.11 * double(i * i), 100 + 0.01 * double(i)};
    points[i].colour = {std::uint8_t(i), std::uint8_t(3 * i), 7};
    points[i].sigma_m = 0.01f * float(i);
    points[i].images = std::uint8_t(2 + i % 5);
    points[i].classification = 2;
  }
  return points;
}

std::string las(LasForm form, bool extra_bytes = true) {
  LasWriter::Options options;
  options.lowest = {500000, 5300000, 0};
  options.highest = {501000, 5301000, 200};
  options.wkt = "PROJCS[\"any\"]";
  options.extra_bytes = extra_bytes;
  options.form = form;
  const std::filesystem::path path = folder() / las_file_name("seed", form);
  {
    auto writer = LasWriter::create(path, options);
    if (!writer || !writer->write(small_cloud()) || !writer->finish()) return "";
  }
  return bytes_of(path);
}

std::string binary_ply() {
  {
    auto writer = PlyWriter::create(folder() / "seed.ply", "EPSG:32633");
    if (!writer) return "";
    writer->write(small_cloud());
    if (!writer->finish()) return "";
  }
  return bytes_of(folder() / "seed.ply");
}

const std::string kTextPly =
    "ply\nformat ascii 1.0\nelement vertex 2\nproperty double x\nproperty double y\nproperty float z\n"
    "property uchar red\nend_header\n1 2 3 4\n5 6 7 8\n";

bool accepts_las(std::string_view bytes, const char* name) {
  auto reader = LasReader::open(file_of(bytes, name));
  if (!reader) return false;
  for (;;) {
    const auto points = reader->read(1000);
    if (!points) return false;
    if (points->empty()) return true;
  }
}

}  // namespace

std::vector<Target> cloud_targets() {
  return {{"las",
           [](std::string_view bytes) { return accepts_las(bytes, "a.las"); },
           {las(LasForm::kLas), las(LasForm::kLas, false)}},
          {"laz",
           [](std::string_view bytes) { return accepts_las(bytes, "a.laz"); },
           {las(LasForm::kLaz), las(LasForm::kLaz, false)}},
          {"copc", [](std::string_view bytes) { return accepts_las(bytes, "a.copc.laz"); }, {las(LasForm::kCopc)}},
          {"ply", [](std::string_view bytes) { return parse_ply(bytes).has_value(); }, {binary_ply(), kTextPly}}};
}

}  // namespace collinea::fuzz
