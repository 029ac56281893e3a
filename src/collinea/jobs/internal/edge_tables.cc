// SPDX-License-Identifier: Apache-2.0
#include "collinea/jobs/internal/edge_tables.h"

#include <fmt/format.h>

#include <cmath>
#include <numbers>

#include "collinea/feature/edge_curve.h"

namespace collinea {
namespace {

constexpr double kDegrees = 180 / std::numbers::pi;
constexpr int kHarmonics = 8;

std::string number(double value, int decimals) { return fmt::format("{:.{}f}", value, decimals); }

double correlation(const Eigen::MatrixXd& covariance) {
  const double product = std::sqrt(covariance(0, 0) * covariance(1, 1));
  return product > 0 ? covariance(0, 1) / product : 0;
}

std::string yes_or_no(bool value) { return value ? "yes" : "no"; }

// x, y, their standard deviations and correlation.
void add_position(std::vector<std::string>& row, const Eigen::Vector2d& at, const Eigen::MatrixXd& covariance) {
  for (int k = 0; k < 2; ++k) row.push_back(number(at[k], 4));
  for (int k = 0; k < 2; ++k) row.push_back(number(std::sqrt(covariance(k, k)), 4));
  row.push_back(number(correlation(covariance), 3));
}

std::vector<TableColumn> position_columns(const char* name) {
  return {{name, ""}, {"x", "px"}, {"y", "px"}, {"sigma_x", "px"}, {"sigma_y", "px"}, {"correlation", ""}};
}

void add(std::vector<TableColumn>& to, std::initializer_list<TableColumn> more) { to.insert(to.end(), more); }

}  // namespace

Curve curve_of(const EdgeMap& map, const EdgeChain& chain) {
  Curve out;
  for (const EdgePoint& p : map.points_of(chain)) out.push_back(p.at);
  return out;
}

TextTable table_of(const std::vector<FoundLine>& lines) {
  TextTable table;
  table.columns = {{"line", ""},        {"theta", "deg"}, {"r", "px"},      {"sigma_theta", "deg"}, {"sigma_r", "px"},
                   {"correlation", ""}, {"x_from", "px"}, {"y_from", "px"}, {"x_to", "px"},         {"y_to", "px"},
                   {"points", ""},      {"sigma0", ""},   {"rms", "px"}};
  for (const FoundLine& found : lines) {
    const EdgeLine& l = found.line;
    table.rows.push_back({std::to_string(table.rows.size() + 1), number(l.theta_rad * kDegrees, 4), number(l.r_px, 3),
                          number(std::sqrt(l.covariance(0, 0)) * kDegrees, 4), number(std::sqrt(l.covariance(1, 1)), 4),
                          number(correlation(l.covariance), 3), number(l.from.x(), 2), number(l.from.y(), 2),
                          number(l.to.x(), 2), number(l.to.y(), 2), std::to_string(found.points.size()),
                          number(l.quality.sigma0, 2), number(l.quality.rms_px, 3)});
  }
  return table;
}

TextTable table_of(const std::vector<LineCorner>& corners) {
  TextTable table;
  table.columns = position_columns("corner");
  add(table.columns, {{"angle", "deg"}, {"gap", "px"}, {"first_line", ""}, {"second_line", ""}});
  for (const LineCorner& c : corners) {
    std::vector<std::string> row = {std::to_string(table.rows.size() + 1)};
    add_position(row, c.at, c.covariance);
    for (std::string word : {number(c.angle_rad * kDegrees, 3), number(c.gap_px, 2), std::to_string(c.first + 1),
                             std::to_string(c.second + 1)})
      row.push_back(std::move(word));
    table.rows.push_back(std::move(row));
  }
  return table;
}

TextTable table_of(const std::vector<FoundCircle>& circles) {
  TextTable table;
  table.columns = position_columns("circle");
  add(table.columns, {{"radius", "px"},
                      {"sigma_radius", "px"},
                      {"bright", ""},
                      {"arc", "deg"},
                      {"points", ""},
                      {"sigma0", ""},
                      {"rms", "px"}});
  for (const FoundCircle& found : circles) {
    const EdgeCircle& c = found.circle;
    std::vector<std::string> row{std::to_string(table.rows.size() + 1)};
    add_position(row, c.centre, c.covariance);
    for (const std::string& word :
         {number(c.radius_px, 4), number(std::sqrt(c.covariance(2, 2)), 4), yes_or_no(c.is_bright),
          number(c.arc_rad * kDegrees, 0), std::to_string(found.points.size()), number(c.quality.sigma0, 2),
          number(c.quality.rms_px, 3)})
      row.push_back(word);
    table.rows.push_back(std::move(row));
  }
  return table;
}

TextTable table_of(const std::vector<EdgeEllipse>& ellipses) {
  TextTable table;
  table.columns = position_columns("ellipse");
  add(table.columns, {{"major", "px"},
                      {"minor", "px"},
                      {"angle", "deg"},
                      {"sigma_major", "px"},
                      {"sigma_minor", "px"},
                      {"sigma_angle", "deg"},
                      {"bright", ""},
                      {"arc", "deg"},
                      {"sigma0", ""},
                      {"rms", "px"}});
  for (const EdgeEllipse& e : ellipses) {
    std::vector<std::string> row{std::to_string(table.rows.size() + 1)};
    add_position(row, e.ellipse.centre, e.covariance);
    for (const std::string& word :
         {number(e.ellipse.major_px, 4), number(e.ellipse.minor_px, 4), number(e.ellipse.angle_rad * kDegrees, 3),
          number(std::sqrt(e.covariance(2, 2)), 4), number(std::sqrt(e.covariance(3, 3)), 4),
          number(std::sqrt(e.covariance(4, 4)) * kDegrees, 3), yes_or_no(e.is_bright), number(e.arc_rad * kDegrees, 0),
          number(e.quality.sigma0, 2), number(e.quality.rms_px, 3)})
      row.push_back(word);
    table.rows.push_back(std::move(row));
  }
  return table;
}

TextTable table_of(const std::vector<Target>& targets, const std::vector<std::string>& names) {
  TextTable table;
  table.columns = position_columns("point");
  add(table.columns, {{"sigma", "px"},
                      {"kind", ""},
                      {"contrast", "grey"},
                      {"blur", "px"},
                      {"sigma_grey", "grey"},
                      {"correlated", ""}});
  for (std::size_t i = 0; i < targets.size(); ++i) {
    const Target& t = targets[i];
    std::vector<std::string> row{i < names.size() ? names[i] : std::to_string(i + 1)};
    add_position(row, t.at, t.covariance);
    for (const std::string& word :
         {number(t.sigma_px(), 4), std::string(word_of(t.kind)), number(t.contrast(), 1), number(t.unknowns[2], 2),
          number(t.sigma_grey, 2), yes_or_no(t.has_correlated_residuals)})
      row.push_back(word);
    table.rows.push_back(std::move(row));
  }
  return table;
}

TextTable table_of(const std::vector<FoundShape>& shapes, const ShapeSearch& search) {
  TextTable table;
  table.columns = position_columns("shape");
  add(table.columns, {{"rotation", "deg"},
                      {"sigma_rotation", "deg"},
                      {"scale", ""},
                      {"sigma_scale", ""},
                      {"share", ""},
                      {"sigma0", ""},
                      {"rms", "px"}});
  const bool is_turned = search.rotations_rad.size() > 1, is_scaled = search.scales.size() > 1;
  for (const FoundShape& s : shapes) {
    std::vector<std::string> row{std::to_string(table.rows.size() + 1)};
    add_position(row, s.at, s.covariance);
    const auto sigma = [&](int k) { return std::sqrt(s.covariance(k, k)); };
    for (const std::string& word :
         {number(s.rotation_rad * kDegrees, 3), is_turned ? number(sigma(2) * kDegrees, 3) : std::string("-"),
          number(s.scale, 5), is_scaled ? number(sigma(is_turned ? 3 : 2), 5) : std::string("-"), number(s.share, 2),
          number(s.quality.sigma0, 2), number(s.quality.rms_px, 3)})
      row.push_back(word);
    table.rows.push_back(std::move(row));
  }
  return table;
}

TextTable chain_table(const EdgeMap& map, double polygon_px) {
  TextTable table;
  table.columns = {{"chain", ""},   {"points", ""},        {"closed", ""}, {"length", "px"}, {"vertices", ""},
                   {"sigma", "px"}, {"amplitude", "grey"}, {"x", "px"},    {"y", "px"}};
  for (const EdgeChain& chain : map.chains) {
    const Curve curve = curve_of(map, chain);
    double sigma = 0, amplitude = 0;
    for (const EdgePoint& p : map.points_of(chain)) {
      sigma += p.sigma_px / double(chain.count);
      amplitude += p.amplitude / double(chain.count);
    }
    table.rows.push_back({std::to_string(table.rows.size() + 1), std::to_string(chain.count),
                          yes_or_no(chain.is_closed), number(length_of(curve, chain.is_closed), 1),
                          std::to_string(polygon_of(curve, chain.is_closed, polygon_px).size()), number(sigma, 3),
                          number(amplitude, 1), number(curve[0].x(), 1), number(curve[0].y(), 1)});
  }
  return table;
}

TextTable edge_point_table(const EdgeMap& map, double curvature_px) {
  TextTable table;
  table.columns = {{"chain", ""},          {"x", "px"}, {"y", "px"},    {"sigma", "px"},      {"normal", "deg"},
                   {"amplitude", "grey"},  {"s", "px"}, {"psi", "deg"}, {"sigma_psi", "deg"}, {"curvature", ""},
                   {"sigma_curvature", ""}};
  for (std::size_t c = 0; c < map.chains.size(); ++c) {
    const auto points = map.points_of(map.chains[c]);
    const auto shape = psi_s(points, map.chains[c].is_closed, map.along_px, curvature_px);
    for (std::size_t i = 0; i < points.size(); ++i) {
      const EdgePoint& p = points[i];
      const bool has_shape = i < shape.size();
      table.rows.push_back({std::to_string(c + 1), number(p.at.x(), 3), number(p.at.y(), 3), number(p.sigma_px, 3),
                            number(std::atan2(p.normal.y(), p.normal.x()) * kDegrees, 1), number(p.amplitude, 1),
                            has_shape ? number(shape[i].s_px, 2) : "-",
                            has_shape ? number(shape[i].psi_rad * kDegrees, 2) : "-",
                            has_shape ? number(shape[i].sigma_psi_rad * kDegrees, 2) : "-",
                            has_shape ? number(shape[i].curvature_per_px, 5) : "-",
                            has_shape ? number(shape[i].sigma_curvature, 5) : "-"});
    }
  }
  return table;
}

TextTable code_table(const EdgeMap& map) {
  TextTable table;
  table.columns = {{"chain", ""}, {"column", ""}, {"row", ""}, {"code", ""}};
  for (const EdgeChain& chain : map.chains) {
    const ChainCode code = chain_code(curve_of(map, chain), chain.is_closed);
    std::string steps;
    for (const std::uint8_t step : code.steps) steps += char('0' + step);
    table.rows.push_back(
        {std::to_string(table.rows.size() + 1), std::to_string(code.x), std::to_string(code.y), steps});
  }
  return table;
}

TextTable descriptor_table(const EdgeMap& map) {
  TextTable table;
  table.columns = {{"chain", ""}, {"radius", "px"}, {"sigma_radius", "px"}};
  for (const char* sigma : {"", "sigma_"})
    for (int n = -kHarmonics; n <= kHarmonics; ++n)
      if (n != 0 && n != 1) table.columns.push_back({fmt::format("{}{}{}", sigma, n < 0 ? "m" : "p", std::abs(n)), ""});
  for (std::size_t c = 0; c < map.chains.size(); ++c) {
    if (!map.chains[c].is_closed) continue;
    const EdgeDescriptors d = edge_descriptors(map.points_of(map.chains[c]), map.along_px, kHarmonics);
    if (d.invariants.empty()) continue;
    std::vector<std::string> row{std::to_string(c + 1), number(d.radius_px, 3), number(d.sigma_radius_px, 3)};
    for (const double value : d.invariants) row.push_back(number(value, 5));
    for (const double sigma : d.sigmas) row.push_back(number(sigma, 5));
    table.rows.push_back(std::move(row));
  }
  return table;
}

}  // namespace collinea
