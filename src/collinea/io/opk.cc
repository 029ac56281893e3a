// SPDX-License-Identifier: Apache-2.0
#include "collinea/io/opk.h"

#include <Eigen/SVD>

#include "collinea/geodesy/local_frame.h"
#include "collinea/io/file.h"
#include "collinea/io/text.h"

namespace collinea {
namespace {

// The rotation part of the conversion at a place: the nearest one to its numeric derivative.
Eigen::Quaterniond map_from_local_rotation(const LocalFrame& frame, const Eigen::Vector3d& local) {
  constexpr double kStep_m = 10;
  Eigen::Matrix3d derivative;
  for (int axis = 0; axis < 3; ++axis) {
    const Eigen::Vector3d step = kStep_m * Eigen::Vector3d::Unit(axis);
    derivative.col(axis) = (frame.map_from_local(local + step) - frame.map_from_local(local - step)) / (2 * kStep_m);
  }
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(derivative, Eigen::ComputeFullU | Eigen::ComputeFullV);
  return Eigen::Quaterniond(Eigen::Matrix3d(svd.matrixU() * svd.matrixV().transpose())).normalized();
}

}  // namespace

Result<std::vector<ExteriorOrientation>> exterior_orientations(const Block& block) {
  std::optional<LocalFrame> frame;
  if (const auto& g = block.georeference) {
    COLLINEA_TRY(frame,
                 LocalFrame::create(g->crs, g->origin_latitude_deg, g->origin_longitude_deg, g->origin_height_m));
  }
  std::vector<ExteriorOrientation> rows;
  for (const auto& [id, cam_from_world] : block.cam_from_world) {
    const Eigen::Vector3d centre = centre_of(cam_from_world);
    ExteriorOrientation row{block.images.at(id).file, centre, {}};
    Eigen::Quaterniond cam_from_map = cam_from_world.rotation;
    if (frame) {
      row.centre_in_map = frame->map_from_local(centre);
      cam_from_map = cam_from_map * map_from_local_rotation(*frame, centre).conjugate();
    }
    row.angles = omega_phi_kappa(cam_from_map);
    rows.push_back(std::move(row));
  }
  return rows;
}

Result<> write_opk(const std::filesystem::path& path, const Block& block) {
  COLLINEA_TRY(const auto rows, exterior_orientations(block));
  std::string text = block.georeference ? "# Exterior orientations in " + block.georeference->crs +
                                              "; angles to the axes of its grid at each projection centre\n"
                                        : "# Exterior orientations in a local frame without place on Earth, z up\n";
  text +=
      "# ground = Rx(omega) Ry(phi) Rz(kappa) image, image frame x right, y up, z backward\n"
      "# image\tx_m\ty_m\tz_m\tomega_deg\tphi_deg\tkappa_deg\n";
  for (const ExteriorOrientation& row : rows) {
    text += row.file;
    for (int i = 0; i < 3; ++i) text += "\t" + fixed(row.centre_in_map[i], 4);
    for (const double angle : {row.angles.omega_deg, row.angles.phi_deg, row.angles.kappa_deg})
      text += "\t" + fixed(angle, 7);
    text += "\n";
  }
  return write_file(path, text);
}

}  // namespace collinea
