// SPDX-License-Identifier: Apache-2.0
// The danger circle and the danger cylinder of resections, as a picture: beside a solution and without one.
#include <gtest/gtest.h>

#include <cmath>

#include "collinea/base/file.h"
#include "collinea/base/test_folder.h"
#include "collinea/geometry/rotation_angles.h"
#include "collinea/io/text.h"
#include "collinea/jobs/resection.h"

namespace collinea {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

class Danger : public ::testing::Test {
 protected:
  Danger() {
    options_.photo.principal_distance = 150;
    options_.out = folder_ / "out";
  }
  [[nodiscard]] std::filesystem::path file(const std::string& name, const std::string& text) const {
    EXPECT_TRUE(write_file(folder_ / name, text));
    return folder_ / name;
  }
  [[nodiscard]] std::string drawing() const {
    const auto text = read_file(folder_ / "out" / "danger.svg");
    return text ? *text : "";
  }
  [[nodiscard]] Result<ResectionReport> of_image(const std::vector<Vector3d>& points, const Vector3d& centre) const {
    const Eigen::Matrix3d r = rotation_matrix(CardanAngles{0.02, -0.03, 0.6});
    std::string measurements = "image point x[mm] y[mm] sigma[mm]\n", ground = "point X Y Z\n";
    for (std::size_t i = 0; i < points.size(); ++i) {
      const Vector3d seen = r * (points[i] - centre);
      const Vector2d xy = -150 * seen.head<2>() / seen.z();
      const std::string name = "p" + std::to_string(i);
      measurements += "A " + name + " " + exact(xy.x()) + " " + exact(xy.y()) + " 0.005\n";
      ground += name + " " + exact(points[i].x()) + " " + exact(points[i].y()) + " " + exact(points[i].z()) + "\n";
    }
    return resect_from_tables(file("m.txt", measurements), file("g.txt", ground), options_);
  }
  [[nodiscard]] Result<ResectionReport> of_station(const Vector2d& station) const {
    std::string measurements = "point direction[gon] sigma[gon]\n", ground = "point X[m] Y[m]\n";
    int i = 0;
    for (const double angle : {0.5, 1.4, 2.6}) {
      const Vector2d to(500 * std::cos(angle), 500 * std::sin(angle)), d = to - station;
      measurements += "p" + std::to_string(i) + " " + exact(std::atan2(d.x(), d.y()) * 200 / M_PI) + " 0.0001\n";
      ground += "p" + std::to_string(i++) + " " + exact(to.x()) + " " + exact(to.y()) + "\n";
    }
    ResectOneOptions options = options_;
    options.method = ResectionMethod::kStation;
    return resect_from_tables(file("m.txt", measurements), file("g.txt", ground), options);
  }
  static std::vector<Vector3d> on_circle(std::initializer_list<double> angles) {
    std::vector<Vector3d> points;
    for (const double angle : angles) points.emplace_back(300 * std::cos(angle), 300 * std::sin(angle), 0);
    return points;
  }

  ResectOneOptions options_;
  TestFolder folder_;
};

TEST_F(Danger, TheCylinderIsDrawnBesideASolution) {
  const auto report = of_image(on_circle({0.2, 1.3, 2.4, 3.9, 5.1}), {290, 20, 900});
  ASSERT_TRUE(report) << report.error().message;
  const ResectionReport::Image& image = report->images[0];
  ASSERT_TRUE(image.danger);
  EXPECT_LT(image.danger->middle_in_world.norm(), 1e-6);
  EXPECT_NEAR(std::abs(image.danger->axis_in_world.z()), 1, 1e-9);
  EXPECT_LT((image.station - Vector3d(290, 20, 900)).norm(), 0.01);  // of exact measurements, near the cylinder
  const std::string svg = drawing();
  for (const char* words : {"<svg ", "A: danger cylinder, seen along its axis", "seen across its axis", "p4",
                            "projection centre 9.31 m inside the cylinder", "radius 300"})
    EXPECT_NE(svg.find(words), std::string::npos) << words << "\n" << svg;
  EXPECT_EQ(svg.find("nan"), std::string::npos);
}

// Exactly on the cylinder over three points the pose is open: the error says so and leaves the picture.
TEST_F(Danger, OnTheCylinderThereIsThePictureAlone) {
  const auto report = of_image(on_circle({0.2, 1.7, 3.9}), {300 * std::cos(0.9), 300 * std::sin(0.9), 900});
  ASSERT_FALSE(report);
  EXPECT_EQ(report.error().code, Errc::kIllPosed);
  EXPECT_NE(report.error().message.find("lies on a circle of radius 300 m"), std::string::npos)
      << report.error().message;
  EXPECT_NE(drawing().find("danger cylinder"), std::string::npos);
  EXPECT_FALSE(std::filesystem::exists(folder_ / "out" / "orientation.txt"));
}

TEST_F(Danger, AStationOnTheCircleIsDrawnAsTheArcThatIsOpen) {
  const auto near = of_station({520 * std::cos(5.0), 520 * std::sin(5.0)});
  ASSERT_TRUE(near) << near.error().message;
  EXPECT_NE(drawing().find("station 20 m outside the circle"), std::string::npos) << drawing();
  const auto on = of_station({500 * std::cos(5.0), 500 * std::sin(5.0)});
  ASSERT_FALSE(on);
  EXPECT_NE(on.error().message.find("lies on a circle of radius 500 m"), std::string::npos) << on.error().message;
  EXPECT_NE(drawing().find("the station is open"), std::string::npos) << drawing();
  // Without a folder the error alone.
  options_.out.reset();
  EXPECT_FALSE(of_station({500 * std::cos(5.0), 500 * std::sin(5.0)}));
}

TEST_F(Danger, DirectionsThatFailOtherwiseHaveNoCircle) {
  const auto report = resect_from_tables(file("m.txt", "point direction[gon]\na 0\nb 10\n"),
                                         file("g.txt", "point X[m] Y[m]\na 0 0\nb 10 10\n"), [&] {
                                           ResectOneOptions options = options_;
                                           options.method = ResectionMethod::kStation;
                                           return options;
                                         }());
  ASSERT_FALSE(report);
  EXPECT_EQ(report.error().message.find("circle of radius"), std::string::npos);
  EXPECT_EQ(drawing(), "");
}

}  // namespace
}  // namespace collinea
