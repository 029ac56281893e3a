// SPDX-License-Identifier: Apache-2.0
#include "collinea/report/volume_report.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

namespace collinea {

std::string volume_text(const Volume& volume, bool sigmas_assumed) {
  std::string text = fmt::format(
      "above     {:.3f} m3\nbelow     {:.3f} m3\nnet       {:.3f} m3, standard deviation {:.3f} m3\n"
      "area      {:.2f} m2{}\n",
      volume.above_m3, volume.below_m3, volume.net_m3(), volume.sigma_m3(), volume.area_m2,
      volume.missing_m2 > 0 ? fmt::format(", and {:.2f} m2 without heights", volume.missing_m2) : "");
  text += fmt::format("of which  {:.3f} m3 by heights{}, {:.3f} m3 by a common shift, {:.3f} m3 by the plane\n",
                      volume.sigma_heights_m3, sigmas_assumed ? " (assumed)" : "", volume.sigma_shift_m3,
                      volume.sigma_base_m3);
  if (volume.plane)
    text += fmt::format(
        "plane     {:.3f} m in the middle, rising {:.4f} to the east and {:.4f} to the north; the border "
        "differs by {:.3f} m\n",
        volume.plane->x(), volume.plane->y(), volume.plane->z(), volume.rim_rms_m);
  return text;
}

std::string volume_json(const Volume& volume) {
  nlohmann::ordered_json j = {{"above_m3", volume.above_m3},
                              {"below_m3", volume.below_m3},
                              {"net_m3", volume.net_m3()},
                              {"sigma_m3", volume.sigma_m3()},
                              {"sigma_heights_m3", volume.sigma_heights_m3},
                              {"sigma_shift_m3", volume.sigma_shift_m3},
                              {"sigma_base_m3", volume.sigma_base_m3},
                              {"area_m2", volume.area_m2},
                              {"missing_m2", volume.missing_m2}};
  if (volume.plane)
    j["plane"] = {{"middle", {volume.middle.x(), volume.middle.y()}},
                  {"height_m", volume.plane->x()},
                  {"slope_east", volume.plane->y()},
                  {"slope_north", volume.plane->z()},
                  {"rim_rms_m", volume.rim_rms_m}};
  return j.dump(2) + "\n";
}

}  // namespace collinea
